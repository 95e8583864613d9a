//! A texture of a material is missing.

use crate::finding::{Finding, Level};
use crate::rule::{Example, Rule, kept};
use crate::subject::{Needed, Subject};

pub const RULE: Rule = Rule {
    code: "EB0006",
    name: "texture-missing",
    level: Level::Warning,
    title: "A texture of a material is missing",
    why: "The asset is incomplete: whoever opens it elsewhere sees a hole, and a package of it has one. Where the format has a value that stands for a picture (USD's `fallback`), or nothing that is seen has it, it renders; else it is refused, and this is an error. However many materials name it, it is one finding.",
    bad: Example::Code("json", r#""images": [{ "uri": "housing_basecolor.png" }]   // not delivered"#),
    good: Example::Words("The picture beside the asset, or no reference to it."),
    find,
    grade: kept,
};

fn find(subject: &Subject<'_>) -> Vec<Finding> {
    let refused = |needed: &Needed| subject.refusals.iter().any(|refusal| refusal.lacks(needed));
    let missing = subject.needed.iter().filter(|needed| !needed.there && (!needed.used || refused(needed)));
    missing
        .map(|needed| {
            let level = if refused(needed) { Level::Error } else { RULE.level };
            // Of a sidecar, the role is the attribute that names it.
            let role = if needed.role == "texture" { String::new() } else { format!(" ({})", needed.role) };
            Finding { level, ..RULE.at(needed.at.clone(), format!("the texture {}{role} is not there", name(needed))) }
        })
        .collect()
}

/// The file without its folders, which differ from machine to machine.
fn name(needed: &Needed) -> String {
    needed
        .file
        .file_name()
        .map_or_else(|| needed.file.display().to_string(), |name| name.to_string_lossy().into_owned())
}
