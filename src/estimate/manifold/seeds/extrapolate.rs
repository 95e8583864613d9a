//! Lamps that a pilot found no path from: what a neighbour does over a train they do too, moved. A lamp at the rim of the
//! picture is seen by a corner of it alone, through a part of the pupil, where few paths go.

use super::tuning::extrapolate::{INSIDE, NEIGHBOURS, OUTSIDE, TRIES};
use super::{Builder, Node, Seeds};
use eyebox_world::eye::EyeLens;
use glam::DVec2;

/// Where the solver may start for another lamp.
struct Start {
    film: DVec2,
    pupil: DVec2,
    /// How far it was foretold, in cells of the picture, and how far it is from the middle of the pupil, of what may be.
    far: f64,
}

impl<I: Fn(Option<u32>) -> f64> Builder<'_, I> {
    /// Starts lamps without sheets from their nearest neighbours that have some, and those from them, until nothing is new.
    pub(super) fn spread(&self, all: &mut [Seeds]) {
        let mut tried: Vec<Vec<usize>> = vec![Vec::new(); all.len()];
        loop {
            let mut found = false;
            for to in 0..all.len() {
                if !all[to].sheets.is_empty() {
                    continue;
                }
                for from in neighbours(all, to) {
                    if tried[to].contains(&from) {
                        continue;
                    }
                    tried[to].push(from);
                    if self.spread_from(all, from, to) {
                        found = true;
                        break;
                    }
                }
            }
            if !found {
                return;
            }
        }
    }

    /// Returns whether the lamp `to` has sheets now.
    fn spread_from(&self, all: &mut [Seeds], from: usize, to: usize) -> bool {
        let source = &all[from];
        let offset = source.middle.local(all[to].middle.point - source.middle.point);
        let nodes = source.sheets.iter().flat_map(|sheet| sheet.nodes.iter().enumerate());
        let mut starts: Vec<Start> = nodes
            .filter_map(|(cell, node)| node.as_ref()?.moved(&self.world.eye, source, cell, offset))
            .filter(|start| start.far.is_finite())
            .collect();
        starts.sort_by(|a, b| a.far.total_cmp(&b.far));
        // From the likeliest on; those next to each other are much alike.
        for start in starts.iter().step_by(starts.len().div_ceil(TRIES).max(1)) {
            self.grow(&mut all[to], start.film, start.pupil);
            if !all[to].sheets.is_empty() {
                return true;
            }
        }
        false
    }
}

impl Node {
    /// Where in the picture another lamp is likely to be seen, so far from this one on its plane. None where it is not.
    fn moved(&self, eye: &EyeLens, source: &Seeds, cell: usize, offset: DVec2) -> Option<Start> {
        let (radius, middle) = (eye.pupil_radius_m(), source.grid.middle(cell));
        let pupil = self.pupil + self.by_lamp * offset;
        let wanted = pupil.clamp_length_max(INSIDE * radius);
        let place = middle + self.by_film.inverse() * (wanted - pupil);
        // A lamp that is imaged in the pupil, or nearly so, stays there wherever one looks.
        let near = (place - middle).abs().cmple(2.0 * eye.half()).all();
        let film = if near { place.clamp(-eye.half(), eye.half()) } else { middle };
        let pupil = pupil + self.by_film * (film - middle);
        let cells = ((film - middle) / (2.0 * source.grid.half_cell())).length();
        let far = cells + pupil.length() / self.reach;
        (pupil.length() <= (OUTSIDE * radius).max(self.reach)).then_some(Start { film, pupil, far })
    }
}

/// The lamps next to one that have sheets, the nearest first.
fn neighbours(all: &[Seeds], of: usize) -> Vec<usize> {
    let place = all[of].middle.point;
    let mut near: Vec<(f64, usize)> = (0..all.len())
        .filter(|other| !all[*other].sheets.is_empty())
        .map(|other| (all[other].middle.point.distance(place), other))
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    near.into_iter().take(NEIGHBOURS).map(|(_, other)| other).collect()
}
