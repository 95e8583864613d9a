//! Materials: the fields that mean something to light, their rows, and how they look.

use super::document::Document;
use super::surface::{Fields, Looks};
use super::user;
use super::value::{self, OPTICS};
use eyebox_base::colour::luminance;
use eyebox_base::error::Result;
use eyebox_scene::assembly::{Assembly, Material, MeshSource};
use eyebox_scene::value::{Data, Value};
use serde_json::{Map, Value as Json, json};

/// The glTF material of material `index`, which is there: what the reader of glTF maps from the ratified extensions goes back into them.
/// Anything else that another format mapped becomes a row of the material, where it has none.
pub fn material(document: &mut Document, assembly: &Assembly, index: usize) -> Result<Json> {
    let Some(material) = assembly.materials.get(index) else { return Ok(json!({})) };
    let mut out = Fields::new();
    out.insert("name".into(), Json::from(material.name.as_str()));
    let mut extensions = Fields::new();
    let mut put = |document: &mut Document, extension: &str, key: &str, json: Json| {
        document.uses(extension);
        let entry = extensions.entry(extension).or_insert_with(|| json!({}));
        entry[key] = json;
    };
    let mut rows: Vec<(String, Value)> = Vec::new();
    for (key, item) in &material.mapped {
        let number = item.number().and_then(value::number);
        match (key.as_str(), number) {
            ("ior", Some(n)) => put(document, "KHR_materials_ior", "ior", n),
            ("dispersion", Some(n)) => put(document, "KHR_materials_dispersion", "dispersion", n),
            ("transmission", Some(n)) => put(document, "KHR_materials_transmission", "transmissionFactor", n),
            ("thickness", Some(n)) => put(document, "KHR_materials_volume", "thicknessFactor", n),
            ("attenuation_distance", Some(n)) => put(document, "KHR_materials_volume", "attenuationDistance", n),
            // Infinite: the default.
            ("attenuation_distance", None) => {}
            ("attenuation_color", _) => {
                put(document, "KHR_materials_volume", "attenuationColor", value::json(item)?);
            }
            ("luminance_cd_m2", Some(n)) => {
                // With the colour that a format's own field gave: lanes from 0 to 1, the luminance in the strength.
                let glow = glow(material)
                    .zip(item.number())
                    .and_then(|((lanes, own), n)| Some((lanes, value::number(n / own)?)));
                let (lanes, strength) = glow.map_or((json!([1, 1, 1]), n), |(lanes, n)| (json!(lanes), n));
                out.insert("emissiveFactor".into(), lanes);
                put(document, "KHR_materials_emissive_strength", "emissiveStrength", strength);
            }
            ("emitter.spectrum", _) if glow(material).is_some() => {}
            // What glows beside `doubleSided` does so on both sides; a row of ours would be an emitter without a strength.
            ("emitter.sides", _) if is_double_sided(material) => {}
            ("coating", _) if film(item).is_some() => {
                if let Some((n, thickness)) = film(item) {
                    let extension = "KHR_materials_iridescence";
                    put(document, extension, "iridescenceFactor", json!(1));
                    put(document, extension, "iridescenceIor", json!(n));
                    put(document, extension, "iridescenceThicknessMinimum", json!(thickness));
                    put(document, extension, "iridescenceThicknessMaximum", json!(thickness));
                }
            }
            _ => rows.push((key.clone(), item.clone())),
        }
    }
    let own = material.attributes.as_ref();
    let mut all: Vec<(String, Value)> = own.and_then(Value::table).unwrap_or(&[]).to_vec();
    for (key, item) in rows {
        let (head, tail) = key.split_once('.').map_or((key.as_str(), None), |(head, tail)| (head, Some(tail)));
        if own.is_some_and(|own| own.get(head).is_some()) {
            continue;
        }
        // A film without a finish beside it is one of another program: a row of ours would be an error there.
        if head == "coating" {
            document.note(&item.at, format!("the coating of material `{}` has no form in glTF", material.name));
            continue;
        }
        match (tail, all.iter_mut().find(|(own, _)| own == head)) {
            (None, _) => all.push((key, item)),
            (Some(tail), Some((_, Value { data: Data::Table(table), .. }))) => table.push((tail.to_owned(), item)),
            (Some(tail), _) => {
                let at = item.at.clone();
                all.push((head.to_owned(), Value::new(Data::Table(vec![(tail.to_owned(), item)]), at)));
            }
        }
    }
    match &material.surface {
        Some(surface) => {
            Looks { document, assembly, material, index }.write(surface, &mut out, &mut extensions);
        }
        None if material.looks.iter().any(|(key, _)| LOOKS.contains(&key.as_str())) => looks(material, &mut out),
        None => {
            // Where nothing is said, glTF has polished metal; here it is matt, grey or as the colours of vertices are.
            let of_it = |mesh: &MeshSource| mesh.materials.contains(&Some(index)) && !mesh.mesh.colors.is_empty();
            let base = if assembly.meshes.iter().any(of_it) { 1.0 } else { 0.8 };
            out.insert(
                "pbrMetallicRoughness".into(),
                json!({ "baseColorFactor": [base, base, base, 1], "metallicFactor": 0, "roughnessFactor": 1 }),
            );
            put(document, "KHR_materials_specular", "specularFactor", json!(0));
        }
    }
    if is_double_sided(material) {
        out.insert("doubleSided".into(), Json::from(true));
    }
    if own.is_some() || !all.is_empty() {
        document.uses(OPTICS);
        let at = own.map_or(&material.at, |own| &own.at).clone();
        extensions.insert(OPTICS.into(), value::json(&Value::new(Data::Table(all), at))?);
    }
    if !extensions.is_empty() {
        out.insert("extensions".into(), Json::Object(extensions));
    }
    if let Some(extras) = user::extras(&material.user) {
        out.insert("extras".into(), extras);
    }
    Ok(Json::Object(out))
}

fn is_double_sided(material: &Material) -> bool {
    let says = |(key, value): &(String, Value)| key == "double_sided" && matches!(value.data, Data::Bool(true));
    material.looks.iter().any(says)
}

/// The colour of a material that glows, its largest lane 1, and its luminance; none if it isn't a colour with a luminance.
fn glow(material: &Material) -> Option<([f64; 3], f64)> {
    let find = |name: &str| material.mapped.iter().find(|(key, _)| key == name).map(|(_, value)| value);
    find("luminance_cd_m2")?.number()?;
    let [r, g, b] = find("emitter.spectrum")?.get("rgb")?.list()? else { return None };
    let lanes = [r.number()?, g.number()?, b.number()?];
    let most = lanes.iter().copied().fold(0.0, f64::max);
    let lanes = lanes.map(|lane| lane / most);
    let own = luminance(lanes);
    (lanes.iter().all(|lane| *lane >= 0.0) && own > 0.0 && own.is_finite()).then_some((lanes, own))
}

/// (index, thickness in nm) of a single film without absorption that `KHR_materials_iridescence` can say.
fn film(coating: &Value) -> Option<(f64, f64)> {
    let [film] = coating.get("stack")?.list()? else { return None };
    let only = film.table()?.iter().all(|(key, _)| key == "n" || key == "thickness_nm");
    let (n, thickness) = (film.get("n")?.number()?, film.get("thickness_nm")?.number()?);
    (only && n >= 1.0 && n.is_finite() && thickness >= 0.0 && thickness.is_finite()).then_some((n, thickness))
}

/// What a format can say of looks that has no surface of ours.
const LOOKS: [&str; 4] = ["base_color", "opacity", "metallic", "roughness"];

/// `pbrMetallicRoughness` of what a format says of looks that has no surface of ours.
fn looks(material: &Material, out: &mut Fields) {
    let find = |name: &str| material.looks.iter().find(|(key, _)| key == name).map(|(_, value)| value);
    let lanes = |value: &Value| -> Option<[f64; 3]> {
        let [r, g, b] = value.list()? else { return None };
        Some([r.number()?, g.number()?, b.number()?])
    };
    let share = |name: &str| find(name).and_then(Value::number).map(|number| number.clamp(0.0, 1.0));
    let mut pbr = Map::new();
    let (color, opacity) = (find("base_color").and_then(lanes), share("opacity"));
    if color.is_some() || opacity.is_some() {
        let [r, g, b] = color.unwrap_or([1.0; 3]).map(|lane| lane.clamp(0.0, 1.0));
        pbr.insert("baseColorFactor".into(), json!([r, g, b, opacity.unwrap_or(1.0)]));
        if opacity.is_some() {
            out.insert("alphaMode".into(), Json::from("BLEND"));
        }
    }
    for (name, key) in [("metallic", "metallicFactor"), ("roughness", "roughnessFactor")] {
        if let Some(number) = share(name) {
            pbr.insert(key.into(), json!(number));
        }
    }
    if !pbr.is_empty() {
        out.insert("pbrMetallicRoughness".into(), Json::Object(pbr));
    }
}
