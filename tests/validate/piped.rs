//! `eyebox validate -`: what comes through a pipe is told by its content and has the findings that its file has.

use super::bench::Bench;
use serde_json::Value;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

fn eyebox(folder: &Path, arguments: &[&str], stdin: &[u8]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_eyebox"));
    command.current_dir(folder).args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("the program runs");
    // A program that reads nothing closes the pipe.
    let _ = child.stdin.take().expect("a pipe").write_all(stdin);
    child.wait_with_output().expect("the program ends")
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).expect("UTF-8")
}

/// Code, level, text and place of every finding; the file `name` is called `<stdin>`.
fn findings(run: &Output, name: &str) -> Vec<String> {
    let report: Value = serde_json::from_slice(&run.stdout).unwrap_or_else(|_| panic!("{}", text(&run.stderr)));
    let said = |finding: &Value| {
        let Value::Object(mut finding) = finding.clone() else { panic!("{finding}") };
        finding.remove("fingerprint");
        Value::Object(finding).to_string().replace(name, "<stdin>")
    };
    report["findings"].as_array().unwrap().iter().map(said).collect()
}

/// The good asset in every format, each with a glass that does not exist.
fn faulty() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    Bench::new().write(folder.path());
    for to in ["all.glb", "all.gltf", "all.usda", "all.usdc", "all.usdz"] {
        let run = eyebox(folder.path(), &["convert", "bench.optics.toml", to], b"");
        assert!(run.status.success(), "{to}: {}", text(&run.stderr));
    }
    for name in ["bench.optics.toml", "all.glb", "all.gltf", "all.usda"] {
        let path = folder.path().join(name);
        let mut bytes = std::fs::read(&path).unwrap();
        let at = bytes.windows(7).position(|window| window == b"\"N-BK7\"").unwrap_or_else(|| panic!("{name}"));
        bytes[at + 5] = b'9';
        std::fs::write(&path, bytes).unwrap();
    }
    folder
}

#[test]
fn what_is_piped_has_the_findings_of_its_file() {
    let folder = faulty();
    let before = std::fs::read_dir(folder.path()).unwrap().count();
    for name in ["bench.optics.toml", "all.glb", "all.gltf", "all.usda", "all.usdc", "all.usdz"] {
        let bytes = std::fs::read(folder.path().join(name)).unwrap();
        let named = eyebox(folder.path(), &["validate", name, "--format", "json"], b"");
        let piped = eyebox(folder.path(), &["validate", "-", "--format", "json"], &bytes);
        assert_eq!(named.status.code(), piped.status.code(), "{name}: {}", text(&piped.stderr));
        let found = findings(&piped, name);
        assert_eq!(found, findings(&named, name), "{name}");
        let is_binary = name.ends_with("usdc") || name.ends_with("usdz");
        assert!(is_binary || found.iter().any(|one| one.contains("EB0209") && one.contains("<stdin>")), "{found:?}");
        let again = eyebox(folder.path(), &["validate", "-", "--format", "json"], &bytes);
        assert_eq!(text(&again.stdout), text(&piped.stdout), "{name}: the same findings have the same fingerprints");
        assert!(text(&piped.stdout).contains("\"<stdin>\"") && !text(&piped.stdout).contains("eyebox-stdin"), "{name}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), before, "nothing is left behind");
}

#[test]
fn every_format_calls_it_stdin() {
    let folder = faulty();
    let sheet = std::fs::read(folder.path().join("bench.optics.toml")).unwrap();
    for (format, said) in [
        ("text", "<stdin>:"),
        ("json", "\"file\": \"<stdin>\""),
        ("sarif", "\"uri\": \"%3Cstdin%3E\""),
        ("junit", "<testsuite name=\"&lt;stdin&gt;\""),
        ("github", "::error file=<stdin>,line="),
    ] {
        let run = eyebox(folder.path(), &["validate", "-", "--format", format], &sheet);
        assert_eq!((run.status.code(), text(&run.stderr)), (Some(1), ""), "{format}");
        let shown = text(&run.stdout);
        assert!(shown.contains(said) && shown.contains("N-BK9") && !shown.contains("eyebox-stdin"), "{shown}");
    }
}

#[test]
fn what_is_no_use_is_said() {
    let folder = faulty();
    let run = |arguments: &[&str], stdin: &[u8]| {
        let out = eyebox(folder.path(), &[&["validate"], arguments].concat(), stdin);
        (out.status.code(), format!("{}{}", text(&out.stdout), text(&out.stderr)))
    };
    for (arguments, stdin, said) in [
        (&["-"][..], &b""[..], "standard input: is empty; expected an asset"),
        (&["-", "-"], b"{}", "standard input is named more than once"),
        (&["-", "--write-baseline", "known.json"], b"{}", "no name that a baseline could know it by"),
    ] {
        let (code, shown) = run(arguments, stdin);
        assert!(code == Some(2) && shown.contains(said) && shown.lines().count() == 1, "{shown}");
    }
    assert!(!folder.path().join("known.json").exists());
    // What no reader takes is a finding, as in a file.
    let (code, shown) = run(&["-"], b"\x89PNG\r\n\x1a\n");
    assert!(code == Some(1) && shown.starts_with("<stdin>: error[EB0001]"), "{shown}");
}
