//! `eyebox init`: a sidecar to start from.

use super::{Format, print};
use crate::base::atomic::{check_writable, write_atomic};
use crate::base::{Error, Result, Where};
use crate::import::template::{Template, skeleton};
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

/// Write a commented sidecar for a bare asset: every part with its faces, fitted surfaces and guesses from names.
#[derive(Args, Debug)]
#[command(after_help = "\
What can't be known is marked TODO; what can be guessed (glass names, lens caps, LEDs) is filled in. Where no name is that \
of optics, the sidecar keeps the picture of the bare asset: the eye and the sky that render assumes are written down. An \
existing file is not overwritten without --force.

Examples:
  eyebox init hud.glb -o hud.optics.toml
  eyebox init hud.glb -o hud.optics.toml --force && eyebox inspect hud.optics.toml")]
pub struct InitArgs {
    /// The asset (.glb, .gltf, .usda, .usdc, .usdz).
    asset: PathBuf,
    /// The sidecar to write.
    #[arg(short, long, value_name = "NAME.optics.toml")]
    output: PathBuf,
    /// Overwrite an existing file.
    #[arg(long)]
    force: bool,
    /// How the summary is printed.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Runs the command.
pub fn run(args: &InitArgs) -> Result<ExitCode> {
    if args.output.exists() && !args.force {
        return Err(Error::new(Where::file(&args.output), "this file exists").expected("another name, or --force"));
    }
    if args.output.extension().is_none_or(|e| e != "toml") {
        return Err(Error::new(Where::file(&args.output), "is no name for a sidecar").expected("NAME.optics.toml"));
    }
    check_writable(&args.output)?;
    let skeleton = skeleton(&args.asset, &args.output)?;
    write_atomic(&args.output, skeleton.text.as_bytes())?;
    print(args.format, || args.summary(&skeleton), || serde_json::json!(skeleton))?;
    Ok(ExitCode::SUCCESS)
}

impl InitArgs {
    fn summary(&self, skeleton: &Template) -> String {
        let output = self.output.display();
        let mut lines = vec![format!("{output}: {} parts of {} kinds", skeleton.parts, skeleton.kinds)];
        lines.extend(skeleton.todos.iter().map(|todo| format!("  TODO {todo}")));
        lines.push(match &skeleton.fault {
            None if skeleton.todos.is_empty() => format!("it can be imported as it is: eyebox inspect {output}"),
            None => format!("it can be imported as it is, with stand-ins for the TODOs: eyebox inspect {output}"),
            Some(fault) => format!("it can't be imported yet: {fault}"),
        });
        lines.join("\n")
    }
}
