//! An emitter has no photometry.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0301",
    name: "emitter-without-strength",
    level: Level::Error,
    title: "An emitter has no photometry",
    why: "Without lumens, candela or cd/m² the picture has no absolute scale. Nothing is assumed.",
    bad: Example::Code("toml", r#"emitter = { group = "led" }"#),
    good: Example::Code("toml", r#"emitter = { group = "led", flux_lm = 0.45 }"#),
    find: nothing,
    grade: kept,
};
