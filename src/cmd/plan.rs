//! `eyebox plan`: what would be traced how, and why.

use super::render_args::{EstimatorArg, PolarisationArg, parse_resolution};
use super::source::{Source, told};
use super::threads::Threads;
use super::{Format, print};
use crate::base::atomic::write_atomic;
use crate::base::{Error, Result, Where};
use crate::check::check;
use crate::estimate::picture::plan_lines;
use crate::plan::forecast::{Forecast, forecast};
use crate::plan::plan_file::PlanFile;
use crate::plan::{Asked, Guides, plan};
use crate::scene::Scene;
use crate::world::World;
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

/// Say which estimator traces which light, and why, without rendering.
#[derive(Args, Debug)]
#[command(after_help = "\
The plan is a function of the scene, the resolution and the request: no clock and no thread count is in it. With -o it is \
written as JSON with its hash; render --plan takes it as it is, and refuses it for another scene.

Examples:
  eyebox plan samples/hud-direct/hud.optics.toml
  eyebox plan hud.optics.toml -o plan.json
  eyebox plan hud.optics.toml --estimator backward --unguided
  eyebox plan hud.optics.toml --resolution 1024x768 --format json
  eyebox render hud.optics.toml --plan plan.json -o hud.exr")]
pub struct PlanArgs {
    /// Write the plan to this JSON file.
    #[arg(short, long, value_name = "PLAN.json")]
    output: Option<PathBuf>,
    /// Which estimator may be used.
    #[arg(long, value_enum, default_value_t)]
    estimator: EstimatorArg,
    /// Trace the polarisation of light.
    #[arg(long, value_enum, value_name = "WHEN", default_value_t)]
    polarisation: PolarisationArg,
    /// Start and aim paths without what pilots learned of where the light is, as for `render`.
    #[arg(long)]
    unguided: bool,
    /// Width and height in pixels, instead of the eye's.
    #[arg(long, value_name = "WxH", value_parser = parse_resolution)]
    resolution: Option<[usize; 2]>,
    #[command(flatten)]
    source: Source,
    #[command(flatten)]
    threads: Threads,
    /// How the result is printed.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Runs the command.
pub fn run(args: &PlanArgs) -> Result<ExitCode> {
    args.threads.within(|| traced(args))
}

fn traced(args: &PlanArgs) -> Result<ExitCode> {
    let mut scene = args.source.import()?.scene;
    if let Some(resolution) = args.resolution {
        scene.eye.resolution = resolution;
    }
    args.source.adapt_eye(&mut scene, args.polarisation.asked(), &|| false)?;
    let checked = check(&scene)?;
    let world = World::freeze(&scene)?;
    let guides = if args.unguided { Guides::Off } else { Guides::On };
    let asked = Asked { choice: args.estimator.choice(), polarisation: args.polarisation.asked(), guides };
    let plan = plan(&checked, &world, asked);
    let frozen = PlanFile::new(&scene, asked, &plan);
    let forecast = forecast(&scene, &world, &frozen.plan)?;
    if let Some(path) = &args.output {
        let bytes = serde_json::to_vec_pretty(&frozen)
            .map_err(|error| Error::new(Where::file(path), format!("cannot be written: {error}")))?;
        write_atomic(path, &bytes)?;
    }
    print(
        args.format,
        || told(&scene).into_iter().chain([text(&scene, &frozen, &forecast)]).collect::<Vec<_>>().join("\n"),
        || serde_json::json!({ "frozen": frozen, "forecast": forecast }),
    )?;
    Ok(ExitCode::SUCCESS)
}

fn text(scene: &Scene, frozen: &PlanFile, forecast: &Forecast) -> String {
    let mut lines = plan_lines(scene, &frozen.plan);
    let plan = &frozen.plan;
    for connection in &plan.connections {
        let seeds = connection.seeds.len();
        let (share, faces) = (100.0 * connection.share, connection.train.0.len());
        let group = &scene.group(connection.group).name;
        lines.push(format!("connection: {group} to the eye over {faces} faces, {share:.3} % of its light there, {seeds} starting points"));
    }
    for screen in &plan.screens {
        let (share, faces) = (100.0 * screen.share, screen.train.0.len());
        let path = scene.parts.get(screen.part as usize).map_or("?", |part| part.path.as_str());
        let group = &scene.group(screen.group).name;
        lines.push(format!(
            "connection: {group} to {path} face {} over {faces} faces, {share:.3} % of its light there",
            screen.face
        ));
    }
    lines.push(forecast.line());
    lines.push(format!("plan {}", frozen.hash));
    lines.join("\n")
}
