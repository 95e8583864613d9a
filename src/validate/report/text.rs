//! For people: `file:line:column: error[EB0102]: …`.

use super::summary;
use crate::Report;
use anstyle::AnsiColor;
use eyebox_check::finding::Level;

pub fn render(report: &Report) -> String {
    let mut out = String::new();
    for finding in &report.findings {
        let colour = match finding.level {
            Level::Error => AnsiColor::Red,
            Level::Warning => AnsiColor::Yellow,
            Level::Note => AnsiColor::Cyan,
        };
        let style = colour.on_default().bold();
        let (place, level, code) = (finding.place.text(), finding.level, finding.rule.code);
        out += &format!("{place}: {style}{level}[{code}]{style:#}: {}\n", finding.text);
    }
    out + &summary(report) + "\n"
}
