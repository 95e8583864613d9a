//! What validation has to say about an asset.

use eyebox_base::Where;
use std::fmt;

/// How grave a finding is. Errors and warnings make `eyebox validate` exit with 1; notes don't.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Level {
    /// Worth knowing: something is left over, or was repaired and changes no picture.
    Note,
    /// It renders, but probably not what the author meant.
    Warning,
    /// It does not render, or renders something that cannot be.
    Error,
}

impl Level {
    pub const ALL: [Level; 3] = [Level::Note, Level::Warning, Level::Error];

    pub fn name(self) -> &'static str {
        match self {
            Level::Note => "note",
            Level::Warning => "warning",
            Level::Error => "error",
        }
    }
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// One thing that a rule found, at one place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// Code of the rule.
    pub code: &'static str,
    pub level: Level,
    pub at: Where,
    /// One line: what, with the offending value.
    pub text: String,
}
