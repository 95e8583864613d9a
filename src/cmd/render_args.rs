//! What `eyebox render` can be asked for.

use super::Format;
use super::frames::{Frames, parse_frames};
use super::moment::Moment;
use super::progress::ProgressArg;
use super::shards::parse_shard;
use super::source::Source;
use super::threads::Threads;
use crate::base::colour::ColourSpace;
use crate::base::rng::{Rng, Stream};
use crate::estimate::aov;
use crate::estimate::finishing::{Finishing, Wanted};
use crate::estimate::render_vars::Named;
use crate::estimate::run::Limits;
use crate::estimate::shard::{self, Head};
use crate::film::aov::Aov;
use crate::film::crop::Crop;
use crate::film::error_detail::ErrorDetail;
use crate::film::plan::Estimator;
use crate::output::exr::{Packing, parse_prefix};
use crate::plan::plan_file::PlanFile;
use crate::plan::{Choice, Polarisation};
use crate::scene::Scene;
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// The most passes of a run that is given no limit at all, and the relative error at which it ends sooner.
const DEFAULT_PASSES: u64 = 64;
const DEFAULT_ERROR: f64 = 0.005;

#[derive(Args, Debug, Clone)]
#[command(after_help = "Examples:\n  \
    eyebox render samples/hud-direct/hud.optics.toml -o hud.exr\n  \
    eyebox render hud.optics.toml -o hud.exr --time 90s --set led.flux_lm=0.6 --set eye.pupil_diameter=\"3 mm\"\n  \
    eyebox render hud.optics.toml -o check.exr --estimator backward --samples 256 --seed 7\n  \
    eyebox render hud.optics.toml -o sharp.exr --diffraction\n  \
    eyebox render hud.optics.toml -o hud.exr --chain 'ghost=COMBINER*:back'\n  \
    eyebox render hud.optics.toml -o hud.3.exr --samples 256 --shard 3/7\n  \
    eyebox render hud.optics.toml -o hud.exr --time 2h --checkpoint 60s --resume\n  \
    eyebox render hud.usda -o hud.0012.exr --frame 12\n  \
    eyebox render hud.usda -o hud.####.exr --frames 1-24 --skip-existing")]
pub struct RenderArgs {
    /// The EXR to write; in hud.####.exr the digits of the frame take the place of #.
    #[arg(short, long, value_name = "OUT.exr")]
    pub output: PathBuf,
    /// Stop after this many passes. Without any limit a run ends at a stated error of 0.5 % of the whole picture, or after 64 passes.
    #[arg(long, value_name = "PASSES", value_parser = clap::value_parser!(u64).range(1..))]
    pub samples: Option<u64>,
    /// Stop after this time: 90s, 1.5m, 2h.
    #[arg(long, value_name = "TIME", value_parser = parse_time)]
    pub time: Option<Duration>,
    /// Stop at this relative error, e.g. 0.01; with another limit given too, exit 1 if it was not met.
    #[arg(long, value_name = "REL", value_parser = parse_error)]
    pub error: Option<f64>,
    /// Without --samples: give passes to the pixels and estimators that have most of the error (the layer `work` shows
    /// where they went), or give all pixels the same number.
    #[arg(long, value_enum, value_name = "WHETHER", default_value_t)]
    pub adaptive: AdaptiveArg,
    /// Which way of tracing light to use.
    #[arg(long, value_enum, default_value_t)]
    pub estimator: EstimatorArg,
    /// Trace the polarisation of light: where a pilot finds that it matters, always, or never (the mean of both
    /// polarisations at each face, which is wrong after the first oblique one).
    #[arg(long, value_enum, value_name = "WHEN", default_value_t)]
    pub polarisation: PolarisationArg,
    /// Start and aim paths without what pilots learned of where the light is. The picture has the same mean and more noise:
    /// for comparisons.
    #[arg(long)]
    pub unguided: bool,
    /// Linear colour space of the picture: Rec.709 with D65, ACEScg (AP1), or CIE XYZ with D65.
    #[arg(long, value_enum, value_name = "SPACE", default_value_t)]
    pub color: ColorArg,
    /// Render by this plan (`eyebox plan -o`) instead of making one.
    #[arg(long, value_name = "PLAN.json")]
    pub plan: Option<PathBuf>,
    /// Do not check the picture while it is traced. Without this option simple paths, with up to 5 % of the work, look for
    /// light that the picture lacks, and a warning says what is missing.
    #[arg(long)]
    pub no_witness: bool,
    /// Seed of the random numbers: the same seed gives the same bits for any number of threads.
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Make only the passes of shard I of N, for `eyebox merge`: the same asset and options on every machine.
    #[arg(long, value_name = "I/N", value_parser = parse_shard, conflicts_with_all = ["time", "error"])]
    pub shard: Option<[u64; 2]>,
    /// Write what is done every now and then (60s, 5m) to OUT.checkpoint.exr, which is removed when OUT is there.
    #[arg(long, value_name = "TIME", value_parser = parse_time)]
    pub checkpoint: Option<Duration>,
    /// Go on from OUT.checkpoint.exr if it is there. --time counts from this start on.
    #[arg(long, requires = "checkpoint")]
    pub resume: bool,
    #[command(flatten)]
    pub threads: Threads,
    /// Width and height in pixels, instead of the eye's.
    #[arg(long, value_name = "WxH", value_parser = parse_resolution)]
    pub resolution: Option<[usize; 2]>,
    /// Trace and write only this part: column and row of its top left pixel, from 0, width and height. Every pixel has the light,
    /// to the bit, that it has in the whole picture of as many passes; stated errors are pooled over what is traced.
    /// The EXR's data window is the part, its display window the picture. No witness looks beside it.
    #[arg(long, value_name = "X,Y,WxH", value_parser = Crop::parse, conflicts_with = "diffraction")]
    pub crop: Option<Crop>,
    /// Write only these layers (and the default image), not those that the asset asks for: direct, caustic_led, stderr, Z, …
    #[arg(long, value_name = "LAYER,…", value_delimiter = ',')]
    pub layers: Vec<String>,
    /// Whose standard errors to write: of the picture, or of every layer, group, `open` and `content` too (with the
    /// covariance of these two).
    #[arg(long, value_enum, value_name = "OF", default_value_t)]
    pub stderr: StderrArg,
    /// Write the variance of every layer whose standard error is known, too (LAYER_variance, hybrid_variance): implies
    /// --stderr layers.
    #[arg(long)]
    pub variance: bool,
    /// Write a layer of your own: the light that a light path expression in OSL's syntax takes, e.g.
    /// ghosts='C.*<RS>.*<RS>.*<L.'led'>'. More than one may be given.
    #[arg(long = "aov", value_name = "NAME=LPE", value_parser = aov::parse_option)]
    pub aovs: Vec<(String, String)>,
    /// Write Cryptomatte layers, too: CryptoPart, CryptoRole and CryptoMaterial of what is met first, …Seen
    /// of what is met behind specular faces.
    #[arg(long)]
    pub cryptomatte: bool,
    /// Begin the names of all layers (all names with a dot: not the default image, not Z) with this, e.g. eb_: Nuke has layers `forward` and `mask` of its
    /// own. Our commands read such a file as if there were no prefix.
    #[arg(long, value_name = "PREFIX", value_parser = parse_prefix)]
    pub layer_prefix: Option<String>,
    /// Give every layer a part of its own in the EXR, the default image the first. (Natron and Fusion read one part better.)
    #[arg(long)]
    pub multi_part: bool,
    /// Store the pictures as half floats, of 11 bits; data, identities and what is too bright for them stay whole.
    #[arg(long)]
    pub half: bool,
    /// How the EXR is compressed: zip (16 lines at a time), zips (line by line), piz (small for noisy pictures), none, or
    /// dwaa (small, with loss; with --multi-part, where data are spared) [default: zip]
    #[arg(long, value_name = "zip|zips|piz|none|dwaa", value_parser = Packing::parse)]
    pub compression: Option<Packing>,
    /// Spread the light as the lit part of the pupil does by diffraction. Without this the picture is geometric; the limit
    /// is in the header either way.
    #[arg(long)]
    pub diffraction: bool,
    /// Write the stated error after 2, 4, 8, … passes into the header too, for the plot of `eyebox report`.
    #[arg(long, conflicts_with_all = ["shard", "resume"])]
    pub convergence: bool,
    /// Add the layers motion and motion_seen: how far each pixel's surface, and what is seen behind specular faces, moves until the next
    /// frame; with --frame or --frames.
    #[arg(long)]
    pub motion: bool,
    /// Add a layer with the light of one way alone: NAME=N, row N of `eyebox paths`, or NAME=PART:HOW,… for all rows with
    /// these, e.g. ghost=COMBINER*:back. In luminance; may be given several times.
    #[arg(long = "chain", value_name = "NAME=N|PART:HOW", conflicts_with = "shard")]
    pub chains: Vec<String>,
    #[command(flatten)]
    pub source: Source,
    /// One file for each of these whole time codes or frames (1-24, 1-24x2, 1,3,5), each with noise of its own and imported by itself; limits hold for each. A frame that fails is
    /// reported and the others go on (exit code 2). Ctrl-C keeps what is done and does not write the frame under way.
    #[arg(long, value_name = "A-B[xS],…", value_parser = parse_frames, allow_hyphen_values = true, conflicts_with = "frame")]
    pub frames: Option<Frames>,
    /// Leave out frames whose file is there.
    #[arg(long, requires = "frames")]
    pub skip_existing: bool,
    /// How progress is shown: a bar on a terminal and lines in a pipe, or the lines that Open Job Description engines read.
    #[arg(long, value_enum, default_value_t)]
    pub progress: ProgressArg,
    /// No progress and no summary.
    #[arg(short, long)]
    pub quiet: bool,
    /// Say who traced what and why, where passes went, and how sharp the picture can be.
    #[arg(short, long, conflicts_with = "quiet")]
    pub verbose: bool,
    /// How the summary is printed.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
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

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum AdaptiveArg {
    #[default]
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
pub enum ColorArg {
    #[default]
    Rec709,
    Acescg,
    Xyz,
}

impl ColorArg {
    pub fn space(self) -> ColourSpace {
        match self {
            ColorArg::Rec709 => ColourSpace::Rec709,
            ColorArg::Acescg => ColourSpace::AcesCg,
            ColorArg::Xyz => ColourSpace::Xyz,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum StderrArg {
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

pub(super) fn parse_time(text: &str) -> std::result::Result<Duration, String> {
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

pub(super) fn parse_error(text: &str) -> std::result::Result<f64, String> {
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

struct Passes {
    first: u64,
    passes: u64,
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
        let moment = Moment { frame: Some(frame), ..self.source.moment.clone() };
        let source = Source { moment, ..self.source.clone() };
        RenderArgs { output, source, frames: None, ..self.clone() }
    }

    /// The seed of the passes: that of `--seed`, and at a time code one that hangs on both, or a sequence would move under a
    /// still pattern of noise. 53 bits, which every reader of JSON keeps.
    pub fn seed_of_passes(&self) -> u64 {
        match self.source.moment.frame {
            None => self.seed,
            Some(frame) => Rng::new(self.seed, Stream::Frame, frame.to_bits(), 0).next_u64() >> 11,
        }
    }

    /// Standard errors of layers are kept if they are asked for, be it by name.
    pub fn errors(&self, named: &[Named]) -> ErrorDetail {
        let errors = ["_stderr", "_covariance", "_variance"];
        let is_error = |layer: &String| errors.iter().any(|error| layer.ends_with(error));
        let asked = self.layers.iter().chain(named.iter().map(|own| &own.layer)).any(is_error);
        match self.stderr {
            StderrArg::Picture if !self.variance && !asked => ErrorDetail::Picture,
            StderrArg::Picture | StderrArg::Layers => ErrorDetail::Layers,
        }
    }

    /// Which layers are written, and how.
    pub fn wanted(&self, named: Vec<Named>, aovs: Vec<Aov>) -> Wanted {
        let mut layers = self.layers.iter().chain(named.iter().map(|own| &own.layer));
        let variance = self.variance || layers.any(|layer| layer.ends_with("_variance"));
        Wanted {
            layers: self.layers.clone(),
            named,
            only_named: aovs.len() > self.aovs.len(),
            aovs,
            variance,
            prefix: self.layer_prefix.clone(),
            multi_part: self.multi_part,
            half: self.half,
            compression: self.compression.map(|packing| packing.name().to_owned()),
            crop: self.crop,
        }
    }

    /// The first pass, and how many a shard has.
    fn passes(&self) -> Passes {
        let (first, passes) = match (self.shard, self.limits().passes) {
            (Some(of), Some(total)) => shard::range(of, total),
            (_, _) => (0, 0),
        };
        Passes { first, passes }
    }

    /// What a shard or a checkpoint of this run says of itself.
    pub fn head(&self, scene: &Scene, frozen: &PlanFile, finishing: Finishing) -> Head {
        let Passes { first, passes } = self.passes();
        let total = self.limits().passes;
        Head {
            eyebox: frozen.eyebox.clone(),
            scene: scene.hash.clone(),
            parts: scene.parts.len(),
            plan: serde_json::json!(frozen),
            plan_hash: frozen.hash.clone(),
            seed: self.seed_of_passes(),
            eye: serde_json::json!(scene.eye),
            of: self.shard,
            total,
            first,
            passes,
            films: Vec::new(),
            dealt: None,
            witness: None,
            finishing,
        }
    }

    /// Whether a checkpoint is of this run; else what differs.
    pub fn is_mine(&self, head: &Head, scene: &Scene) -> Result<(), String> {
        let mine = self.passes();
        let differs = |what: &str| Err(format!("{what} differs"));
        if head.scene != scene.hash || head.eye != serde_json::json!(scene.eye) {
            return differs("the scene");
        }
        if head.seed != self.seed_of_passes() {
            return differs("the seed");
        }
        if head.finishing.wanted.crop != self.crop {
            return differs("the crop");
        }
        if head.of != self.shard || (self.shard.is_some() && head.total != self.limits().passes) {
            return differs("the shard");
        }
        if head.dealt.is_some() && !self.limits().adaptive {
            return differs("where passes go (`--adaptive on`, no `--samples`)");
        }
        let most = if self.shard.is_some() { mine.passes } else { self.limits().passes.unwrap_or(u64::MAX) };
        if head.first != mine.first || head.passes > most {
            return differs("the number of passes");
        }
        Ok(())
    }

    /// It was not said when to stop.
    pub fn is_without_limits(&self) -> bool {
        self.samples.is_none() && self.time.is_none() && self.error.is_none()
    }

    pub fn limits(&self) -> Limits {
        let none = self.is_without_limits();
        let passes = if none { Some(DEFAULT_PASSES) } else { self.samples };
        // Shards are pieces of as many passes, whatever their error.
        let error = if none && self.shard.is_none() { Some(DEFAULT_ERROR) } else { self.error };
        // Shards are of passes of all pixels, and so is what `--samples` asks for. A checkpoint keeps whole passes or later ones.
        let adaptive = self.adaptive == AdaptiveArg::On && passes.is_none();
        let coarse = adaptive && self.time.is_some() && self.checkpoint.is_none() && !self.resume;
        Limits { passes, time: self.time, error, adaptive, coarse }
    }
}
