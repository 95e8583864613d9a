//! The scene cannot be traced.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0608",
    name: "scene-refused",
    level: Level::Error,
    title: "The scene cannot be traced",
    why: "Each attribute is sound, but together they cannot be traced.",
    bad: Example::Words("A face whose coating has more films than can be computed."),
    good: Example::Words("Fewer films."),
    find: nothing,
    grade: kept,
};
