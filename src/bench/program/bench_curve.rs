//! `eyebox bench ASSET…`: time against error.

use clap::Args;
use eyebox::cmd::parse_resolution;
use eyebox::cmd::printer::print_text;
use eyebox::cmd::progress::Signals;
use eyebox::cmd::source::sets;
use eyebox::cmd::threads::pool;
use eyebox_base::atomic::{check_writable, write_atomic};
use eyebox_base::{Error, Result, Where};
use eyebox_bench::curve::asset::{Form, Task, measure};
use eyebox_bench::curve::race::Budget;
use eyebox_bench::curve::reference::Source;
use eyebox_bench::curve::{Report, contenders, name};
use eyebox_plan::Choice;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// What a reference costs if nothing is said: this many times the seconds of a contender.
const REFERENCE_FACTOR: f64 = 4.0;

#[derive(Args, Debug)]
pub struct CurveArgs {
    /// Assets (or sidecars) on which to take time against error.
    #[arg(value_name = "ASSET")]
    assets: Vec<PathBuf>,
    /// Who traces: auto, backward, forward, photon, …; all if not said.
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    estimators: Vec<String>,
    /// CPU seconds of tracing for each estimator on each asset; at least one pass is made.
    #[arg(long, value_name = "SECONDS", value_parser = parse_seconds, default_value = "10")]
    seconds: f64,
    /// End each curve after this many passes, if the seconds last.
    #[arg(long, value_name = "PASSES", value_parser = clap::value_parser!(u64).range(1..))]
    passes: Option<u64>,
    /// Two EXR files of independent runs (other seeds), instead of references made on the spot.
    #[arg(long, value_name = "EXR", conflicts_with_all = ["reference_estimator", "reference_passes", "reference_seconds"])]
    reference: Vec<PathBuf>,
    /// Who traces the references.
    #[arg(long, value_name = "NAME", default_value = "auto")]
    reference_estimator: String,
    /// Passes of each reference, if the seconds last.
    #[arg(long, value_name = "PASSES", value_parser = clap::value_parser!(u64).range(1..))]
    reference_passes: Option<u64>,
    /// CPU seconds of each of the two references; without them 4 times `--seconds`, or no limit if there are passes.
    #[arg(long, value_name = "SECONDS", value_parser = parse_seconds)]
    reference_seconds: Option<f64>,
    /// Threads.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024), default_value_t = 1)]
    threads: u16,
    /// Seed of the contenders; the references have others.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Width and height in pixels, instead of the eye's.
    #[arg(long, value_name = "WxH", value_parser = parse_resolution)]
    resolution: Option<[usize; 2]>,
    /// Change an attribute: PART-OR-GROUP.ATTRIBUTE=VALUE.
    #[arg(long = "set", value_name = "TARGET.ATTRIBUTE=VALUE")]
    sets: Vec<String>,
    /// Also write the result to this file, in the form of its name: .txt, .json, .csv, .svg, .md. May be given several
    /// times.
    #[arg(short, long, value_name = "FILE", requires = "assets")]
    output: Vec<PathBuf>,
}

fn parse_seconds(text: &str) -> std::result::Result<f64, String> {
    match text.strip_suffix('s').unwrap_or(text).parse::<f64>() {
        Ok(seconds) if seconds > 0.0 && seconds.is_finite() => Ok(seconds),
        Ok(_) | Err(_) => Err(format!("`{text}` is not a time in seconds; write e.g. 10")),
    }
}

impl CurveArgs {
    pub fn has_assets(&self) -> bool {
        !self.assets.is_empty()
    }

    pub fn task(&self) -> Result<Task> {
        let all = contenders();
        let contenders = if self.estimators.is_empty() {
            all
        } else {
            self.estimators.iter().map(|text| choice("--estimators", text)).collect::<Result<Vec<_>>>()?
        };
        let budget = Budget { seconds: self.seconds, passes: self.passes };
        let sets = sets(&self.sets)?;
        Ok(Task { contenders, source: self.source()?, seed: self.seed, budget, resolution: self.resolution, sets })
    }

    pub fn assets(&self) -> &[PathBuf] {
        &self.assets
    }

    pub fn pool(&self) -> Result<rayon::ThreadPool> {
        pool(Some(self.threads))
    }

    fn source(&self) -> Result<Source> {
        let fault = |what: &str| Error::new(Where::Option("--reference".to_owned()), what).expected("two EXR files");
        match (self.reference.as_slice(), self.assets.len()) {
            ([], _) => {
                let unsaid =
                    if self.reference_passes.is_some() { f64::INFINITY } else { REFERENCE_FACTOR * self.seconds };
                Ok(Source::Traced {
                    choice: choice("--reference-estimator", &self.reference_estimator)?,
                    passes: self.reference_passes,
                    seconds: self.reference_seconds.unwrap_or(unsaid),
                })
            }
            ([first, second], 1) if first != second => Ok(Source::Files([first.clone(), second.clone()])),
            ([_, _], 1) => Err(fault("the same file twice is one reference")),
            ([_, _], _) => Err(fault("files belong to one asset, and there are several")),
            (_, _) => Err(fault("one error needs two references")),
        }
    }
}

fn choice(option: &str, text: &str) -> Result<Choice> {
    let all = contenders();
    all.iter().copied().find(|choice| name(*choice) == text.trim()).ok_or_else(|| {
        let names: Vec<&str> = all.iter().copied().map(name).collect();
        Error::new(Where::Option(format!("{option} {text}")), "no such estimator")
            .expected(names.join(", "))
            .nearest(text, names)
    })
}

/// The form that a file's name asks for.
fn form_of(path: &Path) -> Result<Form> {
    match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("txt") => Ok(Form::Text),
        Some("json") => Ok(Form::Json),
        Some("csv") => Ok(Form::Csv),
        Some("svg") => Ok(Form::Svg),
        Some("md") => Ok(Form::Markdown),
        Some(_) | None => {
            Err(Error::new(Where::file(path), "does not say its form")
                .expected("a name in .txt, .json, .csv, .svg, .md"))
        }
    }
}

/// Runs the command for its assets; `form`: what goes to stdout.
pub fn run(args: &CurveArgs, form: Form) -> Result<ExitCode> {
    let task = args.task()?;
    for path in &args.output {
        form_of(path)?;
        check_writable(path)?;
    }
    let signals = Signals::install();
    let stop = || signals.caught().is_some();
    let threads = usize::from(args.threads);
    let pool = args.pool()?;
    let mut report = Report::new(threads, task.seed);
    for path in args.assets.iter().take_while(|_| !stop()) {
        report.assets.push(pool.install(|| measure(path, &task, &stop))?);
    }
    for path in &args.output {
        write_atomic(path, report.in_form(form_of(path)?).as_bytes())?;
    }
    print_text(report.in_form(form))?;
    Ok(if stop() { signals.exit_code() } else { ExitCode::SUCCESS })
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::{CommandFactory, FromArgMatches, Parser};

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        curve: CurveArgs,
    }

    fn parse(line: &str) -> CurveArgs {
        let matches = Line::command().get_matches_from(format!("bench {line}").split_whitespace());
        Line::from_arg_matches(&matches).expect(line).curve
    }

    #[test]
    fn references_are_two() {
        assert!(matches!(parse("a.glb").source(), Ok(Source::Traced { choice: Choice::Auto, .. })));
        assert!(matches!(parse("a.glb --reference 1.exr --reference 2.exr").source(), Ok(Source::Files(_))));
        for bad in [
            "a.glb --reference 1.exr",
            "a.glb --reference 1.exr --reference 1.exr",
            "a.glb b.glb --reference 1.exr --reference 2.exr",
        ] {
            assert!(parse(bad).source().is_err(), "{bad}");
        }
    }

    #[test]
    fn every_estimator_has_its_name() {
        assert_eq!(parse("a.glb").task().unwrap().contenders, contenders());
        for one in contenders() {
            assert_eq!(choice("--estimators", name(one)).unwrap(), one);
        }
        let fault = choice("--estimators", "bakward").unwrap_err().to_string();
        assert!(fault.contains("backward"), "{fault}");
        assert!(form_of(Path::new("a.svg")).is_ok() && form_of(Path::new("a.png")).is_err());
    }
}
