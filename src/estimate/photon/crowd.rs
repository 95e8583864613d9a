//! Where photons are crowded their kernels are smaller, so that a focus is as sharp as its photons can draw it and does not
//! light what lies beside it. A box with too many photons is halved along each axis, and the radius of their kernels with it:
//! their areas fall about as the density of photons rises, and by that law what kernels blur goes as r⁴, not as r²
//! (I. Abramson, "On bandwidth variation in kernel estimates", Ann. Stat. 10, 1982).
//!
//! A photon's kernel depends on how many others lie about it, and none of them on the photon. So the mean of the picture is
//! the light blurred by such kernels, each of which brings all that its photon has.

use glam::DVec3;

/// How often a radius is halved at most: two pixels to a quarter of one, and no picture shows less.
pub const MOST: usize = 3;

/// How often the radius of each photon's kernel is halved. `positions`: in boxes of `side` about a lattice at the origin;
/// those in different boxes are taken as if they were in one. `enough`: photons in a box that is not halved.
pub fn halvings(positions: &[DVec3], side: f64, enough: f64) -> Vec<u8> {
    let mut found = vec![0; positions.len()];
    let mut order: Vec<usize> = (0..positions.len()).collect();
    part((positions, side, enough), &mut order, 0, &mut found);
    found
}

fn part((positions, side, enough): (&[DVec3], f64, f64), order: &mut [usize], halved: u8, found: &mut [u8]) {
    if order.len() as f64 <= enough || usize::from(halved) == MOST {
        order.iter().for_each(|&photon| found[photon] = halved);
        return;
    }
    let side = 0.5 * side;
    let octant = |photon: &usize| (positions[*photon] / side).floor().rem_euclid(DVec3::splat(2.0)).to_array();
    let number = |photon: &usize| octant(photon).iter().fold(0.0, |number, half| 2.0 * number + half) as u8;
    order.sort_by_cached_key(number);
    for each in order.chunk_by_mut(|a, b| number(a) == number(b)) {
        part((positions, side, enough), each, halved + 1, found);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::rng::{Rng, Stream};

    /// A square of density 1, which is not too much for boxes of side 8, with a corner of density 13, not too much for those of side 4.
    #[test]
    fn halves_where_photons_are_crowded() {
        let mut rng = Rng::new(1, Stream::Check, 0, 0);
        let mut square = |number: usize, side: f64| -> Vec<DVec3> {
            (0..number).map(|_| DVec3::new(side * rng.uniform() - 8.0, side * rng.uniform() - 8.0, -0.3)).collect()
        };
        let thin = square(256, 16.0);
        assert_eq!(halvings(&thin, 16.0, 256.0), vec![0; 256]);
        let all: Vec<DVec3> = thin.iter().copied().chain(square(768, 8.0)).collect();
        let found = halvings(&all, 16.0, 256.0);
        for (position, halved) in all.iter().zip(found) {
            let dense = position.x < 0.0 && position.y < 0.0;
            assert_eq!(halved, if dense { 2 } else { 1 }, "{position}");
        }
        let point = vec![DVec3::splat(0.3); 1000];
        assert_eq!(halvings(&point, 1.0, 16.0), vec![MOST as u8; 1000], "no end");
        assert!(halvings(&[], 1.0, 16.0).is_empty());
    }
}
