//! Displays that emit a picture: a slide on an emitting face, seen straight, as a lamp, from the eye and from the lamp.

use crate::common::*;
use eyebox::base::ids::SlideId;
use eyebox::film::plan::Estimator;
use eyebox::import::{ImportOptions, Set, import};
use eyebox::plan::Choice;
use eyebox::scene::*;
use eyebox::world::World;
use glam::DVec3;
use std::f64::consts::PI;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;

const BACKWARD: Choice = Choice::Only(Estimator::Backward);
const FORWARD: Choice = Choice::Only(Estimator::Forward);
const WHITE: f64 = 500.0;
const COLUMNS: usize = 8;
const ROWS: usize = 4;
/// Half sides of the display, m.
const HALF: [f64; 2] = [0.04, 0.02];

/// The picture's value of a pixel, none alike.
fn s_of(column: usize, row: usize) -> f64 {
    ((7 * (row * COLUMNS + column) + 3) % 32) as f64 / 31.0
}

/// What a slide of this transmittance and contrast makes of it.
fn luminance_of(slide: &Slide, s: f64) -> f64 {
    WHITE * slide.transmittance * (1.0 / slide.contrast + s * (1.0 - 1.0 / slide.contrast))
}

fn slide() -> Slide {
    let pixels = (0..COLUMNS * ROWS).map(|i| s_of(i % COLUMNS, i / COLUMNS) as f32).collect();
    Slide {
        name: "display".to_owned(),
        file: "display.png".to_owned(),
        width: COLUMNS,
        height: ROWS,
        pixels: Arc::new(pixels),
        rgb: None,
        centre: DVec3::ZERO,
        u: DVec3::X,
        v: DVec3::Y,
        size: HALF.map(|half| 2.0 * half),
        transmittance: 0.8,
        contrast: 50.0,
        polarisation: None,
        primaries: None,
    }
}

/// The display in z = 0, larger than its picture by a half, shining along +z; the eye looks down at it from 0.5 m.
fn display(pupil_diameter_m: f64) -> Scene {
    let mut s = scene();
    let group = add_group(&mut s, "display");
    s.slides.push(slide());
    let mut shining = face(Finish::Absorber);
    shining.emitter = lamp(group, WHITE);
    shining.slide = Some(SlideId::from_index(0));
    let polygon = quad(DVec3::ZERO, DVec3::X * 1.5 * HALF[0], DVec3::Y * 1.5 * HALF[1]);
    add_part(&mut s, "display", mesh(&[polygon]), DVec3::ZERO, None, vec![shining]);
    s.eye.position = DVec3::Z * 0.5;
    s.eye.focus_distance_m = 0.5;
    s.eye.pupil_diameter_m = pupil_diameter_m;
    s.eye.fov_deg = 2.0 * (1.5 * HALF[0] / 0.5f64).atan().to_degrees();
    s.eye.resolution = [3 * COLUMNS / 2, 3 * ROWS / 2];
    s
}

/// Each pixel of the eye is one of the display, or lies around its picture.
fn expected(i: usize) -> f64 {
    let (x, y) = (i % (3 * COLUMNS / 2), i / (3 * COLUMNS / 2));
    match (x.checked_sub(COLUMNS / 4), y.checked_sub(ROWS / 4)) {
        (Some(column), Some(row)) if column < COLUMNS && row < ROWS => luminance_of(&slide(), s_of(column, row)),
        (Some(_) | None, _) => 0.0,
    }
}

#[test]
fn each_pixel_has_the_luminance_of_its_own() {
    for (what, pupil, choice, passes) in
        [("pinhole", 0.0, BACKWARD, 4), ("pupil", 4e-3, BACKWARD, 16), ("from the lamp", 0.1, FORWARD, 64)]
    {
        let image = image(&render(&display(pupil), choice, passes, 3).0);
        assert_eq!(image.len(), 9 * COLUMNS * ROWS / 4);
        for (i, (got, variance)) in image.iter().enumerate() {
            let (want, sigma) = (expected(i), variance.sqrt());
            // The film's plane is that of the display, so that a pupil blurs nothing.
            assert!(
                (got - want).abs() <= 5.0 * sigma + 1e-6 * WHITE,
                "{what}, pixel {i}: {got} ± {sigma}, want {want}"
            );
        }
    }
}

/// A sample whose display is said in the emitter, and the same with a slide on the emitting face.
#[test]
fn an_emitters_image_is_the_slide_on_its_face() {
    let folder = tempfile::tempdir().unwrap();
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples/birdbath");
    for name in ["birdbath.glb", "picture.png"] {
        std::fs::copy(own.join(name), folder.path().join(name)).unwrap();
    }
    let text = std::fs::read_to_string(own.join("birdbath.optics.toml")).unwrap();
    let line = text.lines().find(|line| line.starts_with("emitter")).expect("a display");
    let (lamp, picture) = line.split_once(", image").expect("its image");
    let swapped = text.replace(line, &format!("{lamp} }}\nslide = {{ image{picture}"));
    let read = |name: &str, text: &str| {
        let file = folder.path().join(name);
        std::fs::write(&file, text).unwrap();
        let run = |to: &Path| {
            let out = Command::new(env!("CARGO_BIN_EXE_eyebox")).arg("convert").args([&file, to]).output().unwrap();
            assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
        };
        let carried = ["glb", "usda"].map(|kind| folder.path().join(format!("{name}.{kind}")));
        carried.iter().for_each(|to| run(to));
        std::iter::once(&file).chain(&carried).map(|file| scene_of(file, &[])).collect::<Vec<Scene>>()
    };
    let (said, slid) = (read("emitter.optics.toml", &text), read("slide.optics.toml", &swapped));
    for scene in said.iter().chain(&slid) {
        let shining = |scene: &Scene| {
            let faces = scene.parts.iter().flat_map(|part| part.faces.clone());
            faces.filter(|face| face.emitter.is_some()).collect::<Vec<Face>>()
        };
        assert_eq!(scene.slides, said[0].slides);
        assert_eq!(shining(scene), shining(&said[0]));
    }
    assert_eq!((said[0].slides.len(), said[0].slides[0].contrast), (1, 1e5));
}

/// A face in colour and at one wavelength: each primary has its luminance, white their sum, black what the contrast leaves.
#[test]
fn primaries_have_their_luminances() {
    let primaries = [1000.0, 3000.0, 400.0];
    let sets = ["oled.primaries_cd_m2=[1000, 3000, 400]", "sky.luminance_cd_m2=0", "DISPLAY.contrast=100"];
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples/birdbath/birdbath.optics.toml");
    for (wavelengths, passes) in [("wavelengths.mono_nm=550", 2), ("wavelengths=visible", 512)] {
        let mut s = scene_of(&path, &[&sets[..], &[wavelengths]].concat());
        // From between the display and the beam splitter, straight up at the display, 6 mm away.
        s.eye = Eye {
            position: DVec3::new(0.0, 0.012, -0.025),
            look: DVec3::Y,
            up: DVec3::Z,
            pupil_diameter_m: 0.0,
            fov_deg: 0.2,
            resolution: [2, 2],
            ..s.eye
        };
        let white: f64 = primaries.iter().sum();
        // Places on the picture as make.py draws it, of its half width of 4 mm: red, green, blue, the frame's white, black.
        let at = [[-0.4, -0.3], [0.0, -0.3], [0.4, -0.3], [0.995, 0.0], [0.0, 0.3]];
        for ([u, v], light) in at.into_iter().zip([primaries[0], primaries[1], primaries[2], white, 0.0]) {
            let part = s.parts.iter().find(|part| part.name == "DISPLAY").expect("the display");
            let place = part.to_world.transform_point3(DVec3::new(4.0 * u, 4.0 * v, 0.0));
            s.eye.look = (place - s.eye.position).normalize();
            s.eye.up = (DVec3::Z - s.eye.look * s.eye.look.z).normalize();
            let want = white / 100.0 + light * (1.0 - 1.0 / 100.0);
            let (got, sigma) = mean(&image(&render(&s, BACKWARD, passes, 3).0));
            println!("{wavelengths} {u} {v}: {got} ± {sigma}, want {want}");
            assert!(sigma < 0.02 * want, "noise {sigma} of {want}");
            // D65's table is within 3e-4 of the white of Rec.709.
            let most = 4.0 * sigma + 5e-4 * want;
            assert!((got - want).abs() < most, "{wavelengths} {u} {v}: {got} ± {sigma}, {want}");
        }
    }
}

fn scene_of(path: &Path, sets: &[&str]) -> Scene {
    let sets = sets.iter().map(|text| Set::parse(text).unwrap()).collect();
    import(path, &ImportOptions { sets, ..ImportOptions::default() }).unwrap().scene
}

/// Form factor of a rectangle of sides `a` and `b` from a corner, to a parallel element at `h` under that corner (Howell,
/// Catalog of radiation configuration factors, B-3).
fn corner_factor(a: f64, b: f64, h: f64) -> f64 {
    let part = |x: f64, y: f64| x / (1.0 + x * x).sqrt() * (y / (1.0 + x * x).sqrt()).atan();
    (part(a / h, b / h) + part(b / h, a / h)) / (2.0 * PI)
}

/// A screen lit by the display: E is the sum over its pixels, L = ρE/π.
#[test]
fn it_lights_a_screen_as_its_pixels_do() {
    const RHO: f64 = 0.5;
    let h = 0.03;
    let mut s = display(1e-3);
    let white = face(Finish::Lambert { reflectance: RHO, transmittance: 0.0 });
    // Facing the display from above; the eye looks up at it from beside the display.
    let polygon = quad(DVec3::Z * h, DVec3::Y * 1e-3, DVec3::X * 1e-3);
    add_part(&mut s, "screen", mesh(&[polygon]), DVec3::ZERO, None, vec![white]);
    s.eye.position = DVec3::new(0.1, 0.0, 0.005);
    let to = DVec3::Z * h - s.eye.position;
    s.eye.look = to.normalize();
    s.eye.up = DVec3::Y;
    s.eye.focus_distance_m = to.length();
    s.eye.fov_deg = 0.05;
    s.eye.resolution = [2, 2];
    let factor = |x: f64, y: f64| x.signum() * y.signum() * corner_factor(x.abs(), y.abs(), h);
    let mut illuminance = 0.0;
    for row in 0..ROWS {
        for column in 0..COLUMNS {
            let [x0, x1] = [0, 1].map(|k| (column + k) as f64 / COLUMNS as f64 * 2.0 * HALF[0] - HALF[0]);
            let [y1, y0] = [0, 1].map(|k| HALF[1] - (row + k) as f64 / ROWS as f64 * 2.0 * HALF[1]);
            let seen = factor(x1, y1) - factor(x0, y1) - factor(x1, y0) + factor(x0, y0);
            illuminance += PI * luminance_of(&slide(), s_of(column, row)) * seen;
        }
    }
    let want = RHO * illuminance / PI;
    for (what, choice, passes) in [("from the eye", BACKWARD, 2000), ("auto", Choice::Auto, 500)] {
        let (got, sigma) = mean(&image(&render(&s, choice, passes, 5).0));
        println!("{what}: {got} ± {sigma}, want {want}");
        assert!(sigma < 0.03 * want && (got - want).abs() <= 4.0 * sigma, "{what}: {got} ± {sigma}, want {want}");
    }
}

/// The luminance of a display without a picture falls as its beam does, and a picture changes nothing about that.
#[test]
fn black_has_the_light_that_the_contrast_leaves() {
    let mut s = display(0.0);
    s.slides[0].pixels = Arc::new(vec![0.0; COLUMNS * ROWS]);
    let black = WHITE * 0.8 / 50.0;
    let lit: Vec<f64> =
        image(&render(&s, BACKWARD, 2, 1).0).into_iter().map(|(value, _)| value).filter(|value| *value > 0.0).collect();
    assert_eq!(lit.len(), COLUMNS * ROWS);
    assert!(lit.iter().all(|value| (value / black - 1.0).abs() < 1e-6), "{lit:?}");
    // Nothing is behind it: what light meets is what it is made of, not a window.
    let world = World::freeze(&s).expect("sound");
    assert!(world.lamps.all().iter().all(|lamp| !lamp.is_even()));
}
