//! JSON as a tree of [`Value`]s that know their place, for attributes that travel inside JSON files (the `EYEBOX_optics`
//! objects of glTF).

use super::value::{Data, Value};
use eyebox_base::{Error, Where, error::Result};
use std::path::Path;

/// The tree of `json`, which stands at `pointer` (RFC 6901, empty for a whole document) in `file`. Tables keep the
/// order of the file.
///
/// # Errors
/// `null`, which no attribute can mean.
pub fn value(json: &serde_json::Value, file: &Path, pointer: &str) -> Result<Value> {
    let at = || Where::Pointer { file: file.to_owned(), pointer: pointer.to_owned() };
    let data = match json {
        serde_json::Value::Null => {
            return Err(Error::new(at(), "null means nothing here").expected("a value, or the entry left out"));
        }
        serde_json::Value::Bool(flag) => Data::Bool(*flag),
        serde_json::Value::Number(number) => match number.as_f64().filter(|x| x.is_finite()) {
            Some(number) => Data::Number(number),
            None => return Err(Error::new(at(), format!("{number} is too large")).expected("a 64-bit number")),
        },
        serde_json::Value::String(text) => Data::Text(text.clone()),
        serde_json::Value::Array(items) => {
            let items = items.iter().enumerate();
            Data::List(items.map(|(i, item)| value(item, file, &step(pointer, &i.to_string()))).collect::<Result<_>>()?)
        }
        serde_json::Value::Object(entries) => {
            // glTF allows these two on every object; they say nothing about light.
            let entries = entries.iter().filter(|(key, _)| !matches!(key.as_str(), "extensions" | "extras"));
            let entry = |(key, item): (&String, _)| Ok((key.clone(), value(item, file, &step(pointer, key))?));
            Data::Table(entries.map(entry).collect::<Result<_>>()?)
        }
    };
    Ok(Value::new(data, at()))
}

/// About how many bytes the tree of `json` takes, `prefix` being the length of its file name and pointer: every value
/// carries its place, so a long key costs as often as there are values below it.
pub(super) fn weight(json: &serde_json::Value, prefix: usize) -> usize {
    let own = prefix.saturating_add(2 * size_of::<Value>());
    match json {
        serde_json::Value::Null | serde_json::Value::Bool(_) | serde_json::Value::Number(_) => own,
        serde_json::Value::String(text) => own.saturating_add(text.len()),
        serde_json::Value::Array(items) => {
            items.iter().fold(own, |sum, item| sum.saturating_add(weight(item, prefix.saturating_add(8))))
        }
        serde_json::Value::Object(entries) => entries.iter().fold(own, |sum, (key, item)| {
            let below = weight(item, prefix.saturating_add(key.len()).saturating_add(1));
            sum.saturating_add(key.len()).saturating_add(below)
        }),
    }
}

/// The pointer of the entry or element `key` below `pointer`; `~` and `/` are escaped as RFC 6901 says.
pub fn step(pointer: &str, key: &str) -> String {
    if key.contains(['~', '/']) {
        format!("{pointer}/{}", key.replace('~', "~0").replace('/', "~1"))
    } else {
        format!("{pointer}/{key}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_knows_its_pointer() {
        let text = r#"{"stack": [{"n": 1.38, "thickness_nm": 99}], "a/b~c": true, "name": "ar"}"#;
        let json: serde_json::Value = serde_json::from_str(text).unwrap();
        let tree = value(&json, Path::new("a.gltf"), "/materials/2").unwrap();
        let Data::Table(entries) = &tree.data else { panic!("a table") };
        let keys: Vec<&str> = entries.iter().map(|(key, _)| key.as_str()).collect();
        assert_eq!(keys, ["stack", "a/b~c", "name"]);
        // The standard library of JSON pointers agrees with ours: it finds the same value at the place we noted.
        let Data::List(stack) = &tree.get("stack").unwrap().data else { panic!("a list") };
        let n = stack[0].get("n").unwrap();
        assert_eq!(n.data, Data::Number(1.38));
        for (place, want) in [(n, "/stack/0/n"), (tree.get("a/b~c").unwrap(), "/a~1b~0c")] {
            assert_eq!(place.at, Where::Pointer { file: "a.gltf".into(), pointer: format!("/materials/2{want}") });
            assert!(json.pointer(want).is_some(), "{want}");
        }
    }

    #[test]
    fn extras_say_nothing() {
        let json = serde_json::json!({ "ior": 1.5, "extras": { "note": null }, "extensions": {} });
        let tree = value(&json, Path::new("a.gltf"), "").unwrap();
        assert_eq!(tree.to_string(), "{ ior = 1.5 }");
    }

    #[test]
    fn null_is_refused_with_its_place() {
        let json = serde_json::json!({ "shape": { "radius": null } });
        let fault = value(&json, Path::new("a.gltf"), "").unwrap_err();
        assert!(fault.to_string().starts_with("a.gltf#/shape/radius: null"), "{fault}");
    }
}
