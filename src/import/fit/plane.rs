//! The plane nearest to points: through their mean, across the direction in which they spread least.

use super::linalg::{Triangle, singular};
use glam::DVec3;

/// A plane and how the points spread in it.
pub(super) struct Plane {
    pub vertex: DVec3,
    /// Unit normal.
    pub axis: DVec3,
    /// Root-mean-square spread of the points along their two longest directions and along `axis`.
    pub spread: [f64; 3],
}

/// Orthogonal least squares by singular values of the centred points (Golub & Van Loan §5.5 of the 3-column case).
pub(super) fn plane(points: &[DVec3]) -> Plane {
    let count = points.len().max(1) as f64;
    let mean = points.iter().sum::<DVec3>() / count;
    let mut triangle = Triangle::<3>::new();
    for p in points {
        triangle.add((*p - mean).to_array());
    }
    let found = singular(triangle.r);
    let axis = DVec3::from_array(found[2].1).try_normalize().unwrap_or(DVec3::Z);
    Plane { vertex: mean, axis, spread: found.map(|(value, _)| value / count.sqrt()) }
}
