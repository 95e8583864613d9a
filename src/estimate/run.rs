//! Runs the estimators that a plan asks for, block of passes by block of passes, until told to stop.
//!
//! Sums go into the films pass by pass in one order, so neither the thread count nor where a block ends changes a bit;
//! the clock only decides after which pass to stop.

mod adaptive;
mod drive;
mod engines;
mod outlook;
mod tuning;

use super::ledger::Ledger;
pub use drive::{drive, run};
pub use engines::{begin, begin_trial};
use eyebox_base::memory::give_back;
use eyebox_base::parallel;
use eyebox_base::stats::{beyond_noise, variance_ratio};
use eyebox_film::accumulate::{Film, Saved};
use eyebox_film::guide::ApertureGuide;
use eyebox_film::plan::Estimator;
use eyebox_film::witness::{Judgement, Witness, judge};
pub use outlook::HoldUp;
use std::time::Duration;
pub use tuning::run::LEEWAY;
use tuning::run::MISSED;

/// The normal quantile of 49 in 50. Nine in ten runs are to be honest, and those that stop at what they state are more often those
/// that state too little: with 19 in 20, 56 of 60 on A2 (`--error 0.1`) were.
const Z_OF_98: f64 = 2.053_748_911;

/// When to stop. The first limit that is reached counts.
#[derive(Debug, Clone, Default)]
pub struct Limits {
    pub passes: Option<u64>,
    pub time: Option<Duration>,
    /// Relative error, see [`Films::relative_error`].
    pub error: Option<f64>,
    /// Passes go to where the error is, where no number of them is asked for.
    pub adaptive: bool,
    /// Where passes go to where the error is, the first one goes from coarse to fine, so that it may end in between.
    pub coarse: bool,
}

/// Why a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Stop {
    Passes,
    Time,
    Error,
    /// The error that was asked for is out of reach: no other limit was given, and it would take too much work.
    TooFar,
    /// The observer asked for it (Ctrl-C).
    Asked,
}

/// The state of a run, for progress.
#[derive(Debug, Clone, Copy)]
pub struct Status {
    pub passes: u64,
    pub elapsed: Duration,
    /// Estimate of the relative error; none before there is one.
    pub error: Option<f64>,
    /// Eye and lamp paths so far.
    pub paths: u64,
    /// The work has doubled since the last time that this was said. Depends on no clock.
    pub doubled: bool,
}

/// Watches a run. Called between blocks.
pub trait Observer {
    /// Returns false to stop after this block.
    fn block(&mut self, status: &Status, films: &Films) -> bool;
}

/// Nobody watches.
impl Observer for () {
    fn block(&mut self, _: &Status, _: &Films) -> bool {
        true
    }
}

/// Films and ledgers of the estimators that ran.
pub struct Films {
    pub films: Vec<(Estimator, Film, Ledger)>,
    /// Number of the first pass: a shard starts later than 0.
    pub first: u64,
    /// Passes in the films: the most that a pixel has.
    pub passes: u64,
    /// Where pixels have passes of their own, how these were dealt out so far.
    pub dealt: Dealt,
    /// What a witness saw, if one was asked for.
    pub witness: Option<Witness>,
}

/// How far passes were dealt out to where the error is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
pub struct Dealt {
    /// Rounds that were begun.
    pub rounds: u64,
    /// Passes beside which a witness had its turn, those of one number of several films or rounds counted apart.
    pub attended: u64,
}

/// Everything a run leaves.
pub struct Outcome {
    pub films: Films,
    pub stop: Stop,
    pub elapsed: Duration,
}

impl Films {
    /// The relative error that a run states: [`Films::relative_noise`], and where few pixels have most of the variance, the
    /// squared error of a run is often larger than its mean. Then this is as much larger as it takes for [`LEEWAY`] times it to
    /// cover 49 in 50 of them. The pixels' sum counts as χ² of (Σv)²/Σv² degrees of freedom (F. E. Satterthwaite, Biometrics
    /// Bulletin 2, 1946), and what is known of it by n passes as one of n − 1 times as many. What gathering
    /// photons within a radius blurs is no noise: it is told apart (`film::blur`) and added. None before the second pass, for a
    /// black picture, or for one that is nothing but noise.
    pub fn relative_error(&self) -> Option<f64> {
        let sums = self.noise()?;
        let (noise, signal) = likely_noise(&sums)?;
        Some(((noise + self.blur2()) / signal + self.missed(&sums).powi(2)).sqrt())
    }

    /// The part of [`Films::relative_error`] that falls as the root of the passes, but for what few passes do not know of it.
    pub fn relative_error_of_noise(&self) -> Option<f64> {
        self.noise().as_ref().and_then(likely_noise).map(|(noise, signal)| (noise / signal).sqrt())
    }

    /// The sum over the pixels of squared errors, (cd/m²)², with which [`Films::relative_error`] would be `error`. Where what
    /// gathering blurs hides that, a quarter of what it is.
    fn goal(&self, error: f64) -> Option<f64> {
        let sums = self.noise()?;
        let (noise, (likely, signal)) = (sums.noise, likely_noise(&sums)?);
        let missed = self.missed(&sums).min(error * MISSED);
        let wanted = ((error * error - missed * missed) * signal - self.blur2()) * (noise / likely);
        Some(if wanted > 0.0 { wanted } else { noise / 4.0 })
    }

    /// Sum over the pixels of the squared error that gathering within a radius makes, (cd/m²)²; 0 where noise hides it.
    fn blur2(&self) -> f64 {
        let blurred = self.films.iter().map(|(_, film, _)| film).filter(|film| film.has_blur());
        let of_film = |film: &Film| (0..film.width * film.height).map(|pixel| film.blur2(pixel)).sum::<f64>();
        blurred.map(of_film).sum::<f64>().max(0.0)
    }

    /// Root of (sum of the variances of all pixels' luminance) over (sum of their squares without noise): the noise's share
    /// of the picture. None where [`Films::relative_error`] is none.
    pub fn relative_noise(&self) -> Option<f64> {
        let Noise { noise, seen, .. } = self.noise()?;
        Some((noise / beyond_noise(noise, seen)?).sqrt())
    }

    /// Of the picture's light, what rays from the eye have missed at the most, a quarter of it: see [`eyebox_film::unseen`].
    fn missed(&self, sums: &Noise) -> f64 {
        let most = self.films.iter().map(|(_, film, _)| film.missed()).sum::<f64>();
        if most > 0.0 { most / sums.light } else { 0.0 }
    }

    /// Passes that every pixel of a film is to have, for that to leave room for a relative error; without one, for it to be less than
    /// half of what is stated.
    fn passes_to_miss_less(&self, film: &Film, error: Option<f64>) -> u64 {
        let (Some(sums), Some(unseen)) = (self.noise(), film.unseen()) else { return 0 };
        let error = error.or_else(|| self.relative_error()).unwrap_or(0.0);
        if error > 0.0 { unseen.passes_for(error * MISSED * sums.light) } else { 0 }
    }

    /// What rays will have missed at the most after so many passes of a picture of which this is `share`, of its light; 0 for a black one.
    pub fn missed_after(&self, passes: u64, share: f64) -> f64 {
        let light = self.noise().map_or(0.0, |sums| sums.light / share);
        let most: f64 = self.films.iter().map(|(_, film, _)| film.unseen().map_or(0.0, |own| own.light(passes))).sum();
        if light > 0.0 { most / light } else { 0.0 }
    }

    /// From the second pass on: whether there is any light, be it all noise of which no error is stated yet.
    pub fn has_light(&self) -> bool {
        self.noise().is_some()
    }

    /// Sums over the pixels. None before the second pass or for a black picture.
    ///
    /// Where each pixel goes through points that are even over the passes, what that saves is found in the whole picture.
    fn noise(&self) -> Option<Noise> {
        let (_, first, _) = self.films.first()?;
        let known = |(estimator, film, _): &(Estimator, Film, Ledger)| (saved(*estimator, film), film.doubts());
        let known: Vec<(Saved, Option<Vec<f64>>)> = self.films.iter().map(known).collect();
        // Rows side by side, summed in their order whatever thread made them.
        let of_row = |row: usize| {
            let mut sums = Noise::default();
            for pixel in row * first.width..(row + 1) * first.width {
                let (mut value, mut variance) = (0.0, 0.0);
                for ((_, film, _), (saved, doubts)) in self.films.iter().zip(&known) {
                    value += (0..film.planes.len()).map(|plane| film.mean(pixel, plane).value).sum::<f64>();
                    let of_film = saved.of(film.passes_of(pixel)) * film.variance(pixel, film.planes.len());
                    let of_film = of_film.max(doubts.as_ref().map_or(0.0, |doubts| doubts[pixel]));
                    variance += of_film;
                    sums.unknown += of_film * of_film / film.freedom_of(pixel) as f64;
                }
                sums.add(&Noise {
                    noise: variance,
                    squares: variance * variance,
                    unknown: 0.0,
                    seen: value * value,
                    light: value,
                });
            }
            sums
        };
        let rows: Vec<Noise> = parallel::map(first.height, &of_row);
        let mut sums = Noise::default();
        rows.iter().for_each(|row| sums.add(row));
        (self.passes >= 2 && sums.seen > 0.0).then_some(sums)
    }

    /// Eye and lamp paths so far.
    fn paths(&self) -> u64 {
        self.films.iter().fold(0, |sum, (_, _, ledger)| sum.saturating_add(ledger.paths))
    }

    /// After the last pass, when the errors have been asked for: gives the memory back that only they need.
    pub fn condense(&mut self) {
        self.films.iter_mut().for_each(|(_, film, _)| film.condense());
        give_back();
    }

    /// Gives the memory of all sums back: what was counted stays, and no light.
    pub fn forget_light(&mut self) {
        self.films.iter_mut().for_each(|(_, film, _)| film.forget_light());
        give_back();
    }

    /// What the witness says of the films, if there is one.
    pub fn judgement(&self) -> Option<Judgement> {
        let films: Vec<&Film> = self.films.iter().map(|(_, film, _)| film).collect();
        self.witness.as_ref().map(|witness| judge(witness, &films))
    }

    /// The ledger of one estimator, if it ran.
    pub fn ledger(&self, estimator: Estimator) -> Option<&Ledger> {
        self.films.iter().find(|(e, _, _)| *e == estimator).map(|(_, _, ledger)| ledger)
    }
}

/// Sums over the pixels of a picture.
#[derive(Debug, Clone, Copy, Default)]
struct Noise {
    /// Variance of the luminance, (cd/m²)², its square, and that over the degrees of freedom that tell it.
    noise: f64,
    squares: f64,
    unknown: f64,
    /// Luminance squared, and luminance, cd/m².
    seen: f64,
    light: f64,
}

impl Noise {
    fn add(&mut self, more: &Noise) {
        self.noise += more.noise;
        self.squares += more.squares;
        self.unknown += more.unknown;
        self.seen += more.seen;
        self.light += more.light;
    }
}

/// Of what [`Films::noise`] says: squared error as large as it is likely to be by chance, and luminance squared.
fn likely_noise(sums: &Noise) -> Option<(f64, f64)> {
    let Noise { noise, squares, unknown, seen, .. } = *sums;
    let freedom = |squares: f64| if squares > 0.0 { (noise * noise / squares).max(1.0) } else { f64::INFINITY };
    let most = (variance_ratio(freedom(squares), freedom(unknown), Z_OF_98) / (LEEWAY * LEEWAY)).max(1.0);
    Some((noise * most, beyond_noise(noise, seen)?))
}

/// What evenness over the passes leaves of a film's variance.
fn saved(estimator: Estimator, film: &Film) -> Saved {
    match estimator {
        Estimator::Backward | Estimator::Manifold => film.saved_by_evenness(),
        // What all pixels have of the same photons does not tell as much as so many pixels would; scrambles know by themselves.
        Estimator::Forward | Estimator::Photon => Saved::NOTHING,
    }
}

/// A run that its caller drives: films that grow pass by pass.
pub trait Tracing: Send {
    /// Makes `count` passes more.
    fn step(&mut self, count: u64);
    fn films(&self) -> &Films;
    /// Makes the first pass of one part of the pixels, the parts from coarse to fine; of all that is traced for the picture as a
    /// whole with the first part. Returns how many parts are left.
    fn sweep(&mut self, part: usize) -> usize;
    /// Wants passes for another round of them, where they lessen the error most; `error`: what is to be reached.
    fn aim(&mut self, error: Option<f64>);
    /// How many passes the estimator whose turn it is still wants.
    fn missing(&self) -> Option<u64>;
    /// Makes so many of these.
    fn fill(&mut self, count: u64);
    /// Has a witness look beside every pass from now on. `guide`: where in the pupil lamps are seen, if that is known.
    fn watch(&mut self, guide: Option<&ApertureGuide>);
    /// Starts from pass `first`, or goes on from films that such a run has left. False if they are of another run.
    fn start(&mut self, from: Start) -> bool;
    fn into_films(self: Box<Self>) -> Films;
}

/// Where a run begins.
pub enum Start {
    /// At the pass of this number.
    Pass(u64),
    /// After these.
    Films(Box<Films>),
}
