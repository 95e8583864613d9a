//! Coatings of every thickness, and every spectral mode with and without polarisation.

use super::Case;
use super::glass::reflected;
use super::places::{ball, plate};
use crate::measure::How;
use crate::{closed, kit};
use eyebox_film::plan::{Estimator, Spectral};
use eyebox_scene::{Dispersion, Wavelengths};

/// One film from no thickness at all to a millimetre: clear, absorbing, a metal.
pub fn coatings() -> Vec<Case> {
    let mut cases = Vec::new();
    for [n, k] in [[2.2, 0.0], [1.9, 0.05], [0.06, 3.6]] {
        for nm in [0.0, 1e-3, 1.0, 62.5, 1e3, 1e5, 1e6] {
            for polarised in [false, true] {
                let (mut s, _) = reflected(1.5, 0.0);
                let film = kit::film(&mut s, Dispersion::Table(vec![(550.0, n, k)]), nm);
                s.parts[0].faces[5].coating = Some(film);
                let want = 1000.0 * closed::film(1.0, [n, k], nm, 1.5, 550.0)[0];
                let pol = if polarised { ", polarised" } else { "" };
                let name = format!("film n = {n} + {k}i of {nm:e} nm{pol}");
                let how = How { polarised, ..How::backward(4) };
                cases.push(Case { rounding: 1e-8, ..Case::new(name, s, how, want) });
            }
        }
    }
    cases
}

/// The plate and the ball in every mode.
pub fn modes() -> Vec<Case> {
    let mut cases = Vec::new();
    for spectral in [Spectral::Mono, Spectral::Rgb, Spectral::Hero] {
        for polarised in [false, true] {
            let how = |passes| How { spectral: Some(spectral), polarised, ..How::backward(passes) };
            let name =
                |what: &str| format!("{what}, {}{}", spectral.name(), if polarised { ", polarised" } else { "" });
            let (mut s, want) = plate(45.0, 1.5, true);
            s.wavelengths = Wavelengths::Visible;
            let plain = 1000.0 * closed::plates_unpolarised(&[1.0, 1.5, 1.0], 0.5f64.sqrt());
            let want = if polarised { want } else { plain };
            cases.push(Case { noise: 1e-2, rounding: 1e-5, ..Case::new(name("plate at 45°"), s, how(800), want) });
            let (mut s, want) = ball();
            s.wavelengths = Wavelengths::Visible;
            cases.push(Case { noise: 1e-2, rounding: 1e-5, ..Case::new(name("ball"), s, how(64), want) });
        }
    }
    // From the lamp: the plate, wide open.
    for polarised in [false, true] {
        let (mut s, want) = plate(45.0, 1.5, true);
        (s.eye.fov_deg, s.eye.pupil_diameter_m) = (5.0, 0.1);
        let plain = 1000.0 * closed::plates_unpolarised(&[1.0, 1.5, 1.0], 0.5f64.sqrt());
        let want = if polarised { want } else { plain };
        let name = format!("plate at 45° from the lamp{}", if polarised { ", polarised" } else { "" });
        let how = How { estimator: Estimator::Forward, polarised, ..How::backward(900) };
        // The field is not a single angle.
        cases.push(Case { noise: 5e-2, rounding: 2e-3, ..Case::new(name, s, how, want) });
    }
    cases
}
