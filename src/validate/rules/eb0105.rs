//! Two polished faces coincide and none has priority.

use super::Frozen;
use eyebox_check::finding::{Finding, Level};
use eyebox_check::rule::{Example, Rule, kept, nothing};
use std::collections::BTreeSet;

pub const RULE: Rule = Rule {
    code: "EB0105",
    name: "solids-coincident",
    level: Level::Warning,
    title: "Polished faces of two solids coincide and none has priority",
    why: "Cemented elements share a face. It is one interface, with the coating of the solid that has the higher `priority`; without one the order of the parts in the file decides which coating that is.",
    bad: Example::Words("A doublet whose elements have different coatings on the cemented face and no priority."),
    good: Example::Code(
        "toml",
        "[[bind]]\npath = \"LENS_03\"\npriority = 1          # its coating holds at the cement",
    ),
    find: nothing,
    grade: kept,
};

pub fn find(frozen: &Frozen<'_>) -> Vec<Finding> {
    let scene = frozen.subject.scene;
    let mut seen = BTreeSet::new();
    let mut out = Vec::new();
    for ([part, face], [other, its]) in frozen.world.contacts.touching() {
        let pair = [[part, face].min([other, its]), [part, face].max([other, its])];
        let (Some(first), Some(second)) = (scene.parts.get(pair[0][0]), scene.parts.get(pair[1][0])) else { continue };
        if first.priority != second.priority || !seen.insert(pair) {
            continue;
        }
        let (Some(one), Some(two)) = (first.faces.get(pair[0][1]), second.faces.get(pair[1][1])) else { continue };
        // Bare glass on bare glass is the same whoever comes first.
        if one.coating == two.coating {
            continue;
        }
        let text = format!(
            "coincides with {} face {}, whose coating is another; both have priority {}",
            second.path, pair[1][1], first.priority
        );
        out.push(RULE.at(frozen.subject.part(&first.path, Some(pair[0][1])), text));
    }
    out
}
