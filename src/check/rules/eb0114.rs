//! There is nothing that light could meet.

use crate::check::finding::Level;
use crate::check::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0114",
    name: "nothing-to-trace",
    level: Level::Error,
    title: "There is nothing that light could meet",
    why: "An asset without a surface renders black, or the sky alone.",
    bad: Example::Code("json", r#""scenes": [{ "nodes": [] }]"#),
    good: Example::Code("json", r#""scenes": [{ "nodes": [0] }]"#),
    claims: &[
        "nothing in the scene has a surface",
        "the scene has no nodes",
        "the stage has no prims that are placed anywhere",
        "no node has geometry",
    ],
    find: nothing,
    grade: kept,
};
