//! What makes a finding the same one in a later version of the asset: its rule, its file, the thing in the file, and what
//! is said of it; not its line, which moves with every line above it.

use super::Located;
use crate::base::relative_path::{relative, slashed};
use std::collections::HashMap;
use std::path::Path;

/// Stamps all findings about one asset.
pub fn stamp(all: &mut [Located]) {
    let stamps = stamps(all, |finding| finding.place.file.clone());
    for (finding, stamp) in all.iter_mut().zip(stamps) {
        finding.fingerprint = stamp;
    }
}

/// The fingerprints of these findings if files are named as seen from `folder`: the same from any working directory.
pub fn seen_from(folder: &Path, all: &[Located]) -> Vec<String> {
    stamps(all, |finding| file_from(folder, finding))
}

/// The file of a finding as seen from `folder`.
pub fn file_from(folder: &Path, finding: &Located) -> String {
    slashed(&relative(folder, Path::new(&finding.place.file)))
}

/// Equal findings are told apart by their order.
fn stamps(all: &[Located], file_of: impl Fn(&Located) -> String) -> Vec<String> {
    let mut counts = HashMap::<String, usize>::new();
    let stamp = |finding: &Located| {
        let (place, file) = (&finding.place, file_of(finding));
        let mut key = String::new();
        for piece in [
            finding.rule.code,
            &file,
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
        blake3::hash(key.as_bytes()).to_hex().chars().take(32).collect()
    };
    all.iter().map(stamp).collect()
}
