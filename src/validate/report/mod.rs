//! Reports: one file per format.

mod github;
mod json;
mod junit;
mod sarif;
mod text;

use super::Report;

/// How a report is printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum Style {
    /// One line a finding, as compilers write them.
    #[default]
    Text,
    /// One JSON document.
    Json,
    /// SARIF 2.1.0, for code scanning.
    Sarif,
    /// JUnit XML, for CI servers.
    Junit,
    /// Workflow commands of GitHub Actions: annotations in the diff.
    Github,
}

/// The report as text; only that for terminals has colours, which the caller strips where they are not wanted.
pub fn render(report: &Report, style: Style) -> String {
    match style {
        Style::Text => text::render(report),
        Style::Json => json::render(report),
        Style::Sarif => sarif::render(report),
        Style::Junit => junit::render(report),
        Style::Github => github::render(report),
    }
}

/// `2 errors`, `1 error`.
fn plural(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

/// Counts in one line: `1 error, 2 warnings, 0 notes in 3 assets; 4 in the baseline`.
pub fn summary(report: &Report) -> String {
    let [errors, warnings, notes] = report.counts();
    let mut out = format!(
        "{}, {}, {} in {}",
        plural(errors, "error"),
        plural(warnings, "warning"),
        plural(notes, "note"),
        plural(report.assets.len(), "asset")
    );
    match report.layers {
        0 => {}
        1 => out += "; 1 file skipped: a layer of another",
        more => out += &format!("; {more} files skipped: layers of others"),
    }
    if report.known > 0 {
        out += &format!("; {} in the baseline", report.known);
    }
    if report.cut > 0 {
        out += &format!("; {} more not shown", report.cut);
    }
    out
}
