//! A coordinate or a normal is not a finite number.

use crate::check::finding::Level;
use crate::check::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0008",
    name: "data-not-finite",
    level: Level::Error,
    title: "A coordinate or a normal is not a finite number",
    why: "One NaN spreads to every box around it, and a part is gone or everywhere.",
    bad: Example::Words("A vertex at (NaN, 0, 0): a division by zero in the exporter."),
    good: Example::Words("Finite positions and unit normals."),
    claims: &[
        "read …vertex … is at (",
        "read …point … is at (",
        "has a coordinate that is not a number",
        "warning …texture coordinates that are not finite",
        "warning …a normal that is zero or not finite",
    ],
    find: nothing,
    grade: kept,
};
