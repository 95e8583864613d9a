use super::*;
use eyebox_base::ids::MeshId;
use eyebox_base::rng::{Rng, Stream};
use eyebox_base::stats::Moments;
use eyebox_base::warp::Frame;
use eyebox_scene::{Eye, Face, FaceRange, Finish, Mesh, Shape, Wavelengths};
use glam::DMat3;
use std::f64::consts::PI;

/// A scene with one rectangular lamp (2 × 1 mesh units, facing +z) per emitter, each a part of its own.
fn scene(emitters: &[(Photometry, Angular)]) -> Scene {
    let mesh = Mesh {
        name: "panel".into(),
        positions: vec![[0.0; 3], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        faces: vec![FaceRange { first: 0, count: 2 }],
        ..Mesh::default()
    };
    let part = |&(photometry, angular): &(Photometry, Angular)| Part {
        name: "led".into(),
        path: "HUD/led".into(),
        mesh: MeshId(0),
        to_world: DAffine3::IDENTITY,
        medium: None,
        priority: 0,
        materials: Vec::new(),
        film_in: None,
        faces: vec![Face {
            finish: Finish::Absorber,
            coating: None,
            shape: Shape::Mesh,
            emitter: Some(Emitter {
                group: GroupId(0),
                photometry,
                angular,
                spectrum: None,
                polarisation: None,
                both_sides: false,
                pattern: None,
            }),
            tint: None,
            slide: None,
            sensor: None,
        }],
    };
    Scene {
        name: "lamps".into(),
        unit_m: 1.0,
        wavelengths: Wavelengths::Visible,
        meshes: vec![mesh.into()],
        parts: emitters.iter().map(part).collect(),
        media: vec![],
        coatings: vec![],
        slides: vec![],
        scatters: vec![],
        wave_plates: vec![],
        gratings: vec![],
        surfaces: vec![],
        profiles: Vec::new(),
        groups: vec![],
        lights: Vec::new(),
        sky: None,
        eye: Eye {
            position: DVec3::ZERO,
            look: DVec3::NEG_Z,
            up: DVec3::Y,
            pupil_diameter_m: 0.004,
            adapts: false,
            limits: eyebox_scene::BinocularLimits::default(),
            focus_distance_m: f64::INFINITY,
            fov_deg: 10.0,
            resolution: [1, 1],
            age: 30.0,
        },
        notes: vec![],
        hash: String::new(),
    }
}

fn build(emitters: &[(Photometry, Angular)]) -> Result<Lamps> {
    Lamps::build(&scene(emitters), &|_| DAffine3::from_scale(DVec3::splat(1e-3)))
}

#[test]
fn the_three_photometries_describe_one_lamp() {
    for (angular, n) in [(Angular::Lambert, 1.0), (Angular::CosN { n: 20.0 }, 20.0), (Angular::CosN { n: 0.0 }, 0.0)] {
        let flux = 80.0;
        let i0 = flux * (n + 1.0) / (2.0 * PI);
        let l0 = i0 / 2e-6;
        for photometry in [Photometry::FluxLm(flux), Photometry::LuminanceCdM2(l0), Photometry::IntensityCd(i0)] {
            let lamps = build(&[(photometry, angular)]).unwrap();
            let lamp = &lamps.all()[0];
            assert!((lamp.area_m2 / 2e-6 - 1.0).abs() < 1e-12);
            assert!((lamp.flux_lm / flux - 1.0).abs() < 1e-12 && (lamp.intensity_cd / i0 - 1.0).abs() < 1e-12);
            assert!((lamp.luminance(1.0) / l0 - 1.0).abs() < 1e-12);
            assert_eq!(lamp.luminance(0.0), 0.0);
            assert_eq!(lamp.luminance(-0.5), 0.0);
            assert_eq!(lamp.luminance(f64::NAN), 0.0);
            // Directions weighted by luminance · cos · area / (density · flux) must average to 1 with no scatter.
            let mut rng = Rng::new(1, Stream::Check, 0, 0);
            for _ in 0..100 {
                let cos = lamp.sample_direction(DVec3::X, rng.pair()).x;
                let carried = lamp.luminance(cos) * cos * lamp.area_m2 / lamp.direction_pdf(cos);
                assert!((carried / flux - 1.0).abs() < 1e-9, "n {n}, cos {cos}: {carried}");
            }
        }
    }
}

#[test]
fn directions_have_the_mean_cosine_of_their_intensity() {
    for (angular, n) in [(Angular::Lambert, 1.0f64), (Angular::CosN { n: 20.0 }, 20.0), (Angular::CosN { n: 0.0 }, 0.0)]
    {
        let lamps = build(&[(Photometry::FluxLm(1.0), angular)]).unwrap();
        let normal = DVec3::new(0.6, -0.8, 0.0);
        let (mut rng, mut mean) = (Rng::new(2, Stream::Check, 0, n as u64), Moments::default());
        (0..100_000).for_each(|_| mean.add(lamps.all()[0].sample_direction(normal, rng.pair()).dot(normal)));
        assert!((mean.mean - (n + 1.0) / (n + 2.0)).abs() < 4.0 * mean.stderr(), "n {n}: {}", mean.mean);
    }
}

#[test]
fn points_are_uniform_and_normals_point_outwards_under_mirroring() {
    let mirror = DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(-3.0, 1.0, 1.0)));
    for (to_world, x_mean) in [(DAffine3::IDENTITY, 1.0), (mirror, -3.0)] {
        let lamps = Lamps::build(&scene(&[(Photometry::FluxLm(1.0), Angular::Lambert)]), &|_| to_world).unwrap();
        let lamp = &lamps.all()[0];
        let (mut rng, mut x, mut y, mut second) = (Rng::new(3, Stream::Check, 0, 0), [0.0; 2], 0.0, 0.0);
        let count = 100_000;
        for _ in 0..count {
            let point = lamp.sample_point(rng.pair());
            // A mirrored panel is still outside on +z, though its winding is the other way round.
            assert_eq!(point.normal, DVec3::Z);
            x[0] += point.position.x / count as f64;
            x[1] += point.position.x.powi(2) / count as f64;
            y += point.position.y / count as f64;
            second += f64::from(point.triangle) / count as f64;
        }
        assert!((x[0] / x_mean - 1.0).abs() < 0.01 && (x[1] / x_mean.powi(2) - 4.0 / 3.0).abs() < 0.02, "{x:?}");
        assert!((y - 0.5).abs() < 0.005 && (second - 0.5).abs() < 0.01);
    }
}

#[test]
fn impossible_lamps_are_faults_that_name_their_part() {
    let bad = [
        (Photometry::FluxLm(-1.0), Angular::Lambert),
        (Photometry::LuminanceCdM2(f64::NAN), Angular::Lambert),
        (Photometry::IntensityCd(f64::INFINITY), Angular::Lambert),
        (Photometry::IntensityCd(1e308), Angular::Lambert),
        (Photometry::FluxLm(1.0), Angular::CosN { n: -0.5 }),
        (Photometry::FluxLm(1.0), Angular::CosN { n: f64::INFINITY }),
    ];
    for emitter in bad {
        let text = build(&[emitter]).unwrap_err().to_string();
        assert!(text.starts_with("part HUD/led face 0: the emitter's"), "{text}");
    }
    let good = (Photometry::FluxLm(1.0), Angular::Lambert);
    let flat = Lamps::build(&scene(&[good]), &|_| DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0))).unwrap_err();
    assert!(flat.to_string().contains("has no area"), "{flat}");
    let nan = Lamps::build(&scene(&[good]), &|_| DAffine3::from_scale(DVec3::splat(f64::NAN))).unwrap_err();
    assert!(nan.to_string().contains("has no area"), "{nan}");
    let mut torn = scene(&[good]);
    torn.meshes[0].faces[0].count = u32::MAX;
    assert!(Lamps::build(&torn, &|_| DAffine3::IDENTITY).is_err());
    torn.meshes[0].faces[0].count = 2;
    torn.meshes[0].triangles[1][2] = 77;
    assert!(Lamps::build(&torn, &|_| DAffine3::IDENTITY).is_err());
}

/// 49 lamps in a row, 3 units apart, every seventh of them off.
#[test]
fn lamps_are_picked_with_their_probabilities() {
    let emitters: Vec<_> = (0..49)
        .map(|k| (Photometry::FluxLm(if k % 7 == 3 { 0.0 } else { 1.0 + k as f64 }), Angular::Lambert))
        .collect();
    let lamps =
        Lamps::build(&scene(&emitters), &|part| DAffine3::from_translation(DVec3::new(3.0 * part as f64, 0.0, 0.0)))
            .unwrap();
    assert_eq!(lamps.of_face(5, 0), Some(5));
    assert_eq!((lamps.of_face(5, 1), lamps.of_face(99, 0)), (None, None));
    let point = DVec3::new(20.0, 5.0, 6.0);
    let sum: f64 = (0..49).map(|k| lamps.pick_pdf(point, k)).sum();
    assert!((sum - 1.0).abs() < 1e-12, "{sum}");
    let count = 200_000;
    let (mut by_flux, mut by_point) = ([0.0; 49], [0.0; 49]);
    for k in 0..count {
        let u = (k as f64 + 0.5) / count as f64;
        let (index, probability) = lamps.pick_by_flux(u).unwrap();
        assert!((probability * lamps.total_flux_lm() - lamps.all()[index].flux_lm).abs() < 1e-9);
        by_flux[index] += 1.0 / count as f64;
        let (index, probability) = lamps.pick_for_point(point, u).unwrap();
        assert_eq!(probability, lamps.pick_pdf(point, index));
        by_point[index] += 1.0 / count as f64;
    }
    for (k, lamp) in lamps.all().iter().enumerate() {
        assert!((by_flux[k] - lamp.flux_lm / lamps.total_flux_lm()).abs() < 2e-5, "{k}");
        assert!((by_point[k] - lamps.pick_pdf(point, k)).abs() < 2e-5, "{k}");
        assert_eq!(by_point[k] == 0.0, lamp.flux_lm == 0.0, "{k}");
    }
    assert!(by_point[6] > 5.0 * by_flux[6] && by_point[48] < by_flux[48], "near lamps are preferred");
    let nowhere = DVec3::splat(f64::INFINITY);
    assert!(lamps.pick_for_point(nowhere, 0.999).is_some_and(|(k, p)| p == lamps.pick_pdf(nowhere, k) && p > 0.0));
}

#[test]
fn dark_or_no_lamps_give_no_pick() {
    for emitters in [vec![], vec![(Photometry::FluxLm(0.0), Angular::Lambert)]] {
        let lamps = build(&emitters).unwrap();
        assert_eq!((lamps.pick_by_flux(0.5), lamps.pick_for_point(DVec3::ZERO, 0.5)), (None, None));
        assert_eq!((lamps.pick_pdf(DVec3::ZERO, 0), lamps.total_flux_lm()), (0.0, 0.0));
    }
}

/// A profile for tests: 3 planes and 4 rings, nothing alike, with light behind too.
fn web() -> eyebox_scene::LuminousProfile {
    eyebox_scene::LuminousProfile {
        file: "w.ies".into(),
        axes: eyebox_scene::LuminousProfile::TYPE_C,
        c_rad: vec![0.0, 1.0, 3.5, 2.0 * PI],
        gamma_rad: vec![0.0, 0.4, 1.3, 2.5],
        candela: vec![9.0, 7.0, 2.0, 0.5, 9.0, 3.0, 1.0, 0.0, 9.0, 8.0, 5.0, 1.0, 9.0, 7.0, 2.0, 0.5],
        facts: Default::default(),
    }
}

/// Sums over a fine grid of directions: flux, density and luminance agree, and directions turn with u.
#[test]
fn beams_of_all_kinds_carry_their_flux() {
    let profile = eyebox_base::ids::ProfileId(0);
    let normal = DVec3::new(2.0, -1.0, 2.0) / 3.0;
    let front = web().front();
    for (photometry, angular, flux) in [
        (Photometry::FluxLm(3.0), Angular::Gauss { fwhm_deg: 20.0 }, Some(3.0)),
        (Photometry::IntensityCd(5.0), Angular::Gauss { fwhm_deg: 150.0 }, None),
        (Photometry::AsMeasured, Angular::Profile { profile, c0: DVec3::X }, Some(front.flux_lm())),
        (Photometry::FluxLm(2.0), Angular::Profile { profile, c0: DVec3::Y }, Some(2.0)),
        (Photometry::IntensityCd(18.0), Angular::Profile { profile, c0: DVec3::Y }, Some(2.0 * front.flux_lm())),
    ] {
        let mut scene = scene(&[(photometry, angular)]);
        scene.profiles.push(web());
        let lamps = Lamps::build(&scene, &|_| DAffine3::from_scale(DVec3::splat(1e-3))).unwrap();
        let lamp = &lamps.all()[0];
        if let Some(flux) = flux {
            assert!((lamp.flux_lm / flux - 1.0).abs() < 1e-12, "{photometry:?}: {}", lamp.flux_lm);
        }
        let frame = Frame::about(normal);
        let (rows, columns) = (600, 240);
        let (mut sum, mut density) = (0.0, 0.0);
        for row in 0..rows {
            for column in 0..columns {
                let (theta, phi) =
                    ((row as f64 + 0.5) / rows as f64 * PI / 2.0, (column as f64 + 0.5) / columns as f64 * 2.0 * PI);
                let ((st, ct), (sp, cp)) = (theta.sin_cos(), phi.sin_cos());
                let dir = frame.to_world(DVec3::new(st * cp, st * sp, ct));
                let weight = st * PI / 2.0 / rows as f64 * 2.0 * PI / columns as f64;
                sum += lamp.luminance_along(normal, dir) * ct * lamp.area_m2 * weight;
                density += lamp.density_along(normal, dir) * weight;
            }
        }
        assert!(
            (sum / lamp.flux_lm - 1.0).abs() < 2e-4 && (density - 1.0).abs() < 2e-4,
            "{angular:?}: {sum} {density}"
        );
        assert_eq!(lamp.luminance_along(normal, -normal), 0.0);
        // Every sampled path carries the flux.
        let mut rng = Rng::new(1, Stream::Check, 0, 0);
        for _ in 0..1000 {
            let dir = lamp.sample_direction(normal, rng.pair());
            let cos = dir.dot(normal);
            if cos > 1e-6 {
                let carried = lamp.luminance_along(normal, dir) * cos * lamp.area_m2 / lamp.density_along(normal, dir);
                assert!((carried / lamp.flux_lm - 1.0).abs() < 1e-9, "{angular:?} at {cos}: {carried}");
            }
        }
    }
    // The plane C0 is along u: on the face x, light of C = 0, γ = 0.4.
    let mut scene = scene(&[(Photometry::AsMeasured, Angular::Profile { profile, c0: DVec3::new(1.0, 0.0, 5.0) })]);
    scene.profiles.push(web());
    let lamps = Lamps::build(&scene, &|_| DAffine3::from_scale(DVec3::splat(1e-3))).unwrap();
    let lamp = &lamps.all()[0];
    let (sin, cos) = 0.4f64.sin_cos();
    // Seen from the front C turns clockwise: C = 1 rad is at −1 rad.
    for (turn, want) in [(0.0f64, 7.0), (-1.0, 3.0), (-3.5, 8.0)] {
        let dir = DVec3::new(sin * turn.cos(), sin * turn.sin(), cos);
        let intensity = lamp.luminance_along(DVec3::Z, dir) * cos * lamp.area_m2;
        assert!((intensity / want - 1.0).abs() < 1e-12, "{turn}: {intensity}");
    }
    assert!((lamp.luminance(cos) * cos * lamp.area_m2 - 7.0).abs() < 1e-12);
}
