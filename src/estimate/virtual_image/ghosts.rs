//! Second images of what is looked at: the same face over other trains of specular faces, and how they lie beside the main
//! image.

use super::aim::{aim_over, carried_along};
use super::image::{arcmin, turned};
use super::look::{Landed, Look, look_around};
use super::same_image::image;
use super::subject::{Point, Subject};
use super::tuning::ghosts::{MOST_RIVALS, MOST_WAYS};
use super::ways::Effort;
use eyebox_base::chain::Link;
use eyebox_world::World;
use eyebox_world::mode::{Mode, Mono, MonoStokes};
use eyebox_world::optics::Optics;
use glam::{DVec2, DVec3};

/// One point of a ghost beside the same point of the main image.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct GhostPoint {
    /// Column and row.
    pub cell: [usize; 2],
    /// From the main image's point to the right and up as the eye sees it, minutes of arc.
    pub separation_arcmin: [f64; 2],
    /// What it has of the picture's light over what the main image has. Both trains image one face into air, so that of a lamp it is the
    /// ratio of luminances (radiance over n² is kept along a ray; Born and Wolf, 4.8.3). Of a slide and a screen it is that if they are as
    /// bright towards either train: what shines through them is not asked.
    pub ratio: f64,
}

/// Other trains to a face, those with most light first.
pub struct Trains {
    pub images: Vec<Subject>,
    /// The largest share of a ray's light whose ways were not followed though they carry as much as was asked for.
    pub left_out: f64,
}

/// The trains other than that of `main` over which the eye of `world` sees the same face with at least the share `least` of
/// what a ray starts with, most light first.
pub fn find(tracing: (&World, &Optics<Mono>), main: &Subject, least: f64) -> Trains {
    trains(tracing, main, Effort { least, left_out: 0.0, most_ways: MOST_WAYS })
}

fn trains(tracing: (&World, &Optics<Mono>), main: &Subject, effort: Effort) -> Trains {
    let half = tracing.0.eye.half();
    let Look { found, left_out, .. } = look_around(tracing, [-half, half], (Some(main.part), effort));
    let own = main.train.chain();
    let mut ghosts: Vec<(f64, Subject)> = Vec::new();
    for ((_, _, face, chain), hits) in found {
        if face == main.face && chain != own {
            let brightest = hits.iter().map(|hit| hit.carried).fold(0.0, f64::max);
            ghosts.extend(over(tracing.0, main, &hits).map(|ghost| (brightest, ghost)));
        }
    }
    // By name where two are alike, so that their order hangs on nothing else.
    ghosts.sort_by(|a, b| b.0.total_cmp(&a.0).then_with(|| a.1.train.chain().cmp(&b.1.train.chain())));
    Trains { images: ghosts.into_iter().map(|(_, ghost)| ghost).collect(), left_out }
}

/// What is looked at over that train, of its own and those of other images, that brings most light to the middle of the
/// eyebox as polarised paths have it: without polarisation light that goes straight through a folded lens is brighter than the
/// picture.
pub fn main_image(tracing: (&World, &Optics<Mono>), subject: Subject) -> Subject {
    let polarised = MonoStokes::optics(tracing.0, 0, 0);
    let light = |subject: &Subject| {
        let seen = seen(tracing, &polarised, subject, subject.from);
        seen.into_iter().flatten().map(|seen| seen.light).sum::<f64>()
    };
    let mut rivals: Vec<Subject> = Vec::new();
    for other in trains(tracing, &subject, subject.effort).images {
        let is_new = |known: &Subject| !shows_the_same(known, &other);
        if rivals.len() < MOST_RIVALS && is_new(&subject) && rivals.iter().all(is_new) {
            rivals.push(other);
        }
    }
    let first = (light(&subject), subject);
    let brighter = |best: (f64, Subject), other: Subject| {
        let own = light(&other);
        if own > best.0 { (own, other) } else { best }
    };
    rivals.into_iter().fold(first, brighter).1
}

/// Trains other than that of `main` that show the same image: over gratings, by the same orders of the same parts. Between them light
/// may have been reflected any number of times, as in the slab of a light guide, which sends the picture out again and again. What is left
/// out is over the light of the picture.
pub fn ways(tracing: (&World, &Optics<Mono>), main: &Subject) -> Trains {
    if !main.train.0.iter().any(|lens| lens.link.order != 0) {
        return Trains { images: Vec::new(), left_out: main.left_out };
    }
    let Trains { images, left_out } = trains(tracing, main, main.effort);
    let images = images.into_iter().filter(|other| shows_the_same(main, other)).collect();
    Trains { images, left_out: left_out / main.light }
}

/// Whether two trains bend light by the same orders of the same parts, of which there are some, and go the same way before the first of
/// these and after the last: what is reflected there is a ghost.
pub fn shows_the_same(main: &Subject, other: &Subject) -> bool {
    let of = |subject: &Subject| image(&subject.train.0.iter().map(|lens| lens.link).collect::<Vec<Link>>());
    of(main).is_some_and(|own| of(other) == Some(own))
}

/// The same picture over the train of these hits.
fn over(world: &World, main: &Subject, hits: &[Landed]) -> Option<Subject> {
    let near = |place: DVec3| hits.iter().min_by(|a, b| a.place.distance(place).total_cmp(&b.place.distance(place)));
    let points = main.points.iter().map(|point| Some(Point { near: near(point.place)?.dir, ..*point }));
    let (points, from) = (points.collect::<Option<_>>()?, world.eye.position() + world.geometry.origin());
    Some(Subject { train: hits.first()?.train.clone(), points, from, ways: Vec::new(), ..main.clone() })
}

/// A point of an image that an eye sees.
#[derive(Debug, Clone, Copy)]
pub struct Seen {
    dir: DVec3,
    /// As [`carried_along`] has it.
    light: f64,
}

/// What an eye at `eye` (world, m) sees of a subject, point by point. Shares of light are those of polarised paths: what a face
/// sends back of one polarisation it lacks behind it.
pub fn seen(
    tracing: (&World, &Optics<Mono>),
    polarised: &Optics<MonoStokes>,
    subject: &Subject,
    eye: DVec3,
) -> Vec<Option<Seen>> {
    let one = |point: &Point| {
        let (sight, way) = aim_over(tracing, subject, point, (subject.from, point.near), eye);
        let dir = sight.seen()?;
        Some(Seen { dir, light: carried_along((tracing.0, polarised), way, point, eye, dir)? })
    };
    subject.points.iter().map(one).collect()
}

/// A ghost beside the main image, at the points that are seen of both. `right`: the eye's, unit.
pub fn beside(subject: &Subject, main: &[Option<Seen>], ghost: &[Option<Seen>], right: DVec3) -> Vec<GhostPoint> {
    let pairs = subject.points.iter().zip(main.iter().zip(ghost));
    pairs
        .filter_map(|(own, (main, ghost))| {
            let (Seen { dir, light }, Seen { dir: second, light: less }) = ((*main)?, (*ghost)?);
            let separation = separation(dir, second, right)?;
            let ratio = Some(less / light).filter(|ratio| ratio.is_finite())?;
            Some(GhostPoint { cell: own.cell, separation_arcmin: separation.to_array(), ratio })
        })
        .collect()
}

/// Angle from one direction to another, arcmin to the right and up of an eye turned to the first. `right`: the head's. None where
/// that eye looks along it.
fn separation(dir: DVec3, other: DVec3, right: DVec3) -> Option<DVec2> {
    let seen = turned(dir, right)?.transpose() * other;
    Some(seen.truncate().map(|side| arcmin(side.atan2(seen.z))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ghost_to_the_right_and_up_has_positive_angles() {
        let right = separation(DVec3::NEG_Z, DVec3::new(1e-3, 0.0, -1.0), DVec3::X).unwrap();
        assert!((right - DVec2::new(arcmin(1e-3), 0.0)).length() < 1e-5, "{right}");
        let up = separation(DVec3::NEG_Z, DVec3::new(0.0, 2e-3, -1.0), DVec3::X).unwrap();
        assert!((up - DVec2::new(0.0, arcmin(2e-3))).length() < 1e-4, "{up}");
        assert_eq!(separation(DVec3::X, DVec3::Z, DVec3::X), None);
    }
}
