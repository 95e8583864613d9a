//! Where facts leave it open who should trace, a pilot decides: every way that comes into question makes a few passes of
//! a small picture, and the one with the least variance × counted work wins.

pub(super) mod facts;
mod pilot_run;
mod tuning;
mod verdict;

use crate::Planner;
use crate::pilots::pupil_guide;
use eyebox_base::path::Class;
use eyebox_film::plan::{Estimator, Plan, Row, Verdict};
use facts::{OPEN, connect, kind, lamps_over_eye, own};
use pilot_run::{Trials, Tried};
use std::collections::BTreeSet;
use tuning::selection::{FILLED, SMALL};
use verdict::{Compared, Misses};

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
    /// Whether these are connected. A point of a lamp that is imaged far from the pupil is seen through all of it in one
    /// place of the picture and through none in any other: there is no point of the pupil to solve for.
    Trains,
    /// Light that scatterers get over specular faces or from other scatterers: by photons, or from the eye.
    Scattered,
    /// Whether caustics are connected, or all left to photons.
    Connections,
}

impl Question {
    const ALL: [Question; 4] = [Question::Vision, Question::Trains, Question::Scattered, Question::Connections];

    fn classes(self) -> &'static [Class] {
        match self {
            Question::Vision | Question::Trains => &[Class::Vision],
            Question::Scattered => &[Class::Caustic, Class::Secondary],
            Question::Connections => &[Class::Caustic],
        }
    }
}

/// The plan that a pilot finds best among `base` and what differs from it in one answer after the other.
pub(super) fn settle(making: &Planner<'_>, base: Plan, handicap: &Handicap) -> Plan {
    let open = Open::new(making, &base);
    let trials = if open.is_nothing() { None } else { Trials::new(making) };
    let Some(trials) = trials else { return base };
    let mut best = base;
    let mut of_best: Option<Tried> = None;
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
        let held = of_best.get_or_insert_with(|| trials.start(making, &best));
        let mut rival = trials.start(making, &plan);
        let compared = trials.compare(making, (&best, held), (&plan, &mut rival), handicap);
        let Some(Compared { ratio, wins, misses }) = compared else { continue };
        // What rays hardly ever find is far brighter than they tell when they do. Where photons find none, there is none.
        let unsure = question == Question::Scattered && open.is_unsure(&best);
        let sure = misses.is_some() || rival.surely_sees_scattered() || held.sees_nothing_scattered();
        let wins = wins && (sure || !unsure);
        let [of_own, of_other] = [&best, &plan].map(|plan| names(plan, question));
        let found = match misses {
            None if ratio.is_nan() => format!("in a pilot run neither {of_other} nor {of_own} had any noise"),
            None => format!("in a pilot run {of_other} cost {ratio:.2e} times as much as {of_own} (variance × work)"),
            Some(Misses { rival, found }) => {
                let (blind, sees) = if rival { (of_other, of_own) } else { (of_own, of_other) };
                format!("in a pilot run {blind} found only {:.1} % of the light that {sees} found", 100.0 * found)
            }
        };
        if wins {
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
        }
    }
    best.notes.extend(notes);
    best
}

/// Stands for the pilot's reason until it is known.
const ASKED: &str = "of a pilot";

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
    trains: Vec<bool>,
    scattered: Vec<bool>,
    /// The same, but rays from the eye have to show first that they find the lamps.
    unsure: Vec<bool>,
}

impl Open {
    fn new(making: &Planner<'_>, base: &Plan) -> Open {
        let (scene, facts) = (making.checked.scene(), making.checked.facts());
        let (low, high) = making.world.geometry.bounds();
        let section = (high - low).length_squared();
        let of = |group: usize| {
            let lamps = || making.world.lamps.all().iter().filter(|lamp| lamp.group.index() == group);
            let others = making.world.lights.all().iter().any(|light| light.group().index() == group);
            let sky = scene.sky.as_ref().is_some_and(|sky| sky.group.index() == group);
            // Points and parallel light have no area, and the sky is all around.
            if lamps().next().is_none() || others || sky {
                return [false; 4];
            }
            let ratio = lamps_over_eye(making.world, lamps().map(|lamp| lamp.area_m2).sum());
            let area: f64 = lamps().map(|lamp| lamp.area_m2).sum();
            // Connection knows no emission textures.
            let sees = facts.specular && !facts.pinhole && lamps().all(|lamp| lamp.is_even());
            let [small, between] = [sees && ratio < OPEN[0], sees && (OPEN[0]..=OPEN[1]).contains(&ratio)];
            // Without specular faces every scatterer asks for the lamps, whatever their size.
            let seen = area > SMALL * section && (facts.pinhole || ratio > OPEN[0]);
            [small, between, seen || !facts.specular, facts.specular && !seen]
        };
        let all: Vec<[bool; 4]> = (0..scene.groups.len()).map(of).collect();
        // What a pilot has given up is not asked again.
        let said = crate::selection::facts::rows(making.checked, making.world, making.asked.choice);
        let given_up = |group: usize| {
            let of =
                |rows: &[Row]| rows.get(group * Class::ALL.len() + Class::Vision as usize).map(|r| kind(&r.verdict));
            of(&base.rows) != of(&said)
        };
        let small: Vec<bool> = all.iter().map(|[small, ..]| *small).collect();
        let trains: Vec<bool> = pupil_guide::densities(making, base, &small)
            .into_iter()
            .map(|density| density.is_some_and(|density| density <= FILLED))
            .collect();
        let vision = |(group, [_, between, ..]): (usize, &[bool; 4])| (*between || trains[group]) && !given_up(group);
        Open {
            vision: all.iter().enumerate().map(vision).collect(),
            trains,
            scattered: all.iter().map(|[.., scattered, _]| *scattered).collect(),
            unsure: all.iter().map(|[.., unsure]| *unsure).collect(),
        }
    }

    fn is_nothing(&self) -> bool {
        !self.vision.iter().chain(&self.trains).chain(&self.scattered).chain(&self.unsure).any(|open| *open)
    }

    /// Whether groups are among those that a rival for scattered light would take whose lamps rays from the eye may hardly find.
    fn is_unsure(&self, plan: &Plan) -> bool {
        let taken = |row: &&Row| {
            Question::Scattered.classes().contains(&row.class)
                && matches!(kind(&row.verdict), Some((Estimator::Forward | Estimator::Photon, _)))
        };
        plan.rows.iter().filter(taken).any(|row| self.unsure.get(row.group.index()).is_some_and(|unsure| *unsure))
    }

    /// The rows of a plan with the other answer to a question; none if it is not open.
    fn rival(&self, plan: &Plan, question: Question) -> Option<Vec<Row>> {
        let other = |row: &Row| {
            let open = match question {
                Question::Vision => vec![&self.vision],
                Question::Trains => vec![&self.trains],
                Question::Scattered => vec![&self.scattered, &self.unsure],
                Question::Connections => vec![&self.scattered],
            };
            let open = open.iter().any(|open| open.get(row.group.index()).is_some_and(|open| *open));
            if !question.classes().contains(&row.class) || !open {
                return None;
            }
            match (question, kind(&row.verdict)?) {
                (Question::Vision, (Estimator::Backward, false)) => Some(connect(Estimator::Forward, ASKED)),
                (Question::Vision | Question::Scattered, (Estimator::Forward | Estimator::Photon, _)) => {
                    Some(own(Estimator::Backward, ASKED))
                }
                (Question::Trains | Question::Connections, (rest, true)) => Some(own(rest, ASKED)),
                (Question::Vision | Question::Trains | Question::Scattered | Question::Connections, _) => None,
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
