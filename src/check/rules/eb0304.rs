//! A photometric or ray file is missing.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0304",
    name: "profile-missing",
    level: Level::Error,
    title: "A photometric or ray file is missing",
    why: "The lamp's distribution is not known without it.",
    bad: Example::Code("toml", r#"angular = { profile = { file = "led.ies" } }   # not beside the sidecar"#),
    good: Example::Code("toml", r#"angular = { profile = { file = "photometry/led.ies" } }"#),
    find: nothing,
    grade: kept,
};
