//! A validation rule: what it looks for, why that matters, and how it finds it.
//!
//! Some faults are found by the importer, which must not go on with them. A rule claims those by fragments of their
//! message (`claims`); `tests/validate/` plants every fault into a good asset, so that a message and the fragments that
//! claim it cannot drift apart unnoticed. The others are looked for by `find`.

use super::finding::{Finding, Level};
use super::subject::Subject;
use crate::base::Where;

/// A rule of the registry. See [`RULES`](super::rules::RULES).
#[derive(Debug)]
pub struct Rule {
    /// Stable: `EB` and four digits. A code is never used again for something else.
    pub code: &'static str,
    /// Stable, in words: `solid-open`.
    pub name: &'static str,
    pub level: Level,
    /// One line.
    pub title: &'static str,
    /// Why it matters, in whole sentences.
    pub why: &'static str,
    /// What sets it off, and the same put right.
    pub bad: Example,
    pub good: Example,
    /// Fragments of faults and notes of the importer that are this rule's. `…` stands for any text between two
    /// fragments. Of several rules that claim a message, the one whose matching claim is longest has it.
    pub claims: &'static [&'static str],
    pub find: fn(&Subject<'_>) -> Vec<Finding>,
    /// How grave a finding that was claimed is, where that hangs on the scene.
    pub grade: fn(&Subject<'_>, &Finding) -> Level,
}

/// A piece of an asset.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Example {
    /// A sidecar, or an IES file, or any other text, with the name of its language for the page.
    Code(&'static str, &'static str),
    /// In words, where the fault is in geometry.
    Words(&'static str),
}

/// For rules that have nothing to look for themselves.
pub fn nothing(_: &Subject<'_>) -> Vec<Finding> {
    Vec::new()
}

/// The level of the rule.
pub fn kept(_: &Subject<'_>, finding: &Finding) -> Level {
    finding.level
}

impl Rule {
    /// A finding of this rule.
    pub fn at(&self, at: Where, text: impl Into<String>) -> Finding {
        Finding { code: self.code, level: self.level, at, text: text.into() }
    }

    /// Length of the longest claim of this rule to a message; none if it has no claim.
    pub fn claim(&self, message: &str) -> Option<usize> {
        self.claims.iter().filter(|claim| matches(claim, message)).map(|claim| claim.len()).max()
    }
}

/// Whether the fragments of `claim` occur in `message` one after the other.
fn matches(claim: &str, message: &str) -> bool {
    let mut rest = message;
    claim.split('…').all(|fragment| match rest.split_once(fragment) {
        Some((_, after)) => {
            rest = after;
            true
        }
        None => false,
    })
}

#[cfg(test)]
mod tests {
    use super::matches;

    #[test]
    fn claims_are_fragments_in_order() {
        assert!(matches("path `…` matches no part", "path `LENZ` matches no part"));
        assert!(!matches("matches no part…path", "path `LENZ` matches no part"));
        assert!(!matches("two…two", "only two"));
    }
}
