//! The eye cannot be one.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0503",
    name: "eye-impossible",
    level: Level::Error,
    title: "The eye cannot be one",
    why: "Directions at right angles, a field of view below 180°, a pupil of 0 mm or more, some pixels.",
    bad: Example::Code(
        "toml",
        r#"look = [0, 0, -1]
up = [0, 0, 1]"#,
    ),
    good: Example::Code(
        "toml",
        r#"look = [0, 0, -1]
up = [0, 1, 0]"#,
    ),
    find: nothing,
    grade: kept,
};
