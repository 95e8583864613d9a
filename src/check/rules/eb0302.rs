//! An emitter has two strengths.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0302",
    name: "emitter-with-two-strengths",
    level: Level::Error,
    title: "An emitter has two strengths",
    why: "Flux, luminance and intensity follow from each other by area and angle: two of them contradict sooner or later.",
    bad: Example::Code("toml", r#"emitter = { group = "led", flux_lm = 0.45, luminance_cd_m2 = 3e6 }"#),
    good: Example::Code("toml", r#"emitter = { group = "led", flux_lm = 0.45 }"#),
    find: nothing,
    grade: kept,
};
