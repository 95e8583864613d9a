//! Lights with an extent, which glTF has not: meshes that glow on their outside, of the size and the luminance of the light. They
//! are black otherwise, as a light is that nothing but shines.

use super::document::Document;
use super::value::{self, OPTICS};
use eyebox_base::error::Result;
use eyebox_scene::assembly::{Assembly, LightForm, LightSource};
use eyebox_scene::light_shapes;
use serde_json::{Value as Json, json};

/// Puts the light on its node, or on a new node below it where that has a mesh already. New nodes come after all that are there.
///
/// # Errors
/// Numbers that JSON has not.
pub fn write(document: &mut Document, assembly: &Assembly, light: &LightSource) -> Result<()> {
    let (luminance, shape) = match light.form {
        LightForm::Rect { luminance_cd_m2, width, height } => (luminance_cd_m2, light_shapes::rect(width, height)),
        LightForm::Disk { luminance_cd_m2, radius } => (luminance_cd_m2, light_shapes::disk(radius)),
        LightForm::Sphere { luminance_cd_m2, radius } => (luminance_cd_m2, light_shapes::sphere(radius)),
        LightForm::Cylinder { luminance_cd_m2, radius, length } => {
            (luminance_cd_m2, light_shapes::cylinder(radius, length))
        }
        LightForm::Point { .. } | LightForm::Distant { .. } | LightForm::Dome { .. } => return Ok(()),
    };
    if light.profile.is_some() {
        let text = format!("light `{}`: its intensity distribution is not written, it shines evenly", light.name);
        document.note(&light.at, text);
    }
    let number = document.lamps.len();
    let positions = document.binary.positions(&shape.positions);
    let attributes = json!({ "POSITION": positions, "NORMAL": document.binary.normals(&shape.normals) });
    let indices = document.binary.indices(&shape.triangles);
    let material = assembly.materials.len() + number;
    let mesh = json!({
        "name": light.name, "primitives": [{ "attributes": attributes, "indices": indices, "material": material }],
    });
    let material = glow(document, assembly, light, luminance)?;
    document.lamps.push((mesh, material));
    let mesh = assembly.meshes.len() + number;
    let next = document.nodes.len();
    let Some(Json::Object(own)) = document.nodes.get_mut(light.node) else { return Ok(()) };
    if !own.contains_key("mesh") {
        own.insert("mesh".into(), Json::from(mesh));
        return Ok(());
    }
    if let Json::Array(children) = own.entry("children").or_insert_with(|| json!([])) {
        children.push(Json::from(next));
    }
    document.nodes.push(json!({ "name": light.name, "mesh": mesh }));
    Ok(())
}

/// The material of a light. Rows of ours only where the asset has some: without any it is looked at by default eyes and skies.
fn glow(document: &mut Document, assembly: &Assembly, light: &LightSource, luminance: f64) -> Result<Json> {
    let most = light.color.iter().copied().fold(0.0, f64::max);
    let lanes = light.color.map(|lane| if most > 0.0 { (lane / most).clamp(0.0, 1.0) } else { 1.0 });
    let strength = value::number(luminance * if most > 0.0 { most } else { 1.0 }).unwrap_or_default();
    let own = |key: &str| light.attributes.as_ref().and_then(|own| own.get(key));
    let mut emitter = json!({ "luminance_cd_m2": luminance });
    let [r, g, b] = light.color;
    match (own("spectrum"), light.kelvin) {
        (Some(spectrum), _) => emitter["spectrum"] = value::json(spectrum)?,
        (None, Some(kelvin)) => emitter["spectrum"] = json!({ "cct": kelvin }),
        (None, None) if r == g && g == b => {}
        (None, None) => emitter["spectrum"] = json!({ "rgb": light.color }),
    }
    let name: String = light.name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    emitter["group"] = match own("group") {
        Some(group) => value::json(group)?,
        None if name.starts_with(|c: char| c.is_ascii_alphabetic()) => Json::from(name),
        None => Json::from(format!("light_{name}")),
    };
    let (strong, specular) = ("KHR_materials_emissive_strength", "KHR_materials_specular");
    document.uses(strong);
    document.uses(specular);
    let mut extensions = json!({ strong: { "emissiveStrength": strength }, specular: { "specularFactor": 0 } });
    if assembly.says_what_parts_are() {
        document.uses(OPTICS);
        extensions[OPTICS] = json!({ "finish": "absorber", "emitter": emitter });
    }
    Ok(json!({
        "name": light.name, "emissiveFactor": lanes,
        "pbrMetallicRoughness": { "baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0, "roughnessFactor": 1 },
        "extensions": extensions,
    }))
}
