//! `eyebox render --frames`: one file per time code, each under an import of its own. Names and numbers of frames.

use super::progress::Signals;
use super::render::{Ended, one};
use super::render_args::RenderArgs;
use super::say;
use crate::base::{Fault, Result, Where};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Most frames of one sequence.
const MOST: u64 = 1_000_000;

/// First and last time code and the step between two.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frames {
    first: i64,
    last: i64,
    step: u64,
}

/// `A-B`, `A-BxS` or `A`: whole time codes, the last not below the first, the step above 0.
pub fn parse_frames(text: &str) -> std::result::Result<Frames, String> {
    let bad = || format!("`{text}` is no range of frames; write e.g. 1-24, 1-24x2 or -5-5");
    let (range, step) = match text.split_once(['x', 'X']) {
        Some((range, step)) => (range.trim(), step.trim().parse::<u64>().map_err(|_| bad())?),
        None => (text.trim(), 1),
    };
    // A minus at the start is a sign.
    let dash = range.char_indices().skip(1).find(|(_, c)| *c == '-').map(|(at, _)| at);
    let (first, last) = match dash {
        Some(at) => (range[..at].trim(), range[at + 1..].trim()),
        None => (range, range),
    };
    let (first, last) = (first.parse::<i64>().map_err(|_| bad())?, last.parse::<i64>().map_err(|_| bad())?);
    let frames = Frames { first, last, step };
    if last < first || step == 0 || frames.count() > MOST {
        return Err(format!("{}, at most {MOST} frames, the last not before the first, a step of 1 or more", bad()));
    }
    Ok(frames)
}

impl Frames {
    pub fn count(self) -> u64 {
        (self.last.abs_diff(self.first) / self.step.max(1)).saturating_add(1)
    }
    /// First, last, step.
    pub fn range(self) -> (i64, i64, u64) {
        (self.first, self.last, self.step)
    }
    pub fn codes(self) -> impl Iterator<Item = i64> {
        (0..self.count()).filter_map(move |i| self.first.checked_add_unsigned(i.checked_mul(self.step)?))
    }
}

/// A file name with one run of `#`, for the frame's number.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Pattern {
    folder: PathBuf,
    before: String,
    digits: usize,
    after: String,
}

impl Pattern {
    /// Errors: no `#` in the name, several runs of them, `#` in a folder's name.
    fn of(path: &Path) -> Result<Pattern> {
        let fault = |what: &str| {
            Fault::new(Where::file(path), what).expected("a name like hud.####.exr: one run of # in the file's name")
        };
        let name = path.file_name().and_then(|name| name.to_str()).ok_or_else(|| fault("is no file name"))?;
        let folder = path.parent().map(Path::to_owned).unwrap_or_default();
        if folder.to_string_lossy().contains('#') {
            return Err(fault("has # in the name of a folder"));
        }
        let Some((before, rest)) = name.split_once('#') else {
            return Err(fault("has no # for the frames' numbers"));
        };
        let after = rest.trim_start_matches('#');
        if after.contains('#') {
            return Err(fault("has more than one run of #"));
        }
        let digits = 1 + rest.len() - after.len();
        Ok(Pattern { folder, before: before.to_owned(), digits, after: after.to_owned() })
    }

    /// The file of a frame: its number with zeros before it, the sign not counted.
    fn path(&self, code: i64) -> PathBuf {
        let sign = if code < 0 { "-" } else { "" };
        let (digits, number) = (self.digits, code.unsigned_abs());
        self.folder.join(format!("{}{sign}{number:0digits$}{}", self.before, self.after))
    }
}

/// The file of one frame: `hud.####.exr` is `hud.0012.exr` at 12, a name without `#` is itself. Errors: those of a bad name,
/// no frame, or one between whole numbers.
pub fn named(path: &Path, frame: Option<f64>) -> Result<PathBuf> {
    if path.file_name().is_none_or(|name| !name.to_string_lossy().contains('#')) {
        return Ok(path.to_owned());
    }
    let pattern = Pattern::of(path)?;
    let fault = |what: &str| Fault::new(Where::file(path), what).expected("a whole time code, e.g. --frame 12");
    let frame = frame.ok_or_else(|| fault("has # for the digits of a frame, and no frame was named"))?;
    if frame.fract() != 0.0 || frame.abs() > 1e15 {
        return Err(fault("has # for the digits of a frame, and the frame is no whole number"));
    }
    Ok(pattern.path(frame as i64))
}

/// Renders the frames one after the other. What fails is reported and the others go on; the exit code is then 2. A signal
/// ends the sequence: frames that are done stay, the one under way is not written.
pub fn run(args: &RenderArgs, frames: Frames, signals: &Signals) -> Result<ExitCode> {
    let pattern = Pattern::of(args.output())?;
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges() {
        let codes = |text: &str| parse_frames(text).map(|frames| frames.codes().collect::<Vec<_>>());
        assert_eq!(codes("3-5"), Ok(vec![3, 4, 5]));
        assert_eq!(codes("1-10x4"), Ok(vec![1, 5, 9]));
        assert_eq!(codes("7"), Ok(vec![7]));
        assert_eq!(codes("-2-1"), Ok(vec![-2, -1, 0, 1]));
        assert_eq!(codes("-5--3"), Ok(vec![-5, -4, -3]));
        assert_eq!(codes(&format!("{0}-{0}", i64::MAX)), Ok(vec![i64::MAX]));
        for bad in ["", "-", "a-b", "5-3", "1-5x0", "1-5x", "1.5-3", "1-2-3", "0-9999999", "x2", "é-3"] {
            assert!(codes(bad).is_err(), "{bad}");
        }
        assert!(codes(&format!("{}-{}", i64::MIN, i64::MAX)).is_err());
    }

    #[test]
    fn patterns() {
        let name = |pattern: &str, code: i64| Pattern::of(Path::new(pattern)).unwrap().path(code);
        assert_eq!(name("out/hud.####.exr", 12), Path::new("out/hud.0012.exr"));
        assert_eq!(name("hud_##.exr", -3), Path::new("hud_-03.exr"));
        assert_eq!(name("#.exr", 12345), Path::new("12345.exr"));
        for bad in ["hud.exr", "a#/hud.##.exr", "hud.#.#.exr", ".."] {
            let text = Pattern::of(Path::new(bad)).unwrap_err().to_string();
            assert!(text.contains("expected a name like hud.####.exr"), "{text}");
        }
    }

    #[test]
    fn one_frame_of_a_pattern() {
        let at = |pattern: &str, frame| named(Path::new(pattern), frame).map(|path| path.display().to_string());
        assert_eq!(at("a/hud.####.exr", Some(12.0)).unwrap(), "a/hud.0012.exr");
        assert_eq!(at("a#b/hud.exr", Some(1.5)).unwrap(), "a#b/hud.exr");
        for (pattern, frame) in [("h#d.##.exr", Some(1.0)), ("hud.##.exr", None), ("hud.##.exr", Some(1.5))] {
            assert!(at(pattern, frame).is_err(), "{pattern}");
        }
    }
}
