//! `eyebox sensor`: the light that arrives at faces.

use super::progress::Signals;
use super::render_args::{PolarisationArg, parse_error, parse_time};
use super::source::{Source, told};
use super::threads::Threads;
use super::{Format, print};
use crate::base::atomic::check_writable;
use crate::base::{Error, Result, Where};
use crate::output::exr::write_exr;
use crate::plan::sensor::frame::frame;
use crate::plan::sensor::table::lines;
use crate::plan::sensor::{SensorAsked, SensorMap, measure};
use crate::scene::{Note, Severity};
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

/// Measure the light that arrives at faces: illuminance maps of lamps, sun and sky through the optics.
#[derive(Args, Debug)]
#[command(after_help = "\
A face with `sensor = { pixels = [64, 32] }` has a map of its illuminance in lx on either side, with a standard error for each \
pixel; where the scene's wavelengths are visible, of its irradiance in W/m² from 360 to 830 nm, too. Light is traced from the \
lamps, aimed by a pilot at the face, or from the face, whichever has less noise. The eye takes no light. A sensor that no light \
reaches is a warning, with exit code 1. docs/sensor.md has the definitions.

Examples:
  eyebox sensor hud.optics.toml
  eyebox sensor hud.optics.toml --set 'LCD.sensor={ pixels = [64, 32] }' -o lcd.exr --error 0.02
  eyebox sensor hud.optics.toml --part HUD/LCD --samples 256 --seed 2 --format json --threads 4")]
pub struct SensorArgs {
    /// Write the map to this file; of several sensors each to one of its own, MAP.PART.FACE.exr.
    #[arg(short, long, value_name = "MAP.exr")]
    output: Option<PathBuf>,
    /// Stop after this many passes of each sensor (default 64 when no limit is given).
    #[arg(long, value_name = "PASSES", value_parser = clap::value_parser!(u64).range(1..))]
    samples: Option<u64>,
    /// Stop after this time for each sensor: 90s, 1.5m, 2h.
    #[arg(long, value_name = "TIME", value_parser = parse_time)]
    time: Option<Duration>,
    /// Stop at this relative error of a map's pixels, e.g. 0.01; with another limit given too, exit 1 if it was not met.
    #[arg(long, value_name = "REL", value_parser = parse_error)]
    error: Option<f64>,
    /// Only the sensors of this part: its path or name.
    #[arg(long, value_name = "PART")]
    part: Option<String>,
    /// Where light is traced from: from the lamps or from the sensor, whichever has less noise; or all of it from the sensor, to
    /// compare with (points and parallel light are not found so).
    #[arg(long, value_enum, default_value_t)]
    estimator: SensorEstimator,
    /// Trace the polarisation of light: where any face is specular, always, or never (the mean of both polarisations at each
    /// face, which is wrong after the first oblique one).
    #[arg(long, value_enum, value_name = "WHEN", default_value_t)]
    polarisation: PolarisationArg,
    /// Seed of the random numbers: the same seed gives the same bits for any number of threads.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    source: Source,
    #[command(flatten)]
    threads: Threads,
    /// No progress.
    #[arg(short, long)]
    quiet: bool,
    /// How the result is printed.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Where light is traced from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum SensorEstimator {
    #[default]
    Auto,
    Backward,
}

/// Runs the command.
pub fn run(args: &SensorArgs) -> Result<ExitCode> {
    args.threads.within(|| traced(args))
}

fn traced(args: &SensorArgs) -> Result<ExitCode> {
    if let Some(output) = &args.output {
        if !output.extension().is_some_and(|end| end.eq_ignore_ascii_case("exr")) {
            return Err(Error::new(Where::file(output), "is no name for a map").expected("a name that ends in .exr"));
        }
        check_writable(output)?;
    }
    let signals = Signals::install();
    let scene = args.source.import()?.scene;
    let asked = SensorAsked {
        passes: args.samples,
        time: args.time,
        error: args.error,
        seed: args.seed,
        polarisation: args.polarisation.asked(),
        backward: args.estimator == SensorEstimator::Backward,
        only: args.part.clone(),
    };
    let found = measure(&scene, &asked, &|| signals.caught().is_some(), |done, all| {
        if !args.quiet && all > 1 {
            tell!("eyebox: {done} of {all} sensors");
        }
    })?;
    let Some(found) = found else {
        tell!("eyebox: stopped; nothing was written");
        return Ok(signals.exit_code());
    };
    let mut files = Vec::new();
    for map in &found {
        let Some(output) = &args.output else { break };
        let file = if found.len() == 1 { output.clone() } else { file_of(output, map, &files) };
        write_exr(&file, &frame(map, args.seed))?;
        files.push(file);
    }
    let dark = |map: &SensorMap| map.sides.iter().all(|side| side.peak.is_none());
    let missed = |map: &SensorMap| args.error.is_some_and(|asked| map.error.is_none_or(|error| error > asked));
    let findings = found.iter().filter_map(|map| {
        let of = format!("{} face {}", map.part, map.face);
        if dark(map) {
            Some(format!("{of}: no light arrived, of {} paths", map.paths))
        } else if missed(map) {
            let error = map.error.map_or("is unknown".to_owned(), |error| format!("is {:.3} %", 100.0 * error));
            Some(format!("{of}: its error {error}, not what was asked for"))
        } else {
            None
        }
    });
    let findings: Vec<String> = findings.collect();
    let warnings = || scene.notes.iter().filter(|note| note.severity == Severity::Warning);
    let json = || {
        serde_json::json!({
            "asset": args.source.asset,
            "sensors": found,
            "files": files,
            "findings": findings,
            "warnings": warnings().collect::<Vec<&Note>>(),
        })
    };
    let text = || {
        let said = findings.iter().map(|finding| format!("warning: {finding}"));
        let written = files.iter().map(|file| file.display().to_string());
        told(&scene).into_iter().chain(lines(&found)).chain(said).chain(written).collect::<Vec<_>>().join("\n")
    };
    print(args.format, text, json)?;
    Ok(ExitCode::from(u8::from(!findings.is_empty())))
}

/// The file of one sensor of several: MAP.PART.FACE.exr, what is no letter, digit, `-` or `_` in the part's path a `_`; parts whose
/// paths become alike are told apart by more of these.
fn file_of(output: &Path, map: &SensorMap, taken: &[PathBuf]) -> PathBuf {
    let is_plain = |c: char| c.is_alphanumeric() || c == '_' || c == '-';
    let part: String = map.part.chars().map(|c| if is_plain(c) { c } else { '_' }).collect();
    let mut name = format!("{part}.{}.exr", map.face);
    while taken.contains(&output.with_extension(&name)) {
        name.insert(0, '_');
    }
    output.with_extension(name)
}
