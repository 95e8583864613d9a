//! The f32 hierarchy that proposes candidates: an eight-wide tree over boxes in unit coordinates.
//!
//! Everything is scaled to a cube of half side 1 about the middle of the boxes, so that f32 rounding is a fixed share of
//! the extent, at any scale and place. Each box is padded by more than all f32 roundings of a ray that starts inside the
//! cube: origin, direction and its inverse 6e-8 each over a length of up to 2√3, a zero component of the direction taken as
//! 1.2e-7, four operations per plane.

use super::super::bound::Bounds;
use super::node::{Beam, Lanes};
use super::split::Item;
use super::wide::{Leaf, Visit, Wide};
use glam::{DVec3, Vec3A};
use std::ops::ControlFlow;

/// A hierarchy over boxes; its leaves are slots of the order that [`Tree::build`] returns.
#[derive(Debug)]
pub struct Tree {
    /// Contains all boxes, with a margin for rounding.
    pub bounds: Bounds,
    centre: DVec3,
    /// Unit coordinates per coordinate.
    scale: f64,
    wide: Wide,
}

/// Padding of boxes in unit coordinates: see the module.
const PAD: f64 = 2e-6;

impl Tree {
    /// Builds over finite boxes, with leaves of at most so many, and returns for each slot the index of its box. None if
    /// there are more than can be told apart.
    pub fn build(boxes: &[Bounds], most: usize) -> Option<(Tree, Vec<u32>)> {
        let all = boxes.iter().fold(Bounds::EMPTY, |all, b| all.join(*b));
        let (centre, half) = (all.centre(), all.half().max_element());
        let scale = if half > 0.0 && half.is_finite() { 1.0 / half } else { 1.0 };
        let margin = DVec3::splat(2.0 * PAD / scale + 1e-12 * all.reach());
        let count = u32::try_from(boxes.len()).ok()?;
        let tree = |wide| Tree { bounds: all.widen(margin), centre, scale, wide };
        if boxes.len() <= most {
            return Some((tree(Wide::one_leaf(count)), (0..count).collect()));
        }
        let mut items: Vec<Item> = (0..count)
            .zip(boxes)
            .map(|(index, b)| Item {
                lo: round((b.lo - centre) * scale - PAD, f32::next_down),
                hi: round((b.hi - centre) * scale + PAD, f32::next_up),
                index,
            })
            .collect();
        let wide = Wide::build(&mut items, most)?;
        Some((tree(wide), items.iter().map(|item| item.index).collect()))
    }

    /// The slots of each leaf.
    pub fn leaves(&self) -> &[Leaf] {
        &self.wide.leaves
    }

    /// Calls `visit` with the leaves along origin + t·dir for t in [start, reach], roughly from near to far. It returns a
    /// new reach, or breaks. `dir` is unit; `start` is inside the bounds or on them, as
    /// `Bounds::clip` of them gives it.
    #[inline(always)]
    pub fn candidates(
        &self,
        lanes: Option<Lanes>,
        along: [DVec3; 2],
        range: [f64; 2],
        visit: impl FnMut(u32) -> ControlFlow<(), f64>,
    ) -> ControlFlow<()> {
        self.walk(lanes, along, range, &[(); 0], &mut Each(visit))
    }

    /// [`Tree::candidates`] for a visitor; `contents` is what it looks at: one per leaf, or none.
    #[inline(always)]
    pub fn walk<T>(
        &self,
        lanes: Option<Lanes>,
        [origin, dir]: [DVec3; 2],
        [start, reach]: [f64; 2],
        contents: &[T],
        visitor: &mut impl Visit,
    ) -> ControlFlow<()> {
        if self.wide.is_one_leaf() {
            return visitor.leaf(0, lanes).map_continue(|_| ());
        }
        self.walk_nodes(lanes, [origin, dir], [start, reach], contents, visitor)
    }

    /// The same for a tree of more than one leaf.
    #[inline(always)]
    pub fn walk_nodes<T>(
        &self,
        lanes: Option<Lanes>,
        [origin, dir]: [DVec3; 2],
        [start, reach]: [f64; 2],
        contents: &[T],
        visitor: &mut impl Visit,
    ) -> ControlFlow<()> {
        let begin = ((origin - self.centre) + start * dir) * self.scale;
        if begin.is_nan() {
            return ControlFlow::Continue(());
        }
        // Inside the unit cube, unless the numbers are beyond any meaning.
        let begin = begin.clamp(DVec3::splat(-4.0), DVec3::splat(4.0));
        let beam = Beam { origin: begin.as_vec3a(), dir: dir.as_vec3a(), start, scale: self.scale, pad: PAD };
        self.wide.walk(lanes, &beam, reach, contents, visitor)
    }
}

/// A function of leaves as a visitor.
pub struct Each<F>(pub F);

impl<F: FnMut(u32) -> ControlFlow<(), f64>> Visit for Each<F> {
    #[inline(always)]
    fn leaf(&mut self, leaf: u32, _: Option<Lanes>) -> ControlFlow<(), Option<f64>> {
        (self.0)(leaf).map_continue(Some)
    }
}

fn round(v: DVec3, towards: fn(f32) -> f32) -> Vec3A {
    Vec3A::new(towards(v.x as f32), towards(v.y as f32), towards(v.z as f32))
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
        let (tree, order) = Tree::build(&boxes, 4).expect("forty boxes");
        for zero in [0.0, -0.0] {
            for (origin, dir) in [
                (DVec3::new(7.25, 0.5, -100.0), DVec3::new(zero, zero, 1.0)),
                (DVec3::new(7.25, 0.5, 0.5), DVec3::new(zero, -1.0, zero)),
                (DVec3::new(7.25, 1.0, 0.5), DVec3::new(zero, -1.0, zero)),
                (DVec3::new(50.0, 1.0, 0.0), DVec3::new(-1.0, zero, zero)),
            ] {
                let (start, _) = tree.bounds.clip(origin, dir.recip()).expect("towards the boxes");
                let mut seen = Vec::new();
                let _ = tree.candidates(None, [origin, dir], [start, f64::INFINITY], |leaf| {
                    let Leaf { first, count } = tree.leaves()[leaf as usize];
                    seen.extend_from_slice(&order[first as usize..(first + count) as usize]);
                    ControlFlow::Continue(f64::INFINITY)
                });
                assert!(seen.contains(&7), "{origin} {dir}: {seen:?}");
            }
        }
    }
}
