//! Paths from the eye that follow faint branches bring the same light, and a pilot sees where that pays.

use super::curve::picture::Picture;
use super::curve::race::Ready;
use super::{generate, kit};
use eyebox_base::stats::Moments;
use eyebox_estimate::run::begin;
use eyebox_film::plan::{Estimator, Plan};
use eyebox_plan::{Asked, Choice, Guides, plan};
use eyebox_scene::{Finish, Scene};
use glam::{DAffine3, DVec3};

const SIZE: [usize; 2] = [16, 12];

/// Two panes before a dark ground: the bright sky behind the eye is mirrored in both faces of both, in the far one's by the
/// third and fourth face that a path meets.
fn panes(behind: f64) -> Scene {
    let mut scene = kit::scene(20.0, 1);
    scene.eye.resolution = SIZE;
    scene.eye.pupil_diameter_m = 4e-3;
    for depth in [0.1, 0.15] {
        let place = DAffine3::from_translation(DVec3::Z * -depth) * DAffine3::from_rotation_x(0.2);
        generate::plate(&mut scene, place, 0.1, Finish::Polished);
    }
    // The middle of a panorama is towards +z.
    let luminance = |i: usize| if (16..48).contains(&(i % 64)) { behind as f32 } else { 100.0 };
    kit::sky(&mut scene, 64, 32, (0..64 * 32).map(luminance).collect());
    let ready = Ready::new(&scene, 0.0).unwrap();
    assert_eq!(ready.world.sky.as_ref().unwrap().luminance(DVec3::NEG_Z), 100.0);
    scene
}

/// A lens throws the light of a small lamp on a sheet before the eye: a disc with a sharp rim.
pub(super) fn lamp_on_a_sheet(scene: &mut Scene, reflectance: f64) {
    let led = kit::group(scene, "led");
    let mut square = |depth: f64, half: f64, face| {
        let quad = kit::quad(DVec3::Z * -depth, DVec3::X * half, DVec3::Y * half);
        kit::add(scene, kit::mesh(&[quad]), DAffine3::IDENTITY, None, vec![face]);
    };
    square(0.25, 1e-3, kit::shining(led, 1e6));
    square(0.1, 0.1, kit::face(Finish::Lambert { reflectance, transmittance: 0.7 }));
    generate::lens(scene, 0.2, 0.03, 0.01);
}

fn planned(scene: &Scene, choice: Choice) -> Plan {
    let ready = Ready::new(scene, 0.0).unwrap();
    plan(&ready.checked, &ready.world, choice)
}

/// Sum of the picture over seeds, and the mean variance of a pixel, relative to its square.
fn sums(scene: &Scene, plan: &Plan, passes: u64, seeds: u64) -> (Moments, f64) {
    let ready = Ready::new(scene, 0.0).unwrap();
    let [width, height] = scene.eye.resolution;
    let (mut sum, mut pixels) = (Moments::default(), vec![Moments::default(); width * height]);
    for seed in 0..seeds {
        let mut tracing = begin(&ready.world, plan, scene.groups.len(), scene.eye.resolution, 70 + seed);
        tracing.step(passes);
        let all = Picture::of_films(tracing.films(), scene.eye.resolution).values;
        sum.add(all.iter().sum());
        pixels.iter_mut().zip(&all).for_each(|(moments, light)| moments.add(*light));
    }
    let relative = |moments: &Moments| moments.variance() / moments.mean.powi(2);
    (sum, pixels.iter().map(relative).sum::<f64>() / pixels.len() as f64)
}

fn assert_alike(a: &Moments, b: &Moments, most: f64) {
    let sigma = a.stderr().hypot(b.stderr());
    assert!((a.mean - b.mean).abs() < 4.0 * sigma, "{} and {} ± {sigma}", a.mean, b.mean);
    assert!(sigma < most * a.mean, "{sigma} of {}", a.mean);
}

/// The bright sky in the far pane is not left to one path in thirty.
#[test]
fn faint_reflections_of_a_bright_sky_are_followed() {
    let scene = panes(10_000.0);
    let chosen = planned(&scene, Choice::Auto);
    assert!(chosen.faintest_branch < 1.0);
    assert!(chosen.notes.iter().any(|note| note.contains("follows branches")), "{:?}", chosen.notes);
    let (followed, less) = sums(&scene, &chosen, 16, 24);
    let (left_to_chance, more) = sums(&scene, &Plan { faintest_branch: 1.0, ..chosen }, 16, 24);
    assert_alike(&followed, &left_to_chance, 0.01);
    assert!(30.0 * less < more, "variances {less} and {more}");
}

/// Nothing is to be gained on the generator's panoramas and floors, whose error is that of edges and lamps; and nothing is tried
/// where nothing is to be guided.
#[test]
fn what_does_not_pay_is_not_followed() {
    for seed in [2, 5, 9] {
        let plan = planned(&generate::scene(seed), Choice::Auto);
        assert_eq!(plan.faintest_branch, 1.0, "seed {seed}");
    }
    let unguided = Asked { guides: Guides::Off, ..Choice::Auto.into() };
    let scene = panes(10_000.0);
    let ready = Ready::new(&scene, 0.0).unwrap();
    assert_eq!(plan(&ready.checked, &ready.world, unguided).faintest_branch, 1.0);
}

/// Before scatterers, too: in a room behind glass, and on a floor that lamps light.
#[test]
fn branches_before_scatterers_bring_the_same_light() {
    for (seed, most) in [(2, 0.01), (5, 0.01), (6, 0.05)] {
        let mut scene = generate::scene(seed);
        scene.eye.resolution = SIZE;
        let simple = Plan { faintest_branch: 1.0, ..planned(&scene, Choice::Only(Estimator::Backward)) };
        let (all, _) = sums(&scene, &simple, 64, 16);
        let (branched, _) = sums(&scene, &Plan { faintest_branch: 1.0 / 1024.0, ..simple }, 64, 16);
        assert_alike(&all, &branched, most);
    }
}

/// A pilot that sees no light says nothing: a plan has paths from the eye all the same.
#[test]
fn black_pilots_leave_paths() {
    let scene = generate::scene(0);
    for choice in [Choice::Auto, Choice::Only(Estimator::Photon), Choice::Only(Estimator::Manifold)] {
        let plan = planned(&scene, choice);
        assert_eq!(plan.check(scene.groups.len(), scene.parts.len()), Ok(()), "{choice:?}");
    }
    let mut scene = generate::scene(2);
    kit::sky(&mut scene, 2, 1, vec![0.0; 2]);
    let plan = planned(&scene, Choice::Only(Estimator::Photon));
    assert_eq!(plan.check(scene.groups.len(), scene.parts.len()), Ok(()));
}

/// Lamps behind a diffuser are seldom looked for over specular faces; the sky in the same picture is looked for as ever. Where a
/// lamp may be seen they are.
#[test]
fn lamps_behind_a_diffuser_are_seldom_looked_for() {
    let mut scene = kit::scene(20.0, 1);
    scene.eye.resolution = SIZE;
    scene.eye.pupil_diameter_m = 4e-3;
    kit::sky(&mut scene, 2, 1, vec![100.0; 2]);
    lamp_on_a_sheet(&mut scene, 0.1);
    let hidden = planned(&scene, Choice::Auto);
    assert_eq!((hidden.vision_share, hidden.backward_share), (1.0 / 64.0, 1.0), "{:?}", hidden.rows);
    // A hundredth of a pixel in plain sight is missed by all rays that aim at nothing.
    let mut scene = kit::scene(20.0, 1);
    (scene.eye.resolution, scene.eye.pupil_diameter_m) = (SIZE, 4e-3);
    kit::sky(&mut scene, 2, 1, vec![100.0; 2]);
    let led = kit::group(&mut scene, "led");
    let quad = kit::quad(DVec3::new(0.01, 0.02, -1.0), DVec3::X * 2e-3, DVec3::Y * 2e-3);
    kit::add(&mut scene, kit::mesh(&[quad]), DAffine3::IDENTITY, None, vec![kit::shining(led, 1e6)]);
    assert_eq!(planned(&scene, Choice::Auto).vision_share, 1.0);
    for seed in [0, 5] {
        assert_eq!(planned(&generate::scene(seed), Choice::Auto).vision_share, 1.0, "seed {seed}");
    }
}

/// Looked for at few pixels of a pass, a lamp weighs as much more there: behind two panes it is as bright as if all looked,
/// and so is the sky beside it, which brings about as much light.
#[test]
fn seldom_looks_bring_the_same_light() {
    let mut scene = panes(100.0);
    let led = kit::group(&mut scene, "led");
    let quad = kit::quad(DVec3::Z * -0.3, DVec3::X * 0.03, DVec3::Y * 0.03);
    kit::add(&mut scene, kit::mesh(&[quad]), DAffine3::IDENTITY, None, vec![kit::shining(led, 200.0)]);
    let all = planned(&scene, Choice::Only(Estimator::Backward));
    assert_eq!((all.vision_share, all.backward_share), (1.0, 1.0));
    let (light, variance) = sums(&scene, &all, 16, 12);
    for (vision_share, backward_share) in [(0.125, 1.0), (0.125, 0.5), (1.0, 0.5)] {
        let plan = Plan { vision_share, backward_share, ..all.clone() };
        let (seldom, seldom_variance) = sums(&scene, &plan, 64, 12);
        assert_alike(&seldom, &light, 0.02);
        // It does look more seldom.
        assert!(seldom_variance > 1.2 * variance / 4.0, "{seldom_variance} and {variance}");
    }
}
