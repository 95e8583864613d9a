//! Skins: the joints of a rig as nodes, with where each was when meshes were bound. Joints that are nodes of the assembly are
//! these; others (UsdSkel) become nodes at the root of the scene, once for all meshes that they bend.

use super::animation::Animation;
use super::document::Document;
use super::node::matrix;
use eyebox_scene::assembly::Assembly;
use eyebox_scene::motion::{Joint, is_alike, locals};
use glam::DAffine3;
use serde_json::{Value as Json, json};

/// Joints that became nodes.
#[derive(Debug)]
struct Made {
    joints: Vec<Joint>,
    worlds: Vec<Vec<DAffine3>>,
    nodes: Vec<usize>,
}

/// The skins that were written, and the nodes for them.
#[derive(Debug, Default)]
pub struct Skins {
    made: Vec<Made>,
    /// Nodes without a parent.
    pub roots: Vec<usize>,
}

impl Skins {
    /// The skin of a node's mesh, an index of `skins`; none without joints. New nodes come after all that are there.
    pub fn of(
        &mut self,
        document: &mut Document,
        animation: &mut Animation,
        assembly: &Assembly,
        node: usize,
    ) -> Option<usize> {
        let (skin, worlds) = assembly.joints(node)?;
        let own: Option<Vec<usize>> = skin.joints.iter().map(|joint| joint.node).collect();
        let joints = match own {
            Some(own) => own,
            None => self.nodes(document, animation, assembly, (&skin.joints, worlds)),
        };
        let binds: Vec<[f32; 16]> = skin.binds.iter().map(columns).collect();
        let accessor = document.binary.matrices(&binds);
        document.skins.push(json!({ "joints": joints, "inverseBindMatrices": accessor }));
        Some(document.skins.len() - 1)
    }

    fn nodes(
        &mut self,
        document: &mut Document,
        animation: &mut Animation,
        assembly: &Assembly,
        (joints, worlds): (&[Joint], Vec<Vec<DAffine3>>),
    ) -> Vec<usize> {
        let known = self.made.iter().find(|made| {
            made.joints == joints
                && made.worlds.len() == worlds.len()
                && made.worlds.iter().flatten().zip(worlds.iter().flatten()).all(|(a, b)| is_alike(a, b))
        });
        if let Some(known) = known {
            return known.nodes.clone();
        }
        let first = document.nodes.len();
        let nodes: Vec<usize> = (first..first + joints.len()).collect();
        let mut tops = Vec::new();
        for (number, joint) in joints.iter().enumerate() {
            let locals = locals(joints, number, &worlds);
            let mut out = serde_json::Map::new();
            out.insert("name".into(), Json::from(joint.name.as_str()));
            let children = joints.iter().zip(&nodes).filter(|(other, _)| other.parent == Some(number));
            let children: Vec<usize> = children.map(|(_, node)| *node).collect();
            if !children.is_empty() {
                out.insert("children".into(), json!(children));
            }
            if joint.parent.is_none() {
                tops.push(first + number);
            }
            let Some((still, frames)) = locals.split_first() else { continue };
            let moves = frames.iter().any(|local| local != still);
            let motion = assembly.motion.as_ref().filter(|_| moves);
            let moved = motion.and_then(|motion| animation.node(document, motion, first + number, (*still, frames)));
            match moved {
                Some(moved) => out.extend(moved),
                None => out.extend(matrix(still)),
            }
            document.nodes.push(Json::Object(out));
        }
        // The joints of a skin must have a node in common that is above all of them (2.0, section 3.7.3.2).
        if tops.len() > 1 {
            self.roots.push(document.nodes.len());
            document.nodes.push(json!({ "name": "joints", "children": tops }));
        } else {
            self.roots.extend(tops);
        }
        self.made.push(Made { joints: joints.to_vec(), worlds, nodes: nodes.clone() });
        nodes
    }
}

/// Column by column, with the last row that glTF wants.
fn columns(affine: &DAffine3) -> [f32; 16] {
    let m = affine.to_cols_array().map(|x| x as f32);
    [m[0], m[1], m[2], 0.0, m[3], m[4], m[5], 0.0, m[6], m[7], m[8], 0.0, m[9], m[10], m[11], 1.0]
}
