//! Planes, spheres and conics as one kind of surface, and their exact intersection with a ray.
//!
//! With w = p − vertex and z = w·axis, each of these [`Shape`]s is a part of c (w·w + k z²) − 2 z = 0 (c = 1/radius):
//! the sag formula of `design/formulas.md` section 4 solved for the square root. A plane is c = 0, a sphere k = 0.

use eyebox_scene::Shape;
use glam::DVec3;

/// A quadric of revolution about `axis` through `vertex`, in the units of the shape it was made from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quadric {
    pub vertex: DVec3,
    /// Unit.
    pub axis: DVec3,
    /// 1/radius; the centre of curvature is at `vertex + axis/curvature`.
    pub curvature: f64,
    pub conic: f64,
}

impl Quadric {
    /// The surface of a shape; none for other shapes and for parameters that describe no surface (a zero axis or
    /// radius, a value that is not finite). An infinite radius is a plane.
    pub fn from_shape(shape: &Shape) -> Option<Quadric> {
        let (vertex, axis, curvature, conic) = match *shape {
            Shape::Mesh
            | Shape::Asphere { .. }
            | Shape::Cylinder { .. }
            | Shape::Toroid { .. }
            | Shape::XyPoly { .. }
            | Shape::Zernike { .. }
            | Shape::Bspline { .. } => return None,
            Shape::Plane { vertex, axis } => (vertex, axis, 0.0, 0.0),
            Shape::Sphere { vertex, axis, radius } => (vertex, axis, 1.0 / radius, 0.0),
            Shape::Conic { vertex, axis, radius, conic } => (vertex, axis, 1.0 / radius, conic),
        };
        let axis = axis.try_normalize()?;
        (vertex.is_finite() && curvature.is_finite() && conic.is_finite()).then_some(Quadric {
            vertex,
            axis,
            curvature,
            conic,
        })
    }

    /// Parameters t of the two points origin + t·dir on the surface, ascending; a missing one is `f64::INFINITY`.
    /// Both sheets of a hyperboloid and the far side of an ellipsoid count: see [`Quadric::branch`].
    ///
    /// `from_surface` says that the origin lies on the surface: that root is divided out, so the other one is exact
    /// however near it is, and comes first.
    ///
    /// The roots come from q = −(b + sign(b) √disc), t = q/a and c/q, which do not cancel (Press et al., Numerical
    /// Recipes, section 5.6); the origin is first moved to the point of the ray that is closest to the vertex, where
    /// the constant term is as small as the surface's sag and a distant origin costs no digits.
    pub fn intersect(&self, origin: DVec3, dir: DVec3, from_surface: bool) -> [f64; 2] {
        let dz = dir.dot(self.axis);
        let dd = dir.length_squared();
        let a = self.curvature * (dd + self.conic * dz * dz);
        let mut w = origin - self.vertex;
        if from_surface {
            let b = self.curvature * (w.dot(dir) + self.conic * w.dot(self.axis) * dz) - dz;
            return [finite(-2.0 * b / a), f64::INFINITY];
        }
        let shift = -w.dot(dir) / dd;
        w += shift * dir;
        let z = w.dot(self.axis);
        let b = self.curvature * (w.dot(dir) + self.conic * z * dz) - dz;
        let c = self.curvature * (w.length_squared() + self.conic * z * z) - 2.0 * z;
        let disc = b * b - a * c;
        let q = -(b + disc.sqrt().copysign(b));
        // A negative or invalid discriminant makes q invalid, and then both roots.
        let (one, two) = if q == 0.0 { (shift + q / a, f64::INFINITY) } else { (shift + q / a, shift + c / q) };
        let (one, two) = (finite(one), finite(two));
        if one <= two { [one, two] } else { [two, one] }
    }

    /// Unit normal at a point of the surface; it is `axis` at the vertex and continuous over the sheet.
    pub fn normal(&self, p: DVec3) -> DVec3 {
        self.gradient(p).normalize_or(self.axis)
    }

    /// −½ ∇ of the equation.
    fn gradient(&self, p: DVec3) -> DVec3 {
        let w = p - self.vertex;
        self.axis - self.curvature * (w + self.conic * w.dot(self.axis) * self.axis)
    }

    /// The point of the surface nearest to one that is off by rounding.
    pub fn settle(&self, p: DVec3) -> DVec3 {
        let w = p - self.vertex;
        let z = w.dot(self.axis);
        let value = self.curvature * (w.length_squared() + self.conic * z * z) - 2.0 * z;
        let g = self.gradient(p);
        let settled = p + g * (0.5 * value / g.length_squared());
        if settled.is_finite() { settled } else { p }
    }

    /// 1 − (1+k) c z: positive on the half that contains the vertex, where the surface is a height field over the
    /// plane of the vertex.
    pub fn branch(&self, p: DVec3) -> f64 {
        1.0 - (1.0 + self.conic) * self.curvature * (p - self.vertex).dot(self.axis)
    }

    /// Distance of a point from the surface to first order. Not finite where the equation has no gradient.
    pub fn distance(&self, p: DVec3) -> f64 {
        let w = p - self.vertex;
        let z = w.dot(self.axis);
        let value = self.curvature * (w.length_squared() + self.conic * z * z) - 2.0 * z;
        0.5 * value.abs() / self.gradient(p).length()
    }

    /// 1 − (1+k) c² r², the term under the root of the sag, r from the axis.
    pub fn under_root(&self, r_squared: f64) -> f64 {
        1.0 - (1.0 + self.conic) * self.curvature * self.curvature * r_squared
    }

    /// Height over the plane of the vertex at the distance r from the axis.
    pub fn sag(&self, r_squared: f64) -> f64 {
        self.curvature * r_squared / (1.0 + self.under_root(r_squared).max(0.0).sqrt())
    }

    /// Middle of an ellipsoid or sphere and its semi-axes [along the axis, across]; none for open surfaces.
    pub fn ellipsoid(&self) -> Option<(DVec3, [f64; 2])> {
        let open = 1.0 + self.conic;
        if self.curvature == 0.0 || open <= 0.0 {
            return None;
        }
        let along = 1.0 / (open * self.curvature);
        Some((self.vertex + along * self.axis, [along.abs(), 1.0 / (self.curvature.abs() * open.sqrt())]))
    }
}

fn finite(t: f64) -> f64 {
    if t.is_finite() { t } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyebox_base::rng::{Rng, Stream};
    use eyebox_base::warp;

    fn conic(radius: f64, conic: f64) -> Quadric {
        let shape = Shape::Conic { vertex: DVec3::new(1.0, -2.0, 3.0), axis: DVec3::Z, radius, conic };
        Quadric::from_shape(&shape).unwrap()
    }

    #[test]
    fn every_root_satisfies_the_sag_formula() {
        let mut rng = Rng::new(1, Stream::Check, 0, 0);
        let mut seen = 0;
        for (radius, k) in [(50.0, 0.0), (-20.0, -0.6), (30.0, -1.0), (-40.0, -2.5), (25.0, 0.8), (f64::INFINITY, 0.0)]
        {
            let surface = conic(radius, k);
            for _ in 0..2000 {
                let aim = surface.vertex + DVec3::new(rng.uniform() - 0.5, rng.uniform() - 0.5, 0.0) * 20.0;
                let dir = warp::sphere(rng.pair());
                let distance = 10f64.powf(4.0 * rng.uniform());
                let origin = aim - dir * distance;
                for t in surface.intersect(origin, dir, false) {
                    let p = origin + t * dir;
                    if t.is_finite() && surface.branch(p) > 1e-3 && (p - aim).length() < 1e3 {
                        let w = p - surface.vertex;
                        let sag = surface.sag(w.x * w.x + w.y * w.y);
                        let slope = 1.0 / surface.normal(p).z.abs();
                        assert!(
                            (w.z - sag).abs() < 2e-15 * distance.max(100.0) * slope * 20.0,
                            "{radius} {k} {}",
                            w.z - sag
                        );
                        seen += 1;
                    }
                }
            }
        }
        assert!(seen > 10_000, "{seen}");
    }

    #[test]
    fn the_chord_of_a_ball_is_exact_down_to_grazing() {
        let ball = Quadric::from_shape(&Shape::Sphere { vertex: DVec3::ZERO, axis: DVec3::Z, radius: 2.0 }).unwrap();
        for cos in [0.9, 0.1, 1e-3, 1e-5, 1e-7, 1e-9] {
            // Start at the vertex, whose inward normal is +z: the chord is 2 R cos.
            let dir = DVec3::new((1.0f64 - cos * cos).sqrt(), 0.0, cos);
            let [t, _] = ball.intersect(DVec3::ZERO, dir, true);
            assert!((t / (4.0 * cos) - 1.0).abs() < 1e-12, "{cos}: {t}");
        }
        // Outwards there is nothing ahead; on a plane there is no second root.
        assert!(ball.intersect(DVec3::ZERO, -DVec3::Z, true)[0] < 0.0);
        let plane = Quadric::from_shape(&Shape::Plane { vertex: DVec3::ZERO, axis: DVec3::Z }).unwrap();
        assert_eq!(plane.intersect(DVec3::ZERO, DVec3::Z, true), [f64::INFINITY; 2]);
    }

    #[test]
    fn hostile_numbers_give_no_roots() {
        let plane = Quadric::from_shape(&Shape::Plane { vertex: DVec3::ZERO, axis: DVec3::Z }).unwrap();
        for (origin, dir) in [
            (DVec3::splat(f64::NAN), DVec3::Z),
            (DVec3::ZERO, DVec3::ZERO),
            (DVec3::Z, DVec3::X),
            (DVec3::ZERO, DVec3::splat(f64::INFINITY)),
        ] {
            assert_eq!(plane.intersect(origin, dir, false), [f64::INFINITY; 2], "{origin} {dir}");
        }
        assert_eq!(Quadric::from_shape(&Shape::Sphere { vertex: DVec3::ZERO, axis: DVec3::Z, radius: 0.0 }), None);
        assert_eq!(Quadric::from_shape(&Shape::Plane { vertex: DVec3::ZERO, axis: DVec3::ZERO }), None);
    }
}
