//! `eyebox-bench`: the program measured. It is a program of its own, so that nobody who renders builds or carries it; `eyebox
//! bench` hands over to it.

mod bench;
mod bench_choice;
mod bench_curve;

use clap::Parser;
use std::process::ExitCode;

#[derive(Parser, Debug)]
#[command(name = "eyebox bench", version)]
struct Cli {
    #[command(flatten)]
    args: bench::BenchArgs,
}

fn main() -> ExitCode {
    eyebox::cmd::with_arguments(|cli: &Cli| bench::run(&cli.args))
}
