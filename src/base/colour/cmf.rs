//! CIE 1931 2° colour-matching functions, each nm (CIE 018:2019, table 6); ȳ is V(λ).

use super::grid::{COUNT, Grid, cell, columns, tabulated};
use super::{K_M, Xyz};
use std::sync::LazyLock;

static CMF: LazyLock<[[f64; 3]; COUNT]> = LazyLock::new(|| {
    let [x, y, z] = columns::<3>(include_str!("cmf.csv")).map(|column| tabulated(&column));
    std::array::from_fn(|i| [x[i], y[i], z[i]])
});

/// [x̄, ȳ, z̄] at `nm`: linear between the nm, 0 outside 360–830 nm.
#[inline]
pub fn cmf(nm: f64) -> Xyz {
    between(&CMF, nm)
}

#[inline]
fn between(table: &[[f64; 3]; COUNT], nm: f64) -> Xyz {
    match cell(nm) {
        Some((i, t)) => std::array::from_fn(|c| table[i][c] + (table[i + 1][c] - table[i][c]) * t),
        None => [0.0; 3],
    }
}

/// XYZ of the power distribution `watts` in W/nm (each nm): 683 Σ S (x̄, ȳ, z̄). Y in lm.
pub fn xyz(watts: &Grid) -> Xyz {
    let mut sum = [0.0; 3];
    for (s, cmf) in watts.iter().zip(CMF.iter()) {
        for (sum, cmf) in sum.iter_mut().zip(cmf) {
            *sum += s * cmf;
        }
    }
    sum.map(|sum| K_M * sum)
}

/// [x̄, ȳ, z̄] for integrals over a continuous wavelength, as Monte Carlo makes them: for every S that is linear between
/// the nm, ∫ S · this dλ is the CIE's sum Σ S (x̄, ȳ, z̄) to rounding.
///
/// The integral of a product of two linear pieces is not the sum of the products at their ends; with the plain functions
/// it is off by −Σ ΔS Δx̄ / 6 (1e-4 for a blue LED). Here the nodes d solve (d₋₁ + 4d + d₊₁)/6 = x̄, where the weights are
/// the integrals of the products of triangular hats. In the far tails values just below 0 occur.
pub fn cmf_for_sampling(nm: f64) -> Xyz {
    static DUAL: LazyLock<[[f64; 3]; COUNT]> = LazyLock::new(|| dual(&CMF));
    between(&DUAL, nm)
}

/// Solves the tridiagonal system by elimination (its diagonal dominates); half a hat stands at each end.
fn dual(table: &[[f64; 3]; COUNT]) -> [[f64; 3]; COUNT] {
    let diagonal = |i: usize| if i == 0 || i == COUNT - 1 { 2.0 } else { 4.0 };
    let mut ratio = [0.0; COUNT];
    let mut out = *table;
    for i in 0..COUNT {
        let (above, before) = if i == 0 { (0.0, [0.0; 3]) } else { (ratio[i - 1], out[i - 1]) };
        let pivot = diagonal(i) - above;
        ratio[i] = 1.0 / pivot;
        out[i] = std::array::from_fn(|c| (6.0 * table[i][c] - before[c]) / pivot);
    }
    for i in (0..COUNT - 1).rev() {
        out[i] = std::array::from_fn(|c| out[i][c] - ratio[i] * out[i + 1][c]);
    }
    out
}

/// ȳ of the grid, for those who need V(λ) alone.
#[cfg(test)]
pub(super) fn row(i: usize) -> Xyz {
    CMF[i]
}

#[cfg(test)]
mod tests {
    use super::super::{grid, lookup};
    use super::*;

    #[test]
    fn values_of_the_table_and_between() {
        assert_eq!(cmf(555.0)[1], 1.0);
        assert_eq!(cmf(360.0), [0.0001299, 3.917e-6, 0.0006061]);
        assert_eq!(cmf(830.0), [1.251141e-6, 4.5181e-7, 0.0]);
        let [a, b] = [row(190), row(191)];
        for c in 0..3 {
            assert!((cmf(550.25)[c] - (0.75 * a[c] + 0.25 * b[c])).abs() < 1e-15);
        }
        for outside in [359.999, 830.001, -1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(cmf(outside), [0.0; 3], "{outside}");
        }
        // Sums of the CIE's table at 1 nm: equal energy is nearly white.
        let sums = xyz(&[1.0; COUNT]).map(|sum| sum / K_M);
        for (sum, want) in sums.into_iter().zip([106.865469, 106.856917, 106.892251]) {
            assert!((sum - want).abs() < 1e-5, "{sum} for {want}");
        }
    }

    #[test]
    fn sampled_integrals_are_the_cies_sums() {
        // Two-point Gauss quadrature integrates the products of linear pieces exactly.
        let spectra: [Grid; 3] = [
            [1.0; COUNT],
            grid(|nm| (-4.0 * 2f64.ln() * ((nm - 450.0) / 20.0f64).powi(2)).exp()),
            grid(|nm| if nm == 700.0 { 1.0 } else { 0.0 }),
        ];
        let mut plain_is_off: f64 = 0.0;
        for spectrum in spectra {
            let quadrature = |table: &dyn Fn(f64) -> Xyz| {
                let mut sum = [0.0; 3];
                for i in 0..COUNT - 1 {
                    for t in [0.5 - 0.75f64.sqrt() / 3.0, 0.5 + 0.75f64.sqrt() / 3.0] {
                        let nm = (super::super::FIRST_NM + i) as f64 + t;
                        for (sum, cmf) in sum.iter_mut().zip(table(nm)) {
                            *sum += 0.5 * lookup(&spectrum, nm) * cmf;
                        }
                    }
                }
                sum
            };
            let want = xyz(&spectrum).map(|x| x / K_M);
            let (got, plain) = (quadrature(&cmf_for_sampling), quadrature(&cmf));
            for c in 0..3 {
                assert!((got[c] - want[c]).abs() <= 1e-12 * want[1], "{got:?} for {want:?}");
            }
            plain_is_off = plain_is_off.max((plain[1] / want[1] - 1.0).abs());
        }
        assert!(plain_is_off > 1e-5, "{plain_is_off}");
    }
}
