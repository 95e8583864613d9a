//! From where light seems to come, over the picture, from each position.

use super::super::Scan;
use super::super::tuning::charts::DOT;
use super::Chart;
use super::sheet::Sheet;

/// From dark blue over green to yellow: lightness rises along it, and people with any colour vision can follow it.
const STOPS: [[f64; 3]; 5] =
    [[48.0, 18.0, 90.0], [40.0, 80.0, 140.0], [30.0, 145.0, 140.0], [110.0, 200.0, 90.0], [250.0, 225.0, 40.0]];

/// The colour at a share of the scale.
pub fn colour(share: f64) -> String {
    let at = share.clamp(0.0, 1.0) * (STOPS.len() - 1) as f64;
    let low = (at as usize).min(STOPS.len() - 2);
    let part = at - low as f64;
    let [r, g, b] = [0, 1, 2].map(|c| (STOPS[low][c] + part * (STOPS[low + 1][c] - STOPS[low][c])).round() as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}

pub fn chart(scan: &Scan) -> Option<Chart> {
    let mut sheet = Sheet::new(scan)?;
    let all = || scan.positions.iter().flat_map(|p| &p.points).filter_map(|line| line.vergence).map(|v| v.mean_per_m());
    let (low, high) = all().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    if low > high {
        return None;
    }
    for (index, position) in scan.positions.iter().enumerate() {
        sheet.begin(index, scan);
        for line in &position.points {
            let (Some(at), Some(vergence)) = (line.direction_deg, line.vergence) else { continue };
            let mean = vergence.mean_per_m();
            let share = if high > low { (mean - low) / (high - low) } else { 0.5 };
            let says = format!(
                "{mean:.4} 1/m (horizontal {:.4}, vertical {:.4})",
                vergence.horizontal_per_m, vergence.vertical_per_m
            );
            sheet.disc(at, DOT, &colour(share), &says);
        }
        sheet.end();
    }
    let note = format!(
        "1/distance, mean of both directions, from {low:.4} 1/m (dark blue) to {high:.4} 1/m (yellow); 0 is infinity, below it light \
         converges. Points have their numbers under the pointer."
    );
    Some(Chart { title: "Distance", note, svg: sheet.svg("Maps of 1/distance over the eyebox") })
}
