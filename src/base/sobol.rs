//! Points that fill the unit cube evenly: Sobol' sequences, randomised by nested uniform (Owen) scrambling, so that each
//! point is uniform and different scrambles are independent (A. B. Owen, "Randomly permuted (t,m,s)-nets and
//! (t,s)-sequences", 1995).
//!
//! Scrambling by hashing as in B. Burley, "Practical hash-based Owen scrambling", JCGT 9(4), 2020, after S. Laine and
//! T. Karras 2011, with the constants of N. Vegdahl, "Building a better LK hash", 2021. What lies below the 32 bits of a
//! net is plain random.

use super::rng::{Rng, Stream, mix};

/// Primitive polynomials and initial numbers of S. Joe and F. Y. Kuo, "Constructing Sobol sequences with better
/// two-dimensional projections", SIAM J. Sci. Comput. 30, 2008 (table `new-joe-kuo-6`), dimensions 2 to 8: degree, inner
/// coefficients, m₁ m₂ …
const TABLE: [(usize, u32, [u32; 5]); 7] = [
    (1, 0, [1, 0, 0, 0, 0]),
    (2, 1, [1, 3, 0, 0, 0]),
    (3, 1, [1, 3, 1, 0, 0]),
    (3, 2, [1, 1, 1, 0, 0]),
    (4, 1, [1, 1, 3, 3, 0]),
    (4, 4, [1, 3, 5, 13, 0]),
    (5, 2, [1, 1, 5, 5, 17]),
];

/// Direction numbers, bits reversed: the most significant binary digit of a coordinate is bit 0.
const REVERSED: [[u32; 32]; Sobol::DIMENSIONS] = directions();

const fn directions() -> [[u32; 32]; Sobol::DIMENSIONS] {
    let mut out = [[0u32; 32]; Sobol::DIMENSIONS];
    let mut k = 0;
    while k < 32 {
        out[0][k] = 1 << k;
        k += 1;
    }
    let mut dimension = 1;
    while dimension < Sobol::DIMENSIONS {
        let (degree, inner, first) = TABLE[dimension - 1];
        // v_k = m_k·2^(32−k), k from 1; the recurrence is eq. (3) of the paper.
        let mut v = [0u32; 32];
        let mut k = 0;
        while k < 32 {
            v[k] = if k < degree {
                first[k] << (31 - k)
            } else {
                let mut value = v[k - degree] ^ (v[k - degree] >> degree);
                let mut i = 1;
                while i < degree {
                    if (inner >> (degree - 1 - i)) & 1 == 1 {
                        value ^= v[k - i];
                    }
                    i += 1;
                }
                value
            };
            out[dimension][k] = v[k].reverse_bits();
            k += 1;
        }
        dimension += 1;
    }
    out
}

/// One randomly scrambled sequence: a function of (seed, stream, scramble).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sobol {
    seeds: [u32; Sobol::DIMENSIONS],
    tail: u64,
}

impl Sobol {
    /// Coordinates that a point may have.
    pub const DIMENSIONS: usize = 8;

    pub fn new(seed: u64, stream: Stream, scramble: u64) -> Self {
        let mut rng = Rng::new(seed, Stream::Scramble, stream as u64, scramble);
        Sobol { seeds: std::array::from_fn(|_| (rng.next_u64() >> 32) as u32), tail: rng.next_u64() }
    }

    /// Point `index` of the sequence, each coordinate in [0, 1). `D` ≤ [`Sobol::DIMENSIONS`]; every aligned run of 2ᵏ
    /// points is a net. Every 2³² points the scramble changes.
    pub fn point<const D: usize>(&self, index: u64) -> [f64; D] {
        const { assert!(D <= Sobol::DIMENSIONS) };
        let mut digits = [0u32; D];
        let mut rest = index as u32;
        while rest != 0 {
            let bit = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            for (digits, directions) in digits.iter_mut().zip(&REVERSED) {
                *digits ^= directions[bit];
            }
        }
        let beyond = match index >> 32 {
            0 => 0,
            run => (mix(self.tail ^ run) >> 32) as u32,
        };
        let tail = mix(self.tail ^ index);
        std::array::from_fn(|d| {
            let high = permute(digits[d], self.seeds[d] ^ beyond).reverse_bits();
            let low = mix(tail.wrapping_add(d as u64)) >> 43;
            ((u64::from(high) << 21) | low) as f64 * (1.0 / (1u64 << 53) as f64)
        })
    }
}

/// Each bit is flipped or not by a hash of the seed and of the bits below it.
fn permute(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::Moments;

    fn points(scramble: u64, count: u64) -> Vec<[f64; 8]> {
        let sobol = Sobol::new(5, Stream::Check, scramble);
        (0..count).map(|index| sobol.point(index)).collect()
    }

    /// Each 2ᵏ points put one into every elementary interval: of each dimension alone, and of the first two together in
    /// every shape (a (0,2)-net).
    #[test]
    fn every_scramble_is_a_net() {
        const LOG: u32 = 10;
        for scramble in 0..8 {
            let all = points(scramble, 3 << LOG);
            for run in all.chunks(1 << LOG) {
                for d in 0..8 {
                    let mut seen = vec![0; 1 << LOG];
                    run.iter().for_each(|p| seen[(p[d] * (1u32 << LOG) as f64) as usize] += 1);
                    assert!(seen.iter().all(|n| *n == 1), "dimension {d}");
                }
                for wide in 0..=LOG {
                    let mut seen = vec![0; 1 << LOG];
                    for p in run {
                        let x = (p[0] * (1u32 << wide) as f64) as usize;
                        let y = (p[1] * (1u32 << (LOG - wide)) as f64) as usize;
                        seen[(x << (LOG - wide)) + y] += 1;
                    }
                    assert!(seen.iter().all(|n| *n == 1), "shape {wide}");
                }
            }
        }
    }

    /// Over scrambles, one point is uniform and its digits are independent: chi² of the first six digits of two
    /// coordinates at a fixed index, 4095 degrees of freedom, below the 0.9999 quantile.
    #[test]
    fn a_point_is_uniform_over_scrambles() {
        for index in [0, 1, 77, (1 << 33) + 5] {
            let mut cells = vec![0u32; 4096];
            let count = 1 << 17;
            for scramble in 0..count {
                let p: [f64; 5] = Sobol::new(1, Stream::Forward, scramble).point(index);
                cells[(p[3] * 64.0) as usize * 64 + (p[4] * 64.0) as usize] += 1;
            }
            let want = count as f64 / 4096.0;
            let chi2: f64 = cells.iter().map(|&n| (f64::from(n) - want).powi(2) / want).sum();
            assert!((3780.0..4440.0).contains(&chi2), "index {index}: chi² = {chi2}");
        }
    }

    /// A smooth integrand in four dimensions: unbiased, and the variance falls much faster than 1/n.
    #[test]
    fn the_variance_falls_faster_than_with_random_points() {
        let f = |p: &[f64; 8]| p[..4].iter().map(|x| 1.5 * x.sqrt()).product::<f64>();
        let of = |count: u64| {
            let mut means = Moments::default();
            for scramble in 0..200 {
                let all = points(1000 + scramble, count);
                means.add(all.iter().map(f).sum::<f64>() / count as f64);
            }
            assert!((means.mean - 1.0).abs() < 4.5 * means.stderr(), "{count}: {}", means.mean);
            means.variance()
        };
        let (few, many) = (of(64), of(1024));
        // Independent points: (9/8)⁴ − 1 = 0.60 over the count, and 16 from one to the other.
        assert!(few < 0.2 * 0.60 / 64.0, "{few}");
        assert!(few / many > 100.0, "{few} {many}");
    }
}
