//! `eyebox tolerance`: the virtual image of designs as they will be made.

use super::progress::Signals;
use super::source::{Source, told};
use super::table_file::TableFile;
use super::threads::Threads;
use super::{Format, print};
use crate::base::Result;
use crate::import::toml;
use crate::plan::Polarisation;
use crate::plan::tolerance::parameter::parameters;
use crate::plan::tolerance::table::{csv, lines};
use crate::plan::tolerance::{ToleranceAsked, Tolerances, tolerance};
use crate::scene::{Note, Severity};
use clap::Args;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::path::PathBuf;
use std::process::ExitCode;

/// Draw designs with parts, radii, thicknesses and indices off by their tolerances: what the virtual image does.
#[derive(Args, Debug)]
#[command(after_help = "\
TOLERANCES is a text file with a table for each part that may be off:

  [[tolerance]]
  part = \"HUD/WINDSHIELD\"             # path, name or pattern; or `group`, a node whose parts move together
  decenter_mm = [0.1, 0.1, 0.1]       # along the scene's x, y, z
  tilt_arcmin = [1, 1, 1]             # about x, y, z through its middle, or through `about_mm`
  index = 5e-4

  [[tolerance]]
  part = \"HUD/WINDSHIELD\"
  face = 1
  radius_percent = 0.1
  thickness_mm = 0.02
  wedge_arcmin = [0.2, 0.2]           # about the horizontal and the other axis across the face
  distribution = \"uniform\"            # numbers are half-widths; else normal, and they are standard deviations

The same seed draws the same numbers for a parameter, whatever else is in the file: two designs are compared by the same \
draws. docs/tolerance.md has the definitions.

Examples:
  eyebox tolerance hud.optics.toml tolerances.toml
  eyebox tolerance hud.optics.toml tolerances.toml --draws 4000 --seed 2 -o draws.csv
  eyebox tolerance hud.optics.toml tolerances.toml --format json --threads 4")]
pub struct ToleranceArgs {
    #[command(flatten)]
    source: Source,
    /// What may be off, and by how much (a TOML file, see below).
    tolerances: PathBuf,
    /// Designs that are drawn; 4 more are looked at for each parameter, in which it alone is off.
    #[arg(long, value_name = "N", default_value_t = 1000)]
    draws: usize,
    /// Seed of the draws.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Columns and rows of points of the picture.
    #[arg(long, value_name = "NxM", value_parser = super::scan::parse_grid, default_value = "5x5")]
    points: [usize; 2],
    /// The part that is the picture [default: the slide, lamp or screen that most of the field of view shows]
    #[arg(long, value_name = "PART")]
    target: Option<String>,
    /// Distance between the two eyes, mm.
    #[arg(long, value_name = "MM", default_value_t = 63.0)]
    ipd: f64,
    #[command(flatten)]
    threads: Threads,
    /// Write all draws to this file: .csv (a line per design: parameters, then figures) or .json (the statistics).
    #[arg(short, long, value_name = "OUT.csv|json")]
    output: Option<PathBuf>,
    /// No progress.
    #[arg(short, long)]
    quiet: bool,
    /// How the result is printed.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Runs the command.
pub fn run(args: &ToleranceArgs) -> Result<ExitCode> {
    args.threads.within(|| drawn(args))
}

fn drawn(args: &ToleranceArgs) -> Result<ExitCode> {
    let written = args.output.as_deref().map(TableFile::of).transpose()?;
    let signals = Signals::install();
    let mut scene = args.source.import()?.scene;
    args.source.adapt_eye(&mut scene, Polarisation::Auto, &|| signals.caught().is_some())?;
    let parameters = parameters(&toml::read_as(&args.tolerances, "file of tolerances")?, &scene)?;
    let asked = ToleranceAsked {
        draws: args.draws,
        seed: args.seed,
        points: args.points,
        target: args.target.clone(),
        ipd_m: 1e-3 * args.ipd,
    };
    let bar = if args.quiet {
        ProgressBar::hidden()
    } else {
        ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr())
    };
    if let Ok(style) = ProgressStyle::with_template("{pos}/{len} designs, {per_sec}, {eta} left") {
        bar.set_style(style);
    }
    let found = tolerance(&scene, &parameters, &asked, &|| signals.caught().is_some(), &|done, all| {
        bar.set_length(all as u64);
        bar.set_position(done as u64);
    });
    bar.finish_and_clear();
    let Some(found) = found? else {
        tell!("eyebox: stopped; nothing was written");
        return Ok(signals.exit_code());
    };
    let warnings: Vec<&Note> = scene.notes.iter().filter(|note| note.severity == Severity::Warning).collect();
    let json = || serde_json::json!({ "asset": args.source.asset, "tolerance": found, "warnings": warnings });
    if let Some(file) = written {
        file.write(|| csv(&found), json)?;
    }
    let text = || told(&scene).into_iter().chain(lines(&found)).collect::<Vec<_>>().join("\n");
    print(args.format, text, json)?;
    Ok(ending(&found))
}

/// Designs that could not be traced are findings.
fn ending(found: &Tolerances) -> ExitCode {
    ExitCode::from(u8::from(found.failed + found.failed_alone > 0))
}
