//! A surface of revolution of second order, the nearest point on it, and how the distance to it answers to its
//! parameters.

use super::linalg::length;
use glam::DVec3;

/// c·(ρ² + (1+k)·z²) = 2z in the frame of `vertex` and unit `axis`: curvature c = 1/R at the vertex (signed, zero is a
/// plane), conic constant k (−1 paraboloid, below −1 hyperboloid, its sheet through the vertex), ISO 10110-12 without
/// the power series.
#[derive(Debug, Clone, Copy)]
pub(super) struct Conic {
    pub vertex: DVec3,
    pub axis: DVec3,
    pub c: f64,
    pub k: f64,
}

/// The freedoms of a conic, as columns of the Jacobian.
pub(super) const TURN_U: usize = 0; // turn about the vertex, rad, 2 columns
pub(super) const RISE: usize = 2; // along the axis
pub(super) const CURVE: usize = 3; // c
pub(super) const SHAPE: usize = 4; // k
pub(super) const SLIDE_U: usize = 5; // turn about the centre of curvature by c·s, 2 columns: does nothing to a sphere

impl Conic {
    /// Two unit vectors that make a right-handed frame with the axis.
    fn across(&self) -> (DVec3, DVec3) {
        self.axis.any_orthonormal_pair()
    }

    /// Signed orthogonal distance of `p` from the surface (positive on the side away from the centre of curvature where
    /// c > 0), followed by its derivatives: `[∂d/∂parameter; 7] + [d]`.
    pub fn row(&self, p: DVec3) -> [f64; 8] {
        let (u, v) = self.across();
        let q = p - self.vertex;
        let (x, y, z) = (q.dot(u), q.dot(v), q.dot(self.axis));
        let lambda = match self.foot(x * x + y * y, z) {
            Some(lambda) => lambda,
            // Beyond the centre plane of a hyperboloid: the vertex is an upper bound of the distance to the right
            // sheet.
            None => return [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, q.length()],
        };
        let (c, k) = (self.c, self.c * (1.0 + self.k));
        let (x, y, z) = (x / (1.0 + lambda * c), y / (1.0 + lambda * c), (z + lambda) / (1.0 + lambda * k));
        // Half the gradient at the foot; a displacement V of the surface there changes the distance by −n·V.
        let (gx, gy, gz) = (c * x, c * y, k * z - 1.0);
        let length = length(length(gx, gy), gz);
        let per = 1.0 / length;
        [
            -(gx * z - gz * x) * per,
            -(gy * z - gz * y) * per,
            -gz * per,
            0.5 * (x * x + y * y + (1.0 + self.k) * z * z) * per,
            0.5 * c * z * z * per,
            -c * c * self.k * x * z * per,
            -c * c * self.k * y * z * per,
            lambda * length,
        ]
    }

    /// Signed orthogonal distance alone.
    pub fn distance(&self, p: DVec3) -> f64 {
        let q = p - self.vertex;
        let z = q.dot(self.axis);
        let square = (q - z * self.axis).length_squared();
        let Some(lambda) = self.foot(square, z) else { return q.length() };
        let (across, along) = (1.0 + lambda * self.c, 1.0 + lambda * self.c * (1.0 + self.k));
        let (rho, tilt) = (square.sqrt() / across, (self.c * (1.0 + self.k) * z - 1.0) / along);
        lambda * length(self.c * rho, tilt)
    }

    /// The multiplier λ for which the foot (ρ/(1+λc), (z+λ)/(1+λK)), K = c(1+k), lies on the surface: point − foot is
    /// then λ times half the gradient there. `square` is ρ². On a sphere half the gradient is a unit vector, so that λ
    /// is the distance. Else Newton's method on a function that falls monotonically between its poles, which bound the
    /// near foot. None on the far side of a hyperboloid's centre plane.
    fn foot(&self, square: f64, z: f64) -> Option<f64> {
        let (c, k) = (self.c, self.c * (1.0 + self.k));
        if self.k == 0.0 {
            let miss = c * (square + z * z) - 2.0 * z;
            let lambda = miss / (1.0 + (1.0 + c * miss).max(0.0).sqrt());
            return lambda.is_finite().then_some(lambda);
        }
        if self.k < -1.0 && k * z - 1.0 >= 0.0 {
            return None;
        }
        let mut lambda = 0.0;
        for _ in 0..60 {
            let (across, along) = (1.0 / (1.0 + lambda * c), 1.0 / (1.0 + lambda * k));
            let (square, h) = (square * across * across, (z + lambda) * along);
            let value = c * square + h * (k * h - 2.0);
            let half = c * c * square * across + (k * h - 1.0).powi(2) * along;
            let mut step = 0.5 * value / half;
            if !step.is_finite() {
                return None;
            }
            while 1.0 + (lambda + step) * c <= 0.0 || 1.0 + (lambda + step) * k <= 0.0 {
                step *= 0.5;
            }
            lambda += step;
            // A step leaves 3/2·|c or K, over its factor|·step² at most, and rounding of z hides as much in λ.
            let bend = (c * across).abs().max((k * along).abs());
            if 1.5 * bend * step * step <= f64::EPSILON * (lambda.abs() + z.abs()) && bend * step.abs() <= 0.1 {
                break;
            }
        }
        Some(lambda)
    }

    /// The conic after a step in the seven parameters. A slide keeps the centre of curvature exactly where it is.
    pub fn moved(&self, step: &[f64; 8]) -> Conic {
        let (u, v) = self.across();
        let slide = step[SLIDE_U] * u + step[SLIDE_U + 1] * v;
        let tilt = self.c * slide;
        let n = tilt.length_squared().sqrt().hypot(1.0);
        let vertex = self.vertex
            + step[RISE] * self.axis
            + slide / n
            + self.axis * (self.c * slide.length_squared() / (n * (n + 1.0)));
        let axis = (self.axis - tilt) / n + step[TURN_U] * u + step[TURN_U + 1] * v;
        Conic { vertex, axis: axis.normalize_or(self.axis), c: self.c + step[CURVE], k: self.k + step[SHAPE] }
    }

    /// The same surface seen from its other pole, if it has one: an ellipsoid has the same c and k from both.
    pub fn other_pole(&self) -> Option<Conic> {
        let k = self.c * (1.0 + self.k);
        let far = 2.0 / k;
        (self.k > -1.0 && far.is_finite()).then(|| Conic {
            vertex: self.vertex + far * self.axis,
            axis: -self.axis,
            ..*self
        })
    }

    /// The same surface with c ≥ 0, so that the axis points from the vertex to the centre of curvature.
    pub fn towards_centre(self) -> Conic {
        if self.c < 0.0 { Conic { axis: -self.axis, c: -self.c, ..self } } else { self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tilted(c: f64, k: f64) -> Conic {
        Conic { vertex: DVec3::new(0.3, -0.2, 0.1), axis: DVec3::new(0.2, 0.3, 0.9).normalize(), c, k }
    }

    #[test]
    fn distance_to_a_sphere_is_the_closed_form() {
        let ball = tilted(0.5, 0.0);
        let centre = ball.vertex + ball.axis * 2.0;
        for p in [DVec3::new(3.0, 1.0, 0.5), DVec3::new(0.0, 0.1, 1.0), DVec3::new(-4.0, 9.0, 7.0)] {
            assert!((ball.distance(p) - (p.distance(centre) - 2.0)).abs() < 1e-13, "{}", ball.distance(p));
            assert!((ball.row(p)[7] - ball.distance(p)).abs() < 1e-13);
        }
    }

    #[test]
    fn distance_along_the_normal_is_what_was_walked() {
        for (c, k) in [(0.7, -2.2), (0.7, -1.0), (-0.4, 0.8), (0.3, -0.5), (1e-7, 3.0), (0.0, 0.0)] {
            let conic = tilted(c, k);
            let (u, _) = conic.across();
            let rho = 0.6;
            let z = c * rho * rho / (1.0 + (1.0 - c * c * (1.0 + k) * rho * rho).sqrt());
            let normal = (c * rho * u + (c * (1.0 + k) * z - 1.0) * conic.axis).normalize();
            for walk in [-0.2, 1e-8, 0.3] {
                let p = conic.vertex + rho * u + z * conic.axis + walk * normal;
                assert!((conic.distance(p) - walk).abs() < 1e-14, "c {c} k {k}: {} {walk}", conic.distance(p));
            }
        }
    }

    #[test]
    fn derivatives_are_differences() {
        let conic = tilted(0.6, -1.7);
        let p = conic.vertex + DVec3::new(0.5, 0.4, 0.35);
        let row = conic.row(p);
        for j in 0..7 {
            let h = 1e-6;
            let mut step = [0.0; 8];
            step[j] = h;
            let plus = conic.moved(&step).distance(p);
            step[j] = -h;
            let difference = (plus - conic.moved(&step).distance(p)) / (2.0 * h);
            assert!((row[j] - difference).abs() < 1e-9, "{j}: {} {difference}", row[j]);
        }
    }

    #[test]
    fn the_other_sheet_and_the_other_pole() {
        let conic = tilted(1.0, -3.0); // centre plane at z = 2/(2K) = −0.5
        let p = conic.vertex - 1.5 * conic.axis;
        assert!(conic.distance(p) >= 1.0);
        let egg = tilted(0.5, 0.3);
        let other = egg.other_pole().expect("an ellipsoid has two poles");
        let p = DVec3::new(1.0, 0.4, 0.9);
        assert!((egg.distance(p) - other.distance(p)).abs() < 1e-13);
        assert!(conic.other_pole().is_none() && tilted(0.0, 0.0).other_pole().is_none());
    }
}
