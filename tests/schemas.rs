//! The published schemas against the attribute table. `EYEBOX_BLESS=1 cargo verify --test all schemas` rewrites them.

use eyebox::author::schema;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn below(folder: &Path, all: &mut BTreeSet<PathBuf>) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            below(&path, all);
        } else {
            all.insert(path);
        }
    }
}

#[test]
fn the_schemas_are_up_to_date() {
    let fresh = schema::files();
    if std::env::var_os("EYEBOX_BLESS").is_some_and(|value| value == "1") {
        for (path, text) in &fresh {
            let path = root().join(path);
            fs::create_dir_all(path.parent().expect("a folder")).expect("schemas can be written");
            fs::write(&path, text).expect("schemas can be written");
        }
    }
    for (path, text) in &fresh {
        let stored = fs::read_to_string(root().join(path)).unwrap_or_default();
        let line = stored.lines().zip(text.lines()).take_while(|(a, b)| a == b).count() + 1;
        assert!(
            stored == *text,
            "{path} is stale from line {line}; EYEBOX_BLESS=1 cargo verify --test all schemas rewrites it"
        );
    }
    let mut stored = BTreeSet::new();
    below(&root().join("schemas"), &mut stored);
    let wanted: BTreeSet<PathBuf> = fresh.iter().map(|(path, _)| root().join(path)).collect();
    assert_eq!(stored, wanted, "files in schemas/ that nothing generates");
}

/// Calls `see` with every value of a tree.
fn walk(json: &serde_json::Value, see: &mut impl FnMut(&serde_json::Map<String, serde_json::Value>)) {
    match json {
        serde_json::Value::Object(entries) => {
            see(entries);
            entries.values().for_each(|value| walk(value, see));
        }
        serde_json::Value::Array(items) => items.iter().for_each(|item| walk(item, see)),
        _ => {}
    }
}

#[test]
fn gltf_schemas_keep_the_rules_of_extensions() {
    let files = schema::files();
    let name = |path: &str| path.rsplit('/').next().unwrap_or(path).to_owned();
    let names: BTreeSet<String> = files.iter().map(|(path, _)| name(path)).collect();
    let mut count = 0;
    for (path, text) in files.iter().filter(|(path, _)| path.contains("EYEBOX_optics/schema/")) {
        let json: serde_json::Value = serde_json::from_str(text).expect("JSON");
        assert_eq!(json["$id"].as_str(), Some(name(path).as_str()));
        assert_eq!(json["$schema"].as_str(), Some("https://json-schema.org/draft/2020-12/schema"));
        walk(&json, &mut |entries| {
            // Unknown properties pass, so that later versions of the specification can add some.
            assert!(!entries.contains_key("additionalProperties"), "{path}");
            if let Some(target) = entries.get("$ref").and_then(|target| target.as_str()) {
                assert!(names.contains(target) || target == "glTFProperty.schema.json", "{path}: {target}");
            }
        });
        count += 1;
    }
    assert_eq!(count, 14);
}
