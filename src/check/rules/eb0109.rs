//! Two parts have the same path.

use crate::finding::{Finding, Level};
use crate::rule::{Example, Rule, kept};
use crate::subject::Subject;
use std::collections::BTreeMap;

pub const RULE: Rule = Rule {
    code: "EB0109",
    name: "duplicate-name",
    level: Level::Warning,
    title: "Two parts have the same path",
    why: "A `[[bind]]` by path then means both or neither, and a report that names one means any of them.",
    bad: Example::Words("Two children of the root called LED."),
    good: Example::Words("LED_1 and LED_2."),
    find,
    grade: kept,
};

fn find(subject: &Subject<'_>) -> Vec<Finding> {
    let mut first = BTreeMap::<&str, usize>::new();
    let nodes = subject.assembly.nodes.iter().filter(|node| node.mesh.is_some());
    let mut out = Vec::new();
    for node in nodes {
        let count = first.entry(node.path.as_str()).or_default();
        *count += 1;
        if *count == 2 {
            out.push(RULE.at(node.at.clone(), format!("the path {} is another part's, too", node.path)));
        }
    }
    out
}
