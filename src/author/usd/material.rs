//! Materials: how they look as UsdPreviewSurface and, where that lacks something, as OpenPBR beside it; what they are optically
//! as our own attributes.
//!
//! A shader's inputs are single precision and lack most of what a material can say, so `mapped` and `looks` of the
//! [`Material`] stand in `customData["eyebox"]` too, as JSON: lists of [key, value].

use super::layer::{Datum, Prim, Property};
use super::network::Network;
use super::open_pbr::{self, Optics};
use super::picture::Pictures;
use super::stage::{Writing, named};
use super::{optics, preview, user};
use eyebox_base::colour::luminance;
use eyebox_base::error::Result;
use eyebox_scene::assembly::{Assembly, Material};
use eyebox_scene::value::{Data, Value};
use eyebox_scene::{Colour, Opacity, Scalar, StandardSurface};

/// Binds material `index` to a prim.
///
/// # Errors
/// There is no such material.
pub(super) fn bind(writing: &Writing<'_>, index: usize, prim: &mut Prim) -> Result<()> {
    let Some(path) = writing.materials.get(index) else {
        return Err(writing.fault(&eyebox_base::Where::Nowhere, format!("there is no material {index}")));
    };
    prim.apply("MaterialBindingAPI");
    prim.push(Property::relationship("material:binding", vec![path.clone()]));
    Ok(())
}

/// Appends the scope of all materials below the default prim.
pub(super) fn library(
    writing: &Writing<'_>,
    scope: &str,
    pictures: &mut Pictures,
    prims: &mut Vec<Prim>,
) -> Result<()> {
    if writing.assembly.materials.is_empty() {
        return Ok(());
    }
    prims.push(Prim::def(1, "Scope", scope));
    for (index, (material, path)) in writing.assembly.materials.iter().zip(&writing.materials).enumerate() {
        let name = path.rsplit('/').next().unwrap_or_default();
        let mut prim = Prim::def(2, "Material", name);
        named(&mut prim, &material.name);
        for (key, rows) in [("mapped", &material.mapped), ("looks", &material.looks)] {
            let rows: Vec<_> =
                rows.iter().filter(|(key, _)| !tinted(material) || !GLOW.contains(&key.as_str())).collect();
            if !rows.is_empty() {
                let list = rows.iter().map(|(key, value)| serde_json::json!([key, json(value)])).collect();
                prim.marks.push((key, Datum::Text(serde_json::Value::Array(list).to_string())));
            }
        }
        if let Some(attributes) = &material.attributes {
            optics::apply(writing, attributes, &mut prim)?;
        }
        user::say(writing, &material.user, &mut prim);
        if let Some(surface) = &material.surface {
            unsaid(material, surface, &mut prim);
            let vertices = vertices(writing.assembly, index);
            let mut network = Network::new(writing.assembly, (material, path), vertices, pictures);
            shown(&mut network, surface, &mut prim);
            let nodes = network.finish();
            prims.push(prim);
            prims.extend(nodes);
            continue;
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

/// A shader says everything, the material may have said less: a mark tells what only its looks have, so that no more than that
/// comes back.
fn unsaid(material: &Material, surface: &StandardSurface, prim: &mut Prim) {
    let alpha = match &surface.opacity {
        Opacity::Opaque => None,
        Opacity::Mask { alpha, .. } | Opacity::Blend { alpha } => Some(serde_json::json!(alpha.factor)),
    };
    let all = [
        ("base_color", Some(serde_json::json!(surface.base_color.factor))),
        ("opacity", alpha),
        ("metallic", Some(serde_json::json!(surface.metallic.factor))),
        ("roughness", Some(serde_json::json!(surface.roughness.factor))),
    ];
    let said = |key: &str| material.looks.iter().any(|(own, _)| own == key);
    let list: Vec<_> = all
        .into_iter()
        .filter(|(key, _)| !said(key))
        .filter_map(|(key, value)| Some(serde_json::json!([key, value?])))
        .collect();
    if !list.is_empty() {
        prim.marks.push(("unsaid", Datum::Text(serde_json::Value::Array(list).to_string())));
    }
}

/// Whether faces with this material have colours at their vertices, and whether some of those let light through.
fn vertices(assembly: &Assembly, material: usize) -> Option<bool> {
    let own = assembly.meshes.iter().filter(|source| source.materials.contains(&Some(material)));
    let mut colored = own.filter(|source| !source.mesh.colors.is_empty()).peekable();
    colored.peek()?;
    Some(colored.any(|source| source.mesh.colors.iter().any(|[.., alpha]| *alpha != 1.0)))
}

/// Adds the surfaces of a material to its network, and connects its outputs to them.
fn shown(network: &mut Network<'_>, surface: &StandardSurface, prim: &mut Prim) {
    let material = network.material;
    let optics = optical(material, surface, optics::unit(network.assembly));
    let output = preview::write(network, surface, optics.ior, optics.glow);
    prim.push(Property::connected("outputs:surface", "token", output));
    through(network, surface, prim);
    if !open_pbr::is_needed(surface, &optics, network.vertices) {
        return;
    }
    if surface.ior == f64::INFINITY {
        let text = "an infinite index has no form in OpenPBR: what UsdPreviewSurface lacks is not written";
        return network.warn("OpenPBR", text);
    }
    let output = open_pbr::write(network, surface, &optics);
    prim.push(Property::connected("outputs:mtlx:surface", "token", output));
}

/// Rows of what a material emits.
const GLOW: [&str; 2] = ["luminance_cd_m2", "emitter.spectrum"];

/// Whether a picture of what the material emits is tinted: the shader's colour is the picture's scale then, and the rows would
/// say it a second time.
fn tinted(material: &Material) -> bool {
    let picture = material.surface.as_ref().is_some_and(|surface| surface.emission.is_some());
    picture && material.mapped.iter().any(|(key, _)| key == "emitter.spectrum")
}

/// Diffuse transmission, which neither of the surfaces has: marks that only our reader knows.
fn through(network: &mut Network<'_>, surface: &StandardSurface, prim: &mut Prim) {
    let (share, color) = (&surface.diffuse_transmission, &surface.diffuse_transmission_color);
    if *share == Scalar::new(0.0) && *color == Colour::new([1.0; 3]) {
        return;
    }
    prim.marks.push(("diffuse_transmission", Datum::Double(share.factor)));
    prim.marks.push(("diffuse_transmission_color", Datum::Double3(color.factor)));
    let pictures =
        if share.texture.is_some() || color.texture.is_some() { "; its pictures are not written" } else { "" };
    network.warn("diffuse transmission", &format!("has no form in USD that other programs read{pictures}"));
}

/// What the material's own fields say, for shaders.
fn optical(material: &Material, surface: &StandardSurface, unit_m: f64) -> Optics {
    let find = |key: &str| material.mapped.iter().find(|(own, _)| own == key).map(|(_, value)| value);
    let number = |key: &str| find(key).and_then(Value::number).filter(|x| x.is_finite());
    let positive = |key: &str| number(key).filter(|x| *x > 0.0);
    let lanes = |value: Option<&Value>| -> Option<[f64; 3]> {
        let [r, g, b] = value?.list()? else { return None };
        Some([r.number()?, g.number()?, b.number()?])
    };
    let glow = positive("luminance_cd_m2").map(|nit| {
        let color = lanes(find("emitter.spectrum").and_then(|spectrum| spectrum.get("rgb"))).unwrap_or([1.0; 3]);
        let own = luminance(color);
        color.map(|lane| lane * nit / own)
    });
    let through = surface.transmission != Scalar::new(0.0);
    let film = |coating: &Value| -> Option<(f64, f64)> {
        let [film] = coating.get("stack")?.list()? else { return None };
        Some((film.get("n")?.number()?, film.get("thickness_nm")?.number()?))
    };
    let solid = through && positive("thickness").is_some();
    let attenuation = positive("attenuation_distance").zip(lanes(find("attenuation_color"))).filter(|_| solid);
    Optics {
        ior: number("ior").or((surface.ior != 1.5 && surface.ior.is_finite()).then_some(surface.ior)),
        glow: glow.filter(|glow| glow.iter().all(|lane| lane.is_finite() && *lane >= 0.0)),
        solid,
        attenuation: attenuation.map(|(distance_m, color)| (distance_m / unit_m, color)),
        dispersion: positive("dispersion").filter(|_| through),
        film: find("coating").and_then(film),
    }
}

/// What UsdPreviewSurface can show of what a format says of looks that has no surface of ours.
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
    // Emission of shaders is light: without it the row would be that of a material that somebody has put out.
    if let Some(nit) = find(&material.mapped, "luminance_cd_m2").and_then(|nit| nit.number()).filter(|nit| *nit > 0.0) {
        let grey = [nit as f32; 3];
        if grey[0].is_finite() {
            out.push(Property::new("inputs:emissiveColor", Datum::Float3(grey)).typed("color3f"));
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
