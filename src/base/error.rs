//! Errors for people: what is wrong, where, what was expected, and the nearest valid name. One line each.

use super::Code;
use std::fmt;
use std::path::{Path, PathBuf};

/// A place in the user's material.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default, serde::Serialize)]
pub enum Where {
    /// No better place is known (a command-line argument, the whole run).
    #[default]
    Nowhere,
    /// A whole file.
    File(PathBuf),
    /// A line (1-based) of a text file.
    Line { file: PathBuf, line: usize },
    /// A JSON pointer (RFC 6901) inside a JSON or glTF file, e.g. `/nodes/3/extensions/EYEBOX_optics`.
    Pointer { file: PathBuf, pointer: String },
    /// A prim or property of a USD stage whose root layer is `file`, e.g. `/hud/LENS_01.xformOpOrder`.
    Prim { file: PathBuf, prim: String },
    /// A part of the assembly by its root-relative path, e.g. `HUD_B/LENS_01_PMMA`, with a face if one is meant.
    Part { path: String, face: Option<usize> },
    /// A command-line option, e.g. `--set led.flux_lm=-1`.
    Option(String),
}

impl Where {
    pub fn file(path: &Path) -> Self {
        Where::File(path.to_owned())
    }
    pub fn part(path: &str) -> Self {
        Where::Part { path: path.to_owned(), face: None }
    }
}

impl fmt::Display for Where {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Where::Nowhere => Ok(()),
            Where::File(file) => write!(f, "{}", file.display()),
            Where::Line { file, line } => write!(f, "{}:{line}", file.display()),
            Where::Pointer { file, pointer } => write!(f, "{}#{pointer}", file.display()),
            Where::Prim { file, prim } => write!(f, "{}<{prim}>", file.display()),
            Where::Part { path, face: None } => write!(f, "part {path}"),
            Where::Part { path, face: Some(face) } => write!(f, "part {path} face {face}"),
            Where::Option(text) => write!(f, "{text}"),
        }
    }
}

/// A fault in the user's material or in what was asked: it ends the command with exit code 2.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Error {
    /// What is wrong, with the offending value, in plain words.
    pub what: String,
    pub at: Where,
    /// The range or form that would have been right.
    pub expected: Option<String>,
    /// The valid name nearest to a misspelt one.
    pub nearest: Option<String>,
    /// What it is about, where more is known of that than how far reading had come.
    #[serde(skip)]
    pub code: Option<Code>,
}

pub type Result<T, E = Box<Error>> = std::result::Result<T, E>;

impl Error {
    pub fn new(at: Where, what: impl Into<String>) -> Box<Self> {
        Box::new(Error { what: what.into(), at, expected: None, nearest: None, code: None })
    }
    pub fn expected(mut self: Box<Self>, range: impl Into<String>) -> Box<Self> {
        self.expected = Some(range.into());
        self
    }
    /// Says what it is about.
    pub fn code(mut self: Box<Self>, code: impl Into<Option<Code>>) -> Box<Self> {
        self.code = code.into();
        self
    }
    /// Adds the valid name nearest to `given`, if one is near enough to be a misspelling.
    pub fn nearest<'a>(mut self: Box<Self>, given: &str, valid: impl IntoIterator<Item = &'a str>) -> Box<Self> {
        self.nearest = nearest_name(given, valid);
        self
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let at = self.at.to_string();
        if !at.is_empty() {
            write!(f, "{at}: ")?;
        }
        write!(f, "{}", self.what)?;
        if let Some(expected) = &self.expected {
            write!(f, "; expected {expected}")?;
        }
        if let Some(nearest) = &self.nearest {
            write!(f, "; did you mean `{nearest}`?")?;
        }
        Ok(())
    }
}

impl std::error::Error for Error {}

/// The name in `valid` nearest to `given` by Jaro–Winkler similarity, if it is at least 0.75 similar. That alone would take
/// `forward_led_open` for a misspelling of `foo`: one has to begin the other, or more than half of the letters must fit.
pub fn nearest_name<'a>(given: &str, valid: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let lower = given.to_lowercase();
    valid
        .into_iter()
        .map(|name| (strsim::jaro_winkler(&lower, &name.to_lowercase()), name))
        .filter(|(score, name)| *score >= 0.75 && alike(&lower, &name.to_lowercase()))
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name.to_owned())
}

fn alike(a: &str, b: &str) -> bool {
    let longer = a.chars().count().max(b.chars().count());
    a.starts_with(b) || b.starts_with(a) || 2 * strsim::osa_distance(a, b) < longer
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_line_with_place_range_and_nearest_name() {
        let at = Where::Line { file: "hud.optics.toml".into(), line: 12 };
        let fault = Error::new(at, "unknown attribute `flux_lum`")
            .expected("an emitter attribute")
            .nearest("flux_lum", ["flux_lm", "luminance_cd_m2"]);
        assert_eq!(
            fault.to_string(),
            "hud.optics.toml:12: unknown attribute `flux_lum`; expected an emitter attribute; did you mean `flux_lm`?"
        );
        assert_eq!(nearest_name("xyz", ["flux_lm"]), None);
        assert_eq!(nearest_name("foo", ["forward_led_open_stderr"]), None);
        assert_eq!(nearest_name("pupil", ["position", "pupil_diameter"]), Some("pupil_diameter".to_owned()));
        assert_eq!(nearest_name("eb101", ["EB0311", "EB0101"]), Some("EB0101".to_owned()));
    }
}
