//! Lattices: points that fill the unit cube evenly however many there are, moved together by a random shift.
//!
//! Steps along the axes are powers h, h², … hⁿ of the root of hⁿ + hⁿ⁺¹ = 1 (M. Roberts, "The unreasonable effectiveness of
//! quasirandom sequences", 2018), which no whole numbers relate. In his order, n = D and powers from 1 on, some are near 1,
//! 2/3 or 6/7: the first points lie side by side along that axis, or on three places, or on seven, and their mean errs by
//! more than that of independent points would. So the powers are others, found by the mean squared error over all shifts,
//! Σ S(k)·sin²(πNθ)/(N sin πθ)² over whole-numbered k ≠ 0 with θ = k·step: S is the spectrum of edges in any direction, |k|⁻³ in
//! two dimensions, and of upright ones; N from 2 to 8192, in relation to what independent points err by. Of all n up to 12 it
//! is least with n = 9 for the first two axes; with these for the next two, pairs across and edges askew to all four; and so on.
//! For three axes, whose pairs with four others count too, n = 10 has it nearly as small as any.

/// Point `index` of a lattice of `D` dimensions, moved by `shift` (fractions of 2⁶⁴): each point alone is uniform where the
/// shift is, and all points so far are spread evenly, most of all in the first two dimensions. Those from the fourth on are a
/// compromise: alone, their first eight points are no more even than by chance.
///
/// Lattices of three dimensions are not in step with those of four: for paths that take their points from both.
pub fn lattice<const D: usize>(shift: [u64; D], index: u64) -> [f64; D] {
    let steps = const { steps::<D>() };
    std::array::from_fn(|axis| {
        let fraction = shift[axis].wrapping_add(index.wrapping_mul(steps[axis]));
        (fraction >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    })
}

/// As fractions of 2⁶⁴.
const fn steps<const D: usize>() -> [u64; D] {
    let (n, powers): (usize, &[usize]) = match D {
        // The golden ratio.
        1 => (1, &[1]),
        // As he has it: nothing measured that goes by two axes alone gained by others.
        2 => (2, &[1, 2]),
        3 => (10, &[4, 7, 5]),
        _ => (9, &[5, 8, 6, 9, 3, 4]),
    };
    assert!(D <= powers.len());
    let h = root(n);
    let mut steps = [0u64; D];
    let mut axis = 0;
    while axis < D {
        steps[axis] = (power(h, powers[axis]) * 18_446_744_073_709_551_616.0) as u64;
        axis += 1;
    }
    steps
}

/// h with hⁿ + hⁿ⁺¹ = 1, by Newton's iteration.
const fn root(n: usize) -> f64 {
    let mut h = 0.8f64;
    let mut round = 0;
    while round < 32 {
        let below = power(h, n - 1);
        let (value, slope) = (below * h * (1.0 + h) - 1.0, below * (n as f64 + (n as f64 + 1.0) * h));
        h -= value / slope;
        round += 1;
    }
    h
}

const fn power(h: f64, k: usize) -> f64 {
    let (mut power, mut factors) = (1.0, 0);
    while factors < k {
        power *= h;
        factors += 1;
    }
    power
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Rng, Stream};
    use std::f64::consts::PI;

    /// Over 64 shifts the area of a small disc has no bias and less than a third of the error of independent points.
    #[test]
    fn a_lattice_finds_a_small_image_evenly() {
        const POINTS: u64 = 4096;
        let area = PI * 0.01;
        let mut rng = Rng::new(5, Stream::Check, 0, 0);
        let errors: Vec<f64> = (0..64)
            .map(|_| {
                let shift = [rng.next_u64(), rng.next_u64()];
                let inside = (0..POINTS).filter(|&index| {
                    let [x, y] = lattice(shift, index);
                    (x - 0.4).powi(2) + (y - 0.6).powi(2) < 0.01
                });
                inside.count() as f64 / POINTS as f64 - area
            })
            .collect();
        let independent = (area * (1.0 - area) / POINTS as f64).sqrt();
        let rms = (errors.iter().map(|e| e * e).sum::<f64>() / 64.0).sqrt();
        let mean = errors.iter().sum::<f64>() / 64.0;
        assert!(rms < independent / 3.0, "rms {rms}, independent points {independent}");
        assert!(mean.abs() < 4.0 * rms / 8.0, "mean {mean}, rms {rms}");
    }

    /// The golden ratio, and roots of the equation.
    #[test]
    fn steps_solve_their_equation() {
        let is = |steps: &[u64], k: usize| steps[k] as f64 / 2f64.powi(64);
        assert!((is(&steps::<1>(), 0) - (5f64.sqrt() - 1.0) / 2.0).abs() < 1e-15);
        // Of ten powers the fifth over the fourth, of nine the ninth over the eighth.
        let [ten, nine] = [is(&steps::<3>(), 2) / is(&steps::<3>(), 0), is(&steps::<4>(), 3) / is(&steps::<4>(), 1)];
        assert!((ten.powi(10) * (1.0 + ten) - 1.0).abs() < 1e-13 && (nine.powi(9) * (1.0 + nine) - 1.0).abs() < 1e-13);
        assert!((is(&steps::<3>(), 1) - ten.powi(7)).abs() < 1e-14);
        for (axis, k) in [5, 8, 6, 9, 3, 4].into_iter().enumerate() {
            assert!((is(&steps::<6>(), axis) - nine.powi(k)).abs() < 1e-14);
        }
        assert!((is(&steps::<2>(), 0) - 1.0 / 1.324_717_957_244_746).abs() < 1e-15);
        assert_eq!(steps::<4>()[..], steps::<6>()[..4]);
    }

    /// The mean of `of_one` over many random numbers.
    fn mean(of_one: impl Fn(&mut Rng) -> f64) -> f64 {
        const COUNT: u64 = 20_000;
        (0..COUNT).map(|number| of_one(&mut Rng::new(7, Stream::Check, number, 0))).sum::<f64>() / COUNT as f64
    }

    fn shift<const D: usize>(rng: &mut Rng) -> [u64; D] {
        std::array::from_fn(|_| rng.next_u64())
    }

    /// Mean squared error of the share of an axis beyond an edge, over that of independent points: these have the variance
    /// p(1 − p)/N, in the mean 1/(6N). With n = D and powers from 1 on the first axis of six had 1.45 after two points and
    /// 1.58 after four, of four 0.93 after four and 0.84 after 64, and the second of three 1.24 after 32.
    #[test]
    fn the_first_points_find_upright_edges() {
        fn error<const D: usize>(points: u64, axis: usize) -> f64 {
            let of_one = |rng: &mut Rng| {
                let (shift, edge) = (shift::<D>(rng), rng.uniform());
                let beyond = (0..points).filter(|&index| lattice(shift, index)[axis] >= edge).count();
                (beyond as f64 / points as f64 - (1.0 - edge)).powi(2)
            };
            6.0 * points as f64 * mean(of_one)
        }
        for (points, most) in [(2, 1.0), (4, 0.6), (16, 0.3), (32, 0.2), (64, 0.12)] {
            for axis in 0..2 {
                let of_three = error::<3>(points, axis);
                let of_others = error::<6>(points, axis);
                assert!(of_three.max(of_others) < most, "{points} points, axis {axis}: {of_three} {of_others}");
            }
        }
    }

    /// The same for edges in any direction through a square: of the first two axes, of the next two, and of one of each.
    #[test]
    fn the_first_points_find_edges() {
        fn error<const D: usize>(points: u64, axes: [usize; 2]) -> f64 {
            // Over that of as many independent points, from the same edges.
            let of_one = |rng: &mut Rng, even: bool| {
                let (shift, (sin, cos)) = (shift::<D>(rng), (2.0 * PI * rng.uniform()).sin_cos());
                let is_beyond = |[x, y]: [f64; 2], far: f64| (x - 0.5) * cos + (y - 0.5) * sin > far;
                let far = (rng.uniform() - 0.5) * (cos.abs() + sin.abs());
                let area =
                    (0..256).filter(|k| is_beyond([0, 4].map(|by| ((k >> by) % 16) as f64 / 16.0 + 1.0 / 32.0), far));
                let area = area.count() as f64 / 256.0;
                let found = (0..points).filter(|&index| {
                    let at = if even { lattice(shift, index) } else { std::array::from_fn(|_| rng.uniform()) };
                    is_beyond(axes.map(|axis| at[axis]), far)
                });
                (found.count() as f64 / points as f64 - area).powi(2)
            };
            mean(|rng| of_one(rng, true)) / mean(|rng| of_one(rng, false))
        }
        for (points, of_two, of_three, others) in [(4, 0.62, 0.68, 0.95), (16, 0.35, 0.48, 0.75), (64, 0.2, 0.25, 0.55)]
        {
            let three = error::<3>(points, [0, 1]);
            assert!(three < of_three, "{points} points of three dimensions: {three}");
            for (axes, most) in [([0, 1], of_two), ([2, 3], others), ([0, 2], others), ([1, 3], others)] {
                let six = error::<6>(points, axes);
                assert!(six < most, "{points} points, axes {axes:?}: {six}");
            }
        }
    }

    /// Lattices of three and of four dimensions that serve the same path are not in step: a product of one coordinate of each
    /// has the mean of independent ones.
    #[test]
    fn lattices_of_three_and_four_are_not_in_step() {
        let mut rng = Rng::new(8, Stream::Check, 0, 0);
        let (three, four) = (shift::<3>(&mut rng), shift::<4>(&mut rng));
        for [a, b] in (0..12).map(|k| [k / 4, k % 4]) {
            let both = (0..4096).map(|index| (lattice(three, index)[a] - 0.5) * (lattice(four, index)[b] - 0.5));
            let mean = both.sum::<f64>() / 4096.0;
            // Independent ones have a standard deviation of 1/(12·64); in step it would be up to 1/12.
            assert!(mean.abs() < 2.0 / (12.0 * 64.0), "{a} {b}: {mean}");
        }
    }
}
