//! A slide's pixels are not square.

use crate::finding::{Finding, Level};
use crate::rule::{Example, Rule, kept};
use crate::subject::Subject;

pub const RULE: Rule = Rule {
    code: "EB0404",
    name: "slide-stretched",
    level: Level::Note,
    title: "A slide's pixels are not square",
    why: "Width over height of the picture in pixels and in millimetres differ: the picture is stretched, by intent or by a mistyped size.",
    bad: Example::Code("toml", "size = [40, 20]     # of a picture of 1024 × 1024 pixels"),
    good: Example::Code("toml", "size = [20, 20]"),
    find,
    grade: kept,
};

/// Sides of a pixel may differ by this share.
const SHARE: f64 = 0.02;

fn find(subject: &Subject<'_>) -> Vec<Finding> {
    let mut out = Vec::new();
    for part in &subject.scene.parts {
        for (number, face) in part.faces.iter().enumerate() {
            let Some(id) = face.slide else { continue };
            let slide = subject.scene.slide(id);
            let side = |axis: usize, pixels: usize| slide.size[axis] / pixels.max(1) as f64;
            let (w, h) = (side(0, slide.width), side(1, slide.height));
            if (w - h).abs() > SHARE * w.max(h) {
                let text = format!("its pixels have {w:.4e} × {h:.4e} mesh units");
                out.push(RULE.at(subject.part(&part.path, Some(number)), text));
            }
        }
    }
    out
}
