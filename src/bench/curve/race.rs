//! The estimators trace in turn, a fraction of a second each, so that whatever else the machine does meets all alike.

use super::cells::Batches;
use super::error::References;
use super::fit::{reach, slope};
use super::picture::Picture;
use super::{Curve, LEVELS, Point, name};
use crate::clock::cpu_seconds;
use eyebox_base::Result;
use eyebox_check::{Checked, check};
use eyebox_estimate::ShouldStop;
use eyebox_estimate::run::{Tracing, begin};
use eyebox_film::plan::{Estimator, Plan};
use eyebox_plan::{Choice, plan};
use eyebox_scene::Scene;
use eyebox_world::World;

/// CPU seconds of a turn.
const TURN: f64 = 0.25;

/// When a contender has had enough.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Budget {
    /// CPU seconds of tracing per contender; at least one pass is made.
    pub seconds: f64,
    /// Passes per contender; none: as many as the seconds allow.
    pub passes: Option<u64>,
}

/// A scene before the plan.
pub struct Ready<'s> {
    pub checked: Checked<'s>,
    pub world: World,
    /// CPU seconds of import, checking and freezing.
    pub seconds: f64,
}

impl<'s> Ready<'s> {
    /// Checks and freezes; `import_seconds` is what the scene has cost already.
    ///
    /// Errors: those of checking and freezing.
    pub fn new(scene: &'s Scene, import_seconds: f64) -> Result<Ready<'s>> {
        let start = cpu_seconds();
        let (checked, world) = (check(scene)?, World::freeze(scene)?);
        Ok(Ready { checked, world, seconds: import_seconds + cpu_seconds() - start })
    }

    pub fn scene(&self) -> &'s Scene {
        self.checked.scene()
    }
}

/// One that runs.
struct Runner<'r> {
    choice: Choice,
    plan: &'r Plan,
    tracing: Box<dyn Tracing + 'r>,
    setup_seconds: f64,
    seconds: f64,
    points: Vec<Point>,
    batches: Batches,
    done: bool,
}

impl Runner<'_> {
    fn passes(&self) -> u64 {
        self.tracing.films().passes
    }

    fn paths(&self) -> u64 {
        self.tracing.films().films.iter().map(|(_, _, ledger)| ledger.paths).sum()
    }

    /// One turn: passes up to the next point, or for a quarter of a second.
    fn turn(&mut self, budget: Budget, references: &References, size: [usize; 2]) {
        let next = self.points.last().map_or(1, |point| point.passes.saturating_mul(2));
        let most = budget.passes.unwrap_or(u64::MAX).min(next);
        let begun = self.seconds;
        while self.passes() < most && self.seconds < budget.seconds.min(begun + TURN) {
            // As many passes at once as a tenth of a turn takes: asking for the time is not free either.
            let rate = self.passes() as f64 / self.seconds.max(1e-9);
            let end = most.min(self.batches.next());
            let count = ((0.1 * TURN * rate) as u64).clamp(1, end - self.passes());
            let start = cpu_seconds();
            self.tracing.step(count);
            self.seconds += cpu_seconds() - start;
            // Where batches end is no matter of the clock.
            if self.passes() == end {
                Picture::of_batches(self.tracing.films(), size, &mut self.batches);
            }
        }
        let spent = self.seconds >= budget.seconds || budget.passes.is_some_and(|passes| self.passes() >= passes);
        if (self.passes() >= next || spent) && self.points.last().is_none_or(|point| point.passes < self.passes()) {
            let error = references.measure(&Picture::of_batches(self.tracing.films(), size, &mut self.batches));
            let (passes, paths) = (self.passes(), self.paths());
            self.points.push(Point { passes, seconds: self.seconds, paths, error });
        }
        self.done = spent;
    }

    fn curve(self, resolution: f64) -> Curve {
        let of = |error: &dyn Fn(&Point) -> Option<f64>| -> Vec<[f64; 2]> {
            self.points.iter().filter_map(|point| Some([point.seconds, error(point)?])).collect()
        };
        let reach_all = |points: &[[f64; 2]]| LEVELS.map(|level| reach(points, self.setup_seconds, level)).to_vec();
        let all = of(&|point| Some(point.error.relmse));
        let flat = of(&|point| point.error.flat);
        let told: Vec<[f64; 2]> = all.iter().copied().filter(|[_, error]| *error > resolution).collect();
        Curve {
            estimator: name(self.choice),
            runs: Estimator::ALL.into_iter().filter(|e| self.plan.runs(*e)).map(Estimator::name).collect(),
            setup_seconds: self.setup_seconds,
            paths_per_second: if self.seconds > 0.0 { self.paths() as f64 / self.seconds } else { 0.0 },
            slope: slope(&told),
            reach: reach_all(&all),
            reach_trimmed: reach_all(&of(&|point| Some(point.error.trimmed))),
            reach_flat: if flat.is_empty() { Vec::new() } else { reach_all(&flat) },
            points: self.points,
        }
    }
}

/// Lets all contenders trace until each has used its budget. `stop` (Ctrl-C) is asked between turns: the curves then
/// end where they are.
pub fn race(
    ready: &Ready<'_>,
    contenders: &[Choice],
    references: &References,
    seed: u64,
    budget: Budget,
    stop: &ShouldStop<'_>,
) -> Vec<Curve> {
    let (size, groups) = (ready.scene().eye.resolution, ready.scene().groups.len());
    let plans: Vec<(Plan, f64)> = contenders
        .iter()
        .map(|choice| {
            let start = cpu_seconds();
            let plan = plan(&ready.checked, &ready.world, *choice);
            (plan, ready.seconds + cpu_seconds() - start)
        })
        .collect();
    let mut runners: Vec<Runner<'_>> = contenders
        .iter()
        .zip(&plans)
        .map(|(choice, (plan, planned))| {
            let start = cpu_seconds();
            let tracing = begin(&ready.world, plan, groups, size, seed);
            let setup_seconds = planned + cpu_seconds() - start;
            let done = tracing.films().films.is_empty();
            let (points, batches) = (Vec::new(), Batches::default());
            Runner { choice: *choice, plan, tracing, setup_seconds, seconds: 0.0, points, batches, done }
        })
        .collect();
    while runners.iter().any(|runner| !runner.done) && !stop() {
        for runner in runners.iter_mut().filter(|runner| !runner.done) {
            runner.turn(budget, references, size);
        }
    }
    let resolution = references.resolution();
    runners.into_iter().map(|runner| runner.curve(resolution)).collect()
}
