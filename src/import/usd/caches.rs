//! What the reading of a stage remembers of meshes and skeletons, so that each is made once.

use super::handed::Handed;
use glam::DAffine3;
use std::collections::HashMap;
use std::rc::Rc;

/// Meshes by where they come from, with what is handed down to them, and by what they are.
#[derive(Debug, Default)]
pub(super) struct KnownMeshes {
    pub by_source: HashMap<(String, Handed), Option<usize>>,
    /// By numbers of vertices and triangles.
    pub by_size: HashMap<(usize, usize), Alike>,
    /// Of implicit shapes.
    pub shapes: HashMap<String, usize>,
}

/// Meshes of one size. The first is hashed when there is a second: most large meshes are the only one of their size.
#[derive(Debug, Default)]
pub(super) struct Alike {
    pub unhashed: Option<usize>,
    pub by_content: HashMap<blake3::Hash, Vec<usize>>,
}

/// Skeletons by path, and what binds their animation.
pub(super) type KnownSkeletons = HashMap<(String, Option<String>), Rc<Skeleton>>;

/// A skeleton at the moment.
#[derive(Debug, Default)]
pub(super) struct Skeleton {
    /// The joints' paths.
    pub joints: Vec<String>,
    pub by_path: HashMap<String, usize>,
    /// Where a joint takes what was bound to it, both in the skeleton's axes.
    pub skinning: Vec<DAffine3>,
    /// Joint → skeleton at the moment, and when meshes were bound.
    pub worlds: Vec<DAffine3>,
    pub binds: Vec<DAffine3>,
    /// Weights of blend shapes by their names.
    pub shapes: HashMap<String, f64>,
}
