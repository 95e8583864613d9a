//! The good asset has no finding; each planted fault sets off its rule and no other. A rule without a row here fails.

use super::bench::{Bench, IES};
use eyebox::base::Code;
use eyebox::check::finding::Level;
use eyebox::validate::{findings, rules};
use serde_json::json;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Plants the fault of a rule into the asset.
type Plant = fn(&mut Bench);

/// Every rule but those of USD alone.
const PLANTS: &[(&str, Plant)] = &[
    ("EB0001", |b| b.gltf["meshes"][0]["primitives"] = json!(7)),
    ("EB0002", |b| b.swap("schema = 1", "schema 1")),
    ("EB0003", |b| {
        b.gltf["extensionsUsed"] = json!(["ACME_curved_space"]);
        b.gltf["extensionsRequired"] = json!(["ACME_curved_space"]);
    }),
    ("EB0004", |b| {
        b.gltf["materials"][0]["extensions"] = json!({ "KHR_materials_subsurface": { "scatterDistance": 1 } })
    }),
    ("EB0005", |b| b.node("BAFFLE")["rotation"] = json!([0, 0, 0, 2])),
    ("EB0006", |b| b.gltf["images"] = json!([{ "uri": "housing.png" }])),
    ("EB0007", |b| drop(b.files.remove("bench.bin"))),
    ("EB0008", |b| b.floats("BAFFLE", 0, "POSITION", |i, x| if i == 4 { f32::NAN } else { x })),
    ("EB0101", |b| b.swap("unit = 0.001\n", "")),
    ("EB0102", |b| drop(b.gltf["meshes"][0]["primitives"].as_array_mut().unwrap().remove(1))),
    ("EB0103", |b| {
        for face in 0..6 {
            b.floats("PLATE_A", face, "NORMAL", |_, x| -x);
            b.data("PLATE_A", face, "indices").chunks_exact_mut(12).for_each(|triangle| {
                let (first, rest) = triangle.split_at_mut(4);
                first.swap_with_slice(&mut rest[..4]);
            });
        }
    }),
    ("EB0104", |b| b.shift("PLATE_B", 2, -102.0)),
    ("EB0105", |b| b.shift("PLATE_B", 2, -103.0)),
    ("EB0106", |b| {
        b.swap("shape = { kind = \"sphere\", vertex = [0, 0, 4], axis = [0, 0, 1], radius = -60 }\n", "");
    }),
    ("EB0107", |b| b.swap("radius = -60", "radius = -40")),
    ("EB0108", |b| b.floats("LENS", 2, "NORMAL", |i, x| if i < 3 { -x } else { x })),
    ("EB0109", |b| b.node("STOP")["name"] = json!("BAFFLE")),
    ("EB0110", |b| b.data("BAFFLE", 0, "indices")[4..8].copy_from_slice(&[0; 4])),
    ("EB0111", |b| b.node("LENS")["scale"] = json!([1, 1, 1.2])),
    ("EB0112", |b| b.node("STOP")["scale"] = json!([1, 1, 0])),
    ("EB0113", |b| b.floats("LENS", 2, "NORMAL", |_, x| -x)),
    ("EB0114", |b| b.gltf["scenes"][0]["nodes"] = json!([])),
    ("EB0116", |b| {
        let indices = b.data("LED", 5, "indices");
        let (first, second) = indices.split_at_mut(indices.len() / 2);
        second.copy_from_slice(first);
    }),
    ("EB0201", |b| b.swap("[[bind]]\npath = \"PLATE_B\"\nglass = \"PMMA\"\n", "")),
    ("EB0202", |b| b.swap("glass = \"PMMA\"", "ior = 0.67")),
    ("EB0203", |b| b.swap("mono_nm = 550", "mono_nm = 420")),
    ("EB0204", |b| b.swap("T = 0.5", "T = 0.6")),
    ("EB0205", |b| b.append("\n[[bind]]\npath = \"BAFFLE\"\nfinish = \"absorber\"\ncoating = \"ar\"\n")),
    ("EB0206", |b| {
        b.append(
            "\n[[bind]]\npath = \"BAFFLE\"\nfinish = { kind = \"lambert\", reflectance = 0.7, transmittance = 0.6 }\n",
        );
    }),
    ("EB0207", |b| b.append("\n[coating.spare]\nideal = { R = 0.1, T = 0.9 }\n")),
    ("EB0208", |b| b.gltf["materials"].as_array_mut().unwrap().push(json!({ "name": "CHROME" }))),
    ("EB0209", |b| b.swap("glass = \"N-BK7\"", "glass = \"N-BK8\"")),
    ("EB0210", |b| b.swap("glass = \"PMMA\"", "glass = \"PMMA\"\nabsorption_per_m = [[600, 1], [700, 1]]")),
    ("EB0211", |b| {
        b.gltf["materials"][0]["extensions"] = json!({
            "KHR_materials_transmission": { "transmissionFactor": 0.5 },
            "KHR_materials_volume": { "thicknessFactor": 1 },
        });
    }),
    ("EB0212", |b| {
        b.files.insert("own.agf".into(), b"NM X 1 0 1.6 50\nCD 2.25\nLD 0.3 2.5\n".to_vec());
        b.swap("glass = \"PMMA\"", "glass = \"own.agf#X\"");
    }),
    ("EB0301", |b| b.swap("luminance_cd_m2 = 5000, ", "")),
    ("EB0302", |b| b.swap("luminance_cd_m2 = 5000, ", "luminance_cd_m2 = 5000, flux_lm = 1, ")),
    ("EB0303", |b| b.gltf["materials"][1]["emissiveFactor"] = json!([1, 1, 1])),
    ("EB0304", |b| b.swap("lamp.ies", "lump.ies")),
    ("EB0305", |b| drop(b.files.insert("lamp.ies".into(), IES.replace("10 7 0", "10 7").into_bytes()))),
    ("EB0306", |b| {
        let bulb = IES.replace("1 -1 1 3", "1 -1 1 4").replace("0 45 90", "0 45 90 180").replace("10 7 0", "10 7 5 5");
        b.files.insert("lamp.ies".into(), bulb.into_bytes());
    }),
    ("EB0307", |b| {
        b.swap(
            "emitter = { group = \"led\", luminance_cd_m2 = 5000, angular = \"lambert\", spectrum = \"led_b1\" }",
            "finish = \"absorber\"",
        );
        b.swap(
            "emitter = { group = \"lamp\", angular = { kind = \"profile\", file = \"lamp.ies\" }, spectrum = \"D65\" }",
            "finish = \"absorber\"",
        );
    }),
    ("EB0308", |b| b.swap("luminance_cd_m2 = 5000", "luminance_cd_m2 = 5e9")),
    ("EB0309", |b| b.floats("LED", 5, "POSITION", |i, x| if i % 3 == 1 { 0.0 } else { x })),
    ("EB0310", |b| b.swap("group = \"led\"", "group = \"1-led\"")),
    ("EB0311", |b| b.swap("spectrum = \"D65\"", "spectrum = { table = [[900, 1], [950, 1]] }")),
    ("EB0401", |b| b.swap("size = [24, 24], ", "")),
    ("EB0402", |b| b.swap("slide.png", "slyde.png")),
    ("EB0403", |b| b.swap("size = [24, 24]", "size = [30, 30]")),
    ("EB0404", |b| b.swap("size = [24, 24]", "size = [24, 20]")),
    ("EB0501", |b| b.sheet.truncate(b.sheet.find("[eye]").unwrap())),
    ("EB0502", |b| b.swap("position = [\"0 mm\", \"0 mm\", \"0 mm\"]", "position = [\"0 mm\", \"0 mm\", \"-100 mm\"]")),
    ("EB0503", |b| b.swap("up = [0, 1, 0]", "up = [0, 0, 1]")),
    ("EB0504", |b| b.swap("look = [0, 0, -1]", "look = [0, 0, 1]")),
    ("EB0505", |b| b.shift("BAFFLE", 0, 0.0)),
    ("EB0601", |b| {
        b.swap("[default]\nfinish = \"absorber\"\n", "");
        // Else what nothing binds looks as its material says.
        b.gltf.as_object_mut().expect("an asset").remove("materials");
        for mesh in b.gltf["meshes"].as_array_mut().expect("meshes") {
            for face in mesh["primitives"].as_array_mut().expect("faces") {
                face.as_object_mut().expect("a face").remove("material");
            }
        }
    }),
    ("EB0602", |b| b.append("\n[[bind]]\npath = \"BAFFEL\"\nfinish = \"absorber\"\n")),
    ("EB0603", |b| b.swap("luminance_cd_m2", "luminance_cd")),
    ("EB0604", |b| b.append("\n[[bind]]\npath = \"LCD\"\nfinish = \"absorber\"\n")),
    ("EB0605", |b| {
        b.swap("frame = \"asset\"", "frame = \"PAIR\"");
        for _ in 0..2 {
            let nodes = b.gltf["nodes"].as_array_mut().unwrap();
            nodes.push(json!({ "name": "PAIR" }));
            let index = nodes.len() - 1;
            nodes[0]["children"].as_array_mut().unwrap().push(json!(index));
        }
    }),
    ("EB0606", |b| {
        let nodes = b.gltf["nodes"].as_array_mut().unwrap();
        nodes.push(json!({ "name": "EMPTY", "extensions": { "EYEBOX_optics": { "priority": 1 } } }));
        let index = nodes.len() - 1;
        nodes[0]["children"].as_array_mut().unwrap().push(json!(index));
    }),
    ("EB0607", |b| b.swap("luminance_cd_m2 = 5000", "luminance_cd_m2 = -1")),
    ("EB0608", |b| {
        let film = "{ n = 1.38, thickness_nm = 99.6 }";
        b.swap(film, &[film; 65].join(", "));
    }),
];

fn found(path: &Path) -> Vec<(&'static str, String)> {
    findings(path).into_iter().map(|finding| (finding.code, format!("{}: {}", finding.at, finding.text))).collect()
}

#[test]
fn the_good_asset_has_no_finding() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(found(&Bench::new().write(folder.path())), []);
    // By its own name, too: the sidecar beside it is found.
    std::fs::copy(folder.path().join("bench.optics.toml"), folder.path().join("other.toml")).unwrap();
    assert_eq!(found(&folder.path().join("bench.gltf")), []);
}

/// Nobody has said what any part is: the asset is a picture, with an eye and a sky that are assumed.
#[test]
fn an_asset_without_a_word_of_optics_lacks_nothing() {
    let folder = tempfile::tempdir().unwrap();
    Bench::new().write(folder.path());
    std::fs::remove_file(folder.path().join("bench.optics.toml")).unwrap();
    let found = found(&folder.path().join("bench.gltf"));
    let missing = |(code, _): &&(&str, String)| ["EB0501", "EB0307", "EB0102"].contains(code);
    assert_eq!(found.iter().find(missing), None);
}

#[test]
fn a_planted_fault_sets_off_its_rule_and_no_other() {
    let mut wrong = Vec::new();
    for (code, plant) in PLANTS {
        let folder = tempfile::tempdir().unwrap();
        let mut bench = Bench::new();
        plant(&mut bench);
        let found = found(&bench.write(folder.path()));
        let codes: BTreeSet<&str> = found.iter().map(|(code, _)| *code).collect();
        if codes != BTreeSet::from([*code]) {
            wrong.push(format!("{code}: {found:#?}"));
        }
    }
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), PLANTS.len(), wrong.join("\n"));
}

/// The same asset as a USD stage, as `eyebox convert` writes it.
fn stage(folder: &Path) -> PathBuf {
    let sheet = Bench::new().write(folder);
    let stage = folder.join("bench.usda");
    let done = std::process::Command::new(env!("CARGO_BIN_EXE_eyebox"))
        .arg("convert")
        .args([&sheet, &stage])
        .output()
        .unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    stage
}

#[test]
fn the_unit_of_a_stage() {
    let folder = tempfile::tempdir().unwrap();
    let stage = stage(folder.path());
    assert_eq!(found(&stage), []);
    let text = std::fs::read_to_string(&stage).unwrap();
    let without: Vec<&str> = text.lines().filter(|line| !line.contains("metersPerUnit")).collect();
    std::fs::write(&stage, without.join("\n")).unwrap();
    let found = found(&stage);
    assert!(found.iter().any(|(code, _)| *code == "EB0115"), "{found:?}");
}

/// A new rule needs a row above.
#[test]
fn every_rule_is_planted() {
    let planted: Vec<&str> = PLANTS.iter().map(|(code, _)| *code).chain(["EB0115"]).collect();
    let missing: Vec<&str> = rules::all().map(|rule| rule.code).filter(|code| !planted.contains(code)).collect();
    assert!(missing.is_empty(), "no fault is planted for {missing:?}");
    let codes: Vec<&str> = rules::all().map(|rule| rule.code).collect();
    assert!(codes.windows(2).all(|pair| pair[0] < pair[1]), "codes are unique: {codes:?}");
    let names: BTreeSet<&str> = rules::all().map(|rule| rule.name).collect();
    assert_eq!(names.len(), codes.len(), "names are unique");
    assert!(planted.iter().all(|code| rules::find(code).is_some()));
    let lost: Vec<_> = Code::ALL.iter().filter(|code| rules::find(code.rule()).is_none()).collect();
    assert!(lost.is_empty(), "no rule has {lost:?}");
}

/// Faults are found side by side, not one a run.
#[test]
fn several_faults_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let mut bench = Bench::new();
    for code in ["EB0204", "EB0302", "EB0401", "EB0503", "EB0602", "EB0209", "EB0102"] {
        let plant = PLANTS.iter().find(|(own, _)| *own == code).unwrap().1;
        plant(&mut bench);
    }
    let found = found(&bench.write(folder.path()));
    let codes: BTreeSet<&str> = found.iter().map(|(code, _)| *code).collect();
    assert_eq!(
        codes,
        BTreeSet::from(["EB0102", "EB0204", "EB0209", "EB0302", "EB0401", "EB0503", "EB0602"]),
        "{found:#?}"
    );
}

/// Names of the author's that sound like messages of other rules.
#[test]
fn words_of_a_message_decide_nothing() {
    for words in [
        "there is no eye",
        "no optical attributes bind",
        "is bound twice with the same precedence",
        "the asset requires an extension that is not known here",
        "`spectrum`",
    ] {
        let folder = tempfile::tempdir().unwrap();
        let mut bench = Bench::new();
        bench.append(&format!("\n[[bind]]\npath = \"{words}\"\nfinish = \"absorber\"\n"));
        let found = found(&bench.write(folder.path()));
        let codes: Vec<&str> = found.iter().map(|(code, _)| *code).collect();
        assert_eq!(codes, ["EB0602"], "{found:#?}");
    }
}

/// A wrong normal on a face that has an exact shape changes no ray.
#[test]
fn normals_of_exact_faces_are_a_note() {
    let level = |face: usize| {
        let folder = tempfile::tempdir().unwrap();
        let mut bench = Bench::new();
        bench.floats("LENS", face, "NORMAL", |i, x| if i < 3 { -x } else { x });
        let found = findings(&bench.write(folder.path()));
        found.iter().find(|finding| finding.code == "EB0108").map(|finding| finding.level)
    };
    assert_eq!((level(0), level(2)), (Some(Level::Note), Some(Level::Warning)));
}
