//! What is as it should be has neither errors nor warnings: every sample, and every attribute and kind of the vocabulary,
//! with no more said of it than it needs, in colour, which is the default.

use super::bench::Bench;
use crate::ray_files::writer::{Ray, luminous};
use eyebox::check::finding::Level;
use eyebox::import;
use eyebox::scene::attribute::{KINDS, Kind, Noun, ROWS, row};
use eyebox::validate::findings;
use serde_json::json;
use std::path::{Path, PathBuf};

const LED: &str = "emitter = { group = \"led\", luminance_cd_m2 = 5000, angular = \"lambert\", spectrum = \"led_b1\" }";
const LAMP: &str =
    "emitter = { group = \"lamp\", angular = { kind = \"profile\", file = \"lamp.ies\" }, spectrum = \"D65\" }";

/// The good asset with nothing said that has a default.
fn bare() -> Bench {
    let mut bench = Bench::new();
    for (from, to) in [
        ("wavelengths = { mono_nm = 550 }\n", ""),
        // The catalogue knows PMMA from 436.8 nm on, which in colour is a warning.
        ("glass = \"PMMA\"", "glass = \"N-BK7\""),
        (LED, "emitter = { luminance_cd_m2 = 5000 }"),
        (LAMP, "emitter = { angular = { kind = \"profile\", file = \"lamp.ies\" } }"),
        (", transmittance = 0.9, contrast = 300", ""),
        ("frame = \"asset\"\n", ""),
        ("pupil_diameter = \"4 mm\"\nfocus_distance = \"inf\"\n", ""),
        ("resolution = [32, 32]\nage = 30\n", ""),
    ] {
        bench.swap(from, to);
    }
    bench
}

/// The bare asset with a change.
fn with(change: impl Fn(&mut Bench)) -> Bench {
    let mut bench = bare();
    change(&mut bench);
    bench
}

/// A glass block beside the light's way, with this said of its front.
fn block(said: &str) -> Bench {
    with(|b| {
        b.append(&format!(
            "\n[[bind]]\npath = \"BAFFLE\"\nglass = \"N-BK7\"\n\n[[bind]]\npath = \"BAFFLE\"\nnormal = \"+z\"\n{said}\n"
        ));
    })
}

/// A plate with this instead of its glass.
fn plate(said: &str) -> Bench {
    with(|b| b.swap("path = \"PLATE_B\"\nglass = \"N-BK7\"", &format!("path = \"PLATE_B\"\n{said}")))
}

/// The lamp behind the slide, with this said of it.
fn led(said: &str) -> Bench {
    with(|b| b.swap("luminance_cd_m2 = 5000", said))
}

/// A value of a parameter that has no default; on the front of the block at z = 0.5 where it is about places.
fn needed(attribute: &str, parameter: &str) -> &'static str {
    match (attribute, parameter) {
        ("finish", "n") => "1.44",
        ("finish", "k") => "5.23",
        ("finish", "axis") => "[1, 0, 0]",
        ("finish", "alpha") => "0.1",
        ("finish", "sigma_deg") => "5",
        ("finish", "a") => "0.001",
        ("finish", "b") => "0.01",
        ("finish", "g") => "2",
        ("finish", "file") => "\"scatter.csv\"",
        ("finish", "retardance_nm") => "137.5",
        ("finish", "retardance_waves") => "0.25",
        ("finish", "ordinary_index") => "1.5",
        ("finish", "extraordinary_index") => "1.51",
        ("finish", "handedness") => "\"left\"",
        ("finish", "direction") => "[1, 0, 0]",
        ("finish", "lines_per_mm") => "600",
        ("finish", "orders") => "[{ order = -1, T = 0.3 }, { order = 0, T = 0.6 }]",
        ("coating", "stack") => "[{ n = 1.38, thickness_nm = 99.6 }, { material = \"N-BK7\", thickness_nm = 80 }]",
        ("coating", "table") => "[{ wavelength_nm = 550, angle_deg = 0, R_s = 0.1, R_p = 0.1, T_s = 0.8, T_p = 0.8 }]",
        ("shape", "vertex") => "[0, 0, 0.5]",
        ("shape", "axis") => "[0, 0, 1]",
        // As good as plane over the 60 units of the face.
        ("shape", "radius" | "tube_radius") => "1e6",
        ("shape", "conic") => "0",
        ("shape", "even" | "coeffs") => "[0]",
        ("shape", "norm_radius") => "50",
        ("shape", "half") => "[100, 100]",
        ("shape", "spans") => "[1, 1]",
        ("shape", "tolerance_um") => "1",
        ("angular", "file") => "\"lamp.ies\"",
        ("angular", "fwhm_deg") => "40",
        ("angular", "n") | ("finish", "m") => "10",
        ("spectrum", "cct") => "4000",
        ("spectrum", "rgb") => "[1, 0.5, 0.2]",
        ("spectrum", "table") => "[[450, 1], [650, 2]]",
        ("spectrum", "csv") => "\"led.csv\"",
        ("wavelengths", "mono_nm") => "550",
        _ => panic!("no value is known for `{parameter}` of {attribute}"),
    }
}

/// The kind with its parameters that have no default.
fn value(kind: &Kind) -> String {
    let noun = match kind.attribute {
        "finish" => Noun::Finish,
        "coating" => Noun::Coating,
        "shape" => Noun::Shape,
        "angular" | "spectrum" => Noun::Emitter,
        "wavelengths" => Noun::Asset,
        other => panic!("no noun is known for {other}"),
    };
    let left_out = |parameter: &str| match (kind.attribute, kind.name, parameter) {
        // A name is for others to refer to; a fit finds these itself.
        ("coating", _, "name") | ("shape", "fit", "radius" | "conic" | "tube_radius") => true,
        // Of two ways to say a thing one is enough.
        ("finish", "retarder", "retardance_waves") | ("finish", "circular_polariser", "retardance_nm") => true,
        _ => row(noun, parameter).is_some_and(|row| row.default.is_some()),
    };
    let said: String = (kind.parameters.iter().filter(|parameter| !left_out(parameter)))
        .map(|parameter| match (kind.name, *parameter) {
            // (1 + 3)² heights.
            ("bspline", "coeffs") => format!(", coeffs = {:?}", [0; 16]),
            ("ray_file", "file") => ", file = \"led.tm25ray\"".to_owned(),
            _ => format!(", {parameter} = {}", needed(kind.attribute, parameter)),
        })
        .collect();
    format!("{{ kind = \"{}\"{said} }}", kind.name)
}

/// With a white wall beside the display, for lamps that are no faces: somebody has to see their light.
fn wall(change: impl Fn(&mut Bench)) -> Bench {
    with(|b| {
        b.shift("BAFFLE", 0, 60.0);
        b.append(
            "\n[[bind]]\npath = \"BAFFLE\"\nnormal = \"+z\"\nfinish = { kind = \"lambert\", reflectance = 0.5 }\n",
        );
        change(b);
    })
}

/// Every kind of every attribute, where it may stand.
fn kinds() -> Vec<(String, Bench)> {
    let one = |kind: &Kind| {
        let said = format!("{} = {}", kind.attribute, value(kind));
        let bench = match kind.attribute {
            "finish" | "shape" => block(&said),
            "coating" => block(&format!("finish = \"polished\"\n{said}")),
            // The file has a flux of its own.
            "angular" if kind.name == "ray_file" => led(&said),
            "angular" | "spectrum" => led(&format!("luminance_cd_m2 = 5000, {said}")),
            "wavelengths" => with(|b| b.swap("unit = 0.001\n", &format!("unit = 0.001\n{said}\n"))),
            other => panic!("{other} stands nowhere"),
        };
        (format!("{} {}", kind.attribute, kind.name), bench)
    };
    KINDS.iter().map(one).collect()
}

/// What has no kinds.
fn things() -> Vec<(String, Bench)> {
    let sky = with(|b| {
        let mut hdr = Vec::new();
        let pixels = [image::Rgb([1.0f32; 3]); 8];
        image::codecs::hdr::HdrEncoder::new(&mut hdr).encode(&pixels, 4, 2).unwrap();
        b.files.insert("sky.hdr".to_owned(), hdr);
        b.append("\n[sky]\nimage = \"sky.hdr\"\n");
    });
    let media = [
        "ior = 1.5",
        "glass = \"N-BK7\"",
        "sellmeier = { b = [1.04, 0.23, 1.01], c_um2 = [0.006, 0.02, 103.6] }",
        "cauchy = [1.5, 0.004]",
        "abbe = [1.5168, 64.17]",
        "index_table = [[380, 1.53, 0], [780, 1.51, 0]]",
        "ior = 1.5\nabsorption_per_m = 2",
        "ior = 1.5\npriority = 1",
        "medium = { ior = 1.5 }",
    ];
    let lamps = [
        "flux_lm = 20",
        "luminance_cd_m2 = 5000",
        "intensity_cd = 2",
        "radiant_flux_w = 0.1, spectrum = \"A\"",
        "flux_lm = 20, u = [0, 1, 0]",
        "primaries_cd_m2 = [1000, 3000, 400]",
        "luminance_cd_m2 = 5000, image = \"slide.png\", size = [40, 40], u = [1, 0, 0], v = [0, 1, 0]",
        "flux_lm = 20, polarisation = { angle_deg = 45, degree = 0.5 }",
    ];
    let mut all = vec![
        ("bare".to_owned(), bare()),
        ("sky".to_owned(), sky),
        ("sensor".to_owned(), block("finish = \"polished\"\nsensor = { pixels = [4, 2] }")),
        ("sun".to_owned(), wall(|b| b.append("\n[sun]\ndirection = [0.2, 1, 0.3]\n"))),
        (
            "polarised slide".to_owned(),
            with(|b| b.swap("v = [0, 1, 0]", "v = [0, 1, 0], polarisation = { angle_deg = 0, degree = 1 }")),
        ),
    ];
    let skies = ["luminance_cd_m2 = 1000", "overcast_cd_m2 = 1000", "sun_sky = { elevation_deg = 30, turbidity = 3 }"];
    all.extend(skies.map(|said| (said.to_owned(), wall(|b| b.append(&format!("\n[sky]\n{said}\n"))))));
    all.extend(media.map(|said| (said.to_owned(), plate(said))));
    all.extend(lamps.map(|said| (said.to_owned(), led(said))));
    all
}

/// Without the sidecar's lamps.
fn unlit(change: impl Fn(&mut Bench)) -> Bench {
    with(|b| {
        b.swap("emitter = { luminance_cd_m2 = 5000 }", "finish = \"absorber\"");
        b.swap("emitter = { angular = { kind = \"profile\", file = \"lamp.ies\" } }", "finish = \"absorber\"");
        change(b);
    })
}

/// Lamps of the .gltf itself, of which no spectrum is said: in our attributes, as emission, and as lights.
fn gltf_lamps() -> Vec<(String, Bench)> {
    let ours = unlit(|b| {
        b.gltf["extensionsUsed"] = json!(["EYEBOX_optics"]);
        b.gltf["extensions"] = json!({ "EYEBOX_optics": { "version": 1, "emitters": [{ "luminance_cd_m2": 5000 }] } });
        b.node("LED")["extensions"] = json!({ "EYEBOX_optics": { "faces": [{ "faces": [5], "emitter": 0 }] } });
    });
    let emissive = |colour: [f64; 3]| {
        unlit(|b| {
            b.gltf["extensionsUsed"] = json!(["KHR_materials_emissive_strength"]);
            b.gltf["materials"][1]["emissiveFactor"] = json!(colour);
            b.gltf["materials"][1]["extensions"] =
                json!({ "KHR_materials_emissive_strength": { "emissiveStrength": 5000 } });
        })
    };
    let light = |light: serde_json::Value| {
        wall(|b| {
            b.gltf["extensionsUsed"] = json!(["KHR_lights_punctual"]);
            b.gltf["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light] } });
            let nodes = b.gltf["nodes"].as_array_mut().unwrap();
            let index = nodes.len();
            nodes.push(json!({
                "name": "BULB", "translation": [0, 30, -60], "extensions": { "KHR_lights_punctual": { "light": 0 } }
            }));
            nodes[0]["children"].as_array_mut().unwrap().push(json!(index));
        })
    };
    vec![
        ("emitter of the .gltf".to_owned(), ours),
        ("white emission".to_owned(), emissive([1.0; 3])),
        ("coloured emission".to_owned(), emissive([1.0, 0.5, 0.2])),
        ("point light".to_owned(), light(json!({ "type": "point" }))),
        ("spot light".to_owned(), light(json!({ "type": "spot", "spot": {} }))),
        ("directional light".to_owned(), light(json!({ "type": "directional" }))),
        ("coloured light".to_owned(), light(json!({ "type": "point", "color": [1, 0.5, 0.2] }))),
    ]
}

/// Findings of an asset that are worse than a note.
fn graver(path: &Path) -> Vec<String> {
    let found = findings(path).into_iter().filter(|finding| finding.level > Level::Note);
    found.map(|finding| format!("{} {} {}: {}", finding.level, finding.code, finding.at, finding.text)).collect()
}

fn written(mut bench: Bench, folder: &Path) -> PathBuf {
    bench.files.insert("led.csv".to_owned(), b"450,1\n650,2\n".to_vec());
    bench.files.insert("scatter.csv".to_owned(), b"R,0,0,0,0.1\nR,0,90,0,0.1\n".to_vec());
    bench.files.insert("led.tm25ray".to_owned(), luminous(&parallel()));
    bench.write(folder)
}

/// Rays along the axis, which the lens brings to the pupil.
fn parallel() -> Vec<Ray> {
    let at = |k: i32| f64::from(k) / 10.0 - 0.95;
    (0..400).map(|k| ([at(k / 20), at(k % 20), 0.5], [0.0, 0.0, 1.0], 0.1)).collect()
}

long! {
#[test]
fn every_feature_at_its_defaults_is_clean() {
    let mut wrong = Vec::new();
    for (name, bench) in kinds().into_iter().chain(things()).chain(gltf_lamps()) {
        let folder = tempfile::tempdir().unwrap();
        let found = graver(&written(bench, folder.path()));
        if !found.is_empty() {
            wrong.push(format!("{name}: {found:#?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
}

/// What the test above is about is everything: a row is said somewhere, or it has a default and is left out.
#[test]
fn every_row_is_said_or_has_a_default() {
    let all: Vec<Bench> = kinds().into_iter().chain(things()).chain(gltf_lamps()).map(|(_, bench)| bench).collect();
    let said = |name: &str| {
        let word = |text: &str| text.split(|c: char| !c.is_ascii_alphanumeric() && c != '_').any(|word| word == name);
        all.iter().any(|bench| word(&bench.sheet) || word(&bench.gltf.to_string()))
    };
    // On a face it is a fault; a sun has its own row.
    let misplaced = |noun: Noun, name: &str| noun == Noun::Emitter && name == "illuminance_lx";
    let open = ROWS.iter().filter(|row| row.default.is_none() && !misplaced(row.noun, row.name) && !said(row.name));
    let open: Vec<String> = open.map(|row| format!("{} {}", row.noun, row.name)).collect();
    assert!(open.is_empty(), "nothing says {open:?}");
}

/// The same lamp through the other carriers.
#[test]
fn lamps_without_a_spectrum_are_clean_in_every_carrier() {
    let folder = tempfile::tempdir().unwrap();
    let sheet = written(bare(), folder.path());
    for file in ["all.glb", "all.usda"] {
        let to = folder.path().join(file);
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_eyebox"));
        let run = command.arg("convert").args([&sheet, &to]).output().unwrap();
        assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
        let none: Vec<String> = Vec::new();
        assert_eq!(graver(&to), none, "{file}");
    }
}

long! {
/// Every sidecar of the samples, and every asset that says itself what it is optically.
#[test]
fn every_sample_is_clean() {
    fn below(folder: &Path, all: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() { below(&path, all) } else { all.push(path) }
        }
    }
    let mut files = Vec::new();
    below(&Path::new(env!("CARGO_MANIFEST_DIR")).join("samples"), &mut files);
    files.sort();
    let is = |path: &Path, endings: &[&str]| {
        path.file_name().is_some_and(|name| endings.iter().any(|ending| name.to_string_lossy().ends_with(ending)))
    };
    let carries = |path: &PathBuf| {
        is(path, &[".glb", ".gltf", ".usda", ".usdc", ".usdz"])
            && import::asset(path).is_ok_and(|assembly| assembly.carries_optics())
    };
    let meant: Vec<&PathBuf> = files.iter().filter(|path| is(path, &[".optics.toml"]) || carries(path)).collect();
    let sidecars = meant.iter().filter(|path| is(path, &[".optics.toml"])).count();
    assert!(sidecars >= 7 && meant.len() >= sidecars + 2, "{meant:?}");
    let wrong: Vec<String> = meant
        .iter()
        .map(|path| (path, graver(path)))
        .filter(|(_, found)| !found.is_empty())
        .map(|(path, found)| format!("{}: {found:#?}", path.display()))
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
}
