//! Spectra for linear Rec.709 colours with an exact way back, after the idea of Mallett and Yuksel 2019 ("Spectral primary
//! decomposition for rendering with sRGB reflectance"): three smooth functions that are nowhere below 0 and sum to 1. The
//! table is our own (tests/python/uplift_basis.py).

use super::cmf::xyz;
use super::grid::{COUNT, Grid, cell, columns, lookup, tabulated};
use super::illuminants::d65;
use super::{Rgb, XYZ_TO_REC709, apply};
use std::sync::LazyLock;

struct Uplift {
    basis: Box<[[f64; 3]; COUNT]>,
    /// D65 in W/nm per lm.
    d65: Grid,
    /// 1 over the Rec.709 colour of that D65 (its table's white is within 3e-4 of the space's).
    from_white: Rgb,
}

static UPLIFT: LazyLock<Uplift> = LazyLock::new(|| {
    let [red, blue] = columns::<2>(include_str!("uplift.csv")).map(|column| tabulated(&column));
    let basis = Box::new(std::array::from_fn(|i| [red[i], (1.0 - red[i] - blue[i]).max(0.0), blue[i]]));
    let lumens = xyz(d65())[1];
    let d65 = d65().map(|power| power / lumens);
    Uplift { basis, from_white: apply(&XYZ_TO_REC709, xyz(&d65)).map(|white| 1.0 / white), d65 }
});

/// [ρ_R, ρ_G, ρ_B] at `nm`, each 0–1, sum 1; beyond 360–830 nm as at its end.
#[inline]
pub fn basis(nm: f64) -> [f64; 3] {
    let table = &UPLIFT.basis;
    let (i, t) = cell(nm).unwrap_or(if nm > 500.0 { (COUNT - 2, 1.0) } else { (0, 0.0) });
    std::array::from_fn(|c| table[i][c] + (table[i + 1][c] - table[i][c]) * t)
}

/// Reflectance or transmittance at `nm` of the linear Rec.709 colour `rgb`, each 0–1; then it is 0–1 as well, and grey
/// is the same at every wavelength.
///
/// Under D65 it multiplies red, green and blue of the light by exactly `rgb` (as the CIE's sum by 1 nm): a white of
/// (1, 1, 1) has the colour of the lamp.
#[inline]
pub fn uplift_reflectance(rgb: Rgb, nm: f64) -> f64 {
    let [r, g, b] = basis(nm);
    rgb[0] * r + rgb[1] * g + rgb[2] * b
}

/// Spectral quantity at `nm`, per nm and in watts, of light whose photometric quantity is the linear Rec.709 colour
/// `rgb`, each >= 0 (for a luminance in cd/m²: W/(m² sr nm)): 683 Σ of it with (x̄, ȳ, z̄) is exactly its XYZ. White has
/// (nearly) the spectrum of D65. 0 outside of 360–780 nm, where D65 is tabulated.
#[inline]
pub fn uplift_emission(rgb: Rgb, nm: f64) -> f64 {
    let Uplift { d65, from_white, .. } = &*UPLIFT;
    let scaled = std::array::from_fn(|c| rgb[c] * from_white[c]);
    lookup(d65, nm) * uplift_reflectance(scaled, nm)
}

#[cfg(test)]
mod tests {
    use super::super::{REC709_TO_XYZ, grid};
    use super::*;
    use crate::rng::{Rng, Stream};

    #[test]
    fn the_basis_is_a_share_of_one_at_every_wavelength() {
        for i in 0..47_001 {
            let nm = 360.0 + f64::from(i) * 0.01;
            let rho = basis(nm);
            assert!(rho.iter().all(|rho| (0.0..=1.0).contains(rho)), "{nm}: {rho:?}");
            assert!((rho.iter().sum::<f64>() - 1.0).abs() <= 2.0 * f64::EPSILON, "{nm}: {rho:?}");
        }
        for (outside, end) in [(100.0, 360.0), (2000.0, 830.0)] {
            assert_eq!(basis(outside), basis(end));
        }
        assert!(basis(f64::NAN).iter().sum::<f64>() > 0.99);
        // Red, green and blue are where they are expected.
        for (nm, c) in [(650.0, 0), (535.0, 1), (445.0, 2)] {
            assert!(basis(nm)[c] > 0.9, "{nm}: {:?}", basis(nm));
        }
    }

    #[test]
    fn light_comes_back_as_the_colour_it_was() {
        for sample in 0..200 {
            let mut rng = Rng::new(5, Stream::Check, 1, sample);
            let size = 10f64.powf(rng.uniform() * 12.0 - 3.0);
            let rgb: Rgb = std::array::from_fn(|_| rng.uniform() * size);
            let got = xyz(&grid(|nm| uplift_emission(rgb, nm)));
            let want = apply(&REC709_TO_XYZ, rgb);
            for c in 0..3 {
                assert!((got[c] / want[c] - 1.0).abs() < 1e-9, "{rgb:?}: {got:?} for {want:?}");
            }
        }
        assert_eq!(uplift_emission([1.0; 3], 800.0), 0.0);
    }

    #[test]
    fn a_reflectance_multiplies_the_rgb_of_daylight() {
        let lit = |rgb: Rgb| apply(&XYZ_TO_REC709, xyz(&grid(|nm| lookup(d65(), nm) * uplift_reflectance(rgb, nm))));
        let white = lit([1.0; 3]);
        for sample in 0..200 {
            let mut rng = Rng::new(5, Stream::Check, 2, sample);
            let rgb: Rgb = std::array::from_fn(|_| rng.uniform());
            let got = lit(rgb);
            for c in 0..3 {
                assert!((got[c] / white[c] - rgb[c]).abs() < 1e-9, "{rgb:?}: {got:?}");
            }
            let grey = rgb[0];
            assert!((uplift_reflectance([grey; 3], 360.0 + 470.0 * rgb[1]) - grey).abs() <= 4.0 * f64::EPSILON);
        }
    }
}
