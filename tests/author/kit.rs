//! Runs the program, and says what a scene is.

use crate::common::image;
use eyebox::check::check;
use eyebox::estimate::run::{Limits, run};
use eyebox::import::{ImportOptions, import};
use eyebox::plan::{Choice, plan};
use eyebox::scene::Scene;
use eyebox::world::World;
use std::path::{Path, PathBuf};
use std::process::Command;

pub fn sample(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("samples").join(file)
}

/// Exit code, stdout and stderr.
pub fn eyebox(arguments: &[&Path]) -> (Option<i32>, String, String) {
    let out = Command::new(env!("CARGO_BIN_EXE_eyebox")).args(arguments).output().expect("the program runs");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    (out.status.code(), text(out.stdout), text(out.stderr))
}

/// The program must not complain.
pub fn clean(arguments: &[&str]) {
    let paths: Vec<&Path> = arguments.iter().map(Path::new).collect();
    let (code, _, errors) = eyebox(&paths);
    assert_eq!((code, errors.as_str()), (Some(0), ""), "{arguments:?}");
}

pub fn scene(file: &Path) -> Scene {
    import(file, &ImportOptions::default()).unwrap_or_else(|fault| panic!("{}: {fault}", file.display())).scene
}

/// Everything that a scene says, but for names of files, notes and the hash of its inputs.
pub fn said(scene: &Scene) -> serde_json::Value {
    let mut json = serde_json::to_value(scene).expect("a scene is JSON");
    let object = json.as_object_mut().expect("an object");
    for key in ["name", "hash", "notes"] {
        object.remove(key).expect("it is there");
    }
    if let Some(sky) = json["sky"].as_object_mut() {
        sky.remove("file").expect("it is there");
    }
    for slide in json["slides"].as_array_mut().expect("a list") {
        slide.as_object_mut().expect("an object").remove("file").expect("it is there");
    }
    json
}

/// Asserts that two scenes are the same to the last bit, vertices included.
pub fn same(a: &Scene, b: &Scene, what: &str) {
    assert_eq!(said(a), said(b), "{what}");
    for (a, b) in a.meshes.iter().zip(&b.meshes) {
        assert!(a == b, "{what}: mesh {}", a.name);
    }
    let bits = |scene: &Scene| -> Vec<u64> {
        scene.parts.iter().flat_map(|part| part.to_world.to_cols_array().map(f64::to_bits)).collect()
    };
    assert_eq!(bits(a), bits(b), "{what}");
}

/// A small picture: 32 x 16 pixels, the plan's own choice of estimators.
pub fn picture(scene: &Scene) -> Vec<(u64, u64)> {
    let mut scene = scene.clone();
    scene.eye.resolution = [32, 16];
    let world = World::freeze(&scene).expect("the scene can be traced");
    let plan = plan(&check(&scene).expect("the scene is sound"), &world, Choice::Auto);
    let limits = Limits { passes: Some(2), ..Limits::default() };
    let outcome = run(&world, &plan, scene.groups.len(), [32, 16], 5, &limits, &mut ());
    image(&outcome.films).into_iter().map(|(mean, error)| (mean.to_bits(), error.to_bits())).collect()
}
