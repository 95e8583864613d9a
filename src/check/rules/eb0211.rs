//! A partial transmission has no meaning.

use crate::check::finding::Level;
use crate::check::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0211",
    name: "transmission-partial",
    level: Level::Warning,
    title: "A partial transmission has no meaning",
    why: "`transmissionFactor` between 0 and 1 mixes two materials. A face refracts or it does not; how much a coating lets through is the coating's business.",
    bad: Example::Code("json", r#""KHR_materials_transmission": { "transmissionFactor": 0.5 }"#),
    good: Example::Code("toml", "coating = { ideal = { R = 0.5, T = 0.5 } }"),
    find: nothing,
    grade: kept,
};
