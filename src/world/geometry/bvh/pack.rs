//! Four triangles of a leaf at a time: where a line passes through them, by the arithmetic of
//! `Shear::cross` of `patch.rs`, operation by operation, so the two agree to the bit.

use super::super::patch::Shear;
use super::super::triangle::Triangle;
use super::node::Lanes;
use super::wide::{LEAF_SIZE, Leaf};
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
            #[cfg(target_arch = "x86_64")]
            Some(lanes) => self.cross_in_lanes(lanes, shear, through, [start, reach]),
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
    #[inline(always)]
    fn cross_in_lanes(&self, _: Lanes, shear: &Shear, through: DVec3, [start, reach]: [f64; 2]) -> Option<Crossings> {
        use std::arch::x86_64::*;
        // SAFETY: `Lanes` says that the processor has what the functions need; four numbers at a time are read and
        // written, and they are there.
        unsafe {
            let axes = [shear.axes[0].min(2), shear.axes[1].min(2), shear.axes[2].min(2)];
            let o = [through.x, through.y, through.z];
            let (sx, sy) = (_mm256_set1_pd(shear.shear[0]), _mm256_set1_pd(shear.shear[1]));
            let (ox, oy, oz) = (_mm256_set1_pd(o[axes[0]]), _mm256_set1_pd(o[axes[1]]), _mm256_set1_pd(o[axes[2]]));
            let (mut x, mut y, mut z) = ([ox; 3], [oy; 3], [oz; 3]);
            for (corner, places) in self.corners.iter().enumerate() {
                let (px, py, pz) = (places[axes[0]].as_ptr(), places[axes[1]].as_ptr(), places[axes[2]].as_ptr());
                z[corner] = _mm256_sub_pd(_mm256_cvtps_pd(_mm_load_ps(pz)), oz);
                let (dx, dy) = (_mm256_mul_pd(sx, z[corner]), _mm256_mul_pd(sy, z[corner]));
                x[corner] = _mm256_sub_pd(_mm256_sub_pd(_mm256_cvtps_pd(_mm_load_ps(px)), ox), dx);
                y[corner] = _mm256_sub_pd(_mm256_sub_pd(_mm256_cvtps_pd(_mm_load_ps(py)), oy), dy);
            }
            let u = _mm256_sub_pd(_mm256_mul_pd(x[2], y[1]), _mm256_mul_pd(y[2], x[1]));
            let v = _mm256_sub_pd(_mm256_mul_pd(x[0], y[2]), _mm256_mul_pd(y[0], x[2]));
            let w = _mm256_sub_pd(_mm256_mul_pd(x[1], y[0]), _mm256_mul_pd(y[1], x[0]));
            let zero = _mm256_setzero_pd();
            // Where none of them is a number, as in lanes without a triangle, neither is so; where one of them is not, t
            // is none either.
            let least = _mm256_min_pd(_mm256_min_pd(u, v), w);
            let most = _mm256_max_pd(_mm256_max_pd(u, v), w);
            let not_less = _mm256_cmp_pd::<_CMP_GE_OQ>(least, zero);
            let not_more = _mm256_cmp_pd::<_CMP_LE_OQ>(most, zero);
            let inside = _mm256_or_pd(not_less, not_more);
            if _mm256_movemask_pd(inside) == 0 {
                return None;
            }
            let inverse = _mm256_div_pd(_mm256_set1_pd(1.0), _mm256_add_pd(_mm256_add_pd(u, v), w));
            let heights =
                _mm256_add_pd(_mm256_add_pd(_mm256_mul_pd(u, z[0]), _mm256_mul_pd(v, z[1])), _mm256_mul_pd(w, z[2]));
            let t = _mm256_mul_pd(_mm256_mul_pd(heights, _mm256_set1_pd(shear.shear[2])), inverse);
            // Edge-on and invalid triangles end here: their t is infinite or not a number.
            let magnitude = _mm256_andnot_pd(_mm256_set1_pd(-0.0), t);
            let finite = _mm256_cmp_pd::<_CMP_LT_OQ>(magnitude, _mm256_set1_pd(f64::INFINITY));
            let t = _mm256_add_pd(_mm256_set1_pd(start), t);
            let ahead = _mm256_cmp_pd::<_CMP_GT_OQ>(t, zero);
            let near = _mm256_cmp_pd::<_CMP_LE_OQ>(t, _mm256_set1_pd(reach));
            let counts = _mm256_and_pd(_mm256_and_pd(ahead, near), _mm256_and_pd(finite, inside));
            let inside = _mm256_movemask_pd(counts) as u32;
            if inside == 0 {
                return None;
            }
            let mut all = Crossings { inside, t: [0.0; LEAF_SIZE], weights: [[0.0; LEAF_SIZE]; 3] };
            _mm256_storeu_pd(all.t.as_mut_ptr(), t);
            _mm256_storeu_pd(all.weights[0].as_mut_ptr(), _mm256_mul_pd(u, inverse));
            _mm256_storeu_pd(all.weights[1].as_mut_ptr(), _mm256_mul_pd(v, inverse));
            _mm256_storeu_pd(all.weights[2].as_mut_ptr(), _mm256_mul_pd(w, inverse));
            Some(all)
        }
    }
}
