//! The direction in which a point of the picture is seen from anywhere: Newton's iteration through the train, then a ray
//! that looks whether anything is in the way.

use super::sent;
use super::subject::{Point, Subject};
use super::tuning::aim::{FINE, FINEST, NEAR};
use crate::ledger::Ledger;
use crate::manifold::solver::media::OneWavelength;
use crate::manifold::solver::newton::{Family, Target, newton};
use crate::walk::{Meeting, Met};
use eyebox_world::World;
use eyebox_world::mode::{Mode, Mono};
use eyebox_world::optics::Optics;
use eyebox_world::surface::Surface;
use glam::{DVec2, DVec3};
use std::iter::once;

/// A point as an eye sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sight {
    /// In this direction (unit, world).
    Seen(DVec3),
    /// It would be there, but something is in the way, or the light would have to pass beside a face.
    Hidden(DVec3),
    /// No ray of the train leads there.
    Nowhere,
}

impl Sight {
    /// Seen or not.
    pub fn direction(self) -> Option<DVec3> {
        match self {
            Sight::Seen(dir) | Sight::Hidden(dir) => Some(dir),
            Sight::Nowhere => None,
        }
    }
    /// Where it is seen.
    pub fn seen(self) -> Option<DVec3> {
        match self {
            Sight::Seen(dir) => Some(dir),
            Sight::Hidden(_) | Sight::Nowhere => None,
        }
    }
}

/// How `eye` (world, m) sees a point of the subject, over its own train or, where that is not seen, over another of its ways. `known`: an
/// eye and the direction in which it sees that point or one near it over the subject's train, world. Exact up to rounding.
pub fn aim(
    tracing: (&World, &Optics<Mono>),
    subject: &Subject,
    point: &Point,
    known: (DVec3, DVec3),
    eye: DVec3,
) -> Sight {
    aim_over(tracing, subject, point, known, eye).0
}

/// The same, and the way over which it is seen.
pub fn aim_over<'s>(
    tracing: (&World, &Optics<Mono>),
    subject: &'s Subject,
    point: &Point,
    known: (DVec3, DVec3),
    eye: DVec3,
) -> (Sight, &'s Subject) {
    let own = aim_alone(tracing, subject, point, known, eye);
    if own.seen().is_none() {
        for way in &subject.ways {
            if let Some(point) = way.point(point.cell) {
                let sight = aim_alone(tracing, way, point, (way.from, point.near), eye);
                if sight.seen().is_some() {
                    return (sight, way);
                }
            }
        }
    }
    (own, subject)
}

/// The same over the subject's own train alone.
pub fn aim_alone(
    tracing: (&World, &Optics<Mono>),
    subject: &Subject,
    point: &Point,
    known: (DVec3, DVec3),
    eye: DVec3,
) -> Sight {
    let Some(dir) = transported(tracing, subject, point, known, eye) else { return Sight::Nowhere };
    if carried_along(tracing, subject, point, eye, dir).is_some() { Sight::Seen(dir) } else { Sight::Hidden(dir) }
}

/// Carries a direction from one eye to another: at once, else in steps that shrink where one leads beside a face and grow where
/// none does. Near a rim they would lead beside it if they were all alike, however many.
fn transported(
    (world, optics): (&World, &Optics<Mono>),
    subject: &Subject,
    point: &Point,
    (from, near): (DVec3, DVec3),
    eye: DVec3,
) -> Option<DVec3> {
    let origin = world.geometry.origin();
    let media = OneWavelength(optics);
    let size = FINE * subject.size[0].max(subject.size[1]);
    let target = Target::new(point.place - origin, subject.normal);
    let solved = |share: f64, dir: DVec3| {
        let here = from.lerp(eye, share) - origin;
        let (family, [a, b]) = Family::about(here, None, dir);
        let root = newton(world, &media, &family, DVec2::ZERO, &subject.train, &target, size)?;
        (dir + root.u.x * a + root.u.y * b).try_normalize()
    };
    if let Some(dir) = solved(1.0, near) {
        return Some(dir);
    }
    // From the known direction's own eye first, which sees perhaps another point.
    let mut dir = solved(0.0, near)?;
    let (mut done, mut step) = (0.0, 0.5);
    while done < 1.0 {
        let next = f64::min(done + step, 1.0);
        match solved(next, dir) {
            Some(there) => (done, dir, step) = (next, there, 2.0 * step),
            None if step > FINEST => step *= 0.5,
            None => return None,
        }
    }
    Some(dir)
}

/// The light of the point, polarised as it leaves there where paths carry that, that a ray from the eye takes up
/// after it has met the faces of the train one after the other. None where something is in the way. Of a lamp that is its luminance
/// towards the ray, cd/m²; of a slide, whose picture is left out, and of a screen the share of light that arrives.
pub fn carried_along<M: Mode>(
    tracing: (&World, &Optics<M>),
    subject: &Subject,
    point: &Point,
    eye: DVec3,
    dir: DVec3,
) -> Option<f64> {
    let origin = tracing.0.geometry.origin();
    let mut ledger = Ledger::new(tracing.0.solids.len());
    let mut walker = sent(tracing, eye - origin, dir).recording();
    for lens in &subject.train.0 {
        if !walker.follow(once(lens.link), &mut ledger, |_, _, _| {}) {
            return None;
        }
        // Chance takes nothing of a long train.
        walker.events = walker.events.min(1);
    }
    let links = subject.train.0.len();
    loop {
        let Met::Face(vertex) = walker.advance(&mut ledger) else { return None };
        if (vertex.hit.site.part, vertex.hit.site.face) == (subject.part, subject.face) {
            let size = subject.size[0].max(subject.size[1]);
            let there = (vertex.hit.point + origin - point.place).length() <= NEAR * size;
            if !there {
                return None;
            }
            if let Some(lamp) = walker.lamp_at(&vertex) {
                return Some(walker.carried_of(&lamp) * lamp.luminance);
            }
            // One that is on, but not towards the ray.
            let lamps = &tracing.0.lamps;
            let lamp =
                lamps.of_face(subject.part as usize, subject.face as usize).and_then(|index| lamps.all().get(index));
            if lamp.is_some_and(|lamp| lamp.flux_lm > 0.0) {
                return Some(0.0);
            }
            // A slide gives its light a polarisation.
            if matches!(walker.face(&vertex).surface, Surface::Slide(_)) {
                let _ = walker.meet(&vertex, &mut ledger);
            }
            return Some(walker.beam.weight());
        }
        let went = matches!(walker.meet(&vertex, &mut ledger), Meeting::Went);
        // Anything but a face that is not there is in the way.
        if !went || walker.chain().is_none_or(|chain| chain.0.len() != links) {
            return None;
        }
    }
}
