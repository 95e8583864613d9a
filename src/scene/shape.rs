//! The exact surface that a meshed face approximates; the mesh says where it ends.

use glam::DVec3;

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
}

impl Shape {
    /// The x direction of a surface for which none is given: the mesh's +x laid at right angles to the unit vector
    /// `axis`, its +y where the axis is within 25.8° of x (|axis·x| > 0.9).
    pub fn default_x(axis: DVec3) -> DVec3 {
        let towards = if axis.x.abs() > 0.9 { DVec3::Y } else { DVec3::X };
        (towards - towards.dot(axis) * axis).normalize_or(towards)
    }
}
