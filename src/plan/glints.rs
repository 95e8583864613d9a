//! Where a pinhole's picture shows lamps over specular faces. No light from a lamp falls into a point, and few rays from
//! it meet a lamp in a curved mirror; but rays that pass near one say where Newton's iteration should start.

use super::chains::{SEED, train};
use crate::base::chain::Chain;
use crate::base::lattice::lattice;
use crate::base::rng::{Rng, Stream};
use crate::estimate::ShouldStop;
use crate::estimate::ledger::Ledger;
use crate::estimate::manifold::solve::{Family, Target, newton};
use crate::estimate::walk::{Meeting, Met, Travel, Walker};
use crate::film::train::Glint;
use crate::world::World;
use crate::world::geometry::Ray;
use crate::world::interior::Interior;
use crate::world::mode::{Mode, Mono};
use crate::world::optics::Optics;
use glam::{DMat2, DVec2};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Rays, spread evenly over the picture.
const RAYS: u64 = 1 << 12;
/// A ray is followed both ways where each carries this share of what it started with.
const LEAST: f64 = 1e-3;
/// Segments that one ray and all its branches may have.
const MOST_SEGMENTS: u32 = 256;
/// Sine of the angle by which a ray may miss a lamp's middle to be worth a start.
const NEAR: f64 = 0.5;
/// Starts of a chain and lamp, and of all.
const STARTS: usize = 6;
const MOST_STARTS: usize = 1 << 12;
/// How much wider than the image of a disc about the lamp, as its derivatives have it, a glint is taken to be.
const MARGIN: f64 = 1.5;

/// A ray that came near a lamp.
#[derive(Clone)]
struct Miss {
    film: DVec2,
    /// Sine of the angle.
    by: f64,
}

/// A chain from the eye and a lamp.
type Way = (Chain, usize);

/// The glints of all lamps. Once `stop` says true the rest is left out.
pub(super) fn find(world: &World, stop: &ShouldStop<'_>) -> Vec<Glint> {
    let optics = Mono::<f64>::optics(world, SEED, 0);
    let [width, height] = world.eye.size().map(|n| n as f64);
    let missed = |k: u64| {
        let mut misses = Vec::new();
        if !stop() {
            let mut rng = Rng::new(SEED, Stream::Pilot, 3, k);
            let [x, y] = lattice([0; 2], k);
            let film = world.eye.film_of(0, 0, [x * width, y * height]);
            let (origin, (_, dir), ..) = world.eye.ray_of(film, DVec2::ZERO);
            let ray = Ray { origin, dir, from: None };
            let walker =
                Walker::new((world, &optics), Travel::FromEye, ray, 1.0, Interior::default(), rng.fork()).recording();
            follow(walker, film, &mut 0, &mut Ledger::new(world.solids.len()), &mut misses);
        }
        misses
    };
    let mut ways: BTreeMap<Way, Vec<Miss>> = BTreeMap::new();
    for (way, miss) in (0..RAYS).into_par_iter().flat_map_iter(missed).collect::<Vec<_>>() {
        ways.entry(way).or_default().push(miss);
    }
    // Rays are about so far apart.
    let cell = (4.0 * world.eye.half().element_product() / RAYS as f64).sqrt();
    let mut starts: Vec<(&Way, Miss)> =
        ways.iter().flat_map(|(way, misses)| nearest(misses, cell).into_iter().map(move |miss| (way, miss))).collect();
    starts.sort_by(|a, b| a.1.by.total_cmp(&b.1.by));
    starts.truncate(MOST_STARTS);
    let solved: Vec<Option<Glint>> = starts
        .par_iter()
        .map(|(way, miss)| if stop() { None } else { solve((world, &optics), way, miss.film) })
        .collect();
    let mut found: BTreeMap<&Way, Vec<Glint>> = BTreeMap::new();
    for (way, glint) in starts.iter().zip(solved).filter_map(|((way, _), glint)| Some((*way, glint?))) {
        let known = found.entry(way).or_default();
        // Several starts lead to one image.
        if !known.iter().any(|other| other.holds(glint.middle)) {
            known.push(glint);
        }
    }
    found.into_values().flatten().collect()
}

fn follow(
    mut walker: Walker<'_, Mono>,
    film: DVec2,
    segments: &mut u32,
    ledger: &mut Ledger,
    misses: &mut Vec<(Way, Miss)>,
) {
    loop {
        *segments += 1;
        if *segments > MOST_SEGMENTS {
            return;
        }
        let lamps = walker.world.lamps.all();
        if let Some(chain) = walker.chain().filter(|chain| !chain.0.is_empty()) {
            for (index, lamp) in lamps.iter().enumerate() {
                let (centre, radius) = lamp.around();
                let towards = centre - walker.ray.origin;
                let by = towards.cross(walker.ray.dir).length() - radius;
                let by = by.max(0.0) / towards.length();
                if towards.dot(walker.ray.dir) > 0.0 && by < NEAR {
                    misses.push(((chain.clone(), index), Miss { film, by }));
                }
            }
        }
        let Met::Face(vertex) = walker.advance(ledger) else { return };
        let share = walker.share();
        if share > LEAST
            && let Some(reflected) = walker.split(&vertex, LEAST / share, u8::MAX, ledger)
        {
            follow(reflected, film, segments, ledger, misses);
        }
        match walker.meet(&vertex, ledger) {
            Meeting::Went => {}
            Meeting::Ended | Meeting::Scatter(..) => return,
        }
    }
}

/// The misses to start from: the nearest ones that are some cells apart.
fn nearest(misses: &[Miss], cell: f64) -> Vec<Miss> {
    let mut sorted: Vec<&Miss> = misses.iter().collect();
    sorted.sort_by(|a, b| a.by.total_cmp(&b.by));
    let mut kept: Vec<Miss> = Vec::new();
    for miss in sorted {
        if kept.len() >= STARTS {
            break;
        }
        if kept.iter().all(|other| other.film.distance(miss.film) > 3.0 * cell) {
            kept.push(miss.clone());
        }
    }
    kept
}

/// Where the lamp is seen over a chain, from a start near it.
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
