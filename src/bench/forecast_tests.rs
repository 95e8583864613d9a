//! What a plan foretells of a run against the run.

use super::curve::race::Ready;
use super::generate;
use eyebox_estimate::run::begin;
use eyebox_plan::forecast::forecast;
use eyebox_plan::{Choice, plan};

/// Passes that a run makes until it states 1 %, to a twelfth.
fn passes_to_one_percent(ready: &Ready<'_>) -> f64 {
    let plan = plan(&ready.checked, &ready.world, Choice::Auto);
    let scene = ready.checked.scene();
    let mut tracing = begin(&ready.world, &plan, scene.groups.len(), scene.eye.resolution, 1);
    tracing.step(12);
    while tracing.films().relative_error().unwrap() > 0.01 {
        tracing.step(tracing.films().passes / 12);
    }
    tracing.films().passes as f64
}

/// Even points, photons and connections; and a picture larger than the pilot's, whose pixels hold less of an edge each: from the
/// pilot's own pixels and six passes alone it would be foretold at several times as many.
#[test]
fn forecasts_come_true_within_a_factor_of_two() {
    for (seed, size) in [(1, [32, 24]), (5, [32, 24]), (3, [32, 24]), (1, [144, 108])] {
        let mut scene = generate::scene(seed);
        scene.eye.resolution = size;
        let ready = Ready::new(&scene, 0.0).unwrap();
        let plan = plan(&ready.checked, &ready.world, Choice::Auto);
        let foretold = forecast(&scene, &ready.world, &plan).unwrap().passes.unwrap();
        let real = passes_to_one_percent(&ready);
        eprintln!("seed {seed}, {size:?}: {foretold} foretold, {real} made");
        assert!((0.5..=2.0).contains(&(foretold / real)), "seed {seed}, {size:?}: {foretold} foretold, {real} made");
    }
}
