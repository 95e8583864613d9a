//! `samples/waveguide`: two gratings of the same period send light on as it came, and each meeting takes its share.

use super::{PLANNED, as_brute_force, place, sample, scanned, straight_ahead};
use crate::common::{image, render};
use eyebox::plan::scan::{Position, Scan};
use glam::DVec3;
use std::collections::BTreeSet;

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

/// From under each place, and between two of them: what is seen over both gratings and so many reflections is at infinity, where the
/// lens shows it (which has coma, so that off its axis the image is not quite at infinity).
#[test]
fn a_scan_finds_the_display_over_both_gratings() {
    for met in [0.0, 0.8, 1.0, 1.2, 2.0] {
        let eye = format!("eye.position=[\"{} mm\", \"0 mm\", \"0 mm\"]", step() * (met - 1.0));
        let near = scanned(&sample("waveguide", &["DISPLAY.size=[0.6, 0.34]", &eye]), [1, 1], [0.0, 0.0], None);
        assert!(near.by.starts_with("LENS, ") && near.by.ends_with("; orders +1, -1"), "{met}: {}", near.by);
        let position = &near.positions[0];
        assert_eq!(position.seen, 1.0);
        let (worst, passes) = off(&near, position, step() * (met - 1.0));
        println!("under place {met}: off by up to {worst:.1e}′ over {passes:?} passes");
        assert!(worst < 0.1, "{worst}′");
        let distance = position.distance.unwrap();
        assert!(distance.centre_per_m.unwrap().abs() < 1e-9, "{distance:?}");
        // The sample is its own mirror image in y = 0.
        for line in &position.points {
            let [column, row] = line.cell;
            let other = position.points.iter().find(|other| other.cell == [column, 2 - row]).unwrap();
            let [a, b] = [line, other].map(|line| line.vergence.unwrap().mean_per_m());
            assert!((a - b).abs() < 1e-6, "{a} {b}");
        }
    }
}

/// Where on the display, mm from its middle, a ray from the eye comes to that meets the slab's faces `passes` times on its way from the
/// one grating to the other, by the grating equation, Snell's law and the conic of `make.py`; none if it misses the grating at the end.
fn on_the_display(eye: DVec3, dir: DVec3, passes: i32) -> Option<[f64; 2]> {
    let middle = -4.5 * step();
    let to = |from: DVec3, dir: DVec3, z: f64| from + dir * ((z - from.z) / dir.z);
    let out = to(eye, dir, -18.0);
    let guided = DVec3::new(dir.x - 550.0 / 400.0, dir.y, 0.0);
    let depth = (1.7f64 * 1.7 - guided.length_squared()).sqrt();
    let back = out + guided * (f64::from(passes) * THICKNESS / depth);
    if (back.x - middle).abs() > 2.0 || guided.length() < 1.0 {
        return None;
    }
    let flat = to(DVec3::new(back.x - middle, back.y, -18.0 - THICKNESS), dir, -21.5);
    let inside = DVec3::new(dir.x / 1.5, dir.y / 1.5, 0.0);
    let inside = inside - DVec3::Z * (1.0 - inside.length_squared()).sqrt();
    // z = −24.5 + r²/R/(1 + √(1 − (1 + k) r²/R²)), R = 15, k = −2.25: as a root along the ray, by fixed point.
    let sag = |p: DVec3| {
        let r2 = p.x * p.x + p.y * p.y;
        r2 / 15.0 / (1.0 + (1.0 + 1.25 * r2 / 225.0).sqrt())
    };
    let mut at = to(flat, inside, -24.5);
    for _ in 0..100 {
        at = to(flat, inside, -24.5 + sag(at));
    }
    // x² + y² = 2 R z + (1 + k)(−z²)…: gradient (x, y, (1 + k) z − R).
    let normal = DVec3::new(at.x, at.y, -1.25 * sag(at) - 15.0).normalize();
    let tangential = 1.5 * (inside - normal * inside.dot(normal));
    let leaves = tangential + normal * (1.0 - tangential.length_squared()).sqrt();
    let display = to(at, leaves, -24.5 - FOCAL_LENGTH);
    Some([display.x, display.y])
}

/// How far at most from the places where its directions lead a scan has its points, as the lens shows them, arcmin; and over how many
/// passes. `x`: of the eye, mm.
fn off(found: &Scan, position: &Position, x: f64) -> (f64, BTreeSet<i32>) {
    let (mut worst, mut numbers) = (0f64, BTreeSet::new());
    for line in &position.points {
        let [right, up] = line.direction_deg.expect("it is seen").map(|angle| angle.to_radians().tan());
        let dir = DVec3::new(right, up, -1.0).normalize();
        let [u, v] = place(line.cell);
        let [width, height] = found.picture_m.map(|side| 1e3 * side);
        let off = |[a, b]: [f64; 2]| ((a - u * width).hypot(b - v * height) / FOCAL_LENGTH).to_degrees() * 60.0;
        let eye = DVec3::new(x, 0.0, 0.0);
        let ways = (1..40).step_by(2).filter_map(|passes| Some((off(on_the_display(eye, dir, passes)?), passes)));
        let (arcmin, passes) = ways.min_by(|a, b| a.0.total_cmp(&b.0)).expect("it meets the grating");
        worst = worst.max(arcmin);
        numbers.insert(passes);
    }
    (worst, numbers)
}

/// The whole display from three places of one eyebox: each point comes over its own number of reflections, and the direction in which it
/// is seen leads to it.
#[test]
fn a_scan_stitches_the_ways_through_the_slab() {
    let found = scanned(&sample("waveguide", &[]), [3, 1], [1e-3, 0.0], None);
    let (mut worst, mut numbers) = (0f64, BTreeSet::new());
    for position in &found.positions {
        assert_eq!(position.seen, 1.0);
        let (arcmin, passes) = off(&found, position, 1e3 * position.x_m);
        worst = worst.max(arcmin);
        numbers.extend(passes);
    }
    println!("off by up to {worst:.1e}′, over {numbers:?} passes");
    assert!(worst < 0.1 && numbers.len() > 1, "{worst}′, {numbers:?}");
}

long! {
#[test]
fn as_planned_it_is_what_plain_paths_see() {
    as_brute_force("waveguide", &[], [32, 256]);
}
}
