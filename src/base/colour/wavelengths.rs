//! Sampling of wavelengths for paths that carry several (Wilkie, Nawaz, Droske, Weidlich, Hanika 2014, "Hero wavelength
//! spectral sampling"): each lane is distributed alike, and the lanes of a path stand evenly in the distribution.

use super::cmf::cmf;
use super::grid::{COUNT, FIRST_NM, Grid, LAST_NM, cell, grid, integral};
use std::sync::LazyLock;

/// The share of wavelengths that is spread evenly over 360–830 nm, so that no wavelength is forgotten.
const UNIFORM: f64 = 0.1;

/// Density of each cell of 1 nm, and the share below each nm.
struct Distribution {
    density: [f64; COUNT - 1],
    below: Grid,
}

static DISTRIBUTION: LazyLock<Distribution> = LazyLock::new(|| {
    let weight = grid(|nm| cmf(nm).iter().sum());
    let (total, range) = (integral(&weight), (LAST_NM - FIRST_NM) as f64);
    let density: [f64; COUNT - 1] =
        std::array::from_fn(|i| (1.0 - UNIFORM) * (weight[i] + weight[i + 1]) / (2.0 * total) + UNIFORM / range);
    let mut below = [0.0; COUNT];
    for i in 1..COUNT {
        below[i] = below[i - 1] + density[i - 1];
    }
    // Sums to 1 but for rounding; what is drawn is what `density` says.
    let last = below[COUNT - 1];
    Distribution { density: density.map(|d| d / last), below: below.map(|b| b / last) }
});

/// A wavelength that a lane carries.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lane {
    pub nm: f64,
    /// Density with which this lane's wavelength is drawn, 1/nm.
    pub pdf: f64,
}

/// Density of every lane's wavelength at `nm`, 1/nm: nowhere 0 within 360–830 nm, 0 outside. Constant in each cell of
/// 1 nm, 90 % in proportion to x̄ + ȳ + z̄, 10 % even.
pub fn density(nm: f64) -> f64 {
    cell(nm).map_or(0.0, |(i, _)| DISTRIBUTION.density[i])
}

/// Lane `k` of `n` of the path with random number `u` in [0, 1): the wavelength in nm below which the share
/// (u + k/n) mod 1 of the distribution lies, and its [`density`] in 1/nm. Monotonic in that share.
pub fn hero(u: f64, k: usize, n: usize) -> (f64, f64) {
    let share = (u + k as f64 / n.max(1) as f64).fract();
    let Distribution { density, below } = &*DISTRIBUTION;
    let i = below.partition_point(|b| *b <= share).saturating_sub(1).min(COUNT - 2);
    let t = ((share - below[i]) / density[i]).clamp(0.0, 1.0);
    (((FIRST_NM + i) as f64 + t).min(LAST_NM as f64), density[i])
}

/// The lanes of the path with random number `u` in [0, 1).
pub fn lanes<const N: usize>(u: f64) -> [Lane; N] {
    std::array::from_fn(|k| {
        let (nm, pdf) = hero(u, k, N);
        Lane { nm, pdf }
    })
}

#[cfg(test)]
mod tests {
    use super::super::{K_M, cmf_for_sampling, xyz};
    use super::*;
    use crate::rng::{Rng, Stream};

    #[test]
    fn integrals_of_the_matching_functions_by_sampling_are_their_sums() {
        let want = xyz(&[1.0; COUNT]).map(|x| x / K_M);
        let (mut sum, mut squares) = ([0.0; 3], [0.0; 3]);
        let count = 200_000;
        for sample in 0..count {
            let u = Rng::new(3, Stream::Check, 0, sample).uniform();
            let mut mean = [0.0; 3];
            for Lane { nm, pdf } in lanes::<4>(u) {
                for (mean, cmf) in mean.iter_mut().zip(cmf_for_sampling(nm)) {
                    *mean += 0.25 * cmf / pdf;
                }
            }
            for c in 0..3 {
                sum[c] += mean[c];
                squares[c] += mean[c] * mean[c];
            }
        }
        for c in 0..3 {
            let mean = sum[c] / count as f64;
            let sigma = ((squares[c] / count as f64 - mean * mean) / count as f64).sqrt();
            assert!((mean - want[c]).abs() < 4.0 * sigma, "{mean} ± {sigma} for {}", want[c]);
            assert!(sigma < 1e-3 * want[c], "four lanes hardly vary: {sigma}");
        }
    }

    #[test]
    fn the_density_is_what_is_drawn() {
        let total: f64 = (0..COUNT - 1).map(|i| density((FIRST_NM + i) as f64 + 0.5)).sum();
        assert!((total - 1.0).abs() < 1e-12, "{total}");
        let (mut last, step) = (FIRST_NM as f64, 1e-5);
        for i in 0..100_000 {
            let (nm, pdf) = hero(i as f64 * step, 0, 1);
            assert!(pdf >= 0.0999 / 470.0 && nm >= last && nm <= LAST_NM as f64, "{nm} {pdf}");
            // Away from the borders of cells, equal shares are equal steps.
            if i > 0 && last.floor() == nm.floor() {
                assert!((nm - last) * pdf < step * (1.0 + 1e-6) && (nm - last) * pdf > step * (1.0 - 1e-6));
            }
            last = nm;
        }
        assert!(last > 829.0, "{last}");
    }

    #[test]
    fn no_number_breaks_it() {
        for u in [0.0, 1.0 - f64::EPSILON / 2.0, 1.0, -0.5, f64::NAN, f64::INFINITY, 1e300] {
            for (k, n) in [(0, 0), (0, 1), (3, 4), (usize::MAX, 1)] {
                let (nm, pdf) = hero(u, k, n);
                assert!(pdf > 0.0 && (nm.is_nan() || (360.0..=830.0).contains(&nm)), "{u} {k} {n}: {nm} {pdf}");
            }
        }
        assert_eq!(density(f64::NAN), 0.0);
    }
}
