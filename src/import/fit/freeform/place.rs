//! Where the plane lies over which the heights of a face are told: across its mean normal, turned along the smallest
//! rectangle around it.

use super::super::plane::plane;
use super::super::pole::Face;
use super::model::Frame;
use glam::{DVec2, DVec3};

/// A frame at the middle of a rectangle around the face, and half the rectangle's sides.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub frame: Frame,
    pub half: [f64; 2],
}

/// Triangles that stand steeper than this over the plane (as the cosine) make a face that's no height over it.
const STEEPEST: f64 = 0.1;

impl Place {
    /// None where the face is no height over a plane or has no width.
    pub fn of(face: &Face) -> Option<Place> {
        let flat = plane(&face.points);
        let mut axis = face.normal().unwrap_or(flat.axis);
        // The nearest plane is even about the slopes of a bent face; the mean normal is for faces that are deep.
        if flat.axis.dot(axis).abs() > 0.9 {
            axis = flat.axis * flat.axis.dot(axis).signum();
        }
        over(face, axis).then_some(())?;
        let (u, v) = axis.any_orthonormal_pair();
        let flat: Vec<DVec2> = face.points.iter().map(|p| DVec2::new(p.dot(u), p.dot(v))).collect();
        let (angle, low, high) = rectangle(&flat)?;
        let (sin, cos) = angle.sin_cos();
        let (x, y) = (cos * u + sin * v, cos * v - sin * u);
        let middle = 0.5 * (low + high);
        let height = face.middle().dot(axis);
        let frame = Frame { vertex: middle.x * x + middle.y * y + height * axis, x, y: axis.cross(x), axis };
        let half = (0.5 * (high - low)).to_array();
        (half[1] > 0.0 && half[0].is_finite()).then_some(Place { frame, half })
    }
}

/// Whether all triangles that have an area lie over the plane, on one side or the other: how they are wound says nothing.
fn over(face: &Face, axis: DVec3) -> bool {
    let crosses = face.triangles.iter().filter_map(|t| {
        let [a, b, c] = t.map(|i| face.points.get(i).copied().unwrap_or_default());
        let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
        let cross = (b - a).cross(c - a);
        // The normal of a sliver is rounding.
        (cross.length() > 1e-3 * longest).then_some(cross)
    });
    let normals = crosses.map(|cross| cross.normalize_or(axis).dot(axis).abs());
    normals.fold(1.0, f64::min) > STEEPEST
}

/// Directions tried in a quarter turn.
const TURNS: u32 = 180;

/// The angle of the longer side of the smallest rectangle around the points, and its corners in turned axes.
fn rectangle(points: &[DVec2]) -> Option<(f64, DVec2, DVec2)> {
    let at = |angle: f64| {
        let turn = DVec2::from_angle(-angle);
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for p in points {
            let q = turn.rotate(*p);
            (low, high) = (low.min(q), high.max(q));
        }
        (angle, low, high)
    };
    let quarter = std::f64::consts::FRAC_PI_2;
    let area = |(_, low, high): &(f64, DVec2, DVec2)| (high.x - low.x) * (high.y - low.y);
    let all = (0..TURNS).map(|k| at(quarter * f64::from(k) / f64::from(TURNS)));
    let mut found = all.min_by(|a, b| area(a).total_cmp(&area(b)))?;
    // The sides of a face that is one are told to what its corners tell.
    let mut step = quarter / f64::from(TURNS);
    for _ in 0..4 {
        let finer = (-10..=10).map(|k| at(found.0 + step * f64::from(k) / 10.0));
        found = finer.min_by(|a, b| area(a).total_cmp(&area(b)))?;
        step /= 10.0;
    }
    let size = found.2 - found.1;
    Some(if size.x >= size.y { found } else { at(found.0 + quarter) })
}
