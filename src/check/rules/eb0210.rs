//! A table does not cover the wavelength.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0210",
    name: "table-too-short",
    level: Level::Error,
    title: "A table does not cover the wavelength",
    why: "Between rows values are interpolated, beyond them nothing is known.",
    bad: Example::Code("toml", "absorption_per_m = [[600, 1], [700, 1]]   # at 550 nm"),
    good: Example::Code("toml", "absorption_per_m = [[400, 1], [700, 1]]"),
    find: nothing,
    grade: kept,
};
