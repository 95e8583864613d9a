//! What `eyebox validate` finds, from a program of one's own:
//! `cargo run --release --ignore-rust-version --example validate_and_print FILE`.

use eyebox::prelude::*;

/// One line a finding: level, code, place, text.
pub fn lines(asset: &str) -> Vec<String> {
    let line = |finding: &Finding| format!("{:?} {} {}: {}", finding.level, finding.code, finding.at, finding.text);
    findings(asset).iter().map(line).collect()
}

#[allow(dead_code)] // tests run `lines`
fn main() {
    let sample = concat!(env!("CARGO_MANIFEST_DIR"), "/samples/hud-direct/hud.optics.toml").to_owned();
    let asset = std::env::args().nth(1).unwrap_or(sample);
    let found = lines(&asset);
    found.iter().for_each(|line| println!("{line}"));
    println!("{} findings in {asset}", found.len());
}
