//! What a standard surface leaves of light that comes from within it: a face that emits under its opacity, coat and sheen.

use super::Principled;
use super::look::Look;
use super::point::{Point, Weights, between, coordinates, corners, of_vertices};
use crate::geometry::Hit;
use glam::DVec3;

impl Principled {
    /// The opacity where no texture says anything.
    pub fn plain_opacity(&self) -> f64 {
        Point::plain(&self.surface).look(None).opacity
    }

    /// The opacity at shares of the corners of a triangle of the mesh.
    pub fn opacity_at(&self, triangle: u32, weights: Weights) -> f64 {
        let Some(corners) = self.mesh.triangles.get(triangle as usize) else { return 0.0 };
        let corners = corners.map(|corner| corner as usize);
        let colour = if self.surface.vertex_colors { of_vertices(&self.mesh, corners, weights) } else { [1.0; 4] };
        Point::new(&self.surface, &coordinates(&self.mesh, corners, weights), colour).look(None).opacity
    }

    /// The normal that the mesh has at a place, in its own axes.
    pub fn interpolated(&self, hit: &Hit) -> Option<DVec3> {
        let (corners, weights) = corners(&self.mesh, hit)?;
        between(&self.mesh.normals, corners, weights).map(DVec3::from)
    }

    /// Share of light from below coat and sheen that leaves along a direction of the local frame.
    pub fn lets_out(&self, w: DVec3, look: &Look) -> f64 {
        let layers = self.layers(w, w, look);
        if layers.stain > 0.0 { layers.under / layers.stain * self.stained([w], look) } else { 0.0 }
    }
}
