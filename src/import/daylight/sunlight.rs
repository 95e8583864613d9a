//! What is left of the sun's light after its way through the air: Preetham, Shirley and Smits, "A practical analytic model
//! for daylight", SIGGRAPH 1999, 91–100, appendix A.1, after Iqbal, "An introduction to solar radiation", 1983.

use eyebox_base::colour::{Xyz, tabulated, xyz};
use eyebox_scene::Spectrum;
use std::f64::consts::PI;

/// Full angle of the sun's disc, deg: its mean over the year.
pub const DISC_DEG: f64 = 0.533;

/// Wavelength in nm; radiance of the sun outside of the air in W/(cm² µm sr); absorption by ozone and by water vapour, 1/cm.
/// Of the paper's table 2. The band of the mixed gases, oxygen's from 759 to 771 nm, is beyond its end.
const SUN: [[f64; 4]; 38] = [
    [380.0, 1655.9, 0.0, 0.0],
    [390.0, 1623.37, 0.0, 0.0],
    [400.0, 2112.75, 0.0, 0.0],
    [410.0, 2588.82, 0.0, 0.0],
    [420.0, 2582.91, 0.0, 0.0],
    [430.0, 2423.23, 0.0, 0.0],
    [440.0, 2676.05, 0.0, 0.0],
    [450.0, 2965.83, 0.003, 0.0],
    [460.0, 3054.54, 0.006, 0.0],
    [470.0, 3005.75, 0.009, 0.0],
    [480.0, 3066.37, 0.014, 0.0],
    [490.0, 2883.04, 0.021, 0.0],
    [500.0, 2871.21, 0.03, 0.0],
    [510.0, 2782.5, 0.04, 0.0],
    [520.0, 2710.06, 0.048, 0.0],
    [530.0, 2723.36, 0.063, 0.0],
    [540.0, 2636.13, 0.075, 0.0],
    [550.0, 2550.38, 0.085, 0.0],
    [560.0, 2506.02, 0.103, 0.0],
    [570.0, 2531.16, 0.12, 0.0],
    [580.0, 2535.59, 0.12, 0.0],
    [590.0, 2513.42, 0.115, 0.0],
    [600.0, 2463.15, 0.125, 0.0],
    [610.0, 2417.32, 0.12, 0.0],
    [620.0, 2368.53, 0.105, 0.0],
    [630.0, 2321.21, 0.09, 0.0],
    [640.0, 2282.77, 0.079, 0.0],
    [650.0, 2233.98, 0.067, 0.0],
    [660.0, 2197.02, 0.057, 0.0],
    [670.0, 2152.67, 0.048, 0.0],
    [680.0, 2109.79, 0.036, 0.0],
    [690.0, 2072.83, 0.028, 0.016],
    [700.0, 2024.04, 0.023, 0.024],
    [710.0, 1987.08, 0.018, 0.0125],
    [720.0, 1942.72, 0.014, 1.0],
    [730.0, 1907.24, 0.011, 0.87],
    [740.0, 1862.89, 0.01, 0.061],
    [750.0, 1825.92, 0.009, 0.001],
];

/// The sun's light on a plane across it.
#[derive(Debug, Clone)]
pub struct Sunlight {
    /// Y in lx.
    pub xyz: Xyz,
    pub spectrum: Spectrum,
}

impl Sunlight {
    /// `sun_zenith`: angle from the zenith to the sun, rad, at most π/2.
    pub fn new(turbidity: f64, sun_zenith: f64) -> Self {
        Self::through(|nm, ozone, water| transmittance(turbidity, air_mass(sun_zenith), nm, [ozone, water]))
    }

    fn through(transmittance: impl Fn(f64, f64, f64) -> f64) -> Self {
        // E = π L sin² of the half angle; 1 W/(cm² µm) = 10 W/(m² nm).
        let spread = 10.0 * PI * (0.5 * DISC_DEG).to_radians().sin().powi(2);
        let rows: Vec<(f64, f64)> =
            SUN.iter().map(|[nm, l, ozone, water]| (*nm, spread * l * transmittance(*nm, *ozone, *water))).collect();
        Sunlight { xyz: xyz(&tabulated(&rows)), spectrum: Spectrum::Table(rows) }
    }

    pub fn illuminance_lx(&self) -> f64 {
        self.xyz[1]
    }
}

/// Air on the way over that at the zenith: Kasten, "A new table and approximation formula for the relative optical air
/// mass", 1965.
fn air_mass(sun_zenith: f64) -> f64 {
    1.0 / (sun_zenith.cos() + 0.15 * (93.885 - sun_zenith.to_degrees()).powf(-1.253))
}

fn transmittance(turbidity: f64, mass: f64, nm: f64, [ozone, water]: [f64; 2]) -> f64 {
    // The paper's clear day: 0.35 cm of ozone at normal temperature and pressure, 2 cm of precipitable water; particles whose
    // extinction falls as λ^−1.3.
    const OZONE_CM: f64 = 0.35;
    const WATER_CM: f64 = 2.0;
    let um = nm * 1e-3;
    let molecules = 0.008735 * um.powf(-4.08) * mass;
    let particles = (0.04608 * turbidity - 0.04586) * um.powf(-1.3) * mass;
    let ozone = ozone * OZONE_CM * mass;
    let vapour = water * WATER_CM * mass;
    let vapour = 0.2385 * vapour / (1.0 + 20.07 * vapour).powf(0.45);
    (-(molecules + particles + ozone + vapour)).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sun(turbidity: f64, elevation_deg: f64) -> Sunlight {
        Sunlight::new(turbidity, (90.0 - elevation_deg).to_radians())
    }

    #[test]
    fn outside_of_the_air_it_is_the_solar_illuminance_constant() {
        // 127.5 klx: IES, "Recommended practice for the calculation of daylight availability" (RP-21), 1984.
        let lx = Sunlight::through(|_, _, _| 1.0).illuminance_lx();
        assert!((lx / 127.5e3 - 1.0).abs() < 0.005, "{lx}");
    }

    #[test]
    fn a_very_clear_day_is_near_the_recommended_practice() {
        // RP-21, clear sky: 127.5 klx · exp(−0.21 m), m = 1/sin of the elevation.
        for elevation in [20.0f64, 30.0, 45.0, 60.0, 90.0] {
            let expected = 127.5e3 * (-0.21 / elevation.to_radians().sin()).exp();
            let lx = sun(2.0, elevation).illuminance_lx();
            assert!((lx / expected - 1.0).abs() < 0.06, "{elevation}: {lx}, not {expected}");
        }
    }

    #[test]
    fn haze_and_a_low_sun_dim_and_redden() {
        let xy = |light: &Sunlight| {
            let [x, y, z] = light.xyz;
            [x / (x + y + z), y / (x + y + z)]
        };
        let mut last: Option<Sunlight> = None;
        for (turbidity, elevation) in [(2.0, 90.0), (2.0, 60.0), (2.0, 30.0), (2.0, 5.0), (3.0, 5.0), (6.0, 5.0)] {
            let light = sun(turbidity, elevation);
            if let Some(last) = &last {
                assert!(light.illuminance_lx() < last.illuminance_lx(), "{turbidity} {elevation}");
                assert!(xy(&light)[0] > xy(last)[0], "{turbidity} {elevation}");
            }
            last = Some(light);
        }
        // White at noon, as D65 within a few hundredths; orange at 5°.
        assert!(xy(&sun(3.0, 60.0))[0] < 0.34 && xy(&sun(3.0, 5.0))[0] > 0.45);
        // Worst of all it is still a spectrum that lamps can have.
        assert_eq!(sun(10.0, 0.0).spectrum.problem(), None);
    }

    #[test]
    fn air_is_flat_for_a_high_sun_and_ends_on_the_horizon() {
        // Flat air has 1/sin of the elevation, and no end on the horizon; round air 1/(0.15 · 3.885^−1.253) of that at the zenith.
        let mass = |elevation: f64| air_mass((90.0 - elevation).to_radians());
        for elevation in [30.0f64, 60.0, 90.0] {
            assert!((mass(elevation) * elevation.to_radians().sin() - 1.0).abs() < 0.004, "{}", mass(elevation));
        }
        assert!((mass(0.0) - 36.51).abs() < 0.01, "{}", mass(0.0));
    }
}
