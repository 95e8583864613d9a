//! A baseline: the findings that are known, so that only new ones are shown. `--write-baseline FILE` makes one.

use super::{Located, Report, fingerprint};
use eyebox_base::atomic::write_atomic;
use eyebox_base::relative_path::folder_of;
use eyebox_base::{Error, Result, Where};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Files were named from the working directory in version 1: from another one nothing was known.
const VERSION: u32 = 2;

/// The file. Only fingerprints count; the rest is for who reads it.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Baseline {
    version: u32,
    findings: Vec<Entry>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    fingerprint: String,
    #[serde(default)]
    code: String,
    #[serde(default)]
    file: String,
    #[serde(default)]
    text: String,
}

/// What a baseline knows.
#[derive(Debug, Clone, Default)]
pub struct Known {
    /// Where it stands: its files are named from here.
    folder: PathBuf,
    fingerprints: BTreeSet<String>,
}

impl Known {
    /// Which of these findings are new.
    pub fn unknown(&self, all: &[Located]) -> Vec<bool> {
        if self.fingerprints.is_empty() {
            return vec![true; all.len()];
        }
        let seen = fingerprint::seen_from(&self.folder, all);
        seen.iter().map(|fingerprint| !self.fingerprints.contains(fingerprint)).collect()
    }
}

/// Reads a baseline. Faults: it can't be read, is no baseline, or is of a later version.
pub fn read(path: &Path) -> Result<Known> {
    let fault = |what: String| Error::new(Where::file(path), what);
    let text = std::fs::read_to_string(path).map_err(|error| fault(format!("cannot read the baseline: {error}")))?;
    let baseline: Baseline = serde_json::from_str(&text).map_err(|error| {
        fault(format!("not a baseline: {error}")).expected("a file that `eyebox validate --write-baseline FILE` wrote")
    })?;
    if baseline.version != VERSION {
        return Err(fault(format!("a baseline of version {}", baseline.version))
            .expected(format!("version {VERSION}, as `--write-baseline` writes it")));
    }
    let fingerprints = baseline.findings.into_iter().map(|entry| entry.fingerprint).collect();
    Ok(Known { folder: folder_of(path), fingerprints })
}

/// Writes all findings of a report as known, sorted, so that the file changes as little as they do.
pub fn write(path: &Path, report: &Report) -> Result<()> {
    let folder = folder_of(path);
    let entry = |(finding, fingerprint): (&Located, String)| Entry {
        fingerprint,
        code: finding.rule.code.to_owned(),
        file: fingerprint::file_from(&folder, finding),
        text: finding.lasting.clone(),
    };
    let seen = fingerprint::seen_from(&folder, &report.findings);
    let mut findings: Vec<Entry> = report.findings.iter().zip(seen).map(entry).collect();
    findings
        .sort_by(|a, b| (&a.file, &a.code, &a.text, &a.fingerprint).cmp(&(&b.file, &b.code, &b.text, &b.fingerprint)));
    let mut bytes = serde_json::to_vec_pretty(&Baseline { version: VERSION, findings })
        .map_err(|error| Error::new(Where::file(path), format!("cannot be written: {error}")))?;
    bytes.push(b'\n');
    write_atomic(path, &bytes)
}
