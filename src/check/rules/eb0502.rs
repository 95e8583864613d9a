//! The eye is inside a solid.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0502",
    name: "eye-in-solid",
    level: Level::Error,
    title: "The eye is inside a solid",
    why: "An eye looks from air. One inside a lens or a windscreen was placed in another frame or unit.",
    bad: Example::Code("toml", r#"position = ["0 mm", "0 mm", "-80 mm"]     # the middle of the lens"#),
    good: Example::Code("toml", r#"position = ["0 mm", "0 mm", "0 mm"]"#),
    find: nothing,
    grade: kept,
};
