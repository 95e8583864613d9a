//! Maps from the unit square to the domains that are sampled, and frames about a direction.

use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Uniform on the unit disk; density 1/π. Concentric map of P. Shirley and K. Chiu (1997).
pub fn disk([a, b]: [f64; 2]) -> DVec2 {
    let (x, y) = (2.0 * a - 1.0, 2.0 * b - 1.0);
    if x == 0.0 && y == 0.0 {
        return DVec2::ZERO;
    }
    let (radius, phi) = if x.abs() > y.abs() { (x, PI / 4.0 * (y / x)) } else { (y, PI / 2.0 - PI / 4.0 * (x / y)) };
    DVec2::new(radius * phi.cos(), radius * phi.sin())
}

/// The point of the unit square that [`disk`] takes to a point of the unit disk.
pub fn disk_inverse(p: DVec2) -> [f64; 2] {
    let side = |x: f64| 0.5 + 0.5 * x.clamp(-1.0, 1.0);
    let radius = p.length();
    if radius == 0.0 {
        return [0.5; 2];
    }
    if p.x.abs() > p.y.abs() {
        let x = radius.copysign(p.x);
        [side(x), side(x * (4.0 / PI * (p.y / p.x).atan()))]
    } else {
        let y = radius.copysign(p.y);
        [side(y * (4.0 / PI * (p.x / p.y).atan())), side(y)]
    }
}

/// Cosine-weighted on the hemisphere about +z; density cos θ/π per steradian.
pub fn cosine_hemisphere(uv: [f64; 2]) -> DVec3 {
    let p = disk(uv);
    DVec3::new(p.x, p.y, (1.0 - p.length_squared()).max(0.0).sqrt())
}

/// The flux of an emitter with I ∝ cosⁿ θ: density (n+1)/(2π)·cosⁿ θ per steradian.
pub fn cos_n_hemisphere([a, b]: [f64; 2], n: f64) -> DVec3 {
    let cos = (1.0 - a).powf(1.0 / (n + 1.0));
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let phi = 2.0 * PI * b;
    DVec3::new(sin * phi.cos(), sin * phi.sin(), cos)
}

/// Uniform on the unit sphere; density 1/(4π).
pub fn sphere([a, b]: [f64; 2]) -> DVec3 {
    let z = 1.0 - 2.0 * a;
    let r = (1.0 - z * z).max(0.0).sqrt();
    let phi = 2.0 * PI * b;
    DVec3::new(r * phi.cos(), r * phi.sin(), z)
}

/// Barycentric coordinates uniform over a triangle.
pub fn triangle([a, b]: [f64; 2]) -> [f64; 3] {
    let root = a.sqrt();
    let (u, v) = (1.0 - root, b * root);
    [u, v, 1.0 - u - v]
}

/// A right-handed orthonormal frame about a unit vector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    pub x: DVec3,
    pub y: DVec3,
    pub z: DVec3,
}

impl Frame {
    /// Branch-free construction of Duff et al., JCGT 6(1), 2017.
    pub fn about(z: DVec3) -> Self {
        let sign = 1f64.copysign(z.z);
        let a = -1.0 / (sign + z.z);
        let b = z.x * z.y * a;
        Frame {
            x: DVec3::new(1.0 + sign * z.x * z.x * a, sign * b, -sign * z.x),
            y: DVec3::new(b, sign + z.y * z.y * a, -z.y),
            z,
        }
    }
    pub fn to_world(&self, v: DVec3) -> DVec3 {
        self.x * v.x + self.y * v.y + self.z * v.z
    }
    pub fn to_local(&self, v: DVec3) -> DVec3 {
        DVec3::new(self.x.dot(v), self.y.dot(v), self.z.dot(v))
    }
}

/// The largest number below 1.
pub const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Rng, Stream};

    /// Means of monomials against their closed forms, within 5σ of 2e5 samples.
    #[test]
    fn moments_match_closed_forms() {
        let count = 200_000;
        let mut rng = Rng::new(3, Stream::Check, 0, 0);
        let mut sums = [0.0f64; 5];
        for _ in 0..count {
            let d = disk(rng.pair());
            sums[0] += d.length_squared();
            sums[1] += d.x * d.x;
            sums[2] += cosine_hemisphere(rng.pair()).z;
            sums[3] += cos_n_hemisphere(rng.pair(), 20.0).z;
            sums[4] += sphere(rng.pair()).z.powi(2);
        }
        let want = [0.5, 0.25, 2.0 / 3.0, 21.0 / 22.0, 1.0 / 3.0];
        for (sum, want) in sums.iter().zip(want) {
            assert!((sum / count as f64 - want).abs() < 5.0 * 0.3 / (count as f64).sqrt(), "{sum} {want}");
        }
    }

    #[test]
    fn the_disk_leads_back_to_the_square() {
        let mut rng = Rng::new(6, Stream::Check, 0, 0);
        let points = (0..1000).map(|_| rng.pair()).chain([[0.5; 2], [0.5, 0.9], [0.1, 0.5], [0.25; 2], [0.75, 0.25]]);
        for p in points {
            let back = disk_inverse(disk(p));
            assert!((0..2).all(|k| (back[k] - p[k]).abs() < 1e-12), "{p:?} {back:?}");
        }
    }

    #[test]
    fn frames_are_orthonormal_and_right_handed() {
        let mut rng = Rng::new(4, Stream::Check, 0, 0);
        for _ in 0..1000 {
            let f = Frame::about(sphere(rng.pair()));
            assert!((f.x.cross(f.y) - f.z).length() < 1e-14);
            assert!(f.x.dot(f.y).abs() < 1e-15 && (f.x.length() - 1.0).abs() < 1e-15);
        }
    }
}
