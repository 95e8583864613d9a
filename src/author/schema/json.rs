//! A row's values as JSON Schema 2020-12.

use eyebox_scene::attribute::{self, Form, Noun, Range, Row, Support, kinds, named};
use serde_json::{Map, Value, json};

/// How tables are closed and how things are referred to differs between the carriers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Carrier {
    /// glTF: unknown properties pass, enumerations stay open, things of the asset by index.
    Gltf,
    /// Sidecars: the editor shall show misspelt names.
    Sidecar,
}

/// The schema of a row's value with its description.
pub fn row(row: &Row, carrier: Carrier) -> Value {
    let mut schema = form(row, carrier);
    if let Value::Object(entries) = &mut schema {
        let unit = if row.unit.is_empty() { String::new() } else { format!(" Unit: {}.", row.unit) };
        let default = row.default.map_or(String::new(), |default| format!(" Default: {default}."));
        let state = match row.support {
            Support::Rendered => "",
            Support::Kept => " Kept and reported; changes no picture yet.",
            Support::NotYet => " Not rendered yet: using it is an error.",
        };
        entries.insert("description".to_owned(), format!("{}.{unit}{default}{state}", row.doc).into());
    }
    schema
}

fn form(row: &Row, carrier: Carrier) -> Value {
    let number = number(row.range);
    let rows = |columns: usize| {
        let line = json!({ "type": "array", "items": number, "minItems": columns, "maxItems": columns });
        json!({ "type": "array", "items": line, "minItems": 1 })
    };
    match row.form {
        Form::Number => number,
        Form::Integer => json!({ "type": "integer" }),
        Form::Text => json!({ "type": "string" }),
        Form::File => json!({ "type": "string", "format": "uri-reference" }),
        Form::Length => length(carrier),
        Form::LengthOr(words) => {
            let words = words_schema(words.iter().map(|word| (*word, "")), carrier);
            json!({ "anyOf": [length(carrier), words] })
        }
        Form::Word(words) => words_schema(words.iter().map(|word| (*word, "")), carrier),
        Form::Numbers(count) => json!({ "type": "array", "items": number, "minItems": count, "maxItems": count }),
        Form::Integers(count) => {
            let mut item = number;
            if let Value::Object(entries) = &mut item {
                entries.insert("type".to_owned(), "integer".into());
            }
            json!({ "type": "array", "items": item, "minItems": count, "maxItems": count })
        }
        Form::Place => json!({ "type": "array", "items": length(carrier), "minItems": 3, "maxItems": 3 }),
        Form::Coefficients { least, most } => {
            json!({ "type": "array", "items": number, "minItems": least, "maxItems": most })
        }
        Form::Rows(columns) => rows(columns.len()),
        Form::NumberOrRows(columns) => json!({ "anyOf": [number, rows(columns.len())] }),
        Form::Record(fields) => {
            let must = |name: &&str| attribute::row(row.noun, name).is_some_and(|row| row.default.is_none());
            let required: Vec<&str> = fields.iter().copied().filter(must).collect();
            table(row.noun, fields, &required, carrier)
        }
        Form::Records(fields) => {
            json!({ "type": "array", "items": table(row.noun, fields, &[], carrier), "minItems": 1 })
        }
        Form::Thing(fields) => {
            json!({ "anyOf": reference(carrier).into_iter().chain([table(row.noun, fields, &[], carrier)]).collect::<Vec<_>>() })
        }
        Form::Kind => union(row, carrier),
    }
}

/// A reference to a thing: by name, in glTF also by index.
fn reference(carrier: Carrier) -> Vec<Value> {
    let name = json!({ "type": "string", "minLength": 1 });
    match carrier {
        Carrier::Gltf => vec![json!({ "type": "integer", "minimum": 0 }), name],
        Carrier::Sidecar => vec![name],
    }
}

/// A length with its unit; 0 and, where there is such a number, infinity may stand without one.
fn length(carrier: Carrier) -> Value {
    let pattern = "^\\s*(inf|infinity|∞|[-+0-9.eE]+\\s*(nm|um|µm|μm|mm|cm|m|km|in))\\s*$";
    let mut all = vec![json!({ "type": "string", "pattern": pattern }), json!({ "const": 0 })];
    match carrier {
        Carrier::Gltf => {}
        Carrier::Sidecar => all.push(json!({ "type": "number", "exclusiveMinimum": f64::MAX })),
    }
    json!({ "anyOf": all })
}

/// Words: open in glTF, as its enumerations are.
pub fn words_schema<'a>(words: impl Iterator<Item = (&'a str, &'a str)>, carrier: Carrier) -> Value {
    let mut all: Vec<Value> = words
        .map(
            |(word, doc)| {
                if doc.is_empty() { json!({ "const": word }) } else { json!({ "const": word, "description": doc }) }
            },
        )
        .collect();
    match carrier {
        Carrier::Gltf => all.push(json!({ "type": "string" })),
        Carrier::Sidecar => {}
    }
    json!({ "anyOf": all })
}

/// A kind: a text, or a table with `kind` and its parameters, or a table under the kind's name.
fn union(row: &Row, carrier: Carrier) -> Value {
    let all = || kinds(row.name);
    let mut forms = Vec::new();
    if named(row.noun) && row.name == row.noun.to_string() {
        forms.extend(reference(carrier));
    } else {
        forms.push(words_schema(all().filter(|kind| kind.parameters.is_empty()).map(|k| (k.name, k.doc)), carrier));
    }
    for kind in all() {
        let mut tagged = properties(row.noun, kind.parameters, carrier);
        tagged.insert("kind".to_owned(), json!({ "const": kind.name, "description": kind.doc }));
        forms.push(object(tagged, &["kind"], carrier));
        if kind.parameters.contains(&kind.name) {
            forms.push(object(properties(row.noun, kind.parameters, carrier), &[kind.name], carrier));
        } else if !kind.parameters.is_empty() {
            let inner = object(properties(row.noun, kind.parameters, carrier), &[], carrier);
            forms.push(object(Map::from_iter([(kind.name.to_owned(), inner)]), &[kind.name], carrier));
        }
    }
    json!({ "anyOf": forms })
}

/// The schemas of some rows of a noun, by name.
pub fn properties(noun: Noun, fields: &[&str], carrier: Carrier) -> Map<String, Value> {
    let rows = fields.iter().filter_map(|name| attribute::row(noun, name));
    rows.map(|own| (own.name.to_owned(), row(own, carrier))).collect()
}

/// The table of a noun that has no row of its own name.
pub fn whole(noun: Noun, carrier: Carrier) -> Value {
    let names: Vec<&str> = attribute::own_rows(noun).map(|row| row.name).collect();
    let mut schema = object(properties(noun, &names, carrier), &[], carrier);
    if let (Value::Object(entries), Noun::Sky) = (&mut schema, noun) {
        // Which of them there is may be said elsewhere: a sidecar adds to what the asset says.
        let kinds = attribute::SKIES.map(|(kind, _)| kind);
        let pairs = (0..kinds.len()).flat_map(|a| (0..a).map(move |b| (b, a)));
        let both: Vec<Value> = pairs.map(|(a, b)| json!({ "required": [kinds[a], kinds[b]] })).collect();
        entries.insert("not".to_owned(), json!({ "anyOf": both }));
    }
    schema
}

fn table(noun: Noun, fields: &[&str], required: &[&str], carrier: Carrier) -> Value {
    object(properties(noun, fields, carrier), required, carrier)
}

pub fn object(properties: Map<String, Value>, required: &[&str], carrier: Carrier) -> Value {
    let mut schema = json!({ "type": "object", "properties": properties });
    if let Value::Object(entries) = &mut schema {
        if !required.is_empty() {
            entries.insert("required".to_owned(), json!(required));
        }
        if carrier == Carrier::Sidecar {
            entries.insert("additionalProperties".to_owned(), false.into());
        }
    }
    schema
}

/// A number of the range; infinity is the text "inf".
fn number(range: Range) -> Value {
    let or_infinite = |schema: Value| json!({ "anyOf": [schema, { "const": "inf" }] });
    match range {
        Range::Any => json!({ "type": "number" }),
        Range::AtLeast(min) => json!({ "type": "number", "minimum": tidy(min) }),
        Range::AtLeastOrInfinite(min) => or_infinite(json!({ "type": "number", "minimum": tidy(min) })),
        Range::Positive => json!({ "type": "number", "exclusiveMinimum": 0 }),
        Range::PositiveOrInfinite => or_infinite(json!({ "type": "number", "exclusiveMinimum": 0 })),
        Range::NonZero => json!({ "type": "number", "not": { "const": 0 } }),
        Range::Within(low, high) => json!({ "type": "number", "minimum": tidy(low), "maximum": tidy(high) }),
        Range::Above(low, high) => json!({ "type": "number", "exclusiveMinimum": tidy(low), "maximum": tidy(high) }),
        Range::Between(low, high) => {
            json!({ "type": "number", "exclusiveMinimum": tidy(low), "exclusiveMaximum": tidy(high) })
        }
    }
}

/// Whole numbers without a fraction.
fn tidy(x: f64) -> Value {
    if x.fract() == 0.0 && x.abs() < 1e15 { (x as i64).into() } else { x.into() }
}

/// Which faces: numbers or a direction.
pub fn selectors() -> Map<String, Value> {
    let faces = json!({
        "type": "array", "items": { "type": "integer", "minimum": 0 }, "minItems": 1,
        "description": "numbers of CAD faces, in the order of the mesh's primitives",
    });
    let normal = json!({
        "enum": ["+x", "-x", "+y", "-y", "+z", "-z"],
        "description": "the faces that look along this axis of the part, within 1 degree",
    });
    Map::from_iter([("faces".to_owned(), faces), ("normal".to_owned(), normal)])
}

pub fn pretty(schema: &Value) -> String {
    // Serialising a tree of values can't fail; were it to, the stale file would tell.
    let mut text = serde_json::to_string_pretty(schema).unwrap_or_default();
    text.push('\n');
    text
}
