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
use crate::world::lamp::Lamp;
use crate::world::mode::{Mode, Mono};
use crate::world::optics::Optics;
use glam::{DMat2, DVec2};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Cells along each side of the picture; about one ray looks into each at first.
const CELLS: usize = 64;
const RAYS: u64 = (CELLS * CELLS) as u64;
/// Rays there are for each cell in which one met a specular face, and for those beside it: with one in each of 64 × 64 it hangs
/// on where they fall whether an image in a rim, or of one mirror in another, is found.
const CLOSER: u64 = 8;
/// A ray is followed both ways where each carries this share of what it started with.
const LEAST: f64 = 1e-3;
/// Segments that one ray and all its branches may have.
const MOST_SEGMENTS: u32 = 256;
/// Starts from a chain and lamp, and rays that are kept for them. Starts in an image that is known lead to no other.
const STARTS: usize = 6;
const KEPT: usize = 64;
/// Chains and lamps that are started from: those that a ray came nearest over.
const MOST_WAYS: usize = 1 << 11;
/// How much wider than the image of a disc about the lamp, as its derivatives have it, a glint is taken to be.
const MARGIN: f64 = 1.5;

/// A ray that came near a lamp.
#[derive(Clone, Copy)]
struct Miss {
    film: DVec2,
    /// Sine of the angle.
    by: f64,
}

/// By chain from the eye, and lamp.
type Ways = BTreeMap<Chain, BTreeMap<usize, Vec<Miss>>>;

/// A chain from the eye and a lamp.
type Way<'c> = (&'c Chain, usize);

/// What a ray and all its branches met.
#[derive(Default)]
struct Looked {
    segments: u32,
    /// Over each chain: lamps, and the sines of the angles by which it missed their middles.
    ways: Vec<(Chain, Vec<(usize, f64)>)>,
}

/// The glints of all lamps. Once `stop` says true the rest is left out.
pub(super) fn find(world: &World, stop: &ShouldStop<'_>) -> Vec<Glint> {
    let optics = Mono::<f64>::optics(world, SEED, 0);
    let ways = look((world, &optics), [0; 2], stop);
    let all = ways.iter().flat_map(|(chain, lamps)| lamps.iter().map(move |(lamp, misses)| ((chain, *lamp), misses)));
    let mut all: Vec<(Way<'_>, &Vec<Miss>)> = all.filter(|(_, misses)| !misses.is_empty()).collect();
    all.sort_by(|a, b| a.1[0].by.total_cmp(&b.1[0].by));
    all.truncate(MOST_WAYS);
    all.par_iter().flat_map_iter(|(way, misses)| images((world, &optics), way, misses, stop)).collect()
}

/// Rays through a lattice moved by `shift`: a few all over the picture, the others where those met specular faces. Of each way
/// the nearest are kept.
fn look((world, optics): (&World, &Optics<Mono>), shift: [u64; 2], stop: &ShouldStop<'_>) -> Ways {
    let [width, height] = world.eye.size().map(|n| n as f64);
    let film_of = |[x, y]: [f64; 2]| world.eye.film_of(0, 0, [x * width, y * height]);
    let look = |k: u64| {
        let (mut looked, mut ledger) = (Looked::default(), Ledger::new(world.solids.len()));
        let (origin, (_, dir), ..) = world.eye.ray_of(film_of(lattice(shift, k)), DVec2::ZERO);
        let ray = Ray { origin, dir, from: None };
        let rng = Rng::new(SEED, Stream::Pilot, 3, k);
        let walker = Walker::new((world, optics), Travel::FromEye, ray, 1.0, Interior::default(), rng).recording();
        follow(walker, &mut looked, &mut ledger);
        looked
    };
    // Rays are about so far apart, where there are most.
    let apart = (4.0 * world.eye.half().element_product() / (RAYS * CLOSER) as f64).sqrt();
    let cell_of = |k: u64| lattice(shift, k).map(|x| (x * CELLS as f64) as usize);
    let mut ways = Ways::new();
    let mut closer = vec![true; CELLS * CELLS];
    for round in 0..CLOSER {
        let rays = round * RAYS..(round + 1) * RAYS;
        let here = |k: &u64| {
            let [x, y] = cell_of(*k);
            closer[y * CELLS + x] && !stop()
        };
        let looked: Vec<(u64, Looked)> = rays.into_par_iter().filter(here).map(|k| (k, look(k))).collect();
        if round == 0 {
            closer = specular(&looked.iter().map(|(k, looked)| (cell_of(*k), looked)).collect::<Vec<_>>());
        }
        for (k, looked) in looked {
            let film = film_of(lattice(shift, k));
            for (chain, lamps) in looked.ways.into_iter().filter(|(_, lamps)| !lamps.is_empty()) {
                let way = ways.entry(chain).or_default();
                lamps.into_iter().for_each(|(lamp, by)| way.entry(lamp).or_default().push(Miss { film, by }));
            }
        }
        ways.values_mut().flat_map(BTreeMap::values_mut).for_each(|misses| *misses = nearest(misses, apart));
    }
    ways
}

/// By cell, row by row: whether a ray in it or in a cell beside it met a specular face.
fn specular(looked: &[([usize; 2], &Looked)]) -> Vec<bool> {
    let mut beside = vec![false; CELLS * CELLS];
    for ([x, y], _) in looked.iter().filter(|(_, looked)| !looked.ways.is_empty()) {
        for row in y.saturating_sub(1)..(y + 2).min(CELLS) {
            beside[row * CELLS..][x.saturating_sub(1)..(x + 2).min(CELLS)].fill(true);
        }
    }
    beside
}

fn follow(mut walker: Walker<'_, Mono>, looked: &mut Looked, ledger: &mut Ledger) {
    loop {
        looked.segments += 1;
        if looked.segments > MOST_SEGMENTS {
            return;
        }
        if let Some(chain) = walker.chain().filter(|chain| !chain.0.is_empty()) {
            let by = |lamp: &Lamp| {
                let (centre, radius) = lamp.around();
                let towards = centre - walker.ray.origin;
                let by = (towards.cross(walker.ray.dir).length() - radius).max(0.0) / towards.length();
                // Of the image of a curved mirror in another one few rays are seen, and where those go says little.
                (towards.dot(walker.ray.dir) > 0.0).then_some(by)
            };
            let lamps = walker.world.lamps.all().iter().enumerate();
            let near: Vec<(usize, f64)> = lamps.filter_map(|(index, lamp)| Some((index, by(lamp)?))).collect();
            looked.ways.push((chain.clone(), near));
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
    let mut sorted: Vec<&Miss> = misses.iter().collect();
    sorted.sort_by(|a, b| a.by.total_cmp(&b.by));
    let mut kept: Vec<Miss> = Vec::new();
    for miss in sorted {
        if kept.len() >= KEPT {
            break;
        }
        if kept.iter().all(|other| other.film.distance(miss.film) > 3.0 * apart) {
            kept.push(*miss);
        }
    }
    kept
}

/// Where the lamp is seen over a chain: images that starts near it lead to.
fn images(
    (world, optics): (&World, &Optics<Mono>),
    way: &Way<'_>,
    starts: &[Miss],
    stop: &ShouldStop<'_>,
) -> Vec<Glint> {
    let (mut found, mut tried): (Vec<Glint>, usize) = (Vec::new(), 0);
    for start in starts {
        if tried == STARTS || stop() {
            break;
        }
        if found.iter().any(|known| known.holds(start.film.to_array())) {
            continue;
        }
        tried += 1;
        if let Some(glint) = solve((world, optics), way, start.film)
            && !found.iter().any(|known| known.holds(glint.middle))
        {
            found.push(glint);
        }
    }
    found
}

/// The image that Newton's iteration comes to from a start.
fn solve((world, optics): (&World, &Optics<Mono>), (chain, lamp): &Way<'_>, start: DVec2) -> Option<Glint> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::kit;
    use crate::scene::{Finish, Scene};
    use glam::{DAffine3, DVec3};
    use std::f64::consts::TAU;

    const RADIUS_M: f64 = 0.015;

    /// A small lamp beside a pinhole that looks at convex mirrors. Each shows it once, and once in each other one.
    fn mirrors(at: &[DVec3]) -> Scene {
        let mut scene = kit::scene(40.0, 64);
        let lamp = kit::quad(DVec3::new(0.01, 0.06, 0.0), DVec3::Y * 5e-4, DVec3::X * 5e-4);
        kit::panel(&mut scene, 1e6, lamp);
        for place in at {
            let mut ball = kit::face(Finish::MirrorIdeal { reflectance: 0.9 });
            ball.shape = kit::ball(RADIUS_M);
            kit::add(&mut scene, kit::sphere(RADIUS_M, 32, 64), DAffine3::from_translation(*place), None, vec![ball]);
        }
        scene
    }

    /// Images of the lamp after one and after two reflections, by rays through a lattice moved by `shift`.
    fn counted(world: &World, shift: [u64; 2]) -> [usize; 2] {
        let optics = Mono::<f64>::optics(world, SEED, 0);
        let ways = look((world, &optics), shift, &|| false);
        let of = |reflections: usize| {
            let chains = ways.iter().filter(|(chain, _)| chain.0.len() == reflections);
            chains.map(|(chain, lamps)| images((world, &optics), &(chain, 0), &lamps[&0], &|| false).len()).sum()
        };
        [of(1), of(2)]
    }

    /// Three mirrors have three images of a lamp and six images of images, wherever they stand and wherever rays fall.
    #[test]
    fn an_image_in_each_mirror_and_in_each_mirror_of_each() {
        for place in 0..16 {
            let mut rng = Rng::new(1, Stream::Check, place, 0);
            let mut near = |to: f64| to + (rng.uniform() - 0.5) * 0.01;
            let at = [0.0, 1.0, 2.0].map(|third: f64| {
                let (sin, cos) = (third * TAU / 3.0).sin_cos();
                DVec3::new(near(0.035 * cos), near(0.035 * sin), near(-0.25))
            });
            let world = World::freeze(&mirrors(&at)).unwrap();
            for shift in 0..4 {
                let found = counted(&world, [rng.next_u64(), rng.next_u64()]);
                assert_eq!(found, [3, 6], "{at:?} {shift}");
            }
        }
    }
}
