//! Tolerances as text and as CSV.

use super::Tolerances;
use super::statistics::Statistics;
use super::tuning::table::OFFENDERS;

/// For people.
pub fn lines(found: &Tolerances) -> Vec<String> {
    let mut out = vec![
        format!(
            "picture: {}, by {}; {} parameters, {} designs",
            found.part,
            found.by,
            found.parameters.len(),
            found.draws
        ),
        format!(
            "{:>12} {:>12} {:>11} {:>12} {:>12} {:>12}  figure, unit; what makes most of its variance",
            "nominal", "mean", "sigma", "1 %", "50 %", "99 %"
        ),
    ];
    out.extend(found.figures.iter().map(line));
    if let Some(why) = &found.why {
        let failed = found.failed + found.failed_alone;
        out.push(format!(
            "warning: {} of {} designs could not be traced, the first of them: {why}",
            failed,
            found.draws + 4 * found.parameters.len()
        ));
    }
    let fewest = found.figures.iter().map(|figure| figure.draws).min().unwrap_or(0);
    if fewest + found.failed < found.draws {
        out.push(format!("note: some figures are of {fewest} designs; in the others a face is missed or hidden"));
    }
    out
}

fn line(figure: &Statistics) -> String {
    let [one, _, half, _, most] = figure.percentiles;
    // By itself each; what is left of the whole is of several together.
    let whole: f64 = figure.shares.iter().filter_map(|share| share.variance).sum();
    let told = figure.shares.iter().filter(|share| share.variance != Some(0.0)).take(OFFENDERS);
    let offenders: Vec<String> = told
        .map(|share| match share.variance {
            Some(variance) => format!("{:.0} % {}", 100.0 * variance / whole, share.name),
            None => format!("unknown: {}", share.name),
        })
        .collect();
    format!(
        "{:12.5} {:12.5} {:11.5} {one:12.5} {half:12.5} {most:12.5}  {}, {}{}{}",
        figure.nominal,
        figure.mean,
        figure.sigma,
        figure.figure.name,
        figure.figure.unit,
        if offenders.is_empty() { "" } else { "; " },
        offenders.join(", ")
    )
}

/// A line per design, after a line of names: the parameters' values (m, rad, shares, index), then the figures. What there is
/// none of is empty.
pub fn csv(found: &Tolerances) -> String {
    let quoted = |name: &str| format!("\"{}\"", name.replace('"', "\"\""));
    let names = found.parameters.iter().map(|parameter| parameter.name.as_str());
    let names = names.chain(found.names.iter().map(|figure| figure.name.as_str()));
    let mut out = names.map(quoted).collect::<Vec<_>>().join(",");
    out.push('\n');
    for (values, figures) in &found.samples {
        let figure = |index: usize| figures.get(index).copied().unwrap_or(f64::NAN);
        let row = values.iter().copied().chain((0..found.names.len()).map(figure));
        let cells = row.map(|value| if value.is_finite() { format!("{value:e}") } else { String::new() });
        out.push_str(&cells.collect::<Vec<_>>().join(","));
        out.push('\n');
    }
    out
}
