//! A run beside which a witness looks. What it finds to be off is traced again by the naive estimator, if no limit forbids it.

use super::shards::Saver;
use crate::base::ids::GroupId;
use crate::estimate::run::{Films, Limits, Observer, Outcome, Start, Status, Stop, begin, drive};
use crate::film::guide::ApertureGuide;
use crate::film::plan::{Estimator, Plan, Row, Verdict};
use crate::film::witness::Judgement;
use crate::world::World;

/// What is to be run.
pub struct Watched<'r> {
    pub world: &'r World,
    pub groups: usize,
    pub size: [usize; 2],
    pub seed: u64,
    /// A witness is to look, through where a pilot saw lamps in the pupil.
    pub watch: Option<Option<ApertureGuide>>,
    /// The plan was chosen by us, for a run in one piece: it may be changed.
    pub may_change: bool,
}

/// What came of it.
pub struct Seen {
    pub outcome: Outcome,
    pub judgement: Option<Judgement>,
    /// What was off and was traced again.
    pub warnings: Vec<String>,
}

/// Asks the witness after 2, 4, 8, … passes, so that a long run does not go on for nothing.
struct Watchful<'s, 'p> {
    saver: &'s mut Saver<'p>,
    asks: bool,
    off: bool,
}

impl Observer for Watchful<'_, '_> {
    fn block(&mut self, status: &Status, films: &Films) -> bool {
        let go_on = self.saver.block(status, films);
        if self.asks && status.passes >= 2 && status.doubled {
            self.off = films.judgement().is_some_and(|judgement| judgement.asks_for_others());
        }
        go_on && !self.off
    }
}

/// Traces `plan`, which is changed where the witness finds it to be off. `name`: of a light group. None if `start` is of
/// another run.
pub fn traced(
    run: &Watched<'_>,
    (plan, name): (&mut Plan, &dyn Fn(GroupId) -> String),
    start: Start,
    limits: &Limits,
    saver: &mut Saver<'_>,
) -> Option<Seen> {
    let (first, off) = once(run, plan, start, limits, saver)?;
    let judgement = first.films.judgement();
    let stopped = first.stop == Stop::Asked && !off;
    let found = judgement.as_ref().filter(|judgement| judgement.asks_for_others() && run.may_change && !stopped);
    let left = limits.time.map(|time| time.saturating_sub(first.elapsed));
    let Some(found) = found.filter(|_| left.is_none_or(|left| !left.is_zero())) else {
        return Some(Seen { outcome: first, judgement, warnings: Vec::new() });
    };
    let mut warnings = found.warnings(name);
    let changed = naively(plan, found);
    warnings.push(format!("witness: {} traced again from the eye, by brute force", named(&changed, name)));
    warnings.iter().for_each(|warning| anstream::eprintln!("eyebox: warning: {warning}"));
    let again = Limits { time: left, ..limits.clone() };
    let elapsed = first.elapsed;
    drop(first);
    let (mut outcome, _) = once(run, plan, Start::Pass(0), &again, saver)?;
    outcome.elapsed += elapsed;
    let judgement = outcome.films.judgement();
    Some(Seen { outcome, judgement, warnings })
}

/// One run, and whether it was ended because it is off.
fn once(
    run: &Watched<'_>,
    plan: &Plan,
    start: Start,
    limits: &Limits,
    saver: &mut Saver<'_>,
) -> Option<(Outcome, bool)> {
    let mut tracing = begin(run.world, plan, run.groups, run.size, run.seed);
    if let Some(guide) = &run.watch {
        tracing.watch(guide.as_ref());
    }
    let mut watchful = Watchful { saver, asks: run.watch.is_some() && run.may_change, off: false };
    let outcome = tracing.start(start).then(|| drive(tracing, limits, &mut watchful))?;
    Some((outcome, watchful.off))
}

/// Gives rays from the eye all light that is off, with the reason. Returns the rows that changed.
fn naively(plan: &mut Plan, found: &Judgement) -> Vec<Row> {
    let mut changed = Vec::new();
    for judged in &found.judged {
        let Some(off) = judged.off.as_ref().filter(|_| !judged.from_lamps) else { continue };
        let of_it = |row: &&mut Row| row.group == judged.group && judged.classes.contains(&row.class);
        for row in plan.rows.iter_mut().filter(of_it) {
            let because = format!(
                "the plan before this had {:.4e} cd/m² where a witness saw {:.4e}: {:.1} σ",
                off.run, off.witness, off.sigmas
            );
            let other = match &row.verdict {
                Verdict::Own { owner, .. } => *owner != Estimator::Backward,
                Verdict::Connect { .. } => true,
                Verdict::Emitted { .. } | Verdict::Skip { .. } => false,
            };
            if other {
                row.verdict = Verdict::Own { owner: Estimator::Backward, because };
                changed.push(row.clone());
            }
        }
    }
    plan.backward_paths = plan.backward_paths.max(1);
    (plan.backward_share, plan.vision_share) = (1.0, 1.0);
    changed
}

fn named(rows: &[Row], name: &dyn Fn(GroupId) -> String) -> String {
    let names: Vec<String> = rows.iter().map(|row| format!("{} {}", name(row.group), row.class.name())).collect();
    names.join(", ")
}
