//! The report of a scene small enough to check by hand.

use super::*;
use eyebox_base::Where;
use eyebox_base::ids::{CoatingId, GratingId, GroupId, MediumId, MeshId, SlideId, WavePlateId};
use eyebox_scene::{
    Absorption, Angular, Coating, Dispersion, Emitter, Face, FaceRange, FilmLayer, Finish, Grating, Group, Led, Medium,
    Mesh, Order, Part, Photometry, Residual, Retardance, Sensor, Shape, Slide, Spectrum, WavePlate,
};
use glam::{DAffine3, DMat3, DVec3};
use std::sync::Arc;

/// 2 x 1 mesh units, its two triangles are two faces of area 1.
fn mesh(name: &str) -> Mesh {
    Mesh {
        name: name.into(),
        positions: vec![[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
        normals: vec![[0.0, 0.0, 1.0]; 4],
        uvs: Vec::new(),
        second_uvs: Vec::new(),
        tangents: Vec::new(),
        colors: Vec::new(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        faces: vec![FaceRange { first: 0, count: 1 }, FaceRange { first: 1, count: 1 }],
    }
}

fn face(finish: Finish) -> Face {
    Face { finish, coating: None, shape: Shape::Mesh, emitter: None, tint: None, slide: None, sensor: None }
}

fn part(path: &str, mesh: usize, x_m: f64, faces: [Face; 2]) -> Part {
    Part {
        name: path.rsplit('/').next().unwrap_or(path).into(),
        path: path.into(),
        mesh: MeshId::from_index(mesh),
        to_world: DAffine3 { matrix3: DMat3::from_diagonal(DVec3::splat(1e-3)), translation: DVec3::X * x_m },
        medium: None,
        priority: 0,
        materials: Vec::new(),
        film_in: None,
        faces: faces.into(),
    }
}

fn scene() -> Scene {
    let emitter = Emitter {
        group: GroupId(0),
        photometry: Photometry::FluxLm(std::f64::consts::PI),
        angular: Angular::Lambert,
        spectrum: Some(Spectrum::Led(Led::B1)),
        polarisation: None,
        both_sides: false,
        pattern: None,
    };
    let led = || [face(Finish::Absorber), Face { emitter: Some(emitter.clone()), ..face(Finish::Absorber) }];
    let shape = Shape::Sphere { vertex: DVec3::ZERO, axis: DVec3::Z, radius: -50.0 };
    let cap = Face { coating: Some(CoatingId(0)), shape, ..face(Finish::Polished) };
    let mut lens = part("HUD/OPTICS/LENS", 0, 0.0, [cap, face(Finish::Polished)]);
    lens.medium = Some(MediumId(0));
    let sensor = Some(Sensor { pixels: [64, 32], u: None });
    let slide = Face { slide: Some(SlideId(0)), sensor, ..face(Finish::None) };
    let fit = Where::Part { path: "HUD/OPTICS/LENS".into(), face: Some(0) };
    Scene {
        name: "tiny".into(),
        unit_m: 1e-3,
        wavelengths: Wavelengths::Mono { nm: 550.0 },
        meshes: vec![mesh("plate").into(), mesh("die").into()],
        parts: vec![
            lens,
            part("HUD/LED_1", 1, 0.01, led()),
            part("HUD/LED_2", 1, 0.02, led()),
            part("HUD/LED_3", 1, 0.03, led()),
            part("HUD/LCD", 0, 0.0, [slide, face(Finish::None)]),
            part("HUD/BOX\u{7}", 0, 0.0, [face(Finish::Absorber), face(Finish::Absorber)]),
        ],
        media: vec![Medium {
            name: "glass".into(),
            index: Dispersion::Constant(1.5),
            absorption: Absorption::Constant(2.0),
        }],
        coatings: vec![Coating::stack(
            "ar",
            vec![FilmLayer { index: Dispersion::Constant(1.38), thickness_nm: 99.638 }],
        )],
        scatters: vec![],
        wave_plates: vec![],
        gratings: vec![],
        surfaces: vec![],
        slides: vec![Slide {
            name: "s".into(),
            file: "s.png".into(),
            width: 2,
            height: 1,
            pixels: Arc::new(vec![1.0, 0.0]),
            rgb: None,
            centre: DVec3::ZERO,
            u: DVec3::X,
            v: DVec3::Y,
            size: [2.0, 1.0],
            transmittance: 0.8,
            contrast: 100.0,
            polarisation: None,
            primaries: None,
        }],
        profiles: Vec::new(),
        groups: vec![Group { name: "led".into() }, Group { name: "sky".into() }],
        lights: Vec::new(),
        sky: Some(Sky {
            group: GroupId(1),
            width: 2,
            height: 2,
            luminance: Arc::new(vec![1.0, 2.0, 3.0, 6.0]),
            rgb: None,
            to_world: DMat3::IDENTITY,
            file: "sky.exr".into(),
        }),
        eye: Eye {
            position: DVec3::new(0.0, 0.0, 0.1),
            look: DVec3::NEG_Z,
            up: DVec3::Y,
            pupil_diameter_m: 0.004,
            adapts: false,
            limits: eyebox_scene::BinocularLimits {
                convergence_mrad: Some(2.0),
                dipvergence_mrad: Some(0.5),
                image_distance_m: Some(2.2),
                ..eyebox_scene::BinocularLimits::default()
            },
            focus_distance_m: f64::INFINITY,
            fov_deg: 20.0,
            resolution: [40, 20],
            age: 45.0,
        },
        notes: vec![
            Note::fitted(
                fit,
                "sphere of radius -50",
                Residual { points: 9, rms_um: 1.0, greatest_um: 2.0, known: None },
            ),
            Note::info(Where::Nowhere, "`age` of eye is not said: 45"),
            Note::warning(Where::file(std::path::Path::new("a.glb")), "normals repaired"),
        ],
        hash: String::new(),
    }
}

/// π lm from 1 mm² by Lambert: 1 lm/sr/mm² = 10⁶ cd/m². Half a white slide at contrast 100: (0.8 + 0.008)/2. The sky's
/// two rows weigh the same. 10° has a tangent of 0.1763, half of it is that of 5.038°.
const TREE: &str = "\
tiny: 6 parts, 2 meshes, 12 triangles, unit 0.001 m, 6 parts share meshes, 550 nm
bounds 32 x 1 x 0 mm, from (0, 0, 0) to (32, 1, 0) mm

HUD
├─ OPTICS
│  └─ LENS: glass, n 1.5, absorbs 2/m, 2 x 1 x 0 mm, one of 3 instances of mesh plate, at (1, 0.5, 0)
│          face 0: polished, coating ar [n 1.38 99.638 nm], sphere R -50 mm about (0, 0, 1) (fit: 9 points miss it by 1 µm rms, 2 µm at most)
│          face 1: polished, as meshed
├─ LED_1 … LED_3 (3 alike): 2 x 1 x 0 mm, one of 3 instances of mesh die
│       face 0: absorber
│       face 1: absorber, emits 3.142 lm, 1 cd, 1000000 cd/m² into group led, lambert, half angle 60 deg, spectrum led_b1
├─ LCD: 2 x 1 x 0 mm, one of 3 instances of mesh plate, at (1, 0.5, 0)
│       face 0: slide s.png 2 x 1 pixels, 2 x 1 mm, T 0.8, contrast 100, mean T 0.404, sensor of 64 x 32 pixels
│       face 1: not there for light
└─ BOX\u{fffd}: 2 x 1 x 0 mm, one of 3 instances of mesh plate, absorber, at (1, 0.5, 0)

lamps
  led: 3 faces, 9.425 lm, peak 1 cd, 1000000 cd/m², half angle 60 deg
  sky: sky sky.exr, 2 x 2 pixels, 1 to 6 cd/m², mean 3 cd/m²

eye
  at (0, 0, 100) mm, looks along (0, 0, -1), up (0, 1, 0)
  pupil 4 mm, focus at infinity, field 20 x 10.08 deg, 40 x 20 pixels, age 45
  limits of two eyes: convergence 2 mrad, dipvergence 0.5 mrad, the image at 2200 mm

notes
  warning: a.glb: normals repaired
  info: `age` of eye is not said: 45
";

#[test]
fn a_tiny_scene_as_text() {
    assert_eq!(AssemblyTree::new(&scene()).text(), TREE);
}

#[test]
fn the_same_as_json() {
    let tree = AssemblyTree::new(&scene());
    let text = serde_json::to_string(&tree).expect("plain data");
    let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(json["parts"].as_array().map(Vec::len), Some(6));
    assert_eq!(json["parts"][0]["medium"]["n"], 1.5);
    assert_eq!(json["parts"][0]["faces"][0]["shape"]["radius"], -50.0);
    assert_eq!(json["optics"]["groups"].as_array().map(Vec::len), Some(1));
    let flux = json["optics"]["groups"][0]["flux_lm"].as_f64().expect("a number");
    assert!((flux / (3.0 * std::f64::consts::PI) - 1.0).abs() < 1e-12, "{flux}");
    assert_eq!(json["optics"]["eye"]["focus_distance_m"], serde_json::Value::Null);
    assert_eq!(json["notes"][0]["severity"], "warning");
}

#[test]
fn cosine_powers_and_the_three_photometries_agree() {
    // I(θ) = I₀·cos³θ: the flux is 2π·I₀/4.
    let mut scene = scene();
    let luminance = |scene: &Scene| {
        let report = AssemblyTree::new(scene).parts[1].faces[1].emitter.clone().expect("it emits");
        (report.flux_lm, report.luminance_cd_m2)
    };
    for photometry in
        [Photometry::IntensityCd(2.0), Photometry::LuminanceCdM2(2e6), Photometry::FluxLm(std::f64::consts::PI)]
    {
        scene.parts[1].faces[1].emitter = Some(Emitter {
            group: GroupId(0),
            photometry,
            angular: Angular::CosN { n: 3.0 },
            spectrum: None,
            polarisation: None,
            both_sides: false,
            pattern: None,
        });
        let (flux, along) = luminance(&scene);
        assert!((flux / std::f64::consts::PI - 1.0).abs() < 1e-9 && (along / 2e6 - 1.0).abs() < 1e-9, "{flux} {along}");
    }
}

#[test]
fn without_optics_and_with_broken_tables_nothing_panics() {
    let fault = Error::new(Where::Nowhere, "nothing binds part LENS");
    let text = AssemblyTree::without_optics(&scene(), &fault).text();
    assert!(text.contains("can't be used: nothing binds part LENS") && text.contains("LENS: 2 x 1 x 0 mm"), "{text}");
    assert!(text.contains("2 faces") && !text.contains("emits") && !text.contains("eye\n"), "{text}");
    let mut scene = scene();
    (scene.media, scene.coatings, scene.groups, scene.slides) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    scene.meshes.truncate(1);
    scene.meshes[0].triangles[0] = [900, 0, 1];
    scene.meshes[0].faces[1].count = u32::MAX;
    scene.parts[2].path = "HUD/LED_1".into();
    scene.parts[3].path = "HUD/LED_1/BELOW".into();
    scene.parts[4].path = "A/".repeat(2000);
    let text = AssemblyTree::new(&scene).text();
    assert_eq!(text.matches("LED_").count(), 3, "every part is shown once: {text}");
}

#[test]
fn gratings_and_wave_plates_say_what_they_are() {
    let mut scene = scene();
    let orders = vec![Order { order: 1, transmittance: 0.3, reflectance: 0.05 }];
    scene.gratings.push(Grating {
        direction: DVec3::Y,
        lines_per_mm: 600.0,
        orders: orders.into(),
        rest_in_zero_order: true,
    });
    let retardance = Retardance::Nm(vec![[500.0, 130.0], [600.0, 150.0]]);
    scene.wave_plates.push(WavePlate { retardance, indices: Some([1.544, 1.553]) });
    scene.parts[0].faces[0] = face(Finish::Grating { grating: GratingId(0) });
    scene.parts[0].faces[1] = face(Finish::WavePlate { axis: DVec3::X, plate: WavePlateId(0) });
    let tree = AssemblyTree::new(&scene);
    let text = tree.text();
    for line in [
        "grating, 600 lines/mm across (0, 1, 0), orders +1 R 0.05 T 0.3; the rest goes on in order 0",
        "retarder about (1, 0, 0), 0.25455 waves at 550 nm, by the angle with indices 1.544 and 1.553",
    ] {
        assert!(text.contains(line), "{text}");
    }
    let json = serde_json::to_string(&tree).unwrap();
    assert!(json.contains("\"lines_per_mm\":600.0") && json.contains("\"indices\":[1.544,1.553]"), "{json}");
}
