//! A sidecar turned into rows that an asset can carry itself.

use super::assembly::Assembly;
use super::value::Value;

/// What an asset must say of itself to mean what it means together with a sidecar. Each table replaces the one that
/// stands there. Names of coatings, media, emitters and slides have become indices into the root's arrays
/// (`coatings`, `media`, `emitters`, `slides`: tables, with `name` where they have one); names of files are relative to
/// the folder that the annotation was made for.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Annotation {
    /// `version`, `unit`, `wavelengths`, `default`, the arrays, `sky`, `eye`; none if the root says it all already.
    pub root: Option<Value>,
    /// By node, ascending: attributes of the whole part, and `faces` = [{ faces = [0, 2], attributes }, …].
    pub nodes: Vec<(usize, Value)>,
    /// By material, ascending.
    pub materials: Vec<(usize, Value)>,
    /// By mesh and face, ascending.
    pub faces: Vec<(usize, usize, Value)>,
}

impl Annotation {
    /// Whether the asset says everything already.
    pub fn is_empty(&self) -> bool {
        self.root.is_none() && self.nodes.is_empty() && self.materials.is_empty() && self.faces.is_empty()
    }

    /// Puts the rows where they belong.
    pub fn apply(&self, assembly: &mut Assembly) {
        if let Some(root) = &self.root {
            assembly.optics = Some(root.clone());
        }
        for (index, value) in &self.nodes {
            if let Some(node) = assembly.nodes.get_mut(*index) {
                node.attributes = Some(value.clone());
            }
        }
        for (index, value) in &self.materials {
            if let Some(material) = assembly.materials.get_mut(*index) {
                material.attributes = Some(value.clone());
            }
        }
        for (mesh, face, value) in &self.faces {
            if let Some(place) = assembly.meshes.get_mut(*mesh).and_then(|mesh| mesh.attributes.get_mut(*face)) {
                *place = Some(value.clone());
            }
        }
    }
}
