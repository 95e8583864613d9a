//! There is no eye.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0501",
    name: "eye-missing",
    level: Level::Error,
    title: "There is no eye",
    why: "What is seen depends on where it is seen from. Where somebody has said what parts are, \
        nothing is assumed; an asset of which nobody has is framed.",
    bad: Example::Code("toml", "# no [eye], and the asset has no perspective camera"),
    good: Example::Code(
        "toml",
        r#"[eye]
position = ["0 mm", "0 mm", "0 mm"]
look = [0, 0, -1]
up = [0, 1, 0]
fov_deg = 12"#,
    ),
    find: nothing,
    grade: kept,
};
