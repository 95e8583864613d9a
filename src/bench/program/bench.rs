//! `eyebox bench`: the program measured.

use crate::bench_choice::{self, ChoiceArgs};
use crate::bench_curve::{self, CurveArgs};
use clap::{Args, ValueEnum};
use eyebox::cmd::printer::print_text;
use eyebox_base::document::document;
use eyebox_base::{Error, Result, Where};
use eyebox_bench::curve::asset::Form;
use eyebox_bench::stress::{self, Kind, table};
use std::process::ExitCode;

/// Measure the program: time against error of each estimator on assets, or scenes at the limits of numbers against
/// answers that are known.
#[derive(Args, Debug)]
#[command(after_help = "\
With assets, each estimator traces in turn, and the picture after 1, 2, 4, 8, … passes is held against two independent \
references. docs/bench.md defines the columns. Seconds are CPU seconds; import, plan and pilots are in them.

With --stress, each case prints the mean luminance of its picture, by how many standard errors that misses the closed form, which share \
of the light no fate accounts for, and how many values are no numbers. What is out of limits is a finding.

With --generate, the automatic choice is held against every choice by hand on scenes from seeds; with --error, the error \
that runs state against the one they have; with --bias, its pictures against plain sampling.

Exit codes: 0 no finding, 1 findings, 2 usage.

Examples:
  eyebox bench samples/hud-direct/hud.optics.toml
  eyebox bench a1.optics.toml a2.optics.toml --seconds 16 -o curves.svg -o curves.csv -o results.md
  eyebox bench hud.optics.toml --estimators auto,forward --reference r1.exr --reference r2.exr
  eyebox bench --generate 0..12 --seconds 2
  eyebox bench --generate 0..14 --families assemblies --seconds 2
  eyebox bench --generate 0..100 --families all --seconds 1 --bias
  eyebox bench a2.optics.toml --error 0.1 --runs 100 --reference-estimator photon --seconds 60
  eyebox bench --generate 0..7 --error 0.05 --runs 40 --reference-estimator backward --seconds 10
  eyebox bench --stress
  eyebox bench --stress --only critical --only gap
  eyebox bench --stress --format json
  eyebox bench --stress --format markdown > benches/stress.md")]
pub struct BenchArgs {
    #[command(flatten)]
    curve: CurveArgs,
    #[command(flatten)]
    choice: ChoiceArgs,
    /// Run the numerical stress suite.
    #[arg(long, conflicts_with = "assets")]
    stress: bool,
    /// Only cases of this kind; may be given several times.
    #[arg(long, value_name = "KIND", requires = "stress")]
    only: Vec<String>,
    /// How the result is printed.
    #[arg(long, value_enum, default_value_t)]
    format: BenchFormat,
}

/// How a benchmark is printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum BenchFormat {
    #[default]
    Text,
    Json,
    /// The page of the documentation.
    #[value(alias = "md")]
    Markdown,
    /// One row per point of a curve.
    Csv,
    /// The curves as a picture.
    Svg,
}

impl BenchFormat {
    fn form(self) -> Form {
        match self {
            BenchFormat::Text => Form::Text,
            BenchFormat::Json => Form::Json,
            BenchFormat::Markdown => Form::Markdown,
            BenchFormat::Csv => Form::Csv,
            BenchFormat::Svg => Form::Svg,
        }
    }
}

/// Runs the command.
pub fn run(args: &BenchArgs) -> Result<ExitCode> {
    if let Some(code) = bench_choice::run(&args.choice, &args.curve, args.format.form())? {
        return Ok(code);
    }
    if args.curve.has_assets() {
        return bench_curve::run(&args.curve, args.format.form());
    }
    if !args.stress {
        return Err(Error::new(Where::Nowhere, "nothing to measure").expected("assets, --generate, or --stress"));
    }
    if matches!(args.format, BenchFormat::Csv | BenchFormat::Svg) {
        return Err(Error::new(Where::Option("--format".to_owned()), "a stress report has no such form")
            .expected("text, json, markdown"));
    }
    let kinds = kinds(&args.only)?;
    if args.format == BenchFormat::Text {
        print_text(table::head())?;
    }
    let mut printed = Ok(());
    let report = stress::run(&kinds, &mut |row| {
        if args.format == BenchFormat::Text && printed.is_ok() {
            printed = print_text(table::line(row));
        }
    });
    printed?;
    match args.format {
        BenchFormat::Text => print_text(table::summary(&report))?,
        BenchFormat::Json => print_text(document(serde_json::json!(report)))?,
        BenchFormat::Markdown => {
            let seconds = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
            let cores = std::thread::available_parallelism().map_or(1, usize::from);
            print_text(table::page(&report, seconds.as_secs(), cores))?;
        }
        BenchFormat::Csv | BenchFormat::Svg => {}
    }
    Ok(ExitCode::from(u8::from(report.findings() > 0)))
}

/// The kinds of these names; all if there are none.
fn kinds(names: &[String]) -> Result<Vec<Kind>> {
    if names.is_empty() {
        return Ok(Kind::ALL.to_vec());
    }
    let all = Kind::ALL.map(Kind::name);
    names
        .iter()
        .map(|name| {
            Kind::ALL.into_iter().find(|kind| kind.name() == name).ok_or_else(|| {
                Error::new(Where::Option(format!("--only {name}")), "no such kind of case").expected(all.join(", "))
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn help_has_an_example_and_kinds_are_known() {
        let help = BenchArgs::augment_args(clap::Command::new("bench")).render_long_help().to_string();
        assert!(help.contains("eyebox bench --stress"), "{help}");
        assert_eq!(kinds(&[]).unwrap().len(), Kind::ALL.len());
        assert_eq!(kinds(&["gap".to_owned()]).unwrap(), [Kind::Gap]);
        assert!(kinds(&["gab".to_owned()]).unwrap_err().to_string().contains("gap"));
    }
}
