//! `eyebox annotate`: a sidecar becomes part of the asset.

use super::{Format, authored};
use crate::author;
use crate::base::Result;
use crate::base::atomic::check_writable;
use crate::base::relative_path::folder_of;
use crate::import::{self, annotate, toml};
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

/// Write a copy of an asset that carries the attributes of a sidecar itself.
#[derive(Args, Debug)]
#[command(after_help = "\
The copy means what asset and sidecar mean together; all else in it stays byte for byte. Images are not copied: the \
copy names them relative to its own folder, and its buffers, too.

Examples:
  eyebox annotate hud.glb --optics hud.optics.toml -o hud_optics.glb
  eyebox annotate hud_direct.usda --optics hud_usd.optics.toml -o hud.usda
  eyebox annotate hud.gltf --optics hud.optics.toml -o out/hud.gltf && eyebox render out/hud.gltf -o hud.exr")]
pub struct AnnotateArgs {
    /// The asset (.glb, .gltf, .usda, .usdc, .usdz).
    asset: PathBuf,
    /// The sidecar.
    #[arg(long, value_name = "NAME.optics.toml")]
    optics: PathBuf,
    /// The asset to write, of the same format.
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// How the summary is printed.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Runs the command.
pub fn run(args: &AnnotateArgs) -> Result<ExitCode> {
    check_writable(&args.output)?;
    let assembly = import::asset(&args.asset)?;
    let sidecar = toml::read(&args.optics)?;
    let annotation = annotate(&assembly, Some(&sidecar), &folder_of(&args.output))?;
    let written = author::annotate(&assembly, &annotation, &args.output)?;
    authored(args.format, &assembly, &written)
}
