//! One JSON document.

use crate::Report;
use eyebox_base::document::document;
use serde_json::json;

pub fn render(report: &Report) -> String {
    let finding = |finding: &crate::Located| {
        json!({
            "code": finding.rule.code,
            "name": finding.rule.name,
            "level": finding.level,
            "text": finding.text,
            "place": finding.place,
            "fingerprint": finding.fingerprint,
        })
    };
    let [errors, warnings, notes] = report.counts();
    let assets: Vec<String> = report.assets.iter().map(|asset| crate::shown(asset)).collect();
    let all = json!({
        "version": 1,
        "assets": assets,
        "layers": report.layers,
        "errors": errors,
        "warnings": warnings,
        "notes": notes,
        "known": report.known,
        "cut": report.cut,
        "findings": report.findings.iter().map(finding).collect::<Vec<_>>(),
    });
    document(all) + "\n"
}
