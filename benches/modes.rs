//! What a path costs in each spectral mode, without and with polarisation: ratios to `mono`, for each estimator on the
//! direct HUD in colour, one thread, measured in turn. Run with `cargo bench --ignore-rust-version --bench modes`.
//!
//! `cargo bench … --bench modes -- count MODE ESTIMATOR` traces once and prints nothing else, for a program that counts
//! instructions (`valgrind --tool=callgrind`); benches/modes.md has the figures.

use eyebox::check::check;
use eyebox::estimate::run::{Limits, run};
use eyebox::film::plan::{Estimator, Plan, Spectral};
use eyebox::import::{ImportOptions, import};
use eyebox::plan::{Choice, plan};
use eyebox::scene::{Scene, Wavelengths};
use eyebox::world::World;
use std::path::Path;
use std::time::Instant;

const MODES: [(&str, Spectral, bool); 6] = [
    ("mono", Spectral::Mono, false),
    ("mono + stokes", Spectral::Mono, true),
    ("rgb", Spectral::Rgb, false),
    ("rgb + stokes", Spectral::Rgb, true),
    ("hero", Spectral::Hero, false),
    ("hero + stokes", Spectral::Hero, true),
];

/// Microseconds of wall clock per path.
fn trace(scene: &Scene, world: &World, plan: &Plan, passes: u64, seed: u64) -> f64 {
    let limits = Limits { passes: Some(passes), ..Limits::default() };
    let (groups, size) = (scene.groups.len(), scene.eye.resolution);
    let start = Instant::now();
    let outcome = run(world, plan, groups, size, seed, &limits, &mut ());
    let paths: u64 = outcome.films.films.iter().map(|(_, _, ledger)| ledger.paths).sum();
    start.elapsed().as_secs_f64() * 1e6 / paths as f64
}

fn main() {
    let asked: Vec<String> = std::env::args().skip_while(|argument| argument != "count").skip(1).collect();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool of one thread");
    pool.install(|| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples/hud-direct/hud.optics.toml");
        let mut scene = import(&path, &ImportOptions::default()).expect("the sample imports").scene;
        scene.eye.resolution = [60, 30];
        scene.wavelengths = Wavelengths::Visible;
        let checked = check(&scene).expect("the sample is sound");
        let world = World::freeze(&scene).expect("the sample can be traced");
        for estimator in Estimator::ALL {
            if asked.get(1).is_some_and(|name| name != estimator.name()) {
                continue;
            }
            let plan = plan(&checked, &world, Choice::Only(estimator));
            let plans: Vec<(&str, Plan)> = MODES
                .into_iter()
                .filter(|(name, _, _)| asked.first().is_none_or(|asked| asked == name))
                .map(|(name, spectral, polarised)| {
                    let mut plan = plan.clone();
                    (plan.mode.spectral, plan.mode.polarised) = (spectral, polarised);
                    (name, plan)
                })
                .collect();
            if !asked.is_empty() {
                for (_, plan) in &plans {
                    trace(&scene, &world, plan, 2, 0);
                }
                continue;
            }
            let mut best = vec![f64::INFINITY; plans.len()];
            for round in 0..5 {
                for ((_, plan), best) in plans.iter().zip(&mut best) {
                    *best = best.min(trace(&scene, &world, plan, 2, round));
                }
            }
            for ((name, _), micros) in plans.iter().zip(&best) {
                println!("{:8} {name:13} {micros:6.2} µs a path, {:.2} × mono", estimator.name(), micros / best[0]);
            }
        }
    });
}
