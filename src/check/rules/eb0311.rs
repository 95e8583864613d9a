//! A spectrum has no light that can be seen.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0311",
    name: "spectrum-unusable",
    level: Level::Error,
    title: "A spectrum has no light that can be seen",
    why: "Photometry needs power between 360 and 830 nm; wavelengths must rise.",
    bad: Example::Code("toml", "spectrum = { table = [[900, 1], [950, 1]] }"),
    good: Example::Code("toml", "spectrum = { table = [[450, 1], [650, 1]] }"),
    find: nothing,
    grade: kept,
};
