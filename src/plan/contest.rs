//! Where facts leave it open who should trace, a pilot decides: every way that comes into question makes a few passes of
//! a small picture, and the one with the least variance × counted work wins.

use super::{Making, connect, lamps_over_eye, own};
use crate::base::path::Class;
use crate::estimate::run::{Films, begin_trial};
use crate::film::plan::{Estimator, Plan, Row, Verdict};
use crate::world::World;
use std::collections::BTreeSet;

/// Ratios of the lamps' etendue to the eye's below which each point of the picture has few ways to a lamp, and above which
/// rays from the eye can't miss them. Between them a pilot decides.
const OPEN: [f64; 2] = [8.0, 1e5];
/// Lamps that fill less than this of the scene's cross-section are too small for rays from the eye, wherever they look.
const SMALL: f64 = 3e-4;
/// Longer side of the pilot's picture, pixels.
const SIDE: usize = 32;
/// Counted work after which a trial has seen enough (some 35 ms), and its fewest and most passes.
const WORK: u64 = 1 << 20;
const PASSES: [u64; 2] = [2, 64];
/// How much better a rival must be than what facts say: a pilot is not exact.
const MARGIN: f64 = 1.25;
/// Share of the mean luminance that counts as full error where the picture is black, as in `eyebox bench`.
const FLOOR: f64 = 0.01;

/// By how much an estimator's work and variance are multiplied before they are compared: 1, but in tests that want to see
/// the plan change.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Handicap {
    pub work: [f64; Estimator::ALL.len()],
    pub noise: [f64; Estimator::ALL.len()],
}

impl Default for Handicap {
    fn default() -> Self {
        Handicap { work: [1.0; Estimator::ALL.len()], noise: [1.0; Estimator::ALL.len()] }
    }
}

/// What may be done otherwise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Question {
    /// Lamps seen through specular faces: from the lamps, or from the eye.
    Vision,
    /// Light that scatterers get over specular faces or from other scatterers: by photons, or from the eye.
    Scattered,
    /// Whether caustics are connected, or all left to photons.
    Connections,
}

impl Question {
    const ALL: [Question; 3] = [Question::Vision, Question::Scattered, Question::Connections];

    fn classes(self) -> &'static [Class] {
        match self {
            Question::Vision => &[Class::Vision],
            Question::Scattered => &[Class::Caustic, Class::Secondary],
            Question::Connections => &[Class::Caustic],
        }
    }
}

/// The plan that a pilot finds best among `base` and what differs from it in one answer after the other.
pub(super) fn settle(making: &Making<'_>, base: Plan, handicap: &Handicap) -> Plan {
    let open = Open::new(making, &base);
    let small = if open.is_nothing() { None } else { Small::new(making) };
    let Some(small) = small else { return base };
    let mut best = base;
    let mut of_best: Option<Trial> = None;
    let mut notes = Vec::new();
    for question in Question::ALL {
        let Some(rows) = open.rival(&best, question) else { continue };
        if making.stopped() {
            break;
        }
        let plan = making.plan_of(rows, Some(&best));
        if plan.rows.iter().zip(&best.rows).all(|(a, b)| kind(&a.verdict) == kind(&b.verdict)) {
            // A pilot of the rival's has given up.
            continue;
        }
        let held = of_best.take().unwrap_or_else(|| small.trial(making, &best));
        let rival = small.trial(making, &plan);
        let Some([own, other]) = costs([&held, &rival], handicap) else {
            of_best = Some(held);
            continue;
        };
        let [of_own, of_other] = [&best, &plan].map(|plan| names(plan, question));
        let found =
            format!("a pilot found {:.2e} times the variance × work for {of_other} as for {of_own}", other / own);
        if other * MARGIN < own {
            best = plan;
            for row in best.rows.iter_mut().filter(|row| question.classes().contains(&row.class)) {
                if let Verdict::Own { because, .. } | Verdict::Connect { because, .. } = &mut row.verdict
                    && because == ASKED
                {
                    because.clone_from(&found);
                }
            }
            of_best = Some(rival);
        } else {
            notes.push(found);
            of_best = Some(held);
        }
    }
    best.notes.extend(notes);
    best
}

/// Stands for the pilot's reason until it is known.
const ASKED: &str = "of a pilot";

/// A verdict without its reason: owner, and whether connection has what it can.
fn kind(verdict: &Verdict) -> Option<(Estimator, bool)> {
    match verdict {
        Verdict::Own { owner, .. } => Some((*owner, false)),
        Verdict::Connect { rest, .. } => Some((*rest, true)),
        Verdict::Skip { .. } => None,
    }
}

/// Who makes the paths of a question.
fn names(plan: &Plan, question: Question) -> String {
    let of = |row: &&Row| question.classes().contains(&row.class);
    let kinds: BTreeSet<(bool, Estimator)> = plan
        .rows
        .iter()
        .filter(of)
        .filter_map(|row| kind(&row.verdict))
        .map(|(e, connected)| (!connected, e))
        .collect();
    let name = |(alone, estimator): (bool, Estimator)| match alone {
        true => estimator.name().to_owned(),
        false => format!("manifold with {}", estimator.name()),
    };
    kinds.into_iter().map(name).collect::<Vec<_>>().join(" and ")
}

/// Which light groups the questions are open for.
struct Open {
    vision: Vec<bool>,
    scattered: Vec<bool>,
}

impl Open {
    fn new(making: &Making<'_>, base: &Plan) -> Open {
        let (scene, facts) = (making.checked.scene(), making.checked.facts());
        let (low, high) = making.world.geometry.bounds();
        let section = (high - low).length_squared();
        let of = |group: usize| {
            let lamps = || making.world.lamps.all().iter().filter(|lamp| lamp.group.index() == group);
            let others = making.world.lights.all().iter().any(|light| light.group().index() == group);
            let sky = scene.sky.as_ref().is_some_and(|sky| sky.group.index() == group);
            // Points and parallel light have no area, and the sky is all around.
            if lamps().next().is_none() || others || sky {
                return [false; 2];
            }
            let ratio = lamps_over_eye(making.world, lamps().map(|lamp| lamp.area_m2).sum());
            let area: f64 = lamps().map(|lamp| lamp.area_m2).sum();
            let vision = facts.specular && !facts.pinhole && (OPEN[0]..=OPEN[1]).contains(&ratio);
            // Without specular faces every scatterer asks for the lamps, whatever their size.
            let seen = area > SMALL * section && (facts.pinhole || ratio > OPEN[0]);
            [vision, seen || !facts.specular]
        };
        let all: Vec<[bool; 2]> = (0..scene.groups.len()).map(of).collect();
        // What a pilot has given up is not asked again.
        let said = super::rows(making.checked, making.world, making.choice);
        let given_up = |group: usize| {
            let of =
                |rows: &[Row]| rows.get(group * Class::ALL.len() + Class::Vision as usize).map(|r| kind(&r.verdict));
            of(&base.rows) != of(&said)
        };
        Open {
            vision: all.iter().enumerate().map(|(group, [vision, _])| *vision && !given_up(group)).collect(),
            scattered: all.iter().map(|[_, scattered]| *scattered).collect(),
        }
    }

    fn is_nothing(&self) -> bool {
        !self.vision.iter().chain(&self.scattered).any(|open| *open)
    }

    /// The rows of a plan with the other answer to a question; none if it is not open.
    fn rival(&self, plan: &Plan, question: Question) -> Option<Vec<Row>> {
        let other = |row: &Row| {
            let open = match question {
                Question::Vision => &self.vision,
                Question::Scattered | Question::Connections => &self.scattered,
            };
            if !question.classes().contains(&row.class) || !open.get(row.group.index()).is_some_and(|open| *open) {
                return None;
            }
            match (question, kind(&row.verdict)?) {
                (Question::Vision, (Estimator::Backward, false)) => Some(connect(Estimator::Forward, ASKED)),
                (Question::Vision | Question::Scattered, (Estimator::Forward | Estimator::Photon, _)) => {
                    Some(own(Estimator::Backward, ASKED))
                }
                (Question::Connections, (rest, true)) => Some(own(rest, ASKED)),
                (Question::Vision | Question::Scattered | Question::Connections, _) => None,
            }
        };
        let mut changed = false;
        let turned = |row: &Row| match other(row) {
            Some(verdict) => {
                changed = true;
                Row { verdict, ..row.clone() }
            }
            None => row.clone(),
        };
        let rows = plan.rows.iter().map(turned).collect();
        changed.then_some(rows)
    }
}

/// What a few passes of a plan brought, by estimator.
struct Trial {
    /// Per pixel: luminance and its variance, one entry per estimator that ran.
    values: Vec<f64>,
    variances: Vec<(Estimator, Vec<f64>)>,
    /// Counted work of a pass.
    work: Vec<(Estimator, f64)>,
    passes: f64,
    width: usize,
}

/// The pilot's picture.
struct Small {
    world: World,
    size: [usize; 2],
    /// Longer side of the real one.
    longer: usize,
    /// Of the pixels of the real one.
    share: f64,
}

impl Small {
    fn new(making: &Making<'_>) -> Option<Small> {
        let mut eye = making.checked.scene().eye.clone();
        let [width, height] = eye.resolution;
        let scale = (SIDE as f64 / width.max(height).max(1) as f64).min(1.0);
        let size = [width, height].map(|n| ((n as f64 * scale).round() as usize).max(1));
        eye.resolution = size;
        let share = (size[0] * size[1]) as f64 / (width * height).max(1) as f64;
        Some(Small { world: making.world.seen_by(&eye).ok()?, size, longer: width.max(height), share })
    }

    fn trial(&self, making: &Making<'_>, plan: &Plan) -> Trial {
        let mut own = plan.clone();
        if self.share < 1.0 {
            // As many photons within reach of a point as in the real picture.
            let fewer = |paths: u64| ((paths as f64 * self.share).ceil() as u64).max(u64::from(paths > 0));
            (own.forward_paths, own.photons) = (fewer(plan.forward_paths), fewer(plan.photons));
            own.photon_radii_m = plan.photon_radii_m.scaled(self.share.sqrt().recip());
        }
        let mut tracing = begin_trial(&self.world, &own, making.groups(), (self.size, self.longer), super::pilot::SEED);
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
