//! What formulas say.

use super::{SUN_LX, agrees, asked, empty, flat, maps, sides, sun};
use crate::common::{add_group, add_part, cuboid, face, lamp, mesh, quad, uniform_sky};
use eyebox::scene::{FaceRange, Finish, Mesh, Scene, Sensor, Shape, Spectrum, Wavelengths};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Shares that a plate of index n transmits of both polarisations at cos θ, all reflections inside of it added up: with the
/// Fresnel reflectance R of a surface, (1 − R)/(1 + R) (Born and Wolf, without interference).
fn plate(cos: f64, n: f64) -> [f64; 2] {
    let inner = (1.0 - (1.0 - cos * cos) / (n * n)).sqrt();
    let s = (cos - n * inner) / (cos + n * inner);
    let p = (n * cos - inner) / (n * cos + inner);
    [s, p].map(|r| (1.0 - r * r) / (1.0 + r * r))
}

fn under_glass(scene: &mut Scene, n: f64) {
    let glass = mesh(&cuboid(DVec3::new(1.0, 1.0, 0.002)));
    add_part(scene, "plate", glass, DVec3::new(0.0, 0.0, 0.003), Some(n), vec![face(Finish::Polished); 6]);
}

#[test]
fn the_sun_on_a_plane() {
    for degrees in [0.0_f64, 40.0, 80.0] {
        for (name, angle) in [("parallel", 0.0), ("disc", 0.533_f64.to_radians()), ("wide", 0.3)] {
            // The wide disc must not set.
            if degrees > 70.0 && angle > 0.1 {
                continue;
            }
            let theta = degrees.to_radians();
            let mut scene = empty();
            flat(&mut scene, [0.03, 0.01], [6, 2]);
            sun(&mut scene, DVec3::new(theta.sin(), 0.0, theta.cos()), angle);
            let map = maps(&scene, &asked(8)).remove(0);
            let [front, back] = [&map.sides[0], &map.sides[1]];
            let want = SUN_LX * theta.cos();
            agrees(&format!("{name} {degrees}"), front.mean_lx, want, 1e-9);
            assert_eq!((back.mean_lx.value, back.peak), (0.0, None));
            assert!(map.coverage.iter().all(|share| (share - 1.0).abs() < 1e-6), "{:?}", map.coverage);
            assert!((map.area_m2 - 0.0012).abs() < 1e-9);
            for (light, error) in front.illuminance_lx.iter().zip(&front.stderr_lx) {
                assert!((light - want).abs() < 5.0 * error + 1e-6 * want, "{light} ± {error}, {want}");
            }
            // From behind.
            scene.parts[0].to_world = glam::DAffine3::from_rotation_x(PI);
            let [front, back] = sides(&scene, 8);
            agrees(&format!("{name} {degrees} from behind"), back.mean_lx, want, 1e-9);
            assert_eq!(front.peak, None);
        }
    }
}

#[test]
fn a_uniform_sky() {
    let mut scene = empty();
    flat(&mut scene, [0.03, 0.01], [6, 2]);
    uniform_sky(&mut scene, 500.0);
    for side in sides(&scene, 2) {
        assert!((side.mean_lx.value - 500.0 * PI).abs() < 1e-3, "{:?}", side.mean_lx);
    }
    // On a black ground through a plate, the integral over its transmittance.
    let mut scene = empty();
    flat(&mut scene, [0.005, 0.005], [2, 2]);
    uniform_sky(&mut scene, 500.0);
    under_glass(&mut scene, 1.5);
    let ground = mesh(&[quad(DVec3::ZERO, DVec3::X * 2.0, DVec3::Y * 2.0)]);
    add_part(&mut scene, "ground", ground, DVec3::Z * -1e-4, None, vec![face(Finish::Absorber)]);
    let [front, back] = sides(&scene, 64);
    let steps = 20_000;
    let of_plate = |k: usize| {
        let sin2 = (k as f64 + 0.5) / steps as f64;
        let [s, p] = plate((1.0 - sin2).sqrt(), 1.5);
        0.5 * (s + p) / steps as f64
    };
    agrees("through a plate", front.mean_lx, 500.0 * PI * (0..steps).map(of_plate).sum::<f64>(), 1e-4);
    assert_eq!(back.mean_lx.value, 0.0);
}

#[test]
fn the_sun_through_a_plate() {
    for degrees in [0.0_f64, 60.0, 75.0] {
        let cos = degrees.to_radians().cos();
        let mut scene = empty();
        flat(&mut scene, [0.01, 0.01], [4, 4]);
        sun(&mut scene, DVec3::new(0.0, degrees.to_radians().sin(), cos), 0.0);
        under_glass(&mut scene, 1.52);
        let [s, p] = plate(cos, 1.52);
        agrees(&format!("{degrees}"), sides(&scene, 32)[0].mean_lx, SUN_LX * cos * 0.5 * (s + p), 1e-6);
    }
}

/// A disc of luminance L, seen from its axis under the half angle a: E = π L sin² a.
#[test]
fn a_disc_that_shines() {
    let (radius, distance, sides_of_disc) = (0.05, 0.1, 720);
    let mut scene = empty();
    flat(&mut scene, [1e-3, 1e-3], [2, 2]);
    let group = add_group(&mut scene, "disc");
    let mut shining = face(Finish::Absorber);
    shining.emitter = lamp(group, 1000.0);
    let rim = |k: usize| {
        let (sin, cos) = (TAU * k as f64 / sides_of_disc as f64).sin_cos();
        DVec3::new(radius * cos, -radius * sin, 0.0)
    };
    let disc = mesh(&[(0..sides_of_disc).map(rim).collect()]);
    add_part(&mut scene, "disc", disc, DVec3::Z * distance, None, vec![shining]);
    let want = PI * 1000.0 * radius * radius / (radius * radius + distance * distance);
    agrees("disc", sides(&scene, 64)[0].mean_lx, want, 2e-4);
}

/// The front of a paraboloid of focal length `f`, of one face.
fn paraboloid(f: f64, aperture: f64) -> Mesh {
    let (rings, sectors) = (12, 240);
    let mut mesh = Mesh { name: "dish".to_owned(), ..Mesh::default() };
    let mut put = |x: f64, y: f64| {
        mesh.positions.push(DVec3::new(x, y, (x * x + y * y) / (4.0 * f)).as_vec3().to_array());
        mesh.normals.push(DVec3::new(-x / (2.0 * f), -y / (2.0 * f), 1.0).normalize().as_vec3().to_array());
        mesh.positions.len() as u32 - 1
    };
    let middle = put(0.0, 0.0);
    let ring = |put: &mut dyn FnMut(f64, f64) -> u32, k: usize| -> Vec<u32> {
        let radius = aperture * k as f64 / rings as f64;
        (0..sectors)
            .map(|j| {
                let (sin, cos) = (TAU * j as f64 / sectors as f64).sin_cos();
                put(radius * cos, radius * sin)
            })
            .collect()
    };
    let all: Vec<Vec<u32>> = (1..=rings).map(|k| ring(&mut put, k)).collect();
    for j in 0..sectors {
        let k = (j + 1) % sectors;
        mesh.triangles.push([middle, all[0][j], all[0][k]]);
        for pair in all.windows(2) {
            mesh.triangles.push([pair[0][j], pair[1][j], pair[1][k]]);
            mesh.triangles.push([pair[0][j], pair[1][k], pair[0][k]]);
        }
    }
    mesh.faces.push(FaceRange { first: 0, count: mesh.triangles.len() as u32 });
    mesh
}

/// A dish in the sun brings all light that it catches to its focus, but for the sensor's shadow; and the middle of the sun's
/// image is as bright as the sun over the dish's projected solid angle, π L sin² u, where a ray from the rim falls in under u.
#[test]
fn a_dish_in_the_sun() {
    let (f, aperture, reflectance, half): (f64, f64, f64, f64) = (0.1, 0.02, 0.9, 0.001);
    let angle = 0.533_f64.to_radians();
    let mut scene = empty();
    flat(&mut scene, [half, half], [20, 20]);
    // Its front looks at the dish, which lies below it.
    scene.parts[0].to_world = glam::DAffine3::from_rotation_x(PI);
    sun(&mut scene, DVec3::Z, angle);
    let mut mirror = face(Finish::MirrorIdeal { reflectance });
    mirror.shape = Shape::Conic { vertex: DVec3::ZERO, axis: DVec3::Z, radius: 2.0 * f, conic: -1.0 };
    add_part(&mut scene, "dish", paraboloid(f, aperture), DVec3::Z * -f, None, vec![mirror]);
    let found = maps(&scene, &asked(32)).remove(0);
    let [front, back] = [&found.sides[0], &found.sides[1]];
    let sun_area = PI * aperture * aperture - 4.0 * half * half;
    agrees("caught", front.flux_lm, reflectance * SUN_LX * sun_area, 4e-4);
    // A few thousandths of all light that arrives: known less well than the rest.
    let [value, error] = [back.mean_lx.value, back.mean_lx.stderr.unwrap()];
    assert!((value - SUN_LX).abs() < 4.0 * error && error < 0.06 * SUN_LX, "{value} ± {error}");
    let luminance = SUN_LX / (PI * (angle / 2.0).sin().powi(2));
    // From the focus the rim is at tan(u/2) = aperture/(2 f); the shadow is small and straight ahead.
    let u = 2.0 * (aperture / (2.0 * f)).atan();
    let want = reflectance * luminance * (PI * u.sin().powi(2) - (2.0 * half / f).powi(2));
    let peak = front.peak.expect("light");
    let error = peak.stderr.expect("passes");
    // The brightest of all pixels in the sun's image, which has about sixty, is one that chance favours.
    assert!((peak.value - want).abs() < 5.0 * error + 0.01 * want, "{peak:?} {want}");
    assert!(peak.place_m.iter().all(|x| x.abs() < 0.5 * f * angle), "{peak:?}");
    let four = [189, 190, 209, 210];
    let middle = four.iter().map(|p| front.illuminance_lx[*p]).sum::<f64>() / 4.0;
    let error = four.iter().map(|p| front.stderr_lx[*p].powi(2)).sum::<f64>().sqrt() / 4.0;
    println!("middle: {middle} ± {error}, {want}");
    assert!((middle - want).abs() < 4.0 * error && error < 0.005 * want, "{middle} ± {error}, {want}");
}

/// Equal power from 360 to 830 nm has 683 ∫V/470 nm lm/W, of which the CIE's table of V has ∫V = 106.857 nm; with a colour by
/// glass that disperses, and without.
#[test]
fn watts_of_a_spectrum() {
    for disperses in [false, true] {
        let mut scene = empty();
        scene.wavelengths = Wavelengths::Visible;
        flat(&mut scene, [0.01, 0.01], [2, 2]);
        sun(&mut scene, DVec3::Z, 0.0);
        scene.lights[0].spectrum = Some(Spectrum::Equal);
        if disperses {
            under_glass(&mut scene, 1.5);
            scene.media[0].index = eyebox::scene::glass::find("N-BK7").unwrap().dispersion.clone();
            scene.parts.last_mut().unwrap().to_world.translation.x = 5.0;
        }
        let [front, _] = sides(&scene, 64);
        agrees("lx", front.mean_lx, SUN_LX, 1e-6);
        let efficacy = 683.002 * 106.857 / 470.0;
        let power = front.mean_w_m2.expect("a spectrum is told");
        if disperses {
            // Passes have a few wavelengths each: they lie far apart, and together cover the spectrum evenly.
            let off = (power.value - SUN_LX / efficacy).abs();
            assert!(off < power.stderr.unwrap() && off < 0.05 * power.value, "{power:?}");
        } else {
            agrees("W/m²", power, SUN_LX / efficacy, 1e-4);
        }
        let watts = front.irradiance_w_m2.unwrap();
        let mean = watts.iter().sum::<f64>() / watts.len() as f64;
        assert!((mean / front.mean_w_m2.unwrap().value - 1.0).abs() < 1e-5);
    }
    // One wavelength tells no watts.
    let mut scene = empty();
    flat(&mut scene, [0.01, 0.01], [2, 2]);
    sun(&mut scene, DVec3::Z, 0.0);
    let [front, _] = sides(&scene, 2);
    assert_eq!((front.mean_w_m2, front.irradiance_w_m2), (None, None));
}

/// A sensor of a shape that its rectangle does not fill: what each pixel has is over the face's own area there.
#[test]
fn a_triangle_in_the_sun() {
    let mut scene = empty();
    sun(&mut scene, DVec3::Z, 0.0);
    let mut own = face(Finish::None);
    own.sensor = Some(Sensor { pixels: [8, 4], u: Some(DVec3::X) });
    let triangle = vec![DVec3::new(-0.02, -0.01, 0.0), DVec3::new(0.02, -0.01, 0.0), DVec3::new(-0.02, 0.01, 0.0)];
    add_part(&mut scene, "sensor", mesh(&[triangle]), DVec3::ZERO, None, vec![own]);
    // A face that is not there measures, and lets all light on to what is behind it.
    let mut below = face(Finish::Absorber);
    below.sensor = Some(Sensor { pixels: [1, 1], u: None });
    let floor = mesh(&[quad(DVec3::ZERO, DVec3::X * 0.01, DVec3::Y * 0.005)]);
    add_part(&mut scene, "floor", floor, DVec3::Z * -0.01, None, vec![below]);
    let found = maps(&scene, &asked(16));
    agrees("floor", found[1].sides[0].mean_lx, SUN_LX, 1e-6);
    let front = &found[0].sides[0];
    agrees("triangle", front.mean_lx, SUN_LX, 1e-6);
    for (pixel, share) in found[0].coverage.iter().enumerate() {
        let ([column, row], light) = ([pixel % 8, pixel / 8], front.illuminance_lx[pixel]);
        // The hypotenuse runs from the upper left to the lower right, two columns to a row.
        let want = if column / 2 < row {
            1.0
        } else if column / 2 > row {
            0.0
        } else {
            [0.75, 0.25][column % 2]
        };
        assert!((share - want).abs() < 1e-5, "{column} {row}: {share}");
        let error = front.stderr_lx[pixel];
        assert!(
            (light - if want > 0.0 { SUN_LX } else { 0.0 }).abs() <= 5.0 * error,
            "{column} {row}: {light} ± {error}"
        );
    }
}
