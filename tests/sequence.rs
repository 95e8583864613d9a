//! `eyebox render --frames`: names, what is skipped, what fails, and that a frame is what `--frame` gives.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

fn render(more: &[&str]) -> Output {
    let asset = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples/hud-direct/hud.usda");
    let always = ["--samples", "1", "--resolution", "12x6", "--polarisation", "off", "--estimator", "backward", "-q"];
    let mut command = Command::new(env!("CARGO_BIN_EXE_eyebox"));
    command.arg("render").arg(asset).args(always).args(more).output().expect("the program runs")
}

#[test]
fn one_file_per_frame() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let files = || {
        let mut names: Vec<String> = fs::read_dir(folder.path())
            .expect("readable")
            .map(|entry| entry.expect("readable").file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    };
    let out = render(&["-o", &path("hud.###.exr"), "--frames", "-1-3x2"]);
    assert_eq!(out.status.code(), Some(0), "{}", String::from_utf8_lossy(&out.stderr));
    assert_eq!(files(), ["hud.-001.exr", "hud.001.exr", "hud.003.exr"]);
    assert_eq!(render(&["-o", &path("one.exr"), "--frame", "3"]).status.code(), Some(0));
    let read = |name: &str| fs::read(path(name)).expect("written");
    assert_eq!(read("one.exr"), read("hud.003.exr"));

    // What is there stays; what fails is said with its number, and the exit code tells.
    fs::write(path("hud.001.exr"), "kept").expect("writable");
    fs::remove_file(path("one.exr")).expect("there");
    let bad = ["--set", "nothing.flux_lm=1"];
    let again = ["-o", &path("hud.###.exr"), "--frames", "1-3", "--skip-existing"];
    let out = render(&[&again[..], &bad].concat());
    let said = String::from_utf8_lossy(&out.stderr).into_owned();
    assert_eq!(out.status.code(), Some(2), "{said}");
    assert!(said.contains("frame 2:") && said.contains("1 of 3 frames failed"), "{said}");
    assert_eq!(read("hud.001.exr"), b"kept");
    assert_eq!(files(), ["hud.-001.exr", "hud.001.exr", "hud.003.exr"]);

    for (name, frames) in [("hud.exr", "1-2"), ("a#b#.exr", "1-2"), ("hud.#.exr", "2-1")] {
        assert_eq!(render(&["-o", &path(name), "--frames", frames]).status.code(), Some(2), "{name} {frames}");
    }
}
