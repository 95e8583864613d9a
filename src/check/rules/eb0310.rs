//! A light group cannot be one.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0310",
    name: "group-unusable",
    level: Level::Error,
    title: "A light group cannot be one",
    why: "Layers are kept per group and named by it: letters, digits and underscores. A lamp in the sky's group could not be told from the sky when the layers are mixed.",
    bad: Example::Code("toml", r#"emitter = { group = "1-led", flux_lm = 1 }"#),
    good: Example::Code("toml", r#"emitter = { group = "led", flux_lm = 1 }"#),
    find: nothing,
    grade: kept,
};
