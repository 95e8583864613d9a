//! Light of the sky and of discs at infinity that comes through glass: against a closed form, and against photons.

use super::kit;
use super::measure::{How, trace};
use eyebox_film::plan::Estimator;
use eyebox_scene::{Beacon, BeaconForm, Face, Finish, Scene};
use glam::{DAffine3, DVec3};
use std::f64::consts::PI;

const GLASS: f64 = 1.5168;

/// A square of matt floor at y = −1, seen from above.
fn floor(fov_deg: f64, pixels: usize, half: f64, reflectance: f64) -> Scene {
    let mut scene = kit::scene(fov_deg, pixels);
    let matt = kit::face(Finish::Lambert { reflectance, transmittance: 0.0 });
    let square = kit::mesh(&[kit::quad(DVec3::NEG_Y, DVec3::Z * half, DVec3::X * half)]);
    kit::add(&mut scene, square, DAffine3::IDENTITY, None, vec![matt]);
    kit::look(&mut scene, DVec3::new(0.0, -0.6, 1.0), DVec3::NEG_Y);
    scene
}

/// Luminance and its standard error over a floor under a bright cap of a black sky, of half angle π/`rows`, with this over
/// it.
fn under_the_cap(rows: usize, over: &dyn Fn(&mut Scene)) -> (f64, f64) {
    let mut scene = floor(1.0, 4, 0.05, 0.5);
    let width = 2 * rows;
    kit::sky(&mut scene, width, rows, (0..width * rows).map(|i| if i < width { 1e4 } else { 0.0 }).collect());
    over(&mut scene);
    let measured = trace(&scene, How::backward(256)).unwrap();
    (measured.mean, measured.sigma)
}

/// A pane above the floor, so large that all of the cap is seen through it: illuminance π L sin²θ times what two faces let
/// through at normal incidence, (1 − R)², and 2 ‰ more by reflections in the pane, which are left to chance.
/// Without following the chosen direction through the pane one path in a hundred would find the cap.
#[test]
fn the_sky_through_a_pane() {
    let pane = |scene: &mut Scene| {
        let faces: Vec<Face> = (0..6).map(|_| kit::face(Finish::Polished)).collect();
        let glass = kit::mesh(&kit::cuboid(DVec3::new(3.0, 5e-3, 3.0)));
        kit::add(scene, glass, DAffine3::from_translation(DVec3::Y), Some(GLASS), faces);
    };
    let rows = 32;
    let (open, of_open) = under_the_cap(rows, &|_| {});
    let (behind, sigma) = under_the_cap(rows, &pane);
    let want = 0.5 * 1e4 * (PI / rows as f64).sin().powi(2);
    assert!((open / want - 1.0).abs() < 3e-3 && of_open < 2e-3 * want, "{open} ± {of_open}, {want}");
    let reflected = ((GLASS - 1.0) / (GLASS + 1.0)).powi(2);
    let through = (1.0 - reflected).powi(2);
    assert!(
        (behind / want / through - 1.0).abs() < 6e-3 && sigma < 3e-3 * want,
        "{behind} ± {sigma}, {want} {through}"
    );
}

/// A ball of glass bends what is chosen: the direction of a disc leads elsewhere, and others lead to the disc. Photons know
/// nothing of choosing.
#[test]
fn a_disc_through_a_ball() {
    let mut scene = floor(24.0, 12, 1.0, 0.5);
    let ball = kit::sphere(0.1, 16, 32);
    let above = DAffine3::from_translation(DVec3::Y * -0.65);
    kit::add(&mut scene, ball, above, Some(GLASS), vec![kit::polished(kit::ball(0.1))]);
    let group = kit::group(&mut scene, "sun");
    let form = BeaconForm::Distant { dir: DVec3::NEG_Y, illuminance_lx: 1000.0, angle_rad: 0.4 };
    scene.lights.push(Beacon { name: "sun".to_owned(), group, form, spectrum: None });
    let eye = trace(&scene, How::backward(3000)).unwrap();
    let photons = trace(&scene, How { estimator: Estimator::Photon, ..How::backward(60) }).unwrap();
    let sigma = eye.sigma.hypot(photons.sigma);
    assert!(sigma < 4e-3 * eye.mean, "{eye:?} {photons:?}");
    // Photons are gathered over some width: within 3 ‰.
    assert!((eye.mean - photons.mean).abs() < 4.0 * sigma + 3e-3 * eye.mean, "{eye:?} {photons:?}");
}
