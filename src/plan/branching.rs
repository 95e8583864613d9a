//! How far paths from the eye follow faint branches, how many of them go on at scatterers, and how many there are: a pilot
//! tries, and what has the least variance times work is done. Through a combiner the eye sees a dark road, and in it the
//! bright sky as a ghost of a lens: where chance chooses one way on, one path in a hundred brings all of that.

use super::Making;
use super::pilot::SEED;
use crate::estimate::backward::{Backward, Trial};
use crate::estimate::route::Route;
use crate::estimate::vision::Hints;
use crate::film::plan::{Branching, Estimator, Plan};
use crate::world::mode::Mono;

/// Pixels that each trial looks at, by two paths.
const PLACES: u64 = 256;
/// Shares of a path's light down to which its branches are followed for certain.
const FAINTEST: [f64; 2] = [1.0 / 1024.0, 1.0 / 64.0];
/// Shares of the paths that go on at the first scatterer.
const SCATTERED: [f64; 2] = [1.0 / 4.0, 1.0 / 16.0];
/// How many times less variance times work has to be to depart from what is simple.
const WORTH: f64 = 1.25;
/// Most paths per pixel and pass beside dearer estimators, which cost some tens of times as much as a short path and err more at
/// edges.
pub(super) const MOST: u32 = 4;
/// Relative variance of a pass that is little beside that of such an estimator at edges.
const LITTLE: f64 = 1e-3;

/// What a pilot found.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Branches {
    pub branching: Branching,
    /// How many times less that makes variance times work.
    gain: f64,
    /// Paths of a pixel in a pass beside dearer estimators.
    pub paths: u32,
}

impl Branches {
    /// What a reader of the plan should know.
    pub(super) fn note(&self) -> Option<String> {
        let Branching { faintest, scattered } = self.branching;
        let follows =
            (faintest < 1.0).then(|| format!("follows branches with 1/{:.0} of a path's light", 1.0 / faintest));
        let goes_on = (scattered < 1.0).then(|| format!("goes on at 1 scatterer in {:.0}", 1.0 / scattered));
        let says: Vec<String> = follows.into_iter().chain(goes_on).collect();
        let gain = self.gain;
        let all = || format!("backward {}: a pilot found variance × work {gain:.3} times less", says.join(" and "));
        (!says.is_empty()).then(all)
    }
}

/// A way to branch, and how it did.
#[derive(Clone, Copy)]
struct Tried {
    branching: Branching,
    variance: f64,
    work: f64,
}

impl Tried {
    fn cost(&self) -> f64 {
        self.variance * self.work
    }
}

pub(super) fn learn(making: &Making<'_>, plan: &Plan) -> Branches {
    let trial = |branching: Branching| {
        let route = Route::new(plan, making.groups(), Estimator::Backward);
        let backward = Backward::<Mono>::new(making.world, route, (1, 1.0), Hints::of(plan), SEED);
        backward.branching(branching).trial(PLACES, making.stop)
    };
    let (facts, simple) = (making.checked.facts(), Branching::default());
    let first = trial(simple);
    let finest = facts.specular.then(|| trial(Branching { faintest: FAINTEST[0], ..simple }));
    // What is least noisy tells best how bright the pixels are.
    let pixels = finest.as_ref().unwrap_or(&first).means();
    let tried = |branching: Branching, trial: &Trial| {
        let (variance, work) = (trial.variance(&pixels), trial.work_of_a_path());
        Tried { branching, variance, work }
    };
    let before = tried(simple, &first);
    let mut best = before;
    let mut hold = |next: Tried| {
        if next.cost() * WORTH < best.cost() {
            best = next;
        }
        best.branching
    };
    let mut chosen = simple;
    if let Some(finest) = finest {
        chosen = hold(tried(Branching { faintest: FAINTEST[0], ..simple }, &finest));
        for faintest in FAINTEST.into_iter().skip(1) {
            let branching = Branching { faintest, ..simple };
            chosen = hold(tried(branching, &trial(branching)));
        }
    }
    if facts.scatters {
        for scattered in SCATTERED {
            let branching = Branching { scattered, ..chosen };
            hold(tried(branching, &trial(branching)));
        }
    }
    // Where a trial has seen no light nobody knows how it varies.
    let known = best.variance.is_finite();
    let paths = if known { (best.variance / LITTLE).ceil().clamp(1.0, f64::from(MOST)) as u32 } else { MOST };
    Branches { branching: best.branching, gain: before.cost() / best.cost(), paths }
}
