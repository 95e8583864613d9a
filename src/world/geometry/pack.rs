//! Four triangles of a leaf at a time: which of them a line passes through, by the arithmetic of
//! [`Shear::cross`](super::patch::Shear::cross), operation by operation, so the two agree to the bit.

use super::patch::Shear;
use super::solid::Triangle;
use super::wide::{LEAF_SIZE, Lanes, Leaf};
use glam::DVec3;

/// The triangles of a leaf, one lane each.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub struct Pack {
    /// Per corner and coordinate.
    corners: [[[f32; LEAF_SIZE]; 3]; 3],
    faces: [u32; LEAF_SIZE],
    indices: [u32; LEAF_SIZE],
    leaf: Leaf,
}

impl Pack {
    /// Of the triangles of a leaf, in order.
    pub fn new(leaf: Leaf, triangles: &[Triangle]) -> Pack {
        let mut corners = [[[f32::NAN; LEAF_SIZE]; 3]; 3];
        let (mut faces, mut indices) = ([u32::MAX; LEAF_SIZE], [u32::MAX; LEAF_SIZE]);
        for (lane, triangle) in triangles.iter().take(LEAF_SIZE).enumerate() {
            for (corner, place) in triangle.corners.iter().enumerate() {
                for (axis, x) in place.iter().enumerate() {
                    corners[corner][axis][lane] = *x;
                }
            }
            (faces[lane], indices[lane]) = (triangle.face, triangle.index);
        }
        Pack { corners, faces, indices, leaf }
    }

    /// The slots and triangles that the line through `through` passes through; edge-on ones may be among them.
    #[inline(always)]
    pub fn cross<'a>(
        &'a self,
        lanes: Option<Lanes>,
        shear: &Shear,
        through: DVec3,
    ) -> impl Iterator<Item = (u32, Triangle)> + use<'a> {
        let inside = match lanes {
            // SAFETY: `Lanes` says that the processor has what the function needs.
            #[cfg(target_arch = "x86_64")]
            Some(_) => unsafe { self.inside_in_lanes(shear, through) },
            #[cfg(not(target_arch = "x86_64"))]
            Some(_) => self.inside(shear, through),
            None => self.inside(shear, through),
        };
        let mut inside = inside & ((1 << self.leaf.count) - 1);
        std::iter::from_fn(move || {
            let lane = (inside != 0).then(|| (inside.trailing_zeros() & 3) as usize)?;
            inside &= inside - 1;
            Some((self.leaf.first + lane as u32, self.triangle(lane)))
        })
    }

    #[inline(always)]
    fn triangle(&self, lane: usize) -> Triangle {
        let [a, b, c] = &self.corners;
        let corners = [
            [a[0][lane], a[1][lane], a[2][lane]],
            [b[0][lane], b[1][lane], b[2][lane]],
            [c[0][lane], c[1][lane], c[2][lane]],
        ];
        Triangle { corners, face: self.faces[lane], index: self.indices[lane] }
    }

    /// A bit for each lane.
    #[inline]
    fn inside(&self, shear: &Shear, through: DVec3) -> u32 {
        (0..LEAF_SIZE).fold(0, |inside, lane| {
            u32::from(shear.cross(&self.triangle(lane).corners, through).is_some()) << lane | inside
        })
    }

    /// The same, all four at a time.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    #[inline]
    fn inside_in_lanes(&self, shear: &Shear, through: DVec3) -> u32 {
        use std::arch::x86_64::*;
        let (axes, o) = (shear.axes, through.to_array());
        let (sx, sy) = (_mm256_set1_pd(shear.shear[0]), _mm256_set1_pd(shear.shear[1]));
        let (ox, oy, oz) = (_mm256_set1_pd(o[axes[0]]), _mm256_set1_pd(o[axes[1]]), _mm256_set1_pd(o[axes[2]]));
        // SAFETY: four numbers are read, and they are there.
        let load = |places: &[f32; LEAF_SIZE]| unsafe { _mm256_cvtps_pd(_mm_loadu_ps(places.as_ptr())) };
        let flat = |places: &[[f32; LEAF_SIZE]; 3]| {
            let z = _mm256_sub_pd(load(&places[axes[2]]), oz);
            let x = _mm256_sub_pd(_mm256_sub_pd(load(&places[axes[0]]), ox), _mm256_mul_pd(sx, z));
            let y = _mm256_sub_pd(_mm256_sub_pd(load(&places[axes[1]]), oy), _mm256_mul_pd(sy, z));
            (x, y)
        };
        let (a, b, c) = (flat(&self.corners[0]), flat(&self.corners[1]), flat(&self.corners[2]));
        let turn = |p: (__m256d, __m256d), q: (__m256d, __m256d)| {
            _mm256_sub_pd(_mm256_mul_pd(p.0, q.1), _mm256_mul_pd(p.1, q.0))
        };
        let (u, v, w) = (turn(c, b), turn(a, c), turn(b, a));
        let zero = _mm256_setzero_pd();
        let below = |x| _mm256_cmp_pd::<_CMP_LT_OQ>(x, zero);
        let above = |x| _mm256_cmp_pd::<_CMP_GT_OQ>(x, zero);
        let any_below = _mm256_or_pd(_mm256_or_pd(below(u), below(v)), below(w));
        let any_above = _mm256_or_pd(_mm256_or_pd(above(u), above(v)), above(w));
        !_mm256_movemask_pd(_mm256_and_pd(any_below, any_above)) as u32
    }
}
