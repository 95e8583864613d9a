//! The upper level: a tree over the boxes of parts, one part to a leaf, so that parts are entered from near to far:
//! entering one costs a transform and a walk through its own tree.

use super::bound::Bounds;
use super::tree::Tree;
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
    #[inline]
    pub fn along(
        &self,
        origin: DVec3,
        dir: DVec3,
        reach: f64,
        mut visit: impl FnMut(u32) -> ControlFlow<(), f64>,
    ) -> ControlFlow<()> {
        // A part alone has its own box.
        if let [alone] = self.tree.leaves() {
            return visit(alone.first).map_continue(|_| ());
        }
        let inverse = dir.recip();
        let Some((start, _)) = self.tree.bounds.clip(origin, inverse) else { return ControlFlow::Continue(()) };
        if start > reach {
            return ControlFlow::Continue(());
        }
        self.tree.candidates([origin, dir, inverse], [start, reach], &[(); 0], |leaf, _| {
            match self.tree.leaves().get(leaf as usize) {
                Some(leaf) => visit(leaf.first),
                None => ControlFlow::Break(()),
            }
        })
    }
}
