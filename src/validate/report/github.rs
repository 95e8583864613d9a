//! Workflow commands of GitHub Actions (`::error file=…,line=…,col=…,title=…::…`), one a finding.

use super::summary;
use crate::Report;
use eyebox_check::finding::Level;

pub fn render(report: &Report) -> String {
    let mut out = String::new();
    for finding in &report.findings {
        let command = match finding.level {
            Level::Error => "error",
            Level::Warning => "warning",
            Level::Note => "notice",
        };
        let place = &finding.place;
        let mut properties = format!("file={}", property(&place.file));
        if let Some(line) = place.line {
            properties += &format!(",line={line}");
        }
        if let Some(column) = place.column {
            properties += &format!(",col={column}");
        }
        properties += &format!(",title={}", property(&format!("{} {}", finding.rule.code, finding.rule.name)));
        // An annotation shows the file and line alone.
        let what = place.part.as_ref().or(place.logical.as_ref().filter(|_| place.line.is_none()));
        let text = what.map_or_else(|| finding.text.clone(), |what| format!("{what}: {}", finding.text));
        out += &format!("::{command} {properties}::{}\n", message(&text));
    }
    out + &summary(report) + "\n"
}

/// What a message may not have.
fn message(text: &str) -> String {
    text.replace('%', "%25").replace('\r', "%0D").replace('\n', "%0A")
}

/// What a property may not have.
fn property(text: &str) -> String {
    message(text).replace(':', "%3A").replace(',', "%2C")
}

#[cfg(test)]
mod tests {
    #[test]
    fn nothing_breaks_out() {
        assert_eq!(super::property("a,b:c%\n::"), "a%2Cb%3Ac%25%0A%3A%3A");
        assert_eq!(super::message("100 %\n::error::x"), "100 %25%0A::error::x");
    }
}
