//! `eyebox render --frames`: one file per time code, each under an import of its own.

use super::{Ended, one};
use crate::base::Result;
use crate::cmd::frames::{Frames, Pattern};
use crate::cmd::progress::Signals;
use crate::cmd::render_args::RenderArgs;
use crate::cmd::say;
use crate::scene::Scene;
use std::process::ExitCode;

/// Renders the frames one after the other. What fails is reported and the others go on; the exit code is then 2. A signal
/// ends the sequence: frames that are done stay, the one under way is not written.
pub fn run(args: &RenderArgs, frames: &Frames, signals: &Signals) -> Result<ExitCode> {
    let pattern = Pattern::of(args.output())?;
    if let Some(note) = still(args, frames, &pattern) {
        tell!("note: {note}");
    }
    let (mut failed, mut unmet) = (0u64, 0u64);
    for code in frames.codes() {
        let path = pattern.path(code);
        if args.skips_existing() && path.exists() {
            if !args.is_quiet() {
                tell!("eyebox: {} is there, skipped", path.display());
            }
            continue;
        }
        match one(&args.of_frame(path, code as f64), signals, false) {
            Ok(Ended::Met) => {}
            Ok(Ended::Unmet) => unmet += 1,
            Ok(Ended::Stopped) => return Ok(signals.exit_code()),
            Err(mut fault) => {
                failed += 1;
                fault.what = format!("frame {code}: {}", fault.what);
                say(&fault);
            }
        }
    }
    if failed > 0 {
        tell!("eyebox: {failed} of {} frames failed", frames.count());
    }
    Ok(ExitCode::from(if failed > 0 { 2 } else { u8::from(unmet > 0) }))
}

/// What to say of an asset that is the same at the first frame and at the last; nothing where it can't be read, which the
/// frames themselves tell.
fn still(args: &RenderArgs, frames: &Frames, pattern: &Pattern) -> Option<String> {
    let (first, last) = (frames.codes().next()?, frames.codes().last()?);
    // Not by their hashes, which are of the files; notes tell which frame it is.
    let scene = |code: i64| {
        let built = args.of_frame(pattern.path(code), code as f64).source.import();
        built.ok().map(|built| Scene { notes: Vec::new(), ..built.scene })
    };
    let same = first != last && scene(first)? == scene(last)?;
    same.then(|| format!("the asset is the same at {first} and {last}: nothing in it moves, only the noise differs"))
}
