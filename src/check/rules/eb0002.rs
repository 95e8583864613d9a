//! The sidecar is not TOML.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0002",
    name: "sidecar-unreadable",
    level: Level::Error,
    title: "The sidecar is not TOML",
    why: "Without it the asset has no optics. The line is where the TOML reader stopped.",
    bad: Example::Code("toml", "schema 1"),
    good: Example::Code("toml", "schema = 1"),
    find: nothing,
    grade: kept,
};
