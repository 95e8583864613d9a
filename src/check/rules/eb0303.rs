//! What the asset says of an emitter contradicts what is bound to it.

use crate::finding::{Finding, Level};
use crate::lamps;
use crate::rule::{Example, Rule, kept};
use crate::subject::Subject;

pub const RULE: Rule = Rule {
    code: "EB0303",
    name: "strengths-contradict",
    level: Level::Warning,
    title: "What the asset says of an emitter contradicts what is bound to it",
    why: "The material of a face has an emission in cd/m², and the sidecar gives the face a flux or a luminance of its own, which wins. If both are meant to be the same lamp they should agree; the finding gives both in cd/m².",
    bad: Example::Code(
        "json",
        r#""emissiveFactor": [1, 1, 1], "KHR_materials_emissive_strength": { "emissiveStrength": 5000 }   // beside emitter = { luminance_cd_m2 = 1e6 }"#,
    ),
    good: Example::Code("toml", r#"emitter = { group = "led", luminance_cd_m2 = 5000 }"#),
    find,
    grade: kept,
};

/// Strengths that differ by more than this share contradict: the sheet of an LED is not better than that.
const SHARE: f64 = 0.1;

fn find(subject: &Subject<'_>) -> Vec<Finding> {
    let mut out = Vec::new();
    for part in &subject.scene.parts {
        // The parts of the scene that are meshes of the asset come first and in its order.
        let Some(source) = subject.assembly.meshes.get(part.mesh.index()) else { continue };
        for (number, face) in part.faces.iter().enumerate() {
            let Some(emitter) = &face.emitter else { continue };
            let material = source.materials.get(number).copied().flatten();
            let Some(material) = material.and_then(|index| subject.assembly.materials.get(index)) else { continue };
            let said = material.mapped.iter().find(|(key, _)| key == "luminance_cd_m2");
            let Some(said) = said.and_then(|(_, value)| value.number()).filter(|said| *said > 0.0) else { continue };
            let Some(bound) = lamps::luminance(subject.scene, part, number, emitter) else { continue };
            if (bound - said).abs() > SHARE * said.max(bound) {
                let name = &material.name;
                let text = format!("bound with {bound:.4} cd/m², but its material `{name}` emits {said:.4} cd/m²");
                out.push(RULE.at(subject.part(&part.path, Some(number)), text));
            }
        }
    }
    out
}
