//! The smallest rectangle about points of a plane: a lamp's own sides, however it is turned.

use super::tuning::extent::{ALIKE, MOST_SIDES};
use glam::DVec2;

/// A direction along which the smallest rectangle about these points lies, unit; of several that are as small the one nearest to `upright`
/// or square to it. None of points that lie on a line.
pub(super) fn sides_of_smallest(points: &[DVec2], upright: DVec2) -> Option<DVec2> {
    let hull = hull(points);
    let side = |i: usize| hull[(i + 1) % hull.len()] - hull[i];
    let mut sides: Vec<DVec2> = (0..hull.len()).map(side).collect();
    // One side of the smallest rectangle lies along a side of the hull (H. Freeman and R. Shapira, 1975).
    sides.sort_by(|a, b| b.length_squared().total_cmp(&a.length_squared()));
    sides.truncate(MOST_SIDES);
    let along: Vec<(f64, DVec2)> = sides
        .into_iter()
        .filter_map(|side| {
            let axis = side.try_normalize()?;
            let [low, high] = bounds(&hull, axis);
            Some(((high - low).element_product(), axis))
        })
        .collect();
    let least = along.iter().map(|(area, _)| *area).min_by(f64::total_cmp)?;
    let alike = along.into_iter().filter(|(area, _)| *area <= least * (1.0 + ALIKE));
    // Largest of |cos|, |sin|: how near an axis is to upright or square to it.
    let near = |axis: DVec2| axis.dot(upright).abs().max(axis.perp_dot(upright).abs());
    (least > 0.0).then_some(alike.map(|(_, axis)| axis).max_by(|a, b| near(*a).total_cmp(&near(*b))))?
}

/// Lower and upper corner of the box about points with sides along `axis` (unit) and a quarter turn on.
pub(super) fn bounds(points: &[DVec2], axis: DVec2) -> [DVec2; 2] {
    let at = |p: &DVec2| DVec2::new(p.dot(axis), axis.perp_dot(*p));
    let none = [DVec2::INFINITY, DVec2::NEG_INFINITY];
    points.iter().map(at).fold(none, |[low, high], at| [low.min(at), high.max(at)])
}

/// Corners of the convex hull, around it (A. M. Andrew, 1979). Fewer than three of points that lie on a line.
fn hull(points: &[DVec2]) -> Vec<DVec2> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    sorted.dedup();
    let half = |points: &mut dyn Iterator<Item = DVec2>| {
        let mut chain: Vec<DVec2> = Vec::new();
        for point in points {
            while let [.., a, b] = chain[..]
                && (b - a).perp_dot(point - b) <= 0.0
            {
                chain.pop();
            }
            chain.push(point);
        }
        // The last one is the first of the other half.
        chain.pop();
        chain
    };
    let mut around = half(&mut sorted.iter().copied());
    around.extend(half(&mut sorted.iter().rev().copied()));
    around
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rectangle(turn_deg: f64) -> Vec<DVec2> {
        let turn = DVec2::from_angle(turn_deg.to_radians());
        let corners = [[-12.0, -8.0], [12.0, -8.0], [12.0, 8.0], [-12.0, 8.0], [0.0, 3.0], [12.0, 1.0]];
        corners.map(|corner| DVec2::new(300.0, -40.0) + turn.rotate(corner.into())).to_vec()
    }

    #[test]
    fn a_rectangle_is_itself_however_it_is_turned() {
        for turn in [0.0, 1.0, 17.0, 44.0, 61.0, 90.0, 133.0] {
            let points = rectangle(turn);
            let axis = sides_of_smallest(&points, DVec2::X).unwrap();
            let [low, high] = bounds(&points, axis);
            let size = (high - low).to_array();
            assert!(
                (size[0].max(size[1]) - 24.0).abs() < 1e-12 && (size[0].min(size[1]) - 16.0).abs() < 1e-12,
                "{size:?}"
            );
        }
    }

    /// Of a round outline every rectangle along one of its sides is as small.
    #[test]
    fn of_many_that_are_alike_one_is_upright() {
        let sides = 48;
        let corner = |i: usize| DVec2::from_angle((i as f64 + 0.5) * std::f64::consts::TAU / sides as f64);
        let points: Vec<DVec2> = (0..sides).map(corner).collect();
        let upright = DVec2::from_angle(0.01);
        let axis = sides_of_smallest(&points, upright).unwrap();
        assert!(axis.y.abs() < 1e-12 || axis.x.abs() < 1e-12, "{axis}");
        assert_eq!(sides_of_smallest(&[DVec2::ZERO, DVec2::X, DVec2::X * 2.0], DVec2::X), None);
        assert_eq!(sides_of_smallest(&[], DVec2::X), None);
    }
}
