//! Paths as `LINE_STRIP`s of a binary glTF: a node for each end, a primitive for each path, names in `extras`.

use super::{End, Line, by_end};
use eyebox_base::glb::container;
use serde_json::{Value as Json, json};

/// The bytes of the file; none if it would pass the 4 GiB of the format.
pub fn bytes(lines: &[Line<'_>]) -> Option<Vec<u8>> {
    let mut points: Vec<u8> = Vec::new();
    let (mut nodes, mut meshes, mut materials, mut accessors) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (end, lines) in by_end(lines) {
        let mut primitives = Vec::new();
        for line in lines {
            primitives.push(json!({
                "attributes": { "POSITION": accessors.len() },
                "material": materials.len(),
                "mode": 3,
                "extras": { "end": end.text(), "part": end.part(), "power": line.strip.power, "met": line.strip.met },
            }));
            accessors.push(accessor(line, points.len()));
            points.extend(line.points.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
        }
        let name = format!("rays {}", end.text());
        nodes.push(json!({ "name": name, "mesh": meshes.len(), "extras": { "fate": end.kind(), "part": end.part() } }));
        meshes.push(json!({ "name": name, "primitives": primitives }));
        materials.push(material(end));
    }
    let generator = concat!("eyebox ", env!("CARGO_PKG_VERSION"));
    let mut document = json!({ "asset": { "version": "2.0", "generator": generator } });
    if !nodes.is_empty() {
        document["extensionsUsed"] = json!(["KHR_materials_unlit"]);
        document["scene"] = json!(0);
        document["scenes"] = json!([{ "nodes": (0..nodes.len()).collect::<Vec<_>>() }]);
        document["nodes"] = Json::from(nodes);
        document["meshes"] = Json::from(meshes);
        document["materials"] = Json::from(materials);
        document["accessors"] = Json::from(accessors);
        document["bufferViews"] =
            json!([{ "buffer": 0, "byteLength": points.len(), "byteStride": 12, "target": 34962 }]);
        document["buffers"] = json!([{ "byteLength": points.len() }]);
    }
    // The points are three floats each: padded.
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    container(&text, &points)
}

fn accessor(line: &Line<'_>, offset: usize) -> Json {
    let bound = |pick: fn(f32, f32) -> f32, start: f32| -> [f64; 3] {
        let bound = line.points.iter().fold([start; 3], |b, p| std::array::from_fn(|i| pick(b[i], p[i])));
        bound.map(f64::from)
    };
    json!({
        "bufferView": 0, "byteOffset": offset, "componentType": 5126, "type": "VEC3", "count": line.points.len(),
        "min": bound(f32::min, f32::INFINITY), "max": bound(f32::max, f32::NEG_INFINITY),
    })
}

fn material(end: &End) -> Json {
    let [r, g, b] = end.colour();
    json!({
        "name": end.text(),
        "pbrMetallicRoughness": { "baseColorFactor": [r, g, b, 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0 },
        "extensions": { "KHR_materials_unlit": {} },
    })
}
