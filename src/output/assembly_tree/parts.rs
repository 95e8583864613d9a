//! Parts: where they are and what fills them.

use super::face::{FaceReport, area};
use eyebox_scene::{Mesh, Part, Scene};
use glam::{DAffine3, DVec3};

/// A box along the world's axes, m.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Bounds {
    pub min_m: DVec3,
    pub max_m: DVec3,
}

impl Bounds {
    pub fn with(self, other: Bounds) -> Bounds {
        Bounds { min_m: self.min_m.min(other.min_m), max_m: self.max_m.max(other.max_m) }
    }
    pub fn size_m(self) -> DVec3 {
        self.max_m - self.min_m
    }
    pub fn centre_m(self) -> DVec3 {
        (self.min_m + self.max_m) / 2.0
    }
}

/// The medium of a part at the traced wavelength.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct MediumReport {
    pub name: String,
    pub n: f64,
    pub k: f64,
    pub absorption_per_m: f64,
}

#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct PartReport {
    pub name: String,
    /// Root-relative.
    pub path: String,
    pub mesh: String,
    /// How many parts share the mesh, this one included.
    pub instances: usize,
    pub triangles: usize,
    /// Of all triangles, in the world.
    pub area_m2: f64,
    pub face_count: usize,
    /// None for a part without vertices.
    pub bounds: Option<Bounds>,
    /// Extent along the mesh's own axes, m: the same for every copy however it is turned.
    pub size_m: Option<DVec3>,
    pub medium: Option<MediumReport>,
    pub priority: i32,
    pub faces: Vec<FaceReport>,
}

/// Vertices × parts up to which bounds are exact; beyond that they are those of the meshes' boxes.
const EXACT_WORK: usize = 50_000_000;

pub fn parts(scene: &Scene) -> Vec<PartReport> {
    let mut instances = vec![0usize; scene.meshes.len()];
    let mut work = 0usize;
    for part in &scene.parts {
        if let (Some(count), Some(mesh)) = (instances.get_mut(part.mesh.index()), scene.meshes.get(part.mesh.index())) {
            *count += 1;
            work = work.saturating_add(mesh.positions.len());
        }
    }
    let boxes: Vec<Option<(DVec3, DVec3)>> = scene.meshes.iter().map(|mesh| bounds(points(mesh))).collect();
    let report = |part: &Part| {
        let index = part.mesh.index();
        let mesh = scene.meshes.get(index);
        let local = boxes.get(index).copied().flatten();
        let bounds = match mesh {
            Some(mesh) if work <= EXACT_WORK => bounds(points(mesh).map(|point| part.to_world.transform_point3(point))),
            Some(_) | None => local.and_then(|local| corners(local, &part.to_world)),
        };
        let m = part.to_world.matrix3;
        let scale = DVec3::new(m.x_axis.length(), m.y_axis.length(), m.z_axis.length());
        PartReport {
            name: part.name.clone(),
            path: part.path.clone(),
            mesh: mesh.map_or_else(String::new, |mesh| mesh.name.clone()),
            instances: instances.get(index).copied().unwrap_or(0),
            triangles: mesh.map_or(0, |mesh| mesh.triangles.len()),
            area_m2: (0..part.faces.len()).map(|face| area(scene, part, face)).sum(),
            face_count: part.faces.len(),
            bounds: bounds.map(|(min_m, max_m)| Bounds { min_m, max_m }),
            size_m: local.map(|(low, high)| (high - low) * scale),
            medium: None,
            priority: part.priority,
            faces: Vec::new(),
        }
    };
    scene.parts.iter().map(report).collect()
}

pub fn medium(scene: &Scene, part: &Part) -> Option<MediumReport> {
    let medium = scene.media.get(part.medium?.index())?;
    let index = medium.index.index(scene.wavelengths.traced_nm());
    Some(MediumReport {
        name: medium.name.clone(),
        n: index.re,
        k: index.im,
        absorption_per_m: medium.absorption.per_m(scene.wavelengths.traced_nm()),
    })
}

fn points(mesh: &Mesh) -> impl Iterator<Item = DVec3> {
    mesh.positions.iter().map(|point| DVec3::from_array(point.map(f64::from)))
}

fn bounds(points: impl Iterator<Item = DVec3>) -> Option<(DVec3, DVec3)> {
    points.fold(None, |found, point| {
        let (low, high) = found.unwrap_or((point, point));
        Some((low.min(point), high.max(point)))
    })
}

fn corners((low, high): (DVec3, DVec3), to_world: &DAffine3) -> Option<(DVec3, DVec3)> {
    let pick = |corner: u32, bit: u32, low: f64, high: f64| if corner >> bit & 1 == 0 { low } else { high };
    bounds((0..8).map(|corner| {
        to_world.transform_point3(DVec3::new(
            pick(corner, 0, low.x, high.x),
            pick(corner, 1, low.y, high.y),
            pick(corner, 2, low.z, high.z),
        ))
    }))
}
