//! A scattering face gives back more light than it gets.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0206",
    name: "scatter-gains-energy",
    level: Level::Error,
    title: "A scattering face gives back more light than it gets",
    why: "Reflectance and transmittance are shares of the same light: together they are at most 1.",
    bad: Example::Code("toml", r#"finish = { kind = "lambert", reflectance = 0.7, transmittance = 0.6 }"#),
    good: Example::Code("toml", r#"finish = { kind = "lambert", reflectance = 0.4, transmittance = 0.6 }"#),
    find: nothing,
    grade: kept,
};
