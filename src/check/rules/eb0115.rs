//! The stage does not say its unit.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0115",
    name: "unit-unsaid",
    level: Level::Warning,
    title: "The stage does not say its unit",
    why: "USD takes centimetres where `metersPerUnit` is not said. CAD exports in millimetres are then ten times too large.",
    bad: Example::Code(
        "text",
        r#"#usda 1.0
(
    defaultPrim = "hud"
)"#,
    ),
    good: Example::Code(
        "text",
        r#"#usda 1.0
(
    defaultPrim = "hud"
    metersPerUnit = 0.001
)"#,
    ),
    find: nothing,
    grade: kept,
};
