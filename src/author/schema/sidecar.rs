//! The JSON Schema of a TOML sidecar.

use super::face::{faces, medium};
use super::json::{Carrier, object, pretty, properties, row, selectors, whole};
use eyebox_scene::attribute::{MEDIUM, Noun, Row, row as find};
use serde_json::{Map, Value, json};

pub fn text() -> String {
    let definitions: Map<String, Value> =
        medium().chain(faces()).map(|own| (own.name.to_owned(), row(own, Carrier::Sidecar))).collect();
    let refer = |own: &Row| (own.name.to_owned(), json!({ "$ref": format!("#/$defs/{}", own.name) }));
    let bound = || medium().chain(faces()).map(refer);
    let mut bind: Map<String, Value> = Map::new();
    for (key, what) in [
        ("path", "path of names from the root, which may be left out; * stops at /, ** crosses it"),
        ("name", "name of a part, * for any text"),
        ("material", "name of a material, * for any text"),
        ("mesh", "name of a mesh, * for any text"),
    ] {
        bind.insert(key.to_owned(), json!({ "type": "string", "description": what }));
    }
    bind.extend(selectors());
    bind.extend(bound());
    let mut bind = object(bind, &[], Carrier::Sidecar);
    if let Value::Object(entries) = &mut bind {
        let any = ["path", "name", "material", "mesh"].map(|key| json!({ "required": [key] }));
        entries.insert("anyOf".to_owned(), json!(any));
        entries.insert("not".to_owned(), json!({ "required": ["faces", "normal"] }));
    }
    let mut all: Map<String, Value> = Map::new();
    all.insert("schema".to_owned(), json!({ "const": 1, "description": "version of this vocabulary, 1" }));
    all.extend(properties(Noun::Asset, &["asset", "unit", "wavelengths"], Carrier::Sidecar));
    all.insert("default".to_owned(), object(bound().collect(), &[], Carrier::Sidecar));
    let named = |item: Value| json!({ "type": "object", "additionalProperties": item });
    all.insert("coating".to_owned(), named(json!({ "$ref": "#/$defs/coating" })));
    let medium = MEDIUM.iter().filter_map(|name| find(Noun::Medium, name));
    let medium = medium.map(|own| match own.name {
        "name" => ("name".to_owned(), row(own, Carrier::Sidecar)),
        _ => refer(own),
    });
    all.insert("medium".to_owned(), named(object(medium.collect(), &[], Carrier::Sidecar)));
    all.insert("bind".to_owned(), json!({ "type": "array", "items": bind }));
    for noun in [Noun::Sky, Noun::Sun, Noun::Eye] {
        all.insert(noun.to_string(), whole(noun, Carrier::Sidecar));
    }
    let mut schema = Map::from_iter([
        ("$schema".to_owned(), json!("https://json-schema.org/draft/2020-12/schema")),
        ("$id".to_owned(), json!("sidecar.schema.json")),
        ("title".to_owned(), json!("Optics sidecar")),
        ("description".to_owned(), json!("Optical attributes of a CAD export (`NAME.optics.toml`), version 1.")),
    ]);
    if let Value::Object(own) = object(all, &["schema", "asset"], Carrier::Sidecar) {
        schema.extend(own);
    }
    schema.insert("$defs".to_owned(), definitions.into());
    pretty(&Value::Object(schema))
}
