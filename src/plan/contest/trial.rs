//! A few passes of a small picture by a plan, and what two of them say of their plans' variance × counted work.

use super::Handicap;
use crate::estimate::run::{Films, begin_trial};
use crate::film::plan::{Estimator, Plan};
use crate::plan::{Making, pilot};
use crate::world::World;

/// Longer side of the pilot's picture, pixels.
const SIDE: usize = 32;
/// Counted work after which a trial has seen enough (some 35 ms), and its fewest and most passes.
const WORK: u64 = 1 << 20;
const PASSES: [u64; 2] = [2, 64];
/// Share of the mean luminance that counts as full error where the picture is black, as in `eyebox bench`.
const FLOOR: f64 = 0.01;

/// What a few passes of a plan brought, by estimator.
pub(super) struct Trial {
    /// Per pixel: luminance and its variance, one entry per estimator that ran.
    values: Vec<f64>,
    variances: Vec<(Estimator, Vec<f64>)>,
    /// Counted work of a pass.
    work: Vec<(Estimator, f64)>,
    passes: f64,
    width: usize,
}

/// The pilot's picture.
pub(super) struct Small {
    world: World,
    size: [usize; 2],
    /// Longer side of the real one.
    longer: usize,
    /// Of the pixels of the real one.
    share: f64,
}

impl Small {
    pub(super) fn new(making: &Making<'_>) -> Option<Small> {
        let mut eye = making.checked.scene().eye.clone();
        let [width, height] = eye.resolution;
        let scale = (SIDE as f64 / width.max(height).max(1) as f64).min(1.0);
        let size = [width, height].map(|n| ((n as f64 * scale).round() as usize).max(1));
        eye.resolution = size;
        let share = (size[0] * size[1]) as f64 / (width * height).max(1) as f64;
        Some(Small { world: making.world.seen_by(&eye).ok()?, size, longer: width.max(height), share })
    }

    pub(super) fn trial(&self, making: &Making<'_>, plan: &Plan) -> Trial {
        let mut own = plan.clone();
        if self.share < 1.0 {
            // As many photons within reach of a point as in the real picture.
            let fewer = |paths: u64| ((paths as f64 * self.share).ceil() as u64).max(u64::from(paths > 0));
            (own.forward_paths, own.photons) = (fewer(plan.forward_paths), fewer(plan.photons));
            own.photon_radii_m = plan.photon_radii_m.scaled(self.share.sqrt().recip());
        }
        let mut tracing = begin_trial(
            &self.world,
            &own,
            making.groups(),
            (self.size, self.longer),
            pilot::SEED,
            (making.made.connections(&self.world, plan), making.made.screens(&self.world, &plan.screens)),
        );
        while !tracing.films().films.is_empty() && !making.stopped() {
            let films = tracing.films();
            let work: u64 = films.films.iter().map(|(_, _, ledger)| ledger.work).sum();
            let passes = films.passes;
            if passes >= PASSES[1] || (passes >= PASSES[0] && work >= WORK) {
                break;
            }
            tracing.step(2);
        }
        Trial::of(tracing.films(), self.size)
    }
}

impl Trial {
    fn of(films: &Films, [width, height]: [usize; 2]) -> Trial {
        let pixels = width * height;
        let mut trial = Trial {
            values: vec![0.0; pixels],
            variances: Vec::new(),
            work: Vec::new(),
            passes: films.passes.max(1) as f64,
            width,
        };
        for (estimator, film, ledger) in &films.films {
            let all = film.planes.len();
            for (pixel, value) in trial.values.iter_mut().enumerate() {
                *value += (0..all).map(|plane| film.mean(pixel, plane).value).sum::<f64>();
            }
            trial.variances.push((*estimator, (0..pixels).map(|pixel| film.variance(pixel, all)).collect()));
            trial.work.push((*estimator, ledger.work as f64 / trial.passes));
        }
        trial
    }

    fn variance(&self, pixel: usize, handicap: &Handicap) -> f64 {
        let of = |(estimator, all): &(Estimator, Vec<f64>)| handicap.noise[*estimator as usize] * all[pixel];
        self.variances.iter().map(of).sum()
    }

    fn work(&self, handicap: &Handicap) -> f64 {
        self.work.iter().map(|(estimator, work)| handicap.work[*estimator as usize] * work).sum()
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
pub(super) fn costs(trials: [&Trial; 2], handicap: &Handicap) -> Option<[f64; 2]> {
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
        let (mut stated, mut differs) = (0.0, 0.0);
        for (pixel, smooth) in smooth.iter().enumerate() {
            let reference = trials[knows].values[pixel];
            let scale = smooth.powi(2) + (FLOOR * mean).powi(2);
            stated += trials[one].variance(pixel, handicap) / scale;
            let of_reference = trials[knows].variance(pixel, &plain);
            differs += ((trials[one].values[pixel] - reference).powi(2) - of_reference) / scale;
        }
        let relative = if one == knows { stated } else { stated.max(differs) };
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
