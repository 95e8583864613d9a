//! Sensors by other ways of tracing light.

use super::{agrees, asked, empty, flat, maps, sides, sun};
use crate::common::{add_group, add_part, cuboid, face, image, lamp, mean, mesh, quad, render, uniform_sky, worst_z};
use eyebox::film::plan::Estimator;
use eyebox::plan::Choice;
use eyebox::plan::sensor::SensorAsked;
use eyebox::scene::{Finish, Scene, Sensor};
use glam::DVec3;
use std::f64::consts::PI;

/// A lamp and a wide sun over a grey wall, a ball of glass, a mirror and a sky about a sensor.
fn room() -> Scene {
    let mut scene = empty();
    flat(&mut scene, [0.04, 0.02], [8, 4]);
    sun(&mut scene, DVec3::new(0.3, 0.2, 1.0), 0.8);
    scene.lights[0].group = {
        if let eyebox::scene::BeaconForm::Distant { illuminance_lx, .. } = &mut scene.lights[0].form {
            *illuminance_lx = 800.0;
        }
        scene.lights[0].group
    };
    uniform_sky(&mut scene, 100.0);
    let group = add_group(&mut scene, "led");
    let mut shining = face(Finish::Absorber);
    shining.emitter = lamp(group, 2000.0);
    let panel = mesh(&[quad(DVec3::ZERO, DVec3::X * 0.02, DVec3::Y * -0.02)]);
    add_part(&mut scene, "led", panel, DVec3::new(-0.03, 0.0, 0.08), None, vec![shining]);
    let wall = mesh(&[quad(DVec3::ZERO, DVec3::Y * 0.1, DVec3::Z * 0.05)]);
    let grey = face(Finish::Lambert { reflectance: 0.6, transmittance: 0.0 });
    add_part(&mut scene, "wall", wall, DVec3::new(-0.08, 0.0, 0.05), None, vec![grey]);
    let mirror = mesh(&[quad(DVec3::ZERO, DVec3::Z * 0.05, DVec3::Y * 0.1)]);
    let finish = Finish::MirrorIdeal { reflectance: 0.8 };
    add_part(&mut scene, "mirror", mirror, DVec3::new(0.08, 0.0, 0.05), None, vec![face(finish)]);
    let glass = mesh(&cuboid(DVec3::new(0.02, 0.03, 0.003)));
    add_part(&mut scene, "glass", glass, DVec3::new(0.02, 0.0, 0.03), Some(1.5), vec![face(Finish::Polished); 6]);
    scene
}

/// Traced from the lamps and from the sensor, all pixels of both sides agree.
#[test]
fn from_the_lamps_and_from_the_sensor() {
    let scene = room();
    let forward = maps(&scene, &asked(24)).remove(0);
    let backward = maps(&scene, &SensorAsked { backward: true, seed: 8, ..asked(24) }).remove(0);
    for (a, b) in forward.sides.iter().zip(&backward.sides) {
        let z: Vec<f64> = (0..a.illuminance_lx.len())
            .map(|k| (a.illuminance_lx[k] - b.illuminance_lx[k]) / a.stderr_lx[k].hypot(b.stderr_lx[k]))
            .filter(|z| z.is_finite())
            .collect();
        assert_eq!(z.len(), 32, "{:?}", a.side);
        let (worst, bound) = worst_z(&z, 1e-4);
        assert!(worst < bound, "{:?}: {worst} {bound}", a.side);
        let names = |side: &eyebox::plan::sensor::SideMap| -> Vec<String> {
            side.groups.iter().map(|share| share.group.clone()).collect()
        };
        assert_eq!(names(a), names(b));
        for (of_a, of_b) in a.groups.iter().zip(&b.groups) {
            let [x, y] = [of_a.mean_lx, of_b.mean_lx];
            let error = x.stderr.unwrap().hypot(y.stderr.unwrap());
            assert!((x.value - y.value).abs() < 4.0 * error + 1e-9, "{}: {x:?} {y:?}", of_a.group);
        }
    }
    assert!(forward.error.unwrap() < 0.05, "{:?}", forward.error);
    assert!(forward.sides[0].groups.len() == 3, "{:?}", forward.sides[0].groups);
}

/// A perfectly white Lambertian reflector has the luminance E/π: a sensor on it, and the picture of it traced from the eye.
#[test]
fn a_white_reflector() {
    let mut scene = room();
    let glass = scene.parts.pop().expect("the last part");
    assert_eq!(glass.name, "glass");
    scene.parts[0].faces[0].finish = Finish::Lambert { reflectance: 1.0, transmittance: 0.0 };
    // Four pixels of 4 × 4 mm lie about the middle.
    scene.parts[0].faces[0].sensor = Some(Sensor { pixels: [20, 10], u: None });
    let front = &sides(&scene, 32)[0];
    let middle = [4 * 20 + 9, 4 * 20 + 10, 5 * 20 + 9, 5 * 20 + 10];
    let found = middle.iter().map(|pixel| front.illuminance_lx[*pixel]).sum::<f64>() / 4.0;
    let error = middle.iter().map(|pixel| front.stderr_lx[*pixel].powi(2)).sum::<f64>().sqrt() / 4.0;
    scene.eye.position = DVec3::new(0.0, 0.0, 0.3);
    scene.eye.pupil_diameter_m = 0.0;
    scene.eye.fov_deg = 2.0 * (0.004_f64 / 0.3).atan().to_degrees();
    scene.eye.resolution = [8, 8];
    let (films, _) = render(&scene, Choice::Only(Estimator::Backward), 192, 3);
    let (luminance, sigma) = mean(&image(&films));
    let error = error.hypot(PI * sigma);
    assert!((found - PI * luminance).abs() < 4.0 * error && error < 0.04 * found, "{found} {luminance} ± {error}");
}

/// The same bits for any number of threads, others for another seed.
#[test]
fn threads_and_seeds() {
    let scene = room();
    let with = |threads: usize, seed: u64| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| maps(&scene, &SensorAsked { seed, ..asked(4) }))
    };
    let one = with(1, 7);
    assert_eq!(one, with(3, 7));
    assert_ne!(one[0].sides[0].illuminance_lx, with(1, 8)[0].sides[0].illuminance_lx);
}

/// A sensor changes no bit of a picture.
#[test]
fn pictures_do_not_know_of_sensors() {
    let mut scene = room();
    scene.eye.position = DVec3::new(0.0, 0.0, 0.3);
    scene.eye.resolution = [12, 12];
    let (with, _) = render(&scene, Choice::Auto, 2, 5);
    scene.parts[0].faces[0].sensor = None;
    let (without, _) = render(&scene, Choice::Auto, 2, 5);
    assert_eq!(image(&with), image(&without));
}

/// The eye takes no light from a sensor: a pupil that would cover it does not.
#[test]
fn the_eye_is_not_in_the_way() {
    let mut scene = empty();
    flat(&mut scene, [0.001, 0.001], [1, 1]);
    sun(&mut scene, DVec3::Z, 0.0);
    scene.eye.position = DVec3::Z * 0.05;
    scene.eye.look = DVec3::Z;
    scene.eye.pupil_diameter_m = 0.02;
    agrees("under the eye", sides(&scene, 8)[0].mean_lx, super::SUN_LX, 1e-6);
}

/// A small sensor far behind a small hole: the pilot has to find what one path in ten thousand does.
#[test]
fn a_small_sensor_in_a_large_scene() {
    let mut scene = empty();
    flat(&mut scene, [0.002, 0.002], [4, 4]);
    sun(&mut scene, DVec3::new(0.2, 0.0, 1.0), 0.533_f64.to_radians());
    let far = mesh(&[quad(DVec3::ZERO, DVec3::X * 0.01, DVec3::Y * 0.01)]);
    add_part(&mut scene, "far", far, DVec3::new(0.3, 0.3, -0.3), None, vec![face(Finish::Absorber)]);
    let want = super::SUN_LX * DVec3::new(0.2, 0.0, 1.0).normalize().z;
    agrees("small", sides(&scene, 32)[0].mean_lx, want, 1e-6);
}
