//! What guiding and even points gain: the direct HUD's forward estimator plain (lamps by flux, directions by intensity,
//! random numbers), guided, and guided with even points; time to a relative squared error of 1e-2 over the flat white
//! pixels, and the share of useful paths. Then the photons that the diffuse HUD needs. One thread, processor seconds.
//! Run with `cargo bench --ignore-rust-version --bench guided`.

use eyebox::base::ids::GroupId;
use eyebox::check::check;
use eyebox::estimate::emission::Starts;
use eyebox::estimate::forward::Forward;
use eyebox::estimate::manifold::receiver::Receivers;
use eyebox::estimate::ownership::Ownership;
use eyebox::estimate::photon::PhotonMapper;
use eyebox::film::accumulate::{Components, Film, Sampling};
use eyebox::film::guide::Guide;
use eyebox::film::plan::{Estimator, Plan};
use eyebox::import::{ImportOptions, import};
use eyebox::plan::pilots::pupil::survey;
use eyebox::plan::{Asked, Choice, plan};
use eyebox::scene::Scene;
use eyebox::world::World;
use eyebox::world::mode::{Mode, Mono};
use std::path::Path;
use std::sync::Arc;

/// Processor seconds of this thread.
fn seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    stat.split(' ').next().and_then(|ns| ns.parse::<f64>().ok()).unwrap_or(0.0) * 1e-9
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = seconds();
    let done = work();
    (done, seconds() - start)
}

/// A sample without its sky.
fn hud(name: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("samples/hud-{name}/hud.optics.toml"));
    let mut scene = import(&path, &ImportOptions::default()).expect("the sample imports").scene;
    scene.eye.resolution = [360, 180];
    let Some(sky) = scene.sky.take() else { return scene };
    let gone = sky.group.index();
    scene.groups.remove(gone);
    for emitter in scene.parts.iter_mut().flat_map(|part| &mut part.faces).filter_map(|face| face.emitter.as_mut()) {
        let index = emitter.group.index();
        emitter.group = GroupId::from_index(index - usize::from(index > gone));
    }
    scene
}

/// Pixels whose surroundings are bright and alike in `film`.
fn flat_white(film: &Film) -> Vec<usize> {
    let (width, height) = (film.width, film.height);
    let value = |pixel: usize| (0..film.planes.len()).map(|plane| film.mean(pixel, plane).value).sum::<f64>();
    let mut sorted: Vec<f64> = (0..width * height).map(value).collect();
    sorted.sort_by(f64::total_cmp);
    let white = sorted[sorted.len() * 99 / 100];
    let around = |pixel: usize| {
        let (x, y) = (pixel % width, pixel / width);
        let inside = (1..width - 1).contains(&x) && (1..height - 1).contains(&y);
        inside && (0..9).all(|k| value((y + k / 3 - 1) * width + x + k % 3 - 1) > 0.6 * white)
    };
    (0..width * height).filter(|pixel| around(*pixel)).collect()
}

/// Relative squared error of one of two independent films, from their differences.
fn rel_mse(a: &Film, b: &Film, pixels: &[usize]) -> f64 {
    let value =
        |film: &Film, pixel: usize| (0..film.planes.len()).map(|plane| film.mean(pixel, plane).value).sum::<f64>();
    let mean = pixels.iter().map(|p| value(a, *p) + value(b, *p)).sum::<f64>() / 2.0 / pixels.len() as f64;
    let squares = pixels.iter().map(|p| (value(a, *p) - value(b, *p)).powi(2)).sum::<f64>();
    squares / 2.0 / pixels.len() as f64 / (mean * mean)
}

#[allow(clippy::too_many_arguments)] // what a film is made of
fn forward_film(
    world: &World,
    plan: &Plan,
    scene: &Scene,
    guide: Option<&Guide>,
    starts: Starts,
    paths: u64,
    passes: u64,
    seed: u64,
) -> Film {
    let groups = scene.groups.len();
    let route = Ownership::new(plan, groups, Estimator::Forward);
    let [width, height] = scene.eye.resolution;
    let mut film =
        Film::new(width, height, route.planes.clone(), Components::Luminance, Sampling::PerScramble { paths });
    let forward = Forward::<Mono>::new(world, route, groups, paths, guide, Arc::default(), seed).starting(starts);
    forward.run(&mut film, 0, passes);
    film
}

fn useful(world: &World, plan: &Plan, scene: &Scene, guide: Option<&Guide>) -> f64 {
    let groups = scene.groups.len();
    let paths = 1 << 15;
    let forward = Forward::<Mono>::new(
        world,
        Ownership::new(plan, groups, Estimator::Forward),
        groups,
        paths,
        guide,
        Arc::default(),
        77,
    );
    forward.probe(0, &|| false).len() as f64 / paths as f64
}

fn direct() {
    let scene = hud("direct");
    let checked = check(&scene).expect("the sample is sound");
    let world = World::freeze(&scene).expect("the sample can be traced");
    let asked = Asked::from(Choice::Only(Estimator::Forward));
    let (plan, planning) = timed(|| plan(&checked, &world, asked));
    let (_, surveying) = timed(|| survey(&checked, &world, asked, &plan, &|| false));
    let guide = plan.forward_guide.as_ref();
    println!(
        "direct: plan {planning:.3} s, survey of the pupil {surveying:.3} s, {} boxes",
        guide.map_or(0, Guide::leaves)
    );
    println!("  JSON of the guide: {} bytes", serde_json::to_string(&guide).map_or(0, |text| text.len()));
    let reference = forward_film(&world, &plan, &scene, guide, Starts::Scrambles, 1 << 18, 8, 1000);
    let pixels = flat_white(&reference);
    println!("  {} flat white pixels", pixels.len());
    println!(
        "  useful paths: plain {:.4}, guided {:.4}",
        useful(&world, &plan, &scene, None),
        useful(&world, &plan, &scene, guide)
    );
    for (name, guide, starts, paths, passes) in [
        ("plain", None, Starts::Random, 1 << 20, 3),
        ("guided", guide, Starts::Random, 1 << 18, 2),
        ("guided + even", guide, Starts::Scrambles, 1 << 18, 2),
        ("guided + even", guide, Starts::Scrambles, 1 << 18, 8),
    ] {
        let (a, one) = timed(|| forward_film(&world, &plan, &scene, guide, starts, paths, passes, 1));
        let (b, two) = timed(|| forward_film(&world, &plan, &scene, guide, starts, paths, passes, 2));
        let seconds = 0.5 * (one + two);
        let error = rel_mse(&a, &b, &pixels);
        let stated = pixels.iter().map(|p| a.variance(*p, a.planes.len())).sum::<f64>() / pixels.len() as f64;
        let mean = pixels.iter().map(|p| a.mean(*p, 0).value).sum::<f64>() / pixels.len() as f64;
        println!(
            "  {name:14} {:>9} paths {seconds:7.3} s ({:5.2} µs each)  relMSE {error:.3e} (stated {:.3e})  1e-2 at about {:8.3} s",
            paths * passes,
            seconds / (paths * passes) as f64 * 1e6,
            stated / mean / mean,
            seconds * error / 1e-2
        );
    }
}

fn photon_film(
    world: &World,
    plan: &Plan,
    scene: &Scene,
    guide: Option<&Guide>,
    starts: Starts,
    photons: u64,
    seed: u64,
) -> Film {
    let groups = scene.groups.len();
    let route = Ownership::new(plan, groups, Estimator::Photon);
    let [width, height] = scene.eye.resolution;
    let mut film = Film::new(width, height, route.planes.clone(), Components::Luminance, Sampling::PerPass);
    let screens = Arc::new(Receivers::new(world, &Mono::<f64>::optics(world, seed, 0), &[]));
    PhotonMapper::<Mono>::new(world, route, groups, photons, guide, plan.photon_radii_m, screens, seed)
        .starting(starts)
        .run(&mut film, 0, 1);
    film
}

fn diffuse() {
    let scene = hud("diffuse");
    let checked = check(&scene).expect("the sample is sound");
    let world = World::freeze(&scene).expect("the sample can be traced");
    let asked = Asked::from(Choice::Only(Estimator::Photon));
    let (plan, planning) = timed(|| plan(&checked, &world, asked));
    let guide = plan.photon_guide.as_ref();
    println!("diffuse: plan {planning:.3} s, {} boxes", guide.map_or(0, Guide::leaves));
    let reference = photon_film(&world, &plan, &scene, guide, Starts::OfPass, 1 << 19, 1000);
    let pixels = flat_white(&reference);
    println!("  {} flat white pixels", pixels.len());
    for (name, guide, starts, photons) in [
        ("plain", None, Starts::Random, 1 << 21),
        ("guided", guide, Starts::Random, 1 << 18),
        ("guided + even", guide, Starts::OfPass, 1 << 18),
    ] {
        let (a, one) = timed(|| photon_film(&world, &plan, &scene, guide, starts, photons, 1));
        let (b, two) = timed(|| photon_film(&world, &plan, &scene, guide, starts, photons, 2));
        let error = rel_mse(&a, &b, &pixels);
        println!(
            "  {name:14} {photons:>9} photons {:7.3} s  relMSE {error:.3e}  1e-2 with about {:.3e} photons",
            0.5 * (one + two),
            photons as f64 * error / 1e-2
        );
    }
}

fn main() {
    let asked: Vec<String> = std::env::args().skip(1).collect();
    let wants = |name: &str| !asked.iter().any(|a| a == "direct" || a == "diffuse") || asked.iter().any(|a| a == name);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool of one thread");
    pool.install(|| {
        if wants("direct") {
            direct();
        }
        if wants("diffuse") {
            diffuse();
        }
    });
}
