//! The third step of a rendering: passes until a limit is reached, with a witness beside them.

use super::opened::Opened;
use super::planned::Planned;
use super::{Ended, Run};
use crate::base::ids::GroupId;
use crate::base::{Error, Result, Where};
use crate::cmd::ending::{Ending, NO_WITNESS, ending};
use crate::cmd::progress::Progress;
use crate::cmd::shards::{Saver, checkpoint_of};
use crate::cmd::witnessed::{Seen, Watched, traced};
use crate::estimate::run::{Outcome, Start, Stop};
use crate::film::witness::Judgement;
use crate::plan::Choice;
use crate::plan::plan_file::PlanFile;
use crate::world::World;
use crate::world::light::Light;
use std::time::Instant;

/// What was traced.
pub struct Traced {
    pub outcome: Outcome,
    pub judgement: Option<Judgement>,
    /// What was off and was traced again.
    pub again: Vec<String>,
    /// Relative, of the whole picture.
    pub error: Option<f64>,
    /// After how many passes it was which.
    pub errors: Vec<(u64, f64)>,
    pub ending: Ending,
}

impl Run<'_> {
    /// None if a signal came and what is there by then is not wanted.
    pub fn trace(&self, opened: &Opened, planned: &mut Planned) -> Result<Option<Traced>> {
        let args = &self.args;
        let Opened { scene, world, asked, .. } = opened;
        let mut limits = args.limits();
        // The time that was asked for includes the import, the plan and its pilots.
        limits.time = limits.time.map(|time| time.saturating_sub(self.start.elapsed()));
        if args.shard.is_some() {
            limits.passes = Some(planned.head.passes);
        }
        let mut progress = Progress::new(&limits, (args.quiet, args.progress), self.signals.clone());
        let mut saver = Saver {
            progress: &mut progress,
            head: planned.head.clone(),
            path: checkpoint_of(&args.output),
            every: args.checkpoint,
            last: Instant::now(),
        };
        let ours = args.plan.is_none() && asked.choice == Choice::Auto;
        let watched = Watched {
            world,
            groups: scene.groups.len(),
            size: scene.eye.resolution,
            seed: args.seed_of_passes(),
            // What naive paths find is about the whole picture.
            watch: (!args.no_witness && args.crop.is_none()).then_some(planned.guide.take()),
            may_change: ours && args.shard.is_none() && args.checkpoint.is_none(),
        };
        let name = |group: GroupId| scene.group(group).name.clone();
        let start = std::mem::replace(&mut planned.start, Start::Pass(0));
        let seen = self.pool.install(|| traced(&watched, (&mut planned.plan, &name), start, &limits, &mut saver));
        let Some(Seen { outcome, judgement, warnings: again }) = seen else {
            return Err(Error::new(Where::file(&saver.path), "keeps other sums than this run")
                .expected("the same options, or no file of this name"));
        };
        if outcome.stop == Stop::Asked {
            saver.interrupted(&outcome.films);
        }
        progress.finish();
        if !self.partial && outcome.stop == Stop::Asked {
            return Ok(None);
        }
        let error = self.pool.install(|| outcome.films.relative_error());
        if !again.is_empty() {
            // A changed plan has a name of its own.
            planned.frozen = PlanFile::new(scene, *asked, &planned.plan);
        }
        let one_pass = limits.passes == Some(1);
        let mut ending = match args.shard {
            // One piece of a run tells too little; the whole is judged when it is merged.
            Some(_) => Ending::default(),
            None => ending(&outcome.films, judgement.as_ref(), &name, error, (one_pass, is_lit(world))),
        };
        if let (Some(wanted), Some(stated)) = (args.error, error)
            && stated > wanted
        {
            ending.fell_short(&outcome.films, [stated, wanted], outcome.stop == Stop::TooFar);
        }
        if judgement.is_none() && !args.no_witness && args.crop.is_none() && args.shard.is_none() {
            ending.lines.push(NO_WITNESS.to_owned());
        }
        let errors = progress.errors().to_vec();
        Ok(Some(Traced { outcome, judgement, again, error, errors, ending }))
    }

    pub fn ended(&self, traced: &Traced) -> Ended {
        let met = self.args.error.is_none_or(|limit| traced.error.is_some_and(|error| error <= limit));
        match (traced.outcome.stop, self.signals.caught()) {
            (Stop::Asked, Some(_)) => Ended::Stopped,
            (Stop::Passes | Stop::Time | Stop::TooFar, _) if !met => Ended::Unmet,
            (_, _) if traced.ending.finding => Ended::Unmet,
            (Stop::Passes | Stop::Time | Stop::Error | Stop::TooFar | Stop::Asked, _) => Ended::Met,
        }
    }
}

/// Whether any lamp is on, or there is a sky.
fn is_lit(world: &World) -> bool {
    let faces = world.lamps.all().iter().map(|lamp| lamp.flux_lm);
    let others = world.lights.all().iter().map(Light::flux_lm);
    world.sky.is_some() || faces.chain(others).any(|flux| flux > 0.0)
}
