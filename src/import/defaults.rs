//! What makes a picture of an asset that says nothing of it: an eye that frames it, and how bright its sky is.

use super::assembly::Assembly;
use super::frames;
use eyebox_base::Where;
use eyebox_scene::{Eye, Note};
use glam::DVec3;

/// Of the default picture.
pub const RESOLUTION: [usize; 2] = [960, 540];
pub const FOV_DEG: f64 = 35.0;
/// The eye stands right of the front, which is +z in glTF, and above.
const AZIMUTH_DEG: f64 = 35.0;
const ELEVATION_DEG: f64 = 20.0;
/// Share of the picture that the asset fills at most.
const FILLED: f64 = 0.9;
/// On a horizontal plane the assumed sky brings as much light as a uniform one of this luminance.
pub const SKY_CD_M2: f64 = 1000.0;

/// A pinhole that frames the asset, and the note that says so; none if there is nothing to frame.
pub fn eye(assembly: &Assembly, unit_m: f64, resolution: [usize; 2], fov_deg: f64) -> Option<(Eye, Note)> {
    let (low, high) = bounds(assembly, unit_m)?;
    let centre = 0.5 * (low + high);
    let (azimuth, elevation) = (AZIMUTH_DEG.to_radians(), ELEVATION_DEG.to_radians());
    let towards =
        DVec3::new(azimuth.sin() * elevation.cos(), elevation.sin(), azimuth.cos() * elevation.cos()).normalize();
    let look = -towards;
    let up = (DVec3::Y - DVec3::Y.dot(look) * look).normalize();
    let right = look.cross(up);
    let half = (fov_deg.to_radians() / 2.0).tan();
    let tangents = [half * FILLED, half * FILLED * resolution[1] as f64 / resolution[0] as f64];
    // Every vertex within the picture.
    let needed = |corner: DVec3| {
        let from = corner - centre;
        let across = (from.dot(right).abs() / tangents[0]).max(from.dot(up).abs() / tangents[1]);
        from.dot(towards) + across
    };
    let distance = vertices(assembly, unit_m).map(needed).fold(0.0, f64::max);
    let distance = if distance > 0.0 { distance } else { 1.0 };
    let position = centre + towards * distance;
    let eye = Eye {
        position,
        look,
        up,
        pupil_diameter_m: 0.0,
        adapts: false,
        limits: eyebox_scene::BinocularLimits::default(),
        focus_distance_m: f64::INFINITY,
        fov_deg,
        resolution,
        age: 45.0,
    };
    let text = format!(
        "there is no eye: a pinhole {distance:.3} m from the middle of the asset frames it, {fov_deg}° wide, {} x {}",
        resolution[0], resolution[1]
    );
    Some((eye, Note::assumed(Where::file(&assembly.file), text)))
}

/// The corners of a box about all geometry, scene's world, m.
fn bounds(assembly: &Assembly, unit_m: f64) -> Option<(DVec3, DVec3)> {
    let grown = |found: Option<(DVec3, DVec3)>, point: DVec3| {
        let (low, high) = found.unwrap_or((point, point));
        Some((low.min(point), high.max(point)))
    };
    let found = vertices(assembly, unit_m).fold(None, grown);
    found.filter(|(low, high)| low.is_finite() && high.is_finite())
}

/// Every corner of every triangle, scene's world, m.
fn vertices(assembly: &Assembly, unit_m: f64) -> impl Iterator<Item = DVec3> + '_ {
    assembly.nodes.iter().flat_map(move |node| {
        let source = node.mesh.and_then(|mesh| assembly.meshes.get(mesh));
        let to_world = frames::in_metres(&node.to_world, unit_m, &assembly.axes);
        let corners = source.into_iter().flat_map(|source| {
            let corners = source.mesh.triangles.iter().flatten();
            corners.filter_map(|corner| source.mesh.positions.get(*corner as usize))
        });
        corners.map(move |position| to_world.transform_point3(DVec3::from(position.map(f64::from))))
    })
}
