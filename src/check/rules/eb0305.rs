//! A photometric or ray file is malformed.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0305",
    name: "profile-malformed",
    level: Level::Error,
    title: "A photometric or ray file is malformed",
    why: "An IES or EULUMDAT file is a list of numbers whose meaning hangs on their count: one too many, and every candela is another direction's. A ray file (TM-25, Zemax) is as long as its header says, with unit directions and flux that is not negative.",
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
    find: nothing,
    grade: kept,
};
