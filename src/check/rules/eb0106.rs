//! Facets of a curved specular face are too coarse.

use crate::check::finding::{Finding, Level};
use crate::check::geometry;
use crate::check::rule::{Example, Rule, kept};
use crate::check::subject::{Subject, is_mesh, is_specular};

pub const RULE: Rule = Rule {
    code: "EB0106",
    name: "facets-too-coarse",
    level: Level::Warning,
    title: "Facets of a curved specular face are too coarse",
    why: "A mesh is traced with normals that are interpolated between its vertices, while the rays meet flat triangles. The flat triangle lies beside the true surface by up to the sag of its longest edge, so neighbouring facets bend light to slightly different places. The finding predicts that blur in arc minutes; an eye resolves one.",
    bad: Example::Words("A mirror of 200 mm radius in 16 facets, without a `shape`."),
    good: Example::Code(
        "toml",
        r#"[[bind]]
path = "MIRROR"
faces = [0]
shape = { kind = "fit", tolerance_um = 0.1 }"#,
    ),
    claims: &[],
    find,
    grade: kept,
};

/// What a normal eye resolves, arc minutes.
const EYE_ARCMIN: f64 = 1.0;

fn find(subject: &Subject<'_>) -> Vec<Finding> {
    let mut out = Vec::new();
    // Where something was faulty, it may have been the shape.
    let parts = if subject.whole { &subject.scene.parts[..] } else { &[] };
    for part in parts {
        let mesh = subject.scene.mesh(part.mesh);
        for (number, (face, range)) in part.faces.iter().zip(&mesh.faces).enumerate() {
            if !(is_mesh(face) && is_specular(face)) {
                continue;
            }
            let blur = geometry::facet_blur_arcmin(mesh, *range);
            if blur > EYE_ARCMIN {
                let text = format!("its facets blur by about {blur:.1} arcmin; the eye resolves {EYE_ARCMIN:.0}");
                out.push(RULE.at(subject.part(&part.path, Some(number)), text));
            }
        }
    }
    out
}
