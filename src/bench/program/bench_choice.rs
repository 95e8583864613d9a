//! `eyebox bench --generate A..B` and `eyebox bench ASSET --error REL`: is the choice right, is the stated error true?

use crate::bench_curve::CurveArgs;
use clap::Args;
use eyebox::cmd::printer::print_text;
use eyebox::cmd::progress::Signals;
use eyebox_base::document::document;
use eyebox_base::{Error, Result, Where};
use eyebox_bench::agreement::{self, Summary};
use eyebox_bench::choice::{head, judge, line};
use eyebox_bench::curve::asset::Form;
use eyebox_bench::curve::race::Budget;
use eyebox_bench::generate::{Families, Family, scene_of};
use eyebox_bench::stated::{Stated, measure, measure_scene};
use eyebox_estimate::ShouldStop;
use std::ops::Range;
use std::process::ExitCode;
use std::str::FromStr;

/// References of generated scenes take this many times a contender's seconds each: brute force is slow.
const REFERENCE_FACTOR: f64 = 8.0;
/// Share of the runs whose stated error must hold.
const HONEST: f64 = 0.9;

#[derive(Args, Debug)]
pub struct ChoiceArgs {
    /// Hold the automatic choice against every choice by hand on the scenes of these seeds; exit 1 if it is slower than
    /// 1.3 of the best, or differs from brute force.
    #[arg(long, value_name = "SEED..SEED", value_parser = parse_range, conflicts_with_all = ["assets", "stress"])]
    generate: Option<Range<u64>>,
    /// The families of scenes that seeds take turns over, seed mod their number: `first` (displays like the two samples and
    /// rooms), `assemblies` (a windshield HUD, birdbath, combiner, light guide, microlenses, two slides, a car's cabin), `all`, or
    /// names with commas between them, e.g. `cabin,light-guide`. The family and the seed alone make a scene.
    #[arg(long, value_name = "FAMILIES", default_value = "first", value_parser = Families::from_str, requires = "generate")]
    families: Families,
    /// Hold the automatic choice's pictures of these scenes against plain sampling instead: the deviates of all blocks and energies
    /// against normal ones, and what each run's witness says; exit 1 if there is a bias.
    #[arg(long, requires = "generate", conflicts_with = "error")]
    bias: bool,
    /// Trace the asset, or the scenes of `--generate`, with many seeds until this relative error is stated, and hold the
    /// true error against it; exit 1 if fewer than nine in ten are true within 1.2 of it, or the references are too rough to
    /// tell.
    #[arg(long, value_name = "REL", value_parser = parse_error)]
    error: Option<f64>,
    /// How many seeds.
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u64).range(1..), default_value_t = 100, requires = "error")]
    runs: u64,
}

fn parse_range(text: &str) -> std::result::Result<Range<u64>, String> {
    let bad = || format!("`{text}` is no range of seeds; write e.g. 0..12");
    let (first, end) = text.split_once("..").ok_or_else(bad)?;
    match (first.trim().parse(), end.trim().parse()) {
        (Ok(first), Ok(end)) if first < end => Ok(first..end),
        (_, _) => Err(bad()),
    }
}

fn parse_error(text: &str) -> std::result::Result<f64, String> {
    match text.parse::<f64>() {
        Ok(error) if error > 0.0 && error < 1.0 => Ok(error),
        Ok(_) | Err(_) => Err(format!("`{text}` is no relative error; write e.g. 0.02")),
    }
}

/// Runs the command if it is for one of these.
pub fn run(args: &ChoiceArgs, curve: &CurveArgs, form: Form) -> Result<Option<ExitCode>> {
    let json = match form {
        Form::Json => true,
        Form::Text => false,
        Form::Csv | Form::Svg | Form::Markdown if args.generate.is_none() && args.error.is_none() => false,
        Form::Csv | Form::Svg | Form::Markdown => {
            let fault = Error::new(Where::Option("--format".to_owned()), "this report has no such form");
            return Err(fault.expected("text, json"));
        }
    };
    match (&args.generate, args.error) {
        (Some(seeds), None) if args.bias => biased(seeds.clone(), &args.families, curve, json).map(Some),
        (Some(seeds), None) => generated(seeds.clone(), &args.families, curve, json).map(Some),
        (_, Some(error)) => stated(error, args, curve, json).map(Some),
        (None, None) => Ok(None),
    }
}

fn generated(seeds: Range<u64>, families: &Families, curve: &CurveArgs, json: bool) -> Result<ExitCode> {
    let judged = |family, seed, seconds, stop: &ShouldStop<'_>| judge(family, seed, seconds, REFERENCE_FACTOR, stop);
    let (rows, stopped) = each_seed(seeds, families, curve, (json, head(), line), judged)?;
    if json {
        print_text(document(serde_json::json!({ "choices": rows })))?;
    }
    let sound = rows.iter().all(|row| row.is_fast() && row.agreement.holds());
    Ok(stopped.unwrap_or(ExitCode::from(u8::from(!sound))))
}

fn biased(seeds: Range<u64>, families: &Families, curve: &CurveArgs, json: bool) -> Result<ExitCode> {
    let told = (json, agreement::head(), agreement::line as fn(&_) -> _);
    let (rows, stopped) = each_seed(seeds, families, curve, told, agreement::agreement)?;
    let summary = Summary::new(&rows);
    if json {
        print_text(document(serde_json::json!({ "agreement": rows, "summary": summary })))?;
    } else {
        print_text(agreement::summary(&summary))?;
    }
    Ok(stopped.unwrap_or(ExitCode::from(u8::from(!summary.holds()))))
}

/// A row for each seed, told as it comes but for JSON, until somebody stops the run; then with the exit code for that.
fn each_seed<R: Send>(
    seeds: Range<u64>,
    families: &Families,
    curve: &CurveArgs,
    (json, head, line): (bool, String, fn(&R) -> String),
    row_of: impl Fn(Family, u64, f64, &ShouldStop<'_>) -> Result<R> + Sync,
) -> Result<(Vec<R>, Option<ExitCode>)> {
    let signals = Signals::install();
    let stop = || signals.caught().is_some();
    let pool = curve.pool()?;
    let Budget { seconds, .. } = curve.task()?.budget;
    if !json {
        print_text(head)?;
    }
    let mut rows = Vec::new();
    for seed in seeds {
        let row = pool.install(|| row_of(families.of_seed(seed), seed, seconds, &stop))?;
        if stop() {
            break;
        }
        if !json {
            print_text(line(&row))?;
        }
        rows.push(row);
    }
    Ok((rows, stop().then(|| signals.exit_code())))
}

fn stated(error: f64, args: &ChoiceArgs, curve: &CurveArgs, json: bool) -> Result<ExitCode> {
    let (seeds, runs) = (args.generate.clone(), args.runs);
    let signals = Signals::install();
    let stop = || signals.caught().is_some();
    let (pool, task) = (curve.pool()?, curve.task()?);
    if seeds.is_none() && !curve.has_assets() {
        let fault = Error::new(Where::Option("--error".to_owned()), "there is nothing to trace");
        return Err(fault.expected("an asset or --generate SEED..SEED"));
    }
    let mut reports: Vec<Stated> = Vec::new();
    // Line by line: a hundred runs take their time.
    let mut printed = Ok(());
    let mut tell = |text: String| {
        if !json && printed.is_ok() {
            printed = print_text(text);
        }
    };
    for path in curve.assets().iter().take_while(|_| !stop()) {
        reports.push(pool.install(|| measure(path, &task, (error, runs), &stop, &mut tell))?);
    }
    for seed in seeds.into_iter().flatten().take_while(|_| !stop()) {
        let scene = scene_of(args.families.of_seed(seed), seed);
        let of_scene = || measure_scene(&scene, scene.name.clone(), &task, (error, runs), &stop, &mut tell);
        reports.push(pool.install(of_scene)?);
    }
    printed?;
    if json {
        print_text(document(serde_json::json!({ "stated": reports })))?;
    }
    let honest = |report: &Stated| report.is_told() && report.honest() as f64 >= HONEST * report.runs.len() as f64;
    let honest = reports.iter().all(honest);
    Ok(if stop() { signals.exit_code() } else { ExitCode::from(u8::from(!honest)) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_of_seeds() {
        assert_eq!(parse_range("3..12"), Ok(3..12));
        for bad in ["3", "3..", "4..3", "3..3", "a..b", "-1..3"] {
            assert!(parse_range(bad).is_err(), "{bad}");
        }
        assert!(parse_error("0.02").is_ok() && parse_error("2").is_err() && parse_error("NaN").is_err());
    }
}
