//! Maps of lit faces: finer ones come when passes have paid for them, and bring the same light.

use super::curve::race::Ready;
use super::generate;
use eyebox_estimate::manifold::receiver::Receivers;
use eyebox_estimate::manifold::seeds::bands::Bands;
use eyebox_estimate::manifold::vision::Manifold;
use eyebox_estimate::ownership::Ownership;
use eyebox_estimate::run::{Films, Start, begin};
use eyebox_film::accumulate::{Film, Sampling};
use eyebox_film::plan::Estimator;
use eyebox_plan::{Choice, plan};
use eyebox_world::mode::{Mode, Mono, components};
use std::sync::Arc;

/// A diffuser before 26 LEDs.
const SEED: u64 = 92;

/// A pass over finer maps has the light of the same pass over the first ones, to what a map may err, for less work; pixel by
/// pixel, since both take the same points. At the rim of what is lit coarse maps leave some to photons.
#[test]
fn finer_maps_bring_the_same_light_for_less_work() {
    let mut scene = generate::scene(SEED);
    scene.eye.resolution = [32, 24];
    let ready = Ready::new(&scene, 0.0).unwrap();
    let plan = plan(&ready.checked, &ready.world, Choice::Auto);
    let world = &ready.world;
    let optics = Mono::<f64>::optics(world, 0, 0);
    let first = Arc::new(Receivers::new(world, &optics, &plan.screens));
    let change = first.next_change(0);
    assert!((1..32).contains(&change), "{change}");
    assert!(Arc::ptr_eq(&first, &first.of_pass(change - 1, world, &optics)));
    let run = |screens: Arc<Receivers<Mono>>| {
        let route = Ownership::new(&plan, ready.checked.scene().groups.len(), Estimator::Manifold);
        let mut film = Film::new(32, 24, route.planes.clone(), components::<Mono>(), Sampling::PerPass);
        let none = Arc::new(Bands::default());
        let ledger = Manifold::new(world, route, (none, None), (screens, None), 1).run(&mut film, 0, 1);
        let light: Vec<f64> = (0..32 * 24).map(|pixel| film.mean(pixel, 0).value).collect();
        (light, ledger.work)
    };
    let finest = first.of_pass(u64::MAX, world, &optics);
    let ((rough, work), (fine, less)) = (run(first), run(finest));
    assert!(5 * less < 4 * work, "{less} {work}");
    let mean = rough.iter().sum::<f64>() / rough.len() as f64;
    let far: Vec<_> =
        rough.iter().zip(&fine).enumerate().filter(|(_, (a, b))| (*a - *b).abs() > 3e-3 * mean.max(a.abs())).collect();
    assert!(far.len() * 50 < rough.len(), "{far:?}");
    let total = fine.iter().sum::<f64>() / rough.iter().sum::<f64>();
    assert!((total - 1.0).abs() < 1e-3, "{total}");
}

/// The maps of a pass are a function of its number: a run in pieces is the run in one.
#[test]
fn pieces_of_a_run_have_the_maps_of_the_whole() {
    let mut scene = generate::scene(SEED);
    scene.eye.resolution = [32, 24];
    let ready = Ready::new(&scene, 0.0).unwrap();
    let mut plan = plan(&ready.checked, &ready.world, Choice::Auto);
    let optics = Mono::<f64>::optics(&ready.world, 0, 0);
    // The map of the brightest train.
    plan.screens.truncate(1);
    let screens = Receivers::<Mono>::new(&ready.world, &optics, &plan.screens);
    let (change, groups) = (screens.next_change(0), ready.checked.scene().groups.len());
    assert!((1..u64::MAX).contains(&change), "{change}");
    let run = |start: Start, passes: &[u64]| {
        let mut tracing = begin(&ready.world, &plan, groups, [32, 24], 1);
        assert!(tracing.start(start));
        passes.iter().for_each(|count| tracing.step(*count));
        tracing.into_films()
    };
    let values = |films: &Films| -> Vec<u64> {
        let of = |film: &Film| (0..32 * 24).map(|pixel| film.mean(pixel, 0).value.to_bits()).collect::<Vec<_>>();
        films.films.iter().flat_map(|(_, film, _)| of(film)).collect()
    };
    let whole = values(&run(Start::Pass(0), &[change + 2]));
    let pieces = run(Start::Pass(0), &[change - 1, 3]);
    assert_eq!(whole, values(&pieces));
    let late = run(Start::Films(Box::new(run(Start::Pass(0), &[change]))), &[2]);
    assert_eq!(whole, values(&late));
}
