//! The last step of a rendering: what is said of it.

use super::Run;
use super::opened::Opened;
use super::planned::Planned;
use super::traced::Traced;
use crate::base::Result;
use crate::cmd::ending::stated;
use crate::cmd::print;
use crate::cmd::source::told;
use crate::estimate::ledger::Ledger;
use crate::estimate::picture::plan_lines;
use crate::estimate::run::{Films, Outcome, Stop};
use crate::film::accumulate::Film;
use crate::film::plan::Estimator;
use std::collections::BTreeMap;

impl Run<'_> {
    pub fn tell(&self, opened: &Opened, planned: &Planned, traced: &Traced) -> Result<()> {
        let args = &self.args;
        if args.quiet {
            return Ok(());
        }
        let Opened { scene, .. } = opened;
        let Planned { plan, sharpness, .. } = planned;
        let Traced { outcome, judgement, error, ending, .. } = traced;
        // What a pipe of the result should not hold.
        told(scene).iter().for_each(|line| tell!("{line}"));
        ending.warnings.iter().for_each(|warning| tell!("warning: {warning}"));
        let text = || {
            let mut lines = Vec::new();
            if args.verbose {
                lines.extend(plan_lines(scene, plan));
                lines.extend(sharpness.lines());
                lines.extend(dealt(&outcome.films));
            }
            let [width, height] = scene.eye.resolution;
            let (output, seconds) = (args.output.display(), outcome.elapsed.as_secs_f64());
            lines.push(format!("{output}: {width} × {height} pixels in cd/m², traced in {seconds:.1} s"));
            let of_all = if error.is_some() { " of the whole picture" } else { "" };
            lines.push(format!("{}{of_all}; {}", stated(*error, outcome.films.passes), self.why_it_ended(outcome)));
            lines.extend(witnessed(&ending.lines, args.verbose).into_iter().cloned());
            lines.push(format!(
                "next: `eyebox view {output} -o {}` makes a PNG, `eyebox report {output} -o {}` a page",
                args.output.with_extension("png").display(),
                args.output.with_extension("html").display()
            ));
            if !args.verbose {
                lines.push("who traced what, and why: --verbose, or the file's header".to_owned());
            }
            lines.join("\n")
        };
        let json = || {
            serde_json::json!({
                "output": args.output,
                "scene": scene.name,
                "scene_hash": scene.hash,
                "seed": args.seed_of_passes(),
                "passes": outcome.films.passes,
                "mean_passes": mean_passes(&outcome.films),
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

    fn why_it_ended(&self, outcome: &Outcome) -> String {
        let most = if outcome.films.dealt.rounds > 0 { "up to " } else { "" };
        let after = format!("it ended after {most}{} passes, ", outcome.films.passes);
        let why = match outcome.stop {
            Stop::Error if self.args.is_without_limits() => "below the 0.5 % that runs without limits go to",
            Stop::Error => "below the error that was asked for",
            Stop::Passes if self.args.shard.is_some() => "its part of the run",
            Stop::Passes if self.args.is_without_limits() => "the most that runs without limits make",
            Stop::Passes => "as many as were asked for",
            Stop::Time => "when its time was over",
            Stop::TooFar => "for the error that was asked for is out of reach",
            Stop::Asked => "for it was told to",
        };
        after + why
    }
}

/// Passes that a pixel of each estimator has on average.
fn mean_passes(films: &Films) -> BTreeMap<&'static str, f64> {
    films.films.iter().map(|(estimator, film, _)| (estimator.name(), film.mean_passes())).collect()
}

/// Where passes went, if pixels got passes of their own.
fn dealt(films: &Films) -> Option<String> {
    let of_film = |(estimator, film, _): &(Estimator, Film, Ledger)| {
        let most = film.most_passes();
        match film.sample_map() {
            Some(_) => format!("{} {} to {most}, {:.1} on average", estimator.name(), film.passes, film.mean_passes()),
            None => format!("{} {most}", estimator.name()),
        }
    };
    let each: Vec<String> = films.films.iter().map(of_film).collect();
    (films.dealt.rounds > 0).then(|| format!("passes where the error is (layer `work`): {}", each.join("; ")))
}

/// What is said of the witness: all of it, or what it saw of two kinds of light; if it saw none, why not of one.
fn witnessed(lines: &[String], verbose: bool) -> Vec<&String> {
    const FEW: usize = 2;
    if verbose {
        return lines.iter().collect();
    }
    let saw: Vec<&String> = lines.iter().filter(|line| line.contains('±') || line.contains('%')).take(FEW).collect();
    if saw.is_empty() { lines.iter().take(1).collect() } else { saw }
}
