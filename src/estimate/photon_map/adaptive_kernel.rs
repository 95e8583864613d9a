//! Where photons are crowded their kernels are smaller, so that a focus is as sharp as its photons can draw it and does not
//! light what lies beside it. Boxes with too many photons are halved along each axis until few are left, and the more of them
//! there are per area the smaller is the area of their kernels. By that law what kernels blur goes as r⁴, not as r²
//! (I. Abramson, "On bandwidth variation in kernel estimates", Ann. Stat. 10, 1982).
//!
//! A photon's kernel depends on how many others lie about it, and none of them on the photon. So the mean of the picture is
//! the light blurred by such kernels, each of which brings all that its photon has. Where kernels change from box to box
//! light is missing on one side and too much on the other: they change little, and in each pass boxes lie elsewhere.

pub use super::tuning::adaptive_kernel::{HALVINGS, MOST, STEPS};
use glam::DVec3;

/// A radius after so many steps.
pub fn radius(whole: f64, steps: usize) -> f64 {
    whole * 0.5f64.powf(steps as f64 / STEPS as f64)
}

/// By how many steps the radius of each photon's kernel is smaller. `positions`: in boxes of `side` about a lattice at the
/// origin; those in different boxes are taken as if they were in one. `enough`: photons in a box for the whole radius.
pub fn steps(positions: &[DVec3], side: f64, enough: f64) -> Vec<u8> {
    let mut found = vec![0; positions.len()];
    let mut order: Vec<usize> = (0..positions.len()).collect();
    part((positions, side, enough), &mut order, 0, &mut found);
    found
}

fn part((positions, side, enough): (&[DVec3], f64, f64), order: &mut [usize], halved: usize, found: &mut [u8]) {
    let number = order.len() as f64;
    if number <= enough || halved == HALVINGS {
        // Of a box that is not halved, as if it were one of a whole one full of such boxes.
        let of_whole = number * 4.0f64.powi(halved as i32);
        let steps = (0.5 * STEPS as f64 * (of_whole / enough).log2()).round().clamp(0.0, MOST as f64) as u8;
        order.iter().for_each(|&photon| found[photon] = steps);
        return;
    }
    let side = 0.5 * side;
    let octant = |photon: &usize| (positions[*photon] / side).floor().rem_euclid(DVec3::splat(2.0)).to_array();
    let corner = |photon: &usize| octant(photon).iter().fold(0.0, |bits, half| 2.0 * bits + half) as u8;
    order.sort_by_cached_key(corner);
    for each in order.chunk_by_mut(|a, b| corner(a) == corner(b)) {
        part((positions, side, enough), each, halved + 1, found);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyebox_base::rng::{Rng, Stream};

    /// A square of density 1 with a corner of density 17; 16 are enough in a box of side 4.
    #[test]
    fn radii_are_smaller_where_photons_are_crowded() {
        let mut rng = Rng::new(1, Stream::Check, 0, 0);
        let mut square = |number: usize, side: f64| -> Vec<DVec3> {
            (0..number).map(|_| DVec3::new(side * rng.uniform() - 8.0, side * rng.uniform() - 8.0, -0.3)).collect()
        };
        let thin = square(256, 16.0);
        assert_eq!(steps(&thin, 16.0, 256.0), vec![0; 256]);
        let all: Vec<DVec3> = thin.iter().copied().chain(square(1024, 8.0)).collect();
        for (position, steps) in all.iter().zip(steps(&all, 16.0, 256.0)) {
            let steps = i32::from(steps);
            let dense = position.x < 0.0 && position.y < 0.0;
            // The root of 17 is 16.3 steps; of the 68 photons in a box of side 2 a quarter more are 1.3.
            assert!(if dense { (steps - 16).abs() <= 3 } else { steps <= 3 }, "{position}: {steps}");
        }
        let point = vec![DVec3::splat(0.3); 10_000];
        assert_eq!(steps(&point, 1.0, 16.0), vec![MOST as u8; 10_000], "no end");
        assert!(steps(&[], 1.0, 16.0).is_empty());
        assert_eq!(radius(4.0, MOST), 0.5);
    }
}
