//! Rows of the table that take the whole tracer: scenes of a few faces, rendered by the real estimators.
//!
//! The diffusers are rows of their distributions (`cosm_diffuser`, `lambertian_diffuser_and_furnace`).

use super::{cases, number};
use crate::common::*;
use eyebox::base::ids::SlideId;
use eyebox::base::stats::Moments;
use eyebox::check::check;
use eyebox::estimate::run::{Limits, run};
use eyebox::film::plan::Estimator;
use eyebox::plan::{Choice, plan};
use eyebox::scene::*;
use eyebox::world::World;
use eyebox::world::gauss::GaussLobe;
use glam::DVec3;
use std::sync::Arc;

const BACKWARD: Choice = Choice::Only(Estimator::Backward);
const PHOTON: Choice = Choice::Only(Estimator::Photon);

/// Mean luminance of the picture over `runs` seeds, and its standard error from how they scatter.
fn luminance(scene: &Scene, choice: Choice, passes: u64, runs: u64) -> (f64, f64) {
    let checked = check(scene).expect("the scene is sound");
    let world = World::freeze(scene).expect("the scene can be traced");
    let plan = plan(&checked, &world, choice);
    let limits = Limits { passes: Some(passes), ..Limits::default() };
    let mut seeds = Moments::default();
    for seed in 0..runs {
        let films = run(&world, &plan, scene.groups.len(), scene.eye.resolution, seed, &limits, &mut ()).films;
        seeds.add(mean(&image(&films)).0);
    }
    (seeds.mean, seeds.stderr())
}

/// Within 4 standard errors, which must be below `noise` of the value.
fn assert_traced(name: &str, (got, sigma): (f64, f64), want: f64, noise: f64) {
    println!("{name}: {got:.6e} want {want:.6e}: off {:+.1e}, noise {:.1e}", got / want - 1.0, sigma / want);
    assert!(sigma <= noise * want, "{name}: noise {sigma} of {want}");
    assert!((got - want).abs() <= 4.0 * sigma + 1e-6 * want, "{name}: {got} ± {sigma}, want {want}");
}

/// A black square of half side `half` that emits along `normal`, seen from both sides.
fn panel(s: &mut Scene, at: DVec3, [a, b]: [DVec3; 2], emitter: Emitter) {
    let mut face = face(Finish::Absorber);
    face.emitter = Some(emitter);
    add_part(s, "panel", mesh(&[quad(DVec3::ZERO, a, b)]), at, None, vec![face]);
}

/// A sphere of radius 0.1 m seen from inside, its cap towards −z with the share `port` of the area black.
fn integrating_sphere(rho: f64, port: f64) -> Scene {
    let mut s = scene();
    let (radius, around) = (0.1, 192);
    let rim = (1.0 - 2.0 * port).acos();
    let mut wall = Mesh { name: "wall".to_owned(), ..Mesh::default() };
    let mut faces = Vec::new();
    let mut zone = |from: f64, to: f64, rings: u32, finish: Finish| {
        let base = wall.positions.len() as u32;
        let first = wall.triangles.len() as u32;
        for ring in 0..=rings {
            let (sin, cos) = (from + (to - from) * f64::from(ring) / f64::from(rings)).sin_cos();
            for k in 0..around {
                let (y, x) = (std::f64::consts::TAU * f64::from(k) / f64::from(around)).sin_cos();
                let normal = DVec3::new(sin * x, sin * y, -cos);
                wall.positions.push((normal * radius).as_vec3().to_array());
                wall.normals.push(normal.as_vec3().to_array());
            }
        }
        for ring in 0..rings {
            for k in 0..around {
                let (a, b) = (base + ring * around + k, base + ring * around + (k + 1) % around);
                wall.triangles.extend([[a, b + around, b], [a, a + around, b + around]]);
            }
        }
        wall.faces.push(FaceRange { first, count: wall.triangles.len() as u32 - first });
        let mut zone = face(finish);
        zone.shape = ball_shape(radius);
        faces.push(zone);
    };
    if port > 0.0 {
        zone(0.0, rim, 24, Finish::Absorber);
    }
    zone(rim, std::f64::consts::PI, 96, Finish::Lambert { reflectance: rho, transmittance: 0.0 });
    add_part(&mut s, "sphere", wall, DVec3::ZERO, None, faces);
    // A pinhole, which takes no light from the sphere, before the wall opposite the port.
    s.eye.position = DVec3::Z * 0.05;
    s.eye.look = DVec3::Z;
    s.eye.pupil_diameter_m = 0.0;
    s.eye.fov_deg = 90.0;
    s.eye.resolution = [4, 4];
    s
}

long! {
#[test]
fn integrating_spheres() {
    for case in cases("int_sphere") {
        let (p, r) = (&case["params"], &case["result"]);
        let (flux, rho, port) = (number(&p["flux"]), number(&p["rho"]), number(&p["port_fraction"]));
        assert_eq!(number(&p["r"]), 100.0);
        // The source in the centre: a white ball that shines alike into all directions and takes nothing.
        let mut s = integrating_sphere(rho, port);
        let group = add_group(&mut s, "source");
        let mut ball = face(Finish::Lambert { reflectance: 1.0, transmittance: 0.0 });
        let photometry = Photometry::FluxLm(flux);
        ball.emitter = Some(Emitter {
            group,
            photometry,
            angular: Angular::Lambert,
            spectrum: None,
            polarisation: None,
            both_sides: false,
            pattern: None,
        });
        add_part(&mut s, "source", sphere_mesh(5e-4, 24, 48), DVec3::ZERO, None, vec![ball]);
        let got = luminance(&s, BACKWARD, 512, 16);
        assert_traced(&format!("{} centre", case["id"]), got, number(&r["L_wall_centre_source"]), 2e-3);
        // A narrow beam on the wall, the wall seen elsewhere: light scattered twice or more, gathered from photons.
        let mut s = integrating_sphere(rho, port);
        let group = add_group(&mut s, "beam");
        let beam = Emitter {
            group,
            photometry,
            angular: Angular::CosN { n: 1e4 },
            spectrum: None,
            polarisation: None,
            both_sides: false,
            pattern: None,
        };
        let half = 1e-4;
        panel(&mut s, DVec3::new(-0.05, 0.0, 0.0), [DVec3::Z * half, DVec3::Y * half], beam);
        // Few pixels: the first radius is their distance, and a gathering over half the sphere's radius is still exact.
        s.eye.resolution = [2, 2];
        let got = luminance(&s, PHOTON, 1, 8);
        assert_traced(&format!("{} far from the spot", case["id"]), got, number(&r["L_far_from_spot"]), 4e-3);
    }
}
}

fn furnace(kind: &str) -> serde_json::Value {
    cases("furnace").into_iter().find(|case| case["params"]["kind"] == kind).expect("the case is in the table")
}

/// Inside a glass ball in a uniform sky the luminance is n²L₀. What a white patch in its centre makes of it is seen
/// through the ball: the light that arrives there is T n²L₀ and R times what the patch sends back to itself, and
/// T/n² of what the patch sends comes out, beside R of the sky.
#[test]
fn furnace_inside_a_dielectric() {
    let case = furnace("inside_dielectric");
    let (p, inside) = (&case["params"], number(&case["result"]["L"]));
    let (sky, n, rho) = (number(&p["L0"]), number(&p["n"]), 0.7);
    let mut s = scene();
    uniform_sky(&mut s, sky as f32);
    let mut ball = face(Finish::Polished);
    ball.shape = ball_shape(0.01);
    add_part(&mut s, "ball", sphere_mesh(0.01, 32, 64), DVec3::NEG_Z * 0.1, Some(n), vec![ball]);
    let half = 5e-5;
    let patch = face(Finish::Lambert { reflectance: rho, transmittance: 0.0 });
    let square = mesh(&[quad(DVec3::ZERO, DVec3::X * half, DVec3::Y * half)]);
    add_part(&mut s, "patch", square, DVec3::NEG_Z * 0.1, None, vec![patch]);
    s.eye.pupil_diameter_m = 0.0;
    s.eye.resolution = [2, 2];
    s.eye.fov_deg = 0.02;
    let reflected = ((n - 1.0) / (n + 1.0)).powi(2);
    let through = 1.0 - reflected;
    let want = through / (n * n) * rho * through * inside / (1.0 - reflected * rho) + reflected * sky;
    assert_traced("furnace_4", luminance(&s, BACKWARD, 4096, 8), want, 1e-3);
}

/// Two planes that are 10³ times wider than their distance: what escapes at their rims is h²/a² = 4e-6 of the light.
/// Points that are sampled on so wide a lamp bring 2e-3 of the light, and as seldom as that, so the error is taken from
/// many seeds: that of a few is itself uncertain.
#[test]
fn furnace_between_planes() {
    let case = furnace("parallel_planes");
    let (p, r) = (&case["params"], &case["result"]);
    let mut s = scene();
    let group = add_group(&mut s, "plane");
    let (half, gap) = (5.0, 0.01);
    for (name, z, rho) in [("one", 0.0, number(&p["rho1"])), ("two", gap, number(&p["rho2"]))] {
        let mut plane = face(Finish::Lambert { reflectance: rho, transmittance: 0.0 });
        if name == "one" {
            plane.emitter = lamp(group, number(&p["M1"]) / std::f64::consts::PI);
        }
        let square = mesh(&[quad(DVec3::ZERO, DVec3::X * half, DVec3::Y * half)]);
        add_part(&mut s, name, square, DVec3::Z * z, None, vec![plane]);
    }
    s.eye.position = DVec3::Z * gap / 2.0;
    s.eye.pupil_diameter_m = 0.0;
    s.eye.resolution = [4, 4];
    for (look, key) in [(DVec3::NEG_Z, "M_radiosity_1"), (DVec3::Z, "M_radiosity_2")] {
        s.eye.look = look;
        let want = number(&r[key]) / std::f64::consts::PI;
        assert_traced(&format!("furnace_5 {key}"), luminance(&s, BACKWARD, 512, 32), want, 1e-3);
    }
}

/// A lamp under the flat face of a block, seen from the air under an angle: L₂ = T (n₂/n₁)² L₁. The row that goes from
/// air into glass is traced against the light, for which T is the same and the squares change places.
#[test]
fn luminance_across_an_interface() {
    for case in cases("refract_L") {
        let (p, r) = (&case["params"], &case["result"]);
        let (l, n1, n2) = (number(&p["L"]), number(&p["n1"]), number(&p["n2"]));
        for (k, angle) in p["angles"].as_array().expect("a list").iter().enumerate() {
            let (dense, in_air, want) = match n1 > n2 {
                true => (n1, number(&r["theta_t"][k]), number(&r["L_transmitted"][k])),
                false => (n2, number(angle), number(&r["L_transmitted"][k]) / (n2 * n2 * n2 * n2)),
            };
            let mut s = scene();
            let group = add_group(&mut s, "lamp");
            let block = mesh(&cuboid(DVec3::new(2.0, 2.0, 0.5)));
            let faces = vec![face(Finish::Polished); 6];
            add_part(&mut s, "block", block, DVec3::NEG_Z * 0.5, Some(dense), faces);
            let emitter = lamp(group, l).expect("a lamp");
            panel(&mut s, DVec3::NEG_Z * 0.4, [DVec3::X * 1.9, DVec3::Y * 1.9], emitter);
            let (sin, cos) = in_air.to_radians().sin_cos();
            s.eye.position = DVec3::new(-sin, 0.0, cos) * 0.1;
            s.eye.look = DVec3::new(sin, 0.0, -cos);
            s.eye.pupil_diameter_m = 0.0;
            s.eye.resolution = [1, 1];
            // So narrow that T does not change over the pixel.
            s.eye.fov_deg = 1e-4;
            assert_traced(&format!("{} at {angle}°", case["id"]), luminance(&s, BACKWARD, 16, 4), want, 1e-6);
        }
    }
}

/// A panel with parallel light, a slide, a projector's transmittance, a diffuser with gain, two mirrors, a combiner.
#[test]
fn chain_of_an_idealised_hud() {
    for case in cases("hud_chain") {
        let (p, r) = (&case["params"], &case["result"]);
        let mm = |key: &str| number(&p[key]) * 1e-3;
        let half = [DVec3::X * mm("screen_w_mm") / 2.0, DVec3::Z * mm("screen_h_mm") / 2.0];
        let mut s = scene();
        // The lobe falls off across the field: by 5e-4 in the mean over 1.8°.
        s.eye.fov_deg = 0.4;
        s.eye.resolution = [4, 4];
        let group = add_group(&mut s, "projector");
        let sheet = |s: &mut Scene, name: &str, at: DVec3, [a, b]: [DVec3; 2], what: Face| {
            add_part(s, name, mesh(&[quad(DVec3::ZERO, a, b)]), at, None, vec![what]);
        };
        // The mirrors turn the eye's −z to +y, to −z, to +y.
        let across = [DVec3::X * 0.06, DVec3::new(0.0, 0.06, -0.06)];
        let mirrors = [number(&p["combiner_R"]), number(&p["mirrors_R"][0]), number(&p["mirrors_R"][1])];
        let places = [DVec3::new(0.0, 0.0, -0.2), DVec3::new(0.0, 0.2, -0.2), DVec3::new(0.0, 0.2, -0.4)];
        for (reflectance, at) in mirrors.into_iter().zip(places) {
            sheet(&mut s, "mirror", at, across, face(Finish::MirrorIdeal { reflectance }));
        }
        // The lobe whose luminance along the axis is G τE/π (formula sheet, section 10), with what it hands back of the light that it loses.
        let along = |lobe: GaussLobe| lobe.norm() + lobe.rest([lobe.lost(1.0); 2]);
        let gain = |sigma: f64| GaussLobe::new(sigma).map_or(0.0, |lobe| along(lobe) * std::f64::consts::PI);
        let (mut narrow, mut wide) = (0.05, 1.0);
        for _ in 0..60 {
            let middle: f64 = (narrow + wide) / 2.0;
            if gain(middle) > number(&p["gain"]) { narrow = middle } else { wide = middle }
        }
        let (sigma_deg, transmittance) = (f64::to_degrees(narrow), number(&p["tau_diff"]));
        let diffuser = Finish::Gauss { sigma_deg, reflectance: 0.0, transmittance };
        sheet(&mut s, "diffuser", DVec3::new(0.0, 0.4, -0.4), half, face(diffuser));
        for (place, transmittance, contrast) in
            [(0.405, number(&p["proj_T"]), 1.0), (0.41, number(&p["lcd_T"]), number(&p["lcd_contrast"]))]
        {
            s.slides.push(Slide {
                name: "slide".to_owned(),
                file: "none".to_owned(),
                width: 1,
                height: 1,
                pixels: Arc::new(vec![1.0]),
                rgb: None,
                centre: DVec3::ZERO,
                u: DVec3::X,
                v: DVec3::Z,
                size: [mm("screen_w_mm") * 1.01, mm("screen_h_mm") * 1.01],
                transmittance,
                contrast,
                polarisation: None,
                primaries: None,
            });
            let mut slide = face(Finish::None);
            slide.slide = Some(SlideId::from_index(s.slides.len() - 1));
            sheet(&mut s, "slide", DVec3::new(0.0, place, -0.4), half.map(|a| a * 1.01), slide);
        }
        let photometry = Photometry::FluxLm(number(&p["flux_lm"]) * number(&p["eta_coll"]));
        let parallel = Emitter {
            group,
            photometry,
            angular: Angular::CosN { n: 1e7 },
            spectrum: None,
            polarisation: None,
            both_sides: false,
            pattern: None,
        };
        panel(&mut s, DVec3::new(0.0, 0.415, -0.4), half, parallel);
        for (value, key) in [(1.0, "L_virtual"), (0.0, "L_black")] {
            s.slides[1].pixels = Arc::new(vec![value]);
            let got = luminance(&s, Choice::Auto, 6, 12);
            assert_traced(&format!("{} {key}", case["id"]), got, number(&r[key]), 3e-3);
        }
    }
}
