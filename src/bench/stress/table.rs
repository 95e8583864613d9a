//! The suite's result as text, JSON and Markdown.

use super::{Report, Row};

fn bias(row: &Row) -> String {
    format!("{:+.1}", row.bias)
}

/// A small share, or 0.
fn share(x: f64) -> String {
    if x == 0.0 { "0".to_owned() } else { format!("{x:.0e}") }
}

/// One line of a case.
pub fn line(row: &Row) -> String {
    let verdict = if row.findings.is_empty() { "ok".to_owned() } else { row.findings.join("; ") };
    format!(
        "{:10} {:44} {:>12.6} {:>8} {:>7} {:>7} {:>4}  {verdict}",
        row.kind.name(),
        row.case,
        row.mean,
        share(row.sigma),
        bias(row),
        share(row.loss),
        row.nan
    )
}

/// The head of the lines.
pub fn head() -> String {
    format!("{:10} {:44} {:>12} {:>8} {:>7} {:>7} {:>4}", "kind", "case", "cd/m²", "± σ", "bias σ", "loss", "NaN")
}

/// The last line.
pub fn summary(report: &Report) -> String {
    let (cases, findings) = (report.rows.len(), report.findings());
    format!("{cases} cases, {findings} findings; a bias may be {:.2} σ", report.most_sigma)
}

/// The table of the documentation.
pub fn markdown(report: &Report) -> String {
    let mut out = String::from(
        "| kind | case | want, cd/m² | traced | ± σ | bias, σ | loss of light | NaN | findings |\n|---|---|---|---|---|---|---|---|---|\n",
    );
    for row in &report.rows {
        let findings = if row.findings.is_empty() { "none".to_owned() } else { row.findings.join("; ") };
        out += &format!(
            "| {} | {} | {:.6} | {:.6} | {} | {} | {} | {} | {findings} |\n",
            row.kind.name(),
            row.case,
            row.want,
            row.mean,
            share(row.sigma),
            bias(row),
            share(row.loss),
            row.nan
        );
    }
    out += &format!("\n{}\n", summary(report));
    out
}

/// The page of the documentation. `now`: seconds since 1970.
pub fn page(report: &Report, now: u64, cores: usize) -> String {
    let (year, month, day) = date(now);
    format!(
        "# Numbers at their limits\n\n\
         What `eyebox bench --stress` prints: scenes whose answer is known in closed form, traced. A bias is over the \
         standard error and what rounding may do; the loss is the share of the light that no fate accounts for; values \
         that are no numbers must not occur.\n\n\
         Written by `eyebox bench --stress --format markdown` on {year}-{month:02}-{day:02}, on a machine with {cores} \
         cores.\n\n{}",
        markdown(report)
    )
}

/// Year, month and day of a time in UTC (H. Hinnant, "chrono-compatible low-level date algorithms", 2013).
fn date(now: u64) -> (u64, u64, u64) {
    let days = now / 86_400 + 719_468;
    let (era, of_era) = (days / 146_097, days % 146_097);
    let year = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year + year / 4 - year / 100);
    let shifted = (5 * of_year + 2) / 153;
    let month = if shifted < 10 { shifted + 3 } else { shifted - 9 };
    (year + era * 400 + u64::from(month <= 2), month, of_year - (153 * shifted + 2) / 5 + 1)
}

#[cfg(test)]
mod tests {
    use super::date;

    #[test]
    fn dates() {
        assert_eq!(date(0), (1970, 1, 1));
        assert_eq!(date(951_782_400), (2000, 2, 29));
        assert_eq!(date(1_735_689_599), (2024, 12, 31));
    }
}
