//! Luminance of flat patches, and what moves it.

use super::kit::*;
use super::prescription::{DIRECT, Direct, N_SK16};
use crate::common;
use eyebox::film::plan::Estimator;
use eyebox::plan::Choice;

/// What `auto` takes for the whole picture (`picture.rs`); for a patch this small it would trace from the eye.
/// Specular connection, and light tracing for what it leaves.
const CHOICE: Choice = Choice::Auto;

/// With the ghost of the plate's back face, s and p carried apart (`prescription.md`, "Ghost").
const GHOST: f64 = 1.0326;

/// The direct HUD's luminance at the field angles `at`, the slide filled with `s`: the mean of a patch `fov` wide and half
/// as high, over what the law of the prescription says that mean is of the middle (2°: 0.3 %, 6°: 3 %).
fn direct_by(choice: Choice, sets: &[&str], at: [f64; 2], fov: f64, passes: u64, s: f32) -> Measured {
    let scene = gaze(fill(hud("direct", sets), s), at, fov, [8, 4]);
    let (mean, sigma) = luminance(&scene, choice, passes);
    let tangents = |dx: f64, dy: f64| [at[0] + dx, at[1] + dy].map(|degrees| degrees.to_radians().tan());
    let place = |k: usize| fov / 2.0 * ((2.0 * k as f64 + 1.0) / 8.0 - 1.0);
    let patch: f64 = (0..64).map(|k| DIRECT.luminance(tangents(place(k % 8), place(k / 8) / 2.0))).sum::<f64>() / 64.0;
    let flat = patch / DIRECT.luminance(tangents(0.0, 0.0));
    (mean / flat, sigma / flat)
}

fn direct(sets: &[&str], at: [f64; 2], fov: f64, passes: u64, s: f32) -> Measured {
    direct_by(CHOICE, sets, at, fov, passes, s)
}

/// The middle from a wide patch: cheap.
fn wide(more: &[&str], s: f32) -> Measured {
    direct(&[&ONE_LED[..], more].concat(), [0.0; 2], 6.0, 32, s)
}

#[test]
fn direct_centre() {
    assert_close("direct, one LED", wide(&[], 1.0), 9886.0, 0.01);
    let black = format!("COMBINER_PLATE_NBK7.faces[{}].finish=absorber", back_face());
    assert_close("direct, one LED, black back", wide(&[&black], 1.0), 9886.0, 0.01);
}

long! {
/// Light adds up, and the middle LED alone is known already: what the other eight add is the ghost. With the plate's back
/// face black they add nothing.
#[test]
fn direct_nine_leds() {
    let one = DIRECT.luminance([0.0; 2]);
    let dark = "LED_DIE_5.flux_lm=0";
    let (rest, sigma) = direct(&[dark], [0.0; 2], 6.0, 128, 1.0);
    assert_close("direct, nine LEDs", (one + rest, sigma), 9886.0 * GHOST, 0.01);
    let (ghost, error) = (rest / one, sigma / one);
    println!("ghost {:.3} ± {:.3} %", 100.0 * ghost, 100.0 * error);
    assert!(error < 3e-4 && (ghost - 0.0326).abs() < 5e-4 + 3.0 * error, "ghost {ghost} ± {error}");
    let black = format!("COMBINER_PLATE_NBK7.faces[{}].finish=absorber", back_face());
    let (rest, sigma) = direct(&[dark, &black], [0.0; 2], 6.0, 16, 1.0);
    assert_close("nine LEDs, black back", (one + rest, sigma), 9886.0, 0.01);
}
}

/// The face of the plate whose vertices all have the largest local z.
fn back_face() -> usize {
    let scene = hud("direct", &[]);
    let part = scene.parts.iter().find(|part| part.name == "COMBINER_PLATE_NBK7").expect("the plate");
    let mesh = scene.mesh(part.mesh);
    let mean_z = |face: usize| {
        let corners: Vec<f32> = mesh.triangles[mesh.faces[face].triangles()]
            .iter()
            .flatten()
            .map(|&vertex| mesh.positions[vertex as usize][2])
            .collect();
        corners.iter().sum::<f32>() / corners.len() as f32
    };
    (0..mesh.faces.len()).max_by(|&a, &b| mean_z(a).total_cmp(&mean_z(b))).expect("faces")
}

#[test]
fn direct_off_axis_and_black() {
    // The patch ends at 4°, inside the collimator's rim (4.8°).
    let at: [f64; 2] = [2.5, 0.0];
    let want = DIRECT.luminance(at.map(|a| a.to_radians().tan()));
    // Light tracing alone: a stray path of what connection leaves is one bright pixel here.
    let forward = Choice::Only(Estimator::Forward);
    assert_close("direct, one LED, 2.5° right", direct_by(forward, &ONE_LED, at, 3.0, 60, 1.0), want, 0.01);
    assert_close("direct, black", wide(&[], 0.0), 9886.0 / 300.0, 0.01);
}

long! {
/// ±10 % of what the luminance depends on, against the calculation that shares nothing with the crate.
#[test]
fn direct_moves_as_calculated() {
    let law = |set: &str, changed: Direct| {
        assert_close(set, wide(&[set], 1.0), changed.luminance([0.0; 2]), 0.01);
    };
    law("LED_DIE_5.flux_lm=0.495", Direct { flux_lm: 0.495, ..DIRECT });
    law("eye.pupil_diameter=4.4 mm", Direct { pupil_mm: 4.4, ..DIRECT });
    law("eye.pupil_diameter=3.6 mm", Direct { pupil_mm: 3.6, ..DIRECT });
    law("LENS_02_NBK7.glass=N-SK16", Direct { collimator_index: N_SK16, ..DIRECT });
    let radius = DIRECT.collimator_radius * 0.9;
    law(&format!("LENS_02_NBK7.faces[0].shape.radius={radius}"), Direct { collimator_radius: radius, ..DIRECT });
    let set = "LCD_ACTIVE_AREA.contrast=270";
    let black = wide(&[set], 0.0);
    assert_close(set, black, DIRECT.luminance([0.0; 2]) / 270.0, 0.01);
}
}

// Eight runs of two passes give 1616.0 ± 0.4 against 1617.1 in the middle and 36.13 ± 0.02 against 36.09 with the Lambertian
// screen. Near the rim the tolerance is three standard errors of what a test can afford: 553.6 ± 5.4 against 549.3.

/// The diffuse HUD's white patch about `at`, 2° wide: the value of a quadratic fit in its middle, since the hot spot is
/// curved. Photons, in independent runs.
fn diffuse(sets: &[&str], at: [f64; 2], runs: u64, passes: u64) -> Measured {
    let scene = gaze(fill(hud("diffuse", sets), 1.0), at, 2.0, [8, 8]);
    let mut ready = Ready::new(&scene, Choice::Auto);
    assert!(ready.plan.runs(Estimator::Photon));
    // They bring only what specular connection leaves.
    ready.plan.photons = 1 << 14;
    let values: Vec<f64> = (0..runs).map(|seed| middle_of_fit(&ready.image(passes, seed), 8)).collect();
    of_runs(&values)
}

/// Value at the middle of a square patch from the least-squares fit of a quadratic: over a grid symmetric in x and y the
/// terms x, y and xy drop out, and 1, x², y² have the closed solution below.
fn middle_of_fit(image: &[(f64, f64)], width: usize) -> f64 {
    let n = width as f64;
    let place = |k: usize| (2.0 * k as f64 + 1.0) / n - 1.0;
    let m2: f64 = (0..width).map(|k| place(k).powi(2)).sum::<f64>() / n;
    let m4: f64 = (0..width).map(|k| place(k).powi(4)).sum::<f64>() / n;
    let mean = common::mean(image).0;
    let curved = |coordinate: &dyn Fn(usize) -> f64| {
        let covariance: f64 =
            image.iter().enumerate().map(|(i, v)| v.0 * (coordinate(i).powi(2) - m2)).sum::<f64>() / (n * n);
        covariance / (m4 - m2 * m2)
    };
    mean - m2 * (curved(&|i| place(i % width)) + curved(&|i| place(i / width)))
}

#[test]
fn the_fit_is_exact_for_quadratics() {
    let place = |k: usize| (2.0 * k as f64 + 1.0) / 8.0 - 1.0;
    let value = |x: f64, y: f64| 5.0 + 2.0 * x - y + 0.3 * x * y - 4.0 * x * x + 7.0 * y * y;
    let image: Vec<(f64, f64)> = (0..64).map(|i| (value(place(i % 8), place(i / 8)), 0.0)).collect();
    assert!((middle_of_fit(&image, 8) - 5.0).abs() < 1e-12);
}

#[test]
fn diffuse_centre() {
    assert_close("diffuse, centre", diffuse(&[], [0.0; 2], 6, 1), 1566.0 * GHOST, 0.01);
}

long! {
#[test]
fn diffuse_off_axis() {
    assert_close("diffuse, 5.2° right", diffuse(&[], [5.2, 0.0], 8, 4), 532.0 * GHOST, 0.035);
}
}

long! {
#[test]
fn diffuse_lambertian_screen() {
    let set = "DIFFUSER_SHEET.faces[4].finish={ lambert = { transmittance = 0.9, reflectance = 0 } }";
    assert_close("diffuse, Lambertian", diffuse(&[set], [0.0; 2], 6, 1), 34.95 * GHOST, 0.01);
}
}
