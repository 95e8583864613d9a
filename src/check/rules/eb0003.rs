//! The asset requires an extension that eyebox does not know.

use crate::finding::Level;
use crate::rule::{Example, Rule, kept, nothing};

pub const RULE: Rule = Rule {
    code: "EB0003",
    name: "required-extension-unknown",
    level: Level::Error,
    title: "The asset requires an extension that eyebox does not know",
    why: "`extensionsRequired` says that the asset means something else to who leaves the extension out.",
    bad: Example::Code("json", r#""extensionsRequired": ["ACME_curved_space"]"#),
    good: Example::Code("json", r#""extensionsUsed": ["ACME_curved_space"]"#),
    find: nothing,
    grade: kept,
};
