//! The JSON Schemas of the glTF extension `EYEBOX_optics`.

use super::face::{FACE, faces, holder, list, medium};
use super::json::{Carrier, object, pretty, properties, row, selectors, whole};
use eyebox_scene::attribute::{Form, Noun, Row};
use serde_json::{Map, Value, json};

const FOLDER: &str = "schemas/gltf/EYEBOX_optics/schema";

/// Whether a noun has a schema of its own: all but the asset, whose attributes are the root's.
fn is_shared(noun: Noun) -> bool {
    noun != Noun::Asset
}

pub fn files() -> Vec<(String, String)> {
    let mut all = vec![
        file("glTF", "on the root of an asset", &root()),
        file("material", "on a material", &material()),
        file("node", "on a node; it holds for the parts below it, too, where nothing nearer says otherwise", &node()),
        file("mesh.primitive", "on a mesh primitive, which is one face", &primitive()),
    ];
    for noun in Noun::ALL.into_iter().filter(|noun| is_shared(*noun)) {
        let schema = match holder(noun) {
            // The list of the root holds tables; elsewhere the same may be a name or an index.
            Some(row) => super::json::row(row, Carrier::Gltf),
            None => extensible(whole(noun, Carrier::Gltf)),
        };
        all.push(titled(
            &shared(noun),
            &format!("EYEBOX_optics {noun}"),
            &format!("The attributes of {noun}."),
            schema,
        ));
    }
    all
}

fn shared(noun: Noun) -> String {
    format!("EYEBOX_optics.{noun}.schema.json")
}

fn file(of: &str, place: &str, schema: &Value) -> (String, String) {
    let name = format!("{of}.EYEBOX_optics.schema.json");
    let title = format!("EYEBOX_optics {of} extension");
    titled(&name, &title, &format!("Optical attributes {place}."), schema.clone())
}

fn titled(name: &str, title: &str, description: &str, schema: Value) -> (String, String) {
    let mut all = Map::from_iter([
        ("$schema".to_owned(), json!("https://json-schema.org/draft/2020-12/schema")),
        ("$id".to_owned(), name.into()),
        ("title".to_owned(), title.into()),
    ]);
    let own = match schema {
        Value::Object(entries) => entries,
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) | Value::Array(_) => Map::new(),
    };
    let told = own.get("description").cloned().unwrap_or_else(|| description.into());
    all.insert("description".to_owned(), told);
    all.extend(own.into_iter().filter(|(key, _)| key != "description"));
    (format!("{FOLDER}/{name}"), pretty(&Value::Object(all)))
}

/// An object as the specification wants it: a glTFProperty that lists `extensions` and `extras`.
fn property(properties: Map<String, Value>, required: &[&str]) -> Value {
    extensible(object(properties, required, Carrier::Gltf))
}

fn extensible(mut schema: Value) -> Value {
    if let Value::Object(entries) = &mut schema {
        if let Some(Value::Object(properties)) = entries.get_mut("properties") {
            properties.insert("extensions".to_owned(), json!({}));
            properties.insert("extras".to_owned(), json!({}));
        }
        entries.insert("allOf".to_owned(), json!([{ "$ref": "glTFProperty.schema.json" }]));
    }
    schema
}

/// A row's schema: the shared one of its noun if it is the whole noun.
fn of(own: &Row) -> (String, Value) {
    let schema = match (own.form, own.name == own.noun.to_string()) {
        (Form::Kind | Form::Thing(_), true) if is_shared(own.noun) => {
            json!({ "$ref": shared(own.noun) })
        }
        _ => row(own, Carrier::Gltf),
    };
    (own.name.to_owned(), schema)
}

fn root() -> Value {
    let mut all = Map::new();
    all.insert(
        "version".to_owned(),
        json!({ "type": "integer", "const": 1, "description": "Version of this vocabulary." }),
    );
    all.extend(properties(Noun::Asset, &["unit", "wavelengths"], Carrier::Gltf));
    let default: Map<String, Value> = medium().chain(faces()).map(of).collect();
    let mut default = property(default, &[]);
    if let Value::Object(entries) = &mut default {
        entries.insert("description".to_owned(), "What holds where nothing else says anything.".into());
    }
    all.insert("default".to_owned(), default);
    for noun in [Noun::Medium, Noun::Coating, Noun::Emitter, Noun::Slide] {
        let Some(name) = list(noun) else { continue };
        let description = format!("What `{noun}` refers to by index or by `name`.");
        all.insert(
            name.to_owned(),
            json!({ "type": "array", "items": { "$ref": shared(noun) }, "minItems": 1, "description": description }),
        );
    }
    for noun in [Noun::Sky, Noun::Sun, Noun::Eye] {
        all.insert(noun.to_string(), json!({ "$ref": shared(noun) }));
    }
    property(all, &["version"])
}

fn material() -> Value {
    property([Noun::Finish, Noun::Coating].into_iter().filter_map(holder).map(of).collect(), &[])
}

fn primitive() -> Value {
    property(faces().map(of).collect(), &[])
}

fn node() -> Value {
    let mut all: Map<String, Value> = medium().chain(FACE.into_iter().filter_map(holder)).map(of).collect();
    let mut some = selectors();
    some.extend(faces().map(of));
    let mut some = property(some, &[]);
    if let Value::Object(entries) = &mut some {
        entries.insert("oneOf".to_owned(), json!([{ "required": ["faces"] }, { "required": ["normal"] }]));
    }
    all.insert(
        "faces".to_owned(),
        json!({ "type": "array", "items": some, "minItems": 1, "description": "What holds for some faces only." }),
    );
    property(all, &[])
}
