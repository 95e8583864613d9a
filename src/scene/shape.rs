//! The exact surface that a meshed face approximates; the mesh says where it ends.

use glam::{DAffine3, DVec3};

/// Exact surface of a face, in mesh units.
///
/// `axis` is a unit vector, the normal at `vertex` (of the surface without its polynomial); radius > 0 puts the centre
/// of curvature at `vertex + radius * axis`. The sag along `axis` is `c r²/(1 + sqrt(1 − (1+k) c² r²))`, c = 1/radius
/// (`design/formulas.md` section 4). `x` is a unit vector at right angles to `axis`, and y = axis × x.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum Shape {
    /// The triangles themselves, shaded with the vertex normals.
    Mesh,
    Plane {
        vertex: DVec3,
        axis: DVec3,
    },
    Sphere {
        vertex: DVec3,
        axis: DVec3,
        radius: f64,
    },
    Conic {
        vertex: DVec3,
        axis: DVec3,
        radius: f64,
        conic: f64,
    },
    /// Sag of the conic + `even[0]` r² + `even[1]` r⁴ + …
    Asphere {
        vertex: DVec3,
        axis: DVec3,
        radius: f64,
        conic: f64,
        even: Vec<f64>,
    },
    /// Straight along x; its axis of revolution is the line along x through `vertex + radius * axis`.
    Cylinder {
        vertex: DVec3,
        axis: DVec3,
        x: DVec3,
        radius: f64,
    },
    /// A circle of radius `tube_radius` in the plane of x and `axis`, its centre at `vertex + tube_radius * axis`, turned
    /// about the line along x through `vertex + radius * axis`. Both radii are signed; a cylinder is the toroid of an
    /// infinite `tube_radius`.
    Toroid {
        vertex: DVec3,
        axis: DVec3,
        x: DVec3,
        radius: f64,
        tube_radius: f64,
    },
    /// Sag of the conic + Σ `coeffs[d(d+1)/2 + j]` x^(d−j) y^j: 1, x, y, x², xy, y², x³, x²y, …
    XyPoly {
        vertex: DVec3,
        axis: DVec3,
        x: DVec3,
        radius: f64,
        conic: f64,
        coeffs: Vec<f64>,
    },
    /// Sag of the conic + Σ `coeffs[(n(n+2) + m)/2]` N R_n^|m|(r/norm_radius) cos(mφ), sin(|m|φ) for m < 0, with
    /// N = sqrt((2n+2)/(1+δ_m0)) and φ from x towards y (OSA/ANSI order and norm).
    Zernike {
        vertex: DVec3,
        axis: DVec3,
        x: DVec3,
        radius: f64,
        conic: f64,
        norm_radius: f64,
        coeffs: Vec<f64>,
    },
    /// Sag of the conic + Σ `coeffs[i (spans[1] + 3) + j]` B_i(x) B_j(y), uniform cubic B-splines whose knots divide the
    /// rectangle from −half to half into `spans` along x and y.
    Bspline {
        vertex: DVec3,
        axis: DVec3,
        x: DVec3,
        radius: f64,
        conic: f64,
        half: [f64; 2],
        spans: [u32; 2],
        coeffs: Vec<f64>,
    },
}

impl Shape {
    /// The x direction of a surface for which none is given: the mesh's +x laid at right angles to the unit vector
    /// `axis`, its +y where the axis is within 25.8° of x (|axis·x| > 0.9).
    pub fn default_x(axis: DVec3) -> DVec3 {
        let towards = if axis.x.abs() > 0.9 { DVec3::Y } else { DVec3::X };
        (towards - towards.dot(axis) * axis).normalize_or(towards)
    }

    /// The surface after a rigid motion of mesh units.
    #[must_use]
    pub fn moved(&self, motion: &DAffine3) -> Shape {
        let mut out = self.clone();
        match &mut out {
            Shape::Mesh => {}
            Shape::Plane { vertex, axis }
            | Shape::Sphere { vertex, axis, .. }
            | Shape::Conic { vertex, axis, .. }
            | Shape::Asphere { vertex, axis, .. } => {
                *vertex = motion.transform_point3(*vertex);
                *axis = motion.transform_vector3(*axis).normalize_or(*axis);
            }
            Shape::Cylinder { vertex, axis, x, .. }
            | Shape::Toroid { vertex, axis, x, .. }
            | Shape::XyPoly { vertex, axis, x, .. }
            | Shape::Bspline { vertex, axis, x, .. }
            | Shape::Zernike { vertex, axis, x, .. } => {
                *vertex = motion.transform_point3(*vertex);
                *axis = motion.transform_vector3(*axis).normalize_or(*axis);
                let turned = motion.transform_vector3(*x);
                // At right angles to the last digit.
                *x = (turned - turned.dot(*axis) * *axis).normalize_or(*x);
            }
        }
        out
    }

    /// The surface with all of its radii `factor` times as large, through the same vertex; none of what has no radius. The
    /// polynomial over a conic stays what it is.
    pub fn with_radius(&self, factor: f64) -> Option<Shape> {
        let mut out = self.clone();
        match &mut out {
            Shape::Mesh | Shape::Plane { .. } => return None,
            Shape::Sphere { radius, .. }
            | Shape::Conic { radius, .. }
            | Shape::Asphere { radius, .. }
            | Shape::Cylinder { radius, .. }
            | Shape::XyPoly { radius, .. }
            | Shape::Bspline { radius, .. }
            | Shape::Zernike { radius, .. } => *radius *= factor,
            Shape::Toroid { radius, tube_radius, .. } => {
                *radius *= factor;
                *tube_radius *= factor;
            }
        }
        Some(out)
    }
}
