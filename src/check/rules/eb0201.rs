//! A refracting face has no index.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0201",
    name: "index-missing",
    level: Level::Error,
    title: "A refracting face has no index",
    why: "A polished face bends light by the index of what is behind it; without one there is nothing to compute.",
    bad: Example::Code(
        "toml",
        r#"[[bind]]
path = "LENS"
finish = "polished""#,
    ),
    good: Example::Code(
        "toml",
        r#"[[bind]]
path = "LENS"
finish = "polished"
glass = "N-BK7""#,
    ),
    find: nothing,
    grade: kept,
};
