//! All normals of a face point to the inside.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0113",
    name: "normals-inside-out",
    level: Level::Warning,
    title: "All normals of a face point to the inside",
    why: "Winding and normals disagree on what is outside. eyebox follows the winding for what is inside and the normals for nothing but their bend; another program may do the opposite.",
    bad: Example::Words("Normals negated, triangles not."),
    good: Example::Words("Normals that point to where the triangles are counter-clockwise."),
    find: nothing,
    grade: kept,
};
