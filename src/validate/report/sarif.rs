//! SARIF 2.1.0 (OASIS Standard, 27 March 2020), with what GitHub's code scanning asks of it: relative addresses, a
//! line for every finding, fingerprints, help with every rule.

use crate::locate::Place;
use crate::{Located, Report, page, rules};
use eyebox_check::rule::Rule;
use serde_json::{Value, json};

/// Where the rules' pages are to be read; whoever publishes them sets it when building. Without it no address is given:
/// `informationUri` (§3.19.7) and `helpUri` (§3.49.12) are optional, and every rule carries its whole page as `help`.
const DOCS: Option<&str> = option_env!("EYEBOX_DOCS_URL");
const SCHEMA: &str = "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json";
/// The folder that addresses are relative to.
const ROOT: &str = "SRCROOT";

pub fn render(report: &Report) -> String {
    let all: Vec<&Rule> = rules::all().collect();
    let result = |finding: &Located| result(finding, &all);
    let mut log = json!({
        "$schema": SCHEMA,
        "version": "2.1.0",
        "runs": [{
            "tool": { "driver": {
                "name": "eyebox",
                "version": env!("CARGO_PKG_VERSION"),
                "semanticVersion": env!("CARGO_PKG_VERSION"),
                "rules": all.iter().map(|rule| descriptor(rule)).collect::<Vec<_>>(),
            }},
            "automationDetails": { "id": "eyebox-validate/" },
            "columnKind": "unicodeCodePoints",
            "originalUriBaseIds": { ROOT: { "description": { "text": "the working directory of eyebox" } } },
            "results": report.findings.iter().map(result).collect::<Vec<_>>(),
        }],
    });
    if let Some(docs) = DOCS {
        log["runs"][0]["tool"]["driver"]["informationUri"] = docs.into();
    }
    // Texts and numbers always serialize.
    serde_json::to_string_pretty(&log).unwrap_or_default() + "\n"
}

fn descriptor(rule: &Rule) -> Value {
    let page = page::page(rule);
    let mut out = json!({
        "id": rule.code,
        "name": pascal(rule.name),
        "shortDescription": { "text": format!("{}.", rule.title) },
        "fullDescription": { "text": rule.why },
        "help": { "text": page, "markdown": page },
        "defaultConfiguration": { "level": rule.level.name() },
        "properties": { "tags": ["optics"], "precision": "high", "problem.severity": severity(rule) },
    });
    if let Some(docs) = DOCS {
        out["helpUri"] = format!("{docs}/rules/{}.md", rule.code).into();
    }
    out
}

/// GitHub's words.
fn severity(rule: &Rule) -> &'static str {
    match rule.level {
        eyebox_check::finding::Level::Error => "error",
        eyebox_check::finding::Level::Warning => "warning",
        eyebox_check::finding::Level::Note => "recommendation",
    }
}

fn result(finding: &Located, all: &[&Rule]) -> Value {
    let mut result = json!({
        "ruleId": finding.rule.code,
        "ruleIndex": all.iter().position(|rule| rule.code == finding.rule.code),
        "level": finding.level.name(),
        "message": { "text": finding.text },
        "locations": [location(&finding.place)],
        "partialFingerprints": { "eyeboxFinding/v1": finding.fingerprint },
    });
    if let Some(offset) = finding.place.byte_offset {
        result["properties"] = json!({ "byteOffset": offset });
    }
    result
}

fn location(place: &Place) -> Value {
    let mut physical = json!({ "artifactLocation": { "uri": address(&place.file), "uriBaseId": ROOT } });
    // GitHub shows no finding without a line (GH1003 of Sarif.Multitool): what has none stands at the first.
    physical["region"] = json!({ "startLine": place.line.unwrap_or(1), "startColumn": place.column.unwrap_or(1) });
    let mut location = json!({ "physicalLocation": physical });
    let named = [(place.part.as_ref(), "element"), (place.logical.as_ref(), "object")];
    let logical: Vec<Value> = named
        .into_iter()
        .filter_map(|(name, kind)| Some(json!({ "fullyQualifiedName": name?, "kind": kind })))
        .collect();
    if !logical.is_empty() {
        location["logicalLocations"] = logical.into();
    }
    location
}

/// A file name as a relative reference (RFC 3986): every byte but those of paths escaped.
fn address(file: &str) -> String {
    let mut out = String::new();
    for byte in file.bytes() {
        if byte.is_ascii_alphanumeric() || b"-._~/".contains(&byte) {
            out.push(char::from(byte));
        } else {
            out += &format!("%{byte:02X}");
        }
    }
    // What is outside of the working directory is an address of its own.
    if file.starts_with('/') { format!("file://{out}") } else { out }
}

/// `solid-open` → `SolidOpen`.
fn pascal(name: &str) -> String {
    name.split('-')
        .flat_map(|word| {
            let mut letters = word.chars();
            letters.next().map(|first| first.to_ascii_uppercase()).into_iter().chain(letters)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_and_names() {
        assert_eq!(address("a b/µ%.glb"), "a%20b/%C2%B5%25.glb");
        assert_eq!(address("/tmp/a.glb"), "file:///tmp/a.glb");
        assert_eq!(pascal("solid-open"), "SolidOpen");
    }
}
