//! The samples build, and their parts are what `shared/prescription` and `shared/cad` say.

use crate::{Built, ImportOptions, Set, import};
use eyebox_base::Where;
use eyebox_scene::{Face, Finish, Part, Photometry, Scene, Shape, Slide};
use glam::DVec3;
use std::path::Path;

fn sample(name: &str, sets: &[&str]) -> Built {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("samples").join(name);
    let sets = sets.iter().map(|text| Set::parse(text).unwrap()).collect();
    import(&path, &ImportOptions { sets, ..ImportOptions::default() }).unwrap_or_else(|fault| panic!("{fault}"))
}

fn part<'a>(scene: &'a Scene, name: &str) -> &'a Part {
    scene.parts.iter().find(|part| part.name == name).unwrap_or_else(|| panic!("no part {name}"))
}

/// A point of a part in the CAD frame, mm: the root's turn about x undone.
fn cad(part: &Part, local: DVec3) -> DVec3 {
    let world = part.to_world.transform_point3(local) * 1e3;
    DVec3::new(world.x, -world.z, world.y)
}

fn cad_direction(part: &Part, local: DVec3) -> DVec3 {
    (cad(part, local) - cad(part, DVec3::ZERO)).normalize()
}

/// Radius of curvature with the prescription's sign (centre towards CAD +y: positive), conic, vertex y.
fn surface(part: &Part, face: usize) -> (f64, f64, f64) {
    let (vertex, axis, radius, conic) = match part.faces[face].shape {
        Shape::Plane { vertex, axis } => (vertex, axis, f64::INFINITY, 0.0),
        Shape::Sphere { vertex, axis, radius } => (vertex, axis, radius, 0.0),
        Shape::Conic { vertex, axis, radius, conic } => (vertex, axis, radius, conic),
        Shape::Mesh
        | Shape::Asphere { .. }
        | Shape::Cylinder { .. }
        | Shape::Toroid { .. }
        | Shape::XyPoly { .. }
        | Shape::Zernike { .. }
        | Shape::Bspline { .. } => panic!("{} face {face} is {:?}", part.name, part.faces[face].shape),
    };
    let axis = cad_direction(part, axis);
    assert!(axis.y.abs() > 1.0 - 1e-9, "{} face {face}: axis {axis}", part.name);
    (radius * axis.y.signum(), conic, cad(part, vertex).y)
}

/// Rows of a prescription: part, face, radius, conic, vertex y (mm). `prescription.json`, `surfaces`.
fn check_lenses(scene: &Scene, rows: &[(&str, usize, f64, f64, f64)]) {
    for &(name, face, radius, conic, y) in rows {
        let lens = part(scene, name);
        let (r, k, at) = surface(lens, face);
        if radius.is_infinite() {
            assert!(r.is_infinite(), "{name} {face} radius {r}");
        } else {
            // shared/cad/README.md: 3e-6 in R on every cap; the conic to 2e-3 where the cap is weak.
            assert!((r / radius - 1.0).abs() < 3e-6, "{name} {face} radius {r} not {radius}");
            assert!((k - conic).abs() < 2e-3, "{name} {face} conic {k}");
        }
        // The prescription's table has 4 decimals.
        assert!((at - y).abs() < 1e-4, "{name} {face} vertex {at} not {y}");
        assert_eq!(lens.faces[face].finish, Finish::Polished);
        let films = scene.coating(lens.faces[face].coating.unwrap()).films();
        assert_eq!((films.len(), films[0].thickness_nm, films[0].index.index(550.0).re), (1, 99.638, 1.38));
        assert_eq!((lens.faces[1].finish, lens.faces[1].coating), (Finish::Absorber, None), "{name}: rim");
    }
}

fn check_index(scene: &Scene, name: &str, n: f64) {
    let medium = scene.medium(part(scene, name).medium.unwrap_or_else(|| panic!("{name} is empty")));
    assert!((medium.index.index(550.0).re - n).abs() < 1e-9, "{name} {medium:?}");
}

fn only(faces: &[Face], is: impl Fn(&Face) -> bool) -> usize {
    let found: Vec<usize> = (0..faces.len()).filter(|face| is(&faces[*face])).collect();
    assert_eq!(found.len(), 1, "{found:?}");
    found[0]
}

fn slide(scene: &Scene, y: f64, u: DVec3, v: DVec3) -> &Slide {
    let lcd = part(scene, "LCD_ACTIVE_AREA");
    assert!(lcd.medium.is_none());
    let face = only(&lcd.faces, |face| face.slide.is_some());
    assert!(lcd.faces.iter().all(|face| face.finish == Finish::None));
    let slide = scene.slide(lcd.faces[face].slide.unwrap());
    assert!((cad(lcd, slide.centre) - DVec3::new(0.0, y, -120.0)).length() < 1e-4);
    assert!((cad_direction(lcd, slide.u) - u).length() < 1e-12 && (cad_direction(lcd, slide.v) - v).length() < 1e-12);
    assert_eq!((slide.width, slide.height, slide.transmittance, slide.contrast), (2000, 1000, 0.9, 300.0));
    slide
}

/// What both have in common: combiner, lamps, eye, sky.
fn check_frame(scene: &Scene, flux: f64, y: f64) {
    assert_eq!((scene.unit_m, scene.wavelengths.traced_nm()), (1e-3, 550.0));
    let combiner = part(scene, "COMBINER_PLATE_NBK7");
    check_index(scene, "COMBINER_PLATE_NBK7", 1.5185223876207927);
    let coated = |thickness: f64| {
        only(&combiner.faces, |face| {
            face.coating.is_some_and(|id| scene.coating(id).films()[0].thickness_nm == thickness)
        })
    };
    let plane = |face: usize| match combiner.faces[face].shape {
        Shape::Plane { vertex, axis } => (cad(combiner, vertex), cad_direction(combiner, axis)),
        ref other => panic!("{other:?}"),
    };
    let normal = DVec3::new(0.0, -1.0, 1.0).normalize();
    let (front, back) = (plane(coated(68.435)), plane(coated(99.638)));
    assert!((front.1 - normal).length() < 1e-6 && (back.1 + normal).length() < 1e-6, "{front:?} {back:?}");
    assert!((front.0 - DVec3::new(0.0, 0.0, -120.0)).dot(normal).abs() < 1e-4, "{front:?}");
    assert!(((back.0 - front.0).dot(normal) + 4.0).abs() < 1e-4);
    assert_eq!(combiner.faces.iter().filter(|face| face.finish == Finish::Absorber).count(), 4);

    let lamps: Vec<(&Part, usize)> = scene
        .parts
        .iter()
        .flat_map(|part| {
            part.faces.iter().enumerate().filter(|(_, face)| face.emitter.is_some()).map(move |(i, _)| (part, i))
        })
        .collect();
    assert_eq!(lamps.len(), 9);
    for (die, face) in lamps {
        let emitter = die.faces[face].emitter.as_ref().unwrap();
        assert_eq!(emitter.photometry, Photometry::FluxLm(flux));
        assert_eq!(scene.group(emitter.group).name, "led");
        assert!((cad_direction(die, DVec3::Z) - DVec3::Y).length() < 1e-12);
        assert!((cad(die, DVec3::ZERO).y - y).abs() < 1e-4);
    }
    let eye = &scene.eye;
    let turned = |v: DVec3| DVec3::new(v.x, v.z, -v.y);
    assert!(eye.position.length() < 1e-15 && (eye.look - turned(DVec3::NEG_Z)).length() < 1e-12);
    assert!((eye.up - turned(DVec3::Y)).length() < 1e-12);
    assert_eq!(
        (eye.pupil_diameter_m, eye.focus_distance_m, eye.fov_deg, eye.resolution),
        (0.004, f64::INFINITY, 12.0, [360, 180])
    );
    let sky = scene.sky.as_ref().unwrap();
    // The picture's middle straight ahead.
    assert!(
        (sky.to_world * DVec3::Z - eye.look).length() < 1e-12 && (sky.to_world * DVec3::Y - eye.up).length() < 1e-12
    );
    let (low, high) = sky.luminance.iter().fold((f32::MAX, 0f32), |(low, high), x| (low.min(*x), high.max(*x)));
    assert!((low - 292.0).abs() < 1.0 && (high - 21013.0).abs() < 21.0, "{low} {high}");
    assert!(
        scene
            .notes
            .iter()
            .any(|note| matches!(note.at, Where::Part { face: Some(0), .. }) && note.text.contains("µm rms"))
    );
    for black in scene
        .parts
        .iter()
        .filter(|part| ["HOUSING", "BAFFLE", "LCD_BEZEL", "LED_PCB"].iter().any(|n| part.name.starts_with(n)))
    {
        assert!(black.faces.iter().all(|face| face.finish == Finish::Absorber) && black.medium.is_none());
    }
}

#[test]
fn the_direct_hud_builds() {
    let built = sample("hud-direct/hud.optics.toml", &[]);
    let scene = &built.scene;
    check_frame(scene, 0.45, -395.707);
    check_lenses(
        scene,
        &[
            ("LENS_01_PMMA", 0, 49.25878124522123, -2.2278183778808804, -295.707),
            ("LENS_01_PMMA", 2, f64::INFINITY, 0.0, -287.707),
            ("LENS_02_NBK7", 0, 103.70447752415855, 0.0, -81.707),
            ("LENS_02_NBK7", 2, f64::INFINITY, 0.0, -76.707),
        ],
    );
    check_index(scene, "LENS_01_PMMA", 1.4925878124522123);
    check_index(scene, "LENS_02_NBK7", 1.5185223876207927);
    assert_eq!(slide(scene, -281.707, DVec3::X, DVec3::Z).size, [40.0, 20.0]);
    assert_eq!(scene.media.len(), 2);
}

#[test]
fn the_diffuse_hud_builds() {
    let built = sample("hud-diffuse/hud.optics.toml", &[]);
    let scene = &built.scene;
    check_frame(scene, 0.667, -553.7786498208955);
    check_lenses(
        scene,
        &[
            ("LENS_01_PMMA", 0, 14.777634373566368, -2.2278183778808804, -523.7786),
            ("LENS_01_PMMA", 2, f64::INFINITY, 0.0, -515.7786),
            ("LENS_02_PMMA", 0, f64::INFINITY, 0.0, -514.7786),
            ("LENS_02_PMMA", 2, -39.98267271992276, -2.2278183778808804, -509.7787),
            ("LENS_03_NSK16", 0, 18.39533, 0.0, -437.3636),
            ("LENS_03_NSK16", 2, -79.6836, 0.0, -434.4115),
            ("LENS_04_F2", 0, -20.29192, 0.0, -429.6611),
            ("LENS_04_F2", 2, 22.21328, 0.0, -428.6611),
            ("LENS_05_NSK16", 0, 435.76044, 0.0, -422.6536),
            ("LENS_05_NSK16", 2, -22.01359, 0.0, -419.3946),
            ("LENS_06_NBK7", 0, 103.70447752415855, 0.0, -82.0488),
            ("LENS_06_NBK7", 2, f64::INFINITY, 0.0, -76.0488),
        ],
    );
    check_index(scene, "LENS_03_NSK16", 1.6226076880608007);
    check_index(scene, "LENS_04_F2", 1.623655122927604);
    assert_eq!(slide(scene, -504.77865, DVec3::NEG_X, DVec3::NEG_Z).size, [20.0, 10.0]);
    let screen = part(scene, "DIFFUSER_SHEET");
    let gauss = Finish::Gauss { sigma_deg: 6.0, reflectance: 0.0, transmittance: 0.9 };
    let face = only(&screen.faces, |face| face.finish == gauss);
    assert_eq!((screen.faces.iter().filter(|face| face.finish == Finish::None).count(), screen.medium), (5, None));
    assert_eq!(face, 4);
}

#[test]
fn the_sets_of_the_samples_comments_work() {
    let sets = [
        "led.flux_lm=0",
        "LED_DIE_5.flux_lm=0.45",
        "LENS_02_NBK7.glass=N-SK16",
        "LCD_ACTIVE_AREA.contrast=100",
        "eye.pupil_diameter=3.6 mm",
        "LENS_01_PMMA.faces[0].shape.radius=50",
        "LCD_ACTIVE_AREA.size=[44, 22]",
    ];
    let built = sample("hud-direct/hud.optics.toml", &sets);
    let scene = &built.scene;
    let flux: Vec<f64> = scene
        .parts
        .iter()
        .flat_map(|part| &part.faces)
        .filter_map(|face| match face.emitter.as_ref()?.photometry {
            Photometry::FluxLm(flux) => Some(flux),
            Photometry::LuminanceCdM2(_) | Photometry::IntensityCd(_) | Photometry::AsMeasured => None,
        })
        .collect();
    assert_eq!(flux, [0.0, 0.0, 0.0, 0.0, 0.45, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!((scene.slides[0].contrast, scene.slides[0].size), (100.0, [44.0, 22.0]));
    let (radius, conic, y) = surface(part(scene, "LENS_01_PMMA"), 0);
    assert!(
        radius == 50.0 && (conic + 2.2278183778808804).abs() < 1e-4 && (y + 295.707).abs() < 1e-4,
        "{radius} {conic} {y}"
    );
    check_index(scene, "LENS_02_NBK7", 1.6226076880608007);
    let diffuse = sample("hud-diffuse/hud.optics.toml", &["DIFFUSER_SHEET.finish.sigma_deg=5", "led.flux_lm=4.3"]);
    let screen = part(&diffuse.scene, "DIFFUSER_SHEET");
    assert!(matches!(screen.faces[4].finish, Finish::Gauss { sigma_deg: 5.0, .. }));
    let lambert = "DIFFUSER_SHEET.faces[4].finish={ lambert = { transmittance = 0.9, reflectance = 0 } }";
    let diffuse = sample("hud-diffuse/hud.optics.toml", &[lambert]);
    let screen = part(&diffuse.scene, "DIFFUSER_SHEET");
    assert_eq!(screen.faces[4].finish, Finish::Lambert { reflectance: 0.0, transmittance: 0.9 });
}

#[test]
fn an_asset_with_the_sidecar_beside_it_needs_no_sidecar_named() {
    let built = sample("peers/a1/a1.glb", &[]);
    assert!(
        built.scene.notes.iter().any(|note| note.text.contains("carries no optical attributes; ")),
        "{:?}",
        built.scene.notes
    );
    assert_eq!(built.scene.hash, sample("peers/a1/a1.optics.toml", &[]).scene.hash);
    assert_eq!(built.scene.eye.pupil_diameter_m, 0.0);
    assert_eq!(sample("peers/a2/a2.optics.toml", &[]).scene.media.len(), 2);
    assert!(matches!(
        part(&sample("peers/b/b.optics.toml", &[]).scene, "lens").faces[2].shape,
        Shape::Sphere { radius: -30.0, .. }
    ));
}

#[test]
fn a_sidecar_beside_an_asset_that_names_another_is_not_taken() {
    let folder = tempfile::tempdir().unwrap();
    let home = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("samples/peers/a1");
    for name in ["a1.glb", "other.glb"] {
        std::fs::copy(home.join("a1.glb"), folder.path().join(name)).unwrap();
    }
    let sidecar = std::fs::read_to_string(home.join("a1.optics.toml")).unwrap();
    std::fs::write(folder.path().join("other.optics.toml"), sidecar).unwrap();
    let sample = sample("peers/a1/a1.optics.toml", &[]).scene;
    let bare = import(&folder.path().join("other.glb"), &ImportOptions::default()).unwrap().scene;
    assert!(sample.surfaces.is_empty() && !bare.surfaces.is_empty() && bare.eye != sample.eye);
}

#[test]
fn paths_that_lead_nowhere_are_faults() {
    let fault = |path: &str| import(Path::new(path), &ImportOptions::default()).unwrap_err().to_string();
    assert_eq!(fault("no/such.optics.toml"), "can't read the sidecar no/such.optics.toml: there is no such file");
    assert_eq!(
        fault("hud.step"),
        "hud.step is of no format that can be imported; expected .glb, .gltf, .usda, .usdc, .usdz, .usd or a sidecar .toml"
    );
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.toml");
    std::fs::write(&file, "schema = 1\nasset = \"b.glb\"\n").unwrap();
    let found = fault(&file.to_string_lossy()).replace(&*folder.path().to_string_lossy(), "");
    assert_eq!(found, "/a.toml:2: can't read the asset /b.glb: there is no such file");
    std::fs::write(&file, "schema = 1\n").unwrap();
    let found = fault(&file.to_string_lossy()).replace(&*folder.path().to_string_lossy(), "");
    assert_eq!(found, "/a.toml: `asset` is missing; expected asset = \"FILE.glb\"");
}

/// In colour the displays are those of the sidecars at 550 nm: the same faces, exact surfaces, coatings and glasses.
#[test]
fn the_samples_in_colour_are_the_same_displays() {
    for (name, lamps) in [("hud-direct", 9), ("hud-diffuse", 9)] {
        let plain = sample(&format!("{name}/hud_usd.optics.toml"), &[]).scene;
        let colour = sample(&format!("{name}/colour.optics.toml"), &[]).scene;
        assert_eq!(colour.wavelengths, eyebox_scene::Wavelengths::Visible, "{name}");
        assert_eq!(plain.parts.len(), colour.parts.len(), "{name}");
        let mut shining = 0;
        for (a, b) in plain.parts.iter().zip(&colour.parts) {
            assert_eq!((&a.name, a.faces.len()), (&b.name, b.faces.len()), "{name}");
            for (p, q) in a.faces.iter().zip(&b.faces) {
                assert_eq!(
                    (&p.shape, &p.finish, p.coating.is_some()),
                    (&q.shape, &q.finish, q.coating.is_some()),
                    "{}",
                    a.name
                );
                assert_eq!(
                    (p.emitter.is_some(), p.slide.is_some()),
                    (q.emitter.is_some(), q.slide.is_some()),
                    "{}",
                    a.name
                );
                shining += usize::from(q.emitter.is_some());
            }
            // One acrylic is known at 550 nm, another over all of the visible range.
            let index =
                |scene: &Scene, part: &Part| part.medium.map(|medium| scene.medium(medium).index.index(550.0).re);
            match (index(&plain, a), index(&colour, b)) {
                (Some(n), Some(of_colour)) => assert!((n - of_colour).abs() < 5e-3, "{}: {n} {of_colour}", a.name),
                (n, of_colour) => assert_eq!(n, of_colour, "{}", a.name),
            }
        }
        assert_eq!(shining, lamps, "{name}");
        assert!(colour.sky.is_some_and(|sky| sky.rgb.is_some()), "{name}");
    }
}

/// The town's sky by day, which a script of its own has computed, is the one that `sun_sky` makes.
#[test]
fn the_panorama_by_day_has_the_sky_of_sun_sky() {
    let town = sample("hud-direct/colour.optics.toml", &["sky.rotation_deg=0"]).scene.sky.expect("a sky");
    let day = crate::daylight::clear(3.0, 38f64.to_radians(), 0.2).picture;
    let [of_town, of_day] = [town.rgb.expect("colours"), std::sync::Arc::new(day.rgb.expect("colours"))];
    // Above all houses; the script's sun is 140° left of the middle, where ours has it.
    for elevation in [50.0, 65.0, 80.0, 88.0] {
        for longitude in (0..360).step_by(30).map(f64::from) {
            let pixel = |rgb: &[[f32; 3]], width: usize, longitude: f64| {
                let height = width / 2;
                let x = ((180.0 - longitude) / 360.0).rem_euclid(1.0) * width as f64;
                rgb[((90.0 - elevation) / 180.0 * height as f64) as usize * width + x as usize]
            };
            let found = pixel(&of_town, town.width, longitude);
            let want = pixel(&of_day, day.width, longitude - 140.0);
            for (c, (found, want)) in found.iter().zip(want).enumerate() {
                assert!((found / want - 1.0).abs() < 0.02, "{elevation}°, {longitude}°, {c}: {found} not {want}");
            }
        }
    }
}
