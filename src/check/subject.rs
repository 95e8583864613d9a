//! What rules look at.

use super::geometry::EdgesOfMeshes;
use eyebox_base::{Code, Error, Where};
use eyebox_scene::assembly::Assembly;
use eyebox_scene::value::Value;
use eyebox_scene::{Face, Finish, Part, Scene, Shape};
use std::path::{Path, PathBuf};

/// An asset as far as it could be read.
#[derive(Debug, Clone, Copy)]
pub struct Subject<'a> {
    /// What was asked to be validated.
    pub file: &'a Path,
    pub assembly: &'a Assembly,
    /// The sidecar.
    pub sheet: Option<&'a Value>,
    /// The scene. Where something was faulty, what can be looked at in spite of it: see `whole`.
    pub scene: &'a Scene,
    /// Nothing was faulty: the scene is the one that `render` would have.
    pub whole: bool,
    pub needed: &'a [Needed],
    /// What was faulty.
    pub refusals: &'a [Refusal],
    pub edges: &'a EdgesOfMeshes,
}

/// A file that the asset names.
#[derive(Debug, Clone)]
pub struct Needed {
    pub file: PathBuf,
    /// `texture`, `buffer`, …
    pub role: String,
    pub at: Where,
    pub there: bool,
    /// Whether tracing reads it.
    pub used: bool,
}

/// A fault of reading an asset, and how far that had come.
#[derive(Debug, Clone)]
pub struct Refusal {
    pub stage: Stage,
    pub fault: Box<Error>,
}

/// Steps of the corridor from a path to a world.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// The asset's own file.
    Read,
    /// The sidecar, as text.
    Sidecar,
    /// Attributes, bindings and what they name.
    Build,
    /// The scene as a whole, and its tables.
    Freeze,
}

impl Refusal {
    /// Whether it is that this texture is missing.
    pub fn lacks(&self, needed: &Needed) -> bool {
        self.fault.code == Some(Code::TextureMissing)
            && !needed.there
            && self.fault.what.contains(&needed.file.display().to_string())
    }

    /// What the fault is about; where it says nothing, as much as the stage tells.
    pub fn code(&self) -> Code {
        self.fault.code.unwrap_or(match self.stage {
            Stage::Read => Code::AssetUnreadable,
            Stage::Sidecar => Code::SidecarUnreadable,
            Stage::Build => Code::ValueImpossible,
            Stage::Freeze => Code::SceneRefused,
        })
    }
}

impl Subject<'_> {
    /// Where a part stands in its file; by its path if no node has that.
    pub fn part(&self, path: &str, face: Option<usize>) -> Where {
        Where::Part { path: path.to_owned(), face }
    }
}

/// Whether light is bent or mirrored by the exact normal of a face: where a facet shows.
pub fn is_specular(face: &Face) -> bool {
    if face.is_slide() {
        return false;
    }
    match face.finish {
        Finish::Polished
        | Finish::MirrorMetal { .. }
        | Finish::MirrorIdeal { .. }
        | Finish::Grating { .. }
        | Finish::ReflectivePolariser { .. }
        | Finish::Abg { .. } => true,
        Finish::None
        | Finish::Rough { .. }
        | Finish::Lambert { .. }
        | Finish::Gauss { .. }
        | Finish::CosM { .. }
        | Finish::Measured { .. }
        | Finish::Polariser { .. }
        | Finish::Retarder { .. }
        | Finish::WavePlate { .. }
        | Finish::CircularPolariser { .. }
        | Finish::Surface { .. }
        | Finish::Absorber => false,
    }
}

/// Whether a face is traced as its triangles.
pub fn is_mesh(face: &Face) -> bool {
    face.shape == Shape::Mesh
}

/// Parts whose inside matters: filled with a medium, and with a face that lets light in.
pub fn is_solid(part: &Part) -> bool {
    let lets_in = |face: &Face| matches!(face.finish, Finish::Polished | Finish::Rough { .. });
    part.medium.is_some() && part.faces.iter().any(lets_in)
}
