//! A face has triangles without area.

use crate::finding::{Finding, Level};
use crate::geometry;
use crate::rule::{Example, Rule, kept};
use crate::subject::Subject;
use eyebox_base::weld::rounding;
use std::collections::BTreeSet;

pub const RULE: Rule = Rule {
    code: "EB0110",
    name: "triangles-without-area",
    level: Level::Note,
    title: "A face has triangles without area",
    why: "They are passed over. One in a hundred and more are a sign of a tessellation that went wrong; at the pole of a revolved face there is one.",
    bad: Example::Words("A triangle that names the same vertex twice."),
    good: Example::Words("Triangles with three corners."),
    find,
    grade: kept,
};

/// One triangle in so many is worth a note.
const FEW: usize = 100;

fn find(subject: &Subject<'_>) -> Vec<Finding> {
    let mut seen = BTreeSet::new();
    let mut out = Vec::new();
    for part in subject.scene.parts.iter().filter(|part| seen.insert(part.mesh.index())) {
        let mesh = subject.scene.mesh(part.mesh);
        let grain = rounding(&mesh.positions);
        for (number, range) in mesh.faces.iter().enumerate() {
            let (flat, all) = geometry::without_area(mesh, *range, grain);
            // The pole of a revolved face has one; a face that is nothing else is a matter of what it is for.
            if flat > 0 && flat < all && FEW * flat >= all {
                let text = format!("{flat} of {all} triangles have no area");
                out.push(RULE.at(subject.part(&part.path, Some(number)), text));
            }
        }
    }
    out
}
