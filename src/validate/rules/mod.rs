//! The registry of all rules: those that look (`check/rules`) and those that trace. A new tracing rule is a file and two
//! lines here.

mod eb0104;
mod eb0105;
mod eb0504;
mod eb0505;

use eyebox_check::Checked;
use eyebox_check::finding::Finding;
use eyebox_check::rule::Rule;
use eyebox_check::rules::RULES;
use eyebox_check::subject::Subject;
use eyebox_scene::{Part, Scene};
use eyebox_world::World;

/// A scene that can be traced.
#[derive(Clone, Copy)]
pub struct Frozen<'a> {
    pub subject: &'a Subject<'a>,
    pub checked: &'a Checked<'a>,
    pub world: &'a World,
}

/// A rule that traces.
pub struct Traced {
    pub rule: &'static Rule,
    pub find: fn(&Frozen<'_>) -> Vec<Finding>,
}

/// By code.
pub const TRACED: &[Traced] = &[
    Traced { rule: &eb0104::RULE, find: eb0104::find },
    Traced { rule: &eb0105::RULE, find: eb0105::find },
    Traced { rule: &eb0504::RULE, find: eb0504::find },
    Traced { rule: &eb0505::RULE, find: eb0505::find },
];

/// Whether a rule that traces could find anything, or a table be refused: bare absorbers do nothing with light, and nothing
/// shines on them.
pub fn concern(scene: &Scene) -> bool {
    let inert = |part: &Part| part.medium.is_none() && !part.faces.iter().any(eb0504::is_optical);
    !scene.lights.is_empty() || scene.sky.is_some() || !scene.parts.iter().all(inert)
}

/// Every rule, by code.
pub fn all() -> impl Iterator<Item = &'static Rule> {
    let mut all: Vec<&'static Rule> = RULES.iter().copied().chain(TRACED.iter().map(|traced| traced.rule)).collect();
    all.sort_by_key(|rule| rule.code);
    all.into_iter()
}

/// The rule with this code or name.
pub fn find(code: &str) -> Option<&'static Rule> {
    all().find(|rule| rule.code.eq_ignore_ascii_case(code) || rule.name == code)
}

/// Codes and names, for messages.
pub fn words() -> Vec<&'static str> {
    all().flat_map(|rule| [rule.code, rule.name]).collect()
}

/// Where the eye is said: in the sidecar, else in the asset's own attributes, else the asset.
fn place_of_eye(subject: &Subject<'_>) -> eyebox_base::Where {
    let said = subject.sheet.and_then(|sheet| sheet.get("eye"));
    let said = said.or_else(|| subject.assembly.optics.as_ref().and_then(|optics| optics.get("eye")));
    said.map_or_else(|| eyebox_base::Where::file(&subject.assembly.file), |eye| eye.at.clone())
}
