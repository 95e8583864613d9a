//! A glass, medium or coating of this name does not exist.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0209",
    name: "name-unknown",
    level: Level::Error,
    title: "A glass, medium or coating of this name does not exist",
    why: "A misspelt glass is not air and not BK7. The finding names the nearest name of the catalogue, which `eyebox glass` lists.",
    bad: Example::Code("toml", r#"glass = "N-BK8""#),
    good: Example::Code("toml", r#"glass = "N-BK7""#),
    find: nothing,
    grade: kept,
};
