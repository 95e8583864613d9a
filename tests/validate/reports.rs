//! The program: places of findings, formats, exit codes, configuration, baselines.

use super::bench::Bench;
use serde_json::{Value, json};
use std::path::Path;
use std::process::{Command, Output};

pub fn eyebox(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_eyebox"));
    command
        .current_dir(folder)
        .arg("validate")
        .args(arguments)
        .env_remove("EYEBOX_DOCS_URL")
        .output()
        .expect("the program runs")
}

pub fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).expect("UTF-8")
}

fn folder_with(change: impl Fn(&mut Bench)) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut bench = Bench::new();
    change(&mut bench);
    bench.write(folder.path());
    folder
}

/// Two faults in the sidecar, one of a part in the .gltf.
fn faulty() -> tempfile::TempDir {
    folder_with(|b| {
        b.append("\n[[bind]]\npath = \"BAFFEL\"\nfinish = \"absorber\"\n");
        b.swap("glass = \"PMMA\"", "glass = \"PMMX\"");
        b.gltf["meshes"][0]["primitives"].as_array_mut().unwrap().remove(1);
    })
}

fn line_of(path: &Path, needle: &str) -> usize {
    let text = std::fs::read_to_string(path).unwrap();
    1 + text.lines().position(|line| line.contains(needle)).unwrap_or_else(|| panic!("{needle}"))
}

#[test]
fn places_have_lines_and_columns() {
    let folder = faulty();
    let run = eyebox(folder.path(), &["bench.optics.toml"]);
    assert_eq!((run.status.code(), text(&run.stderr)), (Some(1), ""));
    let shown = text(&run.stdout);
    let sheet = folder.path().join("bench.optics.toml");
    let (glass, path) = (line_of(&sheet, "PMMX"), line_of(&sheet, "BAFFEL"));
    for expected in [
        format!("bench.optics.toml:{glass}:10: error[EB0209]: unknown glass `PMMX`"),
        format!("bench.optics.toml:{path}:9: error[EB0602]: path `BAFFEL` matches no part; did you mean `BAFFLE`?"),
        format!(
            "bench.gltf:{}:5 (BENCH/LENS): error[EB0102]: ",
            line_of(&folder.path().join("bench.gltf"), "\"name\": \"LENS\"") - 1
        ),
        "3 errors, 0 warnings, 0 notes in 1 asset\n".to_owned(),
    ] {
        assert!(shown.contains(&expected), "{expected} is missing in\n{shown}");
    }
    assert!(!shown.contains('\u{1b}'), "no colours in a pipe");
}

#[test]
fn colours_are_forced_and_forbidden() {
    let folder = faulty();
    let run = |set: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_eyebox"));
        command.current_dir(folder.path()).args(["validate", "bench.optics.toml"]).env(set, "1");
        command.output().expect("the program runs").stdout
    };
    assert!(run("CLICOLOR_FORCE").contains(&0x1b));
    assert!(!run("NO_COLOR").contains(&0x1b));
}

#[test]
fn exit_codes() {
    let folder = faulty();
    let code = |arguments: &[&str]| eyebox(folder.path(), arguments).status.code();
    assert_eq!(code(&["bench.optics.toml"]), Some(1));
    assert_eq!(code(&["bench.optics.toml", "--exit-zero"]), Some(0));
    assert_eq!(code(&["nothing.glb"]), Some(2));
    assert_eq!(code(&["."]), Some(1), "the folder's sidecar, once");
    std::fs::create_dir(folder.path().join("empty")).unwrap();
    let none = eyebox(folder.path(), &["empty"]);
    assert_eq!(none.status.code(), Some(2));
    assert!(text(&none.stderr).contains("no asset and no sidecar in this folder"), "{}", text(&none.stderr));
    assert_eq!(code(&[]), Some(2));
    assert_eq!(code(&["bench.optics.toml", "--format", "pdf"]), Some(2));
    assert_eq!(code(&["--explain", "EB9999"]), Some(2));
    assert_eq!(code(&["bench.optics.toml", "--config", "nothing.toml"]), Some(2));
    // Unreadable is a finding.
    std::fs::write(folder.path().join("noise.glb"), b"glTF\x02\0\0\0\xff\xff").unwrap();
    assert_eq!(code(&["noise.glb"]), Some(1));
    let explained = eyebox(folder.path(), &["--explain", "solid-open"]);
    assert!(explained.status.success() && text(&explained.stdout).starts_with("# EB0102: "));
    let good = folder_with(|_| {});
    assert_eq!(eyebox(good.path(), &["bench.optics.toml", "bench.gltf"]).status.code(), Some(0));
    // Notes alone are no failure.
    let noted = folder_with(|b| b.append("\n[coating.spare]\nideal = { R = 0.1, T = 0.9 }\n"));
    let run = eyebox(noted.path(), &["bench.optics.toml"]);
    assert!(run.status.success() && text(&run.stdout).contains("note[EB0207]"), "{}", text(&run.stdout));
}

/// A finding whose text names a file that is missing is the same one from any working directory.
#[test]
fn a_baseline_knows_files_that_texts_name() {
    let folder = folder_with(|b| drop(b.files.remove("bench.bin")));
    let below = folder.path().join("below");
    std::fs::create_dir(&below).unwrap();
    let found = eyebox(folder.path(), &["bench.optics.toml"]);
    assert!(found.status.code() == Some(1) && text(&found.stdout).contains("bench.bin"), "{}", text(&found.stdout));
    let wrote = eyebox(folder.path(), &["bench.optics.toml", "--write-baseline", "known.json"]);
    assert_eq!((wrote.status.code(), text(&wrote.stderr)), (Some(0), ""));
    for (at, asset, known) in [
        (folder.path(), "bench.optics.toml", "known.json"),
        (folder.path(), "./below/../bench.optics.toml", "known.json"),
        (&below, "../bench.optics.toml", "../known.json"),
    ] {
        let run = eyebox(at, &[asset, "--baseline", known]);
        assert_eq!(run.status.code(), Some(0), "{asset}: {}", text(&run.stdout));
    }
}

#[test]
fn configuration_and_baseline() {
    let folder = faulty();
    let count = |arguments: &[&str]| -> (Option<i32>, Vec<String>) {
        let run = eyebox(folder.path(), &[arguments, &["bench.optics.toml", "--format", "json"]].concat());
        let report: Value = serde_json::from_slice(&run.stdout).unwrap_or_else(|_| panic!("{}", text(&run.stderr)));
        let code =
            |finding: &Value| format!("{} {}", finding["code"].as_str().unwrap(), finding["level"].as_str().unwrap());
        (run.status.code(), report["findings"].as_array().unwrap().iter().map(code).collect())
    };
    let all = ["EB0102 error", "EB0209 error", "EB0602 error"].map(str::to_owned);
    let (code, mut found) = count(&[]);
    found.sort();
    assert_eq!((code, found), (Some(1), all.to_vec()));
    let config = folder.path().join("eyebox.toml");
    std::fs::write(&config, "[validate]\nignore = [\"name-unknown\"]\nlevel = { EB0602 = \"note\" }\n[[validate.path]]\nglob = \"*.gltf\"\nlevel = { EB0102 = \"off\" }\n").unwrap();
    assert_eq!(count(&[]), (Some(0), vec!["EB0602 note".to_owned()]));
    std::fs::remove_file(&config).unwrap();

    let wrote = eyebox(folder.path(), &["bench.optics.toml", "--write-baseline", "known.json"]);
    assert_eq!((wrote.status.code(), text(&wrote.stderr)), (Some(0), ""));
    assert_eq!(count(&["--baseline", "known.json"]), (Some(0), vec![]));
    // From another working directory it knows the same, and it says so when it is written there.
    std::fs::create_dir(folder.path().join("below")).unwrap();
    let below = folder.path().join("below");
    let away = eyebox(&below, &["../bench.optics.toml", "--baseline", "../known.json"]);
    assert_eq!(away.status.code(), Some(0), "{}", text(&away.stdout));
    let again = eyebox(&below, &["../bench.optics.toml", "--write-baseline", "../again.json"]);
    assert_eq!((again.status.code(), text(&again.stderr)), (Some(0), ""));
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    assert_eq!(read("again.json"), read("known.json"));
    // Lines above change nothing, a new fault does.
    let sheet = folder.path().join("bench.optics.toml");
    let written = std::fs::read_to_string(&sheet).unwrap();
    std::fs::write(&sheet, format!("# more\n\n{written}\n[coating.x]\nideal = {{ R = 0.9, T = 0.9 }}\n")).unwrap();
    assert_eq!(
        count(&["--baseline", "known.json"]),
        (Some(1), ["EB0204 error", "EB0207 note"].map(str::to_owned).to_vec())
    );
    std::fs::write(folder.path().join("known.json"), "{\"version\": 9, \"findings\": []}").unwrap();
    assert_eq!(eyebox(folder.path(), &["bench.optics.toml", "--baseline", "known.json"]).status.code(), Some(2));
}

/// The parts of SARIF 2.1.0 (§3.13 ff.) that are used, by their sections; `tests/interchange/reports.py` has the OASIS
/// schema's say.
#[test]
fn sarif_is_what_the_standard_asks() {
    let folder = faulty();
    let run = eyebox(folder.path(), &["bench.optics.toml", "--format", "sarif"]);
    assert_eq!(run.status.code(), Some(1));
    let log: Value = serde_json::from_slice(&run.stdout).unwrap();
    assert_eq!(log["version"], "2.1.0");
    let run = &log["runs"][0];
    let rules = run["tool"]["driver"]["rules"].as_array().unwrap();
    let results = run["results"].as_array().unwrap();
    assert_eq!(results.len(), 3);
    for rule in rules {
        match option_env!("EYEBOX_DOCS_URL") {
            Some(docs) => assert_eq!(rule["helpUri"], format!("{docs}/rules/{}.md", rule["id"].as_str().unwrap())),
            None => assert!(rule.get("helpUri").is_none(), "an address that nobody gave: {rule}"),
        }
        assert!(rule["help"]["markdown"].as_str().is_some_and(|page| page.contains(rule["id"].as_str().unwrap())));
        for key in ["shortDescription", "fullDescription", "help"] {
            assert!(rule[key]["text"].as_str().is_some_and(|text| text.ends_with(['.', '\n'])), "{key} of {rule}");
        }
        assert!(["note", "warning", "error"].contains(&rule["defaultConfiguration"]["level"].as_str().unwrap()));
    }
    for result in results {
        let index = result["ruleIndex"].as_u64().unwrap() as usize;
        assert_eq!(rules[index]["id"], result["ruleId"]);
        let physical = &result["locations"][0]["physicalLocation"];
        let uri = physical["artifactLocation"]["uri"].as_str().unwrap();
        assert!(!uri.contains('\\') && !uri.starts_with('/') && !uri.contains(".."), "{uri}");
        assert!(
            physical["region"]["startLine"].as_u64() > Some(0) && physical["region"]["startColumn"].as_u64() > Some(0)
        );
        assert_eq!(result["partialFingerprints"]["eyeboxFinding/v1"].as_str().unwrap().len(), 32);
    }
    let open = results.iter().find(|result| result["ruleId"] == "EB0102").unwrap();
    assert_eq!(open["locations"][0]["logicalLocations"][0]["fullyQualifiedName"], "BENCH/LENS");
    assert_eq!(open["locations"][0]["logicalLocations"][1]["fullyQualifiedName"], "/nodes/1");
}

#[test]
fn junit_and_github() {
    let folder = faulty();
    let run = eyebox(folder.path(), &["bench.optics.toml", "bench.gltf", "--format", "junit"]);
    let xml = text(&run.stdout);
    assert!(xml.starts_with("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"eyebox validate\" tests=\"4\" failures=\"3\""), "{xml}");
    assert_eq!((xml.matches("<failure ").count(), xml.matches("<testsuite ").count()), (3, 2));
    assert_eq!(xml.matches("<testcase ").count(), 4);
    let run = eyebox(folder.path(), &["bench.optics.toml", "--format", "github"]);
    let commands: Vec<&str> = text(&run.stdout).lines().filter(|line| line.starts_with("::")).collect();
    assert_eq!(commands.len(), 3);
    let line = line_of(&folder.path().join("bench.optics.toml"), "PMMX");
    let expected =
        format!("::error file=bench.optics.toml,line={line},col=10,title=EB0209 name-unknown::unknown glass `PMMX`");
    assert!(commands.iter().any(|command| command.starts_with(&expected)), "{commands:?}");
}

/// In a .glb there are no lines: the byte of the JSON value is given.
#[test]
fn a_glb_has_offsets_and_a_stage_has_lines() {
    let folder = folder_with(|_| {});
    let convert = |to: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_eyebox"));
        let run = command.current_dir(folder.path()).args(["convert", "bench.optics.toml", to]).output().unwrap();
        assert!(run.status.success(), "{}", text(&run.stderr));
    };
    convert("all.glb");
    convert("all.usda");
    let findings = |file: &str| -> Vec<Value> {
        let run = eyebox(folder.path(), &[file, "--format", "json"]);
        let report: Value = serde_json::from_slice(&run.stdout).unwrap();
        report["findings"].as_array().unwrap().clone()
    };
    assert_eq!((findings("all.glb"), findings("all.usda")), (vec![], vec![]));

    let path = folder.path().join("all.glb");
    let mut bytes = std::fs::read(&path).unwrap();
    let at = bytes.windows(6).position(|window| window == b"N-BK7\"").unwrap();
    bytes[at + 4] = b'9';
    std::fs::write(&path, &bytes).unwrap();
    let found = findings("all.glb");
    assert_eq!(found[0]["code"], "EB0209", "{found:?}");
    let offset = found[0]["place"]["byte_offset"].as_u64().unwrap() as usize;
    assert!(bytes[offset..].starts_with(b"\"N-BK9\"") && found[0]["place"]["line"] == json!(null), "{found:?}");

    let path = folder.path().join("all.usda");
    let layer = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, layer.replacen("N-BK7", "N-BK9", 1)).unwrap();
    let found = findings("all.usda");
    assert_eq!(
        (&found[0]["code"], &found[0]["place"]["line"]),
        (&json!("EB0209"), &json!(line_of(&path, "N-BK9"))),
        "{found:?}"
    );
}

/// Assets cut off, and with bytes changed: findings, never a panic.
#[test]
fn broken_assets_are_findings() {
    let folder = folder_with(|_| {});
    let whole = std::fs::read(folder.path().join("bench.gltf")).unwrap();
    let sheet = std::fs::read(folder.path().join("bench.optics.toml")).unwrap();
    let config = eyebox::validate::config::Config::default();
    let look = |file: &str| {
        let path = folder.path().join(file);
        let report = eyebox::validate::validate(&[path], &config, &Default::default()).expect("it is there");
        eyebox::validate::report::render(&report, eyebox::validate::report::Style::Sarif)
    };
    for (file, bytes) in [("bench.gltf", &whole), ("bench.optics.toml", &sheet)] {
        let path = folder.path().join(file);
        for step in 0..40u64 {
            let mut broken = bytes.clone();
            let at = (step * 7919 % bytes.len() as u64) as usize;
            if step % 2 == 0 {
                broken.truncate(at)
            } else {
                broken[at] ^= 1 << (step % 7)
            }
            std::fs::write(&path, &broken).unwrap();
            look("bench.optics.toml");
            look("bench.gltf");
        }
        std::fs::write(&path, bytes).unwrap();
    }
}
