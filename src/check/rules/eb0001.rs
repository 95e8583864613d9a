//! The asset cannot be read.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0001",
    name: "asset-unreadable",
    level: Level::Error,
    title: "The asset cannot be read",
    why: "Nothing of it can be traced. The finding names the place where reading stopped: a JSON pointer, a prim or a byte.",
    bad: Example::Words(
        "A .glb that was cut off while it was uploaded; a .gltf whose accessor reaches past its buffer.",
    ),
    good: Example::Words("The file as the exporter wrote it."),
    find: nothing,
    grade: kept,
};
