//! Closed forms and agreements that need the whole tracer: furnaces, slabs, balances, estimator against estimator.

use crate::common::*;
use eyebox::check::check;
use eyebox::estimate::run::begin;
use eyebox::film::plan::{Estimator, Plan};
use eyebox::plan::{Asked, Choice, Guides, plan};
use eyebox::scene::{Absorption, Finish, Shape};
use eyebox::world::World;
use glam::DVec3;

const BACKWARD: Choice = Choice::Only(Estimator::Backward);
const FORWARD: Choice = Choice::Only(Estimator::Forward);
const PHOTON: Choice = Choice::Only(Estimator::Photon);

/// A lossless ball, exact or meshed, in a uniform sky is invisible: every pixel is the sky's luminance, each path.
#[test]
fn a_lossless_ball_in_a_uniform_sky_is_invisible() {
    for exact in [true, false] {
        let mut s = scene();
        uniform_sky(&mut s, 500.0);
        let mut ball = face(Finish::Polished);
        if exact {
            ball.shape = ball_shape(0.01);
        }
        add_part(&mut s, "ball", sphere_mesh(0.01, 48, 96), DVec3::new(0.0, 0.0, -0.05), Some(1.5), vec![ball]);
        let (films, _) = render(&s, BACKWARD, 1024, 1);
        let image = image(&films);
        let (mean, sigma) = mean(&image);
        // All but the few paths that play roulette after many reflections bring exactly the sky's luminance. On the mesh
        // interpolated normals lose whole paths at grazing incidence, one or two in 64 passes of the picture: so many passes
        // that σ does not hang on whether one is lost.
        assert!(sigma < if exact { 0.0125 } else { 0.05 }, "exact {exact}: {sigma}");
        let allowed = 4.0 * sigma + if exact { 1e-9 } else { 1.0 };
        assert!((mean - 500.0).abs() < allowed, "exact {exact}: {mean} ± {sigma}");
    }
}

/// A convex Lambertian body in a uniform sky: L = ρ L₀; the same from NEE and from the scattered ray alone.
#[test]
fn a_lambertian_ball_in_a_uniform_sky() {
    let mut s = scene();
    uniform_sky(&mut s, 1000.0);
    s.eye.fov_deg = 5.0;
    let mut ball = face(Finish::Lambert { reflectance: 0.6, transmittance: 0.0 });
    ball.shape = ball_shape(0.02);
    add_part(&mut s, "ball", sphere_mesh(0.02, 48, 96), DVec3::new(0.0, 0.0, -0.1), None, vec![ball]);
    let (films, _) = render(&s, BACKWARD, 2048, 1);
    let (mean, sigma) = mean(&image(&films));
    assert!(sigma < 0.6, "{sigma}");
    assert!((mean - 600.0).abs() < 4.0 * sigma, "{mean} ± {sigma}");
}

/// Inside a closed Lambertian box whose walls all emit: L = Le/(1 − ρ), seen from inside.
#[test]
fn a_closed_emitting_box() {
    let mut s = scene();
    let group = add_group(&mut s, "walls");
    // Faces that look inwards: the cuboid's, turned over.
    let inward: Vec<Vec<DVec3>> =
        cuboid(DVec3::splat(0.05)).into_iter().map(|p| p.into_iter().rev().collect()).collect();
    let faces = (0..6)
        .map(|_| {
            let mut f = face(Finish::Lambert { reflectance: 0.7, transmittance: 0.0 });
            f.emitter = lamp(group, 100.0);
            f
        })
        .collect();
    add_part(&mut s, "box", mesh(&inward), DVec3::ZERO, None, faces);
    s.eye.pupil_diameter_m = 0.0;
    let (films, _) = render(&s, BACKWARD, 1024, 3);
    let (mean, sigma) = mean(&image(&films));
    let want = 100.0 / 0.3;
    assert!(sigma / want < 1.5e-3, "{sigma}");
    assert!((mean - want).abs() < 4.0 * sigma, "{mean} ± {sigma}, {want}");
}

/// A plane-parallel plate before a panel: T = (1 − r)/(1 + r) for each polarisation, with r the face's reflectance (the
/// plate's inner reflections included).
#[test]
fn a_plate_transmits_its_closed_form() {
    let mut s = scene();
    let group = add_group(&mut s, "panel");
    s.eye.fov_deg = 1.0;
    s.eye.resolution = [4, 4];
    let plate = add_part(
        &mut s,
        "plate",
        mesh(&cuboid(DVec3::new(0.5, 0.5, 0.002))),
        DVec3::new(0.0, 0.0, -0.1),
        Some(1.5),
        vec![face(Finish::Polished); 6],
    );
    let tilt = 60f64.to_radians();
    s.parts[plate].to_world =
        glam::DAffine3::from_translation(DVec3::new(0.0, 0.0, -0.1)) * glam::DAffine3::from_rotation_x(tilt);
    let mut panel = face(Finish::Absorber);
    panel.emitter = lamp(group, 1000.0);
    add_part(
        &mut s,
        "panel",
        mesh(&[quad(DVec3::ZERO, DVec3::X * 0.02, DVec3::Y * 0.02)]),
        DVec3::new(0.0, 0.0, -0.3),
        None,
        vec![panel],
    );
    let (films, _) = render(&s, BACKWARD, 4096, 5);
    let (mean, sigma) = mean(&image(&films));
    let transmittance = |cos: f64| {
        let q2 = (1.25 + cos * cos).sqrt();
        let r_s = ((cos - q2) / (cos + q2)).powi(2);
        let r_p = ((2.25 * cos - q2) / (2.25 * cos + q2)).powi(2);
        // Each polarisation by itself, averaged last.
        let plate = |r: f64| (1.0 - r) / (1.0 + r);
        (plate(r_s) + plate(r_p)) / 2.0
    };
    // The mean over the field, which is 4e-5 less than in its middle.
    let (half, steps) = (0.5f64.to_radians().tan(), 64);
    let place = |k: usize| half * ((2 * k + 1) as f64 / steps as f64 - 1.0);
    let cos_at = |x: f64, y: f64| (tilt.cos() - tilt.sin() * y) / (1.0 + x * x + y * y).sqrt();
    let cells = (0..steps * steps).map(|k| transmittance(cos_at(place(k % steps), place(k / steps))));
    let want = 1000.0 * cells.sum::<f64>() / (steps * steps) as f64;
    assert!(sigma / want < 2e-3, "{sigma}");
    assert!((mean - want).abs() < 4.0 * sigma, "{mean} ± {sigma}, {want}");
}

/// A lamp, a lens-like ball and a screen that all estimators can do: backward, forward and photons agree.
fn ball_and_screen() -> eyebox::scene::Scene {
    let mut s = scene();
    let group = add_group(&mut s, "panel");
    s.eye.position = DVec3::new(0.0, 0.0, 0.3);
    s.eye.pupil_diameter_m = 0.2;
    s.eye.focus_distance_m = 0.3;
    s.eye.fov_deg = 12.0;
    s.eye.resolution = [12, 12];
    let screen = face(Finish::Lambert { reflectance: 0.4, transmittance: 0.5 });
    add_part(
        &mut s,
        "screen",
        mesh(&[quad(DVec3::ZERO, DVec3::X * 0.04, DVec3::Y * 0.04)]),
        DVec3::ZERO,
        None,
        vec![screen],
    );
    let mut ball = face(Finish::Polished);
    ball.shape = ball_shape(0.012);
    add_part(&mut s, "ball", sphere_mesh(0.012, 32, 64), DVec3::new(0.0, 0.0, -0.03), Some(1.5), vec![ball]);
    let mut panel = face(Finish::Lambert { reflectance: 0.3, transmittance: 0.0 });
    panel.emitter = lamp(group, 1e5);
    add_part(
        &mut s,
        "panel",
        mesh(&[quad(DVec3::ZERO, DVec3::X * 0.012, DVec3::Y * 0.012)]),
        DVec3::new(0.0, 0.0, -0.08),
        None,
        vec![panel],
    );
    s
}

#[test]
fn backward_and_forward_agree_and_the_test_bites() {
    let s = ball_and_screen();
    let (films, _) = render(&s, BACKWARD, 16384, 1);
    let backward = image(&films);
    let (films, _) = render(&s, FORWARD, 2000, 2);
    let forward = image(&films);
    let (m, sigma) = mean(&backward);
    let (f, f_sigma) = mean(&forward);
    assert!(sigma / m < 3.5e-3 && f_sigma / f < 3e-3, "{m} ± {sigma}, {f} ± {f_sigma}");
    assert!((m - f).abs() < 4.0 * sigma.hypot(f_sigma), "means {m} ± {sigma}, {f} ± {f_sigma}");
    let (worst, bound) = worst_z(&block_z(&backward, &forward, 12, 3), 1e-3);
    assert!(worst < bound, "{worst} of {bound}");
    let biased: Vec<(f64, f64)> = forward.iter().map(|p| (p.0 * 1.02, p.1)).collect();
    let (worst, bound) = worst_z(&block_z(&backward, &biased, 12, 12), 1e-3);
    assert!(worst > bound, "a bias of 2 % must be found: {worst} of {bound}");
}

long! {
#[test]
fn photons_agree_with_backward() {
    let s = ball_and_screen();
    let (films, _) = render(&s, BACKWARD, 4096, 1);
    let backward = image(&films);
    let (films, _) = render(&s, PHOTON, 512, 2);
    let photon = image(&films);
    let (m, sigma) = mean(&backward);
    let (p, p_sigma) = mean(&photon);
    assert!(p_sigma / p < 3e-3, "{p} ± {p_sigma}");
    assert!((m - p).abs() < 4.0 * sigma.hypot(p_sigma), "means {m} ± {sigma}, {p} ± {p_sigma}");
    let (worst, bound) = worst_z(&block_z(&backward, &photon, 12, 3), 1e-3);
    assert!(worst < bound, "{worst} of {bound}");
}
}

/// A pinhole sees a small lamp in two curved mirrors and, blurred by nothing, far smaller than a pixel. Points that are
/// chosen about the images bring the same light as even ones, with far less noise, and so in each part of the picture.
#[test]
fn a_pinhole_sees_a_lamp_in_balls() {
    let mut s = scene();
    let group = add_group(&mut s, "panel");
    s.eye.pupil_diameter_m = 0.0;
    s.eye.resolution = [8, 4];
    for x in [-0.02, 0.025] {
        let mut ball = face(Finish::MirrorIdeal { reflectance: 0.8 });
        ball.shape = ball_shape(0.015);
        add_part(&mut s, "ball", sphere_mesh(0.015, 32, 64), DVec3::new(x, 0.0, -0.2), None, vec![ball]);
    }
    let mut panel = face(Finish::Absorber);
    panel.emitter = lamp(group, 1e6);
    let panel_mesh = mesh(&[quad(DVec3::ZERO, DVec3::Y * 0.008, DVec3::X * 0.016)]);
    add_part(&mut s, "panel", panel_mesh, DVec3::new(0.03, 0.04, 0.0), None, vec![panel]);
    let checked = check(&s).expect("sound");
    let world = World::freeze(&s).expect("sound");
    let known = plan(&checked, &world, BACKWARD);
    assert!(known.glints.len() >= 2, "{:?}", known.glints);
    let mut even = known.clone();
    even.glints.clear();
    let trace = |plan: &Plan, passes: u64| {
        let mut tracing = begin(&world, plan, 1, s.eye.resolution, 1);
        tracing.step(passes);
        image(&tracing.into_films())
    };
    let (known, even) = (trace(&known, 64), trace(&even, 30_000));
    let ((m, sigma), (e, e_sigma)) = (mean(&known), mean(&even));
    eprintln!("about the images {m} ± {sigma}, even {e} ± {e_sigma}");
    assert!(e_sigma < 0.03 * e && (m - e).abs() < 4.0 * sigma.hypot(e_sigma), "{m} ± {sigma}, {e} ± {e_sigma}");
    // With 470 times the passes.
    assert!(sigma < 2.0 * e_sigma, "{sigma} {e_sigma}");
    let (worst, bound) = worst_z(&block_z(&known, &even, 8, 4), 1e-3);
    assert!(worst < bound, "{worst} of {bound}");
}

/// A ball lens images a small lamp into a part of the pupil. Rays that start where light from the lamp was seen to cross
/// bring the same light as rays that start all over the pupil, with far less noise, and so in each part of the picture.
#[test]
fn a_pupil_sees_a_lamp_in_a_part_of_it() {
    let mut s = scene();
    let group = add_group(&mut s, "led");
    s.eye.pupil_diameter_m = 6e-3;
    s.eye.resolution = [8, 4];
    // The middle of the ball, where it makes an image.
    s.eye.fov_deg = 0.8;
    let mut ball = face(Finish::Polished);
    ball.shape = ball_shape(0.015);
    add_part(&mut s, "ball", sphere_mesh(0.015, 32, 64), DVec3::new(0.0, 0.0, -0.2), Some(1.5), vec![ball]);
    let mut led = face(Finish::Absorber);
    led.emitter = lamp(group, 1e6);
    // Magnified eightfold: 1/f = 1/0.2 + 1/0.0254 with f = nR/(2(n - 1)).
    let led_mesh = mesh(&[quad(DVec3::ZERO, DVec3::X * 1e-4, DVec3::Y * 1e-4)]);
    add_part(&mut s, "led", led_mesh, DVec3::new(0.0, 0.0, -0.2254), None, vec![led]);
    let checked = check(&s).expect("sound");
    let world = World::freeze(&s).expect("sound");
    let known = plan(&checked, &world, BACKWARD);
    assert!(known.pupil_guide.is_some(), "{:?}", known.notes);
    let even = plan(&checked, &world, Asked { guides: Guides::Off, ..BACKWARD.into() });
    assert!(even.pupil_guide.is_none(), "nothing is aimed");
    let trace = |plan: &Plan, passes: u64| {
        let mut tracing = begin(&world, plan, 1, s.eye.resolution, 1);
        tracing.step(passes);
        image(&tracing.into_films())
    };
    let (known, even) = (trace(&known, 500), trace(&even, 10_000));
    let ((m, sigma), (e, e_sigma)) = (mean(&known), mean(&even));
    eprintln!("guided {m} ± {sigma}, even {e} ± {e_sigma}");
    assert!(e_sigma < 0.02 * e && (m - e).abs() < 4.0 * sigma.hypot(e_sigma), "{m} ± {sigma}, {e} ± {e_sigma}");
    // With twenty times the passes.
    assert!(sigma < 2.0 * e_sigma, "{sigma} {e_sigma}");
    let (worst, bound) = worst_z(&block_z(&known, &even, 8, 4), 1e-3);
    assert!(worst < bound, "{worst} of {bound}");
}

long! {
/// Where a wall crosses a floor a photon's kernel reaches behind both, where it is dark. Without [`Rims::around`]'s seams
/// the two rows of pixels along the line were 3 % too dark.
#[test]
fn photons_by_a_wall_that_crosses_the_floor() {
    let mut s = scene();
    let group = add_group(&mut s, "panel");
    let matt = || face(Finish::Lambert { reflectance: 0.7, transmittance: 0.0 });
    let floor = mesh(&[quad(DVec3::ZERO, DVec3::Z, DVec3::X)]);
    add_part(&mut s, "floor", floor, DVec3::new(0.0, -0.3, -1.0), None, vec![matt()]);
    let wall = mesh(&[quad(DVec3::ZERO, DVec3::X, DVec3::Y)]);
    add_part(&mut s, "wall", wall, DVec3::new(0.0, 0.3, -1.3), None, vec![matt()]);
    let mut panel = face(Finish::Absorber);
    panel.emitter = lamp(group, 1e5);
    let panel_mesh = mesh(&[quad(DVec3::ZERO, DVec3::X * 0.05, DVec3::Z * 0.05)]);
    add_part(&mut s, "panel", panel_mesh, DVec3::new(0.0, 0.1, -1.2), None, vec![panel]);
    s.eye.look = DVec3::new(0.0, -0.3, -1.3).normalize();
    s.eye.up = (DVec3::Y - s.eye.look * s.eye.look.y).normalize();
    s.eye.fov_deg = 50.0;
    s.eye.resolution = [32, 2];
    let (films, _) = render(&s, BACKWARD, 4096, 1);
    let (m, sigma) = mean(&image(&films));
    let (films, _) = render(&s, PHOTON, 256, 2);
    let (p, p_sigma) = mean(&image(&films));
    eprintln!("backward {m} ± {sigma}, photons {p} ± {p_sigma}");
    assert!(sigma.hypot(p_sigma) / m < 3e-3, "{m} ± {sigma}, {p} ± {p_sigma}");
    assert!((m - p).abs() < 4.0 * sigma.hypot(p_sigma), "{m} ± {sigma}, {p} ± {p_sigma}");
}
}

/// Every emitted lumen is found again among the fates, each counted where it happens. That a planted leak turns this
/// red is shown beside the walk, in `src/estimate/leak_tests.rs`.
#[test]
fn the_ledger_balances() {
    let mut s = ball_and_screen();
    s.media[0].absorption = Absorption::Constant(20.0);
    for (choice, estimator) in
        [(FORWARD, Estimator::Forward), (PHOTON, Estimator::Photon), (BACKWARD, Estimator::Backward)]
    {
        let (films, _) = render(&s, choice, 64, 9);
        let ledger = films.ledger(estimator).expect("it ran");
        let sigma = ledger.imbalance_sigma().max(1e-12 * ledger.emitted);
        assert!(sigma < 1e-4 * ledger.emitted, "{estimator:?}: σ {} of {}", sigma, ledger.emitted);
        assert!(ledger.imbalance().abs() <= 3.0 * sigma, "{estimator:?}: {} of σ {sigma}", ledger.imbalance());
        assert_eq!(ledger.invalid_paths, 0);
        assert!(ledger.vertex_error <= 1e-12, "{estimator:?}: R + T + A − 1 = {:.1e}", ledger.vertex_error);
    }
}

/// The same bits for 1, 2 and 7 threads.
#[test]
fn threads_change_no_bit() {
    let s = ball_and_screen();
    let take = |threads: usize, choice| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| image(&render(&s, choice, 3, 4).0))
    };
    for choice in [Choice::Auto, BACKWARD, FORWARD] {
        let one = take(1, choice);
        assert!(one == take(2, choice) && one == take(7, choice), "{choice:?}");
    }
}

/// A flat mirror shows the panel at its own luminance times the reflectance, wherever it hangs.
#[test]
fn a_mirror_shows_the_panel() {
    let mut s = scene();
    let group = add_group(&mut s, "panel");
    s.eye.fov_deg = 2.0;
    let mut mirror = face(Finish::MirrorIdeal { reflectance: 0.8 });
    mirror.shape = Shape::Plane { vertex: DVec3::ZERO, axis: DVec3::Z };
    add_part(
        &mut s,
        "mirror",
        mesh(&[quad(DVec3::ZERO, DVec3::X * 0.05, DVec3::Y * 0.05)]),
        DVec3::new(0.0, 0.0, -0.2),
        None,
        vec![mirror],
    );
    let mut panel = face(Finish::Absorber);
    panel.emitter = lamp(group, 250.0);
    add_part(
        &mut s,
        "panel",
        mesh(&[quad(DVec3::ZERO, DVec3::Y * 0.1, DVec3::X * 0.1)]),
        DVec3::new(0.0, 0.0, 0.2),
        None,
        vec![panel],
    );
    let (films, _) = render(&s, BACKWARD, 4, 1);
    for (value, _) in image(&films) {
        assert!((value - 200.0).abs() < 1e-9, "{value}");
    }
}

long! {
/// The other 188 of those that the floor's own tests begin with.
#[test]
fn furnaces_of_principled_surfaces() {
    eyebox::world::scatter::trials::furnaces(200);
}
}
