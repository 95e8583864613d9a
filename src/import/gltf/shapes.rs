//! Which mesh a node shows: the file's own, or one bent by morph targets and joints. A mesh that every node bends takes the
//! place of the file's own; further bends come after all meshes of the file, so that their numbers stay.

use super::accessor::Document;
use super::at::At;
use super::deform::Deform;
use super::notes::Ledger;
use super::pose::Pose;
use super::skin::Bones;
use super::{mesh, morph, rig};
use crate::Rigs;
use crate::assembly::MeshSource;
use eyebox_base::error::Result;
use glam::DAffine3;
use std::collections::HashMap;

/// What tells one bent mesh from another.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct Key {
    mesh: usize,
    /// Bits of the weights; none where all are 0.
    weights: Vec<u64>,
    /// The node, where it has a skin: the mesh is written in its axes.
    skinned: Option<usize>,
}

/// The meshes of the file, then those that are bent otherwise.
pub(super) struct Shapes<'a> {
    own: Vec<(At<'a>, Option<MeshSource>)>,
    more: Vec<MeshSource>,
    known: HashMap<Key, usize>,
    /// Whether rigs are read, and a mesh that a node may bend is this node's alone.
    rigs: Rigs,
}

impl<'a> Shapes<'a> {
    /// Reads every mesh that no node bends.
    ///
    /// # Errors
    /// As [`mesh::read`].
    pub fn read(document: &Document<'a>, pose: &Pose<'_>, rigs: Rigs, ledger: &mut Ledger) -> Result<Self> {
        let list = document.root.list("meshes")?;
        let mut bent = vec![false; list.len()];
        for node in 0..pose.count() {
            let Some(at) = pose.node(node) else { continue };
            let Some(index) = at.json.get("mesh").and_then(|_| at.get("mesh").ok()?.and_then(|mesh| mesh.count().ok()))
            else {
                continue;
            };
            let may_bend = at.json.get("skin").is_some() || list.get(index).is_some_and(|mesh| morph::count(mesh) > 0);
            if let Some(bent) = bent.get_mut(index) {
                *bent |= may_bend;
            }
        }
        let mut own = Vec::with_capacity(list.len());
        for (index, (at, bent)) in list.into_iter().zip(bent).enumerate() {
            let read = if bent { None } else { Some(mesh::read(document, &at, index, &Deform::default(), ledger)?) };
            own.push((at, read));
        }
        Ok(Shapes { own, more: Vec::new(), known: HashMap::new(), rigs })
    }

    /// The mesh that `reference` names, as the node with the index `node` shows it. `world` is where the node stands; none
    /// for one whose bent mesh is to be written in the axes of the world.
    ///
    /// # Errors
    /// Indices, weights, joints and meshes that are wrong.
    pub fn of(
        &mut self,
        document: &Document<'_>,
        (node, reference): (usize, &At<'_>),
        world: Option<DAffine3>,
        pose: &mut Pose<'_>,
        ledger: &mut Ledger,
    ) -> Result<usize> {
        let index = reference.index(self.own.len(), "mesh")?;
        let Some((at, read)) = self.own.get(index) else { return Ok(index) };
        let is_free = read.is_none();
        let skin = pose.node(node).map_or(Ok(None), |node| node.get("skin"))?;
        let weights = if morph::count(at) > 0 || at.json.get("weights").is_some() {
            weights(at, node, pose)?
        } else {
            Vec::new()
        };
        let bits = weights.iter().map(|weight| weight.to_bits()).collect();
        let has_rig = self.rigs != Rigs::No && (skin.is_some() || morph::count(at) > 0);
        let key = Key { mesh: index, weights: bits, skinned: (skin.is_some() || has_rig).then_some(node) };
        if let Some(&known) = self.known.get(&key) {
            return Ok(known);
        }
        if !is_free && key.weights.is_empty() && skin.is_none() && !self.known.values().any(|&known| known == index) {
            return Ok(index);
        }
        let bones = match &skin {
            Some(skin) => {
                let from_world = world.map_or(DAffine3::IDENTITY, |world| world.inverse());
                Some(Bones::read(document, skin, from_world, pose, ledger)?)
            }
            None => None,
        };
        let deform = Deform { weights, bones, is_traced: false };
        let mut source = mesh::read(document, at, index, &deform, ledger)?;
        if has_rig {
            source.rig =
                rig::read(document, (at, &source.mesh.triangles), &deform, (pose, self.rigs), ledger)?.map(Box::new);
        }
        let place = if is_free { index } else { self.own.len() + self.more.len() };
        match self.own.get_mut(index).filter(|_| is_free) {
            Some((_, slot)) => *slot = Some(source),
            None => self.more.push(source),
        }
        self.known.insert(key, place);
        Ok(place)
    }

    /// All of them; those that no node of the scene shows as they are written.
    ///
    /// # Errors
    /// As [`mesh::read`].
    pub fn finish(self, document: &Document<'_>, ledger: &mut Ledger) -> Result<Vec<MeshSource>> {
        let mut out = Vec::with_capacity(self.own.len() + self.more.len());
        for (index, (at, read)) in self.own.into_iter().enumerate() {
            out.push(match read {
                Some(read) => read,
                None => mesh::read(document, &at, index, &Deform::default(), ledger)?,
            });
        }
        out.extend(self.more);
        Ok(out)
    }
}

/// The weights of the morph targets: animated, else the node's, else the mesh's; empty where all are 0.
fn weights(mesh: &At<'_>, node: usize, pose: &Pose<'_>) -> Result<Vec<f64>> {
    let own = match (pose.weights(node), pose.node(node)) {
        (Some(animated), _) => Some(animated.clone()),
        (None, Some(node)) => morph::weights(node)?,
        (None, None) => None,
    };
    let weights = match own {
        Some(own) => own,
        None => morph::weights(mesh)?.unwrap_or_default(),
    };
    Ok(if weights.iter().all(|weight| *weight == 0.0) { Vec::new() } else { weights })
}
