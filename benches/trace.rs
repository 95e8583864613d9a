//! What a path costs: microseconds of wall clock per path for each estimator on the two sample HUDs, one thread, measured
//! in turn so that a busy machine slows all alike. Run with `cargo bench --ignore-rust-version`.

use eyebox::check::check;
use eyebox::estimate::run::{Limits, run};
use eyebox::film::plan::Estimator;
use eyebox::import::{ImportOptions, import};
use eyebox::plan::{Choice, plan};
use eyebox::world::World;
use std::path::Path;
use std::time::Instant;

fn main() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool of one thread");
    pool.install(|| {
        for sample in ["hud-direct", "hud-diffuse"] {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples").join(sample).join("hud.optics.toml");
            let mut scene = import(&path, &ImportOptions::default()).expect("the sample imports").scene;
            scene.eye.resolution = [90, 45];
            let checked = check(&scene).expect("the sample is sound");
            let start = Instant::now();
            let world = World::freeze(&scene).expect("the sample can be traced");
            println!("{sample}: freeze {:.0} ms", start.elapsed().as_secs_f64() * 1e3);
            let plans: Vec<_> =
                Estimator::ALL.map(|estimator| (estimator, plan(&checked, &world, Choice::Only(estimator)))).into();
            let mut best = vec![f64::INFINITY; plans.len()];
            for round in 0..3 {
                for ((_, plan), best) in plans.iter().zip(&mut best) {
                    let limits = Limits { passes: Some(2), ..Limits::default() };
                    let (groups, size) = (scene.groups.len(), scene.eye.resolution);
                    let start = Instant::now();
                    let outcome = run(&world, plan, groups, size, round, &limits, &mut ());
                    let paths: u64 = outcome.films.films.iter().map(|(_, _, ledger)| ledger.paths).sum();
                    *best = best.min(start.elapsed().as_secs_f64() * 1e6 / paths as f64);
                }
            }
            for ((estimator, _), micros) in plans.iter().zip(&best) {
                println!("  {:8} {micros:6.2} µs a path, {:.2} × backward", estimator.name(), micros / best[0]);
            }
        }
    });
}
