//! Where a pinhole's picture shows lamps over specular faces. No light from a lamp falls into a point, and few rays from
//! it meet a lamp in a curved mirror; but rays that pass near one say where Newton's iteration should start.

use super::chains::{SEED, train};
use super::tuning::pinhole_pilot::{
    AT_A_TIME, CELLS, CLOSER, IN_VAIN, KEPT, LEAST, MARGIN, MOST_LAMPS, MOST_SEGMENTS, MOST_WAYS, RAYS, STARTS,
};
use crate::base::chain::Chain;
use crate::base::lattice::lattice;
use crate::base::rng::{Rng, Stream};
use crate::estimate::ShouldStop;
use crate::estimate::ledger::Ledger;
use crate::estimate::manifold::solver::newton::{Family, Target, newton};
use crate::estimate::vision::is_looked_about;
use crate::estimate::walk::{Meeting, Met, Travel, Walker};
use crate::film::specular_chain::Glint;
use crate::world::World;
use crate::world::geometry::Ray;
use crate::world::interior::Interior;
use crate::world::lamp::Lamp;
use crate::world::mode::{Mode, Mono};
use crate::world::optics::Optics;
use glam::{DMat2, DVec2};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// A ray that goes on towards a lamp.
#[derive(Clone, Copy)]
struct Miss {
    film: DVec2,
    /// Sine of the angle by which it misses the sphere about it.
    by: f64,
}

/// A chain from the eye and a lamp.
pub(crate) type Way = (Chain, usize);
type Ways = BTreeMap<Way, Vec<Miss>>;

/// What a ray and all its branches met.
#[derive(Default)]
struct Looked {
    segments: u32,
    met_specular: bool,
    /// Over a chain: lamps, and the sines of the angles.
    ahead: Vec<(Chain, Vec<(usize, f64)>)>,
}

/// The glints of all lamps, those over the shortest chains first. Once `stop` says true the rest is left out.
pub(in crate::plan) fn find(world: &World, stop: &ShouldStop<'_>) -> Vec<Glint> {
    let mut all = find_by_way(world, [0; 2], stop);
    all.sort_by_key(|((chain, _), _)| chain.0.len());
    all.into_iter().flat_map(|(_, glints)| glints).collect()
}

/// The same by rays through a lattice moved by `shift`.
pub(crate) fn find_by_way(world: &World, shift: [u64; 2], stop: &ShouldStop<'_>) -> Vec<(Way, Vec<Glint>)> {
    let optics = Mono::<f64>::optics(world, SEED, 0);
    // Rays are about so far apart where there are most, and at first.
    let area = 4.0 * world.eye.half().element_product();
    let [apart, wide] = [RAYS * CLOSER, RAYS].map(|rays| (area / rays as f64).sqrt());
    let mut ways = look((world, &optics), (shift, apart), stop);
    nearest_ways(&mut ways, MOST_WAYS);
    let all: Vec<(Way, Vec<Miss>)> = ways.into_iter().collect();
    let solved = |(way, misses): (Way, Vec<Miss>)| {
        let glints = images((world, &optics), &way, &nearest(&misses, apart), wide, stop);
        (way, glints)
    };
    all.into_par_iter().map(solved).filter(|(_, glints)| !glints.is_empty()).collect()
}

/// A few rays through a lattice moved by `shift` all over the picture, the others where those met a specular face, `apart` from
/// each other; of each way about the nearest.
fn look((world, optics): (&World, &Optics<Mono>), (shift, apart): ([u64; 2], f64), stop: &ShouldStop<'_>) -> Ways {
    let [width, height] = world.eye.size().map(|n| n as f64);
    let film_of = |[x, y]: [f64; 2]| world.eye.film_of(0, 0, [x * width, y * height]);
    let trace = |k: u64| {
        let (mut looked, mut ledger) = (Looked::default(), Ledger::new(world.solids.len()));
        let (origin, (_, dir), ..) = world.eye.ray_of(film_of(lattice(shift, k)), DVec2::ZERO);
        let ray = Ray { origin, dir, from: None };
        let rng = Rng::new(SEED, Stream::Pilot, 3, k);
        let walker = Walker::new((world, optics), Travel::FromEye, ray, 1.0, Interior::default(), rng).recording();
        follow(walker, &mut looked, &mut ledger);
        looked
    };
    let cell_of = |k: u64| lattice(shift, k).map(|x| (x * CELLS as f64) as usize);
    let mut ways = Ways::new();
    // Those of the rays that met a specular face.
    let mut add = |rays: &[u64]| {
        let mut met = Vec::new();
        for rays in rays.chunks(AT_A_TIME) {
            if stop() {
                break;
            }
            let looked: Vec<Looked> = rays.par_iter().map(|k| trace(*k)).collect();
            for (k, looked) in rays.iter().zip(looked) {
                if looked.met_specular {
                    met.push(*k);
                }
                let film = film_of(lattice(shift, *k));
                for (chain, lamps) in looked.ahead {
                    for (lamp, by) in lamps {
                        let misses = ways.entry((chain.clone(), lamp)).or_default();
                        misses.push(Miss { film, by });
                        if misses.len() >= 4 * KEPT {
                            *misses = nearest(misses, apart);
                        }
                    }
                }
                if ways.len() > 8 * MOST_WAYS {
                    nearest_ways(&mut ways, 4 * MOST_WAYS);
                }
            }
        }
        met
    };
    let mut beside = vec![false; CELLS * CELLS];
    for [x, y] in add(&(0..RAYS).collect::<Vec<_>>()).into_iter().map(cell_of) {
        for row in y.saturating_sub(1)..(y + 2).min(CELLS) {
            beside[row * CELLS..][x.saturating_sub(1)..(x + 2).min(CELLS)].fill(true);
        }
    }
    let is_beside = |k: &u64| {
        let [x, y] = cell_of(*k);
        beside[y * CELLS + x]
    };
    add(&(RAYS..RAYS * CLOSER).filter(is_beside).collect::<Vec<_>>());
    ways
}

fn follow(mut walker: Walker<'_, Mono>, looked: &mut Looked, ledger: &mut Ledger) {
    loop {
        looked.segments += 1;
        if looked.segments > MOST_SEGMENTS {
            return;
        }
        if let Some(chain) = walker.chain().filter(|chain| !chain.0.is_empty()) {
            looked.met_specular = true;
            let missed_by = |lamp: &Lamp| {
                let (centre, radius) = lamp.around();
                let towards = centre - walker.ray.origin;
                let by = (towards.cross(walker.ray.dir).length() - radius).max(0.0) / towards.length();
                // However far beside: where one curved mirror shows another, few rays meet both, and their directions lie
                // as far apart as can be. What leads nowhere is tried last.
                (towards.dot(walker.ray.dir) > 0.0 && by <= 1.0).then_some(by)
            };
            let lamps = walker.world.lamps.all().iter().enumerate();
            let mut lamps: Vec<(usize, f64)> = lamps.filter_map(|(k, lamp)| Some((k, missed_by(lamp)?))).collect();
            if lamps.len() > MOST_LAMPS {
                lamps.sort_by(|a, b| a.1.total_cmp(&b.1));
                lamps.truncate(MOST_LAMPS);
            }
            if !lamps.is_empty() {
                looked.ahead.push((chain.clone(), lamps));
            }
        }
        let Met::Face(vertex) = walker.advance(ledger) else { return };
        let share = walker.share();
        if share > LEAST
            && let Some(reflected) = walker.split(&vertex, LEAST / share, u8::MAX, ledger)
        {
            follow(reflected, looked, ledger);
        }
        match walker.meet(&vertex, ledger) {
            Meeting::Went => {}
            Meeting::Ended | Meeting::Scatter(..) => return,
        }
    }
}

/// The nearest misses that are some rays apart, the nearest one first.
fn nearest(misses: &[Miss], apart: f64) -> Vec<Miss> {
    let mut sorted = misses.to_vec();
    sorted.sort_by(|a, b| a.by.total_cmp(&b.by));
    let mut kept: Vec<Miss> = Vec::new();
    for miss in sorted {
        if kept.len() >= KEPT {
            break;
        }
        if kept.iter().all(|other| other.film.distance(miss.film) > 3.0 * apart) {
            kept.push(miss);
        }
    }
    kept
}

/// Leaves `most` ways, those with the nearest miss.
fn nearest_ways(ways: &mut Ways, most: usize) {
    if ways.len() <= most {
        return;
    }
    let by = |misses: &Vec<Miss>| misses.iter().fold(f64::INFINITY, |least, miss| least.min(miss.by));
    let mut all: Vec<(Way, Vec<Miss>)> = std::mem::take(ways).into_iter().collect();
    all.sort_by_cached_key(|(_, misses)| by(misses).to_bits());
    all.truncate(most);
    ways.extend(all);
}

/// Where the lamp is seen over a chain: images that starts near it lead to. `wide`: how far apart those are after a few in vain.
fn images(
    (world, optics): (&World, &Optics<Mono>),
    way: &Way,
    starts: &[Miss],
    wide: f64,
    stop: &ShouldStop<'_>,
) -> Vec<Glint> {
    let (mut found, mut in_vain): (Vec<Glint>, Vec<DVec2>) = (Vec::new(), Vec::new());
    for Miss { film, .. } in starts {
        if found.len() + in_vain.len() == STARTS || stop() {
            break;
        }
        let is_known = |known: &Glint| known.holds(film.to_array()) && is_looked_about(&world.eye, known);
        let is_left_out = in_vain.len() >= IN_VAIN && in_vain.iter().any(|other| other.distance(*film) <= 3.0 * wide);
        if is_left_out || found.iter().any(is_known) {
            continue;
        }
        match solve((world, optics), way, *film) {
            Some(glint) if !found.iter().any(|known| known.holds(glint.middle)) => found.push(glint),
            Some(_) | None => in_vain.push(*film),
        }
    }
    found
}

/// The image that Newton's iteration comes to from a start.
fn solve((world, optics): (&World, &Optics<Mono>), (chain, lamp): &Way, start: DVec2) -> Option<Glint> {
    let train = train((world, optics), &chain.reversed(), start, DVec2::ZERO)?;
    let lamp = world.lamps.all().get(*lamp)?;
    let (centre, radius) = lamp.around();
    let on_lamp = lamp.sample_point([0.5; 2]);
    let target = Target::new(on_lamp.position, on_lamp.normal);
    let index = |part: Option<u32>| optics.index_in(part)[0];
    let family = Family::Film { pupil: DVec2::ZERO };
    let root = newton(world, &index, &family, start, &train, &target, radius)?;
    let by_place: DMat2 = root.slope.inverse();
    let reach = MARGIN * (radius + centre.distance(on_lamp.position));
    let axes = [by_place.x_axis, by_place.y_axis].map(|axis| (axis * reach).to_array());
    let glint = Glint { middle: root.u.to_array(), axes };
    let seen = world.eye.half() + DVec2::from_array(glint.half());
    (seen.is_finite() && glint.area() > 0.0 && root.u.abs().cmple(seen).all()).then_some(glint)
}
