//! Codeless applied API schemas: `generatedSchema.usda` and `plugInfo.json`, which USD loads from a folder of
//! `PXR_PLUGINPATH_NAME`. No property has a fallback: what an asset doesn't say stays unsaid.

use super::face::FACE;
use eyebox_scene::attribute::Noun;
use eyebox_scene::attribute::usd::{NAMESPACE, Property, UsdType, properties};
use serde_json::{Map, Value, json};
use std::fmt::Write;

const FOLDER: &str = "schemas/usd/eyebox";
/// The major version of the family: part of each schema's name.
const VERSION: &str = "_1";

/// A class: what it is called, what it is for, its properties.
struct Class {
    name: &'static str,
    doc: &'static str,
    multiple: bool,
    properties: Vec<Property>,
}

impl Class {
    fn identifier(&self) -> String {
        format!("Eyebox{}API{VERSION}", self.name)
    }
}

fn classes() -> Vec<Class> {
    let one = |noun: Noun, name, doc| Class { name, doc, multiple: false, properties: properties(noun) };
    let mut all = vec![
        one(
            Noun::Asset,
            "Asset",
            "The whole asset; on its default prim. What holds where nothing else says anything is \
            any property of a medium or a face with eyebox:default: before the rest of its name.",
        ),
        one(Noun::Medium, "Medium", "The inside of a closed solid; on the solid or above it, or on its material."),
        one(Noun::Finish, "Finish", "What a face does with light; on a mesh, above it, on a GeomSubset or a material."),
        one(
            Noun::Coating,
            "Coating",
            "Thin films on a polished face; on a mesh, above it, on a GeomSubset or a material.",
        ),
        one(Noun::Shape, "Shape", "The exact surface that a mesh or a GeomSubset approximates."),
        one(Noun::Emitter, "Emitter", "A face that emits; on a mesh, above it or on a GeomSubset."),
        one(Noun::Slide, "Slide", "A thin transmissive picture; on a mesh, above it or on a GeomSubset."),
        one(Noun::Sensor, "Sensor", "A map of the light that arrives; on a mesh, above it or on a GeomSubset."),
        one(Noun::Sky, "Sky", "Light from everywhere; on a DomeLight or on the default prim."),
        one(Noun::Sun, "Sun", "Light from one direction; on the default prim. A DistantLight says the same."),
        one(Noun::Eye, "Eye", "Who looks; on a camera or on the default prim."),
    ];
    let mut face = vec![selector("faces", UsdType::Ints, "numbers of CAD faces, in the order of the subsets")];
    face.push(selector("normal", UsdType::Token, "the faces that look along this axis of the part, within 1 degree"));
    face.extend(FACE.into_iter().flat_map(properties));
    for property in &mut face {
        property.name = format!("face:__INSTANCE_NAME__:{}", property.name);
    }
    let doc = "What holds for some faces of a part; each instance selects faces by number or by direction. For parts \
        whose faces can't carry properties of their own: instances.";
    all.push(Class { name: "Face", doc, multiple: true, properties: face });
    all
}

/// A property that says which faces are meant.
fn selector(name: &str, ty: UsdType, doc: &str) -> Property {
    let tokens = if ty == UsdType::Token { vec!["+x", "-x", "+y", "-y", "+z", "-z"] } else { Vec::new() };
    let row = &eyebox_scene::attribute::ROWS[0];
    Property { name: name.to_owned(), ty, row, tokens, doc: doc.to_owned() }
}

pub fn files() -> Vec<(String, String)> {
    vec![
        (format!("{FOLDER}/generatedSchema.usda"), usda()),
        (format!("{FOLDER}/plugInfo.json"), super::json::pretty(&plug())),
    ]
}

fn usda() -> String {
    let mut out = "#usda 1.0\n(\n    \"Generated from the attribute table of eyebox; do not edit.\"\n)\n".to_owned();
    for class in classes() {
        // Writing to a string can't fail.
        let _ = writeln!(out, "\nclass \"{}\" (\n    doc = \"\"\"{}\"\"\"\n)\n{{", class.identifier(), class.doc);
        for (index, property) in class.properties.iter().enumerate() {
            let gap = if index == 0 { "" } else { "\n" };
            let _ = writeln!(out, "{gap}    {} {NAMESPACE}{} (", property.ty.name(), property.name);
            if !property.tokens.is_empty() {
                let tokens: Vec<String> = property.tokens.iter().map(|token| format!("\"{token}\"")).collect();
                let _ = writeln!(out, "        allowedTokens = [{}]", tokens.join(", "));
            }
            let selects = property.name.ends_with(":faces") || property.name.ends_with(":normal");
            let (unit, default) = match selects {
                true => (String::new(), String::new()),
                false => (
                    if property.row.unit.is_empty() { String::new() } else { format!(" Unit: {}.", property.row.unit) },
                    property.row.default.map_or(String::new(), |default| format!(" Where it isn't said: {default}.")),
                ),
            };
            let _ = writeln!(out, "        doc = \"\"\"{}.{unit}{default}\"\"\"\n    )", property.doc);
        }
        out.push_str("}\n");
    }
    out
}

fn plug() -> Value {
    let types = classes().into_iter().map(|class| {
        let identifier = class.identifier();
        let kind = if class.multiple { "multipleApplyAPI" } else { "singleApplyAPI" };
        // The type's own name must differ from the schema's; 24.8 finds the schema by its alias only.
        let entry = json!({
            "alias": { "UsdSchemaBase": identifier },
            "autoGenerated": true,
            "bases": ["UsdAPISchemaBase"],
            "schemaIdentifier": identifier,
            "schemaKind": kind,
        });
        (format!("EyeboxOptics{}API{VERSION}", class.name), entry)
    });
    json!({
        "Plugins": [{
            "Info": { "Types": types.collect::<Map<_, _>>() },
            "LibraryPath": "",
            "Name": "eyeboxOptics",
            "ResourcePath": ".",
            "Root": ".",
            "Type": "resource",
        }]
    })
}
