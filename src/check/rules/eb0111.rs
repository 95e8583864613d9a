//! An exact shape is scaled unevenly.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0111",
    name: "uneven-scale",
    level: Level::Error,
    title: "An exact shape is scaled unevenly",
    why: "A sphere that is stretched along one axis is none.",
    bad: Example::Code("json", r#"{ "name": "LENS", "scale": [1, 1, 2] }   // with a fitted sphere"#),
    good: Example::Code("json", r#"{ "name": "LENS", "scale": [2, 2, 2] }"#),
    find: nothing,
    grade: kept,
};
