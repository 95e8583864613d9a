//! The upper level: a binary tree over the boxes of parts, walked strictly from near to far in f64.
//!
//! Entering a part costs a transform and a walk through its own tree, so the order matters more than the width: a
//! wide tree (which visits the leaves of a node in storage order) entered five parts per ray in a stack of seven lenses.

use super::bound::Bounds;
use arrayvec::ArrayVec;
use glam::DVec3;
use std::ops::ControlFlow;

#[derive(Debug)]
pub struct Top {
    nodes: Vec<Node>,
}

#[derive(Debug, Clone, Copy)]
struct Node {
    bounds: Bounds,
    /// Slot of a leaf, or the first of the two children.
    first: u32,
    is_leaf: bool,
}

/// Levels that the stack of a walk holds; below half of them splits are in the middle, which makes at most 32 more.
const DEEPEST: usize = 64;

impl Top {
    /// Builds over boxes and returns for each slot the index of its box. None if there are more than u32 counts.
    pub fn build(boxes: &[Bounds]) -> Option<(Top, Vec<u32>)> {
        let count = u32::try_from(boxes.len()).ok().filter(|n| *n < u32::MAX / 2)?;
        let mut order: Vec<u32> = (0..count).collect();
        let mut top = Top { nodes: Vec::new() };
        if count == 0 {
            return Some((top, order));
        }
        let empty = Node { bounds: Bounds::EMPTY, first: 0, is_leaf: true };
        top.nodes.push(empty);
        let mut open = vec![(0usize, 0..order.len(), 1usize)];
        while let Some((index, range, level)) = open.pop() {
            let own = &mut order[range.clone()];
            let bounds = own.iter().fold(Bounds::EMPTY, |all, i| all.join(boxes[*i as usize]));
            if own.len() == 1 {
                top.nodes[index] = Node { bounds, first: range.start as u32, is_leaf: true };
                continue;
            }
            let middle = range.start + split(own, boxes, level < DEEPEST / 2);
            let first = top.nodes.len();
            top.nodes[index] = Node { bounds, first: first as u32, is_leaf: false };
            top.nodes.extend([empty; 2]);
            open.push((first, range.start..middle, level + 1));
            open.push((first + 1, middle..range.end, level + 1));
        }
        Some((top, order))
    }

    /// Box around everything.
    pub fn bounds(&self) -> Bounds {
        self.nodes.first().map_or(Bounds::EMPTY, |node| node.bounds)
    }

    /// Calls `visit` with the slots whose boxes are entered at t ≤ reach, near ones first. It returns a new reach, or
    /// breaks.
    #[inline]
    pub fn along(
        &self,
        origin: DVec3,
        dir: DVec3,
        mut reach: f64,
        mut visit: impl FnMut(u32) -> ControlFlow<(), f64>,
    ) -> ControlFlow<()> {
        // A part alone has its own box.
        if let [Node { first, is_leaf: true, .. }] = self.nodes.as_slice() {
            return visit(*first).map_continue(|_| ());
        }
        let inverse = dir.recip();
        let enter = |index: u32| {
            let node = self.nodes.get(index as usize)?;
            node.bounds.clip(origin, inverse).map(|(near, _)| (index, near))
        };
        let mut stack: ArrayVec<(u32, f64), DEEPEST> = ArrayVec::new();
        let mut next = enter(0);
        loop {
            let node = match next {
                Some((index, near)) if near <= reach => &self.nodes[index as usize],
                Some(_) | None => {
                    next = stack.pop();
                    if next.is_none() {
                        return ControlFlow::Continue(());
                    }
                    continue;
                }
            };
            if node.is_leaf {
                reach = visit(node.first)?;
                next = None;
                continue;
            }
            next = match (enter(node.first), enter(node.first + 1)) {
                (Some(one), Some(two)) => {
                    let (near, far) = if one.1 <= two.1 { (one, two) } else { (two, one) };
                    // Never full: see DEEPEST.
                    let _ = stack.try_push(far);
                    Some(near)
                }
                (one, two) => one.or(two),
            };
        }
    }
}

/// Sorts boxes and says how many go to the first child: where the two boxes' areas, weighted by their counts, are least
/// (surface area heuristic), or in the middle.
fn split(own: &mut [u32], boxes: &[Bounds], by_area: bool) -> usize {
    let centre = |i: u32, axis: usize| boxes[i as usize].centre()[axis];
    let sort = |own: &mut [u32], axis: usize| {
        own.sort_unstable_by(|a, b| centre(*a, axis).total_cmp(&centre(*b, axis)).then(a.cmp(b)));
    };
    let area = |b: Bounds| {
        let h = b.half();
        h.x * h.y + h.y * h.z + h.z * h.x
    };
    let mut best = (f64::INFINITY, 0, own.len() / 2);
    for axis in 0..3 {
        sort(own, axis);
        let mut behind = vec![0.0; own.len()];
        let mut all = Bounds::EMPTY;
        for k in (1..own.len()).rev() {
            all = all.join(boxes[own[k] as usize]);
            behind[k] = area(all) * (own.len() - k) as f64;
        }
        let mut all = Bounds::EMPTY;
        for k in 1..own.len() {
            all = all.join(boxes[own[k - 1] as usize]);
            let cost = area(all) * k as f64 + behind[k];
            if cost < best.0 && (by_area || k == own.len() / 2) {
                best = (cost, axis, k);
            }
        }
    }
    sort(own, best.1);
    best.2
}
