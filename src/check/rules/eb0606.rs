//! A node has optical attributes but no part.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0606",
    name: "attributes-on-nothing",
    level: Level::Warning,
    title: "A node has optical attributes but no part",
    why: "Attributes of a node hold for the parts at and below it; there are none, so they hold for nothing.",
    bad: Example::Code("json", r#"{ "name": "EMPTY", "extensions": { "EYEBOX_optics": { "priority": 1 } } }"#),
    good: Example::Code(
        "json",
        r#"{ "name": "LENS", "mesh": 0, "extensions": { "EYEBOX_optics": { "priority": 1 } } }"#,
    ),
    find: nothing,
    grade: kept,
};
