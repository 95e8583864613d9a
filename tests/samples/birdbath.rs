//! `samples/birdbath` by paraxial optics: a spherical mirror, and a plate at 45° that shifts what is seen through it.

use super::{as_brute_force, bright, sample, scanned, seen_at};

/// Lengths in metres, as the sample's `make.py` has them: display to beam splitter to half mirror, and half mirror to eye.
const OBJECT: f64 = 0.018 + 0.020;
const EYE: f64 = 0.045;
const RADIUS: f64 = 0.0775;
const PLATE: f64 = 0.001;
/// N-BK7 at 550 nm.
const INDEX: f64 = 1.5185;

/// How far behind the mirror the picture stands: 1/s + 1/s′ = 2/R (Hecht, Optics, 5.4.3).
fn image() -> f64 {
    -1.0 / (2.0 / RADIUS - 1.0 / OBJECT)
}

#[test]
fn the_picture_stands_where_the_mirror_images_it() {
    // A narrow pupil: a sphere brings the rays that meet it 1 mm off its axis together sooner, by 0.0022 1/m.
    let sets = ["DISPLAY.size=[0.8, 0.45]", "wavelengths.mono_nm=550", "eye.pupil_diameter=\"0.4 mm\""];
    let found = scanned(&sample("birdbath", &sets), [1, 1], [0.0, 0.0], None);
    assert_eq!(found.part, "DISPLAY");
    let away = image() + EYE;
    // By d = t sin θ (1 − cos θ/√(n² − sin² θ)) a plate shifts rays towards the side to which it leans them (Hecht, 4.4).
    let sin = 0.5f64.sqrt();
    let shift = PLATE * sin * (1.0 - sin / (INDEX * INDEX - 0.5).sqrt());
    let larger = image() / OBJECT;
    seen_at(&found, &found.positions[0], |[x, y]| [larger * x / away, (larger * y - shift) / away]);
    let got = found.positions[0].distance.unwrap().centre_per_m.unwrap();
    assert!((got - 1.0 / away).abs() < 1e-3, "{got} 1/m, want {}", 1.0 / away);
}

#[test]
fn white_is_a_product_of_shares() {
    let found = scanned(&sample("birdbath", &["wavelengths.mono_nm=550"]), [1, 1], [0.0, 0.0], Some(16));
    bright("birdbath", found.positions[0].luminance.unwrap().centre, 5000.0 * 0.5f64.powi(3));
    // The world: through the half mirror and the beam splitter.
    let mut scene = sample("birdbath", &["oled.luminance_cd_m2=0", "wavelengths.mono_nm=550"]);
    (scene.eye.fov_deg, scene.eye.resolution) = (2.0, [4, 4]);
    let (films, _) = crate::common::render(&scene, super::PLANNED, 64, 3);
    let (got, sigma) = crate::common::mean(&crate::common::image(&films));
    println!("the world: {got} ± {sigma}, want 25");
    assert!(sigma < 0.1 && (got - 25.0).abs() < 4.0 * sigma + 1e-3, "{got} ± {sigma}, want 25");
}

#[test]
fn as_planned_it_is_what_plain_paths_see() {
    as_brute_force("birdbath", &["wavelengths.mono_nm=550"], [16, 64]);
}
