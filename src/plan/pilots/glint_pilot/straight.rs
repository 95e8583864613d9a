//! Lamps in plain view, or through a hole: points on each lamp are joined to points of the pupil. Few of these ways are free where
//! a lamp stands behind a hole, so where none is, more are tried.

use super::fit::{Moves, Seen, about, alike, meets, pieces, settle};
use super::{Wants, Way};
use crate::pilots::tuning::glint_pilot::{ENOUGH, FIRST, JOINED, MOST_JOINED, MOST_TRIANGLES, ROUNDED};
use eyebox_base::chain::Chain;
use eyebox_base::lattice::lattice;
use eyebox_base::parallel;
use eyebox_base::warp::{BELOW_ONE, disk};
use eyebox_estimate::ShouldStop;
use eyebox_film::glint::Glint;
use eyebox_film::unseen::Hidden;
use eyebox_world::World;
use eyebox_world::lamp::Lamp;
use eyebox_world::mode::Mono;
use eyebox_world::optics::Optics;
use glam::{DMat2, DVec2, DVec3};

/// What joining a lamp with the pupil has shown.
#[derive(Default)]
struct Joined {
    /// Within the picture, free or not.
    all: Vec<Seen>,
    free: Vec<Seen>,
    tried: u64,
}

/// Lamps that `wants` says true of and that are seen without faces, with their glints (none where the image is large), and those of which
/// no point was seen.
pub(super) fn find(
    tracing: (&World, &Optics<Mono>),
    wants: &Wants<'_>,
    stop: &ShouldStop<'_>,
) -> (Vec<(Way, Vec<Glint>)>, Option<Hidden>) {
    let wanted: Vec<usize> = (0..tracing.0.lamps.all().len()).filter(|lamp| wants(*lamp)).collect();
    let most = (JOINED / wanted.len().max(1) as u64).clamp(FIRST, MOST_JOINED);
    let of_lamp = |&lamp: &usize| {
        let way = (Chain::default(), lamp);
        let Some(joined) = joined(tracing, &way, most, stop) else { return (None, None) };
        match glint_of(tracing, &way, &joined) {
            Some(glint) => (Some((way, pieces(tracing.0, &glint))), None),
            None => (None, hidden(tracing.0, &tracing.0.lamps.all()[lamp], &joined)),
        }
    };
    let all: Vec<_> = parallel::map_all(&wanted, &of_lamp);
    let hidden = all.iter().filter_map(|(_, hidden)| *hidden).reduce(Hidden::or);
    (all.into_iter().filter_map(|(found, _)| found).collect(), hidden)
}

/// What there is to say of a lamp of which no way was free.
fn hidden(world: &World, lamp: &Lamp, joined: &Joined) -> Option<Hidden> {
    let image = about(world, &joined.all, Some(moves(world, lamp)))?;
    let pixels = image.area() / world.eye.pixel().iter().product::<f64>();
    Some(Hidden { luminance: lamp.brightest(), looks: joined.all.len() as f64 / pixels.max(1.0) })
}

/// Joins a lamp with the pupil. `most`: ways that may be tried. None where it is not within the picture.
fn joined(tracing: (&World, &Optics<Mono>), way: &Way, most: u64, stop: &ShouldStop<'_>) -> Option<Joined> {
    let lamp = tracing.0.lamps.all().get(way.1)?;
    let mut joined = Joined::default();
    let mut count = FIRST;
    while joined.free.len() < ENOUGH && joined.tried < most && !stop() {
        join(tracing, way, lamp, &mut joined, count);
        if joined.all.is_empty() {
            return None;
        }
        count = joined.tried;
    }
    Some(joined)
}

/// The parallelogram about what is seen of a lamp.
fn glint_of(tracing: (&World, &Optics<Mono>), way: &Way, joined: &Joined) -> Option<Glint> {
    let lamp = tracing.0.lamps.all().get(way.1)?;
    // Where most of it is free its outline is known.
    let (world, all, free) = (tracing.0, joined.all.len(), joined.free.len());
    if free >= ENOUGH
        && 4 * free >= all
        && let Some(outline) = outline(world, lamp)
    {
        let glint = about(world, &outline, Some(moves(world, lamp)))?;
        return Some(Glint { axes: glint.axes.map(|axis| axis.map(|x| ROUNDED * x)), ..glint });
    }
    if free == 0 {
        return None;
    }
    // Seen through a hole it moves with the pupil as the hole does: by as much along one way as along the other.
    let few = free < ENOUGH || world.eye.pupil_radius_m() == 0.0;
    let glint = about(world, &joined.free, few.then(|| alike(&joined.free).unwrap_or_else(|| moves(world, lamp))))?;
    // Free ways lie as far apart as so many of the lamp's points do.
    let spread = about(world, &joined.all, Some(moves(world, lamp)))?;
    let apart = 2.0 / (joined.tried as f64).sqrt();
    let wide = |k: usize| {
        let longest = spread.axes.map(|[x, y]| x.hypot(y)).into_iter().fold(0.0, f64::max);
        let [x, y] = glint.axes[k];
        let long = x.hypot(y);
        let by = (long + apart * longest) / long;
        [by * x, by * y]
    };
    settle(tracing, way, Glint { axes: [wide(0), wide(1)], ..glint }, Moves::Unknown)
}

/// The corners of a lamp's triangles, from the middle and from the rim of the pupil; none where they are many, or behind the eye.
fn outline(world: &World, lamp: &Lamp) -> Option<Vec<Seen>> {
    const PUPIL: [DVec2; 5] = [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y];
    let (triangles, corners) = lamp.corners_of([0.0, BELOW_ONE]);
    if triangles > MOST_TRIANGLES {
        return None;
    }
    let eye = &world.eye;
    let radius_m = eye.pupil_radius_m();
    let seen = |corner: DVec3, pupil: DVec2| {
        let (film, _) = eye.towards(corner, radius_m * pupil)?;
        Some(Seen { film, pupil })
    };
    let from = if radius_m > 0.0 { &PUPIL[..] } else { &PUPIL[..1] };
    corners.flat_map(|corner| from.iter().map(move |pupil| seen(corner, *pupil))).collect()
}

/// How the image of a lamp moves with the place in the pupil, per radius.
fn moves(world: &World, lamp: &Lamp) -> DMat2 {
    let (eye, (centre, _)) = (&world.eye, lamp.around());
    let along = (centre - eye.position()).dot(eye.look());
    DMat2::IDENTITY * (eye.pupil_radius_m() * (eye.per_focus() - 1.0 / along))
}

fn join(tracing: (&World, &Optics<Mono>), way: &Way, lamp: &Lamp, joined: &mut Joined, count: u64) {
    let eye = &tracing.0.eye;
    for k in joined.tried..joined.tried + count {
        let [a, b, u, v] = lattice([0; 4], k);
        let point = lamp.sample_point([a, b]);
        let pupil = if eye.pupil_radius_m() > 0.0 { disk([u, v]) } else { DVec2::ZERO };
        let Some((film, dir)) = eye.towards(point.position, eye.pupil_radius_m() * pupil) else { continue };
        if eye.pixel_of(film).is_none() || lamp.luminance_along(point.normal, -dir) <= 0.0 {
            continue;
        }
        let seen = Seen { film, pupil };
        joined.all.push(seen);
        if meets(tracing, way, seen) {
            joined.free.push(seen);
        }
    }
    joined.tried += count;
}
