//! How bright and of which colour a clear sky is: Preetham, Shirley and Smits, "A practical analytic model for daylight",
//! SIGGRAPH 1999, 91–100, appendix A.2. Its formulas are fits to simulations of turbidities from 2 to 6.

use eyebox_base::colour::Xyz;
use std::f64::consts::PI;

/// A clear sky with the sun at one height.
#[derive(Debug, Clone)]
pub struct ClearSky {
    luminance: Law,
    x: Law,
    y: Law,
}

impl ClearSky {
    /// `sun_zenith`: angle from the zenith to the sun, rad.
    pub fn new(turbidity: f64, sun_zenith: f64) -> Self {
        let of = |zenith: f64, rows: [[f64; 2]; 5]| {
            let mut law = Law { scale: 1.0, abcde: rows.map(|[slope, constant]| slope * turbidity + constant) };
            law.scale = zenith / law.at(1.0, sun_zenith);
            law
        };
        let luminance = [[0.1787, -1.4630], [-0.3554, 0.4275], [-0.0227, 5.3251], [0.1206, -2.5771], [-0.0670, 0.3703]];
        let x = [[-0.0193, -0.2592], [-0.0665, 0.0008], [-0.0004, 0.2125], [-0.0641, -0.8989], [-0.0033, 0.0452]];
        let y = [[-0.0167, -0.2608], [-0.0950, 0.0092], [-0.0079, 0.2102], [-0.0441, -1.6537], [-0.0109, 0.0529]];
        let [x_zenith, y_zenith] = zenith_chromaticity(turbidity, sun_zenith);
        ClearSky {
            luminance: of(zenith_luminance(turbidity, sun_zenith), luminance),
            x: of(x_zenith, x),
            y: of(y_zenith, y),
        }
    }

    /// In a direction above the horizon: the cosine of its angle to the zenith, and its angle to the sun in rad. Y in cd/m².
    pub fn xyz(&self, cos_zenith: f64, to_sun: f64) -> Xyz {
        let [luminance, x, y] = [&self.luminance, &self.x, &self.y].map(|law| law.at(cos_zenith, to_sun));
        [x / y * luminance, luminance, (1.0 - x - y) / y * luminance]
    }
}

/// The sky distribution of Perez, Seals and Michalsky, "All-weather model for sky luminance distribution", Solar Energy 50
/// (1993) 235–245: (1 + A exp(B/cos θ)) (1 + C exp(D γ) + E cos² γ), times a number.
#[derive(Debug, Clone)]
struct Law {
    scale: f64,
    abcde: [f64; 5],
}

impl Law {
    fn at(&self, cos_zenith: f64, to_sun: f64) -> f64 {
        let [a, b, c, d, e] = self.abcde;
        let cos = to_sun.cos();
        self.scale * (1.0 + a * (b / cos_zenith).exp()) * (1.0 + c * (d * to_sun).exp() + e * cos * cos)
    }
}

/// At the zenith, cd/m².
pub fn zenith_luminance(turbidity: f64, sun_zenith: f64) -> f64 {
    let chi = (4.0 / 9.0 - turbidity / 120.0) * (PI - 2.0 * sun_zenith);
    1e3 * ((4.0453 * turbidity - 4.9710) * chi.tan() - 0.2155 * turbidity + 2.4192)
}

/// x and y of CIE 1931 at the zenith.
fn zenith_chromaticity(turbidity: f64, sun_zenith: f64) -> [f64; 2] {
    // Rows by turbidity squared, turbidity, 1; columns by the third to no power of the angle.
    let x = [
        [0.00166, -0.00375, 0.00209, 0.0],
        [-0.02903, 0.06377, -0.03202, 0.00394],
        [0.11693, -0.21196, 0.06052, 0.25886],
    ];
    let y = [
        [0.00275, -0.00610, 0.00317, 0.0],
        [-0.04214, 0.08970, -0.04153, 0.00516],
        [0.15346, -0.26756, 0.06670, 0.26688],
    ];
    [x, y].map(|rows| {
        let [square, linear, constant] =
            rows.map(|[a, b, c, d]| ((a * sun_zenith + b) * sun_zenith + c) * sun_zenith + d);
        (square * turbidity + linear) * turbidity + constant
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn zenith_of(elevation_deg: f64) -> f64 {
        (90.0 - elevation_deg).to_radians()
    }

    #[test]
    fn zenith_luminances_by_hand() {
        // Sun on the horizon: χ = 0, and 2.4192 − 0.2155 T is left.
        assert!((zenith_luminance(3.0, zenith_of(0.0)) - 1772.7).abs() < 1e-9);
        // T = 3, sun at 45°: χ = (4/9 − 1/40) π/2 = 0.658862, its tangent 0.774283; 7.1649 · 0.774283 + 1.7727.
        assert!((zenith_luminance(3.0, zenith_of(45.0)) / 7320.36 - 1.0).abs() < 1e-4);
        // T = 2, sun at the zenith: χ = (4/9 − 1/60) π = 1.343904, its tangent 4.331476; 3.1196 · 4.331476 + 1.9882.
        assert!((zenith_luminance(2.0, zenith_of(90.0)) / 15500.7 - 1.0).abs() < 1e-4);
    }

    #[test]
    fn the_zenith_has_its_luminance_and_its_blue() {
        for (turbidity, elevation) in [(2.0, 60.0), (3.0, 30.0), (6.0, 10.0)] {
            let zenith = zenith_of(elevation);
            let [x, y, z] = ClearSky::new(turbidity, zenith).xyz(1.0, zenith);
            assert!((y / zenith_luminance(turbidity, zenith) - 1.0).abs() < 1e-12);
            // Left of and below D65's (0.3127, 0.3290): bluer.
            let sum = x + y + z;
            assert!(x / sum < 0.30 && y / sum < 0.32, "{turbidity} {elevation}: {} {}", x / sum, y / sum);
        }
    }

    #[test]
    fn nowhere_is_less_than_black_or_more_than_a_colour() {
        for turbidity in [2.0, 2.5, 3.0, 4.0, 6.0, 8.0, 10.0] {
            for elevation in (0..=90).step_by(5) {
                let sun = zenith_of(f64::from(elevation));
                let sky = ClearSky::new(turbidity, sun);
                for height in 1..=45 {
                    let zenith = zenith_of(2.0 * f64::from(height) - 1.0);
                    for azimuth in (0..=180).step_by(15) {
                        let across = f64::from(azimuth).to_radians().cos() * zenith.sin() * sun.sin();
                        let to_sun = (across + zenith.cos() * sun.cos()).clamp(-1.0, 1.0).acos();
                        let xyz = sky.xyz(zenith.cos(), to_sun);
                        let sound = xyz.iter().all(|c| *c > 0.0 && c.is_finite());
                        assert!(sound, "T {turbidity}, sun {elevation}, at {height} {azimuth}: {xyz:?}");
                    }
                }
            }
        }
    }
}
