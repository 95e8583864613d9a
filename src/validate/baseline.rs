//! A baseline: the findings that are known, so that only new ones are shown. `--write-baseline FILE` makes one.

use super::{Located, Report};
use crate::base::atomic::write_atomic;
use crate::base::{Fault, Result, Where};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::path::Path;

const VERSION: u32 = 1;

/// The file. Only fingerprints count; the rest is for who reads it.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Baseline {
    version: u32,
    findings: Vec<Known>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Known {
    fingerprint: String,
    #[serde(default)]
    code: String,
    #[serde(default)]
    file: String,
    #[serde(default)]
    text: String,
}

/// The fingerprints in a baseline. Faults: it can't be read, is no baseline, or is of a later version.
pub fn read(path: &Path) -> Result<BTreeSet<String>> {
    let fault = |what: String| Fault::new(Where::file(path), what);
    let text = std::fs::read_to_string(path).map_err(|error| fault(format!("cannot read the baseline: {error}")))?;
    let baseline: Baseline = serde_json::from_str(&text).map_err(|error| {
        fault(format!("not a baseline: {error}")).expected("a file that `eyebox validate --write-baseline FILE` wrote")
    })?;
    if baseline.version != VERSION {
        return Err(fault(format!("a baseline of version {}", baseline.version)).expected(format!("version {VERSION}")));
    }
    Ok(baseline.findings.into_iter().map(|known| known.fingerprint).collect())
}

/// Writes all findings of a report as known, sorted, so that the file changes as little as they do.
pub fn write(path: &Path, report: &Report) -> Result<()> {
    let known = |finding: &Located| Known {
        fingerprint: finding.fingerprint.clone(),
        code: finding.rule.code.to_owned(),
        file: finding.place.file.clone(),
        text: finding.text.clone(),
    };
    let mut findings: Vec<Known> = report.findings.iter().map(known).collect();
    findings
        .sort_by(|a, b| (&a.file, &a.code, &a.text, &a.fingerprint).cmp(&(&b.file, &b.code, &b.text, &b.fingerprint)));
    let mut bytes = serde_json::to_vec_pretty(&Baseline { version: VERSION, findings })
        .map_err(|error| Fault::new(Where::file(path), format!("cannot be written: {error}")))?;
    bytes.push(b'\n');
    write_atomic(path, &bytes)
}
