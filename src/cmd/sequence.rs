//! Names and numbers of the frames of a sequence.

use crate::base::{Fault, Result, Where};
use std::path::{Path, PathBuf};

/// Most frames of a sequence.
const MOST: i64 = 1_000_000;

/// `A-B` or `A-BxS`: first, last, step.
pub fn parse_frames(text: &str) -> std::result::Result<[i64; 3], String> {
    let bad = || format!("`{text}` is no range of frames; write e.g. 1-48 or 1-48x4");
    let (range, step) = text.split_once('x').unwrap_or((text, "1"));
    // A minus before a digit at the start belongs to the first number.
    let dash = range.get(1..).and_then(|rest| rest.find('-')).map(|at| at + 1);
    let (first, last) = dash.map_or((range, range), |at| (&range[..at], &range[at + 1..]));
    let number = |text: &str| text.trim().parse::<i64>();
    match (number(first), number(last), number(step)) {
        (Ok(first), Ok(last), Ok(step)) if first <= last && step >= 1 && last.saturating_sub(first) / step < MOST => {
            Ok([first, last, step])
        }
        (_, _, _) => Err(bad()),
    }
}

/// The file of a frame: `hud.####.exr` is `hud.0012.exr` at 12. Errors: `#` without a frame, or a broken one, in two places,
/// or at a frame between whole numbers.
pub fn named(pattern: &Path, frame: Option<f64>) -> Result<PathBuf> {
    let fault =
        |what: &str| Fault::new(Where::file(pattern), what).expected("one run of #, as in hud.####.exr, and --frame");
    let name = pattern.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let Some(first) = name.find('#') else { return Ok(pattern.to_owned()) };
    let width = name[first..].bytes().take_while(|byte| *byte == b'#').count();
    let rest = &name[first + width..];
    if rest.contains('#') {
        return Err(fault("has # in two places"));
    }
    let frame = frame.ok_or_else(|| fault("has # for the digits of a frame, and no frame was named"))?;
    if frame.fract() != 0.0 || frame.abs() > 1e15 {
        return Err(fault("has # for the digits of a frame, and the frame is no whole number"));
    }
    let (sign, digits) = (if frame < 0.0 { "-" } else { "" }, format!("{:0width$}", frame.abs() as u64));
    Ok(pattern.with_file_name(format!("{}{sign}{digits}{rest}", &name[..first])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges() {
        assert_eq!(parse_frames("1-48"), Ok([1, 48, 1]));
        assert_eq!(parse_frames("-5--2x3"), Ok([-5, -2, 3]));
        assert_eq!(parse_frames("7"), Ok([7, 7, 1]));
        for bad in
            ["", "-", "5-1", "1-5x0", "1-5x", "a-b", "1-99999999999", "é-2", "-9223372036854775808-9223372036854775807"]
        {
            assert!(parse_frames(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn names() {
        let at = |pattern: &str, frame| named(Path::new(pattern), frame).map(|path| path.display().to_string());
        assert_eq!(at("a/hud.####.exr", Some(12.0)).unwrap(), "a/hud.0012.exr");
        assert_eq!(at("hud.#.exr", Some(123.0)).unwrap(), "hud.123.exr");
        assert_eq!(at("hud.##.exr", Some(-3.0)).unwrap(), "hud.-03.exr");
        assert_eq!(at("hud.exr", Some(1.5)).unwrap(), "hud.exr");
        for (pattern, frame) in [("h#d.##.exr", Some(1.0)), ("hud.##.exr", None), ("hud.##.exr", Some(1.5))] {
            assert!(at(pattern, frame).is_err(), "{pattern}");
        }
    }
}
