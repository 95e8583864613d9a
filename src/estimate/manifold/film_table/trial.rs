//! What the tables are good for, cell by cell: solutions beside their nodes tell how far they are off.

use super::make::{ASIDE, BEYOND, Maker, Nodes};
use super::masks::{self, MASKS, Mask};
use super::tuning::trial::{LEAST, MASK_PIXELS, POOR, PUPIL_RIM, QUARTERS, RIM_ERRORS, RIM_PIXELS, SHARP};
use super::{FilmTables, Node, Use, blend, through_slides};
use crate::manifold::receiver::Crossing;
use crate::manifold::seeds::connections::Entry;
use crate::manifold::solver::bicubic::{SIDES, Spot};
use eyebox_world::mode::Mode;
use glam::{DVec2, DVec3};

impl<M: Mode> Maker<'_, M> {
    /// How a cell is to be used. Where no branch has a node at its corners the table says nothing, and little is expected.
    /// `solved`: the nodes with a solution, none of those that were added beyond them.
    pub(super) fn use_of(
        &self,
        tables: &FilmTables<M>,
        entry: &Entry,
        (branches, masks, solved): (&[Nodes<M>], &[Mask], &[bool]),
        cell: usize,
    ) -> Use {
        let corners = tables.over.nodes.corners(cell);
        let lit = |nodes: &&Nodes<M>| corners.iter().any(|node| nodes[*node].is_some());
        let lit: Vec<&Nodes<M>> = branches.iter().filter(lit).collect();
        let at = tables.over.nodes.at_node(cell) + 0.5;
        let known = SIDES.into_iter().find_map(|aside| {
            let spot = tables.over.nodes.spot_by(at, aside)?;
            let whole = lit.iter().all(|nodes| spot.nodes().all(|(node, _)| nodes[node].is_some()));
            whole.then_some((aside, spot))
        });
        let (mask_reach, unsure) = self.mask_reach(tables, entry.starts.size(), (&lit, masks), &corners);
        let edges = (masks, unsure);
        let off =
            known.and_then(|(aside, spot)| Some((aside, self.error(tables.over.film(at), entry, &lit, &spot, edges)?)));
        // Where light ends near a cell it may end within it, beside its middle.
        let off = off.filter(|(aside, _)| {
            let inner = known.is_some_and(|(_, spot)| *aside == [0; 2] && spot.nodes().all(|(node, _)| solved[node]));
            inner
                || QUARTERS.into_iter().all(|[x, y]| {
                    let spot = tables.over.nodes.spot_by(at + DVec2::new(x, y), *aside);
                    let tried = |spot| self.error(tables.over.film(at + DVec2::new(x, y)), entry, &lit, &spot, edges);
                    spot.and_then(tried).is_some()
                })
        });
        off.map_or(Use::SOLVED, |(aside, off)| Use {
            share: (off / POOR).clamp(LEAST, 1.0),
            aside,
            rim: (RIM_PIXELS * self.by_pixel(tables, &lit, &corners)).max(RIM_ERRORS * off / SHARP),
            pupil_rim: (RIM_ERRORS * off).max(PUPIL_RIM),
            mask_reach,
        })
    }

    /// How far about the places of a cell the outlines of masks are looked for, m: 0 where all of them are far. And so near to an
    /// outline nodes and solver need not agree.
    fn mask_reach(
        &self,
        tables: &FilmTables<M>,
        size: f64,
        (branches, masks): (&[&Nodes<M>], &[Mask]),
        corners: &[usize],
    ) -> ([f64; MASKS], f64) {
        let (mut reach, mut unsure) = ([0.0; MASKS], 0.0f64);
        for (k, mask) in masks.iter().enumerate() {
            for nodes in branches {
                let crossing = |node: &usize| nodes[*node].as_ref()?.masks.get(k);
                let known: Vec<&Crossing> = corners.iter().filter_map(crossing).collect();
                let places = || known.iter().map(|crossing| crossing.local);
                let apart = places().flat_map(|a| places().map(move |b| a.distance(b))).fold(0.0, f64::max);
                let blur = |crossing: &&Crossing| size * crossing.by_lamp.iter().map(|by| by.length()).sum::<f64>();
                let blur = known.iter().map(blur).fold(0.0, f64::max);
                // No place of the cell is farther from a corner than half of its diagonal.
                let inside = |place: DVec3, reach: f64| masks::inside(self.world, &[*mask], &[place], reach);
                let hidden = places().any(|place| inside(place, 0.0).is_some_and(|inside| inside < 0.0));
                let near = places().any(|place| inside(place, 0.75 * apart + blur).is_some());
                if apart > 0.0 && (hidden || near) {
                    let cells = if hidden { 2.0 + BEYOND as f64 } else { 1.5 };
                    reach[k] = f64::max(reach[k], cells * apart + blur);
                    unsure = unsure.max(MASK_PIXELS * apart / tables.over.pixels);
                }
            }
        }
        (reach, unsure)
    }

    /// How far places on slides are from one pixel to the next, as a share of the slide's size: the most of a cell.
    fn by_pixel(&self, tables: &FilmTables<M>, branches: &[&Nodes<M>], corners: &[usize]) -> f64 {
        let of_branch = |nodes: &&Nodes<M>| {
            let known: Vec<&Node<M>> = corners.iter().filter_map(|node| nodes[*node].as_ref()).collect();
            let pairs = known.iter().enumerate().flat_map(|(k, a)| known[..k].iter().map(move |b| (*a, *b)));
            let apart = |(a, b): (&Node<M>, &Node<M>)| {
                let both = a.slides.iter().zip(&b.slides).filter(|(a, b)| a.slide == b.slide);
                both.map(|(a, b)| a.local.distance(b.local) / self.world.slides[a.slide].size()).fold(0.0, f64::max)
            };
            pairs.map(apart).fold(0.0, f64::max)
        };
        branches.iter().map(of_branch).fold(0.0, f64::max) / tables.over.pixels
    }

    /// By how much what these branches say of a place in the picture is off, by solutions for two points of the lamp; none
    /// where one of both is missing.
    fn error(
        &self,
        film: DVec2,
        entry: &Entry,
        branches: &[&Nodes<M>],
        spot: &Spot,
        (masks, unsure): (&[Mask], f64),
    ) -> Option<f64> {
        let size = entry.starts.size();
        let mut worst = 0f64;
        for nodes in branches {
            for off in [DVec2::new(ASIDE, 0.5 * ASIDE) * size, DVec2::new(-0.5 * ASIDE, -ASIDE) * size] {
                let blend = blend(nodes, spot, off)?;
                let inside = masks::inside(self.world, masks, &blend.masks, 0.0);
                // So near to an outline either may be right.
                if inside.is_some_and(|inside| inside.abs() <= unsure) {
                    continue;
                }
                let hidden = inside.is_some_and(|inside| inside < 0.0);
                let Some(found) = self.found(entry, film, blend.pupil, off) else {
                    // Beside a slide's picture, and beyond an outline, both know of nothing.
                    if hidden || !through_slides(self.world, self.optics, &blend.slides) {
                        continue;
                    }
                    return None;
                };
                if hidden {
                    return None;
                }
                let of_lane = |lane: usize| (blend.strength[lane] / found.strength[lane] - 1.0).abs();
                let strength = (0..M::LANES).map(of_lane).fold(0.0, f64::max);
                let apart = |((slide, a), (_, b)): (&(usize, DVec3), &(usize, DVec3))| {
                    SHARP * a.distance(*b) / self.world.slides[*slide].size()
                };
                let places = blend.slides.iter().zip(&found.slides).map(apart).fold(0.0, f64::max);
                let pupil = blend.pupil.distance(found.root.u) / self.world.eye.pupil_radius_m();
                let error = strength.max(places).max(pupil);
                worst = worst.max(if error.is_nan() { 1.0 } else { error });
            }
        }
        Some(worst)
    }
}
