//! A coating lies on a face that is not polished.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0205",
    name: "coating-not-polished",
    level: Level::Error,
    title: "A coating lies on a face that is not polished",
    why: "Thin films are computed for a smooth interface. On an absorber or a scatterer they would change nothing, silently.",
    bad: Example::Code(
        "toml",
        r#"finish = "absorber"
coating = "ar""#,
    ),
    good: Example::Code(
        "toml",
        r#"finish = "polished"
coating = "ar""#,
    ),
    find: nothing,
    grade: kept,
};
