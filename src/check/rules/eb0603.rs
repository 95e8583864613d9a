//! An attribute is not known.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0603",
    name: "attribute-unknown",
    level: Level::Error,
    title: "An attribute is not known",
    why: "A misspelt attribute would otherwise be a silent default.",
    bad: Example::Code("toml", r#"emitter = { group = "led", flux_lum = 0.45 }"#),
    good: Example::Code("toml", r#"emitter = { group = "led", flux_lm = 0.45 }"#),
    find: nothing,
    grade: kept,
};
