//! The picture of a slide is missing or unreadable.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0402",
    name: "slide-image-missing",
    level: Level::Error,
    title: "The picture of a slide is missing or unreadable",
    why: "A display without its picture is a lamp.",
    bad: Example::Code("toml", r#"slide = { image = "spede.png", … }"#),
    good: Example::Code("toml", r#"slide = { image = "speed.png", … }"#),
    find: nothing,
    grade: kept,
};
