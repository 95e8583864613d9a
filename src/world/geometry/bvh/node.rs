//! Eight boxes at a time, in eight lanes where the processor has them: a node of the f32 hierarchy, and which of its boxes
//! a ray enters.

use glam::Vec3A;

/// Boxes in unit coordinates and what is in them.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub struct Node {
    /// Lower x, y, z, then in the bits of numbers the children (a node, or a leaf with [`LEAF`]), then upper x, y, z and
    /// nothing. A child that is missing has a box that nothing enters.
    pub rows: [[f32; 8]; 8],
}

/// The row of the children.
pub const CHILDREN: usize = 3;
/// From the row of a lower plane to that of the upper one and back, by exclusive or.
pub const OTHER: usize = 4;
/// Of a child that is a leaf.
pub const LEAF: u32 = 1 << 31;

impl Node {
    /// Without children.
    pub const EMPTY: Node = {
        let (low, high) = ([f32::INFINITY; 8], [f32::NEG_INFINITY; 8]);
        let children = [f32::from_bits(LEAF); 8];
        Node { rows: [low, low, low, children, high, high, high, [0.0; 8]] }
    };
}

/// A ray in unit coordinates.
#[derive(Debug, Clone, Copy)]
pub struct Beam {
    pub origin: Vec3A,
    pub dir: Vec3A,
    /// The ray's own parameter at the origin, unit coordinates per step of it, and what is added for rounding.
    pub start: f64,
    pub scale: f64,
    pub pad: f64,
}

/// Says that the processor has eight lanes of f32 with fused products (AVX2 and FMA).
#[derive(Debug, Clone, Copy)]
pub struct Lanes(());

#[cfg(target_arch = "x86_64")]
impl Lanes {
    /// If this processor has them.
    #[inline(always)]
    pub fn here() -> Option<Lanes> {
        let here = std::is_x86_feature_detected!("avx2") && std::is_x86_feature_detected!("fma");
        here.then_some(Lanes(()))
    }
}

/// What a walk compares with boxes.
pub struct Slopes {
    /// 1/direction, finite.
    inverse: [f32; 3],
    /// origin/direction.
    shift: [f32; 3],
    /// Eight times the row of the plane that is met first, per axis: its first number's place in the node.
    first: [usize; 3],
}

impl Beam {
    /// A parameter of the ray in the tree's, rounded up.
    #[inline(always)]
    pub fn to_unit(self, t: f64) -> f32 {
        let t = ((t - self.start) * self.scale + self.pad) as f32;
        // The next number at least.
        t + t.abs() * f32::EPSILON
    }

    #[inline(always)]
    pub fn slopes(&self) -> Slopes {
        // A component below 1.2e-7 counts as that.
        let most = Vec3A::splat(1.0 / f32::EPSILON);
        let inverse = self.dir.recip().max(-most).min(most);
        // By the sign, which is there before the inverse is.
        let back = self.dir.is_negative_bitmask() as usize;
        Slopes {
            inverse: inverse.to_array(),
            shift: (self.origin * inverse).to_array(),
            first: [8 * ((back & 1) * OTHER), 8 * (1 + ((back >> 1) & 1) * OTHER), 8 * (2 + ((back >> 2) & 1) * OTHER)],
        }
    }
}

/// Which boxes are met at 0 ≤ t ≤ reach, a bit each, and where they are entered.
#[inline(always)]
pub fn enter(lanes: Option<Lanes>, node: &Node, slopes: &Slopes, reach: f32) -> (u32, [f32; 8]) {
    match lanes {
        #[cfg(target_arch = "x86_64")]
        Some(lanes) => enter_in_lanes(lanes, node, slopes, reach),
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
        let (one, two) = (&node.rows[(first / 8) & 7], &node.rows[((first / 8) ^ OTHER) & 7]);
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
#[inline(always)]
fn enter_in_lanes(_: Lanes, node: &Node, slopes: &Slopes, reach: f32) -> (u32, [f32; 8]) {
    use std::arch::x86_64::*;
    let mut entered = [0.0f32; 8];
    // SAFETY: `Lanes` says that the processor has what the functions need; eight numbers are read and written, and they
    // are there.
    let mask = unsafe {
        let (mut near, mut far) = (_mm256_setzero_ps(), _mm256_set1_ps(reach));
        let planes = node.rows.as_flattened().as_ptr();
        for axis in 0..3 {
            let first = slopes.first[axis] & 56;
            let (inverse, shift) = (_mm256_set1_ps(slopes.inverse[axis]), _mm256_set1_ps(slopes.shift[axis]));
            let (one, two) = (_mm256_load_ps(planes.add(first)), _mm256_load_ps(planes.add(first ^ (8 * OTHER))));
            near = _mm256_max_ps(_mm256_fmsub_ps(one, inverse, shift), near);
            far = _mm256_min_ps(_mm256_fmsub_ps(two, inverse, shift), far);
        }
        _mm256_storeu_ps(entered.as_mut_ptr(), near);
        _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(near, far)) as u32
    };
    (mask, entered)
}
