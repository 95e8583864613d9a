//! Gratings against the grating equation, in every estimator: where a lamp is seen and how bright, furnaces, and a pair whose
//! colours come together again.

use crate::common::*;
use eyebox::base::ids::GratingId;
use eyebox::film::plan::Estimator;
use eyebox::plan::{Asked, Choice, Guides, Polarisation};
use eyebox::scene::*;
use glam::{DAffine3, DVec3};

const LUMINANCE: f64 = 1000.0;
const BACKWARD: Choice = Choice::Only(Estimator::Backward);

fn order(order: i32, transmittance: f64, reflectance: f64) -> Order {
    Order { order, transmittance, reflectance }
}

fn grating(s: &mut Scene, at: DVec3, lines_per_mm: f64, orders: Vec<Order>, rest: bool) {
    s.gratings.push(Grating { direction: DVec3::Y, lines_per_mm, orders: orders.into(), rest_in_zero_order: rest });
    let finish = Finish::Grating { grating: GratingId::from_index(s.gratings.len() - 1) };
    let wide = mesh(&[quad(DVec3::ZERO, DVec3::X, DVec3::Y)]);
    add_part(s, &format!("grating at {at}"), wide, at, None, vec![face(finish)]);
}

/// A lamp about `at` that shines along `towards`.
fn panel(s: &mut Scene, at: DVec3, towards: DVec3, half: f64) {
    let group = add_group(s, "panel");
    let mut shining = face(Finish::Absorber);
    shining.emitter = lamp(group, LUMINANCE);
    let across = DVec3::X;
    let square = mesh(&[quad(DVec3::ZERO, across * half, towards.cross(across) * half)]);
    let part = add_part(s, "panel", square, DVec3::ZERO, None, vec![shining]);
    s.parts[part].to_world = DAffine3::from_translation(at);
}

fn narrow() -> Scene {
    let mut s = scene();
    s.eye.fov_deg = 0.2;
    s.eye.resolution = [2, 2];
    s
}

fn seen(s: &Scene, choice: Choice, polarisation: Polarisation, passes: u64) -> (f64, f64) {
    let (films, _) = render(s, Asked { choice, polarisation, guides: Guides::On }, passes, 7);
    for (_, _, ledger) in &films.films {
        assert_eq!((ledger.invalid_paths, ledger.mismatches), (0, 0));
    }
    mean(&image(&films))
}

/// A lamp where order +1 of a ray straight from the eye goes, through the grating or back from it, and nowhere else.
#[test]
fn a_lamp_in_the_first_order() {
    let lines = 0.5 / 550e-6;
    for (sign, through) in [(1.0, true), (-1.0, true), (1.0, false)] {
        let mut s = narrow();
        let start = DVec3::new(0.0, 0.0, -0.3);
        grating(&mut s, start, lines * sign, vec![order(1, 0.4, 0.25), order(0, 0.1, 0.1)], false);
        let dir = DVec3::new(0.0, 0.5 * sign, 0.75f64.sqrt() * if through { -1.0 } else { 1.0 });
        panel(&mut s, start + 0.2 * dir, -dir, 0.005);
        for polarisation in [Polarisation::Off, Polarisation::On] {
            let (got, sigma) = seen(&s, BACKWARD, polarisation, 1024);
            let want = LUMINANCE * if through { 0.4 } else { 0.25 };
            println!("{sign} {through} {polarisation:?}: {got} ± {sigma}, want {want}");
            assert!(
                sigma < 0.03 * want && (got - want).abs() < 4.0 * sigma + 1e-9 * want,
                "{got} ± {sigma}, want {want}"
            );
        }
    }
}

/// What an order has that is too faint to be followed by a path of its own is there in the mean.
#[test]
fn a_lamp_in_a_faint_order() {
    let lines = 0.5 / 550e-6;
    let mut s = narrow();
    let start = DVec3::new(0.0, 0.0, -0.3);
    let share = 1.0 / 1024.0;
    grating(&mut s, start, lines, vec![order(1, share, 0.0), order(0, 0.4, 0.3), order(-1, 0.0, share)], false);
    let dir = DVec3::new(0.0, 0.5, -0.75f64.sqrt());
    panel(&mut s, start + 0.2 * dir, -dir, 0.005);
    let (got, sigma) = seen(&s, BACKWARD, Polarisation::Off, 2048);
    let want = LUMINANCE * share;
    println!("{got} ± {sigma}, want {want}");
    assert!(sigma > 0.0 && sigma < 0.1 * want && (got - want).abs() < 4.0 * sigma, "{got} ± {sigma}, want {want}");
}

/// Light tracing and whatever the plan chooses see the same lamp as rays from the eye, which no connection crosses.
#[test]
fn estimators_agree_about_a_grating() {
    let mut s = scene();
    (s.eye.fov_deg, s.eye.resolution, s.eye.pupil_diameter_m) = (8.0, [8, 8], 0.06);
    let start = DVec3::new(0.0, 0.0, -0.3);
    grating(&mut s, start, 0.5 / 550e-6, vec![order(1, 0.4, 0.25), order(-1, 0.1, 0.0)], true);
    let dir = DVec3::new(0.0, 0.5, -0.75f64.sqrt());
    panel(&mut s, start + 0.2 * dir, -dir, 0.01);
    let (want, sigma) = seen(&s, BACKWARD, Polarisation::Auto, 512);
    assert!(sigma < 0.03 * want, "noise {sigma} of {want}");
    let asked =
        [(Choice::Only(Estimator::Forward), 256), (Choice::Only(Estimator::Manifold), 128), (Choice::Auto, 128)];
    for (choice, passes) in asked {
        let (got, noise) = seen(&s, choice, Polarisation::Auto, passes);
        println!("{choice:?}: {got} ± {noise}, want {want} ± {sigma}");
        assert!(noise < 0.08 * want, "noise {noise} of {want}");
        assert!((got - want).abs() < 4.0 * noise.hypot(sigma), "{choice:?}: {got} ± {noise}, want {want} ± {sigma}");
    }
}

/// In a room that is equally bright everywhere, a grating that loses nothing is not seen, whether its orders propagate or
/// not; and one that keeps what evanescent orders would have is as dark as that says.
#[test]
fn furnaces_of_gratings() {
    let all = || vec![order(1, 0.2, 0.1), order(-1, 0.2, 0.1)];
    for (lines, rest, want) in [(600.0, true, 1.0), (3000.0, true, 1.0), (600.0, false, 0.6), (3000.0, false, 0.0)] {
        let mut s = narrow();
        uniform_sky(&mut s, LUMINANCE as f32);
        grating(&mut s, DVec3::new(0.0, 0.0, -0.3), lines, all(), rest);
        let (got, sigma) = seen(&s, BACKWARD, Polarisation::Off, 64);
        let want = LUMINANCE * want;
        println!("{lines} {rest}: {got} ± {sigma}, want {want}");
        assert!((got - want).abs() < 4.0 * sigma + 1e-6 * LUMINANCE, "{lines} {rest}: {got} ± {sigma}, want {want}");
    }
}

/// Order 1 of one grating and −1 of the next: all colours of a lamp far off leave as they came.
#[test]
fn a_matched_pair_keeps_colours_together() {
    let mut s = narrow();
    s.wavelengths = Wavelengths::Visible;
    grating(&mut s, DVec3::new(0.0, 0.0, -0.2), 500.0, vec![order(1, 0.8, 0.0)], false);
    grating(&mut s, DVec3::new(0.0, 0.0, -0.22), 500.0, vec![order(-1, 0.5, 0.0)], false);
    // Red leaves the pair 9 mm higher than it came in, blue 4 mm: straight behind them is a lamp of 1° alone.
    panel(&mut s, DVec3::new(0.0, 0.0, -4.0), DVec3::Z, 0.03);
    let (got, sigma) = seen(&s, BACKWARD, Polarisation::Off, 256);
    let want = 0.4 * LUMINANCE;
    println!("{got} ± {sigma}, want {want}");
    assert!(sigma < 0.03 * want && (got - want).abs() < 4.0 * sigma + 1e-3 * want, "{got} ± {sigma}, want {want}");
}

long! {
/// A screen that a lamp lights past a grating, and past a reflective polariser: photons and whatever the plan chooses find what
/// paths from the eye find, which meet the lamp by chance behind them.
#[test]
fn a_screen_lit_through_a_grating_or_a_reflective_polariser() {
    let orders = vec![order(1, 0.3, 0.1), order(0, 0.4, 0.1), order(-1, 0.1, 0.0)];
    let polariser = Finish::ReflectivePolariser {
        projected_axis: ProjectedAxis::Absorption, axis: DVec3::new(0.6, 0.8, 0.0),
        transmittance: 0.85,
        transmittance_leak: 0.02,
        reflectance: 0.9,
        reflectance_leak: 0.05,
    };
    for is_grating in [true, false] {
        let mut s = scene();
        (s.eye.fov_deg, s.eye.resolution) = (40.0, [12, 12]);
        let white = Finish::Lambert { reflectance: 0.8, transmittance: 0.0 };
        let screen = mesh(&[quad(DVec3::ZERO, DVec3::X * 0.3, DVec3::Y * 0.3)]);
        add_part(&mut s, "screen", screen, DVec3::new(0.0, 0.0, -0.6), None, vec![face(white)]);
        s.gratings.push(Grating {
            direction: DVec3::Y,
            lines_per_mm: 400.0,
            orders: orders.clone().into(),
            rest_in_zero_order: false,
        });
        let finish = if is_grating { Finish::Grating { grating: GratingId::from_index(0) } } else { polariser };
        // Beside what the eye sees of the screen.
        let pane = mesh(&[quad(DVec3::ZERO, DVec3::X * 0.06, DVec3::Y * 0.12)]);
        add_part(&mut s, "pane", pane, DVec3::new(0.2, 0.0, -0.4), None, vec![face(finish)]);
        panel(&mut s, DVec3::new(0.26, 0.0, -0.25), DVec3::new(-0.4, 0.0, -1.0).normalize(), 0.04);
        let of = |choice: Choice, passes: u64, seed: u64| {
            let (films, _) =
                render(&s, Asked { choice, polarisation: Polarisation::On, guides: Guides::On }, passes, seed);
            for (_, _, ledger) in &films.films {
                assert_eq!((ledger.invalid_paths, ledger.mismatches), (0, 0));
            }
            image(&films)
        };
        let want = of(BACKWARD, 3072, 3);
        let (level, sigma) = mean(&want);
        assert!(level > 1.0 && sigma < 0.02 * level, "{level} ± {sigma}");
        for choice in [Choice::Only(Estimator::Photon), Choice::Auto] {
            let got = of(choice, 64, 5);
            let ((a, s_a), (b, s_b)) = (mean(&got), (level, sigma));
            println!("grating {is_grating} {choice:?}: {a} ± {s_a}, want {b} ± {s_b}");
            // A map of photons blurs by a radius; the whole of the light stays.
            assert!((a - b).abs() < 4.0 * s_a.hypot(s_b) + 5e-3 * b, "{choice:?}: {a} ± {s_a}, want {b} ± {s_b}");
        }
    }
}
}
