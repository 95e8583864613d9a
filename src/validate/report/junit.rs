//! JUnit XML: a suite per asset, a failed case per error or warning, a passed one per note; an asset without findings is
//! one passed case.

use crate::{Located, Report, shown};
use eyebox_check::finding::Level;

pub fn render(report: &Report) -> String {
    let mut suites = String::new();
    let (mut tests, mut failures) = (0, 0);
    for (index, asset) in report.assets.iter().enumerate() {
        let name = attribute(&shown(asset));
        let own: Vec<&Located> = report.findings.iter().filter(|finding| finding.asset == index).collect();
        let failed = own.iter().filter(|finding| finding.level != Level::Note).count();
        let count = own.len().max(1);
        tests += count;
        failures += failed;
        suites += &format!(
            "  <testsuite name=\"{name}\" tests=\"{count}\" failures=\"{failed}\" errors=\"0\" skipped=\"0\" time=\"0\">\n"
        );
        if own.is_empty() {
            suites += &format!("    <testcase name=\"validate\" classname=\"{name}\" time=\"0\"/>\n");
        }
        for finding in own {
            suites += &case(finding, &name);
        }
        suites += "  </testsuite>\n";
    }
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"eyebox validate\" tests=\"{tests}\" failures=\"{failures}\" errors=\"0\" time=\"0\">\n{suites}</testsuites>\n"
    )
}

fn case(finding: &Located, class: &str) -> String {
    let (code, name) = (finding.rule.code, finding.rule.name);
    let place = finding.place.text();
    let head = format!("    <testcase name=\"{code} {name} {}\" classname=\"{class}\" time=\"0\"", attribute(&place));
    let text = attribute(&finding.text);
    let level = finding.level;
    let inside = match level {
        Level::Error | Level::Warning => {
            format!(
                "<failure message=\"{text}\" type=\"{level}\">{}: {level}[{code}]: {text}</failure>",
                attribute(&place)
            )
        }
        Level::Note => format!("<system-out>{}: {level}[{code}]: {text}</system-out>", attribute(&place)),
    };
    format!("{head}>\n      {inside}\n    </testcase>\n")
}

/// Text that may stand in an attribute or an element. What XML 1.0 has no way to write becomes U+FFFD.
fn attribute(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            '\t' | '\n' | '\r' => out += " ",
            '\u{0}'..='\u{1f}' | '\u{fffe}' | '\u{ffff}' => out.push('\u{fffd}'),
            _ => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    #[test]
    fn nothing_breaks_out() {
        assert_eq!(super::attribute("a<b>&\"c\"\n\u{1}µ"), "a&lt;b&gt;&amp;&quot;c&quot; \u{fffd}µ");
    }
}
