//! `eyebox validate`.

use super::print_text;
use super::printer::print_coloured;
use super::threads::Threads;
use crate::base::{Error, Result, Where};
use crate::validate::config::Config;
use crate::validate::report::{Style, render, summary};
use crate::validate::stdin::{self, Piped};
use crate::validate::{baseline, page, rules, validate_with};
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
  eyebox validate assets/                     (every sidecar in it, and every asset that no sidecar and no asset names)
  exporter | eyebox validate -                (told by its content; references from the working directory)
  eyebox validate hud.usda --format github
  eyebox validate hud.optics.toml --write-baseline eyebox-baseline.json
  eyebox validate hud.optics.toml --baseline eyebox-baseline.json
  eyebox validate --explain EB0102")]
pub struct ValidateArgs {
    /// Sidecars (*.optics.toml), assets (.glb, .gltf, .usda, .usdc, .usdz), or folders: all sidecars in them, and all assets
    /// that none of these names and that are no layers of others. `-` is one asset or sidecar on standard input.
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
            Error::new(at, "there is no such rule")
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
    let piped = args.piped()?;
    let report = args.threads.within(|| validate_with(&args.assets, piped.as_ref(), &config, &known))?;
    if let Some(path) = &args.write_baseline {
        baseline::write(path, &report)?;
    }
    let text = render(&report, args.format);
    match args.format {
        Style::Text => print_coloured(text)?,
        Style::Json | Style::Github => print_text(text)?,
        Style::Sarif | Style::Junit => {
            print_text(text)?;
            // These have no place for it.
            if report.layers > 0 {
                tell!("eyebox: {}", summary(&report));
            }
        }
    }
    let passes = report.is_clean() || args.exit_zero || config.exit_zero || args.write_baseline.is_some();
    Ok(ExitCode::from(u8::from(!passes)))
}

impl ValidateArgs {
    /// Standard input, if it is among the assets.
    fn piped(&self) -> Result<Option<Piped>> {
        let named = self.assets.iter().filter(|asset| asset.as_os_str() == stdin::NAMED).count();
        let fault = |what: &str| Error::new(Where::Option(stdin::NAMED.to_owned()), what);
        match (named, &self.write_baseline) {
            (0, _) => Ok(None),
            // All that comes through pipes has one name: a baseline would hide the findings of one in another.
            (_, Some(_)) => Err(fault("standard input has no name that a baseline could know it by")
                .expected("a file with --write-baseline")),
            (1, None) => Ok(Some(Piped::read(&mut std::io::stdin().lock())?)),
            (_, None) => Err(fault("standard input is named more than once").expected("one `-`")),
        }
    }
}
