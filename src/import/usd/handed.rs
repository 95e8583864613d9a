//! What prims hand down to those below them, and what the walk remembers of where it was.

use super::attribute::PrimView;
use super::paint::Painted;
use super::round_trip::Fold;
use super::{binding, skel_binding};
use openusd::sdf;
use std::collections::{HashMap, HashSet};
use std::ops::Range;

/// Deeper than any assembly; each level is a level of recursion here and in composition.
pub(super) const MOST_DEEP: usize = 500;

/// What prims take over from those above them.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Handed {
    /// By purpose: `default` and `render` are, `proxy` and `guide` are not.
    pub shown: bool,
    pub material: binding::Inherited,
    /// Colours of what has no material.
    pub painted: Painted,
    pub skel: skel_binding::Inherited,
}

/// Where the walk is.
#[derive(Debug, Clone)]
pub(super) struct Above {
    pub node: Option<usize>,
    pub handed: Handed,
    /// The innermost instance and its prototype: what is below both is one and the same.
    pub instance: Option<(sdf::Path, sdf::Path)>,
    pub depth: usize,
    /// Roots of instancers' prototypes need not be defined.
    pub may_be_over: bool,
}

/// The nodes below a node that others may copy.
#[derive(Debug, Clone)]
pub(super) struct Template {
    pub top: usize,
    pub nodes: Range<usize>,
    pub cameras: Range<usize>,
    pub lights: Range<usize>,
}

/// What the walk remembers.
#[derive(Debug, Default)]
pub(super) struct Placed {
    pub instances: HashMap<(String, Handed), Template>,
    /// Nodes that start afresh from the world.
    pub resets: HashSet<usize>,
    /// Nodes that our own writer made for what another node holds.
    pub folds: HashMap<usize, Fold>,
    /// The outermost instances.
    pub outermost: Vec<String>,
}

/// The path by which the instances of a prototype know a prim: the same for all of them.
pub(super) fn shared_path(view: &PrimView, below: &Above) -> String {
    let moved = below.instance.as_ref().and_then(|(from, to)| view.path().replace_prefix(from, to));
    moved.as_ref().unwrap_or(view.path()).as_str().to_owned()
}
