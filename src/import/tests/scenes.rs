//! Units, frames, slides, skies and eyes come out where they belong.

use super::{BASE, built, built_on};
use crate::assembly::Camera;
use crate::testing::assembly;
use eyebox_scene::{Finish, Severity, Shape};
use glam::{DAffine3, DMat3, DVec3};

fn near(a: DVec3, b: DVec3) -> bool {
    (a - b).length() <= 1e-12 * (1.0 + b.length())
}

#[test]
fn parts_stand_in_metres_and_equal_media_are_one() {
    let text = "[[bind]]\npath = \"LED_*\"\nglass = \"pmma\"\n[[bind]]\npath = \"LENS\"\nglass = \"PMMA\"\n[[bind]]\npath = \"LCD\"\nior = 1.5\nabsorption_per_m = [[500, 1], [600, 3]]\npriority = -2\n";
    let built = built(text, &["unit=0.001"]).unwrap();
    let scene = &built.scene;
    // LED_2 is third, 20 units along the root's x, which the turn about x leaves alone.
    assert!(near(scene.parts[2].to_world.transform_point3(DVec3::new(0.0, 0.0, 5.0)), DVec3::new(0.02, 0.005, 0.0)));
    assert_eq!(scene.media.len(), 2);
    let lcd = &scene.parts[3];
    assert_eq!((scene.medium(lcd.medium.unwrap()).absorption.per_m(550.0), lcd.priority), (2.0, -2));
    assert!(
        scene
            .notes
            .iter()
            .any(|note| note.severity == Severity::Info && note.text.starts_with("unit 0.001 m replaces"))
    );
    assert_eq!(scene.name, "a");
}

#[test]
fn an_eye_in_a_nodes_frame_is_turned_with_it() {
    let text = BASE.replace("\"0 mm\", \"0 mm\", \"0 mm\"", "\"1 mm\", \"2 mm\", \"3 mm\"");
    let eye = |set: &str| built_on(assembly(&["LENS", "LED"]), &text, &["unit=0.001", set]).unwrap().scene.eye;
    let asset = eye("eye.frame=asset");
    assert!(
        near(asset.position, DVec3::new(1e-3, 2e-3, 3e-3))
            && near(asset.look, DVec3::NEG_Z)
            && near(asset.up, DVec3::Y)
    );
    // −90° about x: y → −z, z → y. As cad/README.md: CAD −z is the glTF world's −y, CAD +y its −z.
    let root = eye("eye.frame=ROOT");
    assert!(near(root.position, DVec3::new(1e-3, 3e-3, -2e-3)), "{:?}", root.position);
    assert!(near(root.look, DVec3::NEG_Y) && near(root.up, DVec3::NEG_Z));
    // A node's origin is in units of the asset, the eye's offset is physical.
    let led = eye("eye.frame=LED");
    assert!(near(led.position, DVec3::new(11e-3, 3e-3, -2e-3)), "{:?}", led.position);
    assert_eq!(
        (led.pupil_diameter_m, led.focus_distance_m, led.resolution, led.fov_deg),
        (4e-3, f64::INFINITY, [360, 180], 12.0)
    );
}

#[test]
fn a_camera_serves_when_the_eye_says_nothing_of_its_place() {
    let with_camera = || {
        let mut asset = assembly(&["LENS"]);
        let to_world = DAffine3::from_mat3_translation(
            DMat3::from_rotation_y(std::f64::consts::FRAC_PI_2),
            DVec3::new(0.0, 0.0, 3.0),
        );
        asset.cameras.push(Camera {
            name: "CAM".into(),
            node: None,
            to_world,
            yfov: Some(0.5),
            aspect: Some(1.5),
            pupil: None,
            focus: Some(250.0),
            frustum: Default::default(),
        });
        asset
    };
    let bare = "schema = 1\nunit = 0.01\n[default]\nfinish = \"absorber\"\n";
    let eye = built_on(with_camera(), bare, &["eye.pupil_diameter=0 mm"]).unwrap().scene.eye;
    assert!(near(eye.position, DVec3::new(0.0, 0.0, 0.03)) && near(eye.look, DVec3::NEG_X) && near(eye.up, DVec3::Y));
    assert_eq!((eye.resolution, eye.pupil_diameter_m, eye.focus_distance_m), ([360, 240], 0.0, 2.5));
    assert!(((eye.fov_deg.to_radians() / 2.0).tan() - 1.5 * 0.25f64.tan()).abs() < 1e-12);
    assert_eq!(built_on(with_camera(), BASE, &[]).unwrap().scene.eye.fov_deg, 12.0);
    assert_eq!(
        built_on(assembly(&["LENS"]), bare, &[]).unwrap_err().to_string(),
        "hud.optics.toml: there is no eye; expected an [eye], or a perspective camera in the asset"
    );
}

/// A folder with a slide and a panorama, and a sidecar there that names them.
fn with_pictures(extra: &str) -> (tempfile::TempDir, Result<crate::Built, String>) {
    with_pictures_on(assembly(&["LCD"]), extra)
}

fn with_pictures_on(assembly: crate::Assembly, extra: &str) -> (tempfile::TempDir, Result<crate::Built, String>) {
    let folder = tempfile::tempdir().unwrap();
    image::GrayImage::from_raw(2, 1, vec![255, 0]).unwrap().save(folder.path().join("slide.png")).unwrap();
    let sky = exr::prelude::SpecificChannels::build()
        .with_channel("Y")
        .with_pixel_fn(|at: exr::prelude::Vec2<usize>| (at.0 as f32,));
    let image = exr::prelude::Image::from_channels((4, 2), sky);
    exr::prelude::WritableImage::write(&image).to_file(folder.path().join("sky.exr")).unwrap();
    std::fs::write(folder.path().join("words.txt"), "no picture").unwrap();
    let text = format!("{BASE}{extra}");
    let sidecar = crate::toml::parse(&text, &folder.path().join("hud.optics.toml")).unwrap();
    let built = crate::build(assembly, Some(&sidecar), &[]).map_err(|fault| fault.to_string());
    (folder, built)
}

#[test]
fn a_slide_lies_in_its_face() {
    let slide = "[[bind]]\npath = \"LCD\"\nfinish = \"none\"\n[[bind]]\npath = \"LCD\"\nnormal = \"-z\"\nslide = { image = \"slide.png\", size = [4, 2], u = [2, 0, 0], v = [0.0005, 3, 0], transmittance = 0.9, contrast = 300 }\n";
    let (_folder, built) = with_pictures(slide);
    let scene = built.unwrap().scene;
    let face = &scene.parts[0].faces[4];
    let found = scene.slide(face.slide.unwrap());
    assert_eq!((face.finish, found.centre, found.u, found.v), (Finish::None, DVec3::ZERO, DVec3::X, DVec3::Y));
    assert_eq!((found.width, found.height, found.pixels.as_slice()), (2, 1, &[1.0, 0.0][..]));
    assert_eq!((found.size, found.transmittance, found.contrast), ([4.0, 2.0], 0.9, 300.0));
    assert_eq!(scene.parts[0].faces[5].slide, None);

    let fault = |from: &str, to: &str| {
        let (folder, built) = with_pictures(&slide.replace(from, to));
        let folder = format!("{}/", folder.path().display());
        built.map_or_else(|fault| fault.replace(&folder, ""), |_| "no fault".into())
    };
    assert_eq!(
        fault("u = [2, 0, 0]", "u = [0, 0, 1]"),
        "hud.optics.toml:16: the slide's face 4 of part ROOT/LCD doesn't contain `u` = [0, 0, 1]; expected a direction \
         along the face, whose normal is [0.000, 0.000, -1.000]"
    );
    assert_eq!(
        fault("contrast = 300", "centre = [0, 0, 1]"),
        "hud.optics.toml:16: the slide's face 4 of part ROOT/LCD doesn't contain `centre`: it is -1.000e0 mesh units off; \
         expected a point of the face's plane"
    );
    assert_eq!(
        fault("slide.png", "slides.png"),
        "hud.optics.toml:16: can't read the slide image slides.png: there is no such file"
    );
    assert!(fault("slide.png", "words.txt").starts_with("hud.optics.toml:16: can't read the picture "));
}

#[test]
fn a_slide_needs_a_flat_face() {
    let mut bent = assembly(&["LCD"]);
    bent.meshes[0].mesh.positions[16][2] = -0.01;
    let slide = "[[bind]]\npath = \"LCD\"\nfaces = [4]\nslide = { image = \"slide.png\", size = [4, 2], u = [1, 0, 0], v = [0, 1, 0] }\n";
    let (folder, built) = with_pictures_on(bent, slide);
    let fault = built.unwrap_err().replace(&format!("{}/", folder.path().display()), "");
    // The bounds' middle is 5 µm off the bent corner, the others too, up to the tilt of the mean normal.
    assert_eq!(
        fault,
        "hud.optics.toml:13: the slide's face 4 of part ROOT/LCD is not flat: 5.000e-3 of 4.472e0 mesh units; expected a plane face"
    );
}

#[test]
fn a_sky_is_scaled_and_turned() {
    let sky = "[sky]\nimage = \"sky.exr\"\nscale_cd_m2 = 10\nrotation_deg = 180\nframe = \"ROOT\"\n";
    let (_folder, built) = with_pictures(sky);
    let scene = built.unwrap().scene;
    let sky = scene.sky.as_ref().unwrap();
    assert_eq!((sky.width, sky.height, &sky.luminance[..4]), (4, 2, &[0.0, 10.0, 20.0, 30.0][..]));
    assert_eq!(scene.group(sky.group).name, "sky");
    // The centre, +z, turned by 180° about +y: the root's −z, which is the world's −y; the pole stays the root's y.
    assert!(near(sky.to_world * DVec3::Z, DVec3::NEG_Y) && near(sky.to_world * DVec3::Y, DVec3::NEG_Z));
}

#[test]
fn fits_follow_the_unit_and_say_their_residual() {
    let text = "[[bind]]\npath = \"LENS\"\nfaces = [4]\nshape = { kind = \"fit\", tolerance_um = 0.05 }\n";
    let built = built(text, &["unit=0.001"]).unwrap();
    let Shape::Plane { vertex, axis } = built.scene.parts[0].faces[4].shape else { panic!("no plane") };
    assert!(near(vertex, DVec3::ZERO) && near(axis, DVec3::NEG_Z));
    assert!(
        built.scene.notes.iter().any(|note| note.text.starts_with("fitted plane: 4 points miss it by")),
        "{:?}",
        built.scene.notes
    );
    let mut bent = assembly(&["LENS"]);
    bent.meshes[0].mesh.positions[16][2] = -0.01;
    let fault = |unit: &str| {
        let text = text.replace("fit\"", "fit\", surface = \"plane\"");
        built_on(bent.clone(), &format!("{BASE}{text}"), &[unit])
            .map_or_else(|fault| fault.to_string(), |_| "fits".into())
    };
    // The same bend is 10 µm in millimetres and 10 nm in micrometres.
    assert_eq!(
        fault("unit=0.001"),
        "hud.optics.toml:13: part ROOT/LENS face 4: the plane misses the points by 2.50 µm rms, 2.50 µm max at (2, 1, 0); \
         expected at most 0.0500 µm"
    );
    assert_eq!(fault("unit=1e-6"), "fits");
    let mut squashed = assembly(&["LENS"]);
    squashed.nodes[1].to_world.matrix3 *= DMat3::from_diagonal(DVec3::new(1.0, 1.0, 1.1));
    assert_eq!(
        built_on(squashed, &format!("{BASE}{text}"), &[]).unwrap_err().to_string(),
        "hud.optics.toml:13: part ROOT/LENS face 4 has an exact shape but its node is not scaled uniformly; expected the \
         same scale along all axes"
    );
}
