//! The energy balance finds what is planted in the walk: a face that loses light, and fates that nobody counts.

use super::ledger::Ledger;
use super::run::{Films, Limits, run};
use eyebox_base::ids::GroupId;
use eyebox_base::path::Class;
use eyebox_film::plan::{Estimator, PathMode, Plan, Radii, Row, Verdict};
use eyebox_scene::{Absorption, Dispersion, Finish, Group, Medium, Scene, Sky};
use eyebox_world::geometry::scenes;
use eyebox_world::{Planted, World};
use glam::{DAffine3, DMat3, DVec3};
use std::sync::Arc;

const BALL: u32 = 0;
const SCREEN: u32 = 1;

/// A ball of glass before a large eye.
fn ball() -> Scene {
    let mm = DAffine3::from_scale(DVec3::splat(1e-3));
    let centre = DVec3::Z * 100.0;
    let mesh = scenes::sphere(10.0, 24, 48, centre);
    let mut scene = scenes::scene(vec![mesh], vec![scenes::part(0, &[scenes::sphere_shape(10.0, centre)], mm)]);
    scene.eye.pupil_diameter_m = 0.05;
    scene.eye.focus_distance_m = 0.1;
    scene.eye.resolution = [4, 4];
    scene.groups = vec![Group { name: "light".to_owned() }];
    scene
}

/// The ball, a screen behind it and a lamp behind the screen's edge; the glass absorbs a little.
fn lit() -> Scene {
    let mut scene = ball();
    scene.media[0] =
        Medium { name: "tint".to_owned(), index: Dispersion::Constant(1.5), absorption: Absorption::Constant(5.0) };
    let place = scene.parts[0].to_world;
    let half_matt = Finish::Lambert { reflectance: 0.5, transmittance: 0.4 };
    scenes::add_square(&mut scene, (15.0, 115.0, DVec3::NEG_Z), half_matt, place);
    scenes::add_square(&mut scene, (8.0, 140.0, DVec3::NEG_Z), Finish::Absorber, place);
    scene.parts[2].faces[0].emitter = Some(scenes::emitter());
    scene
}

fn trace(scene: &Scene, planted: Planted, estimator: Estimator, passes: u64) -> Films {
    let mut world = World::freeze(scene).expect("it can be traced");
    world.planted = planted;
    let own = Verdict::Own { owner: estimator, because: "test".to_owned() };
    let row = |class| Row { group: GroupId(0), class, verdict: own.clone() };
    let plan = Plan {
        forward_paths: 4096,
        photons: 4096,
        photon_radii_m: Radii { caustic: 1e-3, secondary: 1e-3 },
        ..Plan::of(Class::ALL.map(row).to_vec(), PathMode::default())
    };
    let limits = Limits { passes: Some(passes), ..Limits::default() };
    run(&world, &plan, 1, scene.eye.resolution, 7, &limits, &mut ()).films
}

/// emitted = Σ fates within 3σ with σ ≤ 1e-4.
fn balances(ledger: &Ledger) -> bool {
    let sigma = ledger.imbalance_sigma();
    assert!(ledger.paths > 1000 && ledger.emitted > 0.0 && ledger.invalid_paths == 0, "{ledger:?}");
    sigma <= 1e-4 * ledger.emitted && ledger.imbalance().abs() <= 3.0 * sigma.max(1e-12 * ledger.emitted)
}

/// R + T + A = 1 at every specular vertex, the three computed apart.
fn vertices_close(ledger: &Ledger) -> bool {
    ledger.vertex_error <= 1e-12
}

#[test]
fn a_leaky_face_or_an_uncounted_fate_turns_the_balance_red() {
    let scene = lit();
    // Specular connection takes the same vertex step, and starts no paths without a train.
    for estimator in [Estimator::Backward, Estimator::Forward, Estimator::Photon] {
        let verdict = |planted| {
            let films = trace(&scene, planted, estimator, 512);
            let ledger = films.ledger(estimator).expect("it ran").clone();
            println!(
                "{estimator:?} {planted:?}: {:+.2e} of all, vertex {:.1e}",
                ledger.imbalance() / ledger.emitted,
                ledger.vertex_error
            );
            (balances(&ledger), vertices_close(&ledger))
        };
        assert_eq!(verdict(Planted::Nothing), (true, true), "{estimator:?}: nothing is planted");
        assert_eq!(verdict(Planted::Leak { part: BALL }), (false, false), "{estimator:?}: a leaky face");
        for planted in [Planted::Unbooked { part: BALL }, Planted::Unbooked { part: SCREEN }, Planted::UnbookedEscape] {
            assert_eq!(verdict(planted), (false, true), "{estimator:?}: {planted:?}");
        }
    }
}

#[test]
fn a_leaky_face_is_seen_in_a_furnace() {
    let mut scene = ball();
    let luminance = Arc::new(vec![500f32; 64 * 32]);
    let sky = Sky {
        group: GroupId(0),
        width: 64,
        height: 32,
        luminance,
        rgb: None,
        to_world: DMat3::IDENTITY,
        file: "furnace".into(),
    };
    scene.sky = Some(sky);
    let mean_of = |planted| {
        let films = trace(&scene, planted, Estimator::Backward, 256);
        let (_, film, _) = &films.films[0];
        let pixels = film.width * film.height;
        let mean: f64 = (0..pixels).map(|pixel| film.mean(pixel, 0).value).sum::<f64>() / pixels as f64;
        let variance: f64 = (0..pixels).map(|pixel| film.variance(pixel, film.planes.len())).sum();
        (mean, variance.sqrt() / pixels as f64)
    };
    let near = |(mean, sigma): (f64, f64)| (mean - 500.0).abs() <= 4.0 * sigma + 1e-9 && sigma < 0.1;
    let (sound, leaky) = (mean_of(Planted::Nothing), mean_of(Planted::Leak { part: BALL }));
    println!("sound {sound:?}, leaky {leaky:?}");
    assert!(near(sound), "{sound:?}");
    // Every ray that meets the ball loses at least a hundredth, most lose it twice.
    assert!(!near(leaky) && leaky.0 < 495.0, "{leaky:?}");
}
