//! A catalogue law is used beyond its range.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0203",
    name: "index-extrapolated",
    level: Level::Warning,
    title: "A catalogue law is used beyond its range",
    why: "A Sellmeier formula is a fit: beyond the wavelengths it was fitted to it may say anything.",
    bad: Example::Code("toml", "wavelengths = { mono_nm = 380 }       # PMMA is measured from 436.8 nm on"),
    good: Example::Code("toml", "wavelengths = { mono_nm = 550 }"),
    find: nothing,
    grade: kept,
};
