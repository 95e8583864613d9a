//! Nothing emits.

use crate::finding::{Finding, Level};
use crate::rule::{Example, Rule, kept};
use crate::subject::Subject;
use eyebox_base::Where;

pub const RULE: Rule = Rule {
    code: "EB0307",
    name: "no-light",
    level: Level::Warning,
    title: "Nothing emits",
    why: "The picture is black.",
    bad: Example::Code("toml", "# no emitter, no [sky], no [sun]"),
    good: Example::Code("toml", r#"emitter = { group = "led", flux_lm = 0.45 }"#),
    find,
    grade: kept,
};

fn find(subject: &Subject<'_>) -> Vec<Finding> {
    let scene = subject.scene;
    let lit = scene.sky.is_some() || !scene.lights.is_empty();
    let shines = scene.parts.iter().flat_map(|part| &part.faces).any(|face| face.emitter.is_some());
    // What was faulty may have been the lamp.
    if lit || shines || !subject.whole {
        return Vec::new();
    }
    vec![RULE.at(Where::file(&subject.assembly.file), "nothing emits: the picture is black")]
}
