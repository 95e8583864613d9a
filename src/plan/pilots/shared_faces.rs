//! Whether the lamps' light and the eye's sight have a face in common. A path over specular faces has none that only one of
//! them reaches: where a diffuser stands between them there is nothing for light tracing to find, however long it looks.

use super::SEED;
use super::eye_pilot::{self, sides_of};
use super::tuning::shared_faces::{LEAST, MOST_SPLITS, PATHS, POINTS};
use eyebox_base::lattice::lattice;
use eyebox_base::path::Class;
use eyebox_base::rng::Stream;
use eyebox_estimate::ShouldStop;
use eyebox_estimate::data::{End, go_straight};
use eyebox_estimate::emission::{Emission, Origin, Shots, Starts, Visitor};
use eyebox_estimate::ledger::Ledger;
use eyebox_estimate::ownership::Ownership;
use eyebox_estimate::splitting::Splitting;
use eyebox_estimate::walk::{Vertex, Walker};
use eyebox_film::plan::{Estimator, Plan, Verdict};
use eyebox_world::World;
use eyebox_world::eye::Arrival;
use eyebox_world::mode::{Mode, Mono};
use eyebox_world::scatter::Scatter;
use glam::DVec3;
use std::collections::BTreeSet;

/// Faces that light goes on from unscattered.
struct Faces {
    both: Splitting,
    found: BTreeSet<(u32, u32)>,
}

impl Visitor<Mono> for Faces {
    fn split_from(&self, walker: &Walker<'_, Mono>) -> Option<f64> {
        if walker.trail.has_scatter() { None } else { self.both.from(walker) }
    }
    fn most_splits(&self) -> u8 {
        u8::MAX
    }
    fn went(&mut self, walker: &Walker<'_, Mono>, vertex: &Vertex) {
        if !walker.trail.has_scatter() {
            self.found.extend(sides_of(vertex).into_iter().flatten());
        }
    }
    fn pupil(&mut self, _: &Walker<'_, Mono>, _: Origin, _: &Arrival) {}
    fn scatterer(&mut self, _: &Walker<'_, Mono>, _: Origin, _: &Vertex, _: &Scatter) {}
}

/// Whether a lamp may be in plain sight, through glass as well: small ones are missed by rays that aim at nothing. No where
/// something that is not specular stands on the way from the middle of the pupil. Yes once `stop` says true.
pub(crate) fn in_plain_sight(world: &World, stop: &ShouldStop<'_>) -> bool {
    let optics = Mono::<f64>::optics(world, SEED, 0);
    let ledger = &mut Ledger::new(world.solids.len());
    let eye = world.eye.position();
    let mut is_open = |point: DVec3| {
        let far = point.distance(eye);
        let mut reached = false;
        let end = go_straight((world, &optics), (eye, (point - eye) / far), ledger, |vertex| {
            reached |= vertex.hit.point.distance(eye) > 0.999 * far;
        });
        reached || !matches!(end, End::Seen)
    };
    let mut points =
        world.lamps.all().iter().flat_map(|lamp| (0..POINTS).map(|k| lamp.sample_point(lattice([0; 2], k))));
    points.any(|point| stop() || is_open(point.position))
}

/// Whether light tracing may find what the plan gives to it: light that scatterers send to the eye, a lamp in plain sight,
/// or one over specular faces, of which rays from the eye meet one that the lamps' light goes on from.
pub(crate) fn may_meet(world: &World, plan: &Plan, groups: usize, stop: &ShouldStop<'_>) -> bool {
    let scattered = plan.rows.iter().any(|row| match row.verdict {
        Verdict::Own { owner: by, .. } | Verdict::Connect { rest: by, .. } => {
            by == Estimator::Forward && row.class != Class::Vision
        }
        // A lamp in plain sight is none that has a face.
        Verdict::Emitted { .. } => true,
        Verdict::Skip { .. } => false,
    });
    if scattered {
        return true;
    }
    let optics = Mono::<f64>::optics(world, SEED, 0);
    let seen = eye_pilot::faces((world, &optics), stop);
    let is_seen = |face: (u32, u32)| seen.contains(&face);
    if world.lamps.all().iter().any(|lamp| is_seen((lamp.part as u32, lamp.face as u32))) {
        return true;
    }
    let emission = Emission::new(world, &Ownership::new(plan, groups, Estimator::Forward), groups, None);
    let shots = Shots { seed: SEED, stream: Stream::Pilot, pass: 4, paths: PATHS, starts: Starts::OfPass };
    let visitor = || Faces { both: Splitting::new(LEAST, MOST_SPLITS), found: BTreeSet::new() };
    let lit = emission.survey((world, &optics), shots, stop, visitor, |_, _, _, faces: Faces| Some(faces.found));
    lit.into_iter().flatten().any(is_seen)
}
