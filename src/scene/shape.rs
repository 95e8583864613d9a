//! The exact surface that a meshed face approximates; the mesh says where it ends.

use glam::DVec3;

/// Exact surface of a face, in mesh units.
///
/// `axis` is a unit vector; radius > 0 puts the centre of curvature at `vertex + radius * axis`. The sag along `axis`
/// is `c r²/(1 + sqrt(1 − (1+k) c² r²))`, c = 1/radius (`design/formulas.md` section 4).
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
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
}
