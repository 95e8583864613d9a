//! Lamps that are small and skies with a sun in one pixel.

use super::Case;
use crate::kit;
use crate::measure::How;
use eyebox_scene::{Finish, Scene};
use glam::{DAffine3, DVec3};
use std::f64::consts::{PI, TAU};

const REFLECTANCE: f64 = 0.6;

/// A white floor that the eye looks down on under 45°.
fn floor(fov_deg: f64) -> Scene {
    let mut s = kit::scene(fov_deg, 2);
    kit::look(&mut s, DVec3::new(0.0, 0.2, 0.2), DVec3::ZERO);
    let white = kit::face(Finish::Lambert { reflectance: REFLECTANCE, transmittance: 0.0 });
    let square = kit::mesh(&[kit::quad(DVec3::ZERO, DVec3::Z * 0.5, DVec3::X * 0.5)]);
    kit::add(&mut s, square, DAffine3::IDENTITY, None, vec![white]);
    s
}

/// A lamp this wide, metres, 0.5 m above the floor.
fn above(width: f64) -> (Scene, f64) {
    let (mut s, luminance, height) = (floor(0.01), 1e9, 0.5);
    let group = kit::group(&mut s, "lamp");
    let square = kit::mesh(&[kit::quad(DVec3::ZERO, DVec3::X * 0.5 * width, DVec3::Z * 0.5 * width)]);
    let at = DAffine3::from_translation(DVec3::Y * height);
    kit::add(&mut s, square, at, None, vec![kit::shining(group, luminance)]);
    (s, REFLECTANCE / PI * luminance * width * width / (height * height))
}

/// The lamp itself, in a field twice as wide.
fn seen(width: f64) -> (Scene, f64) {
    let distance = 0.5;
    let mut s = kit::scene((2.0 * (width / distance).atan()).to_degrees(), 1);
    let group = kit::group(&mut s, "lamp");
    let square = kit::mesh(&[kit::quad(DVec3::ZERO, DVec3::X * 0.5 * width, DVec3::Y * 0.5 * width)]);
    let at = DAffine3::from_translation(DVec3::NEG_Z * distance);
    kit::add(&mut s, square, at, None, vec![kit::shining(group, 1e9)]);
    (s, 0.25e9)
}

/// Lamps of 1 µm and less.
pub fn emitters() -> Vec<Case> {
    let mut cases = Vec::new();
    for width in [1e-3, 1e-6, 1e-9] {
        let (s, want) = above(width);
        let case = Case::new(format!("floor below a lamp of {width:e} m"), s, How::backward(64), want);
        // The lamp is not quite a point.
        cases.push(Case { rounding: 1e-5, ..case });
        let (s, want) = seen(width);
        let case = Case::new(format!("lamp of {width:e} m seen"), s, How::backward(2000), want);
        cases.push(Case { noise: 2e-2, ..case });
    }
    cases
}

/// The floor below a sky with one bright pixel in row `y`; seen through a pane if `pane`.
fn sun(y: usize, luminance: f32) -> (Scene, f64) {
    let (width, height) = (512, 256);
    let mut s = floor(0.01);
    let mut pixels = vec![1000.0f32; width * height];
    pixels[y * width + 77] = luminance;
    // ∫ cos sin dθ over a row.
    let row = |y: usize| {
        let [a, b] = [y, y + 1].map(|y| (PI * y as f64 / height as f64).sin().powi(2));
        0.5 * (b - a) * TAU / width as f64
    };
    let illuminance = 1000.0 * PI + (f64::from(luminance) - 1000.0) * row(y);
    kit::sky(&mut s, width, height, pixels);
    (s, REFLECTANCE / PI * illuminance)
}

/// Panoramas with a sun in one pixel.
pub fn suns() -> Vec<Case> {
    let mut cases = Vec::new();
    for (y, luminance) in [(20, 1.6e9), (20, 1e15), (100, 1.6e9), (126, 1.6e9)] {
        let (s, want) = sun(y, luminance);
        let case = Case::new(format!("sun of {luminance:e} cd/m² in row {y} of 256"), s, How::backward(2000), want);
        // One scattered ray in 10⁵ finds the sun by chance; whether one does is not in the standard error of so few.
        cases.push(Case { noise: 5e-3, rounding: 2e-5, ..case });
    }
    cases
}
