//! Relative power distributions that the CIE tabulates or gives formulas for.

use super::grid::{Grid, columns, grid, tabulated};
use std::sync::LazyLock;

/// D65; S0, S1, S2 of daylight; the LEDs in the order of [`led`].
static TABLE: LazyLock<[Grid; 13]> =
    LazyLock::new(|| columns::<13>(include_str!("illuminants.csv")).map(|column| tabulated(&column)));

/// CIE standard illuminant D65, 100 at 560 nm; tabulated from 360 to 780 nm, 0 above.
pub fn d65() -> &'static Grid {
    &TABLE[0]
}

/// CIE 015:2018 table 12: LED-B1 to B5, BH1, RGB1, V1, V2 by `index` 0–8, tabulated from 380 to 780 nm. None above 8.
pub fn led(index: usize) -> Option<&'static Grid> {
    TABLE.get(4..)?.get(index)
}

/// Relative power of a black body of `kelvin` at `nm`, 1 at 560 nm, with c₂ in nm·K (CODATA 2018: 1.438776877e7).
pub fn planck(kelvin: f64, c2_nm_k: f64, nm: f64) -> f64 {
    let x = |nm: f64| c2_nm_k / (nm * kelvin);
    (560.0 / nm).powi(5) * x(560.0).exp_m1() / x(nm).exp_m1()
}

/// Daylight of correlated colour temperature `kelvin`, 4000–25000 K, 100 at 560 nm (CIE 15:2004, 3.1; the chromaticity
/// from `kelvin` as it is, M₁ and M₂ not rounded). Power below 0, which only temperatures out of range give, is 0.
pub fn daylight(kelvin: f64) -> Grid {
    let t = 1000.0 / kelvin;
    let x = if kelvin <= 7000.0 {
        0.244063 + t * (0.09911 + t * (2.9678 - t * 4.6070))
    } else {
        0.237040 + t * (0.24748 + t * (1.9018 - t * 2.0064))
    };
    let y = -3.000 * x * x + 2.870 * x - 0.275;
    let m = 0.0241 + 0.2562 * x - 0.7341 * y;
    let (m1, m2) = ((-1.3515 - 1.7703 * x + 5.9114 * y) / m, (0.0300 - 31.4424 * x + 30.0717 * y) / m);
    let [_, s0, s1, s2, ..] = &*TABLE;
    let mut i = 0;
    grid(|_| {
        let power = s0[i] + m1 * s1[i] + m2 * s2[i];
        i += 1;
        power.max(0.0)
    })
}
