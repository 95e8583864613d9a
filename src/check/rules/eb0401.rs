//! A slide has no size.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0401",
    name: "slide-without-size",
    level: Level::Error,
    title: "A slide has no size",
    why: "A picture file has pixels, no millimetres: how large it stands in the display must be said.",
    bad: Example::Code("toml", r#"slide = { image = "speed.png", u = [1, 0, 0], v = [0, 1, 0] }"#),
    good: Example::Code("toml", r#"slide = { image = "speed.png", size = [40, 20], u = [1, 0, 0], v = [0, 1, 0] }"#),
    find: nothing,
    grade: kept,
};
