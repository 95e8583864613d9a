//! `eyebox convert`: an assembly in another format.

use super::{Format, authored};
use crate::author;
use crate::base::Result;
use crate::base::atomic::check_writable;
use crate::base::relative_path::folder_of;
use crate::import::{self, ReadOptions, annotate};
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

/// Write an assembly in another format, with all its optical attributes.
#[derive(Args, Debug)]
#[command(after_help = "\
The extension of OUT says the format. A sidecar as IN becomes part of the new asset. Names, hierarchy, instances and \
geometry stay; what the format can't say is listed (docs/interchange.md). Images are not copied: OUT names them relative \
to its own folder.

Examples:
  eyebox convert hud.optics.toml hud.glb
  eyebox convert hud.optics.toml hud.usda
  eyebox convert hud.glb hud.gltf
  eyebox convert hud.usda hud.glb --frame 12")]
pub struct ConvertArgs {
    /// Sidecar (*.optics.toml) or asset (.glb, .gltf, .usda, .usdc, .usdz).
    asset: PathBuf,
    /// The asset to write (.glb, .gltf, .usda, .usdc, .usdz).
    output: PathBuf,
    /// The time code at which a USD asset is taken; its own values without time, else the earliest, if not said.
    #[arg(long, value_name = "TIME", value_parser = super::parse_frame, allow_negative_numbers = true)]
    frame: Option<f64>,
    /// How the summary is printed.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Runs the command.
pub fn run(args: &ConvertArgs) -> Result<ExitCode> {
    check_writable(&args.output)?;
    let (mut assembly, sidecar) = import::read(&args.asset, &ReadOptions { frame: args.frame })?;
    let sidecar = sidecar.map(|(_, value)| value);
    annotate(&assembly, sidecar.as_ref(), &folder_of(&args.output))?.apply(&mut assembly);
    let written = author::convert(&assembly, &args.output)?;
    authored(args.format, &assembly, &written)
}
