//! A rule matches nothing.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0602",
    name: "rule-matches-nothing",
    level: Level::Error,
    title: "A rule matches nothing",
    why: "A `[[bind]]` whose selector fits no part or no face was meant for one: a part was renamed, or the name is misspelt.",
    bad: Example::Code(
        "toml",
        r#"[[bind]]
path = "LENZ_01""#,
    ),
    good: Example::Code(
        "toml",
        r#"[[bind]]
path = "LENS_01""#,
    ),
    find: nothing,
    grade: kept,
};
