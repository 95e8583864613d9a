//! A transform flattens a part.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0112",
    name: "part-flattened",
    level: Level::Warning,
    title: "A transform flattens a part",
    why: "A scale of 0 along an axis leaves a sheet without an inside.",
    bad: Example::Code("json", r#"{ "scale": [1, 1, 0] }"#),
    good: Example::Code("json", r#"{ "scale": [1, 1, 1] }"#),
    find: nothing,
    grade: kept,
};
