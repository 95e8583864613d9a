//! Which cells of a grid across a height field its triangles cover without a gap: there a point belongs to the face
//! whatever triangle it belongs to, and none need be looked at.
//!
//! With all triangles turned alike in the plane, the number of them about a point changes only across edges that are not
//! passed once each way: the rims of the face, folds, and vertices of one triangle on the edge of another. Where no such
//! edge comes into a cell, all of it is covered or nothing.

use glam::DVec2;
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// Edges between numbers of triangles that differ, in no order.
pub fn open_edges(flat: &[[DVec2; 3]]) -> Vec<[DVec2; 2]> {
    let mut passed: HashMap<Ends, i32, BuildHasherDefault<Mixer>> =
        HashMap::with_capacity_and_hasher(2 * flat.len(), BuildHasherDefault::default());
    for t in flat {
        let turn = (t[1] - t[0]).perp_dot(t[2] - t[0]);
        // What is edge-on contains nothing. What rounding turns the wrong way opens its edges, which is safe.
        let way = if turn > 0.0 {
            1
        } else if turn < 0.0 {
            -1
        } else {
            continue;
        };
        for i in 0..3 {
            let [a, b] = [t[i], t[(i + 1) % 3]].map(|p| [p.x.to_bits(), p.y.to_bits()]);
            let (ends, way) = if a < b { (Ends([a, b]), way) } else { (Ends([b, a]), -way) };
            *passed.entry(ends).or_default() += way;
        }
    }
    let open = passed.into_iter().filter(|(_, ways)| *ways != 0);
    open.map(|(Ends(ends), _)| ends.map(|[x, y]| DVec2::new(f64::from_bits(x), f64::from_bits(y)))).collect()
}

/// An edge by the bits of its ends: triangles that share it have the very same corners.
#[derive(PartialEq, Eq)]
struct Ends([[u64; 2]; 2]);

impl std::hash::Hash for Ends {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.0.iter().flatten().for_each(|bits| state.write_u64(*bits));
    }
}

/// A hash for the bits of numbers, which nobody chooses to make them collide.
#[derive(Default)]
struct Mixer(u64);

impl Hasher for Mixer {
    fn finish(&self) -> u64 {
        self.0 ^ self.0 >> 29
    }
    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|byte| self.write_u64(u64::from(*byte)));
    }
    fn write_u64(&mut self, bits: u64) {
        let mixed = (self.0 ^ bits).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        self.0 = mixed ^ mixed >> 32;
    }
}
