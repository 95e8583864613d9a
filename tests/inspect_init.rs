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

    // No attributes: an error, but the parts are listed, and the unit is doubted.
    let bare = eyebox(&["inspect", asset]);
    assert_eq!(bare.status.code(), Some(2));
    assert!(text(&bare.stderr).contains("no optical attributes bind parts"), "{}", text(&bare.stderr));
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

#[test]
fn explain_names_the_line_and_the_nearest_part() {
    let sidecar = sample("hud-direct/hud.optics.toml");
    let sidecar = sidecar.to_str().expect("UTF-8");
    let explained = eyebox(&["inspect", sidecar, "--explain", "LENS_01_PMMA", "--format", "json"]);
    assert_eq!(explained.status.code(), Some(0));
    let parts: serde_json::Value = serde_json::from_slice(&explained.stdout).expect("JSON");
    let rows = parts[0]["rows"].as_array().expect("rows");
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
