//! `eyebox bench`: hands over to `eyebox-bench`, which measures the program.

use crate::base::{Error, Result, Where};
use clap::Args;
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::{Command, ExitCode};

#[derive(Args, Debug)]
#[command(
    disable_help_flag = true,
    after_help = "Examples:\n  eyebox bench --help\n  eyebox bench samples/hud-direct/hud.optics.toml"
)]
pub struct BenchArgs {
    /// What `eyebox-bench` takes.
    #[arg(value_name = "ARGUMENT", trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<OsString>,
}

/// Runs the command. Errors: there is no `eyebox-bench`.
pub fn run(args: &BenchArgs) -> Result<ExitCode> {
    let (program, before) = program();
    let status = Command::new(&program).args(before).args(&args.arguments).status().map_err(|error| {
        Error::new(Where::Nowhere, format!("{} cannot be run: {error}", program.display()))
            .expected("`cargo build --release -p eyebox-bench`, which builds it beside this program")
    })?;
    Ok(ExitCode::from(status.code().and_then(|code| u8::try_from(code).ok()).unwrap_or(2)))
}

/// The program and its first arguments: where cargo runs this one, cargo builds and runs that one, too.
fn program() -> (PathBuf, Vec<&'static str>) {
    if let (Some(cargo), Some(_)) = (std::env::var_os("CARGO"), std::env::var_os("CARGO_MANIFEST_DIR")) {
        let run = ["run", "--release", "--ignore-rust-version", "--quiet", "-p", "eyebox-bench", "--"];
        return (cargo.into(), run.to_vec());
    }
    let name = format!("eyebox-bench{}", std::env::consts::EXE_SUFFIX);
    let beside = std::env::current_exe().ok().and_then(|own| Some(own.parent()?.join(&name)));
    (beside.filter(|file| file.exists()).unwrap_or_else(|| name.into()), Vec::new())
}
