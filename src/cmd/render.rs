//! `eyebox render`: the corridor, in order.

mod opened;
mod picture;
mod planned;
mod sequence;
mod summary;
mod traced;

use super::frames::named;
use super::progress::Signals;
use super::render_args::RenderArgs;
use crate::base::atomic::check_writable;
use crate::base::{Error, Result, Where};
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

/// Runs the command.
pub fn run(args: &RenderArgs) -> Result<ExitCode> {
    let signals = Signals::install();
    match &args.frames {
        Some(frames) => sequence::run(args, frames, &signals),
        None => Ok(match one(args, &signals, true)? {
            Ended::Met => ExitCode::SUCCESS,
            Ended::Unmet => ExitCode::from(1),
            Ended::Stopped => signals.exit_code(),
        }),
    }
}

/// How a rendering ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Ended {
    Met,
    /// Another limit came before the error that was asked for, or what was found is not to be trusted: it is said why.
    Unmet,
    /// By a signal.
    Stopped,
}

/// Renders one frame. `partial`: whether the passes until a signal are written.
fn one(args: &RenderArgs, signals: &Signals, partial: bool) -> Result<Ended> {
    let run = &Run::begin(args, signals, partial)?;
    let mut opened = run.open()?;
    let Some(mut planned) = run.plan(&mut opened)? else { return Ok(run.stopped("before the first pass")) };
    let Some(mut traced) = run.trace(&opened, &mut planned)? else {
        return Ok(run.stopped("before the frame was done"));
    };
    let frame = run.picture(&opened, &mut planned, &mut traced)?;
    run.write(&opened, &planned, &mut traced, frame)?;
    run.tell(&opened, &planned, &traced)?;
    Ok(run.ended(&traced))
}

/// What all steps of a rendering share.
struct Run<'r> {
    args: RenderArgs,
    signals: &'r Signals,
    partial: bool,
    pool: rayon::ThreadPool,
    start: Instant,
}

impl<'r> Run<'r> {
    /// Errors: what could only be said after an hour of tracing otherwise.
    fn begin(args: &RenderArgs, signals: &'r Signals, partial: bool) -> Result<Self> {
        let start = Instant::now();
        let args = RenderArgs { output: named(&args.output, args.source.moment.frame)?, ..args.clone() };
        check_destination(&args.output)?;
        if let Some(packing) = args.compression {
            let at = || Where::Option(format!("--compression {}", packing.name()));
            packing
                .spares_data(args.multi_part)
                .map_err(|text| Error::new(at(), text).expected("--multi-part with it"))?;
        }
        let pool = args.threads.pool()?;
        Ok(Run { args, signals, partial, pool, start })
    }

    fn is_stopped(&self) -> bool {
        self.signals.caught().is_some()
    }

    /// Without a picture an older file stays as it is.
    fn stopped(&self, when: &str) -> Ended {
        tell!("eyebox: stopped {when}; {} was not written", self.args.output.display());
        Ended::Stopped
    }
}

/// Fails early where the picture could not be written: an hour of tracing must not end in a typing error.
fn check_destination(output: &Path) -> Result<()> {
    if output.extension().is_none_or(|e| !e.eq_ignore_ascii_case("exr")) {
        return Err(Error::new(Where::file(output), "is no name for an EXR file").expected("a name that ends in .exr"));
    }
    check_writable(output)
}
