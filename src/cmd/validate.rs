//! `eyebox validate`.

use super::print_text;
use super::printer::print_coloured;
use super::threads::Threads;
use crate::base::{Fault, Result, Where};
use crate::validate::config::Config;
use crate::validate::report::{Style, render};
use crate::validate::{baseline, page, rules, validate};
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Args, Debug)]
#[command(after_help = "\
Looks at assets without rendering them: units, solids, shapes, media, coatings, lamps, slides, the eye, bindings, and \
whether light reaches the eye at all. Every finding has the code of its rule (docs/validate.md); errors and warnings end \
with exit code 1, notes don't. An asset that cannot be read is a finding; a path that is not there is a usage error \
(exit 2). eyebox.toml in the working directory says which rules hold and how grave they are; a baseline hides what is \
known.

Examples:
  eyebox validate hud.optics.toml
  eyebox validate assets/*.glb --format sarif > eyebox.sarif
  eyebox validate assets/                     (every sidecar in it, and every asset that no sidecar names)
  eyebox validate hud.usda --format github
  eyebox validate hud.optics.toml --write-baseline eyebox-baseline.json
  eyebox validate hud.optics.toml --baseline eyebox-baseline.json
  eyebox validate --explain EB0102")]
pub struct ValidateArgs {
    /// Sidecars (*.optics.toml), assets (.glb, .gltf, .usda, .usdc, .usdz), or folders: all sidecars in them, and all assets
    /// that none of these names.
    #[arg(required_unless_present = "explain", value_name = "ASSET")]
    assets: Vec<PathBuf>,
    /// How the findings are printed.
    #[arg(long, value_enum, default_value_t)]
    format: Style,
    /// Which rules hold, and how grave they are; eyebox.toml in the working directory if there is one.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Hide the findings that this file knows.
    #[arg(long, value_name = "FILE")]
    baseline: Option<PathBuf>,
    /// Write the findings to this file as known, and end with 0.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["baseline", "explain"])]
    write_baseline: Option<PathBuf>,
    /// End with 0 whatever is found.
    #[arg(long)]
    exit_zero: bool,
    /// Print the page of a rule, by its code or name.
    #[arg(long, value_name = "CODE", conflicts_with = "assets")]
    explain: Option<String>,
    #[command(flatten)]
    threads: Threads,
}

/// Runs the command.
pub fn run(args: &ValidateArgs) -> Result<ExitCode> {
    if let Some(code) = &args.explain {
        let rule = rules::find(code).ok_or_else(|| {
            let at = Where::Option(format!("--explain {code}"));
            Fault::new(at, "there is no such rule")
                .expected("a code like EB0102, or a rule's name")
                .nearest(code, rules::words())
        })?;
        print_text(page::page(rule))?;
        return Ok(ExitCode::SUCCESS);
    }
    let config = args.config.as_ref().map_or_else(Config::beside, |path| Config::read(path))?;
    let known = match (&args.write_baseline, args.baseline.as_ref().or(config.baseline.as_ref())) {
        (None, Some(path)) => baseline::read(path)?,
        (Some(_), _) | (None, None) => baseline::Known::default(),
    };
    let report = args.threads.within(|| validate(&args.assets, &config, &known))?;
    if let Some(path) = &args.write_baseline {
        baseline::write(path, &report)?;
    }
    let text = render(&report, args.format);
    match args.format {
        Style::Text => print_coloured(text)?,
        Style::Json | Style::Sarif | Style::Junit | Style::Github => print_text(text)?,
    }
    let passes = report.is_clean() || args.exit_zero || config.exit_zero || args.write_baseline.is_some();
    Ok(ExitCode::from(u8::from(!passes)))
}
