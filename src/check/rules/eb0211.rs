//! A solid that transmits a part.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0211",
    name: "transmission-partial",
    level: Level::Warning,
    title: "A solid transmits a part of the light",
    why: "`transmissionFactor` between 0 and 1 mixes two materials. A face of a solid (`thicknessFactor` above 0) refracts or it does not; how much a coating lets through is the coating's business. Its faces are taken as thin sheets, which may mix.",
    bad: Example::Code(
        "json",
        r#""KHR_materials_transmission": { "transmissionFactor": 0.5 }, "KHR_materials_volume": { "thicknessFactor": 1 }"#,
    ),
    good: Example::Code("toml", "coating = { ideal = { R = 0.5, T = 0.5 } }"),
    find: nothing,
    grade: kept,
};
