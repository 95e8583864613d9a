//! What makes a picture of an asset that says nothing of light: an eye that frames it, and a sky.

use super::assembly::Assembly;
use super::build::{Builder, intern};
use super::frames;
use crate::base::ids::GroupId;
use crate::base::{Code, Where};
use crate::scene::{Eye, Group, Note, Sky};
use glam::{DMat3, DVec3};
use std::sync::Arc;

/// Of the default picture.
pub const RESOLUTION: [usize; 2] = [960, 540];
const FOV_DEG: f64 = 35.0;
/// The eye stands right of the front, which is +z in glTF, and above.
const AZIMUTH_DEG: f64 = 35.0;
const ELEVATION_DEG: f64 = 20.0;
/// Share of the picture that the asset fills at most.
const FILLED: f64 = 0.9;
/// On a horizontal plane the default sky brings as much light as a uniform one of this luminance.
const SKY_CD_M2: f64 = 1000.0;

/// A pinhole that frames the asset, and the note that says so; none if there is nothing to frame.
pub fn eye(assembly: &Assembly, unit_m: f64) -> Option<(Eye, Note)> {
    let (low, high) = bounds(assembly, unit_m)?;
    let centre = 0.5 * (low + high);
    let (azimuth, elevation) = (AZIMUTH_DEG.to_radians(), ELEVATION_DEG.to_radians());
    let towards =
        DVec3::new(azimuth.sin() * elevation.cos(), elevation.sin(), azimuth.cos() * elevation.cos()).normalize();
    let look = -towards;
    let up = (DVec3::Y - DVec3::Y.dot(look) * look).normalize();
    let right = look.cross(up);
    let half = (FOV_DEG.to_radians() / 2.0).tan();
    let tangents = [half * FILLED, half * FILLED * RESOLUTION[1] as f64 / RESOLUTION[0] as f64];
    // Every corner of the box within the picture.
    let needed = |corner: DVec3| {
        let from = corner - centre;
        let across = (from.dot(right).abs() / tangents[0]).max(from.dot(up).abs() / tangents[1]);
        from.dot(towards) + across
    };
    let corner = |i: usize| {
        let pick = |bit: usize, axis: usize| if i >> bit & 1 == 0 { low[axis] } else { high[axis] };
        DVec3::new(pick(0, 0), pick(1, 1), pick(2, 2))
    };
    let distance = (0..8).map(corner).map(needed).fold(0.0, f64::max);
    let distance = if distance > 0.0 { distance } else { 1.0 };
    let position = centre + towards * distance;
    let eye = Eye {
        position,
        look,
        up,
        pupil_diameter_m: 0.0,
        focus_distance_m: f64::INFINITY,
        fov_deg: FOV_DEG,
        resolution: RESOLUTION,
        age: 45.0,
    };
    let text = format!(
        "there is no eye: a pinhole {distance:.3} m from the middle of the asset frames it, {FOV_DEG}° wide, {} x {}",
        RESOLUTION[0], RESOLUTION[1]
    );
    Some((eye, Note::info(Where::file(&assembly.file), text).code(Code::EyeMissing)))
}

/// The corners of a box about all geometry, scene's world, m.
fn bounds(assembly: &Assembly, unit_m: f64) -> Option<(DVec3, DVec3)> {
    let mut found: Option<(DVec3, DVec3)> = None;
    for node in &assembly.nodes {
        let Some(source) = node.mesh.and_then(|mesh| assembly.meshes.get(mesh)) else { continue };
        let to_world = frames::in_metres(&node.to_world, unit_m, &assembly.axes);
        for corner in source.mesh.triangles.iter().flatten() {
            let Some(position) = source.mesh.positions.get(*corner as usize) else { continue };
            let point = to_world.transform_point3(DVec3::from(position.map(f64::from)));
            let (low, high) = found.unwrap_or((point, point));
            found = Some((low.min(point), high.max(point)));
        }
    }
    found.filter(|(low, high)| low.is_finite() && high.is_finite())
}

impl Builder<'_> {
    /// A neutral sky, brighter above: the overcast sky of Moon and Spencer (CIE S 011/E:2003, 16), L = Lz (1 + 2 sin γ)/3, over
    /// ground that reflects a fifth of it.
    pub(super) fn default_sky(&mut self) -> Sky {
        const ROWS: usize = 64;
        const GROUND: f64 = 0.2;
        // E = 7π/9 Lz on a horizontal plane.
        let zenith = SKY_CD_M2 * 9.0 / 7.0;
        let luminance = |row: usize| {
            let elevation = (0.5 - (row as f64 + 0.5) / ROWS as f64) * std::f64::consts::PI;
            if elevation > 0.0 { zenith * (1.0 + 2.0 * elevation.sin()) / 3.0 } else { GROUND * SKY_CD_M2 }
        };
        let pixels = (0..ROWS).flat_map(|row| std::iter::repeat_n(luminance(row) as f32, 2 * ROWS)).collect();
        let text = format!(
            "there is no light: a neutral sky, brighter above, that lights a horizontal plane as a uniform one of {SKY_CD_M2} cd/m² would"
        );
        self.notes.push(Note::info(Where::file(&self.assembly.file), text));
        Sky {
            group: GroupId::from_index(intern(&mut self.groups, Group { name: "sky".to_owned() })),
            width: 2 * ROWS,
            height: ROWS,
            luminance: Arc::new(pixels),
            rgb: None,
            to_world: DMat3::IDENTITY,
            file: "default".to_owned(),
        }
    }
}
