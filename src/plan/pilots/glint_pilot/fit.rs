//! From paths that meet a lamp to the parallelogram about its image, and from a guess at that to one that holds all of it.

use super::Way;
use crate::pilots::chains::SEED;
use crate::pilots::tuning::glint_pilot::{
    ASTRAY, AT_RIM, ENOUGH, FEWEST, GROWN, LEAST_PIXELS, LONG, MARGIN, MOST_PIECES, RAYS_TO_FIT, ROUNDS, THIN,
};
use eyebox_base::lattice::lattice;
use eyebox_base::rng::{Rng, Stream};
use eyebox_base::warp::disk;
use eyebox_estimate::ledger::Ledger;
use eyebox_estimate::walk::{Travel, Walker};
use eyebox_film::glint::Glint;
use eyebox_world::World;
use eyebox_world::geometry::Ray;
use eyebox_world::interior::Interior;
use eyebox_world::mode::Mono;
use eyebox_world::optics::Optics;
use glam::{DMat2, DVec2};

/// A path that meets a lamp: places in the picture, tangents, and in the pupil, radii.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen {
    pub film: DVec2,
    pub pupil: DVec2,
}

/// Whether a path meets a lamp over its chain.
pub(super) fn meets((world, optics): (&World, &Optics<Mono>), (chain, lamp): &Way, seen: Seen) -> bool {
    let (origin, (_, dir), ..) = world.eye.ray_of(seen.film, world.eye.pupil_radius_m() * seen.pupil);
    let ray = Ray { origin, dir, from: None };
    let rng = Rng::new(SEED, Stream::Pilot, 4, 0);
    let mut walker = Walker::new((world, optics), Travel::FromEye, ray, 1.0, Interior::default(), rng);
    let mut ledger = Ledger::new(world.solids.len());
    walker.follow_to(chain.0.iter().copied(), *lamp, &mut ledger, |_, _, _| {}).is_some()
}

/// The parallelogram about all of these, along their principal axes. `by_pupil`: how they move with the pupil; else they tell.
pub(super) fn about(world: &World, seen: &[Seen], by_pupil: Option<DMat2>) -> Option<Glint> {
    let moves = by_pupil.unwrap_or_else(|| regressed(seen));
    let still: Vec<DVec2> = seen.iter().map(|own| own.film - moves * own.pupil).collect();
    let count = still.len() as f64;
    let mean = still.iter().sum::<DVec2>() / count;
    let [mut xx, mut xy, mut yy] = [0.0; 3];
    for off in still.iter().map(|place| *place - mean) {
        (xx, xy, yy) = (xx + off.x * off.x, xy + off.x * off.y, yy + off.y * off.y);
    }
    let along = DVec2::from_angle(0.5 * (2.0 * xy).atan2(xx - yy));
    // A point is about a hundredth of a pixel wide.
    let least = LEAST_PIXELS * DVec2::from_array(world.eye.pixel()).min_element();
    let (mut middle, mut axes) = (DVec2::ZERO, [DVec2::ZERO; 2]);
    for (axis, along) in axes.iter_mut().zip([along, along.perp()]) {
        let (low, high) = still
            .iter()
            .map(|place| place.dot(along))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
        middle += 0.5 * (low + high) * along;
        *axis = (0.5 * (high - low)).max(least) * along;
    }
    let [a, b] = [moves.x_axis, moves.y_axis].map(|axis| axis.to_array());
    let glint = Glint { middle: middle.to_array(), axes: axes.map(|axis| axis.to_array()), by_pupil: [a, b] };
    glint.is_valid().then_some(glint)
}

/// How places in the picture follow from those in the pupil, by least squares; not at all where the pupil is a point.
fn regressed(seen: &[Seen]) -> DMat2 {
    let count = seen.len() as f64;
    let mean = |of: &dyn Fn(&Seen) -> DVec2| seen.iter().map(of).sum::<DVec2>() / count;
    let (film, pupil) = (mean(&|own| own.film), mean(&|own| own.pupil));
    let outer = |a: DVec2, b: DVec2| DMat2::from_cols(a * b.x, a * b.y);
    let (mut across, mut spread) = (DMat2::ZERO, DMat2::ZERO);
    for own in seen {
        across += outer(own.film - film, own.pupil - pupil);
        spread += outer(own.pupil - pupil, own.pupil - pupil);
    }
    let moves = across * spread.inverse();
    if moves.is_finite() { moves } else { DMat2::ZERO }
}

/// The same of what moves alike along both ways; none of a single place, and where the pupil is a point.
pub(super) fn alike(seen: &[Seen]) -> Option<DMat2> {
    let count = seen.len() as f64;
    let mean = |of: &dyn Fn(&Seen) -> DVec2| seen.iter().map(of).sum::<DVec2>() / count;
    let (film, pupil) = (mean(&|own| own.film), mean(&|own| own.pupil));
    let across: f64 = seen.iter().map(|own| (own.film - film).dot(own.pupil - pupil)).sum();
    let spread: f64 = seen.iter().map(|own| (own.pupil - pupil).length_squared()).sum();
    (spread > 0.0).then(|| DMat2::IDENTITY * (across / spread))
}

fn grown(glint: &Glint, by: f64) -> Glint {
    Glint { axes: glint.axes.map(|axis| axis.map(|x| by * x)), ..*glint }
}

/// How an image moves with the place in the pupil.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Moves {
    /// As the guess says.
    Known,
    /// The rays that meet the lamp are to tell.
    Unknown,
}

/// The parallelogram about all of an image of which `guess` holds a part: rays all over it tell where the lamp is met, and it is
/// drawn closer or wider until none of those lies at its rim. None if not one meets the lamp.
pub(super) fn settle(tracing: (&World, &Optics<Mono>), way: &Way, guess: Glint, moves: Moves) -> Option<Glint> {
    let mut glint = guess;
    let mut found = None;
    for round in 0..ROUNDS {
        let seen = shoot(tracing, way, &glint, round);
        if seen.is_empty() {
            break;
        }
        let count = seen.len() as f64;
        let told = moves == Moves::Unknown && seen.len() >= FEWEST && tracing.0.eye.pupil_radius_m() > 0.0;
        let before = DMat2::from_cols_array_2d(&glint.by_pupil);
        let fitted = about(tracing.0, &seen, (!told).then_some(before))?;
        let at_rim = seen.iter().any(|own| glint.reach_of(own.film, own.pupil) > AT_RIM);
        // Corners are seldom met; and where rays tell how it moves they err by what its width is over the root of their number.
        let margin = MARGIN + FEWEST as f64 / (2.0 * count) + if told { ASTRAY / count.sqrt() } else { 0.0 };
        glint = grown(&fitted, if at_rim { GROWN * margin } else { margin });
        found = Some(glint);
        if !at_rim && seen.len() >= ENOUGH {
            break;
        }
    }
    found
}

/// Rays all over a glint and the pupil: those that meet the lamp.
fn shoot(tracing: (&World, &Optics<Mono>), way: &Way, glint: &Glint, round: u64) -> Vec<Seen> {
    let drawn = |k: u64| {
        let [a, b, u, v] = lattice([0; 4], k + round * RAYS_TO_FIT);
        let pupil = if tracing.0.eye.pupil_radius_m() > 0.0 { disk([u, v]) } else { DVec2::ZERO };
        let (film, pupil) = glint.draw(f64::INFINITY, (DVec2::ZERO, pupil), [a, b])?;
        let seen = Seen { film, pupil };
        meets(tracing, way, seen).then_some(seen)
    };
    (0..RAYS_TO_FIT).filter_map(drawn).collect()
}

/// What pixels look closer at of an image: pieces of about a pixel where it is thin, the whole where it is small, and nothing
/// where it is wide and high: there are pixels in its midst, and its edge is one as any other.
pub(super) fn pieces(world: &World, glint: &Glint) -> Vec<Glint> {
    let pixel = DVec2::from_array(world.eye.pixel()).min_element();
    let sides = glint.axes.map(|[x, y]| 2.0 * x.hypot(y));
    if sides[0].min(sides[1]) > THIN * pixel {
        return Vec::new();
    }
    glint.pieces(LONG * pixel, MOST_PIECES)
}
