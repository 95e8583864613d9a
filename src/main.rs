//! The `eyebox` program: see `eyebox --help`.

use std::process::ExitCode;

fn main() -> ExitCode {
    eyebox::cmd::main()
}
