//! An extension that bears on the picture is not used.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0004",
    name: "extension-ignored",
    level: Level::Warning,
    title: "An extension that bears on the picture is not used",
    why: "What it says about the look of a part is left out: the picture is that of an asset without it. It may also be misspelt.",
    bad: Example::Code("json", r#""extensions": { "KHR_materials_subsurface": { "scatterDistance": 0.01 } }"#),
    good: Example::Code(
        "toml",
        r#"[[bind]]
material = "PAINT"
finish = { kind = "measured", file = "wax.bsdf" }"#,
    ),
    find: nothing,
    grade: kept,
};
