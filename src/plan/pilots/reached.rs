//! Who is to have what the solver does not return of a connected train: light tracing, if the pilot saw it arrive, else rays
//! from the eye. A train that only such rays have seen (a large lamp over a small pupil) would be lost by light tracing.

use super::chains::{Arrived, SEED};
use super::eye_pilot;
use super::tuning::reached::{FEWEST_ARRIVED, SIGMAS};
use eyebox_base::path::Class;
use eyebox_estimate::ShouldStop;
use eyebox_estimate::manifold::seeds::connections::Connections;
use eyebox_estimate::manifold::solver::newton::Target;
use eyebox_estimate::ownership::Ownership;
use eyebox_film::plan::{Estimator, Plan};
use eyebox_world::World;
use eyebox_world::mode::{Mode, Mono};

/// Whether paths from the lamps bring the light of a train that rays from the eye have `seen`: some arrived, and not
/// surely less than was seen.
pub(crate) fn is_reached(arrived: &[Arrived], seen: &[Arrived]) -> bool {
    let sum = |all: &[Arrived]| {
        let fold = |(sum, square): (f64, f64), a: &Arrived| (sum + a.luminance, square + a.luminance * a.luminance);
        let (sum, square) = all.iter().fold((0.0, 0.0), fold);
        (sum, square.sqrt())
    };
    let ((from_lamp, lamp_error), (from_eye, eye_error)) = (sum(arrived), sum(seen));
    arrived.len() >= FEWEST_ARRIVED && from_lamp + SIGMAS * lamp_error >= from_eye - SIGMAS * eye_error
}

/// Of the light that rays from the eye see over specular faces, the share that these connections leave to such rays: the
/// largest of any light group that they have. Once `stop` says true the result is worthless.
pub fn left_to_eye(world: &World, plan: &Plan, groups: usize, made: &Connections, stop: &ShouldStop<'_>) -> f64 {
    let route = Ownership::new(plan, groups, Estimator::Manifold);
    let optics = Mono::<f64>::optics(world, SEED, 0);
    let mut sums = vec![[0.0; 2]; groups];
    for seen in eye_pilot::look((world, &optics), stop) {
        if route.share(seen.group, Class::Vision, false).is_none() {
            continue;
        }
        let [point, normal] = seen.on_lamp;
        let target = Target::new(point, normal);
        let places = (seen.film, seen.pupil);
        let left = made.leaves_to_eye((world, &optics), &seen.chain, (seen.lamp, &target), places, &mut 0);
        let [all, rest] = &mut sums[seen.group.index()];
        *all += seen.luminance;
        *rest += if left { seen.luminance } else { 0.0 };
    }
    sums.iter().filter(|[all, _]| *all > 0.0).map(|[all, rest]| rest / all).fold(0.0, f64::max)
}
