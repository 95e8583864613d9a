//! Boxes that contain what a triangle stands for: the triangle, or the patch of an exact surface that it trims.

use super::exact::Quadric;
use super::patch::{Projection, Shear, vertex};
use glam::{DAffine3, DVec3};

/// An axis-aligned box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    pub lo: DVec3,
    pub hi: DVec3,
}

impl Bounds {
    pub const EMPTY: Bounds = Bounds { lo: DVec3::INFINITY, hi: DVec3::NEG_INFINITY };

    pub fn of(points: impl IntoIterator<Item = DVec3>) -> Bounds {
        points.into_iter().fold(Bounds::EMPTY, |b, p| Bounds { lo: b.lo.min(p), hi: b.hi.max(p) })
    }
    pub fn join(self, other: Bounds) -> Bounds {
        Bounds { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }
    /// What both contain: meant for boxes that are known to contain the same thing.
    fn meet(self, other: Bounds) -> Bounds {
        Bounds { lo: self.lo.max(other.lo), hi: self.hi.min(other.hi) }
    }
    pub fn widen(self, by: DVec3) -> Bounds {
        Bounds { lo: self.lo - by, hi: self.hi + by }
    }
    /// Whether another comes within `reach` of this one.
    pub fn comes_near(self, other: Bounds, reach: f64) -> bool {
        let around = self.widen(DVec3::splat(reach));
        around.lo.cmple(other.hi).all() && other.lo.cmple(around.hi).all()
    }
    pub fn centre(self) -> DVec3 {
        0.5 * self.lo + 0.5 * self.hi
    }
    pub fn half(self) -> DVec3 {
        0.5 * self.hi - 0.5 * self.lo
    }
    /// Largest coordinate in size.
    pub fn reach(self) -> f64 {
        self.lo.abs().max(self.hi.abs()).max_element()
    }
    #[inline(always)]
    pub fn contains(self, p: DVec3) -> bool {
        p.cmpge(self.lo).all() && p.cmple(self.hi).all()
    }
    pub fn is_finite(self) -> bool {
        self.lo.is_finite() && self.hi.is_finite()
    }
    /// The box around the image of this box.
    pub fn map(self, by: &DAffine3) -> Bounds {
        let half = self.half();
        let m = by.matrix3;
        let spread = m.x_axis.abs() * half.x + m.y_axis.abs() * half.y + m.z_axis.abs() * half.z;
        let centre = by.transform_point3(self.centre());
        Bounds { lo: centre - spread, hi: centre + spread }
    }
    /// Where the ray enters the box, 0 inside.
    #[inline(always)]
    pub fn enter(&self, origin: DVec3, dir: DVec3) -> Option<f64> {
        // A ray that starts inside, as most do, needs no inverse.
        if self.contains(origin) { Some(0.0) } else { self.clip(origin, dir.recip()).map(|(near, _)| near) }
    }
    /// Parameters between which the ray is inside, if it ever is. `inverse` is 1/direction per component.
    #[inline]
    pub fn clip(&self, origin: DVec3, inverse: DVec3) -> Option<(f64, f64)> {
        let (mut near, mut far) = (0.0f64, f64::INFINITY);
        for (lo, hi, o, i) in [
            (self.lo.x, self.hi.x, origin.x, inverse.x),
            (self.lo.y, self.hi.y, origin.y, inverse.y),
            (self.lo.z, self.hi.z, origin.z, inverse.z),
        ] {
            // Plain comparisons are one instruction each. 0·∞ is not a number only for a ray in the plane of a side,
            // and boxes are wider than what they contain.
            let (one, two) = ((lo - o) * i, (hi - o) * i);
            let (first, last) = if one < two { (one, two) } else { (two, one) };
            near = if first > near { first } else { near };
            far = if last < far { last } else { far };
        }
        (near <= far).then_some((near, far))
    }
}

/// The box of a triangle itself.
pub fn triangle_box(triangle: &[[f32; 3]; 3]) -> Bounds {
    Bounds::of(triangle.map(vertex))
}

/// The box of the patch of `quadric` that `projection` gives to a triangle.
pub fn patch_box(triangle: &[[f32; 3]; 3], quadric: &Quadric, projection: &Projection) -> Bounds {
    match projection {
        Projection::Axial(shear) => height_field_box(triangle, quadric, shear),
        Projection::Central(_) => ellipsoid_box(triangle, quadric),
    }
}

/// Two boxes contain the patch, so their overlap does. One follows the surface: interpolating a height linearly over a
/// triangle whose longest edge is h errs by at most M h²/6, M the largest second derivative (S. Waldron, SIAM J. Numer.
/// Anal. 35, 1998); here M = c·max(1, w^(−3/2)) with w = 1 − (1+k) c² r² at the largest r. The other takes the range of
/// the sag over the triangle's distances from the axis.
fn height_field_box(triangle: &[[f32; 3]; 3], quadric: &Quadric, shear: &Shear) -> Bounds {
    let axis = quadric.axis;
    // Feet of the vertices in the plane of the vertex, relative to it.
    let feet = triangle.map(|v| {
        let w = vertex(v) - quadric.vertex;
        w - w.dot(axis) * axis
    });
    let r2 = feet.map(|f| f.length_squared());
    let far = r2[0].max(r2[1]).max(r2[2]);
    let inside = shear.cross(triangle, quadric.vertex).is_some();
    let near =
        if inside { 0.0 } else { (0..3).map(|i| nearest_squared(feet[i], feet[(i + 1) % 3])).fold(far, f64::min) };
    let w = quadric.under_root(far);
    if w <= 0.0 || w.is_nan() {
        return Bounds::EMPTY;
    }
    let edge2 = (0..3).map(|i| feet[i].distance_squared(feet[(i + 1) % 3])).fold(0.0, f64::max);
    let error = quadric.curvature.abs() * w.powf(-1.5).max(1.0) * edge2 / 6.0;
    let on_surface = [0, 1, 2].map(|i| quadric.vertex + feet[i] + quadric.sag(r2[i]) * axis);
    let followed = Bounds::of(on_surface).widen(error * axis.abs());
    let heights = [quadric.sag(near), quadric.sag(far)];
    let spanned = Bounds::of(feet.iter().flat_map(|f| heights.map(|z| quadric.vertex + *f + z * axis)));
    let slack = DVec3::splat(1e-12 * followed.reach());
    followed.widen(slack).meet(spanned.widen(slack))
}

/// The map that makes the ellipsoid the unit sphere keeps lines through the centre. There the patch lies within
/// 1 − √(1 − h²/3) of the flat triangle between the projected vertices (h its longest edge, its circle's radius ≤ h/√3).
fn ellipsoid_box(triangle: &[[f32; 3]; 3], quadric: &Quadric) -> Bounds {
    let Some((centre, [along, across])) = quadric.ellipsoid() else { return Bounds::EMPTY };
    let axis = quadric.axis;
    let stretch = |w: DVec3, by_axis: f64, by_rest: f64| by_rest * w + (by_axis - by_rest) * w.dot(axis) * axis;
    let unit = triangle.map(|v| stretch(vertex(v) - centre, 1.0 / along, 1.0 / across).normalize_or_zero());
    let edge2 = (0..3).map(|i| unit[i].distance_squared(unit[(i + 1) % 3])).fold(0.0, f64::max);
    let valid = unit.iter().all(|u| *u != DVec3::ZERO) && edge2 < 3.0;
    let pad = if valid { 1.0 - (1.0 - edge2 / 3.0).sqrt() } else { 2.0 };
    let largest = along.max(across);
    let patch = Bounds::of(unit.map(|u| centre + stretch(u, along, across)));
    let whole = Bounds { lo: centre - DVec3::splat(largest), hi: centre + DVec3::splat(largest) };
    let slack = DVec3::splat(1e-12 * whole.reach());
    patch.widen(DVec3::splat(pad * largest)).widen(slack).meet(whole.widen(slack))
}

/// Squared distance of the origin from the segment between two points.
fn nearest_squared(a: DVec3, b: DVec3) -> f64 {
    let along = b - a;
    let t = (-a.dot(along) / along.length_squared()).clamp(0.0, 1.0);
    let p = if t.is_finite() { a + t * along } else { a };
    p.length_squared()
}
