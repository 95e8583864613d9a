//! The table as lines for people.

use super::{Kind, Table};

impl Table {
    /// Lines for people: a row takes two, numbers and names.
    pub fn text(&self) -> String {
        let [lamps, eye] = self.paths;
        let amount = if self.pinhole {
            "a point of a pupil".to_owned()
        } else {
            format!("{:.4e} lm into the pupil", self.flux_lm)
        };
        let mut lines = vec![format!(
            "{} ways from lamps to the eye: {amount} within {:.1}° × {:.1}°",
            self.rows.len(),
            2.0 * self.half_field_degrees[0],
            2.0 * self.half_field_degrees[1],
        )];
        if !self.rows.is_empty() {
            lines.push(format!(
                "{:>3}  {:>9}  {:>10}  {:>6}  {:>10}  {:>10}  {:>7}  {}",
                "",
                "of all",
                if self.pinhole { "all cd/m²" } else { "lm" },
                "± %",
                "mean cd/m²",
                "peak cd/m²",
                "picture",
                "where (degrees)"
            ));
        }
        for row in &self.rows {
            let error = 100.0 * row.relative_stderr;
            let amount = if self.pinhole { row.picture_mean_cd_m2 } else { row.flux_lm };
            let [left, right, bottom, top] = row.footprint.degrees;
            lines.push(format!(
                "{:>3}  {:>9}  {:>10.3e}  {:>6}  {:>10.4}  {:>10.4}  {:>7}  {left:.1} … {right:.1}, {bottom:.1} … {top:.1}",
                row.number,
                percent(row.share),
                amount,
                if error.is_finite() { format!("{error:.1}") } else { "–".to_owned() },
                Digits(row.mean_cd_m2),
                Digits(row.peak_cd_m2),
                percent(row.footprint.share),
            ));
            let kind = match (row.kind, row.of_main) {
                (Kind::Main, _) | (_, None) => row.kind.name().to_owned(),
                (kind, Some(ratio)) => format!("{}, {} of main", kind.name(), percent(ratio)),
            };
            let lamps = match row.lamps.len() {
                0 | 1 => String::new(),
                many => format!(" ({many} lamps)"),
            };
            lines.push(format!("     {}: {kind}{lamps}", row.path));
        }
        if self.left_out.0 > 0 {
            lines.push(format!("left out: {} ways with {} of all together", self.left_out.0, percent(self.left_out.1)));
        }
        let (chains, along) = (self.chains, self.paths_along);
        lines.push(format!(
            "traced: {along} paths along {chains} chains of faces; for the rest {lamps} from the lamps, {eye} from the eye"
        ));
        lines.extend(self.notes.iter().map(|note| format!("note: {note}")));
        lines.join("\n")
    }
}

/// Four digits that count.
struct Digits(f64);

impl std::fmt::Display for Digits {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Digits(x) = *self;
        let text = if x == 0.0 {
            "0".to_owned()
        } else if (1e-3..1e6).contains(&x.abs()) {
            let after = (3 - x.abs().log10().floor() as i32).clamp(0, 6) as usize;
            format!("{x:.after$}")
        } else {
            format!("{x:.3e}")
        };
        let width = f.width().unwrap_or(0);
        write!(f, "{text:>width$}")
    }
}

fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if percent == 0.0 || percent >= 0.01 {
        let after = if percent >= 99.995 { 1 } else { 2 };
        format!("{percent:.after$} %")
    } else {
        format!("{percent:.1e} %")
    }
}
