//! An attribute has a value that it cannot have.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0607",
    name: "value-impossible",
    level: Level::Error,
    title: "An attribute has a value that it cannot have",
    why: "Out of its range, of the wrong kind, or left out where it must be said. The finding says what was expected.",
    bad: Example::Code("toml", r#"emitter = { group = "led", flux_lm = -1 }"#),
    good: Example::Code("toml", r#"emitter = { group = "led", flux_lm = 1 }"#),
    find: nothing,
    grade: kept,
};
