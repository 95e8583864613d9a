//! `samples/pancake` by paraxial optics and Jones calculus: where the folded picture stands, how bright it is, and the ghost that
//! a wave plate off a quarter lets through unfolded.

use super::{as_brute_force, bright, sample, scanned, seen_at};
use crate::polarisers::{Jones, jones, real, times};
use eyebox::base::Complex;

/// Lengths in metres, as the sample's `make.py` has them.
const REFLECTIVE: f64 = -0.018;
const VERTEX: f64 = -0.030;
const DISPLAY: f64 = -0.044;
const RADIUS: f64 = 0.080;
const SHELL: f64 = 0.0015;
/// N-BK7 at 550 nm.
const INDEX: f64 = 1.5185;

/// Height and slope of a ray (Hecht, Optics, 6.2.1).
type Ray = [f64; 2];

fn on([y, u]: Ray, distance: f64) -> Ray {
    [y + u * distance, u]
}

/// From the display through the half mirror's shell to the eye, folded or at once.
fn to_eye(ray: Ray, folded: bool) -> Ray {
    let [y, u] = on(ray, VERTEX - SHELL - DISPLAY);
    let ray = on([y, (u - (INDEX - 1.0) * y / (RADIUS + SHELL)) / INDEX], SHELL);
    let [y, u] = [ray[0], INDEX * ray[1] + (INDEX - 1.0) * ray[0] / RADIUS];
    if !folded {
        return on([y, u], -VERTEX);
    }
    let [y, u] = on([y, u], 2.0 * (REFLECTIVE - VERTEX));
    on([y, u - 2.0 * y / RADIUS], -VERTEX)
}

/// Tangent under which the eye sees a point of the display at a height of 1, and 1/distance of its image in 1/m.
fn seen(folded: bool) -> [f64; 2] {
    let ([a, c], [b, d]) = (to_eye([1.0, 0.0], folded), to_eye([0.0, 1.0], folded));
    // The ray that meets the pupil's middle leaves with the slope −a/b; the eye looks against it.
    [a * d / b - c, d / b]
}

/// Luminances of the ghost, of the folded picture, and of what goes to and fro once more each, for 1 of the display's.
fn by_jones(plate_deg: f64) -> [f64; 8] {
    let delta = plate_deg.to_radians();
    let lag = |delta: f64| Complex { re: delta.cos(), im: delta.sin() };
    let wave = jones(45.0, lag(delta), real(1.0));
    let half = jones(0.0, real(0.5f64.sqrt()), real(0.5f64.sqrt()));
    let through = jones(90.0, real(0.9f64.sqrt()), real(0.0005f64.sqrt()));
    let back = jones(90.0, real(-0.005f64.sqrt()), real(-0.95f64.sqrt()));
    // A polariser along x before a quarter-wave plate at −45° makes light that turns to the right.
    let circular = times(jones(-45.0, lag(90f64.to_radians()), real(1.0)), jones(0.0, real(1.0), real(0.0)));
    let first = times(wave, times(half, circular));
    let mirror = jones(0.0, real(-0.5f64.sqrt()), real(-0.5f64.sqrt()));
    let again = |light: Jones| times(wave, times(mirror, times(wave, times(back, light))));
    // The display's light is unpolarised: half of it along each axis.
    let light = |m: Jones| 0.5 * m.iter().flatten().map(|x| x.norm_sq()).sum::<f64>();
    let mut there = first;
    std::array::from_fn(|_| {
        let seen = light(times(through, there));
        there = again(there);
        seen
    })
}

#[test]
fn the_folded_picture_and_its_ghost_are_where_paraxial_optics_has_them() {
    let found = scanned(&sample("pancake", &["DISPLAY.size=[1.2, 0.7]"]), [1, 1], [0.0, 0.0], None);
    let position = &found.positions[0];
    let [[main, per_m], [ghost, _]] = [seen(true), seen(false)];
    seen_at(&found, position, |[x, y]| [main * x, main * y]);
    let got = position.distance.unwrap().centre_per_m.unwrap();
    assert!((got - per_m).abs() < 5e-3, "{got} 1/m, want {per_m}");
    let [direct, folded, ..] = by_jones(88.0);
    // Others go to and fro more often.
    let second = position.ghosts.iter().min_by_key(|ghost| ghost.by.len()).expect("a ghost");
    for point in &second.points {
        let [x, y] = super::place(point.cell);
        let at = [x * found.picture_m[0], y * found.picture_m[1]];
        for (got, at) in point.separation_arcmin.into_iter().zip(at) {
            let want = 60.0 * ((ghost * at).atan() - (main * at).atan()).to_degrees();
            assert!((got - want).abs() < 0.1, "{}, {:?}: {got}′, want {want}′", second.by, point.cell);
        }
    }
    println!("{}: {} of the picture, want {}", second.by, second.mean_ratio, direct / folded);
    assert!((second.mean_ratio / (direct / folded) - 1.0).abs() < 5e-3, "{} {}", second.mean_ratio, direct / folded);
}

long! {
#[test]
fn its_luminance_is_that_of_jones_calculus() {
    for (waves, degrees) in [("0.25", 90.0), ("0.24444444444444444", 88.0), ("0.16666666666666666", 60.0)] {
        let set = format!("QUARTER_WAVE_PLATE.finish.retardance_waves={waves}");
        let found = scanned(&sample("pancake", &[&set]), [1, 1], [0.0, 0.0], Some(192));
        // A plate far from a quarter sends a tenth round once more: the picture's middle has all of it.
        let want: f64 = by_jones(degrees).iter().sum();
        bright(&set, found.positions[0].luminance.unwrap().centre, 2000.0 * want);
    }
}
}

#[test]
fn as_planned_it_is_what_plain_paths_see() {
    // After 16 passes nearly dark blocks have not seen what little light they have.
    as_brute_force("pancake", &[], [64, 128]);
}
