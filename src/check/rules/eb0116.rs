//! A triangle lies there twice.

use crate::finding::{Finding, Level};
use crate::rule::{Example, Rule, kept};
use crate::subject::{Subject, is_solid};
use eyebox_scene::Part;

pub const RULE: Rule = Rule {
    code: "EB0116",
    name: "triangle-doubled",
    level: Level::Warning,
    title: "A triangle lies there twice",
    why: "A doubled triangle of a lamp shines twice, and one of a solid is a second interface at the same place. Exports that merge a shell with its own copy make them.",
    bad: Example::Words("A die whose upper face was exported with the die and once more with its label."),
    good: Example::Words("The same die with duplicate faces merged before export."),
    find,
    grade: kept,
};

fn find(subject: &Subject<'_>) -> Vec<Finding> {
    let shines = |part: &&Part| part.faces.iter().any(|face| face.emitter.is_some());
    let doubled = |part: &Part| {
        let doubled = subject.edges.of(subject.scene, part.mesh).doubled;
        let all = subject.scene.mesh(part.mesh).triangles.len();
        let (are, theirs) = if doubled == 1 { ("lies", "another does") } else { ("lie", "others do") };
        let text = format!("{doubled} of {all} triangles {are} where {theirs}, the same way round");
        (doubled > 0).then(|| RULE.at(subject.part(&part.path, None), text))
    };
    subject.scene.parts.iter().filter(|part| is_solid(part) || shines(part)).filter_map(doubled).collect()
}
