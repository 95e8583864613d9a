//! An emitting face has no area.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0309",
    name: "emitter-without-area",
    level: Level::Error,
    title: "An emitting face has no area",
    why: "Light per area of nothing is infinite.",
    bad: Example::Words("A die whose top face collapsed to a line."),
    good: Example::Words("A face with triangles that have an area."),
    find: nothing,
    grade: kept,
};
