//! What a format reader delivers: the node hierarchy with geometry, names, transforms and whatever optical attributes
//! the asset itself carries, before any optical meaning is decided.

use super::value::Value;
use crate::base::Where;
use crate::scene::{Mesh, Note};
use glam::DAffine3;
use std::path::PathBuf;

/// An asset as it was read. Lengths in the asset's own units, transforms in f64.
#[derive(Debug, Clone, Default)]
pub struct Assembly {
    pub file: PathBuf,
    /// Every file that was read, the asset first.
    pub dependencies: Vec<PathBuf>,
    /// Metres per unit as the format declares it (glTF: 1).
    pub unit_m: f64,
    /// Parents before children.
    pub nodes: Vec<Node>,
    pub meshes: Vec<MeshSource>,
    pub materials: Vec<Material>,
    /// Cameras found on nodes; used as the eye when nothing else defines one.
    pub cameras: Vec<Camera>,
    /// Root attributes of the asset (glTF: root extension `EYEBOX_optics`), in the sidecar's vocabulary.
    pub optics: Option<Value>,
    /// What was repaired, ignored or not understood.
    pub notes: Vec<Note>,
}

#[derive(Debug, Clone)]
pub struct Node {
    pub name: String,
    /// Root-relative path of names, `HUD_B/LENS_01_PMMA`. Not necessarily unique.
    pub path: String,
    pub parent: Option<usize>,
    /// Node → asset world, in asset units.
    pub to_world: DAffine3,
    pub mesh: Option<usize>,
    /// The node's own optical attributes (medium, emitter, …).
    pub attributes: Option<Value>,
    pub at: Where,
}

#[derive(Debug, Clone)]
pub struct MeshSource {
    pub mesh: Mesh,
    /// Index into `Assembly::materials` per face.
    pub materials: Vec<Option<usize>>,
    /// Optical attributes of each face (glTF: the primitive's `EYEBOX_optics`: shape).
    pub attributes: Vec<Option<Value>>,
    pub at: Where,
}

#[derive(Debug, Clone)]
pub struct Material {
    pub name: String,
    /// Attributes in our vocabulary that the format's own fields map to (e.g. `KHR_materials_ior` → `ior`,
    /// emissive factor × strength → `emitter.luminance_cd_m2`), then the asset's explicit ones.
    pub mapped: Vec<(String, Value)>,
    /// The material's `EYEBOX_optics` (finish, coating).
    pub attributes: Option<Value>,
    pub at: Where,
}

#[derive(Debug, Clone)]
pub struct Camera {
    pub name: String,
    /// Camera → asset world: looks along −z, up +y.
    pub to_world: DAffine3,
    /// Full vertical field of view, radians; none for an orthographic camera (which we cannot use).
    pub yfov: Option<f64>,
    pub aspect: Option<f64>,
}
