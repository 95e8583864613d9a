//! Where second images lie beside the main one, from each position.

use super::super::Scan;
use super::super::tuning::charts::{DOT, LONGEST, SHARE, THICKEST};
use super::sheet::Sheet;
use super::{COLOURS, Chart, escaped, round_down, step};

pub fn chart(scan: &Scan) -> Option<Chart> {
    let mut sheet = Sheet::new(scan)?;
    let mut names: Vec<&str> = Vec::new();
    for ghost in scan.positions.iter().flat_map(|position| &position.ghosts) {
        if !names.contains(&ghost.by.as_str()) {
            names.push(&ghost.by);
        }
    }
    if names.is_empty() {
        return None;
    }
    let most = scan.positions.iter().flat_map(|p| &p.ghosts).map(|ghost| ghost.most_arcmin).fold(0.0, f64::max);
    // The longest one can be seen, and does not reach the next point.
    let longest = (LONGEST / sheet.scale).min(step(scan));
    let factor = if most > 0.0 { round_down(SHARE * longest * 60.0 / most) } else { 1.0 };
    for (index, position) in scan.positions.iter().enumerate() {
        sheet.begin(index, scan);
        for ghost in &position.ghosts {
            let number = names.iter().position(|name| *name == ghost.by).unwrap_or(0);
            let colour = COLOURS[number.min(COLOURS.len() - 1)];
            for point in &ghost.points {
                let Some(line) = position.points.iter().find(|line| line.cell == point.cell) else { continue };
                let Some(from) = line.direction_deg else { continue };
                let off = point.separation_arcmin.map(|arcmin| factor * arcmin / 60.0);
                // By decades of the ratio: 1 is thickest, a ten thousandth a fifth of that.
                let width = THICKEST * (1.0 + 0.2 * point.ratio.max(1e-4).log10()).max(0.2);
                let to = [from[0] + off[0], from[1] + off[1]];
                sheet.line(from, to, colour, width);
                let [right, up] = point.separation_arcmin;
                sheet.disc(
                    to,
                    0.5 * DOT,
                    colour,
                    &format!("{}: {right:.2}′ right, {up:.2}′ up, ratio {:.5}", ghost.by, point.ratio),
                );
            }
        }
        sheet.end();
    }
    let legend: Vec<String> = names
        .iter()
        .enumerate()
        .map(|(number, name)| {
            let colour = COLOURS[number.min(COLOURS.len() - 1)];
            format!("<svg class=\"key\" viewBox=\"0 0 10 10\" aria-hidden=\"true\"><rect width=\"10\" height=\"10\" fill=\"{colour}\"/></svg> {}", escaped(name))
        })
        .collect();
    let note = format!(
        "From each point of the main image to the same point of a ghost, {factor} times as long as it is (the longest is {most:.3}′), \
         thicker where the ghost is brighter: {}",
        legend.join("; ")
    );
    Some(Chart { title: "Ghosts", note, svg: sheet.svg("Ghosts over the eyebox") })
}
