//! Closed forms of radiometry (`tests/data/radiometry_cases.json`, whose header says what made it) against the
//! emitting faces, the eye and the scatterers; the cases that take a whole tracer are in `oracle_radiometry/traced.rs`
//! (plates and slabs in `oracle_slabs.rs`).
//!
//! Integrals are means of jittered strata; their noise is measured over independent repetitions, must be below 0.1 %,
//! and the closed form must lie within 3 of its standard errors (and a rounding of 1e-6: meshes are f32).

mod shapes;
mod traced;

use eyebox::base::rng::{Rng, Stream};
use eyebox::base::stats::Moments;
use eyebox::scene::*;
use eyebox::world::eye::EyeLens;
use eyebox::world::lamp::Lamp;
use eyebox::world::scatter::{Scatter, Sides};
use glam::DVec3;
use serde_json::Value;
use shapes::{MM, disk, eye, lambert, lamp, polygon};
use std::f64::consts::{PI, TAU};

fn cases(kind: &str) -> Vec<Value> {
    let text = include_str!("data/radiometry_cases.json");
    let all: Value = serde_json::from_str(text).unwrap();
    let cases: Vec<Value> = all["cases"].as_array().unwrap().iter().filter(|c| c["kind"] == kind).cloned().collect();
    assert!(!cases.is_empty(), "no case of kind {kind}");
    cases
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is not a number"))
}

/// Mean and standard error of `f` over the unit square: 32 repetitions of 256 × 256 jittered strata.
fn mean(f: impl Fn([f64; 2], &mut Rng) -> f64) -> (f64, f64) {
    let mut runs = Moments::default();
    let strata = 256;
    for run in 0..32 {
        let mut rng = Rng::new(42, Stream::Check, run, 0);
        let mut sum = 0.0;
        for cell in 0..strata * strata {
            let [a, b] = rng.pair();
            let u = [((cell / strata) as f64 + a) / strata as f64, ((cell % strata) as f64 + b) / strata as f64];
            sum += f(u, &mut rng);
        }
        runs.add(sum / (strata * strata) as f64);
    }
    (runs.mean, runs.stderr())
}

fn assert_near(name: &str, (got, noise): (f64, f64), want: f64, rounding: f64) {
    println!("{name}: {got:.9e} want {want:.9e}: off {:+.1e}, noise {:.1e}", got / want - 1.0, noise / want);
    assert!(noise <= 1e-3 * want, "{name}: noise {noise} of {want}");
    assert!((got - want).abs() <= 3.0 * noise + rounding * want, "{name}: {got} ± {noise}, want {want}");
}

/// Illuminance at the origin on a receiver with unit normal `n`, lx.
fn illuminance(lamp: &Lamp, n: DVec3) -> (f64, f64) {
    mean(|u, _| {
        let point = lamp.sample_point(u);
        let d2 = point.position.length_squared();
        let dir = point.position / d2.sqrt();
        lamp.luminance(-dir.dot(point.normal)) * (-dir.dot(point.normal)).max(0.0) * dir.dot(n).max(0.0) / d2
            * lamp.area_m2
    })
}

#[test]
fn lambert_led() {
    for case in cases("lambert_led") {
        let (p, r) = (&case["params"], &case["result"]);
        let (x, y, d) = (number(&p["sx_mm"]) / 2.0, number(&p["sy_mm"]) / 2.0, number(&p["d_mm"]));
        let corners = [(-x, -y), (x, -y), (x, y), (-x, y)].map(|(x, y)| DVec3::new(x, y, d));
        let lamp = lamp(&polygon(&corners, DVec3::ZERO), Photometry::FluxLm(number(&p["flux_lm"])), Angular::Lambert);
        assert_near("L", (lamp.luminance(0.3), 0.0), number(&r["L"]), 1e-6);
        assert_near("I0", (lamp.intensity_cd, 0.0), number(&r["I0"]), 1e-12);
        assert_near("M", (lamp.flux_lm / lamp.area_m2, 0.0), number(&r["M"]), 1e-6);
        assert_near("E_axis", illuminance(&lamp, DVec3::Z), number(&r["E_axis"]), 1e-6);
    }
}

#[test]
fn cosm_source() {
    for case in cases("cosm_source") {
        let (p, r) = (&case["params"], &case["result"]);
        let side = number(&p["area_mm2"]).sqrt();
        let corners = [(0.0, 0.0), (side, 0.0), (side, side), (0.0, side)].map(|(x, y)| DVec3::new(x, y, 0.0));
        let angular = Angular::CosN { n: number(&p["m"]) };
        let lamp = lamp(&polygon(&corners, DVec3::Z), Photometry::FluxLm(number(&p["flux_lm"])), angular);
        assert_near("I0", (lamp.intensity_cd, 0.0), number(&r["I0"]), 1e-12);
        for (k, angle) in p["angles"].as_array().unwrap().iter().enumerate() {
            let cos = number(angle).to_radians().cos();
            assert_near("L", (lamp.luminance(cos), 0.0), number(&r["L"][k]), 1e-6);
            assert_near("I", (lamp.luminance(cos) * cos * lamp.area_m2, 0.0), number(&r["I"][k]), 1e-10);
        }
        // The flux that the emitted directions stand for.
        let flux = mean(|u, _| {
            let cos = lamp.sample_direction(DVec3::Z, u).z;
            lamp.luminance(cos) * cos * lamp.area_m2 / lamp.direction_pdf(cos)
        });
        assert_near("flux", flux, number(&r["flux"]), 1e-9);
    }
}

#[test]
fn disks() {
    for case in cases("disk") {
        let p = &case["params"];
        let lamp = lambert(&disk(number(&p["r"]), number(&p["d"]), number(&p["x"])), number(&p["L"]));
        assert_near(&case["id"].to_string(), illuminance(&lamp, DVec3::Z), number(&case["result"]["E"]), 3e-6);
    }
}

#[test]
fn spheres() {
    for case in cases("sphere") {
        let p = &case["params"];
        let (radius, d, tilt) = (number(&p["R"]), number(&p["d"]), number(&p["tilt"]).to_radians());
        let n = DVec3::new(tilt.sin(), 0.0, tilt.cos());
        // The sphere's pole points at the receiver; the cap that faces it, to beyond its rim, is meshed finely.
        let (rings, sectors, rim) = (1000, 1000, 1.01 * (radius / d).acos());
        let at = |ring: usize, sector: usize| {
            let (sin, cos) = (rim * ring as f64 / rings as f64).sin_cos();
            let phi = TAU * sector as f64 / sectors as f64;
            DVec3::new(radius * sin * phi.cos(), radius * sin * phi.sin(), d - radius * cos)
        };
        let mut triangles = Vec::new();
        for ring in 0..rings {
            for sector in 0..sectors {
                let (a, b) = (at(ring, sector), at(ring, sector + 1));
                let (c, e) = (at(ring + 1, sector), at(ring + 1, sector + 1));
                // Only what can stand above the receiver's horizon: the rest would be noise.
                for triangle in [[a, e, c], [a, b, e]] {
                    if triangle.iter().any(|corner| corner.dot(n) > 0.0) {
                        triangles.push(triangle);
                    }
                }
            }
        }
        let outwards = |[a, b, c]: [DVec3; 3]| {
            let centre = DVec3::new(0.0, 0.0, d);
            if (b - a).cross(c - a).dot(a + b + c - 3.0 * centre) > 0.0 { [a, b, c] } else { [a, c, b] }
        };
        let triangles: Vec<_> = triangles.into_iter().map(outwards).collect();
        let lamp = lambert(&triangles, number(&p["L"]));
        // Chords of 1/1000 turn: area and silhouette are (2π/1000)²/6 = 7e-6 too small.
        assert_near(&case["id"].to_string(), illuminance(&lamp, n), number(&case["result"]["E"]), 2e-5);
    }
}

#[test]
fn rectangles_and_polygons() {
    for kind in ["rect_parallel", "rect_perp", "polygon"] {
        for case in cases(kind) {
            let p = &case["params"];
            let triple = |v: &Value| DVec3::new(number(&v[0]), number(&v[1]), number(&v[2]));
            let (corners, n): (Vec<DVec3>, DVec3) = if kind == "polygon" {
                (p["verts"].as_array().unwrap().iter().map(triple).collect(), triple(&p["n"]))
            } else {
                let (a, b, d) = (number(&p["a"]), number(&p["b"]), number(&p["d"]));
                let corner = |s: f64, t: f64| {
                    if kind == "rect_perp" { DVec3::new(d, s * a, t * b) } else { DVec3::new(s * a, t * b, d) }
                };
                (vec![corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)], DVec3::Z)
            };
            let lamp = lambert(&polygon(&corners, DVec3::ZERO), number(&p["L"]));
            assert_near(&case["id"].to_string(), illuminance(&lamp, n), number(&case["result"]["E"]), 1e-6);
        }
    }
}

/// A lens's pupil, seen from its image, is a disk of the object's luminance × τ.
#[test]
fn cameras() {
    for case in cases("camera") {
        let (p, r) = (&case["params"], &case["result"]);
        let f = number(&p["f"]);
        for (k, field) in p["fields"].as_array().unwrap().iter().enumerate() {
            let x = f * number(field).to_radians().tan();
            let pupil = lambert(&disk(f / number(&p["N"]) / 2.0, f, x), number(&p["L"]) * number(&p["tau"]));
            assert_near(&case["id"].to_string(), illuminance(&pupil, DVec3::Z), number(&r["E_exact"][k]), 3e-6);
        }
    }
    for case in cases("camera_finite") {
        let (p, r) = (&case["params"], &case["result"]);
        let (f, s) = (number(&p["f"]), number(&p["object_distance"]));
        let image = s * f / (s - f);
        assert_near("image distance", (image, 0.0), number(&r["image_distance"]), 1e-12);
        let pupil = lambert(&disk(f / number(&p["N"]) / 2.0, image, 0.0), number(&p["L"]) * number(&p["tau"]));
        assert_near(&case["id"].to_string(), illuminance(&pupil, DVec3::Z), number(&r["E_axis"]), 3e-6);
    }
}

/// The retina's illuminance, the pupil's solid angle, and the bias of reading L as E/(cos σ · Ω).
#[test]
fn retinas() {
    for case in cases("eye") {
        let (p, r) = (&case["params"], &case["result"]);
        let f = number(&p["f"]);
        for (k, field) in p["fields"].as_array().unwrap().iter().enumerate() {
            let field = number(field).to_radians();
            let pupil = lambert(&disk(number(&p["pupil_d"]) / 2.0, f, f * field.tan()), number(&p["L"]));
            let tau = number(&p["tau"]);
            let (e, e_noise) = illuminance(&pupil, DVec3::Z);
            assert_near(&case["id"].to_string(), (e * tau, e_noise * tau), number(&r["E_retina"][k]), 3e-6);
            let omega = mean(|u, _| {
                let point = pupil.sample_point(u);
                let d2 = point.position.length_squared();
                -point.position.dot(point.normal) / d2.sqrt() / d2 * pupil.area_m2
            });
            assert_near("Omega", omega, number(&r["Omega"][k]), 3e-6);
            let read = (e / (field.cos() * omega.0), e_noise / (field.cos() * omega.0));
            assert_near("Eq. 3", read, number(&r["L_by_article_eq3"][k]), 6e-6);
        }
    }
}

/// Flux of a small source into the pupil: from points of the lamp to points of the pupil, all of which must arrive.
#[test]
fn small_source_into_the_pupil() {
    for case in cases("small_to_pupil") {
        let (p, r) = (&case["params"], &case["result"]);
        let (side, d) = (number(&p["area_mm2"]).sqrt() / 2.0, number(&p["d_mm"]));
        let turned = |angle: &Value, z: f64| {
            let (sin, cos) = number(angle).to_radians().sin_cos();
            (DVec3::new(cos, 0.0, -sin * z), DVec3::new(sin, 0.0, cos * z))
        };
        // The source in the origin shines along +z, the eye at d looks back along −z; both are turned about y.
        let (across, normal) = turned(&p["th_s"], 1.0);
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| across * (x * side) + DVec3::Y * (y * side));
        let lamp = lambert(&polygon(&corners, normal * d), number(&p["L"]));
        let (_, look) = turned(&p["th_p"], -1.0);
        let eye = eye(DVec3::Z * d * MM, look, number(&p["pupil_d_mm"]) * MM, 60.0);
        let lens = EyeLens::build(&eye, DVec3::ZERO).unwrap();
        let flux = mean(|u, rng| {
            let from = lamp.sample_point(u);
            let (to, _) = lens.ray(0, 0, [0.5; 2], rng.pair());
            let d2 = to.distance_squared(from.position);
            let dir = (to - from.position) / d2.sqrt();
            assert!(lens.arrive(from.position, dir, f64::INFINITY).is_some_and(|a| a.pixel == Some(0)));
            let cos = dir.dot(from.normal);
            lamp.luminance(cos) * cos * -dir.dot(look) / d2 * lamp.area_m2 * lens.pupil_area_m2()
        });
        // The closed form is that of a small pupil: 2 (r/2d)² = 2e-5 here.
        let small = (eye.pupil_diameter_m / (2.0 * d * MM)).powi(2);
        assert_near(&case["id"].to_string(), flux, number(&r["flux_into_pupil"]), small + 1e-6);
        let fraction = (flux.0 / lamp.flux_lm, flux.1 / lamp.flux_lm);
        assert_near("fraction", fraction, number(&r["fraction_of_emitted"]), small + 1e-6);
    }
}

/// A lamp smaller than a pixel: light traced forwards, and the eye's own rays traced backwards.
#[test]
fn subpixel_lamp_both_ways() {
    for case in cases("subpixel") {
        let (p, r) = (&case["params"], &case["result"]);
        let (side, d) = (number(&p["area_mm2"]).sqrt() / 2.0, number(&p["d_mm"]));
        let corners = [(-side, -side), (side, -side), (side, side), (-side, side)].map(|(x, y)| DVec3::new(x, y, 0.0));
        let lamp = lambert(&polygon(&corners, DVec3::Z), number(&p["L"]));
        // A pupil small beside the pixel's footprint at the lamp, or the focus at infinity would blur it out.
        let eye = eye(DVec3::Z * d * MM, DVec3::NEG_Z, 1e-6, number(&p["px_arcmin"]) / 60.0);
        let lens = EyeLens::build(&eye, DVec3::ZERO).unwrap();
        let forward = mean(|u, rng| {
            let from = lamp.sample_point(u);
            let (to, _) = lens.ray(0, 0, [0.5; 2], rng.pair());
            let d2 = to.distance_squared(from.position);
            let dir = (to - from.position) / d2.sqrt();
            let flux = lamp.luminance(dir.z) * dir.z * dir.z / d2 * lamp.area_m2 * lens.pupil_area_m2();
            let arrival = lens.arrive(from.position, dir, f64::INFINITY).unwrap();
            assert_eq!(arrival.pixel, Some(0));
            flux * arrival.luminance_per_lumen
        });
        assert_near("forward", forward, number(&r["L_pixel"]), 1e-6);
        let backward = mean(|u, rng| {
            let (origin, dir) = lens.ray(0, 0, u, rng.pair());
            let at = (origin - dir * (origin.z / dir.z)) / MM;
            if at.x.abs() < side && at.y.abs() < side { lamp.luminance(-dir.z) } else { 0.0 }
        });
        assert_near("backward", backward, number(&r["L_pixel"]), 1e-6);
    }
}

#[test]
fn flux_into_a_cone() {
    for case in cases("lens_flux") {
        let (p, r) = (&case["params"], &case["result"]);
        let side = number(&p["area_mm2"]).sqrt();
        let corners = [(0.0, 0.0), (side, 0.0), (side, side), (0.0, side)].map(|(x, y)| DVec3::new(x, y, 0.0));
        let lamp = lambert(&polygon(&corners, DVec3::Z), number(&p["L"]));
        let limit = number(&p["half_angle_deg"]).to_radians().cos();
        let share = mean(|u, _| f64::from(u8::from(lamp.sample_direction(DVec3::Z, u).z > limit)));
        assert_near("fraction", share, number(&r["fraction"]), 1e-9);
        let flux = (share.0 * lamp.flux_lm, share.1 * lamp.flux_lm);
        assert_near("flux", flux, number(&r["flux"]), 1e-6);
    }
}

/// Lit with E from straight above, a cosᵐ diffuser shows τE(m + 2)/(2π) cosᵐ θ and sends out τE.
#[test]
fn cosm_diffuser() {
    let case = cases("diffuser").into_iter().find(|c| c["params"]["model"] == "cosm").unwrap();
    let (p, r) = (&case["params"], &case["result"]);
    let finish = Finish::CosM { m: number(&p["m"]), reflectance: 0.0, transmittance: number(&p["tau"]) };
    let diffuser = Scatter::from_finish(&finish).unwrap();
    let angles = p["angles"].as_array().unwrap();
    assert_eq!(angles.len(), 4);
    for (index, theta) in angles.iter().enumerate() {
        let (sin, cos) = number(theta).to_radians().sin_cos();
        let luminance = diffuser.eval(DVec3::NEG_Z, DVec3::new(sin, 0.0, -cos), Sides::AIR) * number(&p["E"]);
        assert_near("cosm diffuser", (luminance, 0.0), number(&r["L"][index]), 1e-10);
    }
    let sampled = mean(|u, rng| {
        let sample = diffuser.sample(DVec3::NEG_Z, Sides::AIR, [rng.uniform(), u[0], u[1]]);
        sample.map_or(0.0, |s| s.weight * number(&p["E"]))
    });
    assert_near("cosm diffuser, flux", sampled, number(&r["M"]), 1e-3);
}

/// Lit with E, a Lambertian diffuser shows τE/π; in a uniform L0, a Lambertian face shows ρL0.
#[test]
fn lambertian_diffuser_and_furnace() {
    let case = cases("diffuser").into_iter().find(|c| c["params"]["model"] == "lambert").unwrap();
    let (p, r) = (&case["params"], &case["result"]);
    let finish = Finish::Lambert { reflectance: 0.0, transmittance: number(&p["tau"]) };
    let diffuser = Scatter::from_finish(&finish).unwrap();
    for theta in [0.0f64, 30.0, 80.0] {
        let seen = DVec3::new(theta.to_radians().sin(), 0.0, -theta.to_radians().cos());
        let luminance = diffuser.eval(DVec3::NEG_Z, seen, Sides::AIR) * number(&p["E"]);
        assert_near("diffuser", (luminance, 0.0), number(&r["L"]), 1e-10);
        assert_eq!(diffuser.eval(DVec3::NEG_Z, -seen, Sides::AIR), 0.0);
    }
    let case = cases("furnace").into_iter().find(|c| c["params"]["kind"] == "lambert_convex").unwrap();
    let (p, r) = (&case["params"], &case["result"]);
    let finish = Finish::Lambert { reflectance: number(&p["rho"]), transmittance: 0.0 };
    let face = Scatter::from_finish(&finish).unwrap();
    for theta in [0.0f64, 60.0, 89.0] {
        let arriving = DVec3::new(theta.to_radians().sin(), 0.0, -theta.to_radians().cos());
        // By the weights of sampled directions, and by the distribution over uniform directions.
        let sampled = mean(|u, rng| {
            face.sample(arriving, Sides::AIR, [rng.uniform(), u[0], u[1]]).map_or(0.0, |s| s.weight * number(&p["L0"]))
        });
        assert_near("furnace", sampled, number(&r["L"]), 1e-12);
        let uniform = mean(|u, _| {
            let (sin, phi) = ((1.0 - u[0] * u[0]).sqrt(), TAU * u[1]);
            let dir = DVec3::new(sin * phi.cos(), sin * phi.sin(), u[0]);
            face.eval(arriving, dir, Sides::AIR) * dir.z * number(&p["L0"]) * 2.0 * PI
        });
        assert_near("furnace", uniform, number(&r["L"]), 1e-12);
    }
}
