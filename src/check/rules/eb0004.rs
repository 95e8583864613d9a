//! An extension that bears on the picture is not used.

use crate::check::finding::Level;
use crate::check::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0004",
    name: "extension-ignored",
    level: Level::Warning,
    title: "An extension that bears on the picture is not used",
    why: "What it says about the look of a part is left out: the picture is that of an asset without it. It may also be misspelt.",
    bad: Example::Code("json", r#""extensions": { "KHR_materials_clearcoat": { "clearcoatFactor": 1 } }"#),
    good: Example::Code(
        "toml",
        r#"[[bind]]
material = "PAINT"
coating = { stack = [{ n = 1.5, thickness_nm = 2000 }] }"#,
    ),
    claims: &[
        "warning …bears on what is seen but is not used",
        "warning …is not known and was ignored",
        "warning …`EYEBOX_optics` means nothing here",
        "warning …`KHR_materials_variants`",
        "warning …is not used yet",
        "warning …shines from its front alone",
        "warning …an animation shows or hides nodes",
    ],
    find: nothing,
    grade: kept,
};
