//! An emitter is brighter than the sun.

use crate::finding::{Finding, Level};
use crate::lamps;
use crate::rule::{Example, Rule, kept};
use crate::subject::Subject;

pub const RULE: Rule = Rule {
    code: "EB0308",
    name: "luminance-implausible",
    level: Level::Warning,
    title: "An emitter is brighter than the sun",
    why: "The sun's disc has 1.6e9 cd/m². Lamps that are looked at have less; more is a flux on a face that is too small, or a wrong unit.",
    bad: Example::Code("toml", r#"emitter = { group = "led", flux_lm = 450 }     # on a die of 0.01 mm²"#),
    good: Example::Code("toml", r#"emitter = { group = "led", flux_lm = 0.45 }"#),
    find,
    grade: kept,
};

/// The sun's disc outside of the atmosphere: 128 klx from 6.80e-5 sr (IESNA, The Lighting Handbook).
const SUN_CD_M2: f64 = 1.88e9;

fn find(subject: &Subject<'_>) -> Vec<Finding> {
    let mut out = Vec::new();
    for part in &subject.scene.parts {
        for (number, face) in part.faces.iter().enumerate() {
            let luminance = face.emitter.as_ref().and_then(|e| lamps::luminance(subject.scene, part, number, e));
            if let Some(luminance) = luminance.filter(|luminance| *luminance > SUN_CD_M2) {
                let text = format!("its face has {luminance:.3e} cd/m², the sun {SUN_CD_M2:.2e}");
                out.push(RULE.at(subject.part(&part.path, Some(number)), text));
            }
        }
    }
    out
}
