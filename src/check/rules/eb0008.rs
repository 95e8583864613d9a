//! A coordinate or a normal is not a finite number.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0008",
    name: "data-not-finite",
    level: Level::Error,
    title: "A coordinate or a normal is not a finite number",
    why: "One NaN spreads to every box around it, and a part is gone or everywhere.",
    bad: Example::Words("A vertex at (NaN, 0, 0): a division by zero in the exporter."),
    good: Example::Words("Finite positions and unit normals."),
    find: nothing,
    grade: kept,
};
