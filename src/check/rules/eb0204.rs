//! A coating gives back more light than it gets.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0204",
    name: "coating-gains-energy",
    level: Level::Error,
    title: "A coating gives back more light than it gets",
    why: "R + T above 1 makes light out of nothing, and between two such faces the picture grows without end.",
    bad: Example::Code(
        "toml",
        r#"[coating.mirror]
ideal = { R = 0.6, T = 0.6 }"#,
    ),
    good: Example::Code(
        "toml",
        r#"[coating.mirror]
ideal = { R = 0.6, T = 0.4 }"#,
    ),
    find: nothing,
    grade: kept,
};
