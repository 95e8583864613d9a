//! A validation rule: what it looks for, why that matters, and how it finds it.
//!
//! Some faults are found by the importer, which must not go on with them. They say themselves what they are about
//! ([`Code`](eyebox_base::Code)), and that names their rule; `tests/validate/` plants every fault into a good asset. The
//! others are looked for by `find`.

use super::finding::{Finding, Level};
use super::subject::Subject;
use eyebox_base::Where;
use eyebox_scene::Note;

/// A rule of the registry. See [`RULES`](super::rules::RULES).
#[derive(Debug)]
pub struct Rule {
    /// Stable: `EB` and four digits. A code is never used again for something else.
    pub code: &'static str,
    /// Stable, in words: `solid-open`.
    pub name: &'static str,
    pub level: Level,
    /// One line.
    pub title: &'static str,
    /// Why it matters, in whole sentences.
    pub why: &'static str,
    /// What sets it off, and the same put right.
    pub bad: Example,
    pub good: Example,
    pub find: fn(&Subject<'_>) -> Vec<Finding>,
    /// How grave a note of the importer is, where that hangs on the scene.
    pub grade: fn(&Self, &Subject<'_>, &Note) -> Level,
}

/// A piece of an asset.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Example {
    /// A sidecar, or an IES file, or any other text, with the name of its language for the page.
    Code(&'static str, &'static str),
    /// In words, where the fault is in geometry.
    Words(&'static str),
}

/// For rules that have nothing to look for themselves.
pub fn nothing(_: &Subject<'_>) -> Vec<Finding> {
    Vec::new()
}

/// The level of the rule.
pub fn kept(rule: &Rule, _: &Subject<'_>, _: &Note) -> Level {
    rule.level
}

impl Rule {
    /// A finding of this rule.
    pub fn at(&self, at: Where, text: impl Into<String>) -> Finding {
        Finding { code: self.code, level: self.level, at, text: text.into() }
    }
}
