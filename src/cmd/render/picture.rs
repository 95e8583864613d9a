//! The fourth step of a rendering: sums become a frame, and the frame a file.

use super::Run;
use super::opened::Opened;
use super::planned::Planned;
use super::traced::Traced;
use crate::base::Result;
use crate::check::check;
use crate::cmd::shards::checkpoint_of;
use crate::estimate::cryptomatte;
use crate::estimate::data::data_layers;
use crate::estimate::finishing::Wanted;
use crate::estimate::motion::motion;
use crate::estimate::motion_seen::{Frozen, motion_seen};
use crate::estimate::picture::{add_data_layers, add_meta, add_sharpness, add_stated_error, add_witness};
use crate::estimate::run::Stop;
use crate::estimate::shard;
use crate::estimate::work_layer::{add_work, work};
use crate::film::frame::{Frame, Meta};
use crate::output::exr::{COLOR_INTEROP_ID, write_exr};
use crate::world::World;

impl Run<'_> {
    pub fn picture(&self, opened: &Opened, planned: &mut Planned, traced: &mut Traced) -> Result<Frame> {
        let args = &self.args;
        let Opened { scene, world, .. } = opened;
        let Planned { plan, frozen, head, sharpness, .. } = planned;
        let films = &mut traced.outcome.films;
        // Where pictures are large the layers need the room of the sums, unless these are to be written.
        if args.shard.is_none() {
            films.condense();
        }
        let finished = self.pool.install(|| head.finishing.picture(films))?;
        let work = work(films);
        if args.shard.is_none() {
            films.forget_light();
        }
        sharpness.applied = finished.applied;
        let mut frame = finished.frame;
        let size = scene.eye.resolution;
        add_data_layers(&mut frame, self.pool.install(|| data_layers(world, size[0], size[1])));
        if let Some(later) = &opened.later {
            let moved = self.pool.install(|| motion(world, scene, later))?;
            moved.into_iter().zip(["X", "Y"]).for_each(|(data, axis)| frame.push(format!("motion.{axis}"), data));
            let (now, next) = (Frozen { world, scene }, World::freeze(later)?);
            let moved = self.pool.install(|| motion_seen(now, Frozen { world: &next, scene: later }));
            moved.into_iter().zip(["u", "v"]).for_each(|(data, axis)| frame.push(format!("motion_seen.{axis}"), data));
        }
        let Wanted { layers, named, .. } = &head.finishing.wanted;
        if let Some(work) = work {
            add_work(&mut frame, work);
        }
        let mattes = cryptomatte::wanted(args.cryptomatte, layers.iter().chain(named.iter().map(|wish| &wish.layer)));
        self.pool.install(|| cryptomatte::add(&mut frame, scene, world, &mattes));
        frame.meta.insert(COLOR_INTEROP_ID.to_owned(), Meta::Text(args.color.space().interop_id().to_owned()));
        frame.meta.insert("planHash".to_owned(), Meta::Text(frozen.hash.clone()));
        add_meta(&mut frame, scene, plan, &traced.outcome, args.seed_of_passes(), &finished.splits);
        add_stated_error(&mut frame, traced.error);
        add_sharpness(&mut frame, sharpness);
        add_witness(
            &mut frame,
            traced.judgement.as_ref(),
            !args.no_witness && args.crop.is_none(),
            &traced.ending.lines,
        );
        if args.convergence {
            let errors = serde_json::json!(traced.errors).to_string();
            frame.meta.insert("convergence".to_owned(), Meta::Text(errors));
        }
        Ok(frame)
    }

    /// What the file cannot hold becomes a warning of the run.
    pub fn write(&self, opened: &Opened, planned: &Planned, traced: &mut Traced, mut frame: Frame) -> Result<()> {
        let args = &self.args;
        let (head, films) = (&planned.head, &traced.outcome.films);
        let warnings = if args.shard.is_some() {
            shard::save(&args.output, head, films, &frame)?;
            Vec::new()
        } else {
            head.finishing.wanted.keep(&mut frame);
            let tracing = (&check(&opened.scene)?, &opened.world);
            let chains = || planned.chains.add(&mut frame, tracing, films.passes, &|| self.is_stopped());
            if self.pool.install(chains).is_none() {
                frame.meta.insert("chainsMissing".to_owned(), Meta::Text("stopped before they were traced".to_owned()));
            }
            head.finishing.wanted.cut(&mut frame);
            write_exr(&args.output, &frame)?
        };
        traced.ending.warnings.splice(0..0, traced.again.drain(..));
        traced.ending.warnings.extend(warnings);
        if args.checkpoint.is_some() && traced.outcome.stop != Stop::Asked {
            // Only now nothing can be lost. If it can't be removed, the next `--resume` finds a run that is over.
            let _ = std::fs::remove_file(checkpoint_of(&args.output));
        }
        Ok(())
    }
}
