//! `eyebox inspect` and `eyebox init` as programs: what they print and where, exit codes, and what they refuse.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn eyebox(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_eyebox")).args(arguments).output().expect("the program runs")
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).expect("UTF-8")
}

fn sample(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("samples").join(file)
}

#[test]
fn a_bare_asset_is_shown_then_gets_a_sidecar_and_can_be_inspected() {
    let folder = tempfile::tempdir().expect("a folder");
    let (asset, sidecar) = (folder.path().join("hud_direct.glb"), folder.path().join("hud.optics.toml"));
    std::fs::copy(sample("hud-direct/hud_direct.glb"), &asset).expect("a copy");
    let (asset, sidecar) = (asset.to_str().expect("UTF-8"), sidecar.to_str().expect("UTF-8"));

    // No attributes: it looks as its materials say. The unit is doubted.
    let bare = eyebox(&["inspect", asset]);
    assert_eq!((bare.status.code(), text(&bare.stderr)), (Some(0), ""));
    let shown = text(&bare.stdout);
    for expected in ["├─ LENS_01_PMMA: ", "LED_DIE_1 … LED_DIE_9 (9 alike)", "looks like millimetres"] {
        assert!(shown.contains(expected), "{expected} is missing:\n{shown}");
    }
    assert!(shown.find("warning:") < shown.find("info:"), "warnings first:\n{shown}");

    let init = eyebox(&["init", asset, "-o", sidecar]);
    assert_eq!((init.status.code(), text(&init.stderr)), (Some(0), ""));
    assert!(text(&init.stdout).contains("TODO flux_lm of LED_DIE_*"), "{}", text(&init.stdout));
    let before = std::fs::read(sidecar).expect("it was written");
    std::fs::write(sidecar, "mine").expect("a file");
    let again = eyebox(&["init", asset, "-o", sidecar]);
    assert_eq!(again.status.code(), Some(2));
    assert!(text(&again.stderr).contains("this file exists; expected another name, or --force"));
    assert_eq!(std::fs::read(sidecar).expect("it is there"), b"mine");
    assert_eq!(eyebox(&["init", asset, "-o", sidecar, "--force", "--format", "json"]).status.code(), Some(0));
    assert_eq!(std::fs::read(sidecar).expect("it is there"), before);

    let json = eyebox(&["inspect", sidecar, "--format", "json", "--set", "led.flux_lm=0.5"]);
    assert_eq!((json.status.code(), text(&json.stderr)), (Some(0), ""));
    let tree: serde_json::Value = serde_json::from_slice(&json.stdout).expect("JSON");
    assert_eq!(tree["optics"]["groups"][0]["flux_lm"], 4.5);
    assert_eq!(tree["parts"][0]["medium"]["name"], "PMMA");
}

/// What is assumed of an asset that is no optics is written down, and is the same then.
#[test]
fn a_picture_keeps_its_eye_its_sky_and_its_looks() {
    let folder = tempfile::tempdir().expect("a folder");
    let (asset, sidecar) = (folder.path().join("card.gltf"), folder.path().join("own.optics.toml"));
    let numbers = [-1.0f32, -1.0, 0.0, 1.0, -1.0, 0.0, 1.0, 1.0, 0.0, -1.0, 1.0, 0.5];
    let indices = [0u16, 1, 2, 0, 2, 3].iter().flat_map(|index| index.to_le_bytes());
    let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).chain(indices).collect();
    std::fs::write(folder.path().join("card.bin"), &bytes).expect("a file");
    let json = serde_json::json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }],
        "nodes": [{ "name": "Card", "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1, "material": 0 }] }],
        "materials": [{ "name": "Paint", "pbrMetallicRoughness": {
            "baseColorFactor": [0.5, 0.25, 0.125, 1], "metallicFactor": 0, "roughnessFactor": 0.5 } }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0.5] },
            { "bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR" }],
        "bufferViews": [{ "buffer": 0, "byteLength": 48 }, { "buffer": 0, "byteOffset": 48, "byteLength": 12 }],
        "buffers": [{ "byteLength": 60, "uri": "card.bin" }] });
    std::fs::write(&asset, json.to_string()).expect("a file");
    let (asset, sidecar) = (asset.to_str().expect("UTF-8"), sidecar.to_str().expect("UTF-8"));
    let tree = |file: &str| -> serde_json::Value {
        let run = eyebox(&["inspect", file, "--format", "json"]);
        assert_eq!((run.status.code(), text(&run.stderr)), (Some(0), ""));
        serde_json::from_slice(&run.stdout).expect("JSON")
    };
    let bare = tree(asset);
    let look = &bare["parts"][0]["faces"][0]["look"];
    assert_eq!((&look["material"], &look["kind"]), (&"Paint".into(), &"dielectric".into()));
    assert_eq!(look["base_color"], serde_json::json!([0.5, 0.25, 0.125]));
    let shown = eyebox(&["inspect", asset]);
    let look = "surface Paint: dielectric, base colour (0.5, 0.25, 0.125), roughness 0.5";
    assert!(text(&shown.stdout).contains(look), "{}", text(&shown.stdout));

    let init = eyebox(&["init", asset, "-o", sidecar]);
    assert_eq!((init.status.code(), text(&init.stderr)), (Some(0), ""));
    let written = std::fs::read_to_string(sidecar).expect("it was written");
    assert!(written.contains("\n[sky]") && written.contains("\n[eye]") && written.contains("# assumed"), "{written}");
    let told = tree(sidecar);
    for what in ["parts", "bounds"] {
        assert_eq!(told[what], bare[what], "{what}");
    }
    for what in ["sky", "lamps", "groups"] {
        assert_eq!(told["optics"][what], bare["optics"][what], "{what}");
    }
    for what in ["pupil_diameter_m", "fov_deg", "resolution", "position"] {
        assert_eq!(told["optics"]["eye"][what], bare["optics"]["eye"][what], "{what}");
    }
    let valid = eyebox(&["validate", asset]);
    assert_eq!(valid.status.code(), Some(0), "{}", text(&valid.stdout));
}

#[test]
fn explain_names_the_line_and_the_nearest_part() {
    let sidecar = sample("hud-direct/hud.optics.toml");
    let sidecar = sidecar.to_str().expect("UTF-8");
    let explained = eyebox(&["inspect", sidecar, "--explain", "LENS_01_PMMA", "--format", "json"]);
    assert_eq!(explained.status.code(), Some(0));
    let parts: serde_json::Value = serde_json::from_slice(&explained.stdout).expect("JSON");
    let rows = parts["parts"][0]["rows"].as_array().expect("rows");
    let row = rows.iter().find(|row| row["face"] == 0 && row["attribute"] == "finish").expect("face 0 has a finish");
    let written = std::fs::read_to_string(sidecar).expect("the sample is there");
    let line = 2 + written.lines().position(|line| line.starts_with("faces = [0, 2]")).expect("the caps are bound");
    assert_eq!(row["at"]["Line"]["line"], line);
    let unknown = eyebox(&["inspect", sidecar, "--explain", "LENS_01_PMA"]);
    assert_eq!((unknown.status.code(), text(&unknown.stdout)), (Some(2), ""));
    assert!(text(&unknown.stderr).contains("did you mean `LENS_01_PMMA`?"), "{}", text(&unknown.stderr));
}

#[test]
fn what_render_refuses_inspect_refuses_with_the_same_words_after_the_tree() {
    let sidecar = sample("hud-direct/hud.optics.toml");
    let sidecar = sidecar.to_str().expect("UTF-8");
    let folder = tempfile::tempdir().expect("a folder");
    let output = folder.path().join("a.exr");
    let output = output.to_str().expect("UTF-8");
    for set in [
        "LENS_01_PMMA.faces[0].shape={kind=\"sphere\",vertex=[0,0,0],axis=[0,0,1],radius=1}",
        "eye.resolution=[60000,60000]",
    ] {
        let inspect = eyebox(&["inspect", sidecar, "--set", set]);
        assert_eq!(inspect.status.code(), Some(2), "{set}");
        assert!(text(&inspect.stdout).contains("LENS_01_PMMA"), "{set}");
        let render = eyebox(&["render", sidecar, "-o", output, "--set", set]);
        assert_eq!((render.status.code(), text(&render.stderr)), (Some(2), text(&inspect.stderr)), "{set}");
    }
}

#[test]
fn geometry_alone_with_totals() {
    let asset = sample("hud-direct/hud_direct.glb");
    let asset = asset.to_str().expect("UTF-8");
    let shown = eyebox(&["inspect", asset, "--geometry", "--format", "json"]);
    assert_eq!((shown.status.code(), text(&shown.stderr)), (Some(0), ""));
    let facts: serde_json::Value = serde_json::from_slice(&shown.stdout).expect("JSON");
    // The second opinion: the `gltf` crate's own accessors.
    let (document, buffers, _) = gltf::import(asset).expect("the gltf crate reads the sample");
    let triangles = |mesh: &gltf::Mesh| -> usize {
        mesh.primitives().filter_map(|p| p.indices().map(|indices| indices.count() / 3)).sum()
    };
    assert!(!buffers.is_empty());
    assert_eq!(facts["totals"]["mesh_triangles"], document.meshes().map(|mesh| triangles(&mesh)).sum::<usize>());
    assert_eq!(facts["totals"]["materials"], document.materials().count());
    assert_eq!(facts["totals"]["parts"], document.nodes().filter(|node| node.mesh().is_some()).count());
    let part = &facts["parts"][0];
    assert!(part["bounds_m"]["low"][0].is_f64() && part["faces"].as_u64() > Some(0), "{part}");
    let text_form = eyebox(&["inspect", asset, "--geometry"]);
    assert!(text(&text_form.stdout).contains("LENS_01_PMMA: "), "{}", text(&text_form.stdout));
}

#[test]
fn dependencies_and_missing_ones() {
    let sidecar = sample("hud-direct/hud.optics.toml");
    let listed = eyebox(&["inspect", sidecar.to_str().expect("UTF-8"), "--deps", "--format", "json"]);
    assert_eq!((listed.status.code(), text(&listed.stderr)), (Some(0), ""));
    let all: serde_json::Value = serde_json::from_slice(&listed.stdout).expect("JSON");
    let found: Vec<(String, String)> = all["files"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|one| {
            let file = Path::new(one["file"].as_str().expect("a path"));
            let name = file.file_name().expect("a name").to_string_lossy().into_owned();
            (one["role"].as_str().expect("a role").to_owned(), name)
        })
        .collect();
    for (role, name) in [
        ("sidecar", "hud.optics.toml"),
        ("asset", "hud_direct.glb"),
        ("image", "slide_direct.png"),
        ("image", "env_day.exr"),
    ] {
        assert!(found.contains(&(role.to_owned(), name.to_owned())), "{role} {name} is not in {found:?}");
    }

    // A bare asset with a buffer that is there, one that is not, and a texture, which nobody needs.
    let folder = tempfile::tempdir().expect("a folder");
    let asset = folder.path().join("a.gltf");
    std::fs::write(folder.path().join("here.bin"), [0; 4]).expect("a file");
    let json = r#"{ "asset": { "version": "2.0" }, "images": [{ "uri": "no.png" }], "buffers": [
        { "byteLength": 4, "uri": "here.bin" }, { "byteLength": 4, "uri": "gone%20away.bin" } ],
        "extensions": { "EYEBOX_optics": { "slides": [{ "image": { "uri": "slide.png" } }] } } }"#;
    std::fs::write(&asset, json).expect("a file");
    let listed = eyebox(&["inspect", asset.to_str().expect("UTF-8"), "--deps"]);
    assert_eq!(listed.status.code(), Some(1));
    let lines: Vec<&str> = text(&listed.stdout).lines().collect();
    let ends = [
        "a.gltf (asset)",
        "here.bin (buffer, named at",
        "gone away.bin (buffer, named at",
        "no.png (texture, named at",
        "slide.png (image, named at",
    ];
    assert_eq!(lines.len(), ends.len(), "{lines:?}");
    for (line, part) in lines.iter().zip(ends) {
        assert!(line.contains(part), "{part} is not in {line}");
    }
    assert!(lines[2].ends_with("#/buffers/1/uri), MISSING") && lines[3].ends_with("missing, not used"), "{lines:?}");
    // Without the missing ones all is well.
    std::fs::write(folder.path().join("gone away.bin"), [0; 4]).expect("a file");
    std::fs::write(folder.path().join("slide.png"), [0; 4]).expect("a file");
    assert_eq!(eyebox(&["inspect", asset.to_str().expect("UTF-8"), "--deps"]).status.code(), Some(0));
}

/// Every command that prints JSON and takes no more than a moment; the others print by the same function.
#[test]
fn every_document_says_which_program_made_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_owned();
    let sidecar = sample("hud-direct/hud.optics.toml");
    let sidecar = sidecar.to_str().expect("UTF-8");
    let (usd, glb, optics, bare) = (file("a.usda"), file("a.glb"), file("a.optics.toml"), file("bare.glb"));
    std::fs::copy(sample("hud-direct/hud_direct.glb"), &bare).expect("a copy");
    for arguments in [
        &["glass"][..],
        &["glass", "PMMA", "--nm", "550"],
        &["inspect", sidecar],
        &["inspect", sidecar, "--deps"],
        &["inspect", sidecar, "--geometry"],
        &["inspect", sidecar, "--explain", "LENS_*"],
        &["init", &bare, "-o", &optics],
        &["convert", sidecar, &usd],
        &["annotate", &bare, "--optics", sidecar, "-o", &glb],
        &["validate", sidecar],
    ] {
        let run = eyebox(&[arguments, &["--format", "json"]].concat());
        let said: serde_json::Value = serde_json::from_slice(&run.stdout)
            .unwrap_or_else(|error| panic!("{arguments:?}: {error}: {}", text(&run.stderr)));
        assert_eq!(said["eyebox"], env!("CARGO_PKG_VERSION"), "{arguments:?}");
    }
}
