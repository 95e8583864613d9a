//! Whether the error that a run states is the one it has: many seeds of one asset, against references of another
//! estimator.

use super::curve::asset::{Task, open};
use super::curve::error::References;
use super::curve::picture::Picture;
use super::curve::race::Ready;
use super::curve::reference::references;
use super::curve::{ReferenceFacts, name};
use eyebox_base::Result;
use eyebox_estimate::ShouldStop;
use eyebox_estimate::run::{Films, LEEWAY, Limits, Observer, Status, run};
use eyebox_film::plan::Plan;
use eyebox_plan::plan;
use eyebox_scene::Scene;
use std::path::Path;
use std::time::Duration;

/// One run.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Run {
    pub seed: u64,
    pub passes: u64,
    /// Relative error as the run states it; none if it states none.
    pub stated: Option<f64>,
    /// Root of the sum of squared errors over the sum of squares.
    pub real: f64,
}

impl Run {
    pub fn is_honest(&self) -> bool {
        self.stated.is_some_and(|stated| self.real <= LEEWAY * stated)
    }

    fn line(&self) -> String {
        let stated = self.stated.unwrap_or(f64::NAN);
        let (seed, passes, ratio) = (self.seed, self.passes, self.real / stated);
        format!("{seed:>6} {passes:>8} {stated:>10.5} {:>10.5} {ratio:>6.2}\n", self.real)
    }
}

/// Many runs of an asset.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Stated {
    pub asset: String,
    pub estimator: &'static str,
    /// What the runs were asked for.
    pub error: f64,
    pub reference: ReferenceFacts,
    /// The smallest relative error that the references can tell from none.
    pub least: f64,
    pub runs: Vec<Run>,
}

impl Stated {
    /// Runs whose true error is at most 1.2 of the stated one.
    pub fn honest(&self) -> usize {
        self.runs.iter().filter(|run| run.is_honest()).count()
    }

    /// Whether the references are good enough to tell a run that states too little.
    pub fn is_told(&self) -> bool {
        // With two of their standard errors more an honest run would be none.
        self.least.powi(2) <= (LEEWAY * LEEWAY - 1.0) * self.error.powi(2)
    }

    fn head(&self) -> String {
        let Stated { asset, estimator, error, .. } = self;
        let head = format!("{:>6} {:>8} {:>10} {:>10} {:>6}", "seed", "passes", "stated", "true", "ratio");
        format!("{asset}, {estimator}, --error {error}\n{head}\n")
    }

    fn verdict(&self) -> String {
        let (honest, all, least) = (self.honest(), self.runs.len(), self.least);
        let verdict = format!("{honest} of {all} runs have a true error of at most {LEEWAY} of the stated one\n");
        if self.is_told() {
            return verdict;
        }
        format!(
            "{verdict}too rough: the references tell no error below {least:.5} from none; they need more \
             --reference-seconds or another --reference-estimator\n"
        )
    }
}

/// Hears a report as it grows: two lines of head, one of each run as it ends, one of all.
pub type Tell<'t> = dyn FnMut(String) + Send + 't;

struct Nobody<'s>(&'s ShouldStop<'s>);
impl Observer for Nobody<'_> {
    fn block(&mut self, _: &Status, _: &Films) -> bool {
        !(self.0)()
    }
}

/// Traces an asset `count` times by the task's first contender until a run states this relative error, or the task's
/// seconds (of the wall) or passes are over.
///
/// Errors: those of import, checking, freezing and of reference files.
pub fn measure(
    path: &Path,
    task: &Task,
    (error, count): (f64, u64),
    stop: &ShouldStop<'_>,
    tell: &mut Tell<'_>,
) -> Result<Stated> {
    let (scene, _) = open(path, task)?;
    measure_scene(&scene, path.display().to_string(), task, (error, count), stop, tell)
}

/// The same for a scene of this name.
///
/// Errors: those of checking, freezing and of reference files.
pub fn measure_scene(
    scene: &Scene,
    asset: String,
    task: &Task,
    (error, count): (f64, u64),
    stop: &ShouldStop<'_>,
    tell: &mut Tell<'_>,
) -> Result<Stated> {
    let ready = Ready::new(scene, 0.0)?;
    let (references, reference) = references(&ready, &task.source, task.seed, stop)?;
    let choice = task.contenders.first().copied().unwrap_or_default();
    let limits = Limits {
        passes: task.budget.passes,
        time: Duration::try_from_secs_f64(task.budget.seconds).ok(),
        error: Some(error),
        adaptive: true,
        coarse: false,
    };
    let plan = plan(&ready.checked, &ready.world, choice);
    let least = references.least_relative_error();
    let mut stated = Stated { asset, estimator: name(choice), error, reference, least, runs: Vec::new() };
    tell(stated.head());
    for run in runs(&ready, &plan, &references, task.seed..task.seed.saturating_add(count), &limits, stop) {
        tell(run.line());
        stated.runs.push(run);
    }
    tell(stated.verdict());
    Ok(stated)
}

/// Traces with these seeds, one after the other.
pub fn runs(
    ready: &Ready<'_>,
    plan: &Plan,
    references: &References,
    seeds: std::ops::Range<u64>,
    limits: &Limits,
    stop: &ShouldStop<'_>,
) -> impl Iterator<Item = Run> {
    let (size, groups) = (ready.scene().eye.resolution, ready.scene().groups.len());
    let one = move |seed| {
        let films = run(&ready.world, plan, groups, size, seed, limits, &mut Nobody(stop)).films;
        let real = references.relative_error(&Picture::of_films(&films, size));
        Run { seed, passes: films.passes, stated: films.relative_error(), real }
    };
    seeds.take_while(|_| !stop()).map(one)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::reference::Source;
    use crate::{generate, kit};
    use eyebox_film::plan::Estimator;
    use eyebox_plan::Choice;
    use eyebox_scene::Finish;
    use glam::DVec3;

    /// A matt wall under a large lamp.
    fn wall() -> Scene {
        let mut scene = kit::scene(60.0, 10);
        kit::panel(&mut scene, 50.0, kit::quad(DVec3::new(0.0, 3.0, 0.0), DVec3::X * 0.7, DVec3::Z * 0.7));
        let wall = kit::mesh(&[kit::quad(DVec3::new(0.0, 0.0, -2.0), DVec3::X * 3.0, DVec3::Y * 3.0)]);
        let matt = kit::face(Finish::Lambert { reflectance: 0.5, transmittance: 0.0 });
        kit::add(&mut scene, wall, glam::DAffine3::IDENTITY, None, vec![matt]);
        scene
    }

    /// From the eye no path to it is rare, so the true error is the stated one where passes are independent, and where they are
    /// even among themselves, less: that saves half the variance, which twelve passes of so few pixels do not tell.
    #[test]
    fn a_wall_states_its_error() {
        let scene = wall();
        let ready = Ready::new(&scene, 0.0).unwrap();
        let choice = Choice::Only(Estimator::Backward);
        let source = Source::Traced { choice, passes: Some(600), seconds: 1e9 };
        let (references, _) = references(&ready, &source, 1, &|| false).unwrap();
        let plan = plan(&ready.checked, &ready.world, choice);
        let limits = |passes: u64| Limits { passes: Some(passes), ..Limits::default() };
        let all: Vec<Run> = runs(&ready, &plan, &references, 0..12, &limits(12), &|| false).collect();
        assert_eq!(all.len(), 12);
        let ratios: Vec<f64> = all.iter().map(|run| run.real / run.stated.unwrap()).collect();
        let mean = ratios.iter().sum::<f64>() / 12.0;
        assert!((0.55..1.0).contains(&mean), "{ratios:?}");
        assert!(!Run { stated: Some(0.5 * all[0].real), ..all[0] }.is_honest());
        assert!(!Run { stated: None, ..all[0] }.is_honest());

        // Passes of other seeds each.
        let size = scene.eye.resolution;
        let pass = |seed: u64| run(&ready.world, &plan, 1, size, seed, &limits(1), &mut Nobody(&|| false)).films;
        let mixed = (0..12).map(|k| {
            let mut films = pass(100 + 12 * k);
            for seed in 1..12 {
                let more = pass(100 + 12 * k + seed);
                for ((_, film, _), (_, other, _)) in films.films.iter_mut().zip(&more.films) {
                    assert!(film.merge(other));
                }
                films.passes += more.passes;
            }
            references.relative_error(&Picture::of_films(&films, size)) / films.relative_error().unwrap()
        });
        let ratios: Vec<f64> = mixed.collect();
        let mean = ratios.iter().sum::<f64>() / 12.0;
        assert!((0.8..1.2).contains(&mean), "{ratios:?}");
    }

    /// Four passes of a room that they hardly find: what stands in the picture is noise for the most part, and an error that takes it
    /// for light would be two thirds of the true one.
    #[test]
    fn noise_is_no_light() {
        let scene = generate::scene(6);
        let ready = Ready::new(&scene, 0.0).unwrap();
        let choice = Choice::Only(Estimator::Backward);
        let source = Source::Traced { choice, passes: Some(800), seconds: 1e9 };
        let (references, _) = references(&ready, &source, 1, &|| false).unwrap();
        let limits = Limits { passes: Some(4), ..Limits::default() };
        let plan = plan(&ready.checked, &ready.world, choice);
        let runs: Vec<Run> = runs(&ready, &plan, &references, 0..20, &limits, &|| false).collect();
        let ratios: Vec<f64> = runs.iter().filter_map(|run| Some(run.real / run.stated?)).collect();
        assert!(runs.iter().all(|run| run.real > 0.8), "not noisy enough: {runs:?}");
        assert!(ratios.iter().filter(|ratio| **ratio <= LEEWAY).count() >= 18, "{ratios:?}");
        assert!(ratios.iter().sum::<f64>() / 20.0 > 0.7, "{ratios:?}");
    }

    /// How small an error two references tell: as large as what they say of a third of their kind that has no error of its
    /// own to speak of.
    #[test]
    fn rough_references_say_so() {
        let scene = wall();
        let ready = Ready::new(&scene, 0.0).unwrap();
        let choice = Choice::Only(Estimator::Backward);
        let of = |passes: u64, seed: u64| {
            let source = Source::Traced { choice, passes: Some(passes), seconds: 1e9 };
            references(&ready, &source, seed, &|| false).unwrap().0
        };
        let plan = plan(&ready.checked, &ready.world, choice);
        let limits = Limits { passes: Some(4096), ..Limits::default() };
        let films = run(&ready.world, &plan, 1, scene.eye.resolution, 99, &limits, &mut Nobody(&|| false)).films;
        let picture = Picture::of_films(&films, scene.eye.resolution);
        let (mut beyond, mut most) = (0, 0.0f64);
        for seed in 0..40 {
            let references = of(2, 100 + seed);
            let share = references.relative_error(&picture) / references.least_relative_error();
            (beyond, most) = (beyond + u32::from(share > 1.0), most.max(share));
        }
        assert!(beyond <= 4 && most > 0.5, "{beyond} of 40 beyond, {most} the largest");
        assert!(of(200, 7).least_relative_error() < 0.2 * of(2, 7).least_relative_error());
    }
}
