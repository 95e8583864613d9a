//! Ray files through the sidecar, glTF and USD, and the words of the commands.

use super::writer::{Tm25, lambertian, luminous, row, tm25};
use eyebox::import::{ImportOptions, Set, import};
use eyebox::scene::{BeaconForm, Scene, Spectrum};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A copy of a sample whose display is a lamp of this text, beside the files.
fn folder(emitter: &str, files: &[(&str, Vec<u8>)]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples/birdbath");
    std::fs::copy(own.join("birdbath.glb"), folder.path().join("birdbath.glb")).unwrap();
    files.iter().for_each(|(name, bytes)| std::fs::write(folder.path().join(name), bytes).unwrap());
    let text = std::fs::read_to_string(own.join("birdbath.optics.toml")).unwrap();
    let line = text.lines().find(|line| line.starts_with("emitter")).expect("a display");
    let path = folder.path().join("led.optics.toml");
    std::fs::write(&path, text.replace(line, &format!("emitter = {{ {emitter} }}"))).unwrap();
    (folder, path)
}

fn scene_of(path: &Path, sets: &[&str]) -> Result<Scene, String> {
    let sets = sets.iter().map(|text| Set::parse(text).unwrap()).collect();
    let built = import(path, &ImportOptions { sets, ..ImportOptions::default() });
    built.map(|built| built.scene).map_err(|fault| fault.to_string())
}

fn eyebox(words: &[&str], path: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_eyebox")).arg(words[0]).arg(path).args(&words[1..]).output().expect("it runs")
}

fn flux(scene: &Scene) -> f64 {
    let of = |form: &BeaconForm| match form {
        BeaconForm::Rays { flux_lm, .. } => *flux_lm,
        BeaconForm::Point { .. } | BeaconForm::Profile { .. } | BeaconForm::Distant { .. } => panic!("{form:?}"),
    };
    scene.lights.iter().map(|light| of(&light.form)).sum()
}

const LAMP: &str = "group = \"led\", angular = { kind = \"ray_file\", file = \"led.tm25ray\" }";

#[test]
fn every_carrier_has_the_same_lamp() {
    let rays = lambertian(500, 1.0, 2.5);
    let (folder, path) = folder(LAMP, &[("led.tm25ray", luminous(&rays))]);
    let said = scene_of(&path, &[]).unwrap();
    assert_eq!((said.lights.len(), said.group(said.lights[0].group).name.as_str()), (1, "led"));
    assert!((flux(&said) - 2.5).abs() < 1e-5);
    for kind in ["glb", "usda"] {
        let to = folder.path().join(format!("led.{kind}"));
        let out = eyebox(&["convert", to.to_str().unwrap()], &path);
        assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
        let carried = scene_of(&to, &[]).unwrap();
        let forms = |scene: &Scene| scene.lights.iter().map(|light| light.form.clone()).collect::<Vec<_>>();
        assert_eq!(forms(&carried), forms(&said), "{kind}");
    }
    let out = eyebox(&["inspect", "--format", "json"], &path);
    let json: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();
    let lamps = json["optics"]["lamps"].as_array().unwrap();
    let lamp = lamps.iter().find(|lamp| lamp["kind"] == "ray file").unwrap();
    assert!((lamp["flux_lm"].as_f64().unwrap() - 2.5).abs() < 1e-5 && lamp["group"] == "led", "{lamp}");
    let out = eyebox(&["inspect"], &path);
    let text = String::from_utf8_lossy(&out.stdout).into_owned();
    assert!(text.contains("led: 1 light, 2.5 lm"), "{text}");
    // The file is one of the scene's: another one makes another scene.
    std::fs::write(folder.path().join("led.tm25ray"), luminous(&lambertian(501, 1.0, 2.5))).unwrap();
    assert_ne!(scene_of(&path, &[]).unwrap().hash, said.hash);
}

#[test]
fn the_flux_is_the_files_unless_something_else_is_said() {
    let rays = lambertian(300, 1.0, 3.0);
    let watts = [true, false, false, false, false, false];
    // A box of 10 nm about the peak of V: 682 lm/W within 0.5 %.
    let spectrum = vec![(550.0, 1.0), (560.0, 1.0)];
    let of_watts = |head: Tm25| {
        let rows: Vec<Vec<f32>> = rays.iter().map(|ray| row(ray, &[ray.2 as f32])).collect();
        tm25(&Tm25 { flags: watts, ..head }, &rows)
    };
    let told = of_watts(Tm25 { spectral: 3, spectra: vec![spectrum], watts: 3.0, ..Tm25::default() });
    let bare = of_watts(Tm25 { watts: 3.0, ..Tm25::default() });
    let stated = of_watts(Tm25 { watts: 3.0, lumens: 11.0, ..Tm25::default() });
    let scaled = Tm25 { lumens: 11.0, flags: [false, false, true, false, false, false], ..Tm25::default() };
    let rows: Vec<Vec<f32>> = rays.iter().map(|ray| row(ray, &[ray.2 as f32])).collect();
    let few =
        of_watts(Tm25 { spectral: 3, spectra: vec![vec![(550.0, 1.0), (560.0, 1.0)]], watts: 30.0, ..Tm25::default() });
    let files = [
        ("scaled.tm25ray", tm25(&scaled, &rows)),
        ("few.tm25ray", few),
        ("led.tm25ray", luminous(&rays)),
        ("told.tm25ray", told),
        ("bare.tm25ray", bare),
        ("stated.tm25ray", stated),
    ];
    let colour = "wavelengths=visible";
    for (name, rest, set, want) in [
        ("led", "", colour, 3.0),
        ("led", "flux_lm = 7, ", colour, 7.0),
        ("told", "", colour, 3.0 * 682.0),
        ("told", "flux_lm = 7, ", colour, 7.0),
        ("told", "radiant_flux_w = 1, ", colour, 682.0),
        ("led", "radiant_flux_w = 1, spectrum = { table = [[550, 1], [560, 1]] }, ", colour, 682.0),
        ("bare", "spectrum = { table = [[550, 1], [560, 1]] }, ", colour, 3.0 * 682.0),
        ("bare", "flux_lm = 2, ", colour, 2.0),
        ("stated", "", colour, 11.0),
        // What the header states holds, as where somebody has taken the first rays of a longer file.
        ("scaled", "", colour, 11.0),
        ("few", "", colour, 30.0 * 682.0),
        // All light of a scene of one wavelength has that: V(510) = 0.503.
        ("bare", "", "wavelengths.mono_nm=510", 3.0 * 683.0 * 0.503),
    ] {
        let text = format!("group = \"led\", {rest}angular = {{ kind = \"ray_file\", file = \"{name}.tm25ray\" }}");
        let (_folder, path) = folder(&text, &files);
        let scene = scene_of(&path, &[set]).unwrap_or_else(|fault| panic!("{fault}"));
        let found = flux(&scene);
        assert!((found / want - 1.0).abs() < 5e-3, "{name} {rest}: {found}, want {want}");
        if name == "told" {
            assert!(matches!(&scene.lights[0].spectrum, Some(Spectrum::Table(rows)) if rows.len() == 2));
        }
    }
    for (name, rest, want) in [
        ("bare", "", "radiant flux alone, of a spectrum that nobody says; expected flux_lm or a spectrum"),
        ("led", "luminance_cd_m2 = 5, ", "`luminance_cd_m2` of emitter is of a face, and the rays of a file are none"),
        ("led", "flux_lm = 1, sides = \"both\", ", "`sides` of emitter is of a face"),
        ("led", "flux_lm = 1, radiant_flux_w = 1, ", "flux_lm and radiant_flux_w"),
        ("none", "", "there is no such file"),
    ] {
        let text = format!("group = \"led\", {rest}angular = {{ kind = \"ray_file\", file = \"{name}.tm25ray\" }}");
        let (_folder, path) = folder(&text, &files);
        let found = scene_of(&path, &[colour]).expect_err("a fault");
        assert!(found.contains(want) && !found.contains('\n'), "{found}, not {want}");
    }
}

/// A wavelength for each ray makes lamps of 10 nm each, whose fluxes are those of their rays.
#[test]
fn rays_keep_their_colours() {
    let head = Tm25 { spectral: 2, flags: [true, true, false, false, false, false], ..Tm25::default() };
    let rows: Vec<Vec<f32>> = lambertian(400, 1.0, 400.0)
        .iter()
        .enumerate()
        .map(|(k, ray)| row(ray, &[1.0, 450.0 + 0.25 * k as f32]))
        .collect();
    let (_folder, path) = folder(LAMP, &[("led.tm25ray", tm25(&head, &rows))]);
    let scene = scene_of(&path, &["wavelengths=visible"]).unwrap();
    assert_eq!(scene.lights.len(), 10);
    let want: f64 = (0..400).map(|k| 683.0 * eyebox::base::colour::cmf(450.0 + 0.25 * f64::from(k))[1]).sum();
    assert!((flux(&scene) / want - 1.0).abs() < 1e-6, "{} {want}", flux(&scene));
    // One spectrum for all of them is one that the sidecar says.
    let all = format!("{LAMP}, spectrum = \"equal\"");
    let (_folder, path) = folder_of(&all, tm25(&head, &rows));
    let scene = scene_of(&path, &["wavelengths=visible"]).unwrap();
    assert!(scene.lights.iter().all(|light| light.spectrum == Some(Spectrum::Equal)));
}

fn folder_of(emitter: &str, file: Vec<u8>) -> (tempfile::TempDir, PathBuf) {
    folder(emitter, &[("led.tm25ray", file)])
}

/// The program refuses what would be black, and says where a broken file is.
#[test]
fn refusals_end_with_2() {
    let rays = lambertian(200, 1.0, 1.0);
    let (folder, path) = folder(LAMP, &[("led.tm25ray", luminous(&rays))]);
    let picture = folder.path().join("a.exr");
    let render = |words: &[&str]| {
        let all =
            [&["render", "-o", picture.to_str().unwrap(), "--samples", "1", "--resolution", "8x8"], words].concat();
        let out = eyebox(&all, &path);
        (out.status.code(), String::from_utf8_lossy(&out.stderr).into_owned())
    };
    let (code, text) = render(&["--estimator", "backward"]);
    assert!(code == Some(2) && text.contains("no path from the eye meets the rays of a file"), "{code:?} {text}");
    let bytes = luminous(&rays);
    std::fs::write(folder.path().join("led.tm25ray"), &bytes[..bytes.len() - 7]).unwrap();
    let (code, text) = render(&[]);
    assert_eq!(code, Some(2));
    assert!(text.trim().lines().count() == 1 && text.contains("led.tm25ray") && text.contains("is cut off"), "{text}");
}
