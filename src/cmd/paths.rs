//! `eyebox paths`: by which parts light gets to the eye, and how much of it.

use super::source::{Source, told};
use super::threads::Threads;
use super::{Format, print};
use crate::base::Result;
use crate::check::check;
use crate::import::Built;
use crate::plan::paths::{Asked, table};
use crate::scene::Severity;
use crate::world::World;
use clap::Args;
use std::process::ExitCode;

/// List the ways of light from the lamps to the eye, most light first: the main image, ghosts, stray light.
#[derive(Args, Debug)]
#[command(after_help = "\
A row is a sequence of parts; a reflection is named by the side of a solid (front: from outside, back: inside and out again \
by the same face), `inside` where it leaves by another face. `A | B`: from the lamp to a scatterer, and from it to the eye. \
A ghost meets the parts of the main path alone and shows the same; stray light comes by other parts or past a slide. docs/paths.md has the definitions.

Examples:
  eyebox paths samples/hud-direct/hud.optics.toml
  eyebox paths hud.optics.toml --least 1e-4 --format json
  eyebox paths hud.optics.toml --set 'COMBINER.coating=none' --paths 65536 --threads 4
  eyebox render hud.optics.toml -o hud.exr --chain ghost=2")]
pub struct PathsArgs {
    /// Leave out ways with less of all light than this.
    #[arg(long, value_name = "SHARE", default_value_t = Asked::LEAST, value_parser = share)]
    least: f64,
    /// Paths from the lamps, and from the eye where it looks too. Four times as many halve the errors.
    #[arg(long, value_name = "N", default_value_t = Asked::PATHS, value_parser = clap::value_parser!(u64).range(1..=1 << 28))]
    paths: u64,
    #[command(flatten)]
    source: Source,
    #[command(flatten)]
    threads: Threads,
    /// Trace the polarisation of light: where a pilot finds that it matters, always, or never.
    #[arg(long, value_enum, value_name = "WHEN", default_value_t)]
    polarisation: super::render_args::PolarisationArg,
    /// How the result is printed.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

fn share(text: &str) -> std::result::Result<f64, String> {
    match text.parse::<f64>() {
        Ok(share) if share > 0.0 && share < 1.0 => Ok(share),
        Ok(_) | Err(_) => Err(format!("`{text}` is not a share; write e.g. 1e-6")),
    }
}

/// Runs the command.
pub fn run(args: &PathsArgs) -> Result<ExitCode> {
    args.threads.within(|| traced(args))
}

fn traced(args: &PathsArgs) -> Result<ExitCode> {
    let Built { mut scene, .. } = args.source.import()?;
    args.source.adapt_eye(&mut scene, args.polarisation.asked(), &|| false)?;
    let checked = check(&scene)?;
    let world = World::freeze(&scene)?;
    let asked = Asked { least: args.least, paths: args.paths, polarisation: args.polarisation.asked() };
    let Some(table) = table(&checked, &world, asked, &|| false) else { return Ok(ExitCode::SUCCESS) };
    let warnings = || scene.notes.iter().filter(|note| note.severity == Severity::Warning);
    let text = || told(&scene).into_iter().chain([table.text()]).collect::<Vec<_>>().join("\n");
    let json = || {
        let mut json = serde_json::json!(table);
        json["scene"] = serde_json::json!(scene.name);
        json["scene_hash"] = serde_json::json!(scene.hash);
        json["warnings"] = serde_json::json!(warnings().collect::<Vec<_>>());
        json
    };
    print(args.format, text, json)?;
    Ok(ExitCode::SUCCESS)
}
