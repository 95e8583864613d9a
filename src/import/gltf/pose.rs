//! Where nodes stand: as they are written, but for what an animation moves. Worlds are made when they are asked for, so that
//! what nobody uses is never looked at, and kept: a joint may come after the mesh that it bends.

use super::at::At;
use super::hierarchy::Tree;
use super::notes::Ledger;
use super::transform;
use eyebox_base::error::Result;
use glam::{DAffine3, DQuat, DVec3};
use std::collections::HashMap;

/// What an animation says of a node at the moment.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Moved {
    pub translation: Option<DVec3>,
    pub rotation: Option<DQuat>,
    pub scale: Option<DVec3>,
    /// Of the morph targets of its mesh.
    pub weights: Option<Vec<f64>>,
}

/// Nodes by their index in the file.
pub(super) struct Pose<'a> {
    nodes: Vec<At<'a>>,
    parents: Vec<Option<usize>>,
    moved: HashMap<usize, Moved>,
    locals: Vec<Option<DAffine3>>,
    worlds: Vec<Option<DAffine3>>,
}

impl<'a> Pose<'a> {
    pub fn new(tree: &Tree<'a>, moved: HashMap<usize, Moved>) -> Self {
        let count = tree.nodes.len();
        Pose {
            nodes: tree.nodes.clone(),
            parents: tree.parents.clone(),
            moved,
            locals: vec![None; count],
            worlds: vec![None; count],
        }
    }

    pub fn count(&self) -> usize {
        self.nodes.len()
    }
    pub fn node(&self, node: usize) -> Option<&At<'a>> {
        self.nodes.get(node)
    }
    /// The node's children stand where no node is above them.
    pub fn take_off(&mut self, node: usize) {
        self.parents.iter_mut().filter(|parent| **parent == Some(node)).for_each(|parent| *parent = None);
    }
    /// The weights that an animation gives to the morph targets of a node's mesh.
    pub fn weights(&self, node: usize) -> Option<&Vec<f64>> {
        self.moved.get(&node)?.weights.as_ref()
    }

    /// Node → parent.
    ///
    /// # Errors
    /// As [`transform::local`].
    pub fn local(&mut self, node: usize, ledger: &mut Ledger) -> Result<DAffine3> {
        if let Some(known) = self.locals.get(node).copied().flatten() {
            return Ok(known);
        }
        let Some(at) = self.nodes.get(node) else { return Ok(DAffine3::IDENTITY) };
        let local = transform::local(at, self.moved.get(&node), &mut ledger.notes)?;
        if let Some(slot) = self.locals.get_mut(node) {
            *slot = Some(local);
        }
        Ok(local)
    }

    /// Node → asset world: the product from the root.
    ///
    /// # Errors
    /// As [`local`](Self::local) of it and of those above it; a product that overflows.
    pub fn world(&mut self, node: usize, ledger: &mut Ledger) -> Result<DAffine3> {
        // Up to what is known, then down again: chains of nodes can be long.
        let (mut chain, mut above) = (vec![node], self.parent(node));
        let mut world = DAffine3::IDENTITY;
        while let Some(next) = above {
            if let Some(known) = self.worlds.get(next).copied().flatten() {
                world = known;
                break;
            }
            chain.push(next);
            above = self.parent(next);
        }
        for node in chain.into_iter().rev() {
            if let Some(known) = self.worlds.get(node).copied().flatten() {
                world = known;
                continue;
            }
            world *= self.local(node, ledger)?;
            if let Some(at) = self.nodes.get(node).filter(|_| !world.is_finite()) {
                return Err(at.fault("the node's world transform overflows").expected("finite numbers"));
            }
            if let Some(slot) = self.worlds.get_mut(node) {
                *slot = Some(world);
            }
        }
        Ok(world)
    }

    /// Where the parent of a node stands.
    ///
    /// # Errors
    /// As [`world`](Self::world).
    pub fn above(&mut self, node: usize, ledger: &mut Ledger) -> Result<DAffine3> {
        self.parent(node).map_or(Ok(DAffine3::IDENTITY), |parent| self.world(parent, ledger))
    }

    pub fn parent(&self, node: usize) -> Option<usize> {
        self.parents.get(node).copied().flatten()
    }
}
