//! Something in the asset was repaired or left out on reading.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0005",
    name: "left-out",
    level: Level::Warning,
    title: "Something in the asset was repaired or left out on reading",
    why: "The reader could go on, but what it took is not what the file says.",
    bad: Example::Code("json", r#"{ "rotation": [0, 0, 0, 2] }"#),
    good: Example::Code("json", r#"{ "rotation": [0, 0, 0, 1] }"#),
    find: nothing,
    grade: kept,
};
