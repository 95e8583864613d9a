//! A name means several parts.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0605",
    name: "name-ambiguous",
    level: Level::Error,
    title: "A name means several parts",
    why: "A path without a pattern means one part.",
    bad: Example::Code(
        "toml",
        r#"[[bind]]
path = "HUD/LED"           # there are two"#,
    ),
    good: Example::Code(
        "toml",
        r#"[[bind]]
path = "HUD/LED*""#,
    ),
    find: nothing,
    grade: kept,
};
