//! How a set of boxes is parted for the eight-wide tree: where the two halves' areas, weighted by the leaves that each
//! fills, are least (surface area heuristic, in bins: I. Wald, "On fast construction of SAH-based bounding volume
//! hierarchies", 2007).

use arrayvec::ArrayVec;
use glam::{BVec3A, UVec3, Vec3A};
use std::cmp::Ordering;

/// A box in unit coordinates and whose it is.
#[derive(Debug, Clone, Copy)]
pub struct Item {
    pub lo: Vec3A,
    pub hi: Vec3A,
    pub index: u32,
}

/// A box that grows.
#[derive(Debug, Clone, Copy)]
pub struct Extent {
    pub lo: Vec3A,
    pub hi: Vec3A,
}

const BINS: usize = 32;
/// Up to so many items are tried one by one, which is faster than bins.
const FEW: usize = 8;

impl Extent {
    pub const EMPTY: Extent = Extent { lo: Vec3A::INFINITY, hi: Vec3A::NEG_INFINITY };

    pub fn of(items: &[Item]) -> Extent {
        items.iter().fold(Extent::EMPTY, |all, item| all.join(item.lo, item.hi))
    }

    #[inline]
    fn join(self, lo: Vec3A, hi: Vec3A) -> Extent {
        Extent { lo: self.lo.min(lo), hi: self.hi.max(hi) }
    }

    /// Half the area.
    #[inline]
    pub fn area(self) -> f32 {
        let d = self.hi - self.lo;
        d.x * d.y + d.y * d.z + d.z * d.x
    }
}

/// Sorts items, of which a leaf holds `most`, and says how many go to the first half: neither none nor all of two or more.
pub fn split(items: &mut [Item], most: usize) -> usize {
    if items.len() <= FEW {
        return sweep(items, most);
    }
    let middles = items.iter().fold(Extent::EMPTY, |all, item| all.join(item.lo + item.hi, item.lo + item.hi));
    let spread = middles.hi - middles.lo;
    let some: BVec3A = spread.cmpgt(Vec3A::ZERO);
    // The last middle falls into the last bin, not behind it.
    let scale = Vec3A::select(some, Vec3A::splat(BINS as f32 * 0.999_99) / spread, Vec3A::ZERO);
    let bin = |item: &Item| -> [usize; 3] {
        let at: UVec3 = ((item.lo + item.hi - middles.lo) * scale).as_uvec3();
        at.to_array().map(|at| (at as usize).min(BINS - 1))
    };
    let mut bins = [[(Extent::EMPTY, 0usize); BINS]; 3];
    for item in items.iter() {
        for (axis, at) in bin(item).into_iter().enumerate() {
            let (extent, count) = &mut bins[axis][at];
            *extent = extent.join(item.lo, item.hi);
            *count += 1;
        }
    }
    let mut best = (f32::INFINITY, 0, 0);
    for axis in (0..3).filter(|axis| some.test(*axis)) {
        let mut behind = [0.0f32; BINS];
        let (mut all, mut filled) = (Extent::EMPTY, 0);
        for at in (1..BINS).rev() {
            let (extent, count) = bins[axis][at];
            (all, filled) = (all.join(extent.lo, extent.hi), filled + count);
            behind[at] = if filled == 0 { f32::INFINITY } else { cost(all, filled, most) };
        }
        let (mut all, mut filled) = (Extent::EMPTY, 0);
        for at in 1..BINS {
            let (extent, count) = bins[axis][at - 1];
            (all, filled) = (all.join(extent.lo, extent.hi), filled + count);
            let sum = if filled == 0 { f32::INFINITY } else { cost(all, filled, most) + behind[at] };
            if sum < best.0 {
                best = (sum, axis, at);
            }
        }
    }
    let (_, axis, at) = best;
    let mut first = 0;
    if best.0 < f32::INFINITY {
        for i in 0..items.len() {
            if bin(&items[i])[axis] < at {
                items.swap(first, i);
                first += 1;
            }
        }
    }
    if first == 0 || first == items.len() { items.len() / 2 } else { first }
}

/// The same among all places between items, for few of them.
fn sweep(items: &mut [Item], most: usize) -> usize {
    let n = items.len();
    let mut best = (f32::INFINITY, 0, n / 2);
    for axis in 0..3 {
        items.sort_unstable_by(along(axis));
        let mut behind: ArrayVec<f32, FEW> = ArrayVec::new();
        let mut all = Extent::EMPTY;
        for (i, item) in items.iter().enumerate().rev() {
            all = all.join(item.lo, item.hi);
            behind.push(cost(all, n - i, most));
        }
        let mut all = Extent::EMPTY;
        for at in 1..n {
            all = all.join(items[at - 1].lo, items[at - 1].hi);
            let sum = cost(all, at, most) + behind[n - at - 1];
            if sum < best.0 {
                best = (sum, axis, at);
            }
        }
    }
    let (_, axis, at) = best;
    if axis != 2 {
        items.sort_unstable_by(along(axis));
    }
    at
}

/// The order of items' middles along an axis.
fn along(axis: usize) -> impl Fn(&Item, &Item) -> Ordering {
    let at = move |item: &Item| item.lo[axis] + item.hi[axis];
    move |a, b| at(a).total_cmp(&at(b)).then(a.index.cmp(&b.index))
}

/// Sorts items along their longest side and says how many go to the first half.
pub fn halve(items: &mut [Item]) -> usize {
    let extent = Extent::of(items);
    let side = (extent.hi - extent.lo).to_array();
    let axis = (0..3).fold(0, |longest, axis| if side[axis] > side[longest] { axis } else { longest });
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, along(axis));
    middle
}

/// Of looking into a box with so many items, `most` of them in a leaf.
#[inline]
fn cost(extent: Extent, count: usize, most: usize) -> f32 {
    extent.area() * count.div_ceil(most.max(1)) as f32
}
