//! `eyebox rays`: some light paths as lines for a viewer, and what became of all of them.

use super::source::{Source, told};
use super::threads::Threads;
use super::{Format, print};
use crate::base::atomic::check_writable;
use crate::base::{Error, Result, Where};
use crate::check::check;
use crate::import::Built;
use crate::output::rays::{self, Space};
use crate::plan::Polarisation;
use crate::plan::paths::rays::{Asked, From, rays};
use crate::scene::Severity;
use crate::world::World;
use clap::{Args, ValueEnum};
use glam::{DMat3, DVec3};
use std::path::PathBuf;
use std::process::ExitCode;

/// Paths that are counted in the table of fates, drawn or not.
const COUNTED: u64 = 1 << 14;

/// Write light paths as lines to look at beside the asset, and say where their light ends: why is it black?
#[derive(Args, Debug)]
#[command(after_help = "\
The table says where the light goes: from the lamps in shares of their flux, from the eye in shares of what it looks at. \
Lines are green where they arrive (at the eye, or from the eye at a lamp), red where they are absorbed, blue where they leave \
the scene; each has the names of the parts that it met. Units and axes are those of the asset, so that both files lie on each \
other in a viewer.

Examples:
  eyebox rays samples/hud-direct/hud.optics.toml -o rays.glb
  eyebox rays hud.optics.toml -o rays.usda --from eye --pixel 512,384
  eyebox rays hud.optics.toml --from eye --format json")]
pub struct RaysArgs {
    /// The file to write; without it only the table is printed.
    #[arg(short, long, value_name = "RAYS.glb|RAYS.usda")]
    output: Option<PathBuf>,
    /// Where paths start.
    #[arg(long, value_enum, value_name = "END")]
    from: Option<Start>,
    /// Paths that are drawn: half as they come, half from each end in turn.
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u64).range(1..=1 << 20))]
    count: u64,
    /// Only through this pixel, from the eye: column and row, from 0 at the upper left.
    #[arg(long, value_name = "X,Y", value_parser = parse_pixel)]
    pixel: Option<[usize; 2]>,
    /// Seed of the random numbers.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    source: Source,
    #[command(flatten)]
    threads: Threads,
    /// How the table is printed.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Start {
    /// On the lamps, by their flux.
    Lamp,
    /// In the pupil.
    Eye,
}

fn parse_pixel(text: &str) -> std::result::Result<[usize; 2], String> {
    let bad = || format!("`{text}` is not a pixel; write e.g. 512,384");
    let (x, y) = text.split_once(',').ok_or_else(bad)?;
    match (x.trim().parse(), y.trim().parse()) {
        (Ok(x), Ok(y)) => Ok([x, y]),
        (_, _) => Err(bad()),
    }
}

/// Runs the command.
pub fn run(args: &RaysArgs) -> Result<ExitCode> {
    args.threads.within(|| traced(args))
}

fn traced(args: &RaysArgs) -> Result<ExitCode> {
    if let Some(output) = &args.output {
        if !["glb", "usda"].contains(&rays::extension(output).as_str()) {
            return Err(rays::unknown(output));
        }
        check_writable(output)?;
    }
    if let (Some(Start::Lamp), Some(_)) = (args.from, args.pixel) {
        return Err(Error::new(Where::Option("--pixel".to_owned()), "a pixel is looked through from the eye")
            .expected("--from eye"));
    }
    let mut built = args.source.import()?;
    args.source.adapt_eye(&mut built.scene, Polarisation::Auto, &|| false)?;
    let Built { scene, .. } = &built;
    let checked = check(scene)?;
    let world = World::freeze(scene)?;
    let [width, height] = scene.eye.resolution;
    if let Some([x, y]) = args.pixel
        && (x >= width || y >= height)
    {
        return Err(Error::new(Where::Option(format!("--pixel {x},{y}")), "is not in the picture").expected(format!(
            "0,0 to {},{}",
            width.saturating_sub(1),
            height.saturating_sub(1)
        )));
    }
    let from = match (args.from, args.pixel) {
        (_, Some(pixel)) => From::Eye(Some(pixel)),
        (Some(Start::Eye), None) => From::Eye(None),
        (Some(Start::Lamp) | None, None) => From::Lamps,
    };
    let asked = Asked { from, kept: args.count, counted: COUNTED, seed: args.seed };
    let (mut strips, fates, _) = rays(&checked, &world, asked, &|| false);
    let origin = world.geometry.origin();
    strips.iter_mut().flat_map(|strip| &mut strip.points).for_each(|point: &mut DVec3| *point += origin);
    if let Some(output) = &args.output {
        rays::write(output, &strips, &space(&built, rays::extension(output) == "glb"))?;
    }
    let warnings = || scene.notes.iter().filter(|note| note.severity == Severity::Warning);
    let what = match from {
        From::Lamps => "from the lamps".to_owned(),
        From::Eye(None) => "from the eye".to_owned(),
        From::Eye(Some([x, y])) => format!("from the eye through pixel {x},{y}"),
    };
    let text = || {
        let mut lines = told(scene);
        lines.push(match fates.paths {
            0 => "nothing shines: no path starts".to_owned(),
            paths => format!("{paths} paths {what}; where their light ends:"),
        });
        lines.push(fates.text());
        lines.extend(args.output.iter().map(|output| format!("{}: {} paths", output.display(), strips.len())));
        lines.retain(|line| !line.is_empty());
        lines.join("\n")
    };
    let json = || {
        serde_json::json!({
            "scene": scene.name,
            "scene_hash": scene.hash,
            "from": what,
            "paths": fates.paths,
            "fates": fates.json(),
            "output": args.output,
            "drawn": strips.len(),
            "warnings": warnings().collect::<Vec<_>>(),
        })
    };
    print(args.format, text, json)?;
    Ok(ExitCode::SUCCESS)
}

/// The coordinates of the asset; those of glTF where the asset is none.
fn space(built: &Built, glb: bool) -> Space {
    let usd = !["glb", "gltf"].contains(&rays::extension(&built.asset).as_str());
    if glb && usd {
        return Space { unit_m: 1.0, turn: DMat3::IDENTITY, z_up: false };
    }
    // Axes are turned by quarters, so the way back is the transpose.
    let turn = built.axes.transpose();
    let z_up = (turn * DVec3::Y).z.abs() > 0.5;
    Space { unit_m: built.scene.unit_m, turn, z_up }
}
