//! A few passes of a small picture by a plan, and what two of them say of their plans' variance × counted work.

use super::Handicap;
use crate::estimate::ledger::Ledger;
use crate::estimate::run::{Films, begin_trial};
use crate::film::accumulate::Film;
use crate::film::plan::{Estimator, Plan};
use crate::plan::shrunk::Shrunk;
use crate::plan::{Making, pilot};

/// Longer sides of the pilot's pictures, pixels: a rough one, and a fine one for what that leaves open.
const SIDES: [usize; 2] = [12, 32];
/// Counted work after which a trial has seen enough (some 10 ms and 35 ms), and its fewest and most passes.
const WORK: [u64; 2] = [1 << 18, 1 << 20];
const PASSES: [u64; 2] = [2, 64];
/// Passes from which on a second trial of as many tells what even points save; of a run for which it is taken, and most of it.
const TELL_EVEN: u64 = 4;
const RUN: f64 = 64.0;
const MOST_EVEN: f64 = 0.125;
/// Counted work that the fewest passes of a fine picture may be, or the rough one has to do.
const MOST_WORK: f64 = 4.0 * WORK[1] as f64;
/// How many times the variance × work has to differ in the rough picture for the fine one not to be asked.
const CLEAR: f64 = 8.0;
/// How much better a rival must be than what facts say, by a fine and by a rough picture: a pilot is not exact.
const MARGINS: [f64; 2] = [1.25, 2.0];
/// Share of the mean luminance that counts as full error where the picture is black, as in `eyebox bench`.
const FLOOR: f64 = 0.01;

/// What a plan's passes brought in both pictures; the fine one is not always asked.
pub(super) struct Tried {
    rough: Trial,
    fine: Option<Trial>,
}

/// The pilot's pictures.
pub(super) struct Trials {
    rough: Small,
    fine: Small,
}

/// What a comparison of two plans says.
pub(super) struct Compared {
    /// The rival's variance × work over that of the other.
    pub ratio: f64,
    /// Whether it is enough for the rival.
    pub wins: bool,
}

impl Trials {
    pub(super) fn new(making: &Making<'_>) -> Option<Trials> {
        let [rough, fine] = [0, 1].map(|level| Small::new(making, level));
        Some(Trials { rough: rough?, fine: fine? })
    }

    pub(super) fn start(&self, making: &Making<'_>, plan: &Plan) -> Tried {
        Tried { rough: self.rough.trial(making, plan), fine: None }
    }

    /// Holds a rival plan against another; none where nothing was seen.
    pub(super) fn compare(
        &self,
        making: &Making<'_>,
        (plan, tried): (&Plan, &mut Tried),
        (rival, of_rival): (&Plan, &mut Tried),
        handicap: &Handicap,
    ) -> Option<Compared> {
        let compared = |of: [&Trial; 2], margin: f64| {
            let [own, other] = costs(of, handicap)?;
            Some(Compared { ratio: other / own, wins: other * margin < own })
        };
        let rough = compared([&tried.rough, &of_rival.rough], MARGINS[1]);
        let clear = |ratio: f64| !(CLEAR.recip()..=CLEAR).contains(&ratio);
        if rough.as_ref().is_some_and(|rough| clear(rough.ratio)) {
            return rough;
        }
        let larger = self.fine.picture.pixels() / self.rough.picture.pixels();
        let dearest = tried.rough.work(handicap).max(of_rival.rough.work(handicap));
        if rough.is_some() && dearest * larger * PASSES[0] as f64 > MOST_WORK {
            return rough;
        }
        let fine = tried.fine.get_or_insert_with(|| self.fine.trial(making, plan));
        let other = of_rival.fine.get_or_insert_with(|| self.fine.trial(making, rival));
        compared([fine, other], MARGINS[0])
    }
}

/// What a few passes of a plan brought, by estimator that ran.
struct Trial {
    parts: Vec<Part>,
    /// Per pixel: luminance.
    values: Vec<f64>,
    passes: f64,
    width: usize,
}

/// An estimator's part of it.
struct Part {
    estimator: Estimator,
    /// Per pixel: luminance and its variance.
    values: Vec<f64>,
    variances: Vec<f64>,
    /// What is left of them in a run, whose passes are even.
    left: f64,
    /// Counted work of a pass.
    work: f64,
}

/// A small picture of a pilot.
struct Small {
    picture: Shrunk,
    /// Counted work after which a trial ends.
    work: u64,
}

impl Small {
    fn new(making: &Making<'_>, level: usize) -> Option<Small> {
        let picture = Shrunk::new(making.world, &making.checked.scene().eye, SIDES[level]).ok()?;
        Some(Small { picture, work: WORK[level] })
    }

    fn trial(&self, making: &Making<'_>, plan: &Plan) -> Trial {
        let Shrunk { world, size, longer, .. } = &self.picture;
        let own = self.picture.plan(plan);
        let begin = |seed: u64| {
            let joined = (making.made.connections(world, plan), making.made.screens(world, &plan.screens));
            begin_trial(world, &own, making.groups(), (*size, *longer), seed, joined)
        };
        let mut tracing = begin(pilot::SEED);
        while !tracing.films().films.is_empty() && !making.stopped() {
            let films = tracing.films();
            let work: u64 = films.films.iter().map(|(_, _, ledger)| ledger.work).sum();
            let passes = films.passes;
            if passes >= PASSES[1] / 2 || (passes >= PASSES[0] && work >= self.work / 2) {
                break;
            }
            tracing.step(2);
        }
        let first = Trial::of(tracing.films(), *size);
        let passes = tracing.films().passes;
        if passes < TELL_EVEN || making.stopped() {
            return first;
        }
        let mut again = begin(pilot::SEED + 1);
        again.step(passes);
        first.and(&Trial::of(again.films(), *size))
    }
}

impl Trial {
    fn of(films: &Films, [width, height]: [usize; 2]) -> Trial {
        let pixels = width * height;
        let passes = films.passes.max(1) as f64;
        let part = |(estimator, film, ledger): &(Estimator, Film, Ledger)| {
            let all = film.planes.len();
            let value = |pixel| (0..all).map(|plane| film.mean(pixel, plane).value).sum();
            Part {
                estimator: *estimator,
                values: (0..pixels).map(value).collect(),
                variances: (0..pixels).map(|pixel| film.variance(pixel, all)).collect(),
                left: 1.0,
                work: ledger.work as f64 / passes,
            }
        };
        Trial::new(films.films.iter().map(part).collect(), pixels, passes, width)
    }

    fn new(parts: Vec<Part>, pixels: usize, passes: f64, width: usize) -> Trial {
        let value = |pixel: usize| parts.iter().map(|part| part.values[pixel]).sum();
        Trial { values: (0..pixels).map(value).collect(), parts, passes, width }
    }

    /// Both trials of a plan together. They differ by less than they state where points are even over passes: so much
    /// less, in a run, is the variance.
    fn and(self, other: &Trial) -> Trial {
        let pixels = self.values.len();
        let both: Vec<f64> = self.values.iter().zip(&other.values).map(|(a, b)| 0.5 * (a + b)).collect();
        let mean = both.iter().sum::<f64>() / pixels.max(1) as f64;
        let smooth = smooth(&both, self.width);
        let passes = self.passes;
        let part = |(a, b): (&Part, &Part)| {
            let (mut states, mut differs) = (0.0, 0.0);
            for (pixel, smooth) in smooth.iter().enumerate() {
                let scale = smooth.powi(2) + (FLOOR * mean).powi(2);
                states += (a.variances[pixel] + b.variances[pixel]) / scale;
                differs += (a.values[pixel] - b.values[pixel]).powi(2) / scale;
            }
            let saves = if differs < states { (differs / states).powf((RUN.ln() / passes.ln()).max(1.0)) } else { 1.0 };
            let of = |a: &[f64], b: &[f64], factor: f64| a.iter().zip(b).map(|(a, b)| factor * (a + b)).collect();
            Part {
                estimator: a.estimator,
                values: of(&a.values, &b.values, 0.5),
                variances: of(&a.variances, &b.variances, 0.25),
                left: saves.max(MOST_EVEN),
                work: 0.5 * (a.work + b.work),
            }
        };
        let parts = self.parts.iter().zip(&other.parts).map(part).collect();
        Trial::new(parts, pixels, passes + other.passes, self.width)
    }

    fn variance(&self, pixel: usize, handicap: &Handicap) -> f64 {
        self.parts.iter().map(|part| handicap.noise[part.estimator as usize] * part.variances[pixel]).sum()
    }

    /// The same in a run of as many passes that go on from others.
    fn variance_left(&self, pixel: usize, handicap: &Handicap) -> f64 {
        let of = |part: &Part| handicap.noise[part.estimator as usize] * part.left * part.variances[pixel];
        self.parts.iter().map(of).sum()
    }

    fn work(&self, handicap: &Handicap) -> f64 {
        self.parts.iter().map(|part| handicap.work[part.estimator as usize] * part.work).sum()
    }

    /// Sum of the picture and its standard error.
    fn light(&self) -> (f64, f64) {
        let variance = (0..self.values.len()).map(|pixel| self.variance(pixel, &Handicap::default())).sum::<f64>();
        (self.values.iter().sum(), variance.sqrt())
    }
}

/// Variance of a pass, relative to the picture, times its work, for each of two trials of the same scene; none where
/// nothing was seen.
///
/// What a trial has not found states no variance. So the picture of the one that knows more is held against the other's,
/// and their difference counts where it is larger than what is stated.
fn costs(trials: [&Trial; 2], handicap: &Handicap) -> Option<[f64; 2]> {
    let pixels = trials[0].values.len();
    let light = trials.map(Trial::light);
    // One that surely misses light of the other's knows less; else the smoother one knows more.
    let misses = |one: usize| light[one].0 + 3.0 * light[one].1 < light[1 - one].0 - 3.0 * light[1 - one].1;
    let knows = match (misses(0), misses(1)) {
        (true, _) => 1,
        (_, true) => 0,
        (false, false) => usize::from(light[1].1 < light[0].1),
    };
    let mean = light[knows].0 / pixels.max(1) as f64;
    if !(mean > 0.0 && mean.is_finite()) {
        return None;
    }
    // A pixel that is dark by chance would weigh as much as a dark one.
    let smooth = smooth(&trials[knows].values, trials[knows].width);
    let plain = Handicap::default();
    let cost = |one: usize| {
        let (mut left, mut stated, mut differs) = (0.0, 0.0, 0.0);
        for (pixel, smooth) in smooth.iter().enumerate() {
            let reference = trials[knows].values[pixel];
            let scale = smooth.powi(2) + (FLOOR * mean).powi(2);
            left += trials[one].variance_left(pixel, handicap) / scale;
            stated += trials[one].variance(pixel, handicap) / scale;
            let of_reference = trials[knows].variance(pixel, &plain);
            differs += ((trials[one].values[pixel] - reference).powi(2) - of_reference) / scale;
        }
        // These few passes differ as they state; what evenness saves shows in a run.
        let relative = if one == knows { left } else { left + (differs - stated).max(0.0) };
        relative / pixels as f64 * trials[one].passes * trials[one].work(handicap)
    };
    Some([cost(0), cost(1)])
}

/// Means over each pixel and its neighbours.
fn smooth(values: &[f64], width: usize) -> Vec<f64> {
    let height = values.len() / width.max(1);
    let around = |pixel: usize| {
        let (x, y) = (pixel % width, pixel / width);
        let rows = y.saturating_sub(1)..(y + 2).min(height);
        let columns = x.saturating_sub(1)..(x + 2).min(width);
        let count = rows.len() * columns.len();
        let sum: f64 = rows.flat_map(|j| columns.clone().map(move |i| values[j * width + i])).sum();
        sum / count as f64
    };
    (0..values.len()).map(around).collect()
}
