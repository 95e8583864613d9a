//! The human eye as formulas: pupil diameter by adaptation and age, and light scattered in the eye (glare).
//!
//! Luminance in cd/m², angles in degrees, age in years; `pigment` is that of the iris, 0 (black) to 1.2 (light blue).

/// Whether one eye or both are adapted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Eyes {
    One,
    Both,
}

/// Diameter of the pupil in mm (Watson and Yellott, "A unified formula for light-adapted pupil size", Journal of Vision
/// 12(10), 2012, eq. 21), for a field of `area_deg2` and ages of 20 to 83.
pub fn pupil_watson_yellott_mm(luminance: f64, area_deg2: f64, age: f64, eyes: Eyes) -> f64 {
    let monocular = match eyes {
        Eyes::One => 0.1,
        Eyes::Both => 1.0,
    };
    let stanley_davies = pupil_stanley_davies_mm(luminance * monocular, area_deg2);
    stanley_davies + (age - 28.58) * (0.02132 - 0.009562 * stanley_davies)
}

/// Diameter of the pupil in mm at the mean age of the observers, both eyes (Stanley and Davies 1995).
pub fn pupil_stanley_davies_mm(luminance: f64, area_deg2: f64) -> f64 {
    let q = (luminance * area_deg2 / 846.0).powf(0.41);
    7.75 - 5.75 * q / (q + 2.0)
}

/// Diameter of the pupil in mm for a field of `area_deg2` (Barten 1999, "Contrast sensitivity of the human eye", eq. 3.2).
pub fn pupil_barten_mm(luminance: f64, area_deg2: f64) -> f64 {
    5.0 - 3.0 * (0.4 * (luminance * area_deg2 / 1600.0).log10()).tanh()
}

/// Retinal illuminance in troland: cd/m² times mm² of pupil.
pub fn trolands(luminance: f64, diameter_mm: f64) -> f64 {
    luminance * std::f64::consts::FRAC_PI_4 * diameter_mm * diameter_mm
}

/// Veiling luminance per illuminance at the eye, 1/sr: the general disability glare equation of CIE 146:2002, for angles
/// of 0.1 to 100.
pub fn glare_general(theta_deg: f64, age: f64, pigment: f64) -> f64 {
    let t = theta_deg;
    10.0 / t.powi(3) + (5.0 / (t * t) + 0.1 * pigment / t) * (1.0 + (age / 62.5).powi(4)) + 0.0025 * pigment
}

/// The same for angles of 0.1 to 30 (CIE 146:2002, small angles).
pub fn glare_small_angle(theta_deg: f64, age: f64) -> f64 {
    10.0 / theta_deg.powi(3) + 5.0 / (theta_deg * theta_deg) * (1.0 + (age / 62.5).powi(4))
}

/// The same for angles of 1 to 30: Stiles and Holladay's law with the age of CIE 146:2002.
pub fn glare_stiles_holladay(theta_deg: f64, age: f64) -> f64 {
    10.0 / (theta_deg * theta_deg) * (1.0 + (age / 70.0).powi(4))
}

/// The whole point-spread function of the eye, 1/sr, from 0 on (CIE 135/1:1999; Vos and van den Berg). Its integral over
/// the sphere is 1.01 to 1.19: normalise it where it is used to spread light.
pub fn glare_spread(theta_deg: f64, age: f64, pigment: f64) -> f64 {
    let t2 = theta_deg * theta_deg;
    let aged = (age / 70.0).powi(4);
    let peak = |amplitude: f64, width: f64, power: f64| amplitude * (1.0 + t2 / (width * width)).powf(-power);
    (1.0 - 0.08 * aged) * (peak(9.2e6, 0.0046, 1.5) + peak(1.5e5, 0.045, 1.5))
        + (1.0 + 1.6 * aged)
            * (peak(400.0, 0.1, 1.0) + 3e-8 * t2 + pigment * (peak(1300.0, 0.1, 1.5) + peak(0.8, 0.1, 0.5)))
        + 0.0025 * pigment
}

/// Veiling luminance of sources, cd/m²: (illuminance at the eye in lx, angle to the line of sight in degrees).
pub fn veil(sources: &[(f64, f64)], age: f64, pigment: f64) -> f64 {
    sources.iter().map(|(illuminance, theta_deg)| illuminance * glare_general(*theta_deg, age, pigment)).sum()
}

/// The smallest difference of luminance that cones see against a field of `adaptation`, cd/m² (Ferwerda, Pattanaik,
/// Shirley and Greenberg, "A model of visual adaptation for realistic image synthesis", SIGGRAPH 1996, photopic
/// threshold against intensity).
pub fn threshold_ferwerda(adaptation: f64) -> f64 {
    let log = adaptation.max(f64::MIN_POSITIVE).log10();
    let threshold = if log <= -2.6 {
        -0.72
    } else if log >= 1.9 {
        log - 1.255
    } else {
        (0.249 * log + 0.65).powf(2.7) - 0.72
    };
    10f64.powf(threshold)
}

#[cfg(test)]
mod tests {
    use super::threshold_ferwerda;

    /// By hand from the three pieces; they meet to within a percent.
    #[test]
    fn thresholds_of_cones() {
        assert!((threshold_ferwerda(234.0) - 234.0 * 0.055_590_4).abs() < 1e-3);
        assert_eq!(threshold_ferwerda(0.0), threshold_ferwerda(1e-6));
        // log La = 0: 0.65^2.7 − 0.72 = −0.407 48.
        assert!((threshold_ferwerda(1.0).log10() + 0.407_48).abs() < 1e-4, "{}", threshold_ferwerda(1.0).log10());
        for knee in [-2.6f64, 1.9] {
            let (below, above) =
                (threshold_ferwerda(10f64.powf(knee - 1e-9)), threshold_ferwerda(10f64.powf(knee + 1e-9)));
            assert!((below / above - 1.0).abs() < 0.02, "{knee}: {below} {above}");
        }
    }
}
