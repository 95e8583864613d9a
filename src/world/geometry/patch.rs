//! Which triangle a line passes through, so that no line slips between two triangles that share an edge.
//!
//! The test of S. Woop, C. Benthin and I. Wald ("Watertight ray/triangle intersection", JCGT 2(1), 2013) in f64: each
//! vertex is mapped to the plane across the line by the same operations whatever triangle asks, and the sign of
//! x₁y₂ − x₂y₁ in floating point is the true sign or zero (rounding is monotonic), bit-opposite for the two triangles at
//! an edge. Zero counts as inside for both.
//!
//! The same test trims exact surfaces: a point of the surface belongs to the triangle that the line through it, along
//! the axis or from the centre, passes through.

use super::exact::Quadric;
use glam::{DVec2, DVec3};

/// A direction prepared for the test: its largest component and the shear that turns it into that axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shear {
    pub axes: [usize; 3],
    pub shear: [f64; 3],
}

/// Where a line passes through a triangle.
#[derive(Debug, Clone, Copy)]
pub struct Crossing {
    /// Parameter along the direction.
    pub t: f64,
    /// Weights of the three vertices, their sum is 1.
    pub weights: [f64; 3],
}

impl Shear {
    #[inline(always)]
    pub fn along(dir: DVec3) -> Shear {
        // Numbers, not branches: which component is the largest is anybody's guess.
        const AXES: [[usize; 3]; 4] = [[1, 2, 0], [2, 0, 1], [0, 1, 2], [0, 1, 2]];
        let (a, b, c) = (dir.x.abs(), dir.y.abs(), dir.z.abs());
        let second = usize::from(a <= b);
        let last = usize::from(a <= c && b <= c);
        let axes = AXES[(second | last << 1) & 3];
        let d = [dir.x, dir.y, dir.z, 0.0];
        let (x, y, z) = (d[axes[0] & 3], d[axes[1] & 3], d[axes[2] & 3]);
        let inverse = 1.0 / z;
        Shear { axes, shear: [x * inverse, y * inverse, inverse] }
    }

    /// Coordinates of a point across the direction.
    #[inline]
    pub fn flatten(&self, p: DVec3) -> DVec2 {
        let p = p.to_array();
        let [x, y, z] = self.axes.map(|axis| p[axis]);
        DVec2::new(x - self.shear[0] * z, y - self.shear[1] * z)
    }

    /// Where the line through `through` in this direction passes through the triangle; both sides count, an edge-on
    /// triangle does not.
    #[inline]
    pub fn cross(&self, triangle: &[[f32; 3]; 3], through: DVec3) -> Option<Crossing> {
        let [kx, ky, kz] = self.axes;
        let [sx, sy, sz] = self.shear;
        let o = through.to_array();
        let map = |v: &[f32; 3]| {
            let z = f64::from(v[kz]) - o[kz];
            [(f64::from(v[kx]) - o[kx]) - sx * z, (f64::from(v[ky]) - o[ky]) - sy * z, z]
        };
        let [a, b, c] = [map(&triangle[0]), map(&triangle[1]), map(&triangle[2])];
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let sum = u + v + w;
        let inverse = 1.0 / sum;
        let t = (u * a[2] + v * b[2] + w * c[2]) * sz * inverse;
        // Edge-on and invalid triangles end here too.
        t.is_finite().then_some(Crossing { t, weights: [u * inverse, v * inverse, w * inverse] })
    }
}

/// The point with these weights on a triangle.
#[inline(always)]
pub fn point_on(triangle: &[[f32; 3]; 3], weights: [f64; 3]) -> DVec3 {
    let [a, b, c] = [vertex(triangle[0]), vertex(triangle[1]), vertex(triangle[2])];
    a * weights[0] + b * weights[1] + c * weights[2]
}

/// A mesh vertex in f64.
#[inline(always)]
pub fn vertex(v: [f32; 3]) -> DVec3 {
    DVec3::new(f64::from(v[0]), f64::from(v[1]), f64::from(v[2]))
}

/// The lines that share out an exact surface among the triangles of its face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Projection {
    /// Along the axis: the patch is a height field.
    Axial(Shear),
    /// From the centre of an ellipsoid or sphere: the patch reaches to its equator or beyond.
    Central(DVec3),
}

impl Projection {
    /// Height fields keep away from the equator, where a line along the axis grazes the surface: at 0.25 the slope is
    /// at most √3 and mesh vertices off the surface still have a place on it. The height field is preferred because
    /// its patches end at the walls of a lens that runs along the axis.
    const MARGIN: f64 = 0.25;

    /// The projection for a face with these vertices; none if they are on a sheet that the shape does not mean.
    pub fn choose(quadric: &Quadric, vertices: impl Iterator<Item = DVec3>) -> Option<Projection> {
        let (mut height_field, mut on_sheet) = (true, true);
        for p in vertices {
            let w = p - quadric.vertex;
            let z = w.dot(quadric.axis);
            let branch = quadric.branch(p);
            on_sheet &= branch > 0.0;
            height_field &= branch > Self::MARGIN;
            height_field &= quadric.under_root(w.length_squared() - z * z) > Self::MARGIN;
        }
        if height_field {
            return Some(Projection::Axial(Shear::along(quadric.axis)));
        }
        match quadric.ellipsoid() {
            Some((centre, _)) => Some(Projection::Central(centre)),
            // A paraboloid or hyperboloid is a height field wherever it is.
            None => on_sheet.then(|| Projection::Axial(Shear::along(quadric.axis))),
        }
    }
}
