//! How much work a relative error takes: a few passes of a small picture, and the square root law.

use crate::base::Result;
use crate::estimate::run::begin;
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
}

/// Passes of the pilot.
const PASSES: u64 = 6;
/// Longer side of its picture, pixels.
const SIDE: usize = 64;

/// Runs the pilot. Errors: as [`World::freeze`].
pub fn forecast(scene: &Scene, plan: &Plan) -> Result<Forecast> {
    let mut small = scene.clone();
    let longer = scene.eye.resolution[0].max(scene.eye.resolution[1]).max(1);
    let scale = (SIDE as f64 / longer as f64).min(1.0);
    small.eye.resolution = scene.eye.resolution.map(|n| ((n as f64 * scale) as usize).max(1));
    let pixels = |[w, h]: [usize; 2]| (w * h) as f64;
    let share = pixels(small.eye.resolution) / pixels(scene.eye.resolution);
    let mut own = plan.clone();
    let fewer = |paths: u64| if paths == 0 { 0 } else { ((paths as f64 * share) as u64).max(1 << 10) };
    (own.forward_paths, own.photons) = (fewer(plan.forward_paths), fewer(plan.photons));
    let world = World::freeze(&small)?;
    let mut tracing = begin(&world, &own, scene.groups.len(), small.eye.resolution, 0);
    tracing.step(PASSES);
    let films = tracing.films();
    let paths: u64 = films.films.iter().map(|(_, _, ledger)| ledger.paths).sum();
    let error = films.relative_error().map(|error| error * (PASSES as f64).sqrt());
    Ok(Forecast {
        error_of_a_pass: error,
        paths_of_a_pass: paths as f64 / PASSES as f64 / share,
        passes: error.map(|error| (error / 0.01).powi(2).ceil().max(1.0)),
    })
}

impl Forecast {
    /// For people.
    pub fn line(&self) -> String {
        match self.passes {
            Some(passes) => format!(
                "to 1 % error: about {passes:.0} passes, {:.2e} paths (a pilot of {PASSES} passes of a small picture)",
                passes * self.paths_of_a_pass
            ),
            None => "to 1 % error: nothing was seen in a pilot, so nothing is foretold".to_owned(),
        }
    }
}
