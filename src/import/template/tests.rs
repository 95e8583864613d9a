//! Skeletons of the CAD samples, and of assemblies with names that nobody would give.

use super::*;
use crate::ReadOptions;
use crate::testing::assembly;
use eyebox_scene::{Finish, Scene, Shape};

fn sample(file: &str) -> (Template, Scene) {
    let asset = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("samples").join(file);
    let sidecar = asset.with_file_name("init.optics.toml");
    let skeleton = skeleton(&asset, &sidecar).expect("the sample can be read");
    assert_eq!(skeleton.fault, None);
    let value = toml::parse(&skeleton.text, &sidecar).expect("a skeleton is TOML");
    let assembly = gltf::read(&asset, &ReadOptions::default()).expect("the sample can be read");
    let built = build(assembly, Some(&value), &[]).expect("a skeleton can be imported");
    (skeleton, built.scene)
}

/// R (mm, positive: centre of curvature towards +z of the part) and conic constant of every curved cap: the
/// prescription of the reference HUDs, as in `fit/cad_tests.rs`.
struct Cap(&'static str, &'static str, usize, f64, f64);

const K: f64 = -2.2278183778808804;
const DIRECT: [Cap; 2] = [Cap("LENS_01_PMMA", "PMMA", 0, 49.25878, K), Cap("LENS_02_NBK7", "N-BK7", 0, 103.70448, 0.0)];
const DIFFUSE: [Cap; 9] = [
    Cap("LENS_01_PMMA", "PMMA", 0, 14.77763, K),
    Cap("LENS_02_PMMA", "PMMA", 2, -39.98267, K),
    Cap("LENS_03_NSK16", "N-SK16", 0, 18.39533, 0.0),
    Cap("LENS_03_NSK16", "N-SK16", 2, -79.68360, 0.0),
    Cap("LENS_04_F2", "F2", 0, -20.29192, 0.0),
    Cap("LENS_04_F2", "F2", 2, 22.21328, 0.0),
    Cap("LENS_05_NSK16", "N-SK16", 0, 435.76044, 0.0),
    Cap("LENS_05_NSK16", "N-SK16", 2, -22.01359, 0.0),
    Cap("LENS_06_NBK7", "N-BK7", 0, 103.70448, 0.0),
];

fn check(scene: &Scene, caps: &[Cap]) {
    for Cap(name, glass, face, r, k) in caps {
        let part = scene.parts.iter().find(|part| part.name == *name).expect("the part is there");
        assert_eq!(part.medium.map(|id| scene.medium(id).name.as_str()), Some(*glass), "{name}");
        let found = &part.faces[*face];
        assert_eq!(found.finish, Finish::Polished, "{name} {face}");
        let (radius, conic) = match &found.shape {
            Shape::Sphere { axis, radius, .. } => (axis.z.signum() * radius, 0.0),
            Shape::Conic { axis, radius, conic, .. } => (axis.z.signum() * radius, *conic),
            Shape::Mesh
            | Shape::Plane { .. }
            | Shape::Asphere { .. }
            | Shape::Cylinder { .. }
            | Shape::Toroid { .. }
            | Shape::XyPoly { .. }
            | Shape::Zernike { .. }
            | Shape::Bspline { .. } => panic!("{name} {face} is {:?}", found.shape),
        };
        // What fitting the f32 points gives (`fit/cad_tests.rs`).
        assert!((radius / r - 1.0).abs() < 3e-6 && (conic - k).abs() < 2e-3, "{name} {face}: {radius} {conic}");
        assert_eq!(part.faces[1].finish, Finish::Absorber, "the rim of {name}");
    }
    for part in scene.parts.iter().filter(|part| part.name.starts_with("LED_DIE_")) {
        let lit: Vec<usize> = (0..6).filter(|face| part.faces[*face].emitter.is_some()).collect();
        assert_eq!(lit, [4], "{}", part.name);
    }
    let combiner = scene.parts.iter().find(|part| part.name == "COMBINER_PLATE_NBK7").expect("the combiner is there");
    let polished: Vec<usize> = (0..6).filter(|face| combiner.faces[*face].finish == Finish::Polished).collect();
    assert_eq!(polished, [4, 5]);
    for name in ["HOUSING_TUBE", "LED_PCB", "LCD_BEZEL", "BAFFLE_01"] {
        let part = scene.parts.iter().find(|part| part.name == name).expect("the part is there");
        assert!(part.medium.is_none() && part.faces.iter().all(|face| face.finish == Finish::Absorber), "{name}");
    }
}

#[test]
fn the_skeletons_of_the_cad_samples_import_with_the_prescribed_lenses() {
    let (direct, scene) = sample("hud-direct/hud_direct.glb");
    check(&scene, &DIRECT);
    assert_eq!((direct.parts, direct.kinds), (18, 10));
    assert_eq!(direct.todos.len(), 4, "{:?}", direct.todos);
    assert!(direct.text.contains("\nunit = 0.001 ") && direct.text.contains("\nasset = \"hud_direct.glb\"\n"));
    // Copies are one kind, and every face is listed.
    assert!(direct.text.contains("\npath = \"LED_DIE_*\"\n") && !direct.text.contains("LED_DIE_5"));
    assert!(direct.text.contains(
        "#   face 0: 1896.6 mm2, towards (0, 0, -1), conic R 49.2588 mm k -2.22782, centre towards (0, 0, 1)"
    ));
    let (_, scene) = sample("hud-diffuse/hud_diffuse.glb");
    check(&scene, &DIFFUSE);
    let screen = scene.parts.iter().find(|part| part.name == "DIFFUSER_SHEET").expect("the screen is there");
    let scatters = |face: &eyebox_scene::Face| matches!(face.finish, Finish::Gauss { .. });
    assert_eq!(screen.faces.iter().filter(|face| scatters(face)).count(), 1);
}

#[test]
fn odd_names_give_toml_that_imports_all_the_same() {
    let names = [
        "LENS \"1\"\\",
        "LENS\n[eye]\nx = 1 # \u{1b}",
        "LENS *",
        "LENS A",
        "LENS A",
        "LED_1",
        "LED_2",
        "LED_board",
        "",
        "LENS/LED_3",
    ];
    let skeleton = of(assembly(&names), "a\"b.glb", Path::new("x.optics.toml")).expect("it is written");
    assert_eq!(skeleton.fault, None, "{}", skeleton.text);
    assert_eq!(skeleton.parts, names.len());
    // As a path, `LENS *` would be a pattern for other parts too; the author is asked.
    assert!(skeleton.todos.iter().any(|todo| todo == "a name of its own for ROOT/LENS *"), "{:?}", skeleton.todos);
    // Two copies of one name are bound together.
    assert!(skeleton.text.contains("path = \"LENS A*\"\nglass"), "{}", skeleton.text);
    assert!(skeleton.todos.iter().all(|todo| !todo.contains(char::is_control)), "{:?}", skeleton.todos);
    // `LED_*` would be the board's, too.
    assert!(!skeleton.text.contains("\"LED_*\"") && skeleton.text.contains("\"LED_2\""), "{}", skeleton.text);
    let none = of(Assembly::default(), "a.glb", Path::new("x.optics.toml")).expect("it is written");
    assert_eq!((none.parts, none.fault), (0, None));
}

#[test]
fn what_is_no_optics_keeps_its_picture() {
    for z_up in [false, true] {
        let mut asset = assembly(&["Helmet", "Visor"]);
        if z_up {
            asset.axes = glam::DMat3::from_cols(glam::DVec3::X, glam::DVec3::NEG_Z, glam::DVec3::Y);
        }
        let bare = build(asset.clone(), None, &[]).expect("a picture");
        assert!(bare.assumed.eye && bare.assumed.sky);
        let skeleton = of(asset.clone(), "a.glb", Path::new("x.optics.toml")).expect("it is written");
        assert_eq!((skeleton.fault, skeleton.parts), (None, 2), "{}", skeleton.text);
        let sidecar = toml::parse(&skeleton.text, Path::new("x.optics.toml")).expect("TOML");
        let told = build(asset, Some(&sidecar), &[]).expect("it can be imported");
        assert!(!told.assumed.eye && !told.assumed.sky, "it is said now");
        assert_eq!((&told.scene.sky, told.scene.wavelengths), (&bare.scene.sky, bare.scene.wavelengths));
        let finishes = |built: &Built| built.scene.parts.iter().map(|part| part.faces.clone()).collect::<Vec<_>>();
        assert_eq!(finishes(&told), finishes(&bare));
        let (a, b) = (&told.scene.eye, &bare.scene.eye);
        // Directions are normalised once more.
        for (a, b) in [(a.position, b.position), (a.look, b.look), (a.up, b.up)] {
            assert!((a - b).length() <= 4.0 * f64::EPSILON * b.length(), "{a} {b}");
        }
        assert_eq!(
            (a.pupil_diameter_m, a.focus_distance_m, a.fov_deg, a.resolution),
            (b.pupil_diameter_m, b.focus_distance_m, b.fov_deg, b.resolution)
        );
    }
    // A camera and a lamp of its own stay what they are.
    let mut asset = assembly(&["Helmet"]);
    asset.cameras.push(crate::assembly::Camera {
        name: "CAM".into(),
        node: None,
        to_world: glam::DAffine3::IDENTITY,
        yfov: Some(0.5),
        aspect: Some(1.5),
        pupil: None,
        focus: None,
        frustum: Default::default(),
    });
    let skeleton = of(asset, "a.glb", Path::new("x.optics.toml")).expect("it is written");
    assert!(skeleton.fault.is_none() && skeleton.text.contains("\n# [eye] "), "{}", skeleton.text);
}

#[test]
fn an_asset_is_named_from_the_sidecars_folder() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    std::fs::create_dir_all(at("cad")).and_then(|()| std::fs::create_dir_all(at("optics/x"))).expect("folders");
    std::fs::write(at("cad/a.glb"), "").expect("a file");
    assert_eq!(relative(&at("cad/a.glb"), &at("cad/a.optics.toml")), "a.glb");
    assert_eq!(relative(&at("cad/a.glb"), &at("optics/x/a.optics.toml")), "../../cad/a.glb");
    assert_eq!(
        skeleton(&at("x.optics.toml"), &at("y.optics.toml")).map(|_| ()).map_err(|fault| fault.what),
        Err("this is a sidecar already".into())
    );
}
