//! The picture's grid as each position has it, over the grid of the best affine picture.

use super::super::tuning::charts::SHARE;
use super::super::{Line, Position, Scan};
use super::sheet::Sheet;
use super::{COLOURS, Chart, round_down};
use eyebox_estimate::virtual_image::image::ideal;
use glam::{DVec2, DVec3};

/// Points that are seen: cell, direction, and that of the best affine picture; degrees.
pub fn deviations(scan: &Scan, position: &Position) -> Vec<([usize; 2], [f64; 2], [f64; 2])> {
    let last = scan
        .positions
        .iter()
        .flat_map(|position| &position.points)
        .fold([0; 2], |last, line| [0, 1].map(|axis| usize::max(last[axis], line.cell[axis])));
    let place = |line: &Line| {
        let [u, v] = [0, 1].map(|axis| line.cell[axis] as f64 / last[axis].max(1) as f64 - 0.5);
        DVec2::new(u * scan.picture_m[0], -v * scan.picture_m[1])
    };
    let seen: Vec<(&Line, [f64; 2])> =
        position.points.iter().filter(|line| line.seen).filter_map(|line| Some((line, line.direction_deg?))).collect();
    let places: Vec<(DVec2, DVec3)> = seen.iter().map(|(line, deg)| (place(line), direction(*deg))).collect();
    let middle = places.iter().min_by(|a, b| a.0.length().total_cmp(&b.0.length())).map(|(_, dir)| *dir);
    let Some(found) = middle.and_then(|middle| ideal(&places, middle, DVec3::X)) else { return Vec::new() };
    let angles = |dir: DVec3| [dir.x, dir.y].map(|side| side.atan2(-dir.z).to_degrees());
    seen.iter().zip(found).map(|((line, deg), ideal)| (line.cell, *deg, angles(ideal))).collect()
}

/// Of an eye that looks along −z with its right along x.
fn direction(deg: [f64; 2]) -> DVec3 {
    let [x, y] = deg.map(|angle| angle.to_radians().tan());
    DVec3::new(x, y, -1.0).normalize()
}

pub fn chart(scan: &Scan) -> Option<Chart> {
    let mut sheet = Sheet::new(scan)?;
    let all: Vec<_> = scan.positions.iter().map(|position| deviations(scan, position)).collect();
    let far = |[a, b]: [f64; 2], [c, d]: [f64; 2]| (a - c).hypot(b - d);
    let most = all.iter().flatten().map(|(_, real, ideal)| far(*real, *ideal)).fold(0.0, f64::max);
    // The largest deviation is drawn as a good part of the distance between two points.
    let step = all
        .iter()
        .flat_map(|points| points.windows(2))
        .map(|pair| far(pair[0].2, pair[1].2))
        .fold(f64::INFINITY, f64::min);
    let factor = if most > 0.0 && step.is_finite() { round_down(SHARE * step / most) } else { 1.0 };
    for (index, points) in all.iter().enumerate() {
        sheet.begin(index, scan);
        let enlarged =
            |real: [f64; 2], ideal: [f64; 2]| [0, 1].map(|axis| ideal[axis] + factor * (real[axis] - ideal[axis]));
        for (cell, real, ideal) in points {
            let next = [[cell[0] + 1, cell[1]], [cell[0], cell[1] + 1]];
            for (_, real2, ideal2) in points.iter().filter(|(other, ..)| next.contains(other)) {
                sheet.line(*ideal, *ideal2, "#999999", 0.5);
                sheet.line(enlarged(*real, *ideal), enlarged(*real2, *ideal2), COLOURS[0], 1.2);
            }
        }
        sheet.end();
    }
    let note = format!(
        "The picture's grid (blue), its deviations from the best affine picture (grey) enlarged {factor} times; the largest is {:.3}′.",
        60.0 * most
    );
    let svg = sheet.svg("Distortion grids over the eyebox");
    Some(Chart { title: "Distortion", note, svg })
}
