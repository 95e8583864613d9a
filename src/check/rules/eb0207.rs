//! A named coating or medium is used by no part.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0207",
    name: "named-unused",
    level: Level::Note,
    title: "A named coating or medium is used by no part",
    why: "It is left over, or the part that should have it has another name.",
    bad: Example::Code(
        "toml",
        r#"[coating.ar]
stack = [{ n = 1.38, thickness_nm = 99.6 }]   # and no coating = "ar""#,
    ),
    good: Example::Code(
        "toml",
        r#"[[bind]]
path = "LENS"
coating = "ar""#,
    ),
    find: nothing,
    grade: kept,
};
