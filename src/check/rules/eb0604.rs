//! Two rules of the same rank contradict.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0604",
    name: "bound-twice",
    level: Level::Error,
    title: "Two rules of the same rank contradict",
    why: "Which of them holds would be chance. A more specific selector decides it.",
    bad: Example::Code(
        "toml",
        r#"[[bind]]
path = "LED_*"
finish = "polished"

[[bind]]
path = "*_1"
finish = "none""#,
    ),
    good: Example::Code(
        "toml",
        r#"[[bind]]
path = "LED_*"
finish = "polished"

[[bind]]
path = "LED_1"
finish = "none""#,
    ),
    find: nothing,
    grade: kept,
};
