//! The asset has a suspicious size.

use crate::finding::{Finding, Level};
use crate::geometry::extent_m;
use crate::rule::{Example, Rule, kept};
use crate::subject::Subject;
use eyebox_base::Where;

pub const RULE: Rule = Rule {
    code: "EB0101",
    name: "scale-suspicious",
    level: Level::Warning,
    title: "The asset has a suspicious size",
    why: "glTF says metres and CAD kernels write millimetres all the same. A head-up display of 300 m has the right picture but its pupil is a millionth of the area it should be, so almost all light is lost.",
    bad: Example::Code("toml", r#"asset = "hud.glb"                 # 320 units wide, and a unit is 1 m"#),
    good: Example::Code(
        "toml",
        r#"asset = "hud.glb"
unit = 0.001                      # the export is in millimetres"#,
    ),
    find,
    grade: kept,
};

/// Smaller than any display with its optics: taken for metres twice divided by a thousand.
const TINY_M: f64 = 1e-3;

fn find(subject: &Subject<'_>) -> Vec<Finding> {
    let extent = extent_m(subject.scene);
    // A unit that a stage says for itself is no guess of ours.
    if subject.assembly.says_unit() || !(extent > 0.0 && extent < TINY_M) {
        return Vec::new();
    }
    let text = format!("largest extent {:.3} mm: the unit of {} m is too small", extent * 1e3, subject.scene.unit_m);
    vec![RULE.at(Where::file(&subject.assembly.file), text)]
}
