//! There is nothing that light could meet.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0114",
    name: "nothing-to-trace",
    level: Level::Error,
    title: "There is nothing that light could meet",
    why: "An asset without a surface renders black, or the sky alone.",
    bad: Example::Code("json", r#""scenes": [{ "nodes": [] }]"#),
    good: Example::Code("json", r#""scenes": [{ "nodes": [0] }]"#),
    find: nothing,
    grade: kept,
};
