//! The binary tree over boxes: `obvhs` joins what lies beside each other from the bottom up (PLOC: D. Meister and J. Bittner,
//! "Parallel locally-ordered clustering for bounding volume hierarchy construction", 2018) and puts subtrees to better places
//! (D. Meister and J. Bittner, "Parallel reinsertion for bounding volume hierarchy optimization", 2018).

use super::split::Item;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

/// So many boxes at most, the parts of the sample HUDs among them. Of more our own splits make trees that are traced faster, and
/// sooner (`benches/trees.md` has the figures); and sets that nest are joined one pair at a time, in squares of their number.
pub const MOST: usize = 1 << 12;
/// Share of the subtrees that are put elsewhere in the first round. From 0.15 to 0.5 rays through the sample HUDs are as fast
/// within 3 %, beyond it nothing is gained.
const MOVED: f32 = 0.5;

/// A binary tree down to single boxes, two at least. The same for the same boxes: one thread builds it.
pub fn binary(items: &[Item]) -> Bvh2 {
    let boxes: Vec<Aabb> = items.iter().map(|item| Aabb::new(item.lo, item.hi)).collect();
    let indices = (0..items.len() as u32).collect();
    let mut builder = PlocBuilder::with_capacity(boxes.len());
    let mut tree = builder.build(PlocSearchDistance::High, &boxes, indices, SortPrecision::U64, 0);
    ReinsertionOptimizer::default().run(&mut tree, MOVED, None);
    tree
}
