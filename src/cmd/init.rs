//! `eyebox init`: a sidecar to start from.

use super::{Format, print};
use crate::author;
use crate::base::atomic::{check_writable, write_atomic};
use crate::base::{Error, Result, Where};
use crate::import::template::{Template, skeleton};
use crate::import::{build, prescription, toml};
use crate::scene::Note;
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

/// Write a commented sidecar for a bare asset: every part with its faces, fitted surfaces and guesses from names. Of a lens file:
/// an asset with its solids, too.
#[derive(Args, Debug)]
#[command(after_help = "\
What can't be known is marked TODO; what can be guessed (glass names, lens caps, LEDs) is filled in. Where no name is that \
of optics, the sidecar keeps the picture of the bare asset: the eye and the sky that render assumes are written down. An \
existing file is not overwritten without --force.

A sequential lens file of Zemax OpticStudio (.zmx) or CODE V (.seq) becomes solids of glass and mirrors in NAME.glb beside the sidecar, which has \
their exact surfaces and apertures, their glasses, an eye at the stop and a lamp at the image. Standard surfaces, even aspheres, \
toroids, polynomials in x and y, standard and fringe Zernike surfaces, gratings and coordinate breaks are read; coatings and \
obscurations are named and left out.

Examples:
  eyebox init hud.glb -o hud.optics.toml
  eyebox init combiner.zmx -o combiner.optics.toml
  eyebox init hud.glb -o hud.optics.toml --force && eyebox inspect hud.optics.toml")]
pub struct InitArgs {
    /// The asset (.glb, .gltf, .usda, .usdc, .usdz) or lens file (.zmx, .seq).
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
    if prescription::is_prescription(&args.asset) {
        return args.of_prescription();
    }
    let skeleton = skeleton(&args.asset, &args.output)?;
    write_atomic(&args.output, skeleton.text.as_bytes())?;
    print(args.format, || args.summary(&skeleton), || serde_json::json!(skeleton))?;
    Ok(ExitCode::SUCCESS)
}

impl InitArgs {
    /// A prescription becomes an asset beside the sidecar, and the sidecar.
    fn of_prescription(&self) -> Result<ExitCode> {
        let name = self.output.file_name().unwrap_or_default().to_string_lossy();
        let stem = name.strip_suffix(".optics.toml").or(name.strip_suffix(".toml")).unwrap_or(&name);
        let asset = self.output.with_file_name(format!("{stem}.glb"));
        if asset.exists() && !self.force {
            return Err(Error::new(Where::file(&asset), "this file exists").expected("another name, or --force"));
        }
        let made = prescription::make(&self.asset, &format!("{stem}.glb"))?;
        let sheet = toml::parse(&made.text, &self.output)?;
        let built = build(made.assembly.clone(), Some(&sheet), &[]);
        let written = author::convert(&made.assembly, &asset)?;
        write_atomic(&self.output, made.text.as_bytes())?;
        let notes: Vec<&Note> = made.notes.iter().chain(&written.notes).collect();
        let fault = built.err().map(|fault| fault.to_string());
        let parts = made.assembly.nodes.len();
        let text = || {
            let output = self.output.display();
            let mut lines = vec![format!("{output}, {}: {parts} parts", asset.display())];
            lines.extend(notes.iter().map(|note| format!("  {}: {}", note.at, note.text)));
            lines.push(match &fault {
                None => format!("it can be imported as it is: eyebox inspect {output}"),
                Some(fault) => format!("it can't be imported yet: {fault}"),
            });
            lines.join("\n")
        };
        let json = || serde_json::json!({ "asset": asset, "parts": parts, "notes": notes, "fault": fault });
        print(self.format, text, json)?;
        Ok(ExitCode::SUCCESS)
    }

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
