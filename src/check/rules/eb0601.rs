//! A part is bound by no rule.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0601",
    name: "part-unbound",
    level: Level::Error,
    title: "A part is bound by no rule",
    why: "It has no finish, so it is not known what it does with light. Nor has it a material that says how it looks, which would be shown. Nothing is assumed, not even black. `finish = \"material\"` says of a part that its material is meant.",
    bad: Example::Code(
        "toml",
        r#"[[bind]]
path = "LENS"          # and no [default]"#,
    ),
    good: Example::Code(
        "toml",
        r#"[default]
finish = "absorber""#,
    ),
    find: nothing,
    grade: kept,
};
