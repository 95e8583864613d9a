//! A refractive index is impossible.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0202",
    name: "index-impossible",
    level: Level::Error,
    title: "A refractive index is impossible",
    why: "Below 1 light would be faster than in vacuum, above 10 no glass or metal is; most such numbers are a wavelength or a decimal point in the wrong place.",
    bad: Example::Code("toml", "ior = 0.67"),
    good: Example::Code("toml", "ior = 1.49"),
    find: nothing,
    grade: kept,
};
