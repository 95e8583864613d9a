//! What makes a finding the same one in a later version of the asset: its rule, its file, the thing in the file, and what
//! is said of it; not its line, which moves with every line above it.

use super::Located;
use std::collections::HashMap;

/// Stamps all findings about one asset. Equal ones are told apart by their order.
pub fn stamp(all: &mut [Located]) {
    let mut counts = HashMap::<String, usize>::new();
    for finding in all {
        let place = &finding.place;
        let mut key = String::new();
        for piece in [
            finding.rule.code,
            &place.file,
            place.part.as_deref().unwrap_or_default(),
            place.logical.as_deref().unwrap_or_default(),
            &finding.text,
        ] {
            // Lengths, so that pieces can't run into each other.
            key += &format!("{}:{piece};", piece.len());
        }
        let count = counts.entry(key.clone()).or_default();
        key += &count.to_string();
        *count += 1;
        // 16 bytes are more than enough to tell some thousands apart.
        finding.fingerprint = blake3::hash(key.as_bytes()).to_hex().chars().take(32).collect();
    }
}
