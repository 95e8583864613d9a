//! `samples/waveguide`: two gratings of the same period send light on as it came, and each meeting takes its share.

use super::{PLANNED, as_brute_force, sample, straight_ahead};
use crate::common::{image, render};

/// mm, as the sample's `make.py` has them.
const FOCAL_LENGTH: f64 = 30.0;
const THICKNESS: f64 = 1.5;

/// From one place where light meets the grating out to the next, mm: 2 t tan θ, with sin θ = λ/(n d) (Born and Wolf, 8.6.1).
fn step() -> f64 {
    2.0 * THICKNESS * (550.0f64 / (1.7 * 400.0)).asin().tan()
}

/// The eye under the first, the second and the third of them sees the middle of the display straight ahead.
#[test]
fn each_place_has_its_share() {
    for met in 0..3 {
        let eye = format!("eye.position=[\"{} mm\", \"0 mm\", \"0 mm\"]", step() * f64::from(met - 1));
        straight_ahead("waveguide", &eye, (2048, 1.2e-2), 20000.0 * 0.4 * 0.75f64.powi(met) * 0.25);
    }
}

/// An edge of the display is seen where the lens shows it: gratings of one period, in and out, turn nothing. Pixels of 0.1′ look across
/// it, and those beyond it are black.
#[test]
fn it_shows_the_display_where_the_lens_does() {
    const COUNT: usize = 40;
    let pixel_deg = 0.1 / 60.0;
    for (axis, at) in [(0, 0.3), (0, -0.3), (1, 0.17), (1, -0.17)] {
        let tangent = at / FOCAL_LENGTH;
        let (look, resolution) = match axis {
            0 => (format!("eye.look=[{tangent}, 0, -1]"), [COUNT, 1]),
            _ => (format!("eye.look=[0, {tangent}, -1]"), [1, COUNT]),
        };
        let up = if axis == 0 { "eye.up=[0, 1, 0]".to_owned() } else { format!("eye.up=[0, 1, {tangent}]") };
        let fov = format!("eye.fov_deg={}", pixel_deg * resolution[0] as f64);
        let sets = ["eye.pupil_diameter=0", "DISPLAY.contrast=1", "DISPLAY.size=[0.6, 0.34]", &look, &up, &fov];
        let mut scene = sample("waveguide", &sets);
        scene.eye.resolution = resolution;
        // Columns count to the right, rows down: pixels from inside of the picture outwards.
        let mut lit: Vec<bool> =
            image(&render(&scene, PLANNED, 256, 3).0).iter().map(|(value, _)| *value > 0.0).collect();
        if (axis == 0) == (at < 0.0) {
            lit.reverse();
        }
        let inside = lit.iter().take_while(|lit| **lit).count();
        println!("axis {axis}, {at} mm: {inside} of {COUNT} pixels are inside");
        assert!(lit[inside..].iter().all(|lit| !lit), "{lit:?}");
        assert!(inside.abs_diff(COUNT / 2) <= 1, "axis {axis}, {at} mm: {inside} of {COUNT}");
    }
}

#[test]
fn as_planned_it_is_what_plain_paths_see() {
    as_brute_force("waveguide", &[], [32, 256]);
}
