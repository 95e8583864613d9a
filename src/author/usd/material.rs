//! Materials: how they look as UsdPreviewSurface, what they are optically as our own attributes.
//!
//! A shader's inputs are single precision and lack most of what a material can say, so `mapped` and `looks` of the
//! [`Material`] stand in `customData["eyebox"]` too, as JSON: lists of [key, value].

use super::layer::{Datum, Prim, Property};
use super::optics;
use super::stage::{Writing, named};
use crate::base::fault::Result;
use crate::scene::assembly::Material;
use crate::scene::value::{Data, Value};

/// Binds material `index` to a prim.
///
/// # Errors
/// There is no such material.
pub(super) fn bind(writing: &Writing<'_>, index: usize, prim: &mut Prim) -> Result<()> {
    let Some(path) = writing.materials.get(index) else {
        return Err(writing.fault(&crate::base::Where::Nowhere, format!("there is no material {index}")));
    };
    prim.apply("MaterialBindingAPI");
    prim.push(Property::relationship("material:binding", vec![path.clone()]));
    Ok(())
}

/// Appends the scope of all materials below the default prim.
pub(super) fn library(writing: &Writing<'_>, scope: &str, prims: &mut Vec<Prim>) -> Result<()> {
    if writing.assembly.materials.is_empty() {
        return Ok(());
    }
    prims.push(Prim::def(1, "Scope", scope));
    for (material, path) in writing.assembly.materials.iter().zip(&writing.materials) {
        let name = path.rsplit('/').next().unwrap_or_default();
        let mut prim = Prim::def(2, "Material", name);
        named(&mut prim, &material.name);
        for (key, rows) in [("mapped", &material.mapped), ("looks", &material.looks)] {
            if !rows.is_empty() {
                let list = rows.iter().map(|(key, value)| serde_json::json!([key, json(value)])).collect();
                prim.marks.push((key, Datum::Text(serde_json::Value::Array(list).to_string())));
            }
        }
        if let Some(attributes) = &material.attributes {
            optics::apply(writing, attributes, &mut prim)?;
        }
        let inputs = inputs(material);
        if inputs.is_empty() {
            prims.push(prim);
            continue;
        }
        prim.push(Property::connected("outputs:surface", "token", format!("{path}/Surface.outputs:surface")));
        prims.push(prim);
        let mut shader = Prim::def(3, "Shader", "Surface");
        shader.push(Property::new("info:id", Datum::Token("UsdPreviewSurface".to_owned())).uniform());
        shader.properties.extend(inputs);
        shader.push(Property::declared("outputs:surface", "token"));
        prims.push(shader);
    }
    Ok(())
}

/// What UsdPreviewSurface can show.
fn inputs(material: &Material) -> Vec<Property> {
    let find = |rows: &[(String, Value)], key: &str| rows.iter().find(|(own, _)| own == key).map(|(_, v)| v.clone());
    let single = |value: f64| (value as f32).is_finite().then_some(Datum::Float(value as f32));
    let mut out = Vec::new();
    if let Some(color) = find(&material.looks, "base_color") {
        let lanes: Vec<f32> =
            color.list().unwrap_or(&[]).iter().filter_map(Value::number).map(|lane| lane as f32).collect();
        if let [r, g, b] = lanes.as_slice() {
            out.push(Property::new("inputs:diffuseColor", Datum::Float3([*r, *g, *b])).typed("color3f"));
        }
    }
    for (key, input) in [("metallic", "metallic"), ("roughness", "roughness"), ("opacity", "opacity")] {
        if let Some(value) = find(&material.looks, key).as_ref().and_then(Value::number).and_then(single) {
            out.push(Property::new(format!("inputs:{input}"), value));
        }
    }
    if let Some(ior) = find(&material.mapped, "ior").as_ref().and_then(Value::number).and_then(single) {
        out.push(Property::new("inputs:ior", ior));
    }
    out
}

/// A value as JSON; infinity, which JSON lacks, as the text `inf`.
fn json(value: &Value) -> serde_json::Value {
    match &value.data {
        Data::Bool(flag) => (*flag).into(),
        Data::Number(number) if *number == f64::INFINITY => "inf".into(),
        Data::Number(number) => (*number).into(),
        Data::Text(text) => text.as_str().into(),
        Data::List(items) => items.iter().map(json).collect(),
        Data::Table(entries) => {
            serde_json::Value::Object(entries.iter().map(|(key, value)| (key.clone(), json(value))).collect())
        }
    }
}
