//! Floor 7: one file per subcommand: arguments → calls, no logic.
//!
//! Exit codes: 0 clean, 1 findings (or a stated error not met), 2 usage or failure, 130, 143 and 129 after Ctrl-C, SIGTERM and
//! SIGHUP (with a valid file).

/// A line on stderr. `eprintln!` panics where nobody reads any more, as after a dropped connection, and the picture is lost.
macro_rules! tell {
    ($($said:tt)*) => {{
        let line = format!("{}\n", format_args!($($said)*));
        let _ = std::io::Write::write_all(&mut anstream::stderr().lock(), line.as_bytes());
    }};
}

mod annotate;
mod bench;
mod chains;
mod completions;
mod convert;
mod diff;
mod ending;
mod frames;
mod glass;
mod init;
mod inspect;
mod job;
mod man;
mod measure;
mod merge;
mod mix;
mod moment;
mod paths;
mod plan;
pub mod printer;
pub mod progress;
mod rays;
mod render;
mod render_args;
mod report;
mod scan;
mod sensor;
mod shards;
pub mod source;
mod table_file;
pub mod threads;
mod tolerance;
mod validate;
mod view;
mod witnessed;

use crate::author::Written;
use crate::base::{Error, Result};
use crate::scene::assembly::Assembly;
use crate::scene::{Note, Severity};
use clap::{Parser, Subcommand, ValueEnum};
use printer::{print, print_text};
pub use render_args::parse_resolution;
use std::process::ExitCode;

/// Trace a head-up-display or AR assembly into one layered EXR in absolute cd/m².
#[derive(Parser, Debug)]
#[command(
    name = "eyebox",
    version,
    propagate_version = true,
    after_help = "Examples:\n  eyebox init hud.glb -o hud.optics.toml\n  eyebox inspect hud.optics.toml\n  eyebox render samples/hud-direct/hud.optics.toml -o hud.exr\n  eyebox view hud.exr -o hud.png\n  eyebox mix hud.exr --gain led=0.5 -o dim.exr\n  eyebox diff a.exr b.exr\n  eyebox measure hud.exr"
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Debug)]
enum Command {
    /// Trace an assembly into a layered EXR.
    Render(render_args::RenderArgs),
    /// Show an assembly as a tree, with lamps, eye, and all notes from reading it.
    Inspect(inspect::InspectArgs),
    /// Say which estimator traces which light, and why, without rendering.
    Plan(plan::PlanArgs),
    /// List the ways of light from the lamps to the eye: main image, ghosts, stray light.
    Paths(paths::PathsArgs),
    /// Write light paths as lines to look at, and say where their light ends.
    Rays(rays::RaysArgs),
    /// List the glasses and films that are known by name, with their indices.
    Glass(glass::GlassArgs),
    /// Write a sidecar to start from.
    Init(init::InitArgs),
    /// Write a copy of an asset that carries the attributes of a sidecar itself.
    Annotate(annotate::AnnotateArgs),
    /// Write an assembly in another format, with all its optical attributes.
    Convert(convert::ConvertArgs),
    /// Change lamp levels, contrast and background of a rendered frame.
    Mix(mix::MixArgs),
    /// Add up the shards of a rendering: the result has the bits of a run on one machine.
    Merge(merge::MergeArgs),
    /// Write a job template that a farm runs in shards.
    Job(job::JobArgs),
    /// Compare two frames by their standard errors.
    Diff(diff::DiffArgs),
    /// Measure a frame as a display.
    Measure(measure::MeasureArgs),
    /// Look at the virtual image from a grid of eye positions.
    Scan(scan::ScanArgs),
    /// Measure the light that arrives at faces: illuminance maps of lamps, sun and sky through the optics.
    Sensor(sensor::SensorArgs),
    Tolerance(tolerance::ToleranceArgs),
    /// Turn a layer of an EXR into a PNG for a display.
    View(view::ViewArgs),
    /// Make one page of a frame: pictures that recombine live, measurements, light paths, plan, convergence.
    Report(report::ReportArgs),
    /// Check assets by rules, for CI: findings with their lines, in text, JSON, SARIF, JUnit or GitHub's form.
    Validate(validate::ValidateArgs),
    /// Measure the program: time against error, and answers that are known. `eyebox-bench` does it.
    Bench(bench::BenchArgs),
    /// Print a script that lets a shell complete `eyebox`.
    Completions(completions::CompletionsArgs),
    /// Print the manual page, or write one for every command.
    Man(man::ManArgs),
}

/// How a command prints its result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum Format {
    #[default]
    Text,
    Json,
}

/// Runs the program with the arguments of the process.
pub fn main() -> ExitCode {
    with_arguments(|cli: &Cli| match &cli.command {
        Command::Render(args) => render::run(args),
        Command::Inspect(args) => inspect::run(args),
        Command::Plan(args) => plan::run(args),
        Command::Paths(args) => paths::run(args),
        Command::Rays(args) => rays::run(args),
        Command::Glass(args) => glass::run(args),
        Command::Init(args) => init::run(args),
        Command::Annotate(args) => annotate::run(args),
        Command::Convert(args) => convert::run(args),
        Command::Mix(args) => mix::run(args),
        Command::Merge(args) => merge::run(args),
        Command::Job(args) => job::run(args),
        Command::Diff(args) => diff::run(args),
        Command::Measure(args) => measure::run(args),
        Command::Scan(args) => scan::run(args),
        Command::Sensor(args) => sensor::run(args),
        Command::Tolerance(args) => tolerance::run(args),
        Command::View(args) => view::run(args),
        Command::Validate(args) => validate::run(args),
        Command::Bench(args) => bench::run(args),
        Command::Report(args) => report::run(args),
        Command::Completions(args) => completions::run(args),
        Command::Man(args) => man::run(args),
    })
}

/// Does what the arguments of the process ask for, and says in one line on stderr what is wrong with them or with it.
pub fn with_arguments<C: Parser>(run: impl FnOnce(&C) -> Result<ExitCode>) -> ExitCode {
    let cli = match C::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version go to stdout with 0; a usage error is one line on stderr with 2.
            if error.use_stderr() {
                say(&Error::new(crate::base::Where::Nowhere, one_line(&error.to_string())));
            } else {
                match printer::judged(error.print()) {
                    Ok(()) => {}
                    Err(fault) => {
                        say(&fault);
                        return ExitCode::from(2);
                    }
                }
            }
            return ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2));
        }
    };
    match run(&cli) {
        Ok(code) => code,
        Err(fault) => {
            say(&fault);
            ExitCode::from(2)
        }
    }
}

/// The message of a usage error without its usage block, in one line.
fn one_line(text: &str) -> String {
    let lines =
        text.lines().map(str::trim).take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more"));
    let said: Vec<&str> = lines.filter(|line| !line.is_empty()).collect();
    said.join(" ").trim_start_matches("error: ").to_owned()
}

/// One line on stderr, red `error` on terminals that want colour.
fn say(fault: &Error) {
    let red = anstyle::AnsiColor::Red.on_default().bold();
    tell!("{red}error{red:#}: {fault}");
}

/// A time code of `--frame`.
fn parse_frame(text: &str) -> std::result::Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(frame) if frame.is_finite() => Ok(frame),
        Ok(_) | Err(_) => Err(format!("`{text}` is not a time code; write e.g. 12 or 12.5")),
    }
}

/// Prints which files were written, what the format can't say, and warnings from reading.
fn authored(format: Format, assembly: &Assembly, written: &Written) -> Result<ExitCode> {
    let warnings = assembly.notes.iter().filter(|note| note.severity == Severity::Warning);
    let notes: Vec<&Note> = warnings.chain(&written.notes).collect();
    let line = |note: &&Note| {
        let severity = if note.severity == Severity::Warning { "warning" } else { "note" };
        let at = note.at.to_string();
        if at.is_empty() { format!("{severity}: {}", note.text) } else { format!("{severity}: {at}: {}", note.text) }
    };
    let text = || {
        let files = written.files.iter().map(|file| file.display().to_string());
        notes.iter().map(line).chain(files).collect::<Vec<_>>().join("\n")
    };
    print(format, text, || serde_json::json!({ "files": written.files, "notes": notes }))?;
    Ok(ExitCode::SUCCESS)
}
