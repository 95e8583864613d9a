//! The f32 hierarchy of eight boxes to a node, and the walk through it.
//!
//! What a walk proposes may differ by f32 rounding from processor to processor, but boxes are padded by more than that
//! (see [`tree`](super::tree)), so what is hit does not.

use super::collapse::Halves;
use super::huge_pages;
use super::node::{Beam, CHILDREN, LEAF, Lanes, Node, OTHER, enter};
use super::split::Item;
use super::stack::Stack;
use std::ops::ControlFlow;

/// Triangles of a leaf.
pub const LEAF_SIZE: usize = 4;

/// The slots of a leaf.
#[derive(Debug, Clone, Copy)]
pub struct Leaf {
    pub first: u32,
    pub count: u32,
}

#[derive(Debug)]
pub struct Wide {
    nodes: Vec<Node>,
    pub leaves: Vec<Leaf>,
}

/// Looks at the leaves that a walk proposes.
pub trait Visit {
    /// Returns a new reach in the ray's own parameter where it has changed, or breaks.
    fn leaf(&mut self, leaf: u32, lanes: Option<Lanes>) -> ControlFlow<(), Option<f64>>;
}

impl Wide {
    /// A leaf of the first slots, without a tree.
    pub fn one_leaf(count: u32) -> Wide {
        Wide { nodes: Vec::new(), leaves: vec![Leaf { first: 0, count }] }
    }

    #[inline]
    pub fn is_one_leaf(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Builds over boxes in unit coordinates, which it sorts, with leaves of at most so many: the index of the i-th is
    /// that of slot i. None if there are more than can be told apart.
    pub fn build(items: &mut [Item], most: usize) -> Option<Wide> {
        let halves = Halves::best(items, most);
        let mut wide = Wide { nodes: vec![Node::EMPTY], leaves: Vec::new() };
        // A node and what it stands for.
        let mut open = vec![(0usize, 0usize)];
        while let Some((index, set)) = open.pop() {
            for (lane, child) in halves.children(set).into_iter().enumerate() {
                let extent = halves.extent(child);
                let code = if let Some(slots) = halves.leaf(child) {
                    wide.leaves.push(Leaf { first: u32::try_from(slots.start).ok()?, count: slots.len() as u32 });
                    LEAF | code(wide.leaves.len() - 1)?
                } else {
                    open.push((wide.nodes.len(), child));
                    wide.nodes.push(Node::EMPTY);
                    code(wide.nodes.len() - 1)?
                };
                let node = &mut wide.nodes[index];
                node.rows[CHILDREN][lane] = f32::from_bits(code);
                for axis in 0..3 {
                    node.rows[axis][lane] = extent.lo[axis];
                    node.rows[axis ^ OTHER][lane] = extent.hi[axis];
                }
            }
        }
        wide.nodes = huge_pages::settle(wide.nodes);
        Some(wide)
    }

    /// Shows `visitor` the leaves whose boxes are met up to a reach, roughly from near to far. `contents` is what it will
    /// look at: one per leaf, or none.
    #[inline(always)]
    pub fn walk<T>(
        &self,
        lanes: Option<Lanes>,
        beam: &Beam,
        reach: f64,
        contents: &[T],
        visitor: &mut impl Visit,
    ) -> ControlFlow<()> {
        #[cfg(target_arch = "x86_64")]
        if lanes.is_none()
            && let Some(lanes) = Lanes::here()
        {
            // SAFETY: the processor has what the function needs.
            return unsafe { self.walk_in_lanes(lanes, beam, reach, contents, visitor) };
        }
        self.walk_by(lanes, beam, reach, contents, visitor)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    fn walk_in_lanes<T>(
        &self,
        lanes: Lanes,
        beam: &Beam,
        reach: f64,
        contents: &[T],
        visitor: &mut impl Visit,
    ) -> ControlFlow<()> {
        self.walk_by(Some(lanes), beam, reach, contents, visitor)
    }

    #[inline(always)]
    fn walk_by<T>(
        &self,
        lanes: Option<Lanes>,
        beam: &Beam,
        reach: f64,
        contents: &[T],
        visitor: &mut impl Visit,
    ) -> ControlFlow<()> {
        let mut reach = beam.to_unit(reach);
        let slopes = beam.slopes();
        let mut stack = Stack::new();
        let mut next = 0u32;
        loop {
            if next & LEAF != 0 {
                if let Some(nearer) = visitor.leaf(next & !LEAF, lanes)? {
                    reach = beam.to_unit(nearer);
                }
            } else {
                let Some(node) = self.nodes.get(next as usize) else { return ControlFlow::Continue(()) };
                let (mask, near) = enter(lanes, node, &slopes, reach);
                let child = |mask: u32| node.rows[CHILDREN][(mask.trailing_zeros() & 7) as usize].to_bits();
                // Nearness in the high half: it is not negative, and such numbers are in the order of their bits.
                let key = |mask: u32| {
                    let near = near[(mask.trailing_zeros() & 7) as usize].to_bits();
                    u64::from(near) << 32 | u64::from(child(mask))
                };
                if mask != 0 {
                    let mut others = mask & (mask - 1);
                    next = child(mask);
                    if others == 0 {
                        continue;
                    }
                    self.fetch(next, contents);
                    let mut best = key(mask);
                    let base = stack.top();
                    loop {
                        let other = key(others);
                        self.fetch(other as u32, contents);
                        others &= others - 1;
                        if !stack.insert(best.max(other), base) {
                            break;
                        }
                        best = best.min(other);
                        if others == 0 {
                            break;
                        }
                    }
                    next = best as u32;
                    continue;
                }
            }
            loop {
                let Some(key) = stack.pop() else { return ControlFlow::Continue(()) };
                if f32::from_bits((key >> 32) as u32) <= reach {
                    next = key as u32;
                    break;
                }
            }
        }
    }
}

impl Wide {
    /// Asks the memory for a child that will be looked at soon.
    #[inline(always)]
    fn fetch<T>(&self, child: u32, contents: &[T]) {
        #[cfg(target_arch = "x86_64")]
        {
            use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
            let place = (child & !LEAF) as usize;
            let node = self.nodes.as_ptr().wrapping_add(place).cast::<i8>();
            let leaf = contents.as_ptr().wrapping_add(place).cast::<i8>();
            let first = if child & LEAF != 0 { leaf } else { node };
            // SAFETY: a hint that has no effect on what is computed, whatever the address.
            unsafe {
                _mm_prefetch::<_MM_HINT_T0>(first);
                _mm_prefetch::<_MM_HINT_T0>(first.wrapping_add(64));
                _mm_prefetch::<_MM_HINT_T0>(first.wrapping_add(128));
            }
        }
        #[cfg(not(target_arch = "x86_64"))]
        let _ = (child, contents);
    }
}

fn code(place: usize) -> Option<u32> {
    u32::try_from(place).ok().filter(|code| *code < LEAF)
}
