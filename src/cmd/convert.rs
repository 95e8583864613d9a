//! `eyebox convert`: an assembly in another format.

use super::moment::Moment;
use super::{Format, authored};
use crate::author;
use crate::base::Result;
use crate::base::atomic::check_writable;
use crate::base::relative_path::folder_of;
use crate::import::{self, annotate};
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

/// Write an assembly in another format, with all its optical attributes and its looks.
#[derive(Args, Debug)]
#[command(after_help = "\
The extension of OUT says the format. A sidecar as IN becomes part of the new asset. Names, hierarchy, instances and \
geometry stay; what the format can't say is listed (docs/interchange.md). Pictures of materials are copied: into a .glb or \
.usdz, else into the folder NAME_textures beside OUT. Pictures of skies and slides are not: OUT names them relative to its \
own folder. What moves is written as it moves (nodes, joints, shapes of meshes), or with --frame as it stands at that moment.

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
    #[command(flatten)]
    moment: Moment,
    /// How the summary is printed.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Runs the command.
pub fn run(args: &ConvertArgs) -> Result<ExitCode> {
    check_writable(&args.output)?;
    let (mut assembly, sidecar) = import::moving(&args.asset, &args.moment.reading())?;
    let sidecar = sidecar.map(|(_, value)| value);
    annotate(&assembly, sidecar.as_ref(), &folder_of(&args.output))?.apply(&mut assembly);
    let written = author::convert(&assembly, &args.output)?;
    authored(args.format, &assembly, &written)
}
