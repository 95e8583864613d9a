//! The peers' scenes A1, A2 and B (`samples/peers`): image means against four other renderers, and the split of A1
//! against their figures and a separate calculation (`samples/peers/README.md`).

mod common;

use common::render;
use eyebox::base::stats::Moments;
use eyebox::estimate::run::Films;
use eyebox::film::layer::Layer;
use eyebox::import::{ImportOptions, import};
use eyebox::plan::{Asked, Choice, Guides, Polarisation};
use eyebox::scene::Scene;
use std::path::Path;

/// As the peers trace.
const UNPOLARISED: Asked = Asked { choice: Choice::Auto, polarisation: Polarisation::Off, guides: Guides::On };

fn peer(name: &str, side: usize) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("samples/peers/{name}/{name}.optics.toml"));
    let mut scene = import(&path, &ImportOptions::default()).expect("the sample imports").scene;
    scene.eye.resolution = [side, side];
    scene
}

/// Mean over pixels of one layer, or of all.
fn layer_mean(films: &Films, layer: Option<Layer>) -> f64 {
    let mut sum = 0.0;
    let mut pixels = 0;
    for (_, film, _) in &films.films {
        pixels = film.width * film.height;
        for (plane, key) in film.planes.iter().enumerate() {
            if layer.is_none_or(|layer| key.layer == layer) {
                sum += (0..pixels).map(|pixel| film.mean(pixel, plane).value).sum::<f64>();
            }
        }
    }
    sum / pixels as f64
}

/// Means of direct, caustic, secondary, forward and of everything over independent seeds. Photons are shared by the
/// pixels of a pass, so only whole runs are independent.
fn means(scene: &Scene, passes: u64, seeds: u64) -> [Moments; 5] {
    let mut out = [Moments::default(); 5];
    let wanted = Layer::SUM_ORDER.map(Some).into_iter().chain([None]);
    let wanted: Vec<Option<Layer>> = wanted.collect();
    for seed in 0..seeds {
        let (films, _) = render(scene, UNPOLARISED, passes, seed);
        for (moments, layer) in out.iter_mut().zip(&wanted) {
            moments.add(layer_mean(&films, *layer));
        }
    }
    out
}

#[track_caller]
fn agrees(what: &str, got: &Moments, want: f64, sigma: f64, most_noise: f64) {
    let noise = got.stderr();
    println!("{what}: {:.4} ± {noise:.4}, expected {want} ± {sigma}", got.mean);
    assert!(noise <= most_noise * want, "{what}: noise {noise} of {}", got.mean);
    let z = (got.mean - want) / noise.hypot(sigma);
    assert!(z.abs() < 4.0, "{what}: {} ± {noise}, expected {want} ± {sigma}: z = {z}", got.mean);
}

#[test]
fn a1_led_ball_screen() {
    let [direct, caustic, secondary, _, all] = means(&peer("a1", 64), 48, 8);
    agrees("A1 mean", &all, 33.02, 0.03, 1.5e-3);
    agrees("A1 direct", &direct, 19.10, 0.01, 2e-3);
    // Caustic and secondary by our classes, from the separate calculation; the peers' 11.0 and 2.77 + 0.16 draw the
    // line elsewhere.
    agrees("A1 caustic", &caustic, 11.053, 0.005, 5e-3);
    agrees("A1 secondary", &secondary, 2.861, 0.003, 5e-3);
}

#[test]
fn a2_through_a_second_ball() {
    let [direct, caustic, secondary, _, all] = means(&peer("a2", 64), 24, 8);
    // The peers' mean leaves the rarest of the lamp's mirror images to luck; the separate calculation does not.
    agrees("A2 mean, peers", &all, 52.28, 0.3, 6e-3);
    agrees("A2 mean", &all, 52.922, 0.01, 6e-3);
    agrees("A2 direct", &direct, 17.006, 0.005, 2e-2);
    agrees("A2 caustic", &caustic, 33.284, 0.006, 5e-3);
    agrees("A2 secondary", &secondary, 2.6325, 0.003, 1e-2);
}

#[test]
fn b_lens_into_the_pupil() {
    let [direct, _, _, forward, _] = means(&peer("b", 64), 24, 8);
    agrees("B mean", &forward, 17880.0, 5.0, 5e-3);
    assert_eq!(direct.mean, 0.0);
}
