//! What the networks of a material read of the mesh that it is on: sets of texture coordinates and colours, by the names
//! of primvars. A surface of a scene knows sets by number; each face gets those that its own material names.

use super::fold::Folded;
use std::collections::HashMap;

/// A set of texture coordinates.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) enum Set {
    /// The primvar's name, without `primvars:`.
    Named(String),
    /// MaterialX counts them; which primvar that is, is the mesh's matter.
    Numbered(u32),
}

/// A set, and what its reader has where the mesh has none.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Coordinates {
    pub set: Set,
    pub fallback: [f32; 2],
}

/// A primvar that a network reads.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct OfVertices {
    pub name: String,
    /// One number is in all three.
    pub fallback: [f32; 3],
    /// Three numbers rather than one.
    pub color: bool,
}

impl OfVertices {
    pub fn is_colour(&self) -> bool {
        self.color
    }
}

/// What a material reads of its mesh.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Reads {
    /// By the numbers that the surface knows them by.
    pub sets: Vec<Coordinates>,
    pub color: Option<OfVertices>,
    pub opacity: Option<OfVertices>,
}

impl Reads {
    /// How many sets a mesh of a scene has.
    pub const SETS: usize = 2;

    /// The number of a set; none if there is no room for one more.
    pub fn number(&mut self, wanted: &Coordinates) -> Option<u32> {
        let known = self.sets.iter().position(|known| known == wanted);
        let number = known.unwrap_or(self.sets.len());
        if number >= Self::SETS {
            return None;
        }
        if known.is_none() {
            self.sets.push(wanted.clone());
        }
        u32::try_from(number).ok()
    }
}

/// The material that is read at the moment.
#[derive(Debug, Default)]
pub(super) struct Folding {
    pub reads: Reads,
    /// What nodes came to, by prim and output: a node may be read by many. None while it is being folded, and of what is no
    /// value.
    pub known: HashMap<(String, String), Option<Folded>>,
    pub depth: usize,
}
