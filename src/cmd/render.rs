//! `eyebox render`: the corridor, in order.

use super::chains::Chains;
use super::ending::{Ending, ending, stated};
use super::frames::named;
use super::print;
use super::progress::{Progress, Signals};
use super::render_args::RenderArgs;
use super::sequence;
use super::shards::{Saver, checkpoint_of, resume};
use super::witnessed::{Seen, Watched, traced};
use crate::base::atomic::check_writable;
use crate::base::ids::GroupId;
use crate::base::{Error, Result, Where};
use crate::check::{Checked, check};
use crate::estimate::aov::{self, Granted};
use crate::estimate::cryptomatte;
use crate::estimate::data::data_layers;
use crate::estimate::finishing::{Finishing, Wanted};
use crate::estimate::picture::{add_data_layers, add_meta, add_sharpness, add_witness, check_layers, plan_lines};
use crate::estimate::render_vars;
use crate::estimate::run::{Outcome, Start, Stop};
use crate::estimate::shard;
use crate::film::aov::Aov;
use crate::film::diffraction::{Diffraction, PRIMARIES_NM};
use crate::film::frame::Meta;
use crate::film::plan::Plan;
use crate::film::pupil::Pupil;
use crate::film::sharpness::{GroupPupil, Sharpness};
use crate::film::witness::Judgement;
use crate::import::Built;
use crate::output::exr::{COLOR_INTEROP_ID, write_exr};
use crate::plan::plan_file::PlanFile;
use crate::plan::pupil::{Surveyed, survey};
use crate::plan::{Asked, Choice, Guides, plan_unless};
use crate::scene::assembly::RequestedLayer;
use crate::scene::{Scene, Severity, Wavelengths};
use crate::world::World;
use crate::world::light::Light;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

/// Runs the command.
pub fn run(args: &RenderArgs) -> Result<ExitCode> {
    let signals = Signals::install();
    match &args.frames {
        Some(frames) => sequence::run(args, frames, &signals),
        None => Ok(match one(args, &signals, true)? {
            Ended::Met => ExitCode::SUCCESS,
            Ended::Unmet => ExitCode::from(1),
            Ended::Stopped => signals.exit_code(),
        }),
    }
}

/// How a rendering ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    Met,
    /// Another limit came before the error that was asked for, or what was found is not to be trusted: it is said why.
    Unmet,
    /// By a signal.
    Stopped,
}

/// Renders one frame. `partial`: whether the passes until a signal are written.
pub fn one(args: &RenderArgs, signals: &Signals, partial: bool) -> Result<Ended> {
    let start = Instant::now();
    let args = &RenderArgs { output: named(&args.output, args.source.moment.frame)?, ..args.clone() };
    check_destination(&args.output)?;
    if let Some(packing) = args.compression {
        let at = || Where::Option(format!("--compression {}", packing.name()));
        packing.spares_data(args.multi_part).map_err(|text| Error::new(at(), text).expected("--multi-part with it"))?;
    }
    let pool = args.threads.pool()?;
    let Built { mut scene, layers: wishes, .. } = args.source.import()?;
    // The path table has the asset's own resolution, so that its numbers are those of `eyebox paths`.
    let own = scene.eye.resolution;
    if let Some(resolution) = args.resolution {
        scene.eye.resolution = resolution;
    }
    if let Some(crop) = args.crop
        && !crop.fits(scene.eye.resolution)
    {
        let [width, height] = scene.eye.resolution;
        return Err(Error::new(Where::Option(format!("--crop {crop}")), "reaches out of the picture")
            .expected(format!("a part of {width} x {height} pixels")));
    }
    let checked = check(&scene)?;
    check_layers(&args.layers, &scene.groups)?;
    let mut world = World::freeze(&scene)?;
    let stop = || signals.caught().is_some();
    let guides = if args.unguided { Guides::Off } else { Guides::On };
    let asked = Asked { choice: args.estimator.choice(), polarisation: args.polarisation.asked(), guides };
    let behind = if args.resume { resume(&args.output, &|head| args.is_mine(head, &scene))? } else { None };
    let plan = match (&args.plan, &behind) {
        (Some(path), _) => Some(PlanFile::read(path, &scene, asked)?.plan),
        (None, Some((head, _))) => {
            Some(PlanFile::of_value(&head.plan, &checkpoint_of(&args.output), &scene, asked)?.plan)
        }
        (None, None) => pool.install(|| plan_unless(&checked, &world, asked, &stop)),
    };
    let Some(mut plan) = plan else { return Ok(stopped(args, "before the first pass")) };
    let Surveyed { pupils, guide } = pool.install(|| survey(&checked, &world, asked, &plan, &stop));
    if stop() {
        return Ok(stopped(args, "before the first pass"));
    }
    let mut sharpness = Sharpness::new(&pupils, scene.wavelengths.traced_nm(), world.eye.pixel());
    let diffraction = args.diffraction.then(|| spread_by(&scene, &checked, &world, &pupils));
    let frozen = PlanFile::new(&scene, asked, &plan);
    // What the command line asks for goes before what the asset asks for.
    let wishes: &[RequestedLayer] = if args.layers.is_empty() { &wishes } else { &[] };
    let (named_layers, ungranted) = render_vars::granted(wishes, &scene.groups);
    let Granted { aovs, notes: refused, sieve } =
        aov::granted(&args.aovs, (wishes, &named_layers), &scene, &world, &plan)?;
    let names: Vec<String> =
        named_layers.iter().map(|own| own.name.clone()).chain(aovs.iter().flat_map(Aov::layers)).collect();
    let Some(chains) = pool.install(|| Chains::find(args, (&scene, own), &names, &stop))? else {
        return Ok(stopped(args, "before the first pass"));
    };
    scene.notes.extend(ungranted.into_iter().chain(refused));
    world.sieve = sieve;
    plan.errors = args.errors(&named_layers);
    let mut limits = args.limits();
    // Only now: plan and pilots are those of the whole picture, so that the part has its bits.
    world.eye.crop = args.crop;
    // The time that was asked for includes the import, the plan and its pilots.
    limits.time = limits.time.map(|time| time.saturating_sub(start.elapsed()));
    let size = scene.eye.resolution;
    let groups = scene.groups.len();
    let mut finishing = Finishing::new(&scene, &plan, args.color.space(), diffraction);
    finishing.wanted = args.wanted(named_layers, aovs);
    let head = args.head(&scene, &frozen, finishing);
    if let Some((behind, _)) = &behind
        && behind.plan_hash != head.plan_hash
    {
        return Err(Error::new(Where::file(&checkpoint_of(&args.output)), "is of another plan").expected(frozen.hash));
    }
    let start = match behind {
        Some((_, films)) => Start::Films(films),
        None => Start::Pass(head.first),
    };
    if args.shard.is_some() {
        limits.passes = Some(head.passes);
    }
    let mut progress = Progress::new(&limits, (args.quiet, args.progress), signals.clone());
    let path = checkpoint_of(&args.output);
    let every = args.checkpoint;
    let mut saver = Saver { progress: &mut progress, head: head.clone(), path, every, last: Instant::now() };
    let ours = args.plan.is_none() && asked.choice == Choice::Auto;
    let watched = Watched {
        world: &world,
        groups,
        size,
        seed: args.seed_of_passes(),
        // What naive paths find is about the whole picture.
        watch: (!args.no_witness && args.crop.is_none()).then_some(guide),
        may_change: ours && args.shard.is_none() && args.checkpoint.is_none(),
    };
    let name = |group: GroupId| scene.group(group).name.clone();
    let seen = pool.install(|| traced(&watched, (&mut plan, &name), start, &limits, &mut saver));
    let Some(Seen { mut outcome, judgement, warnings: traced_again }) = seen else {
        return Err(Error::new(Where::file(&saver.path), "keeps other sums than this run")
            .expected("the same options, or no file of this name"));
    };
    if outcome.stop == Stop::Asked {
        saver.interrupted(&outcome.films);
    }
    let Saver { every, path: checkpoint, .. } = saver;
    progress.finish();
    if !partial && outcome.stop == Stop::Asked {
        return Ok(stopped(args, "before the frame was done"));
    }
    let error = pool.install(|| outcome.films.relative_error());
    // A changed plan has a name of its own.
    let frozen = if traced_again.is_empty() { frozen } else { PlanFile::new(&scene, asked, &plan) };
    let lit = is_lit(&world);
    let mut ending = match args.shard {
        // One piece of a run tells too little; the whole is judged when it is merged.
        Some(_) => Ending::default(),
        None => ending(&outcome.films, judgement.as_ref(), &name, error, (limits.passes == Some(1), lit)),
    };
    // Where pictures are large the layers need the room of the sums, unless these are to be written.
    if args.shard.is_none() {
        outcome.films.condense();
    }
    let finished = pool.install(|| head.finishing.picture(&outcome.films))?;
    if args.shard.is_none() {
        outcome.films.forget_light();
    }
    sharpness.applied = finished.applied;
    let mut frame = finished.frame;
    add_data_layers(&mut frame, pool.install(|| data_layers(&world, size[0], size[1])));
    let Wanted { layers, named, .. } = &head.finishing.wanted;
    let mattes = cryptomatte::wanted(args.cryptomatte, layers.iter().chain(named.iter().map(|wish| &wish.layer)));
    pool.install(|| cryptomatte::add(&mut frame, &scene, &world, &mattes));
    frame.meta.insert(COLOR_INTEROP_ID.to_owned(), Meta::Text(args.color.space().interop_id().to_owned()));
    frame.meta.insert("planHash".to_owned(), Meta::Text(frozen.hash));
    add_meta(&mut frame, &scene, &plan, &outcome, args.seed_of_passes(), &finished.splits);
    add_sharpness(&mut frame, &sharpness);
    add_witness(&mut frame, judgement.as_ref(), !args.no_witness && args.crop.is_none(), &ending.lines);
    if args.convergence {
        let errors = serde_json::json!(progress.errors()).to_string();
        frame.meta.insert("convergence".to_owned(), Meta::Text(errors));
    }
    let warnings = if args.shard.is_some() {
        shard::save(&args.output, &head, &outcome.films, &frame)?;
        Vec::new()
    } else {
        head.finishing.wanted.keep(&mut frame);
        let checked = check(&scene)?;
        if pool.install(|| chains.add(&mut frame, (&checked, &world), outcome.films.passes, &stop)).is_none() {
            frame.meta.insert("chainsMissing".to_owned(), Meta::Text("stopped before they were traced".to_owned()));
        }
        head.finishing.wanted.cut(&mut frame);
        write_exr(&args.output, &frame)?
    };
    ending.warnings.splice(0..0, traced_again);
    ending.warnings.extend(warnings);
    if every.is_some() && outcome.stop != Stop::Asked {
        // Only now nothing can be lost. If it can't be removed, the next `--resume` finds a run that is over.
        let _ = std::fs::remove_file(&checkpoint);
    }
    if !args.quiet {
        summary(args, (&scene, &plan), (&outcome, error), &sharpness, (&ending, judgement.as_ref()))?;
    }
    let met = args.error.is_none_or(|limit| error.is_some_and(|error| error <= limit));
    Ok(match (outcome.stop, signals.caught()) {
        (Stop::Asked, Some(_)) => Ended::Stopped,
        (Stop::Passes | Stop::Time, _) if !met => Ended::Unmet,
        (_, _) if ending.finding => Ended::Unmet,
        (Stop::Passes | Stop::Time | Stop::Error | Stop::Asked, _) => Ended::Met,
    })
}

/// What the picture's light is spread by.
fn spread_by(scene: &Scene, checked: &Checked, world: &World, pupils: &[GroupPupil]) -> Diffraction {
    let wavelengths_nm = match scene.wavelengths {
        Wavelengths::Mono { nm } => [nm; 3],
        Wavelengths::Visible => PRIMARIES_NM,
    };
    Diffraction {
        pixel: world.eye.pixel(),
        wavelengths_nm,
        pupils: pupils.to_vec(),
        full: Pupil::full(scene.eye.pupil_diameter_m),
        only_vision: !checked.facts().scatters,
    }
}

/// Whether any lamp is on, or there is a sky.
fn is_lit(world: &World) -> bool {
    let faces = world.lamps.all().iter().map(|lamp| lamp.flux_lm);
    let others = world.lights.all().iter().map(Light::flux_lm);
    world.sky.is_some() || faces.chain(others).any(|flux| flux > 0.0)
}

/// Without a picture an older file stays as it is.
fn stopped(args: &RenderArgs, when: &str) -> Ended {
    tell!("eyebox: stopped {when}; {} was not written", args.output.display());
    Ended::Stopped
}

/// Fails early where the picture could not be written: an hour of tracing must not end in a typing error.
fn check_destination(output: &Path) -> Result<()> {
    if output.extension().is_none_or(|e| !e.eq_ignore_ascii_case("exr")) {
        return Err(Error::new(Where::file(output), "is no name for an EXR file").expected("a name that ends in .exr"));
    }
    check_writable(output)
}

fn summary(
    args: &RenderArgs,
    (scene, plan): (&Scene, &Plan),
    (outcome, error): (&Outcome, Option<f64>),
    sharpness: &Sharpness,
    (ending, judgement): (&Ending, Option<&Judgement>),
) -> Result<()> {
    // What a pipe of the result should not hold, and nobody who looks at it should miss.
    let of_scene = scene.notes.iter().filter(|note| note.severity == Severity::Warning);
    of_scene.for_each(|note| tell!("warning: {}: {}", note.at, note.text));
    ending.warnings.iter().for_each(|warning| tell!("warning: {warning}"));
    let text = || {
        let mut lines = plan_lines(scene, plan);
        lines.extend(sharpness.lines());
        lines.extend(ending.lines.iter().cloned());
        let error = stated(error, outcome.films.passes);
        let seconds = outcome.elapsed.as_secs_f64();
        let passes = outcome.films.passes;
        lines.push(format!("{}: {passes} passes in {seconds:.1} s, {error}", args.output.display()));
        lines.join("\n")
    };
    let json = || {
        serde_json::json!({
            "output": args.output,
            "scene": scene.name,
            "scene_hash": scene.hash,
            "seed": args.seed_of_passes(),
            "passes": outcome.films.passes,
            "seconds": outcome.elapsed.as_secs_f64(),
            "stop": outcome.stop,
            "relative_error": error,
            "plan": plan,
            "diffraction": sharpness,
            "ledgers": outcome.films.films.iter().map(|(e, _, l)| (e.name(), l)).collect::<Vec<_>>(),
            "notes": scene.notes,
            "witness": judgement,
            "warnings": ending.warnings,
        })
    };
    print(args.format, text, json)
}
