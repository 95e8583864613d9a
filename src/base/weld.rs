//! Which vertices are one point: exporters repeat a vertex per seam, per pole and per crease, sometimes a rounding
//! apart.

use glam::DVec3;
use std::collections::HashMap;

/// Half a unit in the last place of the largest coordinate, as a distance: √3 · 2⁻²⁴ · max|x|, the farthest that
/// rounding to f32 can move a point. Points that are not finite are passed over.
pub fn rounding(points: &[[f32; 3]]) -> f64 {
    let largest = points.iter().flatten().filter(|x| x.is_finite()).fold(0.0f64, |m, &x| m.max(f64::from(x).abs()));
    3f64.sqrt() * 2f64.powi(-24) * largest
}

/// For each vertex, the index of the first vertex that lies within `reach` (mesh units) of it, itself if it is the
/// first. A vertex that is not finite stays alone.
pub fn weld(points: &[[f32; 3]], reach: f64) -> Vec<usize> {
    // Cells are much wider than `reach`, so that a point meets more than one cell only near their walls; all eight
    // corners of its reach are looked up, so that a wall never separates two points. A face that is a single point has
    // reach 0.
    let cell = if reach > 0.0 { 16.0 * reach } else { 1.0 };
    let key = |p: DVec3| (p / cell).floor().to_array().map(|x| x as i64);
    // The latest point of each cell, and for each point the one before it in its cell: no list per cell.
    let mut cells: HashMap<[i64; 3], usize> = HashMap::with_capacity(points.len());
    let mut before = vec![usize::MAX; points.len()];
    let mut first = Vec::with_capacity(points.len());
    for (index, point) in points.iter().enumerate() {
        let p = DVec3::from_array(point.map(f64::from));
        if !p.is_finite() {
            first.push(index);
            continue;
        }
        let (low, high) = (key(p - reach), key(p + reach));
        let mut found: Option<usize> = None;
        for corner in 0..8usize {
            let pick = |axis: usize| if corner >> axis & 1 == 0 { low[axis] } else { high[axis] };
            if (0..3).any(|axis| corner >> axis & 1 == 1 && low[axis] == high[axis]) {
                continue; // the same cell again
            }
            let mut next = cells.get(&[pick(0), pick(1), pick(2)]).copied();
            while let Some((other, o)) = next.and_then(|other| Some((other, points.get(other)?))) {
                let near = DVec3::from_array(o.map(f64::from)).distance_squared(p) <= reach * reach;
                if near && found.is_none_or(|f| other < f) {
                    found = Some(other);
                }
                next = before.get(other).copied();
            }
        }
        first.push(found.unwrap_or(index));
        if found.is_none() {
            before[index] = cells.insert(key(p), index).unwrap_or(usize::MAX);
        }
    }
    first
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rounding_apart_is_one_point_and_a_wall_does_not_separate() {
        let points = [
            [1.0f32, 2.0, 3.0],
            [f32::NAN, 0.0, 0.0],
            [1.0, 2.0, f32::from_bits(3f32.to_bits() + 1)],
            [1.0, 2.0, 3.001],
        ];
        let reach = 2.0 * rounding(&points);
        assert_eq!(weld(&points, reach), [0, 1, 0, 3]);
        // Two points 2.2e-16 apart around a cell wall at zero (seen at the pole of LENS_04_F2).
        let points = [[2.220446e-16f32, 0.0, 1.0], [-2.220446e-16, 0.0, 1.0]];
        assert_eq!(weld(&points, rounding(&points)), [0, 0]);
        assert_eq!(weld(&[[0.0; 3]; 2], 0.0), [0, 0]);
    }
}
