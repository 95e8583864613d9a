//! How much work a relative error takes: passes of a small picture until it states that error or has cost enough, and the square
//! root law from there on. Even points converge faster than that law has it, which few passes cannot tell. How much less noise the
//! pixels of the whole picture have is foretold from those of a still smaller one.

use crate::base::Result;
use crate::estimate::run::{Films, begin};
use crate::film::plan::Plan;
use crate::scene::Scene;
use crate::world::World;

/// Passes and paths to a relative error of 1 %.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Forecast {
    /// Relative error of one pass, by the pilot; none for a black picture.
    pub error_of_a_pass: Option<f64>,
    /// Paths of one pass of the whole picture.
    pub paths_of_a_pass: f64,
    /// Passes to 1 %.
    pub passes: Option<f64>,
    /// Passes that the pilot made.
    pub pilot_passes: u64,
}

/// The relative error that is asked for.
const AIM: f64 = 0.01;
/// First passes of the pilot.
const PASSES: u64 = 6;
/// Counted work that the pilot may take, about a second's.
const WORK: u64 = 50_000_000;
/// Longer side of its picture, pixels.
const SIDE: usize = 64;

/// Runs the pilot. Errors: as [`World::freeze`].
pub fn forecast(scene: &Scene, plan: &Plan) -> Result<Forecast> {
    let longer = scene.eye.resolution[0].max(scene.eye.resolution[1]).max(1);
    let shrunk = |side: usize| {
        let mut small = scene.clone();
        let scale = (side as f64 / longer as f64).min(1.0);
        small.eye.resolution = scene.eye.resolution.map(|n| ((n as f64 * scale) as usize).max(1));
        let share = pixels(&small) / pixels(scene);
        let mut own = plan.clone();
        let fewer = |paths: u64| if paths == 0 { 0 } else { ((paths as f64 * share) as u64).max(1 << 10) };
        (own.forward_paths, own.photons) = (fewer(plan.forward_paths), fewer(plan.photons));
        (small, own, share)
    };
    let (small, own, share) = shrunk(SIDE);
    let world = World::freeze(&small)?;
    let mut tracing = begin(&world, &own, scene.groups.len(), small.eye.resolution, 0);
    tracing.step(PASSES);
    let first = of_a_pass(tracing.films());
    let larger = match first {
        Some(error) if share < 1.0 => {
            let (smaller, own, _) = shrunk(SIDE / 2);
            let world = World::freeze(&smaller)?;
            let mut tracing = begin(&world, &own, scene.groups.len(), smaller.eye.resolution, 0);
            tracing.step(PASSES);
            let rough = of_a_pass(tracing.films()).unwrap_or(0.0);
            of_the_whole([error, rough], pixels(&small) / pixels(&smaller), share)
        }
        Some(_) | None => 1.0,
    };
    let work = |films: &Films| films.films.iter().map(|(_, _, ledger)| ledger.work).sum::<u64>();
    let far = |films: &Films| films.relative_error().is_some_and(|error| error * larger > AIM);
    // Twice as many passes take twice the work.
    while far(tracing.films()) && 2 * work(tracing.films()) <= WORK {
        tracing.step(tracing.films().passes);
    }
    let films = tracing.films();
    let paths: u64 = films.films.iter().map(|(_, _, ledger)| ledger.paths).sum();
    Ok(Forecast {
        error_of_a_pass: first.map(|error| error * larger),
        paths_of_a_pass: paths as f64 / films.passes as f64 / share,
        passes: of_a_pass(films).map(|error| (error * larger / AIM).powi(2).ceil().max(1.0)),
        pilot_passes: films.passes,
    })
}

fn pixels(scene: &Scene) -> f64 {
    scene.eye.resolution.iter().product::<usize>() as f64
}

/// How many times the error of a small picture that of the whole one is, whose pixels are 1/`share` as many. `errors`: of the small
/// picture and of one with 1/`ratio` of its pixels.
fn of_the_whole([error, rough]: [f64; 2], ratio: f64, share: f64) -> f64 {
    let exponent = (error / rough).ln() / ratio.ln();
    // Pixels of half the size have less of an edge or a slope each, and no more noise. Where none has any there is no number.
    if exponent.is_nan() { 1.0 } else { share.powf(-exponent.clamp(-0.5, 0.0)) }
}

/// The relative error of one pass that these would state if passes were independent.
fn of_a_pass(films: &Films) -> Option<f64> {
    films.relative_error().map(|error| error * (films.passes as f64).sqrt())
}

impl Forecast {
    /// For people.
    pub fn line(&self) -> String {
        match self.passes {
            Some(passes) => format!(
                "to 1 % error: about {passes:.0} passes, {:.2e} paths (a pilot of {} passes of a small picture)",
                passes * self.paths_of_a_pass,
                self.pilot_passes
            ),
            None => "to 1 % error: nothing was seen in a pilot, so nothing is foretold".to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_fall_with_the_pixels_size_as_far_as_two_pictures_tell() {
        for (errors, want) in [
            ([0.1, 0.2], 0.25),
            ([0.1, 0.1], 1.0),
            ([0.2, 0.1], 1.0),
            ([0.1, 10.0], 0.25),
            ([0.1, 0.1 * 2f64.sqrt()], 0.5),
            ([0.0, 0.0], 1.0),
            ([0.1, 0.0], 1.0),
        ] {
            let got = of_the_whole(errors, 4.0, 1.0 / 16.0);
            assert!((got - want).abs() < 1e-12, "{errors:?}: {got} {want}");
        }
    }
}
