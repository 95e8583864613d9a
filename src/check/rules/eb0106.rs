//! Facets of a curved specular face are too coarse.

use crate::facets::{self, EYE_ARCMIN};
use crate::finding::{Finding, Level};
use crate::rule::{Example, Rule, kept};
use crate::subject::Subject;

pub const RULE: Rule = Rule {
    code: "EB0106",
    name: "facets-too-coarse",
    level: Level::Warning,
    title: "Facets of a curved specular face are too coarse",
    why: "A mesh is traced with normals that are interpolated between its vertices, while the rays meet flat triangles. Three things go wrong: the flat facet lies beside the true surface (a mirrored ray turns by θ²/4 where the normals of its corners differ by θ), facets without normals of the surface step from one to the next (by the step), and vertex normals that are not those of the surface, or turn unevenly, turn light with them (twice the angle (b − a)·(m + n)/2h between an edge of length h and the mean of the normals at its ends, which on a smooth surface is h²κ′/12). The finding foretells the direction error and blur in arc minutes, the root mean square over the face; at its worst place it is some two times as much. An eye resolves one: above that the finding is a warning, and `render` and `scan` say it too; from a tenth of that on it is a note.",
    bad: Example::Words("A mirror of 200 mm radius in 16 facets, without a `shape`."),
    good: Example::Code(
        "toml",
        r#"[[bind]]
path = "MIRROR"
faces = [0]
shape = { kind = "fit", tolerance_um = 0.1 }"#,
    ),
    find,
    grade: kept,
};

/// Share of what the eye resolves from which a note says what facets do: what is measured on a display is as fine.
const NOTED: f64 = 0.1;

fn find(subject: &Subject<'_>) -> Vec<Finding> {
    // Where something was faulty, it may have been the shape.
    if !subject.whole {
        return Vec::new();
    }
    let worth = |arcmin: f64| arcmin > NOTED * EYE_ARCMIN;
    let found = facets::all(subject.scene).filter(|(_, _, facets)| worth(facets.arcmin()));
    found
        .filter_map(|(part, face, facets)| {
            let part = subject.scene.parts.get(part)?;
            let found = RULE.at(subject.part(&part.path, Some(face)), facets.text());
            let level = if facets.arcmin() > EYE_ARCMIN { found.level } else { Level::Note };
            Some(Finding { level, ..found })
        })
        .collect()
}
