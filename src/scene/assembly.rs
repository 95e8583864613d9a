//! What a format reader delivers: the node hierarchy with geometry, names, transforms and whatever optical attributes
//! the asset itself carries, before any optical meaning is decided.

use super::motion::{Clock, Motion, Rig};
use super::user_property::UserProperty;
use super::value::Value;
use super::{Mesh, Note, StandardSurface};
use eyebox_base::{Code, Shared, Where};
use glam::{DAffine3, DMat3, DVec3};
use std::path::PathBuf;
use std::sync::Arc;

/// An asset as it was read. Lengths in the asset's own units, transforms in f64.
#[derive(Debug, Clone)]
pub struct Assembly {
    pub file: PathBuf,
    /// Every file that was read, the asset first.
    pub dependencies: Vec<PathBuf>,
    /// Metres per unit as the format declares it (glTF: 1).
    pub unit_m: f64,
    /// The asset's world → the scene's world, which is glTF's: +y up. USD with `upAxis = "Z"` is turned by −90° about
    /// x; all entries are 0 and ±1, so that turning rounds nothing.
    pub axes: DMat3,
    /// Parents before children.
    pub nodes: Vec<Node>,
    pub meshes: Vec<MeshSource>,
    pub materials: Vec<Material>,
    /// Cameras found on nodes; used as the eye when nothing else defines one.
    pub cameras: Vec<Camera>,
    /// Lights that are no geometry in the format.
    pub lights: Vec<LightSource>,
    /// Pictures of materials, and where they are named. They are not used, but belong to the asset. (Of USD; glTF's stand in
    /// its own lists.)
    pub textures: Vec<(PathBuf, Where)>,
    /// Kinds of geometry that are there and not read, each once.
    pub unread: Vec<String>,
    /// The layers that the asset asks for, and their names; empty if it leaves that to us.
    pub layers: Vec<RequestedLayer>,
    /// Root attributes of the asset (glTF: root extension `EYEBOX_optics`), in the sidecar's vocabulary.
    pub optics: Option<Value>,
    /// What was repaired, ignored or not understood.
    pub notes: Vec<Note>,
    /// What a layer over a USD stage has to know of it.
    pub stage: Option<StageFacts>,
    /// Variants that were asked for: with others it is another scene.
    pub variants: Vec<String>,
    /// When something happens, if the reader was asked for that.
    pub clock: Option<Clock>,
    /// How it moves, if it does and the reader was asked for that; the rest of the assembly is a moment of it.
    pub motion: Option<Motion>,
}

/// What a USD stage says beside its prims.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StageFacts {
    pub default_prim: Option<String>,
    /// `startTimeCode`, `endTimeCode`, `timeCodesPerSecond`, as far as they are said.
    pub times: Vec<(&'static str, f64)>,
    /// The paths of the outermost instances: nothing can be said of what is inside them.
    pub instances: Vec<String>,
}

impl Default for Assembly {
    fn default() -> Self {
        Assembly {
            file: PathBuf::new(),
            dependencies: Vec::new(),
            unit_m: 1.0,
            axes: DMat3::IDENTITY,
            nodes: Vec::new(),
            meshes: Vec::new(),
            materials: Vec::new(),
            cameras: Vec::new(),
            lights: Vec::new(),
            textures: Vec::new(),
            unread: Vec::new(),
            layers: Vec::new(),
            optics: None,
            notes: Vec::new(),
            stage: None,
            variants: Vec::new(),
            clock: None,
            motion: None,
        }
    }
}

impl Assembly {
    /// Whether the second texture coordinate grows upwards, as USD's `st` does; in glTF it grows downwards.
    pub fn st_runs_up(&self) -> bool {
        self.stage.is_some()
    }

    /// Whether the asset says for itself how long a unit is, as a stage can; glTF's is a metre, whatever a kernel wrote.
    pub fn says_unit(&self) -> bool {
        self.stage.is_some() && self.notes.iter().all(|note| note.code != Some(Code::UnitUnsaid))
    }

    /// Whether the asset itself says anything in our vocabulary.
    pub fn carries_optics(&self) -> bool {
        self.optics.is_some()
            || self.nodes.iter().any(|node| node.attributes.is_some())
            || self.materials.iter().any(|material| material.attributes.is_some())
            || self.meshes.iter().any(MeshSource::carries_optics)
    }

    /// Whether it says what parts are, beside that some shine: that says nothing of the others, and formats have lamps of their own
    /// (MeshLightAPI of USD), which must not take from the rest how it looks.
    pub fn says_what_parts_are(&self) -> bool {
        let more =
            |attributes: &Option<Value>| attributes.as_ref().is_some_and(|value| says_beside(value, &["emitter"]));
        self.optics.is_some()
            || self.nodes.iter().any(|node| more(&node.attributes))
            || self.materials.iter().any(|material| more(&material.attributes))
            || self.meshes.iter().any(|mesh| mesh.says_beside(&["shape", "emitter"]))
    }
}

/// Whether attributes have other keys than these.
fn says_beside(attributes: &Value, keys: &[&str]) -> bool {
    attributes.table().is_none_or(|rows| rows.iter().any(|(key, _)| !keys.contains(&key.as_str())))
}

#[derive(Debug, Clone)]
pub struct Node {
    pub name: String,
    /// Root-relative path of names, `HUD_B/LENS_01_PMMA`. Not necessarily unique.
    pub path: String,
    pub parent: Option<usize>,
    /// Node → parent, in asset units.
    pub local: DAffine3,
    /// Node → asset world, in asset units: the product of `local` from the root.
    pub to_world: DAffine3,
    pub mesh: Option<usize>,
    /// The node's own optical attributes (medium, emitter, …). They hold for all parts below it, too, where nothing
    /// nearer says otherwise. `faces` is a list of tables, each with `faces` or `normal` and what holds for those.
    pub attributes: Option<Value>,
    /// What its author has said of it beside the format.
    pub user: Vec<UserProperty>,
    pub at: Where,
}

#[derive(Debug, Clone)]
pub struct MeshSource {
    pub mesh: Shared<Mesh>,
    /// Index into `Assembly::materials` per face.
    pub materials: Vec<Option<usize>>,
    /// Optical attributes of each face (glTF: the primitive's `EYEBOX_optics`: shape).
    pub attributes: Vec<Option<Value>>,
    /// What bends it, if the reader was asked for that: `mesh` is bent already.
    pub rig: Option<Box<Rig>>,
    /// The shape that it was made of, where the format has shapes without points.
    pub implicit: Option<ImplicitShape>,
    pub at: Where,
}

/// A sphere, cube, cylinder, cone, capsule or plane of USD. Light meets the mesh that was made of it; the shape is written again.
#[derive(Debug, Clone, PartialEq)]
pub struct ImplicitShape {
    /// The type of its prim.
    pub kind: &'static str,
    /// What it says of its size: `radius`, `height`, …
    pub lengths: Vec<(&'static str, f64)>,
    /// X, Y or Z, of shapes that have an axis.
    pub axis: Option<&'static str>,
}

impl MeshSource {
    /// Whether the asset says anything of its faces in our vocabulary. An exact surface alone says nothing of light: USD's
    /// spheres have it, wherever they are written.
    fn carries_optics(&self) -> bool {
        self.says_beside(&["shape"])
    }
    fn says_beside(&self, keys: &[&str]) -> bool {
        let own = |attributes: &&Value| !self.is_own_shape(attributes);
        self.attributes.iter().flatten().filter(own).any(|attributes| says_beside(attributes, keys))
    }
    /// Whether attributes of a face are the exact surface of a shape that the format itself has: a sphere of USD.
    pub fn is_own_shape(&self, attributes: &Value) -> bool {
        attributes.get("shape").is_some_and(|shape| shape.at == self.at && attributes.at == self.at)
    }
}

#[derive(Debug, Clone)]
pub struct Material {
    pub name: String,
    /// Attributes in our vocabulary that the format's own fields map to (e.g. `KHR_materials_ior` → `ior`,
    /// emissive factor × strength → `emitter.luminance_cd_m2`), then the asset's explicit ones.
    pub mapped: Vec<(String, Value)>,
    /// The material's `EYEBOX_optics` (finish, coating).
    pub attributes: Option<Value>,
    /// How it looks to other programs; kept for writing, of no meaning to light here: `base_color` (3 numbers,
    /// linear Rec.709), `opacity`, `metallic`, `roughness`.
    pub looks: Vec<(String, Value)>,
    /// How it looks, which is what its faces are where nothing says otherwise; its pictures are not read yet.
    pub surface: Option<Shared<StandardSurface>>,
    /// What its author has said of it beside the format.
    pub user: Vec<UserProperty>,
    pub at: Where,
}

#[derive(Debug, Clone)]
pub struct Camera {
    pub name: String,
    /// The node that holds it, an index of `Assembly::nodes`.
    pub node: Option<usize>,
    /// Camera → asset world: looks along −z, up +y.
    pub to_world: DAffine3,
    /// Full vertical field of view, radians; none for an orthographic camera (which we cannot use).
    pub yfov: Option<f64>,
    pub aspect: Option<f64>,
    /// Diameter of its aperture and distance that is sharp, in asset units, if it says them.
    pub pupil: Option<f64>,
    pub focus: Option<f64>,
    /// What it means to other programs.
    pub frustum: Frustum,
}

/// What a rasteriser takes of a camera, in asset units. It means nothing to light, and is kept for writing.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Frustum {
    /// Nothing nearer is shown, and nothing beyond.
    pub near: Option<f64>,
    pub far: Option<f64>,
    /// Half the width and half the height of what an orthographic camera shows.
    pub half: Option<[f64; 2]>,
    /// The lens and the film that make its field of view.
    pub film: Option<Film>,
    /// Between which times its shutter is open, in frames about the one that is shown.
    pub shutter: Option<[f64; 2]>,
}

/// What photographers call a camera by, in asset units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Film {
    pub focal: f64,
    /// Width and height.
    pub size: [f64; 2],
    /// How far the film's middle is beside the axis, to the right and up.
    pub offset: [f64; 2],
}

/// A light that the format has as such (KHR_lights_punctual, UsdLux). Lengths in asset units, in the light's own axes;
/// strengths already in our units, exposure and normalisation worked in.
#[derive(Debug, Clone)]
pub struct LightSource {
    pub name: String,
    /// The node that holds it, an index of `Assembly::nodes`.
    pub node: usize,
    pub form: LightForm,
    /// Linear Rec.709 colour with luminance 1.
    pub color: [f64; 3],
    /// A colour temperature, K, that `color` is the colour of.
    pub kelvin: Option<f64>,
    /// The measured intensity distribution that shapes it, if any.
    pub profile: Option<LightProfile>,
    pub attributes: Option<Value>,
    pub at: Where,
}

/// A measured distribution of a light: its direction (0, 0) is −z of the light, its plane C0 +x, C90 +y.
#[derive(Debug, Clone, PartialEq)]
pub struct LightProfile {
    pub source: ProfileSource,
    /// Of the file's candela, unless `normalize`.
    pub factor: f64,
    /// The profile only shapes the light, whose flux stays what it is without.
    pub normalize: bool,
    /// Of γ: see [`LuminousProfile::angle_scaled`](super::LuminousProfile::angle_scaled); 0 for none.
    pub angle_scale: f64,
}

impl LightProfile {
    pub fn of(source: ProfileSource, factor: f64) -> Self {
        LightProfile { source, factor, normalize: false, angle_scale: 0.0 }
    }
}

/// Where a profile is.
#[derive(Debug, Clone, PartialEq)]
pub enum ProfileSource {
    File(PathBuf),
    /// In the asset.
    Embedded(Arc<Vec<u8>>),
}

impl ProfileSource {
    pub fn file(&self) -> Option<&PathBuf> {
        match self {
            ProfileSource::File(file) => Some(file),
            ProfileSource::Embedded(_) => None,
        }
    }
}

/// The kinds of lights; they shine along −z where they have a direction.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LightForm {
    /// A point; `cone` is (inner, outer) half angle in radians of a spot.
    Point {
        intensity_cd: f64,
        cone: Option<(f64, f64)>,
    },
    /// From infinity; `angle` is the full angle of its disc in radians, 0 for parallel light.
    Distant {
        illuminance_lx: f64,
        angle: f64,
    },
    Rect {
        luminance_cd_m2: f64,
        width: f64,
        height: f64,
    },
    Disk {
        luminance_cd_m2: f64,
        radius: f64,
    },
    Sphere {
        luminance_cd_m2: f64,
        radius: f64,
    },
    /// Along x, without caps.
    Cylinder {
        luminance_cd_m2: f64,
        radius: f64,
        length: f64,
    },
    /// A latitude-longitude picture around the scene; none is uniform.
    Dome {
        scale_cd_m2: f64,
        image: Option<PathBuf>,
    },
}

impl LightForm {
    /// Whether a point of the light's own frame lies within its body.
    pub fn holds(&self, local: DVec3) -> bool {
        match *self {
            LightForm::Sphere { radius, .. } => local.length() < radius,
            LightForm::Cylinder { radius, length, .. } => {
                local.x.abs() < 0.5 * length && local.y.hypot(local.z) < radius
            }
            LightForm::Point { .. }
            | LightForm::Distant { .. }
            | LightForm::Dome { .. }
            | LightForm::Rect { .. }
            | LightForm::Disk { .. } => false,
        }
    }
}

/// A layer that the asset asks for (USD RenderVar).
#[derive(Debug, Clone, PartialEq)]
pub struct RequestedLayer {
    /// What is asked for: a name of a layer of ours, or a light path expression.
    pub source: String,
    pub expression: bool,
    /// The name it shall have in the file.
    pub name: String,
    pub at: Where,
}
