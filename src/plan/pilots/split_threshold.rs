//! How far paths from the eye follow faint branches, and how many paths there are: a pilot tries, and what has the least
//! variance times work is done. Through a combiner the eye sees a dark road, and in it the bright sky as a ghost of a lens:
//! where chance chooses one way on, one path in a hundred brings all of that.

use super::SEED;
pub(crate) use super::tuning::split_threshold::MOST;
use super::tuning::split_threshold::{FAINTEST, LITTLE, PASSES, PASSES_OF_SCALE, PLACES, WORTH};
use crate::Planner;
use eyebox_estimate::backward::Backward;
use eyebox_estimate::ownership::Ownership;
use eyebox_estimate::vision::Hints;
use eyebox_film::plan::{Estimator, Plan};
use eyebox_world::mode::Mono;

/// What a pilot found.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Branches {
    /// [`Plan::faintest_branch`].
    pub faintest: f64,
    /// How many times less that makes variance times work.
    gain: f64,
    /// Paths of a pixel in a pass beside dearer estimators.
    pub paths: u32,
}

impl Branches {
    /// What a reader of the plan should know.
    pub(crate) fn note(&self) -> Option<String> {
        (self.faintest < 1.0).then(|| {
            format!(
                "backward follows branches down to 1/{:.0} of a path's light: in a pilot run that cost {:.3} times less (variance × work)",
                1.0 / self.faintest,
                self.gain
            )
        })
    }
}

/// Of what plans differ in, only the paths that backward computes matter, and through which windows it sees the sky.
pub(crate) fn learn(making: &Planner<'_>, plan: &Plan) -> Branches {
    let trial = |faintest: f64, passes: [u64; 2]| {
        let route = Ownership::new(plan, making.groups(), Estimator::Backward);
        let hints = Hints::of_sky(plan.sky_guide.as_ref());
        let backward = Backward::<Mono>::new(making.world, route, (1, 1.0), hints, SEED);
        backward.branching(faintest).trial(PLACES, passes, making.stop)
    };
    let ways = if making.checked.facts().specular { &FAINTEST[..] } else { &[] };
    // What is least noisy tells best how bright the pixels are, by paths that no way is judged by.
    let pixels = trial(ways.first().copied().unwrap_or(1.0), PASSES_OF_SCALE).means();
    // Relative variance and its product with the work.
    let judge = |faintest: f64| {
        let trial = trial(faintest, PASSES);
        let variance = trial.variance(&pixels);
        (variance, variance * trial.work_of_a_path())
    };
    let (mut faintest, (mut variance, before)) = (1.0, judge(1.0));
    let mut least = before;
    for way in ways {
        let (varies, cost) = judge(*way);
        if cost * WORTH < least {
            (faintest, variance, least) = (*way, varies, cost);
        }
    }
    // Where a trial has seen no light nobody knows how it varies.
    let known = variance.is_finite();
    let paths = if known { (variance / LITTLE).ceil().clamp(1.0, f64::from(MOST)) as u32 } else { MOST };
    Branches { faintest, gain: before / least, paths }
}
