//! A file that the asset needs is missing.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0007",
    name: "file-missing",
    level: Level::Error,
    title: "A file that the asset needs is missing",
    why: "A buffer, a sky, a table or the asset that a sidecar names: without it nothing can be traced.",
    bad: Example::Code(
        "toml",
        r#"[sky]
image = "env_dya.exr""#,
    ),
    good: Example::Code(
        "toml",
        r#"[sky]
image = "env_day.exr""#,
    ),
    find: nothing,
    grade: kept,
};
