//! Lamps that are no faces, against closed forms, through every estimator that meets them; and from the asset's lights.

use crate::common::*;
use eyebox::base::Where;
use eyebox::base::ids::ProfileId;
use eyebox::check::check;
use eyebox::estimate::picture::picture;
use eyebox::estimate::run::{Limits, run};
use eyebox::film::layer::Layer;
use eyebox::film::plan::{Estimator, Verdict};
use eyebox::import::{Assembly, build, photometric};
use eyebox::plan::{Choice, plan};
use eyebox::scene::assembly::{Camera, LightForm, LightProfile, LightSource, Node, ProfileSource};
use eyebox::scene::*;
use eyebox::world::World;
use glam::{DAffine3, DMat3, DVec3};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

const BACKWARD: Choice = Choice::Only(Estimator::Backward);
const FORWARD: Choice = Choice::Only(Estimator::Forward);
const RHO: f64 = 0.5;

/// A white screen in z = 0, seen from above at a small spot about the origin.
fn screen(pupil_diameter_m: f64) -> Scene {
    let mut s = scene();
    let white = face(Finish::Lambert { reflectance: RHO, transmittance: 0.0 });
    add_part(&mut s, "screen", mesh(&[quad(DVec3::ZERO, DVec3::X, DVec3::Y)]), DVec3::ZERO, None, vec![white]);
    s.eye.position = DVec3::Z * 0.5;
    s.eye.focus_distance_m = 0.5;
    s.eye.pupil_diameter_m = pupil_diameter_m;
    s.eye.fov_deg = 1e-3;
    s.eye.resolution = [2, 2];
    s
}

fn light(s: &mut Scene, form: BeaconForm) {
    let group = add_group(s, "light");
    s.lights.push(Beacon { name: "light".to_owned(), group, form, spectrum: None });
}

fn at(theta_deg: f64) -> DVec3 {
    let (sin, cos) = theta_deg.to_radians().sin_cos();
    DVec3::new(sin * 0.6, sin * 0.8, cos)
}

fn luminance(s: &Scene, choice: Choice, passes: u64) -> (f64, f64) {
    mean(&image(&render(s, choice, passes, 5).0))
}

fn assert_is(what: &str, (got, sigma): (f64, f64), want: f64, noise: f64) {
    println!("{what}: {got:.7e} want {want:.7e}: off {:+.1e}, noise {:.1e}", got / want - 1.0, sigma / want);
    assert!(sigma <= noise * want, "{what}: noise {sigma} of {want}");
    assert!((got - want).abs() <= 4.0 * sigma + 1e-6 * want, "{what}: {got} ± {sigma}, want {want}");
}

/// E = I cos θ/d², a spot's I by its angle; L = ρE/π.
#[test]
fn points_and_spots_light_a_screen() {
    let (distance, intensity_cd) = (0.3, 12.0);
    for theta in [0.0, 30.0, 70.0] {
        let mut s = screen(0.0);
        light(&mut s, BeaconForm::Point { position: at(theta) * distance, intensity_cd, spot: None });
        let e = intensity_cd * theta.to_radians().cos() / (distance * distance);
        assert_is(&format!("point at {theta}°"), luminance(&s, BACKWARD, 16), RHO * e / PI, 1e-5);
    }
    let (inner, outer) = (0.2f64, 0.5f64);
    for off in [0.0f64, 0.1, 0.25, 0.35, 0.45, 0.6] {
        // A spot above the origin whose axis is turned away by `off`.
        let mut s = screen(0.0);
        let spot = Some(SpotCone { axis: DVec3::new(off.sin(), 0.0, -off.cos()), inner_rad: inner, outer_rad: outer });
        light(&mut s, BeaconForm::Point { position: DVec3::Z * distance, intensity_cd, spot });
        let x = ((off.cos() - outer.cos()) / (inner.cos() - outer.cos())).clamp(0.0, 1.0);
        let want = RHO * intensity_cd * x * x / (distance * distance) / PI;
        let (got, _) = luminance(&s, BACKWARD, 4);
        // The pixel is 1e-5 rad wide, and the edge steep.
        assert!((got - want).abs() <= 1e-3 * want, "spot at {off}: {got}, want {want}");
    }
}

/// E cos θ, whether the light is parallel or fills a disc that stands above the horizon.
#[test]
fn distant_lamps_light_a_screen() {
    for angle_rad in [0.0f64, 0.0093, 0.8] {
        for theta in [0.0f64, 40.0, 60.0] {
            let mut s = screen(0.0);
            s.eye.resolution = [8, 8];
            light(&mut s, BeaconForm::Distant { dir: -at(theta), illuminance_lx: 800.0, angle_rad });
            let passes = 4096;
            let cos = theta.to_radians().cos();
            let want = RHO * 800.0 * cos / PI;
            let (got, mut sigma) = luminance(&s, BACKWARD, passes);
            if angle_rad == 0.0093 {
                // A scattered ray meets the disc with the chance of sin² of half its angle times cos θ, 2e-5, and then
                // brings the expected luminance: for a few hits the error that they make is known better than seen.
                let chance = (angle_rad / 2.0).sin().powi(2) * cos;
                sigma = sigma.hypot(want * (chance / (64 * passes) as f64).sqrt());
            }
            assert_is(&format!("distant at {theta}°, disc of {angle_rad}"), (got, sigma), want, 5e-3);
        }
    }
    // The disc itself: E/(π sin² of half its angle).
    let mut s = screen(0.0);
    s.eye.look = DVec3::Z;
    s.eye.fov_deg = 1.0;
    light(&mut s, BeaconForm::Distant { dir: DVec3::NEG_Z, illuminance_lx: 800.0, angle_rad: 0.1 });
    let (got, _) = luminance(&s, BACKWARD, 2);
    let want = 800.0 / (PI * 0.05f64.sin().powi(2));
    assert!((got / want - 1.0).abs() < 1e-12, "{got} {want}");
}

/// Ω of the square of half side `half` in z = 0 about the origin, seen from a point above it: four corners of
/// atan(xy/(h d)), sr.
fn solid_angle_of_square(half: f64, from: DVec3) -> f64 {
    let corner = |x: f64, y: f64| (x * y / (from.z * DVec3::new(x, y, from.z).length())).atan();
    let (left, right) = (-half - from.x, half - from.x);
    let (low, high) = (-half - from.y, half - from.y);
    corner(right, high) - corner(left, high) - corner(right, low) + corner(left, low)
}

/// Light tracing into a wide pupil that is focused on the screen: the mean of E over the square that is seen. The view
/// is wide because few of the paths that light the screen would come through a narrow one.
#[test]
fn forward_finds_the_closed_forms() {
    let place = at(60.0) * 0.6;
    let (inner, outer) = (0.1f64, 0.3f64);
    let spot = Some(SpotCone { axis: -at(20.0), inner_rad: inner, outer_rad: outer });
    let half = 0.5 * 20f64.to_radians().tan();
    let area = 4.0 * half * half;
    // A spot of which all falls into view, and distant lamps from where the pupil's shadow does not.
    let spot_flux = 10.0 * 2.0 * PI * (1.0 - inner.cos() + (inner.cos() - outer.cos()) / 3.0);
    let distant = |angle_rad| BeaconForm::Distant { dir: -at(60.0), illuminance_lx: 30.0, angle_rad };
    let forms = [
        (
            "point",
            BeaconForm::Point { position: place, intensity_cd: 10.0, spot: None },
            10.0 * solid_angle_of_square(half, place) / area,
        ),
        ("spot", BeaconForm::Point { position: at(20.0) * 0.3, intensity_cd: 10.0, spot }, spot_flux / area),
        ("parallel", distant(0.0), 15.0),
        ("disc", distant(0.2), 15.0),
    ];
    for (name, form, e) in forms {
        let mut s = screen(0.4);
        s.eye.fov_deg = 40.0;
        light(&mut s, form);
        assert_is(&format!("{name} forward"), luminance(&s, FORWARD, 1600), RHO * e / PI, 1e-2);
    }
}

/// Where nothing shines, or nothing that shines can be brought to the eye, the picture is black and has its size.
#[test]
fn without_light_the_picture_is_black() {
    let dark = screen(0.004);
    let mut unseen = screen(0.0);
    light(&mut unseen, BeaconForm::Point { position: DVec3::Z, intensity_cd: 1.0, spot: None });
    for (s, choice, said) in [
        (&dark, Choice::Auto, "nothing emits"),
        (&dark, FORWARD, "nothing emits"),
        (&unseen, FORWARD, "no estimator can bring"),
    ] {
        let checked = check(s).expect("the scene is sound");
        let world = World::freeze(s).expect("it can be traced");
        let plan = plan(&checked, &world, choice);
        assert!(plan.notes.iter().any(|note| note.contains(said)), "{:?}", plan.notes);
        // No limit is needed where nothing changes.
        let outcome = run(&world, &plan, s.groups.len(), [2, 2], 1, &Limits::default(), &mut ());
        let frame = picture(s, &plan, &outcome, Default::default()).expect("a picture").frame;
        assert_eq!((frame.width, frame.height), (2, 2));
        assert!(frame.channels.iter().any(|channel| channel.name == "hybrid.R"));
        assert!(frame.channels.iter().all(|channel| channel.data == [0.0; 4]), "{:?}", frame.channels);
    }
}

/// Light that reaches the screen by a mirror alone, gathered from photons: E of the image, the mirror's share of it.
#[test]
fn photons_come_off_a_mirror() {
    let below = DVec3::new(0.3, 0.0, -0.1);
    let image_at = DVec3::new(0.3, 0.0, 2.1);
    let up = at(20.0) * DVec3::new(-1.0, -1.0, 1.0);
    let forms = [
        (
            BeaconForm::Point { position: below, intensity_cd: 10.0, spot: None },
            10.0 * image_at.z / image_at.length().powi(3),
        ),
        (BeaconForm::Distant { dir: up, illuminance_lx: 20.0, angle_rad: 0.0 }, 20.0 * up.z),
        (BeaconForm::Distant { dir: up, illuminance_lx: 20.0, angle_rad: 0.1 }, 20.0 * up.z),
    ];
    for (form, e) in forms {
        let mut s = screen(0.0);
        s.eye.fov_deg = 10.0;
        s.parts[0].to_world = DAffine3::from_scale(DVec3::splat(0.25));
        let mirror = face(Finish::MirrorIdeal { reflectance: 0.75 });
        let plane = mesh(&[quad(DVec3::ZERO, DVec3::X, DVec3::Y)]);
        add_part(&mut s, "mirror", plane, DVec3::Z, None, vec![mirror]);
        light(&mut s, form.clone());
        let (films, plan) = render(&s, Choice::Auto, 48, 5);
        let visible = matches!(form, BeaconForm::Distant { angle_rad, .. } if angle_rad > 0.0);
        assert_eq!(plan.notes.iter().any(|note| note.contains("no luminance")), !visible, "{:?}", plan.notes);
        assert_eq!(matches!(plan.rows[0].verdict, Verdict::Skip { .. }), !visible, "{:?}", plan.rows[0]);
        // What the screen sends to itself by the mirror is `secondary`, 0.7 % of it.
        let (_, film, _) = films.films.iter().find(|(owner, _, _)| *owner == Estimator::Photon).expect("photons");
        let plane = film.planes.iter().position(|key| key.layer == Layer::Caustic).expect("a caustic");
        let caustic: Vec<(f64, f64)> =
            (0..4).map(|pixel| (film.mean(pixel, plane).value, film.variance(pixel, plane))).collect();
        assert_is(&format!("photons of {form:?}"), mean(&caustic), 0.75 * RHO * e / PI, 2e-2);
    }
}

fn oracle(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/07_ies/good").join(name)
}

fn profile(name: &str) -> LuminousProfile {
    photometric::profile(&oracle(name), &Where::Nowhere, &mut Vec::new()).expect("a good file")
}

/// E = I(C, γ) cos θ/d² with the probes of the oracle: the lamp is turned so that the screen's middle lies at (C, γ).
#[test]
fn measured_points_light_a_screen() {
    let distance = 0.4;
    for name in ["full_0_360_irregular.ies", "isym3.ldt", "bilateral_0_180.ies"] {
        for (c, gamma) in [(0.0f64, 0.0f64), (45.0, 22.5), (200.0, 45.0), (330.0, 60.0), (100.0, 37.0)] {
            let mut s = screen(0.0);
            s.profiles.push(profile(name));
            let ((sin_c, cos_c), (sin, cos)) = (c.to_radians().sin_cos(), gamma.to_radians().sin_cos());
            // The lamp's direction (C, γ) in its own frame, turned onto −z; then as far as it goes into any axes.
            let own = DVec3::new(sin * cos_c, sin * sin_c, -cos);
            let axes = DMat3::from_quat(glam::DQuat::from_rotation_arc(own, -at(30.0)));
            let form = BeaconForm::Profile { position: at(30.0) * distance, axes, profile: ProfileId(0), factor: 2.5 };
            light(&mut s, form);
            let intensity = 2.5 * s.profiles[0].value(c.to_radians(), gamma.to_radians());
            let want = RHO * intensity * 30f64.to_radians().cos() / (distance * distance) / PI;
            let (got, _) = luminance(&s, BACKWARD, 4);
            // The pixel is 1e-5 rad wide, and the intensity not constant over it.
            assert!((got - want).abs() <= 1e-4 * want, "{name} at ({c}, {gamma}): {got}, want {want}");
        }
    }
}

/// A small square that emits by a profile lights the screen as the profile says, from the lamp's side and, for one that
/// is the same all round, from the eye's.
#[test]
fn measured_faces_light_a_screen() {
    let (side, height) = (0.004, 0.5);
    for (name, photometry, choice) in [
        ("axial_2002.ies", Photometry::AsMeasured, BACKWARD),
        ("axial_2002.ies", Photometry::FluxLm(10.0), BACKWARD),
        ("axial_2002.ies", Photometry::AsMeasured, FORWARD),
        ("full_0_360_irregular.ies", Photometry::AsMeasured, FORWARD),
    ] {
        // Wide, as for the other lamps, because few of the paths that light the screen would come through a narrow pupil.
        let mut s = screen(if choice == FORWARD { 0.2 } else { 0.0 });
        s.eye.fov_deg = 30.0;
        s.profiles.push(profile(name));
        let mut lamp = face(Finish::Absorber);
        let group = add_group(&mut s, "light");
        let angular = Angular::Profile { profile: ProfileId(0), c0: DVec3::X };
        lamp.emitter = Some(Emitter {
            group,
            photometry,
            angular,
            spectrum: None,
            polarisation: None,
            both_sides: false,
            pattern: None,
        });
        // Faces down: u × v = −z.
        let down = quad(DVec3::ZERO, DVec3::Y * side / 2.0, DVec3::X * side / 2.0);
        let place = DVec3::new(-0.15, 0.05, height);
        add_part(&mut s, "lamp", mesh(&[down]), place, None, vec![lamp]);
        let whole = s.profiles[0].front().flux_lm();
        let scale = if let Photometry::FluxLm(flux) = photometry { flux / whole } else { 1.0 };
        let (got, sigma) = luminance(&s, choice, if choice == FORWARD { 300 } else { 1000 });
        // The mean of E over the square that is seen.
        let half = (s.eye.fov_deg / 2.0).to_radians().tan();
        let right = s.eye.look.cross(s.eye.up).normalize();
        let up = right.cross(s.eye.look);
        let (mut e, n) = (0.0, 40);
        for k in 0..n * n {
            let [x, y] = [k % n, k / n].map(|k| (2.0 * (f64::from(k) + 0.5) / f64::from(n) - 1.0) * half);
            let dir = s.eye.look + right * x + up * y;
            let point = s.eye.position - dir * (s.eye.position.z / dir.z);
            let away = point - place;
            let cos = -away.normalize().z;
            // C0 along +x of the world, C90 along x × n with n = −z: +y.
            let intensity = scale * s.profiles[0].along(away.normalize());
            e += intensity * cos / away.length_squared() / f64::from(n * n);
        }
        let want = RHO * e / PI;
        println!("{name} {photometry:?}: {got} ± {sigma}, want {want}");
        assert!(
            sigma < 0.02 * want && (got - want).abs() < 4.0 * sigma + 2e-3 * want,
            "{name}: {got} ± {sigma}, want {want}"
        );
    }
}

/// A sheet that shines from both sides, with its front away from the screen: each side has the luminance, or half of the flux.
#[test]
fn a_sheet_shines_from_its_back() {
    let (side, height, luminance_cd_m2) = (0.004, 0.5, 2e5);
    let flux = 2.0 * PI * luminance_cd_m2 * side * side;
    for (photometry, choice) in [
        (Photometry::LuminanceCdM2(luminance_cd_m2), BACKWARD),
        (Photometry::FluxLm(flux), BACKWARD),
        (Photometry::FluxLm(flux), FORWARD),
    ] {
        let mut s = screen(if choice == FORWARD { 0.2 } else { 0.0 });
        s.eye.fov_deg = 30.0;
        let mut lamp = face(Finish::Absorber);
        let group = add_group(&mut s, "light");
        let angular = Angular::Lambert;
        let light =
            Emitter { group, photometry, angular, spectrum: None, polarisation: None, both_sides: true, pattern: None };
        lamp.emitter = Some(light);
        let up = quad(DVec3::ZERO, DVec3::X * side / 2.0, DVec3::Y * side / 2.0);
        let place = DVec3::new(-0.15, 0.05, height);
        add_part(&mut s, "lamp", mesh(&[up]), place, None, vec![lamp]);
        let (got, sigma) = luminance(&s, choice, if choice == FORWARD { 300 } else { 1000 });
        // The mean of E over the square that is seen.
        let half = (s.eye.fov_deg / 2.0).to_radians().tan();
        let right = s.eye.look.cross(s.eye.up).normalize();
        let above = right.cross(s.eye.look);
        let (mut e, n) = (0.0, 40);
        for k in 0..n * n {
            let [x, y] = [k % n, k / n].map(|k| (2.0 * (f64::from(k) + 0.5) / f64::from(n) - 1.0) * half);
            let dir = s.eye.look + right * x + above * y;
            let point = s.eye.position - dir * (s.eye.position.z / dir.z);
            let away = point - place;
            let cos = -away.normalize().z;
            e += luminance_cd_m2 * side * side * cos * cos / away.length_squared() / f64::from(n * n);
        }
        let want = RHO * e / PI;
        println!("{photometry:?}: {got} ± {sigma}, want {want}");
        assert!(sigma < 0.02 * want && (got - want).abs() < 4.0 * sigma + 2e-3 * want, "{got} ± {sigma}, want {want}");
    }
}

/// A profile on a light of the asset: its candela times the factor; with `normalize` the light keeps its flux.
#[test]
fn profiles_of_an_assets_lights() {
    let own = |file: &str| LightProfile::of(ProfileSource::File(oracle(file)), 3.0);
    let mut source = asset(vec![
        ("a", LightForm::Point { intensity_cd: 3.0, cone: None }),
        ("b", LightForm::Point { intensity_cd: 3.0, cone: None }),
        ("c", LightForm::Disk { luminance_cd_m2: 3.0, radius: 2.0 }),
        ("d", LightForm::Rect { luminance_cd_m2: 3.0, width: 4.0, height: 3.0 }),
        ("e", LightForm::Sphere { luminance_cd_m2: 3.0, radius: 2.0 }),
    ]);
    for light in &mut source.lights {
        light.profile = Some(own("bilateral_0_180.ies"));
    }
    for index in [1, 3] {
        let profile = source.lights[index].profile.as_mut().expect("set above");
        profile.normalize = true;
    }
    let scene = build(source, None, &[]).expect("it is sound").scene;
    let world = World::freeze(&scene).expect("it can be traced");
    let measured = profile("bilateral_0_180.ies");
    let near = |got: f64, want: f64| assert!((got / want - 1.0).abs() < 1e-9, "{got} {want}");
    let lights: Vec<f64> = world.lights.all().iter().map(|light| light.flux_lm()).collect();
    let lamps: Vec<f64> = world.lamps.all().iter().map(|lamp| lamp.flux_lm).collect();
    near(lights[0], 3.0 * measured.flux_lm());
    near(lights[1], 3.0 * 4.0 * PI);
    near(lights[2], 3.0 * measured.flux_lm());
    near(lamps[0], 3.0 * measured.front().flux_lm());
    near(lamps[1], 3.0 * PI * 12e-4);
    assert_eq!((lights.len(), lamps.len()), (3, 2));
    assert!(scene.notes.iter().any(|note| note.text.contains("becomes a point")));
    assert!(scene.notes.iter().any(|note| note.text.contains("go backwards")));
    let BeaconForm::Profile { axes, .. } = scene.lights[0].form else { panic!("{:?}", scene.lights[0]) };
    assert_eq!(axes, DMat3::IDENTITY, "(0, 0) is −z, C0 +x");
}

/// Every lumen that lamps without faces emit is found again; the flux of each is its closed form.
#[test]
fn the_ledger_closes_with_lights() {
    let cone = SpotCone { axis: DVec3::NEG_Z, inner_rad: 0.3, outer_rad: 0.7 };
    let (ci, co) = (0.3f64.cos(), 0.7f64.cos());
    let point = |spot| BeaconForm::Point { position: DVec3::Z * 0.2, intensity_cd: 7.0, spot };
    let measured =
        BeaconForm::Profile { position: DVec3::Z * 0.2, axes: DMat3::IDENTITY, profile: ProfileId(0), factor: 1.0 };
    for (form, flux) in [
        (point(None), Some(7.0 * 4.0 * PI)),
        (point(Some(cone)), Some(7.0 * 2.0 * PI * (1.0 - ci + (ci - co) / 3.0))),
        (BeaconForm::Distant { dir: -at(30.0), illuminance_lx: 50.0, angle_rad: 0.1 }, None),
        // The oracle's flux of the file, to the seven digits that it has.
        (measured, Some(2527.33543)),
    ] {
        let mut s = screen(0.1);
        s.profiles.push(profile("full_0_360_irregular.ies"));
        let mut ball = face(Finish::Polished);
        ball.shape = ball_shape(0.05);
        add_part(&mut s, "ball", sphere_mesh(0.05, 24, 48), DVec3::Z * 0.1, Some(1.5), vec![ball]);
        light(&mut s, form.clone());
        let (films, _) = render(&s, FORWARD, 8, 3);
        let ledger = films.ledger(Estimator::Forward).expect("it ran");
        let sigma = ledger.imbalance_sigma().max(1e-12 * ledger.emitted);
        assert!(sigma < 1e-4 * ledger.emitted && ledger.imbalance().abs() <= 3.0 * sigma, "{form:?}: {ledger:?}");
        assert!(ledger.vertex_error <= 1e-12 && ledger.absorbed[0] > 0.0);
        let world = World::freeze(&s).expect("it can be traced");
        if let Some(flux) = flux {
            assert!((world.lights.all()[0].flux_lm() / flux - 1.0).abs() < 1e-9, "{form:?}");
        }
        // Guided paths carry that flux in the mean.
        let per_pass = ledger.emitted / 8.0 / world.lights.all()[0].flux_lm();
        assert!((per_pass - 1.0).abs() < 0.05, "{form:?}: {per_pass}");
    }
}

fn asset(lights: Vec<(&str, LightForm)>) -> Assembly {
    let lifted = DAffine3::from_translation(DVec3::Y * 2.0);
    let node = Node {
        name: "rig".to_owned(),
        path: "rig".to_owned(),
        parent: None,
        local: lifted,
        to_world: lifted,
        mesh: None,
        attributes: None,
        user: Vec::new(),
        at: Where::Nowhere,
    };
    let light = |(name, form): (&str, LightForm)| LightSource {
        name: name.to_owned(),
        node: 0,
        form,
        color: [1.0; 3],
        kelvin: None,
        profile: None,
        attributes: None,
        at: Where::Nowhere,
    };
    Assembly {
        unit_m: 0.01,
        nodes: vec![node],
        lights: lights.into_iter().map(light).collect(),
        cameras: vec![Camera {
            name: "eye".to_owned(),
            node: Some(0),
            to_world: DAffine3::IDENTITY,
            yfov: Some(0.5),
            aspect: Some(1.0),
            pupil: None,
            focus: None,
            frustum: Default::default(),
        }],
        ..Assembly::default()
    }
}

/// The lights of an asset: places and lengths in its units, strengths as they are.
#[test]
fn lights_of_an_asset() {
    let l = 30.0;
    let scene = build(
        asset(vec![
            ("Key 1", LightForm::Point { intensity_cd: 5.0, cone: Some((0.1, 0.2)) }),
            ("sun", LightForm::Distant { illuminance_lx: 9.0, angle: 0.01 }),
            ("rect", LightForm::Rect { luminance_cd_m2: l, width: 4.0, height: 3.0 }),
            ("disk", LightForm::Disk { luminance_cd_m2: l, radius: 2.0 }),
            ("ball", LightForm::Sphere { luminance_cd_m2: l, radius: 2.0 }),
            ("tube", LightForm::Cylinder { luminance_cd_m2: l, radius: 1.0, length: 5.0 }),
            ("2nd", LightForm::Dome { scale_cd_m2: 7.0, image: None }),
        ]),
        None,
        &[],
    )
    .expect("it is sound")
    .scene;
    let names: Vec<&str> = scene.groups.iter().map(|group| group.name.as_str()).collect();
    assert_eq!(names, ["Key_1", "sun", "rect", "disk", "ball", "tube", "light_2nd"]);
    let BeaconForm::Point { position, intensity_cd, spot: Some(spot) } = scene.lights[0].form else {
        panic!("{:?}", scene.lights[0])
    };
    assert!(position.distance(DVec3::Y * 0.02) < 1e-15 && intensity_cd == 5.0 && spot.axis == DVec3::NEG_Z);
    assert!(matches!(scene.lights[1].form, BeaconForm::Distant { dir: DVec3::NEG_Z, .. }));
    let world = World::freeze(&scene).expect("it can be traced");
    let areas = [12e-4, PI * 4e-4, 4.0 * PI * 4e-4, 2.0 * PI * 5e-4];
    for (lamp, area) in world.lamps.all().iter().zip(areas) {
        assert!((lamp.flux_lm / (PI * l * area) - 1.0).abs() < 1e-6, "{}: {}", lamp.part, lamp.flux_lm);
    }
    assert_eq!(world.lamps.all().len(), areas.len());
    let sky = world.sky.expect("the dome");
    assert!((sky.integral() / (4.0 * PI * 7.0) - 1.0).abs() < 1e-12);
}
