//! A solid with a medium is not closed.

use crate::finding::{Finding, Level};
use crate::rule::{Example, Rule, kept};
use crate::subject::{Subject, is_solid};
use eyebox_scene::Part;

pub const RULE: Rule = Rule {
    code: "EB0102",
    name: "solid-open",
    level: Level::Error,
    title: "A solid with a medium is not closed",
    why: "A ray that enters through a face and leaves through a hole never finds out that it left: from there on it travels in glass, and every later refraction is wrong.",
    bad: Example::Words("A lens whose rim was left out of the export: two caps and nothing between them."),
    good: Example::Words(r#"The same lens with its rim, which may be black (`finish = "absorber"`)."#),
    find,
    grade: kept,
};

fn find(subject: &Subject<'_>) -> Vec<Finding> {
    let open = |part: &Part| {
        let edges = subject.edges.of(subject.scene, part.mesh);
        let text = format!("{} of {} edges have one triangle only: the solid is open", edges.open, edges.all);
        (edges.open > 0).then(|| RULE.at(subject.part(&part.path, None), text))
    };
    subject.scene.parts.iter().filter(|part| is_solid(part)).filter_map(open).collect()
}
