//! A triangle of a mesh as it is packed and traced.

use super::patch::vertex;
use glam::DVec3;

#[derive(Debug, Clone, Copy)]
pub struct Triangle {
    pub corners: [[f32; 3]; 3],
    /// Face of the part.
    pub face: u32,
    /// Triangle of the mesh.
    pub index: u32,
}

/// Twice the area times the normal that the winding gives.
#[inline(always)]
pub fn winding(corners: &[[f32; 3]; 3]) -> DVec3 {
    let [a, b, c] = [vertex(corners[0]), vertex(corners[1]), vertex(corners[2])];
    (b - a).cross(c - a)
}
