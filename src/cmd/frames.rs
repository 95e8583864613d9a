//! Which frames a sequence has, and how their files are called.

use crate::base::{Error, Result, Where};
use std::path::{Path, PathBuf};

/// Most frames of one sequence.
const MOST: u64 = 1_000_000;

/// First and last time code and the step between two.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Range {
    pub first: i64,
    pub last: i64,
    pub step: u64,
}

/// Ranges of time codes, one after the other.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Frames(Vec<Range>);

/// `A-B`, `A-BxS` or `A`, several with commas between them: whole time codes, the last of a range not below the first, the step
/// above 0.
pub fn parse_frames(text: &str) -> std::result::Result<Frames, String> {
    let ranges = text.split(',').map(parse_range).collect::<std::result::Result<Vec<Range>, String>>()?;
    let frames = Frames(ranges);
    if frames.count() > MOST {
        return Err(format!("`{text}` has more than {MOST} frames"));
    }
    Ok(frames)
}

fn parse_range(text: &str) -> std::result::Result<Range, String> {
    let bad = || format!("`{text}` is no range of frames; write e.g. 1-24, 1-24x2, 1,3,5 or -5-5");
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
    let range = Range { first, last, step };
    if last < first || step == 0 || range.count() > MOST {
        return Err(format!("{}, at most {MOST} frames, the last not before the first, a step of 1 or more", bad()));
    }
    Ok(range)
}

impl Range {
    fn count(self) -> u64 {
        (self.last.abs_diff(self.first) / self.step.max(1)).saturating_add(1)
    }
    fn codes(self) -> impl Iterator<Item = i64> {
        (0..self.count()).filter_map(move |i| self.first.checked_add_unsigned(i.checked_mul(self.step)?))
    }
}

impl Frames {
    pub fn count(&self) -> u64 {
        self.0.iter().fold(0, |sum, range| sum.saturating_add(range.count()))
    }
    pub fn ranges(&self) -> &[Range] {
        &self.0
    }
    pub fn codes(&self) -> impl Iterator<Item = i64> + '_ {
        self.0.iter().flat_map(|range| range.codes())
    }
}

/// A file name with one place for the frame's number: a run of `#`, `%04d` as C and Nuke write it, or Houdini's `$F4`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pattern {
    folder: PathBuf,
    before: String,
    digits: usize,
    after: String,
}

/// The first place for a number in a name: where it begins and ends, and its digits.
fn place(name: &str) -> Option<(usize, usize, usize)> {
    let numbered = |at: usize, rest: &str, ends: Option<char>| {
        let digits: String = rest.chars().take_while(char::is_ascii_digit).collect();
        let end = at + digits.len() + ends.map_or(0, char::len_utf8);
        let closed = ends.is_none_or(|ends| rest[digits.len()..].starts_with(ends));
        let count = digits.trim_start_matches('0').parse().unwrap_or(1usize);
        (closed && count <= 32 && digits.len() <= 3).then_some((end, count))
    };
    name.char_indices().find_map(|(at, c)| {
        let rest = &name[at + c.len_utf8()..];
        match c {
            '#' => {
                let more = rest.len() - rest.trim_start_matches('#').len();
                Some((at, at + 1 + more, 1 + more))
            }
            '%' => numbered(at + 1, rest, Some('d')).map(|(end, digits)| (at, end, digits)),
            '$' => {
                let rest = rest.strip_prefix('F')?;
                numbered(at + 2, rest, None).map(|(end, digits)| (at, end, digits))
            }
            _ => None,
        }
    })
}

impl Pattern {
    /// Whether a path has a place for a frame's number.
    pub fn has_place(path: &Path) -> bool {
        path.file_name().is_some_and(|name| place(&name.to_string_lossy()).is_some())
    }

    /// Errors: no place for a number in the name, several, or one in a folder's name.
    pub fn of(path: &Path) -> Result<Pattern> {
        let fault = |what: &str| {
            Error::new(Where::file(path), what).expected(
                "a name like hud.####.exr, hud.%04d.exr or hud.$F4.exr: one place for the number in the file's name",
            )
        };
        let name = path.file_name().and_then(|name| name.to_str()).ok_or_else(|| fault("is no file name"))?;
        let folder = path.parent().map(Path::to_owned).unwrap_or_default();
        if place(&folder.to_string_lossy()).is_some() {
            return Err(fault("has a place for a number in the name of a folder"));
        }
        let Some((start, end, digits)) = place(name) else {
            return Err(fault("has no place for the frames' numbers"));
        };
        let (before, after) = (&name[..start], &name[end..]);
        if place(after).is_some() {
            return Err(fault("has more than one place for a number"));
        }
        Ok(Pattern { folder, before: before.to_owned(), digits, after: after.to_owned() })
    }

    /// The same written with `#`.
    pub fn hashed(&self) -> PathBuf {
        self.folder.join(format!("{}{}{}", self.before, "#".repeat(self.digits), self.after))
    }

    /// The file of a frame: its number with zeros before it, the sign not counted.
    pub fn path(&self, code: i64) -> PathBuf {
        let sign = if code < 0 { "-" } else { "" };
        let (digits, number) = (self.digits, code.unsigned_abs());
        self.folder.join(format!("{}{sign}{number:0digits$}{}", self.before, self.after))
    }
}

/// The file of one frame: `hud.####.exr` is `hud.0012.exr` at 12, a name without a place for a number is itself. Errors: those
/// of a bad name, no frame, or one between whole numbers.
pub fn named(path: &Path, frame: Option<f64>) -> Result<PathBuf> {
    if !Pattern::has_place(path) {
        return Ok(path.to_owned());
    }
    let pattern = Pattern::of(path)?;
    let fault = |what: &str| Error::new(Where::file(path), what).expected("a whole time code, e.g. --frame 12");
    let frame = frame.ok_or_else(|| fault("has a place for the number of a frame, and no frame was named"))?;
    if frame.fract() != 0.0 || frame.abs() > 1e15 {
        return Err(fault("has a place for the number of a frame, and the frame is no whole number"));
    }
    Ok(pattern.path(frame as i64))
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
        assert_eq!(codes("1,3,8-9"), Ok(vec![1, 3, 8, 9]));
        assert_eq!(codes("5, -2"), Ok(vec![5, -2]));
        for bad in
            ["", "1,", ",", "1;2", "-", "a-b", "5-3", "1-5x0", "1-5x", "1.5-3", "1-2-3", "0-9999999", "x2", "é-3"]
        {
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
        assert_eq!(name("hud.%04d.exr", 12), Path::new("hud.0012.exr"));
        assert_eq!(name("hud_%d.exr", 12), Path::new("hud_12.exr"));
        assert_eq!(name("hud.$F4.exr", 12), Path::new("hud.0012.exr"));
        assert_eq!(name("$F.exr", -7), Path::new("-7.exr"));
        for plain in ["a%b.exr", "100%.exr", "$HUD.exr", "50%d9", "%04x.exr"] {
            let is_one = plain == "50%d9";
            assert_eq!(Pattern::has_place(Path::new(plain)), is_one, "{plain}");
        }
        for bad in ["hud.exr", "a#/hud.##.exr", "hud.#.#.exr", "hud.%04d.$F.exr", ".."] {
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
