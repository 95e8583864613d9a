//! Lamps and paint on polished glass: light goes through the face under them, whichever end it is followed from.

use super::curve::picture::Picture;
use super::curve::race::Ready;
use super::kit;
use eyebox_base::stats::Moments;
use eyebox_estimate::run::begin;
use eyebox_film::plan::Estimator;
use eyebox_plan::{Choice, plan};
use eyebox_scene::{Finish, Scene};
use glam::{DAffine3, DVec3};

const SIZE: [usize; 2] = [8, 6];
/// Half the thickness of the pane, m, and where its middle is.
const HALF: f64 = 2e-3;
const AT: f64 = -0.25;

/// A pane before the eye.
fn pane(fov_deg: f64) -> Scene {
    let mut scene = kit::scene(fov_deg, 1);
    scene.eye.resolution = SIZE;
    scene.eye.pupil_diameter_m = 20e-3;
    let mut faces: Vec<_> = (0..6).map(|_| kit::face(Finish::Absorber)).collect();
    (faces[4], faces[5]) = (kit::face(Finish::Polished), kit::face(Finish::Polished));
    let mesh = kit::mesh(&kit::cuboid(DVec3::new(0.03, 0.03, HALF)));
    kit::add(&mut scene, mesh, DAffine3::from_translation(DVec3::Z * AT), Some(1.5), faces);
    scene
}

/// A square of this half-width in the pane's frame; it looks to +Z, towards the eye, or away.
fn square(scene: &mut Scene, middle: DVec3, half: f64, to_eye: bool, face: eyebox_scene::Face) {
    let x = if to_eye { DVec3::X } else { DVec3::NEG_X };
    let mesh = kit::mesh(&[kit::quad(middle, x * half, DVec3::Y * half)]);
    kit::add(scene, mesh, DAffine3::from_translation(DVec3::Z * AT), None, vec![face]);
}

fn matt(reflectance: f64, transmittance: f64) -> eyebox_scene::Face {
    kit::face(Finish::Lambert { reflectance, transmittance })
}

/// The sum of the picture, over seeds.
fn sum(scene: &Scene, only: Estimator, passes: u64) -> Moments {
    let ready = Ready::new(scene, 0.0).unwrap();
    let plan = plan(&ready.checked, &ready.world, Choice::Only(only));
    let mut moments = Moments::default();
    for seed in 0..12 {
        let mut tracing = begin(&ready.world, &plan, scene.groups.len(), SIZE, seed);
        tracing.step(passes);
        moments.add(Picture::of_films(tracing.films(), SIZE).values.iter().sum());
    }
    moments
}

/// All of these estimators against rays from the eye; what those find.
fn agree(scene: &Scene, passes: u64, others: &[(Estimator, u64)]) -> Moments {
    let brute = sum(scene, Estimator::Backward, passes);
    assert!(brute.mean > 0.0 && brute.stderr() < 0.015 * brute.mean, "{brute:?}");
    for (estimator, passes) in others {
        let found = sum(scene, *estimator, *passes);
        let sigma = brute.stderr().hypot(found.stderr());
        eprintln!("{estimator:?} {} ± {} of {} ± {}", found.mean, found.stderr(), brute.mean, brute.stderr());
        assert!(sigma < 0.03 * brute.mean, "{estimator:?}: {found:?}");
        assert!((found.mean - brute.mean).abs() < 4.0 * sigma, "{estimator:?}: {found:?} for {brute:?}");
    }
    brute
}

/// A lamp on the back of a pane is seen through it, as one a hair behind it: paths that start on its very face go into the
/// glass through it. Before they did, light tracing had 1/n² of the light, and connection none.
#[test]
fn a_lamp_on_glass_shines_through_its_face() {
    let lit = |behind: f64| {
        let mut scene = pane(3.0);
        let group = kit::group(&mut scene, "led");
        square(&mut scene, DVec3::new(1e-3, 0.0, -HALF - behind), 2e-3, true, kit::shining(group, 1e4));
        scene
    };
    let on = agree(&lit(0.0), 64, &[(Estimator::Forward, 64), (Estimator::Manifold, 64)]);
    let off = sum(&lit(1e-5), Estimator::Backward, 64);
    assert!((on.mean - off.mean).abs() < 4.0 * on.stderr().hypot(off.stderr()), "{on:?} for {off:?}");
}

/// A lamp on the front of a pane shines away from it, straight and off a wall: the glass behind it is in nobody's way.
#[test]
fn a_lamp_on_glass_shines_away_from_it() {
    let mut scene = pane(12.0);
    let group = kit::group(&mut scene, "led");
    square(&mut scene, DVec3::new(-5e-3, 0.0, HALF), 2e-3, true, kit::shining(group, 1e4));
    square(&mut scene, DVec3::new(0.0, 0.02, 0.2), 0.015, false, matt(0.9, 0.0));
    agree(&scene, 256, &[(Estimator::Forward, 64), (Estimator::Manifold, 64)]);
}

/// A diffuser on the front of the pane that has the lamp on its back: light that is chosen at the diffuser goes into glass at
/// once, which no straight line to the lamp does.
#[test]
fn a_diffuser_on_glass_is_lit_through_it() {
    let mut scene = pane(4.0);
    let group = kit::group(&mut scene, "led");
    square(&mut scene, DVec3::new(0.0, 0.0, -HALF), 4e-3, true, kit::shining(group, 1e4));
    square(&mut scene, DVec3::new(0.0, 0.0, HALF), 0.012, true, matt(0.2, 0.7));
    agree(&scene, 128, &[(Estimator::Forward, 256), (Estimator::Photon, 16)]);
}

/// White paint on the back of a pane: light that it sends back is refracted where it came in. A ray from the eye that lost
/// this would still be right where it came, and wrong where the light did.
#[test]
fn paint_on_glass_sends_light_back_through_its_face() {
    let mut scene = pane(4.0);
    let group = kit::group(&mut scene, "led");
    square(&mut scene, DVec3::new(0.0, 0.0, -HALF), 0.012, true, matt(0.9, 0.0));
    square(&mut scene, DVec3::new(0.02, 0.0, 0.03), 0.01, false, kit::shining(group, 1e4));
    agree(&scene, 256, &[(Estimator::Forward, 512), (Estimator::Photon, 16)]);
}
