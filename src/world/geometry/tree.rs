//! The f32 hierarchy that proposes candidates: `obvhs`' compressed eight-wide tree over boxes in unit coordinates.
//!
//! Everything is scaled to a cube of half side 1 about the middle of the boxes, so that f32 rounding (and the constant
//! 1e-4 below which obvhs ignores a box) is a fixed share of the extent, at any scale and place. Each box is padded by
//! more than all f32 roundings of a ray that starts inside the cube: origin and direction 6e-8 each over a length of up
//! to 2√3, a zero component of the direction taken as 1.2e-7, four operations per plane.

use super::bound::Bounds;
use glam::{DVec3, UVec2, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::bvh2::{Bvh2, node::Bvh2Node};
use obvhs::cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh;
use obvhs::cwbvh::{CwBvh, node::CwBvhNode};
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use obvhs::ray::Ray;
use std::ops::ControlFlow;

/// A hierarchy over boxes; candidates are slots of the order that [`Tree::build`] returns.
#[derive(Debug)]
pub struct Tree {
    /// Contains all boxes, with a margin for rounding.
    pub bounds: Bounds,
    centre: DVec3,
    /// Unit coordinates per coordinate.
    scale: f64,
    nodes: Nodes,
}

#[derive(Debug)]
enum Nodes {
    /// So few that all are candidates.
    Few(u32),
    Wide(CwBvh),
}

/// Padding of boxes in unit coordinates: see the module.
const PAD: f64 = 2e-6;
/// Rays start this much earlier in unit coordinates: beyond the distance within which obvhs ignores boxes.
const BACK: f64 = 1.0 / 1024.0;
/// Up to this many primitives a tree is not worth entering.
const FEW: usize = 3;
/// obvhs' stack of nodes.
const DEEPEST: usize = 30;

impl Tree {
    /// Builds over finite boxes and returns for each slot the index of its box. None if there are more than u32 counts.
    pub fn build(boxes: &[Bounds]) -> Option<(Tree, Vec<u32>)> {
        let all = boxes.iter().fold(Bounds::EMPTY, |all, b| all.join(*b));
        let (centre, half) = (all.centre(), all.half().max_element());
        let scale = if half > 0.0 && half.is_finite() { 1.0 / half } else { 1.0 };
        let margin = DVec3::splat(2.0 * PAD / scale + 1e-12 * all.reach());
        let count = u32::try_from(boxes.len()).ok()?;
        let tree = |nodes| Tree { bounds: all.widen(margin), centre, scale, nodes };
        let order: Vec<u32> = (0..count).collect();
        if boxes.len() <= FEW {
            return Some((tree(Nodes::Few(count)), order));
        }
        let padded: Vec<Aabb> = boxes
            .iter()
            .map(|b| Aabb {
                min: round((b.lo - centre) * scale - PAD, f32::next_down),
                max: round((b.hi - centre) * scale + PAD, f32::next_up),
            })
            .collect();
        // The steps of obvhs' medium build without its debug-only validation, which panics on deep trees.
        let mut binary = PlocBuilder::with_capacity(padded.len()).build(
            PlocSearchDistance::Medium,
            &padded,
            order.clone(),
            SortPrecision::U64,
            3,
        );
        ReinsertionOptimizer::default().run(&mut binary, 0.05, None);
        let mut wide = bvh2_to_cwbvh(&binary, 3, true, false);
        if depth(&wide) > DEEPEST {
            wide = bvh2_to_cwbvh(&balanced(&padded, order), 3, true, false);
        }
        let order = std::mem::take(&mut wide.primitive_indices);
        Some((tree(Nodes::Wide(wide)), order))
    }

    /// Calls `visit` with candidate slots along origin + t·dir for t in [start, reach], roughly from near to far. It
    /// returns a new reach, or breaks. `dir` is unit; `start` is inside the bounds or on them, as
    /// [`Bounds::clip`] of them gives it.
    #[inline]
    pub fn candidates(
        &self,
        origin: DVec3,
        dir: DVec3,
        start: f64,
        reach: f64,
        mut visit: impl FnMut(u32) -> ControlFlow<(), f64>,
    ) -> ControlFlow<()> {
        let wide = match &self.nodes {
            Nodes::Few(count) => {
                for slot in 0..*count {
                    visit(slot)?;
                }
                return ControlFlow::Continue(());
            }
            Nodes::Wide(wide) => wide,
        };
        let begin = ((origin - self.centre) + start * dir) * self.scale - BACK * dir;
        if begin.is_nan() {
            return ControlFlow::Continue(());
        }
        // Inside the unit cube, unless the numbers are beyond any meaning.
        let begin = begin.clamp(DVec3::splat(-4.0), DVec3::splat(4.0));
        let to_unit = |t: f64| {
            let t = (t - start) * self.scale + BACK;
            ((t + PAD) as f32).next_up()
        };
        // Adding zero turns −0 into 0: obvhs takes the sign of a zero from its bit here and from `< 0` there.
        let dir = dir.as_vec3a() + Vec3A::ZERO;
        let mut ray = Ray::new(begin.as_vec3a(), dir, 0.0, to_unit(reach));
        let mut state = wide.new_traversal(dir);
        let mut node: &CwBvhNode;
        obvhs::traverse!(wide, node, state, node.intersect_ray(&ray, state.oct_inv4), {
            ray.tmax = to_unit(visit(state.primitive_id)?);
        });
        ControlFlow::Continue(())
    }
}

fn round(v: DVec3, towards: fn(f32) -> f32) -> Vec3A {
    Vec3A::new(towards(v.x as f32), towards(v.y as f32), towards(v.z as f32))
}

/// A tree of the least depth: halves at the median along the longest side. For boxes that nest at every scale or
/// coincide, from which obvhs makes chains deeper than its stack.
fn balanced(boxes: &[Aabb], mut order: Vec<u32>) -> Bvh2 {
    let mut tree = Bvh2 { nodes: vec![Bvh2Node::default()], ..Bvh2::default() };
    let mut open = vec![(0usize, 0..order.len())];
    while let Some((index, range)) = open.pop() {
        let own = &mut order[range.clone()];
        let all = own.iter().fold(Aabb::empty(), |all, i| all.union(&boxes[*i as usize]));
        let first_child = tree.nodes.len();
        if own.len() <= 1 {
            tree.nodes[index] = Bvh2Node::new(all, 1, range.start as u32);
            continue;
        }
        let axis = all.largest_axis();
        let middle = own.len() / 2;
        let at = |i: &u32| boxes[*i as usize].center_axis(axis);
        own.select_nth_unstable_by(middle, |a, b| at(a).total_cmp(&at(b)).then(a.cmp(b)));
        tree.nodes[index] = Bvh2Node::new(all, 0, first_child as u32);
        tree.nodes.extend([Bvh2Node::default(); 2]);
        open.push((first_child, range.start..range.start + middle));
        open.push((first_child + 1, range.start + middle..range.end));
    }
    tree.primitive_indices = order;
    tree
}

/// Levels of a tree.
fn depth(tree: &CwBvh) -> usize {
    let mut deepest = 0;
    let mut open = vec![(0u32, 1usize)];
    while let Some((index, level)) = open.pop() {
        deepest = deepest.max(level);
        let Some(node) = tree.nodes.get(index as usize) else { continue };
        for child in 0..8 {
            if !node.is_child_empty(child) && !node.is_leaf(child) {
                open.push((node.child_node_index(child), level + 1));
            }
        }
    }
    deepest
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rays along axes in both kinds of zero, from inside, outside and the surface of a row of boxes.
    #[test]
    fn zeros_of_either_sign() {
        let boxes: Vec<Bounds> = (0..40)
            .map(|i| Bounds::of([DVec3::new(f64::from(i), 0.0, 0.0), DVec3::new(f64::from(i) + 0.5, 1.0, 1.0)]))
            .collect();
        let (tree, order) = Tree::build(&boxes).expect("forty boxes");
        for zero in [0.0, -0.0] {
            for (origin, dir) in [
                (DVec3::new(7.25, 0.5, -100.0), DVec3::new(zero, zero, 1.0)),
                (DVec3::new(7.25, 0.5, 0.5), DVec3::new(zero, -1.0, zero)),
                (DVec3::new(7.25, 1.0, 0.5), DVec3::new(zero, -1.0, zero)),
                (DVec3::new(50.0, 1.0, 0.0), DVec3::new(-1.0, zero, zero)),
            ] {
                let (start, _) = tree.bounds.clip(origin, dir.recip()).expect("towards the boxes");
                let mut seen = Vec::new();
                let _ = tree.candidates(origin, dir, start, f64::INFINITY, |slot| {
                    seen.push(order[slot as usize]);
                    ControlFlow::Continue(f64::INFINITY)
                });
                assert!(seen.contains(&7), "{origin} {dir}: {seen:?}");
            }
        }
    }
}
