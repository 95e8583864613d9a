//! `eyebox inspect`: what an assembly is, as the program understands it.

use super::source::Source;
use super::{Format, print};
use crate::base::{Error, Result};
use crate::check::check;
use crate::import::deps::{Dependency, dependencies};
use crate::import::{geometry, outline};
use crate::output::assembly_tree::AssemblyTree;
use crate::output::geometry::GeometryFacts;
use crate::scene::Scene;
use crate::world::World;
use clap::Args;
use std::process::ExitCode;

/// Show an assembly as a tree: media, faces, lamps, slides, eye, sky and every note.
#[derive(Args, Debug)]
#[command(after_help = "\
Lengths are in mm of the world. Parts that are alike take one line with their count. Of ordinary \
materials kind, base colour (linear Rec.709), roughness, layers and the names of their textures are shown. Where the optical attributes can't be \
used, the geometry is shown all the same before the error (exit 2). What render would refuse is an error here too, after \
the tree. --geometry asks for no optics at all; --deps lists every file that is needed and ends with exit 1 if one is missing.

Examples:
  eyebox inspect samples/hud-direct/hud.optics.toml
  eyebox inspect hud.optics.toml --explain LENS_01_PMMA
  eyebox inspect hud.glb --geometry --format json
  eyebox inspect hud.optics.toml --deps
  eyebox inspect hud.optics.toml --set led.flux_lm=0.6 --format json
  eyebox inspect hud.usda --frame 12 --geometry")]
pub struct InspectArgs {
    /// Say of each attribute of a part (name, path or pattern) which line won.
    #[arg(long, value_name = "PART")]
    explain: Option<String>,
    #[command(flatten)]
    source: Source,
    /// Show the geometry alone, without optics: parts, triangles, bounds, materials, lights, cameras.
    #[arg(long, conflicts_with_all = ["explain", "sets"])]
    geometry: bool,
    /// List every file that the asset needs; exit 1 if one is missing.
    #[arg(long, conflicts_with_all = ["explain", "sets", "geometry"])]
    deps: bool,
    /// How the result is printed.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Runs the command.
pub fn run(args: &InspectArgs) -> Result<ExitCode> {
    if args.deps {
        let all = dependencies(&args.source.asset, &args.source.reading())?;
        print(args.format, || deps_text(&all), || serde_json::json!({ "files": all }))?;
        let missing = all.iter().any(|dependency| dependency.used && !dependency.there);
        return Ok(ExitCode::from(u8::from(missing)));
    }
    if args.geometry {
        let facts = GeometryFacts::new(&geometry(&args.source.asset, &args.source.reading())?);
        print(args.format, || facts.text(), || serde_json::json!(facts))?;
        return Ok(ExitCode::SUCCESS);
    }
    let built = args.source.import().map_err(|fault| args.shown(fault))?;
    let refused = refusal(&built.scene);
    match &args.explain {
        Some(part) => {
            let found = built.explained.find(part)?;
            let text = || found.iter().map(|part| part.text()).collect::<Vec<_>>().join("\n");
            print(args.format, text, || serde_json::json!({ "parts": found }))?;
        }
        None => show(args.format, &AssemblyTree::new(&built.scene))?,
    }
    refused.map_or(Ok(ExitCode::SUCCESS), Err)
}

/// What `render` would refuse before its first ray.
fn refusal(scene: &Scene) -> Option<Box<Error>> {
    check(scene).err().or_else(|| World::freeze(scene).err())
}

/// One file a line: what it is for, and whether it is there.
fn deps_text(all: &[Dependency]) -> String {
    let line = |dependency: &Dependency| {
        let Dependency { file, role, at, there, used } = dependency;
        let named = at.to_string();
        let named = if named.is_empty() { String::new() } else { format!(", named at {named}") };
        let state = match (there, used) {
            (true, true) => "",
            (true, false) => ", not used",
            (false, true) => ", MISSING",
            (false, false) => ", missing, not used",
        };
        format!("{} ({role}{named}){state}", file.display())
    };
    all.iter().map(line).collect::<Vec<_>>().join("\n")
}

fn show(format: Format, tree: &AssemblyTree) -> Result<()> {
    print(format, || tree.text(), || serde_json::json!(tree))
}

impl InspectArgs {
    /// Shows what can be shown in spite of `fault`, if the asset itself can be read.
    fn shown(&self, fault: Box<Error>) -> Box<Error> {
        if let (None, Ok(scene)) = (&self.explain, outline(&self.source.asset, &self.source.reading())) {
            let _ = show(self.format, &AssemblyTree::without_optics(&scene, &fault));
        }
        fault
    }
}
