//! Guided emission and even points on the direct HUD: nothing is biased, much is gained, and the error that is stated is
//! the scatter of seeds.

use super::kit::*;
use eyebox::base::path::Class;
use eyebox::base::stats::Moments;
use eyebox::estimate::emission::Starts;
use eyebox::estimate::forward::Forward;
use eyebox::estimate::manifold::receiver::Receivers;
use eyebox::estimate::ownership::Ownership;
use eyebox::estimate::photon::PhotonMapper;
use eyebox::film::accumulate::{Components, Film, Sampling};
use eyebox::film::guide::{Guide, Sample};
use eyebox::film::plan::Estimator;
use eyebox::plan::Choice;
use eyebox::scene::Scene;
use eyebox::world::mode::{Mode, Mono};
use std::sync::Arc;

const FORWARD: Choice = Choice::Only(Estimator::Forward);

fn small() -> Scene {
    gaze(hud("direct", &[]), [0.0; 2], 13.0, [24, 12])
}

struct Tracer<'s> {
    ready: Ready<'s>,
}

impl Tracer<'_> {
    fn forward(&self, guide: Option<&Guide>, starts: Starts, paths: u64, seed: u64) -> Forward<'_, Mono> {
        let groups = self.ready.scene.groups.len();
        let route = Ownership::new(&self.ready.plan, groups, Estimator::Forward);
        Forward::new(&self.ready.world, route, groups, paths, guide, Arc::default(), seed).starting(starts)
    }

    fn film(&self, paths: u64) -> Film {
        let [width, height] = self.ready.scene.eye.resolution;
        let route = Ownership::new(&self.ready.plan, self.ready.scene.groups.len(), Estimator::Forward);
        Film::new(width, height, route.planes, Components::Luminance, Sampling::PerScramble { paths })
    }

    fn trace(&self, guide: Option<&Guide>, starts: Starts, paths: u64, passes: u64, seed: u64) -> Film {
        let mut film = self.film(paths);
        self.forward(guide, starts, paths, seed).run(&mut film, 0, passes);
        film
    }

    fn guide(&self) -> Option<&Guide> {
        self.ready.plan.forward_guide.as_ref()
    }
}

/// Mean over pixels, and the mean variance of a pixel.
fn of_film(film: &Film) -> (f64, f64) {
    let pixels = film.width * film.height;
    let mean =
        (0..pixels).map(|pixel| (0..film.planes.len()).map(|p| film.mean(pixel, p).value).sum::<f64>()).sum::<f64>();
    let variance = (0..pixels).map(|pixel| film.variance(pixel, film.planes.len())).sum::<f64>();
    (mean / pixels as f64, variance / pixels as f64)
}

/// Eight of ten paths arrive in the picture, the mean is that of plain tracing, and each path is worth 60 plain ones even
/// before any evenness of points counts.
#[test]
fn guided_paths_arrive_and_bias_nothing() {
    let scene = small();
    let tracer = Tracer { ready: Ready::new(&scene, FORWARD) };
    let paths = 1 << 15;
    let useful =
        |guide| tracer.forward(guide, Starts::Scrambles, paths, 5).probe(0, &|| false).len() as f64 / paths as f64;
    let [plain, guided] = [useful(None), useful(tracer.guide())];
    eprintln!("useful: plain {plain:.4}, guided {guided:.4}");
    // 2 % of the paths start on lamps by flux and 3 % or a little more anywhere on each, lest what the pilot missed is never found.
    assert!(guided > 0.8, "{guided}");
    // Pixels are alike, so the relative error of the picture's mean can be taken over runs.
    let mut runs = [Moments::default(); 2];
    let (mut of_plain, mut of_guided) = (0.0, 0.0);
    for seed in 0..16 {
        let plain = of_film(&tracer.trace(None, Starts::Random, 1 << 16, 1, seed));
        let guided = of_film(&tracer.trace(tracer.guide(), Starts::Scrambles, 1 << 12, 1, seed));
        runs[0].add(plain.0);
        runs[1].add(guided.0);
        of_plain += plain.1 * 16.0;
        of_guided += guided.1;
    }
    let [plain, guided] = runs;
    eprintln!("plain {} ± {}, guided {} ± {}", plain.mean, plain.stderr(), guided.mean, guided.stderr());
    eprintln!("a guided path is worth {:.1} plain ones", of_plain / of_guided);
    assert!((plain.mean - guided.mean).abs() < 4.0 * plain.stderr().hypot(guided.stderr()));
    assert!(guided.stderr() < 0.01 * guided.mean);
    assert!(of_plain > 60.0 * of_guided, "{}", of_plain / of_guided);
}

/// Few even paths cost little noise: of the second moment of what a path brings (its relative variance and one) little comes
/// from paths that bring more than 20 times the mean.
#[test]
fn what_the_pilot_missed_is_little() {
    let scene = small();
    let tracer = Tracer { ready: Ready::new(&scene, FORWARD) };
    let paths = 1 << 17;
    let (mut sum, mut squares, mut brought) = (0.0, 0.0, Vec::new());
    for seed in 0..8 {
        let forward = tracer.forward(tracer.guide(), Starts::Random, paths, seed);
        let light = |sample: &Sample| sample.weight / forward.density(sample.lamp, &sample.x);
        brought.extend(forward.probe(0, &|| false).iter().map(light));
    }
    let all = (8 * paths) as f64;
    for light in &brought {
        sum += light / all;
        squares += light * light / all;
    }
    let rare = |light: &&f64| **light > 20.0 * sum;
    let bright = brought.iter().filter(rare).map(|light| light * light / all).sum::<f64>() / squares;
    let most = brought.iter().fold(0.0f64, |most, light| most.max(*light)) / sum;
    let second = squares / (sum * sum);
    eprintln!("second moment {second:.3}, of it {bright:.4} from bright paths, the brightest {most:.0} times the mean");
    assert!(second < 2.0, "{second}");
    assert!(bright < 0.2, "{bright}");
}

/// With a guide and even points a fifth of the photons does, at equal radii: the scatter of seeds is smaller, and the mean the
/// same.
#[test]
fn guided_photons_are_worth_five() {
    let scene = gaze(hud("diffuse", &[]), [0.0; 2], 8.0, [24, 12]);
    let ready = Ready::new(&scene, Choice::Only(Estimator::Photon));
    let (groups, pixels) = (ready.scene.groups.len(), 24 * 12);
    let trace = |guide: Option<&Guide>, starts: Starts, photons: u64, seed: u64| {
        let route = Ownership::new(&ready.plan, groups, Estimator::Photon);
        let mut film = Film::new(24, 12, route.planes.clone(), Components::Luminance, Sampling::PerPass);
        let screens = Arc::new(Receivers::new(&ready.world, &Mono::<f64>::optics(&ready.world, seed, 0), &[]));
        let radii = ready.plan.photon_radii_m;
        PhotonMapper::<Mono>::new(&ready.world, route, groups, photons, guide, radii, screens, seed)
            .starting(starts)
            .run(&mut film, 0, 1);
        film
    };
    let photons = 1 << 14;
    let mut values = [vec![Moments::default(); pixels], vec![Moments::default(); pixels]];
    let mut means = [Moments::default(); 2];
    for seed in 0..16 {
        let plain = trace(None, Starts::Random, 5 * photons, seed);
        let guided = trace(ready.plan.photon_guide.as_ref(), Starts::OfPass, photons, seed);
        for ((film, values), mean) in [plain, guided].iter().zip(&mut values).zip(&mut means) {
            values.iter_mut().enumerate().for_each(|(pixel, of)| of.add(film.mean(pixel, 0).value));
            mean.add(of_film(film).0);
        }
    }
    let [plain, guided] = values.map(|of| of.iter().map(Moments::variance).sum::<f64>());
    eprintln!("a guided photon is worth {:.1} plain ones", 5.0 * plain / guided);
    assert!(guided < plain, "{guided} {plain}");
    let [plain, guided] = means;
    eprintln!("plain {} ± {}, guided {} ± {}", plain.mean, plain.stderr(), guided.mean, guided.stderr());
    assert!((plain.mean - guided.mean).abs() < 4.0 * plain.stderr().hypot(guided.stderr()));
}

/// What connection leaves of the diffuse HUD's light, lens ghosts of some 1e-4, is the same by photons that part at lenses as by
/// photons that choose, and for the same work they scatter less.
#[test]
fn photons_that_part_find_ghosts() {
    let scene = gaze(hud("diffuse", &[]), [0.0; 2], 8.0, [24, 12]);
    let ready = Ready::new(&scene, Choice::Auto);
    assert!(ready.plan.photons_part, "little is left to photons");
    let groups = ready.scene.groups.len();
    let optics = Mono::<f64>::optics(&ready.world, 0, 0);
    let screens = Arc::new(Receivers::new(&ready.world, &optics, &ready.plan.screens));
    let trace = |part: bool, photons: u64, seed: u64| {
        let route = Ownership::new(&ready.plan, groups, Estimator::Photon);
        let mut film = Film::new(24, 12, route.planes.clone(), Components::Luminance, Sampling::PerPass);
        let (guide, radii) = (ready.plan.photon_guide.as_ref(), ready.plan.photon_radii_m);
        let mapper =
            PhotonMapper::<Mono>::new(&ready.world, route, groups, photons, guide, radii, screens.clone(), seed);
        let ledger = mapper.parting(part).starting(Starts::OfPass).run(&mut film, 0, 1);
        let open = |pixel: usize| (0..film.planes.len()).map(|plane| film.mean(pixel, plane).open()).sum::<f64>();
        ((0..24 * 12).map(open).sum::<f64>(), ledger.work as f64)
    };
    let (mut means, mut works) = ([Moments::default(); 2], [0.0; 2]);
    for seed in 0..24 {
        for (part, photons) in [(false, 1 << 14), (true, 1 << 10)] {
            let (light, work) = trace(part, photons, seed);
            means[usize::from(part)].add(light);
            works[usize::from(part)] += work;
        }
    }
    let [chosen, parted] = means;
    let gain = chosen.variance() * works[0] / (parted.variance() * works[1]);
    eprintln!("chosen {} ± {}, parted {} ± {}", chosen.mean, chosen.stderr(), parted.mean, parted.stderr());
    eprintln!("{gain:.0} times less variance × work");
    assert!((chosen.mean - parted.mean).abs() < 4.0 * chosen.stderr().hypot(parted.stderr()));
    assert!(parted.stderr() < 0.05 * parted.mean, "the test would see nothing");
    assert!(gain > 4.0, "{gain}");
}

/// The stated error is the scatter of seeds, where each pixel gets half a path of each scramble and where it gets many.
#[test]
fn the_error_of_even_points_is_the_scatter_of_seeds() {
    let scene = small();
    let tracer = Tracer { ready: Ready::new(&scene, FORWARD) };
    for (paths, passes, seeds) in [(1 << 10, 1, 48), (1 << 10, 3, 32), (1 << 13, 1, 24)] {
        let pixels = 24 * 12;
        let mut values = vec![Moments::default(); pixels];
        let mut stated = 0.0;
        for seed in 0..seeds {
            let film = tracer.trace(tracer.guide(), Starts::Scrambles, paths, passes, seed);
            stated += of_film(&film).1 * pixels as f64 / seeds as f64;
            values.iter_mut().enumerate().for_each(|(pixel, of)| of.add(film.mean(pixel, 0).value));
        }
        let seen: f64 = values.iter().map(Moments::variance).sum();
        let ratio = (stated / seen).sqrt();
        eprintln!("{paths} paths, {passes} passes: stated over seen σ {ratio:.3}");
        assert!((0.85..1.18).contains(&ratio), "{paths} × {passes}: {ratio}");
    }
}

/// The same bits for 1, 2 and 7 threads, and however the passes are cut into runs.
#[test]
fn even_points_are_a_function_of_pass_and_path() {
    let scene = small();
    let tracer = Tracer { ready: Ready::new(&scene, FORWARD) };
    let paths = (1 << 14) + 5;
    let once = tracer.trace(tracer.guide(), Starts::Scrambles, paths, 3, 9);
    for threads in [1, 2, 7] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let again = pool.install(|| {
            let forward = tracer.forward(tracer.guide(), Starts::Scrambles, paths, 9);
            let mut film = tracer.film(paths);
            forward.run(&mut film, 0, 1);
            forward.run(&mut film, 1, 2);
            film
        });
        assert!(again == once, "{threads} threads");
    }
}

/// Where a diffuser stands between the lamps and all that the eye sees unscattered, light tracing is given up after one
/// look. An eye beside the beam sees the combiner that the light goes on from: there a rare path might be found yet.
#[test]
fn light_tracing_is_given_up_early_only_where_nothing_is_shared() {
    let why = |scene: &Scene| {
        let ready = Ready::new(scene, Choice::Auto);
        let row = ready.plan.rows.iter().find(|row| row.class == Class::Vision).expect("every class has a row");
        format!("{:?}", row.verdict)
    };
    let beside = {
        let mut scene = small();
        scene.eye.position += 9e-3 * scene.eye.right();
        scene
    };
    let diffuse = gaze(hud("diffuse", &[]), [0.0; 2], 13.0, [24, 12]);
    for (scene, paths) in [(&diffuse, "none of 8192 pilot paths"), (&beside, "none of 65536 pilot paths")] {
        assert!(why(scene).contains(paths), "{}", why(scene));
    }
    assert!(why(&small()).contains("Connect"), "{}", why(&small()));
}
