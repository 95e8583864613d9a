//! A texture of a material is missing.

use crate::finding::{Finding, Level};
use crate::rule::{Example, Rule, kept};
use crate::subject::Subject;

pub const RULE: Rule = Rule {
    code: "EB0006",
    name: "texture-missing",
    level: Level::Warning,
    title: "A texture of a material is missing",
    why: "Textures change no ray, so it renders. But the asset is incomplete: whoever opens it elsewhere sees a hole, and a package of it has one.",
    bad: Example::Code("json", r#""images": [{ "uri": "housing_basecolor.png" }]   // not delivered"#),
    good: Example::Words("The picture beside the asset, or no reference to it."),
    find,
    grade: kept,
};

fn find(subject: &Subject<'_>) -> Vec<Finding> {
    let missing = subject.needed.iter().filter(|needed| !needed.there && !needed.used);
    missing
        .map(|needed| RULE.at(needed.at.clone(), format!("the {} {} is not there", needed.role, name(needed))))
        .collect()
}

/// The file without its folders, which differ from machine to machine.
fn name(needed: &crate::subject::Needed) -> String {
    needed
        .file
        .file_name()
        .map_or_else(|| needed.file.display().to_string(), |name| name.to_string_lossy().into_owned())
}
