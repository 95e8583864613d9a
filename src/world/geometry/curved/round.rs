//! Cylinders and tori as whole surfaces, however far they reach around their axis.

use super::Gradient;
use super::isolate::{Bent, roots};
use super::number::{Num, Series};
use super::sag::Frame;
use glam::{DMat3, DVec3};
use std::ops::ControlFlow;

/// A cylinder through the vertex, straight along the frame's x: c (y² + z²) − 2 z = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cylinder {
    pub frame: Frame,
    pub curvature: f64,
}

impl Cylinder {
    /// As [`Quadric::intersect`](crate::geometry::exact::Quadric::intersect), of which this is the equation
    /// across x.
    pub fn intersect(&self, origin: DVec3, dir: DVec3, from_surface: bool) -> [f64; 2] {
        let (w, d) = (self.frame.local(origin), self.frame.turned(dir));
        let (mut w, d) = (w.truncate_x(), d.truncate_x());
        let dd = d.length_squared();
        let a = self.curvature * dd;
        if from_surface {
            let b = self.curvature * w.dot(d) - d.y;
            return [finite(-2.0 * b / a), f64::INFINITY];
        }
        let shift = -w.dot(d) / dd;
        w += shift * d;
        let b = self.curvature * w.dot(d) - d.y;
        let c = self.curvature * w.length_squared() - 2.0 * w.y;
        let q = -(b + (b * b - a * c).sqrt().copysign(b));
        let (one, two) = if q == 0.0 { (shift + q / a, f64::INFINITY) } else { (shift + q / a, shift + c / q) };
        let (one, two) = (finite(one), finite(two));
        if one <= two { [one, two] } else { [two, one] }
    }

    /// Signed distance, positive on the side of the axis: (2z − c(y² + z²))/(1 + √((1 − cz)² + c²y²)), which has no
    /// cancellation where the radius is long.
    fn signed(&self, p: DVec3) -> f64 {
        let q = self.frame.local(p);
        signed_circle(self.curvature, q.y, q.z)
    }

    pub fn distance(&self, p: DVec3) -> f64 {
        self.signed(p).abs()
    }

    /// Unit normal; it is `axis` at the vertex.
    pub fn normal(&self, p: DVec3) -> DVec3 {
        let q = self.frame.local(p);
        let n = DVec3::new(0.0, -self.curvature * q.y, 1.0 - self.curvature * q.z);
        self.frame.back(n).normalize_or(self.frame.axis)
    }

    /// (0, −c y, 1 − c z) in the frame, which changes by −c (0, dy, dz).
    pub fn gradient(&self, p: DVec3) -> Gradient {
        let q = self.frame.local(p);
        let c = self.curvature;
        let vector = self.frame.back(DVec3::new(0.0, -c * q.y, 1.0 - c * q.z));
        let turn = self.frame.turn();
        Gradient { vector, change: turn * DMat3::from_diagonal(DVec3::new(0.0, -c, -c)) * turn.transpose() }
    }

    pub fn settle(&self, p: DVec3) -> DVec3 {
        let settled = p - self.signed(p) * self.normal(p);
        if settled.is_finite() { settled } else { p }
    }

    /// 1 − c z: positive on the half that contains the vertex.
    pub fn branch(&self, p: DVec3) -> f64 {
        1.0 - self.curvature * self.frame.local(p).z
    }

    /// The point of the axis nearest to p.
    pub fn foot(&self, p: DVec3) -> DVec3 {
        let q = self.frame.local(p);
        self.frame.vertex + self.frame.back(DVec3::new(q.x, 0.0, 1.0 / self.curvature))
    }
}

/// Signed distance of (y, z) from the circle of curvature c that touches the line z = 0 at the origin.
pub fn signed_circle(c: f64, y: f64, z: f64) -> f64 {
    let lift = 1.0 - c * z;
    (2.0 * z - c * (y * y + z * z)) / (1.0 + (lift * lift + c * c * y * y).sqrt())
}

trait TruncateX {
    fn truncate_x(self) -> glam::DVec2;
}
impl TruncateX for DVec3 {
    /// (y, z).
    fn truncate_x(self) -> glam::DVec2 {
        glam::DVec2::new(self.y, self.z)
    }
}

/// A ring torus: a circle of radius |1/tube| in the frame's x–z plane through the vertex, turned about the line along x
/// through vertex + axis/curvature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Torus {
    pub frame: Frame,
    /// Signed: the axis of revolution is at vertex + radius·axis, the circle's centre at vertex + tube·axis.
    pub radius: f64,
    pub tube: f64,
}

impl Torus {
    /// None if the tube is not thinner than the ring: then the sheets cross.
    pub fn new(frame: Frame, radius: f64, tube: f64) -> Option<Torus> {
        ((radius - tube).abs() > tube.abs()).then_some(Torus { frame, radius, tube })
    }

    pub fn ring(&self) -> f64 {
        (self.radius - self.tube).abs()
    }

    /// About the centre: x along the axis of revolution.
    fn central(&self, p: DVec3) -> DVec3 {
        self.frame.local(p) - DVec3::new(0.0, 0.0, self.radius)
    }

    fn middle(&self) -> DVec3 {
        self.frame.vertex + self.radius * self.frame.axis
    }

    pub fn foot(&self, p: DVec3) -> DVec3 {
        let q = self.central(p);
        let around = DVec3::new(0.0, q.y, q.z).normalize_or(DVec3::NEG_Z);
        self.middle() + self.frame.back(self.ring() * around)
    }

    pub fn distance(&self, p: DVec3) -> f64 {
        ((p - self.foot(p)).length() - self.tube.abs()).abs()
    }

    /// Unit normal away from the tube's middle, turned so that it is `axis` at the vertex.
    pub fn normal(&self, p: DVec3) -> DVec3 {
        (p - self.foot(p)).normalize_or(self.frame.axis) * -self.tube.signum()
    }

    /// The way from the tube's middle, which moves with the point around the ring.
    pub fn gradient(&self, p: DVec3) -> Gradient {
        let q = self.central(p);
        let across = q.y.hypot(q.z);
        let around = DVec3::new(0.0, q.y, q.z) / across;
        // Along the ring's tangent alone the middle moves, by ring/across of what the point does.
        let tangent = DVec3::new(0.0, -around.z, around.y);
        let share = self.ring() / across;
        let moves = DMat3::from_cols(tangent * tangent.x, tangent * tangent.y, tangent * tangent.z) * share;
        let sign = -self.tube.signum();
        let turn = self.frame.turn();
        let change = turn * (DMat3::IDENTITY - moves) * turn.transpose() * sign;
        Gradient { vector: (p - self.foot(p)) * sign, change }
    }

    pub fn settle(&self, p: DVec3) -> DVec3 {
        let foot = self.foot(p);
        foot + (p - foot).normalize_or(self.frame.axis) * self.tube.abs()
    }

    /// Largest curvature.
    pub fn sharpest(&self) -> f64 {
        (1.0 / self.tube.abs()).max(1.0 / (self.ring() - self.tube.abs()))
    }

    /// Radius of the ball around it.
    pub fn size(&self) -> f64 {
        self.ring() + self.tube.abs()
    }

    /// As [`Sag::along`](super::sag::Sag::along), on the whole torus.
    pub fn along(
        &self,
        origin: DVec3,
        dir: DVec3,
        from_surface: bool,
        reach: f64,
        visit: &mut impl FnMut(f64, DVec3) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let size = self.size();
        let (o, d) = (self.central(origin) / size, self.frame.turned(dir));
        let shift = -o.dot(d) / d.length_squared();
        let half = (1.0 + 1e-9 - (o + shift * d).length_squared()).sqrt();
        if half.is_nan() {
            return ControlFlow::Continue(());
        }
        // What is searched does not depend on the reach: see `Sag::along`.
        let mut met = |t: f64, at: DVec3| match t > 0.0 {
            true if t >= reach => ControlFlow::Break(()),
            true => visit(t, at),
            false => ControlFlow::Continue(()),
        };
        let (near, far) = ((shift - half).max(0.0), shift + half);
        if near * size >= reach {
            return ControlFlow::Continue(());
        }
        let (ring, tube) = (self.ring() / size, self.tube.abs() / size);
        // Within the unit ball: see `Quartic::of` for the derivatives' bounds.
        if from_surface {
            let ray = Quartic { o, d, ring, tube, start: Some(o), bend: 32.0 };
            return roots(&ray, near, far, &mut |t| met(t * size, origin + t * size * dir));
        }
        let base = origin + near * size * dir;
        let ray = Quartic { o: self.central(base) / size, d, ring, tube, start: None, bend: 32.0 };
        roots(&ray, 0.0, far - near, &mut |s| met((near + s) * size, base + s * size * dir))
    }
}

/// (|p|² + R² − r²)² − 4R² ρ² along a line, ρ the distance from the axis, in a ball of radius 1; over t for a line that
/// starts on the surface. With |p|, R, r ≤ 1 the second derivative is at most 2·2²+2·2·2+8 < 32, and that of the
/// quotient less (the third derivative is at most 24, and a third of it counts).
struct Quartic {
    o: DVec3,
    d: DVec3,
    ring: f64,
    tube: f64,
    start: Option<DVec3>,
    bend: f64,
}

impl Quartic {
    fn value<T: Num>(&self, x: T, y: T, z: T) -> T {
        let across = y.square() + z.square();
        let sum = (x.square() + across).plus((self.ring - self.tube) * (self.ring + self.tube));
        sum.square() - across.times(4.0 * self.ring * self.ring)
    }
}

impl Bent for Quartic {
    fn at(&self, t: f64) -> (f64, f64) {
        let p = self.o + t * self.d;
        match self.start {
            None => {
                let line = |k: usize| Series([p[k], self.d[k]]);
                let [value, slope] = self.value(line(0), line(1), line(2)).0;
                (value, slope)
            }
            Some(o) => {
                let line = |k: usize| super::number::Slope {
                    start: o[k],
                    at: Series([p[k], self.d[k]]),
                    slope: Series([self.d[k], 0.0]),
                };
                let [value, slope] = self.value(line(0), line(1), line(2)).slope.0;
                (value, slope)
            }
        }
    }
    fn bend(&self) -> f64 {
        self.bend
    }
    fn noise(&self) -> f64 {
        16.0 * f64::EPSILON
    }
    fn grain(&self, t: f64) -> f64 {
        match self.start {
            None => 0.25 * f64::EPSILON * (1.0 + t.abs()),
            Some(_) => f64::EPSILON * t.abs(),
        }
    }
}

fn finite(t: f64) -> f64 {
    if t.is_finite() { t } else { f64::INFINITY }
}
