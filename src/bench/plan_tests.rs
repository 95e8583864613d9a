//! Plans follow what their pilots measure, and what pilots miss is still in the stated error.

use super::curve::error::References;
use super::curve::race::Ready;
use super::curve::reference::{Source, references};
use super::stated::{Run, runs};
use super::{generate, kit};
use eyebox_base::chain::Step;
use eyebox_base::ids::GroupId;
use eyebox_base::path::Class;
use eyebox_base::stats::Moments;
use eyebox_estimate::manifold::seeds::connections::{Connections, index_of};
use eyebox_estimate::run::{Limits, begin};
use eyebox_film::plan::{Estimator, Plan, Verdict};
use eyebox_film::specular_chain::Connection;
use eyebox_plan::pilots::{forward, left};
use eyebox_plan::selection::Handicap;
use eyebox_plan::{Choice, plan, plan_handicapped};
use eyebox_scene::{Finish, Scene};
use eyebox_world::mode::{Mode, Mono};
use glam::{DAffine3, DVec3};
use std::sync::Arc;

/// Who has the paths of a class of the first light group, but for what connection takes of them.
fn owner(plan: &Plan, class: Class) -> (Estimator, bool) {
    match plan.row(GroupId(0), class).verdict {
        Verdict::Own { owner, .. } => (owner, false),
        Verdict::Connect { rest, .. } => (rest, true),
        Verdict::Emitted { .. } | Verdict::Skip { .. } => panic!("{class:?} is skipped"),
    }
}

/// A handicap of this factor for some estimators: as if they were slower, and as if they were noisier.
fn sabotage(estimators: &[Estimator], factor: f64) -> [Handicap; 2] {
    let mut all = [Handicap::default(); 2];
    for estimator in estimators {
        all[0].work[*estimator as usize] = factor;
        all[1].noise[*estimator as usize] = factor;
    }
    all
}

/// Owners in the plan of a scene, and in the plans that see these estimators a hundred times slower or noisier.
fn owners(seed: u64, class: Class, sabotaged: &[Estimator]) -> [(Estimator, bool); 3] {
    let scene = generate::scene(seed);
    let ready = Ready::new(&scene, 0.0).unwrap();
    let [slow, noisy] = sabotage(sabotaged, 100.0);
    [Handicap::default(), slow, noisy]
        .map(|handicap| owner(&plan_handicapped(&ready.checked, &ready.world, &handicap), class))
}

/// LEDs of 700 times the eye's etendue behind a lens: connection is six times as fast as rays from the eye, which facts
/// don't tell.
#[test]
fn sabotaged_connection_loses_its_lamps() {
    let [plain, slow, noisy] = owners(7, Class::Vision, &[Estimator::Manifold]);
    assert_eq!(plain, (Estimator::Forward, true));
    assert_eq!([slow, noisy], [(Estimator::Backward, false); 2]);
    let [_, slow, noisy] = owners(7, Class::Vision, &[Estimator::Backward]);
    assert_eq!([slow, noisy], [(Estimator::Forward, true); 2]);
}

/// Nine LEDs this far behind a lens of 25 mm that is 50 mm before the eye.
fn collimated(behind: f64) -> Scene {
    let mut scene = kit::scene(14.0, 1);
    scene.eye.resolution = [96, 72];
    scene.eye.pupil_diameter_m = 4e-3;
    generate::lens(&mut scene, 0.05, 0.025, 0.01);
    let group = kit::group(&mut scene, "led");
    let place = |i: i32| 1.5e-3 * f64::from(i);
    let centre = |k: i32| DVec3::new(place(k % 3 - 1), place(k / 3 - 1), -(0.05 + behind));
    let leds: Vec<_> = (0..9).map(|k| kit::quad(centre(k), DVec3::X * 1e-4, DVec3::Y * 1e-4)).collect();
    let faces = leds.iter().map(|_| kit::shining(group, 1e6)).collect();
    kit::add(&mut scene, kit::mesh(&leds), DAffine3::IDENTITY, None, faces);
    scene
}

/// A lamp that is imaged into the pupil is connected; one that is imaged at infinity is seen through all of the pupil, and
/// there is no point of it to solve for. Facts say the same of both: 2.1 of the eye's etendue.
#[test]
fn a_lamp_at_infinity_is_not_connected() {
    let of = |behind: f64| {
        let scene = collimated(behind);
        let ready = Ready::new(&scene, 0.0).unwrap();
        owner(&plan(&ready.checked, &ready.world, Choice::Auto), Class::Vision)
    };
    assert_eq!(of(0.05), (Estimator::Forward, true));
    let (_, connected) = of(0.025);
    assert!(!connected);
}

/// Whoever has them, it is the same light.
#[test]
fn lamps_at_infinity_are_as_bright_by_any_way() {
    let scene = collimated(0.025);
    let ready = Ready::new(&scene, 0.0).unwrap();
    let light = |choice: Choice, passes: u64| {
        let mut tracing = begin(&ready.world, &plan(&ready.checked, &ready.world, choice), 1, [96, 72], 1);
        tracing.step(passes);
        let (mut sum, mut variance) = (0.0, 0.0);
        for (_, film, _) in &tracing.films().films {
            let all = film.planes.len();
            for pixel in 0..96 * 72 {
                sum += (0..all).map(|plane| film.mean(pixel, plane).value).sum::<f64>();
                variance += film.variance(pixel, all);
            }
        }
        (sum, variance.sqrt())
    };
    let (auto, error) = light(Choice::Auto, 64);
    let (eye, of_eye) = light(Choice::Only(Estimator::Backward), 512);
    eprintln!("auto {auto} ± {error}, from the eye {eye} ± {of_eye}");
    assert!(error.hypot(of_eye) < 5e-3 * eye, "{auto} ± {error}, {eye} ± {of_eye}");
    assert!((auto - eye).abs() < 4.0 * error.hypot(of_eye), "{auto} ± {error}, {eye} ± {of_eye}");
}

/// LEDs of 790 times the eye's etendue: pass by pass connection is no better than rays from the eye, but its points on the
/// lamps are even over the passes. After 64 it needs a third of their time, after 256 a quarter.
#[test]
fn what_even_points_save_is_seen() {
    let scene = generate::scene(49);
    let ready = Ready::new(&scene, 0.0).unwrap();
    assert_eq!(owner(&plan(&ready.checked, &ready.world, Choice::Auto), Class::Vision), (Estimator::Forward, true));
}

/// Where connection has all light that a pilot sees, a pass has a quarter of a path from the lamps for each pixel; without
/// its trains, as many as light tracing alone.
#[test]
fn light_tracing_costs_as_much_as_is_left_to_it() {
    let scene = generate::scene(42);
    let ready = Ready::new(&scene, 0.0).unwrap();
    let paths = |choice| plan(&ready.checked, &ready.world, choice).forward_paths;
    assert_eq!(paths(Choice::Only(Estimator::Manifold)), 32 * 24 / 4);
    assert_eq!(paths(Choice::Only(Estimator::Forward)), 1 << 12);
}

/// Without its connections all light is left to light tracing, and where the brightest has no start, what it would bring;
/// without its train that is for rays from the eye.
#[test]
fn what_is_left_is_what_is_not_connected() {
    let scene = generate::scene(42);
    let ready = Ready::new(&scene, 0.0).unwrap();
    let plan = plan(&ready.checked, &ready.world, Choice::Only(Estimator::Manifold));
    let pilot = forward(&ready.world, &plan, 1, &|| false);
    let optics = <Mono as Mode>::optics(&ready.world, 0, 0);
    let share = |of: &[Connection]| {
        let connections = Arc::new(Connections::new(&ready.world, &index_of(&optics), of));
        left(&ready.world, &plan, 1, &pilot, connections, &|| false)
    };
    assert!(share(&plan.connections) < 1e-3);
    assert!((share(&[]) - 1.0).abs() < 0.15, "{}", share(&[]));
    // Brightest first.
    assert!(share(&plan.connections[1..]) < 1e-3);
    let mut without = plan.connections.clone();
    without[0].seeds.clear();
    let faint: f64 = plan.connections[1..].iter().map(|connection| connection.share).sum();
    let rest = share(&without);
    assert!((rest - (1.0 - faint)).abs() < 0.15, "{rest} of {}", 1.0 - faint);
}

/// LEDs behind rough glass: photons bring what it scatters.
#[test]
fn sabotaged_photons_lose_their_light() {
    let [plain, slow, noisy] = owners(60, Class::Secondary, &[Estimator::Photon]);
    assert_eq!(plain, (Estimator::Photon, false));
    assert_eq!([slow, noisy], [(Estimator::Backward, false); 2]);
}

/// LEDs over a matt floor: pass by pass photons bring what is scattered twice several times as fast as rays from the eye,
/// whose directions are even over the passes.
#[test]
fn sabotaged_rays_from_the_eye_lose_their_light() {
    // In the pilot's picture of the second photons are the smoother ones.
    for seed in [5, 19] {
        let [plain, slow, noisy] = owners(seed, Class::Secondary, &[Estimator::Backward]);
        assert_eq!(plain, (Estimator::Backward, false), "seed {seed}");
        assert_eq!([slow, noisy], [(Estimator::Photon, false); 2], "seed {seed}");
    }
}

/// Light of the LEDs that the floor and the block on it send each other: with sixteen times the passes, independent paths
/// would have a sixteenth of the variance.
#[test]
fn what_scatters_twice_converges_faster_than_by_chance() {
    let mut scene = generate::scene(5);
    scene.eye.resolution = [16, 12];
    let ready = Ready::new(&scene, 0.0).unwrap();
    let plan = plan(&ready.checked, &ready.world, Choice::Only(Estimator::Backward));
    let mut spread = [16, 256].map(|passes| (passes, vec![Moments::default(); 16 * 12]));
    for seed in 0..12 {
        let mut tracing = begin(&ready.world, &plan, 1, [16, 12], seed);
        for (passes, pixels) in &mut spread {
            tracing.step(*passes - tracing.films().passes);
            let films = &tracing.films().films;
            let value = |pixel: usize| {
                films.iter().flat_map(|(_, f, _)| (0..f.planes.len()).map(move |p| f.mean(pixel, p).value)).sum::<f64>()
            };
            pixels.iter_mut().enumerate().for_each(|(pixel, moments)| moments.add(value(pixel)));
        }
    }
    let [few, many] = spread.map(|(_, pixels)| pixels.iter().map(Moments::variance).sum::<f64>());
    assert!(few > 40.0 * many, "{few} {many}: {}", few / many);
}

fn by_brute_force(ready: &Ready<'_>, passes: u64) -> References {
    let choice = Choice::Only(Estimator::Backward);
    let source = Source::Traced { choice, passes: Some(passes), seconds: 1e9 };
    references(ready, &source, 1, &|| false).unwrap().0
}

/// At least nine in ten.
fn assert_honest(runs: &[Run]) {
    let honest = runs.iter().filter(|run| run.is_honest()).count();
    assert!(10 * honest >= 9 * runs.len(), "{honest} of {}: {runs:?}", runs.len());
}

/// The pilot knows nothing of how the lamps' light gets to the eye: no train and no guide. What little finds its way is
/// noise, and the error says so.
#[test]
fn what_the_pilot_missed_is_in_the_stated_error() {
    let mut scene = generate::scene(0);
    scene.eye.resolution = [12, 9];
    let ready = Ready::new(&scene, 0.0).unwrap();
    let mut plan = plan(&ready.checked, &ready.world, Choice::Only(Estimator::Manifold));
    assert!(!plan.connections.is_empty());
    plan.connections.clear();
    plan.forward_guide = None;
    plan.forward_paths = 1 << 12;
    let references = by_brute_force(&ready, 2000);
    let limits = Limits { passes: Some(16), time: None, error: Some(0.3), ..Limits::default() };
    let runs: Vec<_> = runs(&ready, &plan, &references, 0..40, &limits, &|| false).collect();
    assert!(runs.iter().all(|run| run.stated.is_some_and(|stated| stated > 0.05)), "{runs:?}");
    assert_honest(&runs);
}

/// One lamp behind a pane, and one that is seen in a mirror which its light hardly ever hits on the way to the pupil.
fn mirrored() -> Scene {
    let mut scene = kit::scene(20.0, 1);
    scene.eye.resolution = [32, 24];
    scene.eye.pupil_diameter_m = 3e-3;
    let group = kit::group(&mut scene, "led");
    let mut lamp = |centre: DVec3, a: DVec3, b: DVec3, luminance: f64| {
        let faces = vec![kit::shining(group, luminance)];
        kit::add(&mut scene, kit::mesh(&[kit::quad(centre, a, b)]), DAffine3::IDENTITY, None, faces);
    };
    lamp(DVec3::new(-0.05, 0.0, -0.6), DVec3::X * 0.02, DVec3::Y * 0.02, 1e3);
    // Beside the eye, seen in the mirror at (0.06, 0, −0.6), which is tilted by half the angle to it.
    let (mirror, place) = (DVec3::new(0.06, 0.0, -0.6), DVec3::new(0.4, 0.0, -0.3));
    let towards = (mirror - place).normalize();
    let side = towards.cross(DVec3::Y).normalize();
    lamp(place, DVec3::Y * 0.01, side * 0.01, 2e4);
    let normal = ((place - mirror).normalize() - mirror.normalize()).normalize();
    let side = DVec3::Y.cross(normal).normalize();
    let quad = kit::quad(mirror, side * 0.012, DVec3::Y * 0.012);
    let face = kit::face(Finish::MirrorIdeal { reflectance: 0.9 });
    kit::add(&mut scene, kit::mesh(&[quad]), DAffine3::IDENTITY, None, vec![face]);
    let mut faces: Vec<_> = (0..6).map(|_| kit::face(Finish::Absorber)).collect();
    (faces[4], faces[5]) = (kit::face(Finish::Polished), kit::face(Finish::Polished));
    let pane = DAffine3::from_translation(DVec3::new(-0.05, 0.0, -0.5));
    kit::add(&mut scene, kit::mesh(&kit::cuboid(DVec3::new(0.04, 0.04, 5e-4))), pane, Some(1.5), faces);
    scene
}

/// Of the lamps' paths some millionths come to the pupil, too few for a pilot; most of the picture's light comes by the
/// mirror. Rays from the eye show the pilot both trains.
#[test]
fn a_mirror_in_plain_sight_is_not_missed() {
    let scene = mirrored();
    let ready = Ready::new(&scene, 0.0).unwrap();
    let plan = plan(&ready.checked, &ready.world, Choice::Only(Estimator::Manifold));
    let back = |connection: &&eyebox_film::specular_chain::Connection| {
        connection.train.0.len() == 1 && connection.train.0[0].link.step == Step::Back
    };
    let share: f64 = plan.connections.iter().filter(back).map(|connection| connection.share).sum();
    assert!(share > 0.5, "{:?}", plan.connections);
}

/// In colour each pass bends light by a wavelength of its own: connection has nearly all of the light of its trains at each of
/// them, not at that of the first pass alone.
#[test]
fn connection_has_the_light_of_every_wavelength() {
    let mut scene = generate::scene(42);
    scene.wavelengths = eyebox_scene::Wavelengths::Visible;
    for medium in &mut scene.media {
        medium.index = eyebox_scene::Dispersion::Abbe { n_d: medium.index.index(587.6).re, v_d: 40.0 };
    }
    let ready = Ready::new(&scene, 0.0).unwrap();
    let plan = plan(&ready.checked, &ready.world, Choice::Only(Estimator::Manifold));
    assert!(matches!(plan.mode.spectral, eyebox_film::plan::Spectral::Hero), "lenses disperse");
    let mut tracing = eyebox_estimate::run::begin(&ready.world, &plan, 1, scene.eye.resolution, 3);
    tracing.step(32);
    let films = tracing.films();
    let blue = |of: &dyn Fn(Estimator) -> bool| -> f64 {
        let own = films.films.iter().filter(|(estimator, ..)| of(*estimator));
        let sum = |film: &eyebox_film::accumulate::Film| -> f64 {
            let planes = || 0..film.planes.len();
            let pixel =
                |at| planes().map(|p| film.mean_entries(at, p).nth(2).map_or(0.0, |light| light.value)).sum::<f64>();
            (0..film.width * film.height).map(pixel).sum()
        };
        own.map(|(_, film, _)| sum(film)).sum()
    };
    let (all, connected) = (blue(&|_| true), blue(&|estimator| estimator == Estimator::Manifold));
    assert!(connected > 0.9 * all, "connection has {connected} of {all} of the blue light");
}
