//! A solid is inside out.

use crate::finding::{Finding, Level};
use crate::geometry;
use crate::rule::{Example, Rule, kept};
use crate::subject::{Subject, is_solid};
use eyebox_base::Where;
use eyebox_scene::{Note, Part, Scene};
use std::collections::HashMap;

pub const RULE: Rule = Rule {
    code: "EB0103",
    name: "solid-inverted",
    level: Level::Error,
    title: "A solid is inside out",
    why: "The winding of its triangles says which side is the inside. Turned round, air is glass and glass is air: a positive lens becomes a negative one.",
    bad: Example::Words("A mirrored copy (scale −1) whose triangles were not turned back by the exporter."),
    good: Example::Words("Triangles counter-clockwise as seen from outside."),
    find,
    grade: kept,
};

fn find(subject: &Subject<'_>) -> Vec<Finding> {
    let all = inverted(subject.scene).into_iter();
    all.map(|(part, text)| RULE.at(subject.part(&part.path, None), text)).collect()
}

/// Each solid that is inside out, with what is to be said of it.
fn inverted(scene: &Scene) -> Vec<(&Part, String)> {
    // Once per mesh: many parts may share one.
    let mut known = HashMap::new();
    let mut turned = |part: &Part| {
        let mesh = scene.mesh(part.mesh);
        // Of an open or crossed solid the sign says nothing.
        let (edges, volume) =
            *known.entry(part.mesh.index()).or_insert_with(|| (geometry::edges(mesh), geometry::volume(mesh)));
        let text = format!("its triangles enclose {volume:.3e} cubic mesh units: they look inwards");
        (edges.open == 0 && volume < 0.0).then_some(text)
    };
    let solids = scene.parts.iter().filter(|part| is_solid(part));
    solids.filter_map(|part| Some((part, turned(part)?))).collect()
}

/// A warning for each solid that is inside out: in its picture air is glass and glass is air.
pub fn warnings(scene: &Scene) -> Vec<Note> {
    let note = |(part, text): (&Part, String)| {
        let at = Where::Part { path: part.path.clone(), face: None };
        Note::warning(at, format!("{text}, so that glass is air and air is glass"))
    };
    inverted(scene).into_iter().map(note).collect()
}
