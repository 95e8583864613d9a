//! Meshes: one primitive per CAD face, in order, each with vertices of its own, so that reading gives the same faces with
//! the same bits.

use super::document::Document;
use super::value::{self, OPTICS};
use crate::base::Error;
use crate::base::error::Result;
use crate::scene::assembly::{Assembly, MeshSource};
use serde_json::{Value as Json, json};

/// The glTF mesh of `source`. Faults: triangles or normals that don't fit the vertices.
pub fn mesh(document: &mut Document, assembly: &Assembly, source: &MeshSource) -> Result<Json> {
    let mut primitives = Vec::new();
    let mut unused = false;
    for face in 0..source.mesh.faces.len() {
        let material = source.materials.get(face).copied().flatten().and_then(|index| assembly.materials.get(index));
        let surface = material.and_then(|material| material.surface.as_ref());
        // glTF multiplies them into any base colour (2.0, section 3.9.2).
        let shown = surface.is_none_or(|surface| surface.vertex_colors);
        unused |= !shown && !source.mesh.colors.is_empty();
        let mut primitive = self::face(document, source, face, shown)?;
        if let Some(material) = source.materials.get(face).copied().flatten() {
            primitive["material"] = Json::from(material);
        }
        if let Some(Some(attributes)) = source.attributes.get(face) {
            document.uses(OPTICS);
            primitive["extensions"] = json!({ OPTICS: value::json(attributes)? });
        }
        primitives.push(primitive);
    }
    if unused {
        let what = "colours of vertices that its material does not show are not written: glTF would show them";
        document.note(&source.at, format!("mesh `{}`: {what}", source.mesh.name));
    }
    if primitives.is_empty() {
        document.note(&source.at, format!("mesh `{}` has no faces: it gets an empty one", source.mesh.name));
        primitives.push(nothing(document));
    }
    Ok(json!({ "name": source.mesh.name, "primitives": primitives }))
}

/// What a face without triangles is: a primitive must have a vertex, so it is a single point.
fn nothing(document: &mut Document) -> Json {
    let point = *document.point.get_or_insert_with(|| document.binary.positions(&[[0.0; 3]]));
    json!({ "attributes": { "POSITION": point }, "mode": 0 })
}

fn face(document: &mut Document, source: &MeshSource, face: usize, colors: bool) -> Result<Json> {
    let mesh = &source.mesh;
    let wrong = |what: &str| Error::new(source.at.clone(), format!("mesh `{}` face {face}: {what}", mesh.name));
    let range = mesh.faces.get(face).and_then(|range| Some((range.first, range.first.checked_add(range.count)?)));
    let triangles = range.and_then(|(first, end)| mesh.triangles.get(first as usize..end as usize));
    let triangles = triangles.ok_or_else(|| wrong("its triangles do not exist"))?;
    if triangles.is_empty() {
        return Ok(nothing(document));
    }
    let mut used: Vec<u32> = triangles.as_flattened().to_vec();
    used.sort_unstable();
    used.dedup();
    let pick = |what: &str, count: usize| match used.last() {
        Some(last) if (*last as usize) < count => Ok(()),
        Some(_) | None => Err(wrong(what)),
    };
    pick("a vertex does not exist", mesh.positions.len())?;
    let positions: Vec<[f32; 3]> = used.iter().map(|vertex| mesh.positions[*vertex as usize]).collect();
    let mut attributes = json!({ "POSITION": document.binary.positions(&positions) });
    if !mesh.normals.is_empty() {
        pick("a normal does not exist", mesh.normals.len())?;
        let normals: Vec<[f32; 3]> = used.iter().map(|vertex| mesh.normals[*vertex as usize]).collect();
        attributes["NORMAL"] = Json::from(document.binary.normals(&normals));
    }
    let sets = match (mesh.uvs.is_empty(), mesh.second_uvs.is_empty()) {
        (true, true) => vec![],
        (false, true) => vec![&mesh.uvs],
        // Sets are numbered without gaps (2.0, section 3.7.2.1): where the first is not there, the second stands for it.
        (true, false) => vec![&mesh.second_uvs; 2],
        (false, false) => vec![&mesh.uvs, &mesh.second_uvs],
    };
    for (number, set) in sets.into_iter().enumerate() {
        pick("a texture coordinate does not exist", set.len())?;
        let uvs: Vec<[f32; 2]> = used.iter().map(|vertex| document.down(set[*vertex as usize])).collect();
        attributes[format!("TEXCOORD_{number}")] = Json::from(document.binary.uvs(&uvs));
    }
    if colors && !mesh.colors.is_empty() {
        pick("a colour does not exist", mesh.colors.len())?;
        let colors: Vec<[f32; 4]> = used.iter().map(|vertex| mesh.colors[*vertex as usize]).collect();
        attributes["COLOR_0"] = Json::from(document.binary.colors(&colors));
    }
    let number = |vertex: u32| used.partition_point(|other| *other < vertex) as u32;
    let corners: Vec<[u32; 3]> = triangles.iter().map(|triangle| triangle.map(number)).collect();
    Ok(json!({ "attributes": attributes, "indices": document.binary.indices(&corners) }))
}
