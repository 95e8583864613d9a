//! `action.yml`: its scripts do what their inputs say, with programs that only say how they were called; and the files that package
//! the program agree with `Cargo.toml`.
#![cfg(unix)]

use std::collections::BTreeMap;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn text(name: &str) -> String {
    std::fs::read_to_string(root().join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// The script of the step of this name.
fn script(step: &str) -> String {
    let action = text("action.yml");
    let own = action.split(&format!("- name: {step}\n")).nth(1).unwrap_or_else(|| panic!("no step {step}"));
    let own = own.split("\n    - ").next().unwrap();
    let (_, run) = own.split_once("run: |\n").expect("the step has a script");
    run.lines().map(|line| line.get(8..).unwrap_or("")).collect::<Vec<_>>().join("\n")
}

/// An empty place to work in, with folders `bin` (of programs) and `temp`.
struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Place {
        let place = Place(tempfile::tempdir().unwrap());
        ["bin", "temp"].iter().for_each(|name| std::fs::create_dir(place.path(name)).unwrap());
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// A program that says its name and how it was called, then does `more`.
    fn program(&self, name: &str, more: &str) {
        let path = self.path(name);
        let called = Path::new(name).file_name().unwrap().to_string_lossy().into_owned();
        std::fs::write(&path, format!("#!/bin/bash\necho \"{called} $*\"\n{more}\n")).unwrap();
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
    }

    /// What the program of the action is made of.
    fn sources(&self, main: &str) {
        std::fs::create_dir_all(self.path("src")).unwrap();
        for (name, text) in [("Cargo.toml", ""), ("Cargo.lock", ""), ("src/main.rs", main)] {
            std::fs::write(self.path(name), text).unwrap();
        }
    }

    fn run(&self, step: &str, inputs: &[(&str, &str)]) -> Output {
        let names = ["BINARY", "WHEEL", "ASSETS", "CONFIG", "BASELINE", "SARIF", "EXIT_ZERO"];
        let mut all: BTreeMap<&str, &str> = names.map(|name| (name, "")).into();
        all.extend(inputs.iter().copied());
        let mut bash = Command::new("bash");
        bash.args(["-e", "-c", &script(step)]).current_dir(self.0.path()).env_clear().envs(all);
        bash.env("PATH", format!("{}:/usr/bin:/bin", self.path("bin").display()));
        for (name, file) in
            [("RUNNER_TEMP", "temp"), ("GITHUB_PATH", "path"), ("GITHUB_OUTPUT", "output"), ("GITHUB_ACTION_PATH", ".")]
        {
            bash.env(name, self.path(file));
        }
        bash.output().expect("bash runs")
    }

    /// What the step wrote for later ones.
    fn said(&self) -> [String; 2] {
        ["output", "path"].map(|name| std::fs::read_to_string(self.path(name)).unwrap_or_default().trim().to_owned())
    }
}

fn shown(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

#[test]
fn a_program_is_taken_found_or_built() {
    // One that is given.
    let place = Place::new();
    place.program("mine", "");
    let own = place.path("mine");
    assert!(place.run("Find eyebox", &[("BINARY", own.to_str().unwrap())]).status.success());
    let bin = place.path("temp/eyebox/bin");
    assert_eq!(place.said(), ["build=false".to_owned(), bin.display().to_string()]);
    assert!(bin.join("eyebox").exists());
    let absent = place.run("Find eyebox", &[("BINARY", "nowhere/eyebox")]);
    assert_eq!(absent.status.code(), Some(2));
    assert!(shown(&absent).contains("::error") && shown(&absent).contains("nowhere/eyebox"), "{}", shown(&absent));
    // A wheel: a Python that makes environments with a Python that installs.
    let place = Place::new();
    place.program("bin/python3", "mkdir -p \"$3/bin\"; cp \"$0\" \"$3/bin/python\"");
    let wheel = place.run("Find eyebox", &[("WHEEL", "eyebox-0.1.0-py3-none-any.whl")]);
    assert!(shown(&wheel).contains("python3 -m pip install eyebox-0.1.0-py3-none-any.whl"), "{}", shown(&wheel));
    assert_eq!(place.said()[0], "build=false");
    // One in PATH.
    let place = Place::new();
    place.program("bin/eyebox", "");
    assert!(place.run("Find eyebox", &[]).status.success());
    assert_eq!(place.said(), ["build=false", ""]);
    // None: it is built, unless the cache had it.
    let place = Place::new();
    place.sources("fn main() {}");
    assert!(place.run("Find eyebox", &[]).status.success());
    assert!(place.said()[0].starts_with("build=true\nsum=") && place.said()[1].is_empty(), "{:?}", place.said());
    place.program("bin/cargo", "");
    let built = place.run("Build eyebox", &[]);
    assert!(shown(&built).starts_with("cargo install --locked --ignore-rust-version"), "{}", shown(&built));
    std::fs::create_dir_all(place.path("temp/eyebox/bin")).unwrap();
    place.program("temp/eyebox/bin/eyebox", "");
    assert_eq!(shown(&place.run("Build eyebox", &[])), "");
}

/// The action stands outside of the workspace, where `hashFiles` is empty: the key of the cache is a sum over its sources, which
/// changes with them and with nothing else.
#[test]
fn another_program_has_another_key() {
    let action = text("action.yml");
    let key = action.lines().find(|line| line.trim_start().starts_with("key: ")).expect("a key");
    assert!(!key.contains("hashFiles(") && key.contains("${{ steps.find.outputs.sum }}"), "{key}");
    let sum = |source: &str| {
        let place = Place::new();
        place.sources(source);
        let run = place.run("Find eyebox", &[]);
        assert!(run.status.success(), "{}", shown(&run));
        let said = place.said()[0].clone();
        let (_, sum) = said.split_once("sum=").expect("a sum");
        assert!(sum.len() == 40 && sum.chars().all(|c| c.is_ascii_hexdigit()), "{sum}");
        sum.to_owned()
    };
    assert_eq!(sum("fn main() {}"), sum("fn main() {}"));
    assert_ne!(sum("fn main() {}"), sum("fn main() { }"));
}

#[test]
fn assets_are_validated_and_none_is_an_error() {
    let place = Place::new();
    place.program("bin/eyebox", "");
    std::fs::write(place.path("a.glb"), "").unwrap();
    let run = place.run("Validate", &[("ASSETS", "*.glb"), ("SARIF", "out.sarif"), ("EXIT_ZERO", "true")]);
    assert_eq!(shown(&run), "eyebox validate a.glb --exit-zero --format github\n");
    assert_eq!(
        std::fs::read_to_string(place.path("out.sarif")).unwrap(),
        "eyebox validate a.glb --format sarif --exit-zero\n"
    );
    let none = place.run("Validate", &[("ASSETS", "*.usd")]);
    assert_eq!(none.status.code(), Some(2));
    assert!(shown(&none).contains("no file matches the input `assets`: *.usd"), "{}", shown(&none));
    // Text in an input is no command.
    let hostile = place.run("Validate", &[("ASSETS", "a.glb"), ("CONFIG", "$(touch pwned)")]);
    assert!(shown(&hostile).contains("--config $(touch pwned)") && !place.path("pwned").exists());
}

#[test]
fn packages_say_what_cargo_says() {
    let python: toml::Table = text("pyproject.toml").parse().unwrap();
    let cargo: toml::Table = text("Cargo.toml").parse().unwrap();
    assert_eq!(python["project"]["name"], cargo["package"]["name"]);
    let dynamic: Vec<&str> =
        python["project"]["dynamic"].as_array().unwrap().iter().filter_map(toml::Value::as_str).collect();
    assert_eq!(dynamic, ["version", "description", "license"], "these are Cargo's");
    assert_eq!(python["tool"]["maturin"]["bindings"].as_str(), Some("bin"));
    let hooks = text(".pre-commit-hooks.yaml");
    for (id, language) in [("eyebox-validate", "rust"), ("eyebox-validate-system", "system")] {
        let own = hooks.split(&format!("- id: {id}\n")).nth(1).and_then(|own| own.split("- id:").next()).expect(id);
        assert!(own.contains(&format!("language: {language}\n")) && own.contains("entry: eyebox validate .\n"), "{id}");
    }
}
