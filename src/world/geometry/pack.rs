//! Four triangles of a leaf at a time: where a line passes through them, by the arithmetic of
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

/// Where a line passes through the triangles of a leaf.
pub struct Crossings {
    /// A bit for each lane that counts.
    pub inside: u32,
    pub t: [f64; LEAF_SIZE],
    /// Per corner and lane.
    pub weights: [[f64; LEAF_SIZE]; 3],
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

    /// Where the line through `through` passes through the triangles at 0 < t ≤ reach, t from `start` before `through`;
    /// none if it passes through none of them.
    #[inline(always)]
    pub fn cross(
        &self,
        lanes: Option<Lanes>,
        shear: &Shear,
        through: DVec3,
        [start, reach]: [f64; 2],
    ) -> Option<Crossings> {
        match lanes {
            // SAFETY: `Lanes` says that the processor has what the function needs.
            #[cfg(target_arch = "x86_64")]
            Some(_) => unsafe { self.cross_in_lanes(shear, through, [start, reach]) },
            #[cfg(not(target_arch = "x86_64"))]
            Some(_) => self.cross_by_one(shear, through, [start, reach]),
            None => self.cross_by_one(shear, through, [start, reach]),
        }
    }

    /// The slot of a lane.
    #[inline(always)]
    pub fn slot(&self, lane: usize) -> u32 {
        self.leaf.first + lane as u32
    }

    /// Face of the part and triangle of the mesh.
    #[inline(always)]
    pub fn whose(&self, lane: usize) -> (u32, u32) {
        (self.faces[lane & 3], self.indices[lane & 3])
    }

    #[inline(always)]
    pub fn triangle(&self, lane: usize) -> Triangle {
        let [a, b, c] = &self.corners;
        let lane = lane & 3;
        let corners = [
            [a[0][lane], a[1][lane], a[2][lane]],
            [b[0][lane], b[1][lane], b[2][lane]],
            [c[0][lane], c[1][lane], c[2][lane]],
        ];
        Triangle { corners, face: self.faces[lane], index: self.indices[lane] }
    }

    #[inline]
    fn cross_by_one(&self, shear: &Shear, through: DVec3, [start, reach]: [f64; 2]) -> Option<Crossings> {
        let mut all = Crossings { inside: 0, t: [0.0; LEAF_SIZE], weights: [[0.0; LEAF_SIZE]; 3] };
        for lane in 0..LEAF_SIZE.min(self.leaf.count as usize) {
            let Some(crossing) = shear.cross(&self.triangle(lane).corners, through) else { continue };
            let t = start + crossing.t;
            all.t[lane] = t;
            for corner in 0..3 {
                all.weights[corner][lane] = crossing.weights[corner];
            }
            all.inside |= u32::from(t > 0.0 && t <= reach) << lane;
        }
        (all.inside != 0).then_some(all)
    }

    /// The same, all four at a time.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    #[inline]
    fn cross_in_lanes(&self, shear: &Shear, through: DVec3, [start, reach]: [f64; 2]) -> Option<Crossings> {
        use std::arch::x86_64::*;
        let (axes, o) = (shear.axes.map(|axis| axis.min(2)), through.to_array());
        let (sx, sy) = (_mm256_set1_pd(shear.shear[0]), _mm256_set1_pd(shear.shear[1]));
        let (ox, oy, oz) = (_mm256_set1_pd(o[axes[0]]), _mm256_set1_pd(o[axes[1]]), _mm256_set1_pd(o[axes[2]]));
        // SAFETY: four numbers are read, and they are there.
        let load = |places: &[f32; LEAF_SIZE]| unsafe { _mm256_cvtps_pd(_mm_loadu_ps(places.as_ptr())) };
        let flat = |places: &[[f32; LEAF_SIZE]; 3]| {
            let z = _mm256_sub_pd(load(&places[axes[2]]), oz);
            let x = _mm256_sub_pd(_mm256_sub_pd(load(&places[axes[0]]), ox), _mm256_mul_pd(sx, z));
            let y = _mm256_sub_pd(_mm256_sub_pd(load(&places[axes[1]]), oy), _mm256_mul_pd(sy, z));
            [x, y, z]
        };
        let (a, b, c) = (flat(&self.corners[0]), flat(&self.corners[1]), flat(&self.corners[2]));
        let turn =
            |p: [__m256d; 3], q: [__m256d; 3]| _mm256_sub_pd(_mm256_mul_pd(p[0], q[1]), _mm256_mul_pd(p[1], q[0]));
        let (u, v, w) = (turn(c, b), turn(a, c), turn(b, a));
        let zero = _mm256_setzero_pd();
        // Where one of them is not a number, t is none either.
        let least = _mm256_min_pd(_mm256_min_pd(u, v), w);
        let most = _mm256_max_pd(_mm256_max_pd(u, v), w);
        let outside = _mm256_and_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(least, zero), _mm256_cmp_pd::<_CMP_GT_OQ>(most, zero));
        let inside = !_mm256_movemask_pd(outside) as u32 & ((1 << self.leaf.count) - 1);
        if inside == 0 {
            return None;
        }
        let inverse = _mm256_div_pd(_mm256_set1_pd(1.0), _mm256_add_pd(_mm256_add_pd(u, v), w));
        let heights =
            _mm256_add_pd(_mm256_add_pd(_mm256_mul_pd(u, a[2]), _mm256_mul_pd(v, b[2])), _mm256_mul_pd(w, c[2]));
        let t = _mm256_mul_pd(_mm256_mul_pd(heights, _mm256_set1_pd(shear.shear[2])), inverse);
        // Edge-on and invalid triangles end here: their t is infinite or not a number.
        let magnitude = _mm256_andnot_pd(_mm256_set1_pd(-0.0), t);
        let finite = _mm256_cmp_pd::<_CMP_LT_OQ>(magnitude, _mm256_set1_pd(f64::INFINITY));
        let t = _mm256_add_pd(_mm256_set1_pd(start), t);
        let ahead = _mm256_cmp_pd::<_CMP_GT_OQ>(t, zero);
        let near = _mm256_cmp_pd::<_CMP_LE_OQ>(t, _mm256_set1_pd(reach));
        let inside = inside & _mm256_movemask_pd(_mm256_and_pd(_mm256_and_pd(ahead, near), finite)) as u32;
        if inside == 0 {
            return None;
        }
        let store = |x| {
            let mut numbers = [0.0; LEAF_SIZE];
            // SAFETY: four numbers are written, and there is room for them.
            unsafe { _mm256_storeu_pd(numbers.as_mut_ptr(), x) };
            numbers
        };
        let weights = [u, v, w].map(|x| store(_mm256_mul_pd(x, inverse)));
        Some(Crossings { inside, t: store(t), weights })
    }
}
