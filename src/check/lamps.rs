//! What rules measure on lamps.

use eyebox_scene::{Emitter, Part, Scene};
use glam::DVec3;

/// Luminance along the normal of an emitting face, cd/m². None for a face without an area or a profile that is dark
/// along it.
pub fn luminance(scene: &Scene, part: &Part, face: usize, emitter: &Emitter) -> Option<f64> {
    let area = area_m2(scene, part, face);
    let spread = emitter.angular.spread(&scene.profiles)?;
    let luminance = emitter.unit_cd(&spread, area) * spread.normal / area;
    (area > 0.0 && luminance.is_finite()).then_some(luminance)
}

/// World area of a face, m².
fn area_m2(scene: &Scene, part: &Part, face: usize) -> f64 {
    let mesh = scene.mesh(part.mesh);
    let range = mesh.faces.get(face).map_or(0..0, |range| range.triangles());
    let corner = |vertex: u32| {
        let point = mesh.positions.get(vertex as usize)?;
        Some(part.to_world.transform_point3(DVec3::from_array(point.map(f64::from))))
    };
    let area = |[a, b, c]: &[u32; 3]| {
        let (a, b, c) = (corner(*a)?, corner(*b)?, corner(*c)?);
        Some(0.5 * (b - a).cross(c - a).length())
    };
    mesh.triangles.get(range).unwrap_or(&[]).iter().filter_map(area).sum()
}
