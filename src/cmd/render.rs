//! `eyebox render`: the corridor, in order.

use super::progress::{Progress, ProgressArg, Signals};
use super::sequence::{self, Frames, named, parse_frames};
use super::shards::{Saver, checkpoint_of, parse_shard, resume};
use super::{Format, print};
use crate::base::atomic::check_writable;
use crate::base::colour::ColourSpace;
use crate::base::{Fault, Result, Where};
use crate::check::{Checked, check};
use crate::estimate::aov;
use crate::estimate::data::data_layers;
use crate::estimate::finishing::{Finishing, Wanted};
use crate::estimate::mattes;
use crate::estimate::picture::{add_data_layers, add_meta, add_sharpness, check_layers, plan_lines};
use crate::estimate::run::{Limits, Outcome, Start, Stop, begin, drive};
use crate::estimate::shard::{self, Head};
use crate::estimate::wish::{self, Named};
use crate::film::aov::Aov;
use crate::film::detail::ErrorDetail;
use crate::film::diffraction::{Diffraction, PRIMARIES_NM};
use crate::film::frame::Meta;
use crate::film::plan::{Estimator, Plan};
use crate::film::pupil::Pupil;
use crate::film::sharpness::{GroupPupil, Sharpness};
use crate::import::{Built, ImportOptions, Set, import};
use crate::output::exr::{COLOR_INTEROP_ID, parse_prefix, write_exr};
use crate::plan::frozen::Frozen;
use crate::plan::pupil::survey;
use crate::plan::{Asked, Choice, Polarisation, plan_unless};
use crate::scene::assembly::LayerWish;
use crate::scene::{Scene, Severity, Wavelengths};
use crate::world::World;
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Passes of a run that is given no limit at all.
const DEFAULT_PASSES: u64 = 64;

#[derive(Args, Debug, Clone)]
#[command(after_help = "Examples:\n  \
    eyebox render samples/hud-direct/hud.optics.toml -o hud.exr\n  \
    eyebox render hud.optics.toml -o hud.exr --time 90s --set led.flux_lm=0.6 --set eye.pupil_diameter=\"3 mm\"\n  \
    eyebox render hud.optics.toml -o check.exr --estimator backward --samples 256 --seed 7\n  \
    eyebox render hud.optics.toml -o sharp.exr --diffraction\n  \
    eyebox render hud.optics.toml -o hud.3.exr --samples 256 --shard 3/7\n  \
    eyebox render hud.optics.toml -o hud.exr --time 2h --checkpoint 60s --resume\n  \
    eyebox render hud.usda -o hud.0012.exr --frame 12\n  \
    eyebox render hud.usda -o hud.####.exr --frames 1-24 --skip-existing")]
pub struct RenderArgs {
    /// Sidecar (*.optics.toml) or asset (.glb, .gltf, .usda, .usdc, .usdz).
    asset: PathBuf,
    /// The EXR to write; in hud.####.exr the digits of the frame take the place of #.
    #[arg(short, long, value_name = "OUT.exr")]
    output: PathBuf,
    /// Stop after this many passes (default 64 when no limit is given).
    #[arg(long, value_name = "PASSES", value_parser = clap::value_parser!(u64).range(1..))]
    samples: Option<u64>,
    /// Stop after this time: 90s, 1.5m, 2h.
    #[arg(long, value_name = "TIME", value_parser = parse_time)]
    time: Option<Duration>,
    /// Stop at this relative error, e.g. 0.01; with another limit given too, exit 1 if it was not met.
    #[arg(long, value_name = "REL", value_parser = parse_error)]
    error: Option<f64>,
    /// Which way of tracing light to use.
    #[arg(long, value_enum, default_value_t)]
    estimator: EstimatorArg,
    /// Trace the polarisation of light: where a pilot finds that it matters, always, or never (the mean of both
    /// polarisations at each face, which is wrong after the first oblique one).
    #[arg(long, value_enum, value_name = "WHEN", default_value_t)]
    polarisation: PolarisationArg,
    /// Linear colour space of the picture: Rec.709 with D65, ACEScg (AP1), or CIE XYZ with D65.
    #[arg(long, value_enum, value_name = "SPACE", default_value_t)]
    color: ColorArg,
    /// Render by this plan (`eyebox plan -o`) instead of making one.
    #[arg(long, value_name = "PLAN.json")]
    plan: Option<PathBuf>,
    /// Seed of the random numbers: the same seed gives the same bits for any number of threads.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Make only the passes of shard I of N, for `eyebox merge`: the same asset and options on every machine.
    #[arg(long, value_name = "I/N", value_parser = parse_shard, conflicts_with_all = ["time", "error"])]
    shard: Option<[u64; 2]>,
    /// Write what is done every now and then (60s, 5m) to OUT.checkpoint.exr, which is removed at the end.
    #[arg(long, value_name = "TIME", value_parser = parse_time)]
    checkpoint: Option<Duration>,
    /// Go on from OUT.checkpoint.exr if it is there.
    #[arg(long)]
    resume: bool,
    /// Threads; all cores by default.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Width and height in pixels, instead of the eye's.
    #[arg(long, value_name = "WxH", value_parser = parse_resolution)]
    resolution: Option<[usize; 2]>,
    /// Write only these layers (and the default image), not those that the asset asks for: direct, caustic_led, stderr, Z, …
    #[arg(long, value_name = "LAYER,…", value_delimiter = ',')]
    layers: Vec<String>,
    /// Whose standard errors to write: of the picture, or of every layer, group, `open` and `content` too (with the
    /// covariance of these two).
    #[arg(long, value_enum, value_name = "OF", default_value_t)]
    stderr: StderrArg,
    /// Write the variance of every layer whose standard error is known, too (LAYER_variance, hybrid_variance): implies
    /// --stderr layers.
    #[arg(long)]
    variance: bool,
    /// Write a layer of your own: a light path expression in OSL's syntax that takes whole classes of paths of light
    /// groups, e.g. glints='C<.[Ss]>*<.[DG]><.[Ss]>+<L.'led'>'. More than one may be given.
    #[arg(long = "aov", value_name = "NAME=LPE", value_parser = aov::parse_option)]
    aovs: Vec<(String, String)>,
    /// Write Cryptomatte layers, too: CryptoPart and CryptoRole of what is met first, CryptoPartSeen and CryptoRoleSeen
    /// of what is met behind specular faces.
    #[arg(long)]
    cryptomatte: bool,
    /// Begin the names of all layers but the default image with this, e.g. eb_: Nuke has layers `forward` and `mask` of its
    /// own. Our commands read such a file as if there were no prefix.
    #[arg(long, value_name = "PREFIX", value_parser = parse_prefix)]
    layer_prefix: Option<String>,
    /// Give every layer a part of its own in the EXR, the default image the first. (Natron and Fusion read one part better.)
    #[arg(long)]
    multi_part: bool,
    /// Spread the light as the lit part of the pupil does by diffraction. Without this the picture is geometric; the limit
    /// is in the header either way.
    #[arg(long)]
    diffraction: bool,
    /// Write the stated error after 2, 4, 8, … passes into the header too, for the plot of `eyebox report`.
    #[arg(long, conflicts_with_all = ["shard", "resume"])]
    convergence: bool,
    /// Change an attribute: PART-OR-GROUP.ATTRIBUTE=VALUE, e.g. led.flux_lm=0.5, eye.pupil_diameter="3 mm".
    #[arg(long = "set", value_name = "TARGET.ATTRIBUTE=VALUE")]
    sets: Vec<String>,
    /// The time code at which a USD asset is taken; its own values without time, else the earliest, if not said.
    #[arg(long, value_name = "TIME", value_parser = super::parse_frame, allow_negative_numbers = true)]
    frame: Option<f64>,
    /// One file for each of these whole time codes, each imported by itself; limits hold for each. A frame that fails is
    /// reported and the others go on (exit code 2). Ctrl-C keeps what is done and does not write the frame under way.
    #[arg(long, value_name = "A-B[xS]", value_parser = parse_frames, allow_hyphen_values = true, conflicts_with = "frame")]
    frames: Option<Frames>,
    /// Leave out frames whose file is there.
    #[arg(long, requires = "frames")]
    skip_existing: bool,
    /// How progress is shown: a bar on a terminal and lines in a pipe, or the lines that Open Job Description engines read.
    #[arg(long, value_enum, default_value_t)]
    progress: ProgressArg,
    /// No progress and no summary.
    #[arg(short, long)]
    quiet: bool,
    /// How the summary is printed.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum EstimatorArg {
    /// The plan decides per light group and path class.
    #[default]
    Auto,
    /// Path tracing from the eye.
    Backward,
    /// Light tracing from the lamps into the pupil.
    Forward,
    /// Photon map for caustic and secondary.
    Photon,
    /// Specular connection of lamps and pupil; light tracing for what it leaves.
    Manifold,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum PolarisationArg {
    #[default]
    Auto,
    On,
    Off,
}

impl PolarisationArg {
    pub fn asked(self) -> Polarisation {
        match self {
            PolarisationArg::Auto => Polarisation::Auto,
            PolarisationArg::On => Polarisation::On,
            PolarisationArg::Off => Polarisation::Off,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum ColorArg {
    #[default]
    Rec709,
    Acescg,
    Xyz,
}

impl ColorArg {
    fn space(self) -> ColourSpace {
        match self {
            ColorArg::Rec709 => ColourSpace::Rec709,
            ColorArg::Acescg => ColourSpace::AcesCg,
            ColorArg::Xyz => ColourSpace::Xyz,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum StderrArg {
    /// `stderr`: of `hybrid`.
    #[default]
    Picture,
    /// Also LAYER_stderr, LAYER_GROUP_stderr, …_open_stderr, …_content_stderr and …_covariance.
    Layers,
}

impl EstimatorArg {
    pub fn choice(self) -> Choice {
        match self {
            EstimatorArg::Auto => Choice::Auto,
            EstimatorArg::Backward => Choice::Only(Estimator::Backward),
            EstimatorArg::Forward => Choice::Only(Estimator::Forward),
            EstimatorArg::Photon => Choice::Only(Estimator::Photon),
            EstimatorArg::Manifold => Choice::Only(Estimator::Manifold),
        }
    }
}

fn parse_time(text: &str) -> std::result::Result<Duration, String> {
    let bad = || format!("`{text}` is not a time; write e.g. 90s, 1.5m or 2h");
    let split = text.find(|c: char| c.is_alphabetic()).unwrap_or(text.len());
    let (number, unit) = text.split_at(split);
    let seconds: f64 = number.trim().parse().map_err(|_| bad())?;
    let factor = match unit.trim() {
        "ms" => 1e-3,
        "" | "s" => 1.0,
        "m" | "min" => 60.0,
        "h" => 3600.0,
        _ => return Err(bad()),
    };
    Duration::try_from_secs_f64(seconds * factor).map_err(|_| bad())
}

fn parse_error(text: &str) -> std::result::Result<f64, String> {
    match text.parse::<f64>() {
        Ok(error) if error > 0.0 && error.is_finite() => Ok(error),
        Ok(_) | Err(_) => Err(format!("`{text}` is not a relative error; write e.g. 0.01 for 1 %")),
    }
}

pub fn parse_resolution(text: &str) -> std::result::Result<[usize; 2], String> {
    let bad = || format!("`{text}` is not a resolution; write e.g. 360x180");
    let (width, height) = text.split_once(['x', 'X', '×']).ok_or_else(bad)?;
    match (width.trim().parse(), height.trim().parse()) {
        (Ok(width), Ok(height)) if width > 0 && height > 0 => Ok([width, height]),
        (_, _) => Err(bad()),
    }
}

/// Runs the command.
pub fn run(args: &RenderArgs) -> Result<ExitCode> {
    let signals = Signals::install();
    match args.frames {
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
    /// Another limit came before the error that was asked for.
    Unmet,
    /// By a signal.
    Stopped,
}

/// Renders one frame. `partial`: whether the passes until a signal are written.
pub fn one(args: &RenderArgs, signals: &Signals, partial: bool) -> Result<Ended> {
    let start = Instant::now();
    let args = &RenderArgs { output: named(&args.output, args.frame)?, ..args.clone() };
    check_destination(&args.output)?;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(args.threads.map_or(0, usize::from))
        .build()
        .map_err(|error| Fault::new(Where::Option("--threads".to_owned()), error.to_string()))?;
    let sets = args.sets.iter().map(|text| Set::parse(text)).collect::<Result<Vec<_>>>()?;
    let Built { mut scene, layers: wishes, .. } = import(&args.asset, &ImportOptions { sets, frame: args.frame })?;
    if let Some(resolution) = args.resolution {
        scene.eye.resolution = resolution;
    }
    let checked = check(&scene)?;
    check_layers(&args.layers, &scene.groups)?;
    let world = World::freeze(&scene)?;
    let stop = || signals.caught().is_some();
    let asked = Asked { choice: args.estimator.choice(), polarisation: args.polarisation.asked() };
    let behind = if args.resume { resume(&args.output, &|head| args.is_mine(head, &scene))? } else { None };
    let plan = match (&args.plan, &behind) {
        (Some(path), _) => Some(Frozen::read(path, &scene, asked)?.plan),
        (None, Some((head, _))) => {
            Some(Frozen::of_value(&head.plan, &checkpoint_of(&args.output), &scene, asked)?.plan)
        }
        (None, None) => pool.install(|| plan_unless(&checked, &world, asked, &stop)),
    };
    let Some(mut plan) = plan else { return Ok(stopped(args, "before the first pass")) };
    let pupils = pool.install(|| survey(&checked, &world, asked, &plan, &stop));
    if stop() {
        return Ok(stopped(args, "before the first pass"));
    }
    let mut sharpness = Sharpness::new(&pupils, scene.wavelengths.traced_nm(), world.eye.pixel());
    let diffraction = args.diffraction.then(|| spread_by(&scene, &checked, &world, &pupils));
    let frozen = Frozen::new(&scene, asked, &plan);
    plan.errors = args.errors();
    // What the command line asks for goes before what the asset asks for.
    let wishes: &[LayerWish] = if args.layers.is_empty() { &wishes } else { &[] };
    let (named_layers, ungranted) = wish::granted(wishes, &scene.groups);
    let (aovs, refused) = aov::granted(&args.aovs, wishes, &scene, &world, &plan)?;
    scene.notes.extend(ungranted.into_iter().chain(refused));
    let mut limits = args.limits();
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
        return Err(Fault::new(Where::file(&checkpoint_of(&args.output)), "is of another plan").expected(frozen.hash));
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
    let mut saver =
        Saver { progress: &mut progress, head: head.clone(), path, every, last: Instant::now(), failed: None };
    let outcome = pool.install(|| {
        let mut tracing = begin(&world, &plan, groups, size, args.seed);
        tracing.start(start).then(|| drive(tracing, &limits, &mut saver))
    });
    let Some(outcome) = outcome else {
        return Err(Fault::new(Where::file(&saver.path), "keeps other sums than this run")
            .expected("the same options, or no file of this name"));
    };
    saver.close(&outcome.films, outcome.stop == Stop::Asked);
    progress.finish();
    if !partial && stop() {
        return Ok(stopped(args, "before the frame was done"));
    }
    let finished = pool.install(|| head.finishing.picture(&outcome.films))?;
    sharpness.applied = finished.applied;
    let mut frame = finished.frame;
    add_data_layers(&mut frame, &pool.install(|| data_layers(&world, size[0], size[1])));
    let Wanted { layers, named, .. } = &head.finishing.wanted;
    let mattes = mattes::wanted(args.cryptomatte, layers.iter().chain(named.iter().map(|wish| &wish.layer)));
    pool.install(|| mattes::add(&mut frame, &scene, &world, &mattes));
    frame.meta.insert(COLOR_INTEROP_ID.to_owned(), Meta::Text(args.color.space().interop_id().to_owned()));
    frame.meta.insert("planHash".to_owned(), Meta::Text(frozen.hash));
    add_meta(&mut frame, &scene, &plan, &outcome, args.seed, &finished.splits);
    add_sharpness(&mut frame, &sharpness);
    if args.convergence {
        let errors = serde_json::json!(progress.errors()).to_string();
        frame.meta.insert("convergence".to_owned(), Meta::Text(errors));
    }
    let warnings = if args.shard.is_some() {
        shard::save(&args.output, &head, &outcome.films, &frame)?;
        Vec::new()
    } else {
        head.finishing.wanted.keep(&mut frame);
        write_exr(&args.output, &frame)?
    };
    if !args.quiet {
        summary(args, &scene, &plan, &outcome, &sharpness, &warnings)?;
    }
    let met = args.error.is_none_or(|limit| outcome.films.relative_error().is_some_and(|error| error <= limit));
    Ok(match (outcome.stop, signals.caught()) {
        (Stop::Asked, Some(_)) => Ended::Stopped,
        (Stop::Passes | Stop::Time, _) if !met => Ended::Unmet,
        (Stop::Passes | Stop::Time | Stop::Error | Stop::Asked, _) => Ended::Met,
    })
}

impl RenderArgs {
    pub fn output(&self) -> &Path {
        &self.output
    }
    pub fn skips_existing(&self) -> bool {
        self.skip_existing
    }
    pub fn is_quiet(&self) -> bool {
        self.quiet
    }

    /// The same for one frame of a sequence.
    pub fn of_frame(&self, output: PathBuf, frame: f64) -> RenderArgs {
        RenderArgs { output, frame: Some(frame), frames: None, ..self.clone() }
    }

    /// Standard errors of layers are kept if they are asked for, be it by name.
    fn errors(&self) -> ErrorDetail {
        let errors = ["_stderr", "_covariance", "_variance"];
        let named = |layer: &String| errors.iter().any(|error| layer.ends_with(error));
        match self.stderr {
            StderrArg::Picture if !self.variance && !self.layers.iter().any(named) => ErrorDetail::Picture,
            StderrArg::Picture | StderrArg::Layers => ErrorDetail::Layers,
        }
    }

    /// Which layers are written, and how.
    fn wanted(&self, named: Vec<Named>, aovs: Vec<Aov>) -> Wanted {
        Wanted {
            layers: self.layers.clone(),
            named,
            only_named: aovs.len() > self.aovs.len(),
            aovs,
            variance: self.variance || self.layers.iter().any(|layer| layer.ends_with("_variance")),
            prefix: self.layer_prefix.clone(),
            multi_part: self.multi_part,
        }
    }

    /// What a shard or a checkpoint of this run says of itself.
    fn head(&self, scene: &Scene, frozen: &Frozen, finishing: Finishing) -> Head {
        let total = self.limits().passes;
        let (first, passes) = match (self.shard, total) {
            (Some(of), Some(total)) => shard::range(of, total),
            (_, _) => (0, 0),
        };
        Head {
            eyebox: frozen.eyebox.clone(),
            scene: scene.hash.clone(),
            parts: scene.parts.len(),
            plan: serde_json::json!(frozen),
            plan_hash: frozen.hash.clone(),
            seed: self.seed,
            eye: serde_json::json!(scene.eye),
            of: self.shard,
            total,
            first,
            passes,
            films: Vec::new(),
            finishing,
        }
    }

    /// Whether a checkpoint is of this run; else what differs.
    fn is_mine(&self, head: &Head, scene: &Scene) -> Result<(), String> {
        let differs = |what: &str| Err(format!("{what} differs"));
        if head.scene != scene.hash || head.eye != serde_json::json!(scene.eye) {
            return differs("the scene");
        }
        if head.seed != self.seed {
            return differs("the seed");
        }
        if head.of != self.shard || (self.shard.is_some() && head.total != self.limits().passes) {
            return differs("the shard");
        }
        Ok(())
    }

    fn limits(&self) -> Limits {
        let none = self.samples.is_none() && self.time.is_none() && self.error.is_none();
        let passes = if none { Some(DEFAULT_PASSES) } else { self.samples };
        Limits { passes, time: self.time, error: self.error }
    }
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

/// Without a picture an older file stays as it is.
fn stopped(args: &RenderArgs, when: &str) -> Ended {
    anstream::eprintln!("eyebox: stopped {when}; {} was not written", args.output.display());
    Ended::Stopped
}

/// Fails early where the picture could not be written: an hour of tracing must not end in a typing error.
fn check_destination(output: &Path) -> Result<()> {
    if output.extension().is_none_or(|e| !e.eq_ignore_ascii_case("exr")) {
        return Err(Fault::new(Where::file(output), "is no name for an EXR file").expected("a name that ends in .exr"));
    }
    check_writable(output)
}

fn summary(
    args: &RenderArgs,
    scene: &Scene,
    plan: &Plan,
    outcome: &Outcome,
    sharpness: &Sharpness,
    warnings: &[String],
) -> Result<()> {
    let error = outcome.films.relative_error();
    let text = || {
        let warnings_of_scene = scene.notes.iter().filter(|note| note.severity == Severity::Warning);
        let mut lines: Vec<String> =
            warnings_of_scene.map(|note| format!("warning: {}: {}", note.at, note.text)).collect();
        lines.extend(plan_lines(scene, plan));
        lines.extend(sharpness.lines());
        lines.extend(warnings.iter().map(|warning| format!("warning: {warning}")));
        let error = error.map_or("unknown error".to_owned(), |e| format!("error {:.2} %", 100.0 * e));
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
            "seed": args.seed,
            "passes": outcome.films.passes,
            "seconds": outcome.elapsed.as_secs_f64(),
            "stop": outcome.stop,
            "relative_error": error,
            "plan": plan,
            "diffraction": sharpness,
            "ledgers": outcome.films.films.iter().map(|(e, _, l)| (e.name(), l)).collect::<Vec<_>>(),
            "notes": scene.notes,
            "warnings": warnings,
        })
    };
    print(args.format, text, json)
}
