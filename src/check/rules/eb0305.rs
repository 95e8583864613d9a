//! A photometric file is malformed.

use crate::check::finding::Level;
use crate::check::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0305",
    name: "profile-malformed",
    level: Level::Error,
    title: "A photometric file is malformed",
    why: "An IES or EULUMDAT file is a list of numbers whose meaning hangs on their count: one too many, and every candela is another direction's.",
    bad: Example::Code(
        "text",
        r#"1 -1 1 3 1 1 2 0 0 0
1 1 5
0 45 90
0
8 2          (3 angles, 2 candela values)"#,
    ),
    good: Example::Code(
        "text",
        r#"1 -1 1 3 1 1 2 0 0 0
1 1 5
0 45 90
0
8 5 2"#,
    ),
    claims: &[
        "build .ies:",
        "build .ldt:",
        "build .eul:",
        "warning …the horizontal angles end at",
        "warning …names no edition that is known",
        "warning …no edition is named",
    ],
    find: nothing,
    grade: kept,
};
