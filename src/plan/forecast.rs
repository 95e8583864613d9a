//! How much work a relative error takes: passes of a small picture until it states that error or has cost enough, and the square
//! root law from there on, or until its passes can have missed little enough. Even points converge faster than that law has it, which few passes cannot tell. How much less noise the
//! pixels of the whole picture have is foretold from a few passes of one in between.

use super::pilots::pilot_resolution::PilotResolution;
use super::tuning::forecast::{AIM, LARGER_SIDE, MOST_BY_PIXELS, PASSES, SIDE, WORK};
use eyebox_base::Result;
use eyebox_estimate::run::{Films, Tracing, begin};
use eyebox_film::plan::Plan;
use eyebox_scene::Scene;
use eyebox_world::World;

/// Passes and paths to a relative error of 1 %.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Forecast {
    /// Relative error of one pass of the whole picture, by the pilot's first six, or by all where six were nothing but noise; none
    /// where all were, and for a black picture.
    pub error_of_a_pass: Option<f64>,
    /// Paths of one pass of the whole picture.
    pub paths_of_a_pass: f64,
    /// Passes to 1 %, by all of the pilot's: fewer than the error of one tells where points are even.
    pub passes: Option<f64>,
    /// Passes that the pilot made.
    pub pilot_passes: u64,
}

/// Runs the pilot for a plan of this scene, whose world it is. Errors: as [`World::seen_by`].
pub fn forecast(scene: &Scene, world: &World, plan: &Plan) -> Result<Forecast> {
    let shrunk = |side: usize| PilotResolution::new(world, &scene.eye, side);
    let small = shrunk(SIDE)?;
    let mut tracing = first_passes(&small, plan, scene);
    let first = of_a_pass(tracing.films());
    let larger = match tracing.films().relative_noise() {
        Some(noise) if small.share < 1.0 => {
            let finer = shrunk(LARGER_SIDE)?;
            let tracing = first_passes(&finer, plan, scene);
            let fine = tracing.films().relative_noise();
            fine.map_or(1.0, |fine| of_the_whole([noise, fine], finer.share / small.share, finer.share))
        }
        Some(_) | None => 1.0,
    };
    let work = |films: &Films| films.films.iter().map(|(_, _, ledger)| ledger.work).sum::<u64>();
    let far = |films: &Films| films.relative_error_of_noise().map_or(films.has_light(), |error| error * larger > AIM);
    // Twice as many passes take twice the work.
    while far(tracing.films()) && 2 * work(tracing.films()) <= WORK {
        tracing.step(tracing.films().passes);
    }
    let films = tracing.films();
    let paths: u64 = films.films.iter().map(|(_, _, ledger)| ledger.paths).sum();
    Ok(Forecast {
        error_of_a_pass: first.or_else(|| of_a_pass(films)).map(|error| error * larger),
        paths_of_a_pass: paths as f64 / films.passes as f64 / small.share,
        passes: of_a_pass(films)
            .map(|error| passes_to_aim(error * larger, |passes| films.missed_after(passes, small.share))),
        pilot_passes: films.passes,
    })
}

/// Passes until the noise, whose error falls as their root, and what rays may have missed are together at what was aimed at, to a twentieth.
fn passes_to_aim(error_of_a_pass: f64, missed_after: impl Fn(u64) -> f64) -> f64 {
    let mut passes = (error_of_a_pass / AIM).powi(2).ceil().max(1.0);
    while (error_of_a_pass / passes.sqrt()).hypot(missed_after(passes as u64)) > 1.0001 * AIM && passes < 1e15 {
        passes = (1.05 * passes).ceil();
    }
    passes
}

fn first_passes<'w>(small: &'w PilotResolution, plan: &Plan, scene: &Scene) -> Box<dyn Tracing + 'w> {
    let mut tracing = begin(&small.world, &small.plan(plan), scene.groups.len(), small.size, 0);
    tracing.step(PASSES);
    tracing
}

/// The whole picture's error in that of a small one, from the errors of this and of one with `ratio` times its pixels, which are
/// `share` of the whole one's.
fn of_the_whole([small, fine]: [f64; 2], ratio: f64, share: f64) -> f64 {
    // Smaller pixels have no more noise. Of two pixels where one was, at most one has the edge: error² is as the pixels' side.
    let exponent = ((fine / small).ln() / ratio.ln()).clamp(MOST_BY_PIXELS, 0.0);
    // Where there is no noise there is no number.
    if exponent.is_nan() { 1.0 } else { (ratio / share).powf(exponent) }
}

/// The relative error by noise of one pass that these would state if passes were independent: what gathering blurs falls
/// more slowly, and in a small picture it is larger.
fn of_a_pass(films: &Films) -> Option<f64> {
    films.relative_error_of_noise().map(|error| error * (films.passes as f64).sqrt())
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
            None => "to 1 % error: a pilot saw nothing that stands out of noise, so nothing is foretold".to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_errors_come_down_to_what_was_aimed_at() {
        assert_eq!(passes_to_aim(0.1, |_| 0.0), 100.0);
        // 0.008 are left for the noise.
        let passes = passes_to_aim(0.1, |_| 0.006);
        assert!((156.0..166.0).contains(&passes), "{passes}");
        let passes = passes_to_aim(0.001, |passes| 2.0 / passes as f64);
        assert!((200.0..215.0).contains(&passes), "{passes}");
    }

    #[test]
    fn errors_fall_with_the_pixels_size_as_far_as_two_pictures_tell() {
        let root = 2f64.sqrt();
        for (errors, want) in [
            ([0.1 * root, 0.1], 0.25),
            ([0.1, 0.1], 1.0),
            ([0.1, 0.2], 1.0),
            ([10.0, 0.1], 0.25),
            ([0.1 * root.sqrt(), 0.1], 0.5),
            ([0.0, 0.0], 1.0),
            ([0.1, 0.0], 0.25),
        ] {
            let got = of_the_whole(errors, 4.0, 1.0 / 64.0);
            assert!((got - want).abs() < 1e-12, "{errors:?}: {got} {want}");
        }
    }
}
