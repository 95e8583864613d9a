//! Eight boxes at a time: the nodes of the f32 hierarchy and the walk through them, in eight lanes where the processor
//! has them.
//!
//! What a walk proposes may differ by f32 rounding from processor to processor, but boxes are padded by more than that
//! (see [`tree`](super::tree)), so what is hit does not.

use super::huge;
use super::split::{Extent, Item, halve, split};
use arrayvec::ArrayVec;
use std::mem::MaybeUninit;
use std::ops::{ControlFlow, Range};

/// Boxes in unit coordinates and what is in them.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
struct Node {
    /// Lower x, y, z, then in the bits of numbers the children (a node, or a leaf with [`LEAF`]), then upper x, y, z and
    /// nothing. A child that is missing has a box that nothing enters.
    rows: [[f32; 8]; 8],
}

/// The row of the children.
const CHILDREN: usize = 3;
/// From the row of a lower plane to that of the upper one and back, by exclusive or.
const OTHER: usize = 4;

const LEAF: u32 = 1 << 31;
/// Triangles of a leaf.
pub const LEAF_SIZE: usize = 4;
/// Levels of a tree: each of them leaves at most seven entries on the stack.
pub const DEEPEST: usize = 36;
const ROOM: usize = 256;

/// What is left to look at: places below `top` are written, the others are not, so that starting costs nothing.
struct Stack {
    items: [MaybeUninit<u64>; ROOM],
    top: usize,
}

impl Stack {
    #[inline(always)]
    fn new() -> Stack {
        Stack { items: [const { MaybeUninit::uninit() }; ROOM], top: 0 }
    }

    /// Puts a key among those at `base` and above, which descend. False if there is no room.
    #[inline(always)]
    fn insert(&mut self, key: u64, base: usize) -> bool {
        if self.top >= ROOM {
            return false;
        }
        let mut at = self.top;
        while at > base {
            // SAFETY: a place below the top, see above.
            let below = unsafe { self.items[(at - 1) % ROOM].assume_init() };
            if below >= key {
                break;
            }
            self.items[at % ROOM].write(below);
            at -= 1;
        }
        self.items[at % ROOM].write(key);
        self.top += 1;
        true
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<u64> {
        self.top = self.top.checked_sub(1)?;
        // SAFETY: it was below the top, see above.
        Some(unsafe { self.items[self.top % ROOM].assume_init() })
    }
}

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

/// A ray in unit coordinates: origin, and 1/direction, which may be infinite.
#[derive(Debug, Clone, Copy)]
pub struct Beam {
    pub origin: [f32; 3],
    pub inverse: [f32; 3],
    /// The ray's own parameter at the origin, unit coordinates per step of it, and what is added for rounding.
    pub start: f64,
    pub scale: f64,
    pub pad: f64,
}

/// Looks at the leaves that a walk proposes.
pub trait Visit {
    /// Returns a new reach in the ray's own parameter where it has changed, or breaks.
    fn leaf(&mut self, leaf: u32, lanes: Option<Lanes>) -> ControlFlow<(), Option<f64>>;
}

/// Says that the processor has eight lanes of f32 with fused products (AVX2 and FMA).
#[derive(Debug, Clone, Copy)]
pub struct Lanes(());

/// What a walk compares with boxes.
struct Slopes {
    /// 1/direction, finite.
    inverse: [f32; 3],
    /// origin/direction.
    shift: [f32; 3],
    /// The row of the plane that is met first, per axis.
    first: [usize; 3],
}

impl Beam {
    #[inline(always)]
    fn to_unit(self, t: f64) -> f32 {
        (((t - self.start) * self.scale + self.pad) as f32).next_up()
    }

    #[inline(always)]
    fn slopes(&self) -> Slopes {
        // A component below 1.2e-7 counts as that.
        let inverse = self.inverse.map(|x| x.clamp(-1.0 / f32::EPSILON, 1.0 / f32::EPSILON));
        Slopes {
            inverse,
            shift: [0, 1, 2].map(|i| self.origin[i] * inverse[i]),
            first: [0, 1, 2].map(|i| if inverse[i] < 0.0 { i ^ OTHER } else { i }),
        }
    }
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

    /// Builds over boxes in unit coordinates, which it sorts, with leaves of at most so many: the index of the i-th is that of slot i. None if there are
    /// more than can be told apart.
    pub fn build(items: &mut [Item], most: usize) -> Option<Wide> {
        let mut wide = Wide { nodes: vec![EMPTY], leaves: Vec::new() };
        // A node, the items below it, its level.
        let mut open = vec![(0usize, 0..items.len(), 1usize)];
        while let Some((index, range, level)) = open.pop() {
            for (lane, child) in part(items, range, (level, most)).into_iter().enumerate() {
                let extent = Extent::of(&items[child.clone()]);
                let code = if child.len() <= most {
                    wide.leaves.push(Leaf { first: u32::try_from(child.start).ok()?, count: child.len() as u32 });
                    LEAF | code(wide.leaves.len() - 1)?
                } else {
                    open.push((wide.nodes.len(), child, level + 1));
                    wide.nodes.push(EMPTY);
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
        wide.nodes = huge::settle(wide.nodes);
        Some(wide)
    }

    /// Shows `visitor` the leaves whose boxes are met up to a reach, roughly from near to far. `contents` is what it will
    /// look at: one per leaf, or none.
    #[inline(always)]
    pub fn walk<T>(&self, beam: &Beam, reach: f64, contents: &[T], visitor: &mut impl Visit) -> ControlFlow<()> {
        #[cfg(target_arch = "x86_64")]
        if std::is_x86_feature_detected!("avx2") && std::is_x86_feature_detected!("fma") {
            // SAFETY: the processor has what the function needs.
            return unsafe { self.walk_in_lanes(beam, reach, contents, visitor) };
        }
        self.walk_by(None, beam, reach, contents, visitor)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    fn walk_in_lanes<T>(&self, beam: &Beam, reach: f64, contents: &[T], visitor: &mut impl Visit) -> ControlFlow<()> {
        self.walk_by(Some(Lanes(())), beam, reach, contents, visitor)
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
                let (mut mask, near) = enter(lanes, node, &slopes, reach);
                // Nearness in the high half: it is not negative, and such numbers are in the order of their bits.
                let mut pull = || {
                    let lane = (mask.trailing_zeros() & 7) as usize;
                    let child = node.rows[CHILDREN][lane].to_bits();
                    let key = u64::from(near[lane].to_bits()) << 32 | u64::from(child);
                    let any = mask != 0;
                    mask &= mask.wrapping_sub(1);
                    any.then_some(key)
                };
                if let Some(mut best) = pull() {
                    self.fetch(best as u32, contents);
                    let base = stack.top;
                    while let Some(other) = pull() {
                        self.fetch(other as u32, contents);
                        if !stack.insert(best.max(other), base) {
                            break;
                        }
                        best = best.min(other);
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

const EMPTY: Node = {
    let (low, high) = ([f32::INFINITY; 8], [f32::NEG_INFINITY; 8]);
    let children = [f32::from_bits(LEAF); 8];
    Node { rows: [low, low, low, children, high, high, high, [0.0; 8]] }
};

/// Which boxes are met at 0 ≤ t ≤ reach, a bit each, and where they are entered.
#[inline(always)]
fn enter(lanes: Option<Lanes>, node: &Node, slopes: &Slopes, reach: f32) -> (u32, [f32; 8]) {
    match lanes {
        // SAFETY: `Lanes` says that the processor has what the function needs.
        #[cfg(target_arch = "x86_64")]
        Some(_) => unsafe { enter_in_lanes(node, slopes, reach) },
        #[cfg(not(target_arch = "x86_64"))]
        Some(_) => enter_by_one(node, slopes, reach),
        None => enter_by_one(node, slopes, reach),
    }
}

#[inline(always)]
fn enter_by_one(node: &Node, slopes: &Slopes, reach: f32) -> (u32, [f32; 8]) {
    let (mut near, mut far) = ([0.0f32; 8], [reach; 8]);
    for axis in 0..3 {
        let first = slopes.first[axis];
        let (one, two) = (&node.rows[first & 7], &node.rows[(first ^ OTHER) & 7]);
        for lane in 0..8 {
            let enter = one[lane] * slopes.inverse[axis] - slopes.shift[axis];
            let leave = two[lane] * slopes.inverse[axis] - slopes.shift[axis];
            near[lane] = if enter > near[lane] { enter } else { near[lane] };
            far[lane] = if leave < far[lane] { leave } else { far[lane] };
        }
    }
    let mask = (0..8).fold(0, |mask, lane| mask | u32::from(near[lane] <= far[lane]) << lane);
    (mask, near)
}

/// The same, all eight at a time.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
#[inline]
fn enter_in_lanes(node: &Node, slopes: &Slopes, reach: f32) -> (u32, [f32; 8]) {
    use std::arch::x86_64::*;
    // SAFETY: eight numbers are read, and they are there.
    let load = |planes: &[f32; 8]| unsafe { _mm256_loadu_ps(planes.as_ptr()) };
    let (mut near, mut far) = (_mm256_setzero_ps(), _mm256_set1_ps(reach));
    for axis in 0..3 {
        let first = slopes.first[axis];
        let (inverse, shift) = (_mm256_set1_ps(slopes.inverse[axis]), _mm256_set1_ps(slopes.shift[axis]));
        let plane = |which: usize| _mm256_fmsub_ps(load(&node.rows[which & 7]), inverse, shift);
        near = _mm256_max_ps(plane(first), near);
        far = _mm256_min_ps(plane(first ^ OTHER), far);
    }
    let mask = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(near, far)) as u32;
    let mut entered = [0.0f32; 8];
    // SAFETY: eight numbers are written, and there is room for them.
    unsafe { _mm256_storeu_ps(entered.as_mut_ptr(), near) };
    (mask, entered)
}

fn code(place: usize) -> Option<u32> {
    u32::try_from(place).ok().filter(|code| *code < LEAF)
}

/// Parts a node's items among up to eight children: the largest child gives way to two.
fn part(items: &mut [Item], range: Range<usize>, (level, most): (usize, usize)) -> ArrayVec<Range<usize>, 8> {
    // Sets that nest at every scale would make chains; the most numerous child, halved, makes at most 16 more levels.
    let by_area = level < DEEPEST / 2;
    let size = |items: &[Item]| if by_area { Extent::of(items).area() } else { items.len() as f32 };
    let mut children: ArrayVec<(f32, Range<usize>), 8> = ArrayVec::new();
    children.push((size(&items[range.clone()]), range));
    while !children.is_full() {
        let wide = children.iter_mut().filter(|(_, child)| child.len() > most);
        let Some((largest, child)) = wide.max_by(|a, b| a.0.total_cmp(&b.0)) else { break };
        let own = &mut items[child.clone()];
        let middle = child.start + if by_area { split(own, most) } else { halve(own) };
        let other = middle..child.end;
        child.end = middle;
        *largest = size(&items[child.clone()]);
        children.push((size(&items[other.clone()]), other));
    }
    children.into_iter().map(|(_, child)| child).collect()
}
