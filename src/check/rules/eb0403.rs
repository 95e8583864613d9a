//! A slide does not fit its face.

use crate::finding::{Finding, Level};
use crate::geometry;
use crate::rule::{Example, Rule, kept};
use crate::subject::Subject;

pub const RULE: Rule = Rule {
    code: "EB0403",
    name: "slide-off-face",
    level: Level::Warning,
    title: "A slide does not fit its face",
    why: "Outside of the picture the face is opaque, and a picture beyond the face is cut off by the mesh. A picture far smaller or larger than its face usually has its size in another unit.",
    bad: Example::Code("toml", "size = [0.04, 0.02]     # metres, on a face of 40 × 20 mesh units"),
    good: Example::Code("toml", "size = [40, 20]"),
    find,
    grade: kept,
};

/// Share of the face by which the picture may stand out, and below which it is lost on it.
const OVER: f64 = 1.02;
const UNDER: f64 = 0.5;

fn find(subject: &Subject<'_>) -> Vec<Finding> {
    let mut out = Vec::new();
    for part in &subject.scene.parts {
        for (number, face) in part.faces.iter().enumerate() {
            let Some(id) = face.slide else { continue };
            let slide = subject.scene.slide(id);
            let mesh = subject.scene.mesh(part.mesh);
            let Some(extent) = geometry::extent_along(mesh, number, [slide.u, slide.v]) else { continue };
            let share = [0, 1].map(|axis| slide.size[axis] / extent[axis]);
            if share.iter().any(|share| *share > OVER) || share.iter().all(|share| *share < UNDER) {
                let ([w, h], [x, y]) = (slide.size, extent);
                let text = format!("the slide has {w} × {h} mesh units, its face {x:.4} × {y:.4}");
                out.push(RULE.at(subject.part(&part.path, Some(number)), text));
            }
        }
    }
    out
}
