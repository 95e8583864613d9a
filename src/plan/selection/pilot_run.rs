//! A few passes of a small picture by a plan, and what two of them say of their plans' variance × counted work.

use super::Handicap;
use super::tuning::pilot_run::{CLEAR, MARGINS, MOST_EVEN, MOST_WORK, PASSES, RUN, SIDES, SURE, TELL_EVEN, WORK};
use super::verdict::{Compared, FLOOR, judge, smooth};
use crate::pilots::pilot_resolution::PilotResolution;
use crate::{Planner, pilots};
use eyebox_estimate::ledger::Ledger;
use eyebox_estimate::run::{Films, begin_trial};
use eyebox_film::accumulate::Film;
use eyebox_film::layer::Layer;
use eyebox_film::plan::{Estimator, Plan};

/// What a plan's passes brought in both pictures; the fine one is not always asked.
pub(super) struct Tried {
    rough: Trial,
    fine: Option<Trial>,
}

impl Tried {
    /// Whether the light that scatterers get from others or over specular faces stands out of its noise, as it does where it was
    /// found in many passes.
    pub(super) fn surely_sees_scattered(&self) -> bool {
        let [light, variance] = self.fine.as_ref().unwrap_or(&self.rough).scattered();
        light > SURE * variance.sqrt()
    }

    /// None of that light came to any pixel.
    pub(super) fn sees_nothing_scattered(&self) -> bool {
        std::iter::once(&self.rough).chain(&self.fine).all(|trial| trial.scattered()[0] == 0.0)
    }
}

/// The pilot's pictures.
pub(super) struct Trials {
    rough: Small,
    fine: Small,
}

impl Trials {
    pub(super) fn new(making: &Planner<'_>) -> Option<Trials> {
        let [rough, fine] = [0, 1].map(|level| Small::new(making, level));
        Some(Trials { rough: rough?, fine: fine? })
    }

    pub(super) fn start(&self, making: &Planner<'_>, plan: &Plan) -> Tried {
        Tried { rough: self.rough.trial(making, plan), fine: None }
    }

    /// Holds a rival plan against another; none where nothing was seen.
    pub(super) fn compare(
        &self,
        making: &Planner<'_>,
        (plan, tried): (&Plan, &mut Tried),
        (rival, of_rival): (&Plan, &mut Tried),
        handicap: &Handicap,
    ) -> Option<Compared> {
        let rough = judge([&tried.rough, &of_rival.rough], handicap, MARGINS[1]);
        let clear = |ratio: f64| !(CLEAR.recip()..=CLEAR).contains(&ratio);
        if rough.as_ref().is_some_and(|rough| rough.misses.is_some() || clear(rough.ratio)) {
            return rough;
        }
        let larger = self.fine.picture.pixels() / self.rough.picture.pixels();
        let dearest = tried.rough.work(handicap).max(of_rival.rough.work(handicap));
        if rough.is_some() && dearest * larger * PASSES[0] as f64 > MOST_WORK {
            return rough;
        }
        let fine = tried.fine.get_or_insert_with(|| self.fine.trial(making, plan));
        let other = of_rival.fine.get_or_insert_with(|| self.fine.trial(making, rival));
        judge([fine, other], handicap, MARGINS[0])
    }
}

/// What a few passes of a plan brought, by estimator that ran.
pub(super) struct Trial {
    parts: Vec<Part>,
    /// Per pixel: luminance.
    pub values: Vec<f64>,
    pub passes: f64,
    pub width: usize,
}

/// An estimator's part of it.
pub(super) struct Part {
    pub estimator: Estimator,
    /// Per pixel: luminance and its variance.
    pub values: Vec<f64>,
    pub variances: Vec<f64>,
    /// What is left of them in a run, whose passes are even.
    pub left: f64,
    /// Counted work of a pass.
    pub work: f64,
    /// Light of the layers `caustic` and `secondary` in the whole picture, and its variance.
    pub scattered: [f64; 2],
}

/// A small picture of a pilot.
struct Small {
    picture: PilotResolution,
    /// Counted work after which a trial ends.
    work: u64,
}

impl Small {
    fn new(making: &Planner<'_>, level: usize) -> Option<Small> {
        let picture = PilotResolution::new(making.world, &making.checked.scene().eye, SIDES[level]).ok()?;
        Some(Small { picture, work: WORK[level] })
    }

    fn trial(&self, making: &Planner<'_>, plan: &Plan) -> Trial {
        let PilotResolution { world, size, longer, .. } = &self.picture;
        let own = self.picture.plan(plan);
        let begin = |seed: u64| {
            let joined = (making.made.connections(world, plan), making.made.screens(world, &plan.screens));
            begin_trial(world, &own, making.groups(), (*size, *longer), seed, joined)
        };
        let mut tracing = begin(pilots::SEED);
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
        let mut again = begin(pilots::SEED + 1);
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
            let of_scatterers = |plane: &usize| match film.planes[*plane].layer {
                Layer::Caustic | Layer::Secondary => true,
                Layer::Direct | Layer::Forward => false,
            };
            let scattered: Vec<usize> = (0..all).filter(of_scatterers).collect();
            let over = |of: &dyn Fn(usize, usize) -> f64| {
                let pixel = |pixel: usize| scattered.iter().map(|plane| of(pixel, *plane)).sum::<f64>();
                (0..pixels).map(pixel).sum::<f64>()
            };
            let light = |pixel: usize, plane: usize| film.mean(pixel, plane).value;
            let variance = |pixel: usize, plane: usize| film.variance(pixel, plane);
            Part {
                scattered: [over(&light), over(&variance)],
                estimator: *estimator,
                values: (0..pixels).map(value).collect(),
                variances: (0..pixels).map(|pixel| film.variance(pixel, all)).collect(),
                left: 1.0,
                work: ledger.work as f64 / passes,
            }
        };
        Trial::new(films.films.iter().map(part).collect(), pixels, passes, width)
    }

    pub(super) fn new(parts: Vec<Part>, pixels: usize, passes: f64, width: usize) -> Trial {
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
                scattered: [0.5 * (a.scattered[0] + b.scattered[0]), 0.25 * (a.scattered[1] + b.scattered[1])],
            }
        };
        let parts = self.parts.iter().zip(&other.parts).map(part).collect();
        Trial::new(parts, pixels, passes + other.passes, self.width)
    }

    /// [`Part::scattered`] of all parts.
    fn scattered(&self) -> [f64; 2] {
        let add = |[light, variance]: [f64; 2], part: &Part| [light + part.scattered[0], variance + part.scattered[1]];
        self.parts.iter().fold([0.0; 2], add)
    }

    pub(super) fn variance(&self, pixel: usize, handicap: &Handicap) -> f64 {
        self.parts.iter().map(|part| handicap.noise[part.estimator as usize] * part.variances[pixel]).sum()
    }

    /// The same in a run of as many passes that go on from others.
    pub(super) fn variance_left(&self, pixel: usize, handicap: &Handicap) -> f64 {
        let of = |part: &Part| handicap.noise[part.estimator as usize] * part.left * part.variances[pixel];
        self.parts.iter().map(of).sum()
    }

    pub(super) fn work(&self, handicap: &Handicap) -> f64 {
        self.parts.iter().map(|part| handicap.work[part.estimator as usize] * part.work).sum()
    }

    /// Sum of the pixels of a part of the picture, and its standard error.
    pub(super) fn light(&self, within: &dyn Fn(usize) -> bool) -> (f64, f64) {
        let pixels = || (0..self.values.len()).filter(|pixel| within(*pixel));
        let variance = pixels().map(|pixel| self.variance(pixel, &Handicap::default())).sum::<f64>();
        (pixels().map(|pixel| self.values[pixel]).sum(), variance.sqrt())
    }
}
