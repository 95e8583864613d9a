//! A material of the asset is used by no face.

use crate::finding::{Finding, Level};
use crate::rule::{Example, Rule, kept};
use crate::subject::Subject;
use std::collections::BTreeSet;

pub const RULE: Rule = Rule {
    code: "EB0208",
    name: "material-unused",
    level: Level::Note,
    title: "A material of the asset is used by no face",
    why: "It is left over from the exporter, or a face lost it.",
    bad: Example::Code(
        "json",
        r#""materials": [{ "name": "GLASS" }, { "name": "CHROME" }]   // no primitive has "material": 1"#,
    ),
    good: Example::Code("json", r#""primitives": [{ "material": 1, … }]"#),
    find,
    grade: kept,
};

fn find(subject: &Subject<'_>) -> Vec<Finding> {
    let meshes = subject.assembly.nodes.iter().filter_map(|node| subject.assembly.meshes.get(node.mesh?));
    let used: BTreeSet<usize> = meshes.flat_map(|mesh| mesh.materials.iter().flatten().copied()).collect();
    let unused = subject.assembly.materials.iter().enumerate().filter(|(index, _)| !used.contains(index));
    unused
        .map(|(_, material)| RULE.at(material.at.clone(), format!("no face has the material `{}`", material.name)))
        .collect()
}
