//! The upper level: a tree over the boxes of parts, one part to a leaf, so that parts are entered from near to far:
//! entering one costs a transform and a walk through its own tree.

use super::super::bound::Bounds;
use super::node::Lanes;
use super::tree::{Each, Tree};
use super::wide::{Leaf, Visit};
use glam::DVec3;
use std::ops::ControlFlow;

#[derive(Debug)]
pub struct Top {
    bounds: Bounds,
    tree: Tree,
}

impl Top {
    /// Builds over boxes and returns for each slot the index of its box. None if there are more than can be told apart.
    pub fn build(boxes: &[Bounds]) -> Option<(Top, Vec<u32>)> {
        let (tree, order) = Tree::build(boxes, 1)?;
        Some((Top { bounds: boxes.iter().fold(Bounds::EMPTY, |all, b| all.join(*b)), tree }, order))
    }

    /// Box around everything.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Calls `visit` with the slots whose boxes are entered at t ≤ reach, near ones first. It returns a new reach, or
    /// breaks.
    pub fn along(
        &self,
        origin: DVec3,
        dir: DVec3,
        reach: f64,
        visit: impl FnMut(u32) -> ControlFlow<(), f64>,
    ) -> ControlFlow<()> {
        self.walk(None, [origin, dir], reach, &mut Each(visit))
    }

    /// [`Top::along`] for a visitor of slots.
    #[inline(always)]
    pub fn walk(
        &self,
        lanes: Option<Lanes>,
        [origin, dir]: [DVec3; 2],
        reach: f64,
        visitor: &mut impl Visit,
    ) -> ControlFlow<()> {
        // A part alone has its own box.
        if let [alone] = self.tree.leaves() {
            return visitor.leaf(alone.first, lanes).map_continue(|_| ());
        }
        let Some(start) = self.tree.bounds.enter(origin, dir).filter(|start| *start <= reach) else {
            return ControlFlow::Continue(());
        };
        let mut slots = Slots { leaves: self.tree.leaves(), visitor };
        self.tree.walk_nodes(lanes, [origin, dir], [start, reach], &[(); 0], &mut slots)
    }
}

/// From leaves, of one slot each, to slots.
struct Slots<'a, V> {
    leaves: &'a [Leaf],
    visitor: &'a mut V,
}

impl<V: Visit> Visit for Slots<'_, V> {
    #[inline(always)]
    fn leaf(&mut self, leaf: u32, lanes: Option<Lanes>) -> ControlFlow<(), Option<f64>> {
        match self.leaves.get(leaf as usize) {
            Some(leaf) => self.visitor.leaf(leaf.first, lanes),
            None => ControlFlow::Break(()),
        }
    }
}
