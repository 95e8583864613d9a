//! The curves as text for people and as Markdown.

use super::fit::Reach;
use super::{AssetReport, Curve, LEVELS, Report};

/// Three digits, with a power of ten where the number is small or large.
fn short(x: f64) -> String {
    let size = x.abs();
    match size {
        _ if x == 0.0 => "0".to_owned(),
        _ if !(1e-2..1e5).contains(&size) => format!("{x:.2e}"),
        _ if size < 1.0 => format!("{x:.3}"),
        _ if size < 10.0 => format!("{x:.2}"),
        _ if size < 100.0 => format!("{x:.1}"),
        _ => format!("{x:.0}"),
    }
}

fn maybe(x: Option<f64>) -> String {
    x.map_or("–".to_owned(), short)
}

/// An error as the references see it.
fn told(error: f64, resolution: f64) -> String {
    if error.is_finite() && error < resolution { format!("< {}", short(resolution)) } else { short(error) }
}

fn seconds(reach: &Reach) -> String {
    match reach.seconds {
        None => "–".to_owned(),
        Some(s) if reach.extrapolated => format!("~{}", short(s)),
        Some(s) => short(s),
    }
}

const HEAD: [&str; 11] =
    ["estimator", "setup s", "CPU s", "passes", "paths/s", "relMSE", "trimmed", "flat", "edges", "energy", "worst σ"];

fn head() -> Vec<String> {
    let levels = LEVELS.map(|level| format!("s to {level:.0e}"));
    HEAD.iter().map(|cell| (*cell).to_owned()).chain(std::iter::once("slope".to_owned())).chain(levels).collect()
}

fn cells(curve: &Curve, resolution: f64) -> Vec<String> {
    let name = if curve.estimator == "auto" {
        format!("auto ({})", curve.runs.join(" + "))
    } else {
        curve.estimator.to_owned()
    };
    let mut cells = vec![name, short(curve.setup_seconds)];
    match curve.points.last() {
        Some(point) => {
            let error = point.error;
            cells.extend([
                short(curve.setup_seconds + point.seconds),
                point.passes.to_string(),
                short(curve.paths_per_second),
                told(error.relmse, resolution),
                told(error.trimmed, resolution),
                error.flat.map_or("–".to_owned(), |flat| told(flat, resolution)),
                error.edges.map_or("–".to_owned(), |edges| told(edges, resolution)),
                format!("{:.4} ± {:.4}", error.energy, error.energy_sigma),
                format!("{:+.1}", error.worst_sigma),
                maybe(curve.slope),
            ]);
            cells.extend(curve.reach.iter().map(seconds));
        }
        None => cells.resize(HEAD.len() + 1 + LEVELS.len(), "–".to_owned()),
    }
    cells
}

fn reference_line(asset: &AssetReport) -> String {
    let reference = &asset.reference;
    let passes = reference.passes.map_or(String::new(), |[a, b]| format!(", {a} and {b} passes"));
    let [flat, all] = reference.flat_pixels;
    format!(
        "references: {}{passes}, {} CPU s, mean {} cd/m², relMSE {} each; they tell errors from {} on; flat: {flat} of \
         {all} pixels; {}",
        reference.from,
        short(reference.seconds),
        short(reference.mean),
        short(reference.noise),
        short(reference.resolution),
        reference.known_blocks.map_or("too rough to tell a bias".to_owned(), |blocks| format!(
            "the worst of a sound picture's {blocks} blocks deviates by up to {:.1} σ",
            reference.most_sigma
        )),
    )
}

fn title(asset: &AssetReport) -> String {
    let [width, height] = asset.resolution;
    format!("{}, {width} × {height} pixels", asset.asset)
}

/// A table for people.
pub fn text(report: &Report) -> String {
    let mut out = String::new();
    for asset in &report.assets {
        let rows: Vec<Vec<String>> = std::iter::once(head())
            .chain(asset.curves.iter().map(|curve| cells(curve, asset.reference.resolution)))
            .collect();
        let width = |column: usize| rows.iter().filter_map(|row| row.get(column)).map(|c| c.chars().count()).max();
        out += &format!("{}\n{}\n", title(asset), reference_line(asset));
        for row in &rows {
            for (column, cell) in row.iter().enumerate() {
                // The name to the left, numbers to the right.
                let pad = " ".repeat(width(column).unwrap_or(0).saturating_sub(cell.chars().count()));
                out += &if column == 0 { format!("{cell}{pad}") } else { format!("  {pad}{cell}") };
            }
            out += "\n";
        }
        out += "\n";
    }
    out + &format!("~: beyond the curve's end, if the error falls as one over the time. {}\n", machine(report))
}

fn machine(report: &Report) -> String {
    let threads = if report.threads == 1 { "one thread".to_owned() } else { format!("{} threads", report.threads) };
    format!("{}, {threads}, eyebox {}, seed {}.", report.processor, report.version, report.seed)
}

/// The same as Markdown, and the seconds by the trimmed error and over flat pixels.
pub fn markdown(report: &Report) -> String {
    let mut out = format!(
        "# Time against error, measured\n\nWritten by `eyebox bench`; docs/bench.md defines the columns.\n\n{}\n",
        machine(report)
    );
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    for asset in &report.assets {
        out += &format!("\n## {}\n\n{}\n\n", title(asset), reference_line(asset));
        let head = head();
        out += &line(&head);
        out += &line(&vec!["---".to_owned(); head.len()]);
        for curve in &asset.curves {
            out += &line(&cells(curve, asset.reference.resolution));
        }
        let levels = |what: &str| LEVELS.map(|level| format!("{what}: s to {level:.0e}"));
        let mut head = vec!["estimator".to_owned()];
        head.extend(levels("trimmed").into_iter().chain(levels("flat")));
        out += &format!("\n{}", line(&head));
        out += &line(&vec!["---".to_owned(); head.len()]);
        for curve in &asset.curves {
            let mut row = vec![curve.estimator.to_owned()];
            for reach in [&curve.reach_trimmed, &curve.reach_flat] {
                row.extend((0..LEVELS.len()).map(|level| reach.get(level).map_or("–".to_owned(), seconds)));
            }
            out += &line(&row);
        }
    }
    out + "\n~: beyond the curve's end, if the error falls as one over the time.\n"
}
