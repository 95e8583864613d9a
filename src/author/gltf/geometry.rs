//! Meshes: one primitive per CAD face, in order, each with vertices of its own, so that reading gives the same faces with
//! the same bits.

use super::super::tracks;
use super::document::Document;
use super::value::{self, OPTICS};
use eyebox_base::Error;
use eyebox_base::error::Result;
use eyebox_scene::assembly::{Assembly, MeshSource};
use eyebox_scene::motion::{MeshMotion, Motion, Skin, Vertices};
use serde_json::{Value as Json, json};

/// The shapes of a mesh beside the one that is written.
struct Shapes {
    names: Vec<String>,
    weights: Vec<f64>,
    /// Differences of all vertices of the mesh.
    by: Vec<Vertices>,
}

/// The targets of the mesh's rig; of a mesh that moves by its vertices, the difference at each frame that is written.
fn shapes(assembly: &Assembly, index: usize, source: &MeshSource) -> Shapes {
    if let Some(rig) = &source.rig {
        let names = rig.targets.iter().map(|target| target.name.clone()).collect();
        let by = rig.targets.iter().map(|target| target.by.clone()).collect();
        return Shapes { names, weights: rig.pose.weights.clone(), by };
    }
    let motion = assembly.motion.as_ref();
    let Some((motion, moved)) = motion.and_then(|motion| Some((motion, motion.of_mesh(index)?))) else {
        return Shapes { names: Vec::new(), weights: Vec::new(), by: Vec::new() };
    };
    let kept = tracks::of_shapes(motion, moved);
    let less = |all: &[[f32; 3]], still: &[[f32; 3]]| -> Vec<[f32; 3]> {
        all.iter().zip(still).map(|(a, b)| std::array::from_fn(|lane| a[lane] - b[lane])).collect()
    };
    let by = kept.iter().filter_map(|at| moved.shapes.get(*at)).map(|shape| Vertices {
        positions: less(&shape.positions, &source.mesh.positions),
        normals: less(&shape.normals, &source.mesh.normals),
    });
    let by: Vec<Vertices> = by.collect();
    let names = kept.iter().filter_map(|at| Some(format!("frame {}", motion.frames.get(*at)?))).collect();
    Shapes { names, weights: vec![0.0; by.len()], by }
}

/// The weights of the shapes of a mesh that moves by its vertices, at each frame: from one shape to the next.
pub fn tents(motion: &Motion, moved: &MeshMotion) -> Vec<Vec<f64>> {
    let kept = tracks::of_shapes(motion, moved);
    let at = |frame: usize| {
        let upper = kept.partition_point(|own| *own < frame).min(kept.len().saturating_sub(1));
        let lower = if kept.get(upper) == Some(&frame) { upper } else { upper.saturating_sub(1) };
        let mut weights = vec![0.0; kept.len()];
        if let (Some(from), Some(to)) = (kept.get(lower), kept.get(upper)) {
            let share = motion.share(*from, frame, *to);
            weights[lower] += 1.0 - share;
            weights[upper] += share;
        }
        weights
    };
    (0..motion.frames.len()).map(at).collect()
}

/// The glTF mesh number `index`. Faults: triangles or normals that don't fit the vertices.
pub fn mesh(document: &mut Document, assembly: &Assembly, index: usize) -> Result<Json> {
    let Some(source) = assembly.meshes.get(index) else { return Ok(json!({})) };
    let shapes = shapes(assembly, index, source);
    if source.rig.is_none() && !shapes.by.is_empty() {
        let what = format!("moves by its vertices: {} morph targets follow each other", shapes.by.len());
        document.note(&source.at, format!("mesh `{}` {what}", source.mesh.name));
    }
    let mut primitives = Vec::new();
    let mut unused = false;
    for face in 0..source.mesh.faces.len() {
        let material = source.materials.get(face).copied().flatten().and_then(|index| assembly.materials.get(index));
        let surface = material.and_then(|material| material.surface.as_ref());
        // glTF multiplies them into any base colour (2.0, section 3.9.2).
        let shown = surface.is_none_or(|surface| surface.vertex_colors);
        unused |= !shown && !source.mesh.colors.is_empty();
        let mut primitive = self::face(document, (source, &shapes), face, shown)?;
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
        primitives.push(nothing(document, 0));
    }
    let mut out = json!({ "name": source.mesh.name, "primitives": primitives });
    if !shapes.by.is_empty() {
        out["weights"] = json!(shapes.weights);
        out["extras"] = json!({ "targetNames": shapes.names });
    }
    Ok(out)
}

/// What a face without triangles is: a primitive must have a vertex, so it is a single point.
/// All primitives of a mesh have as many targets.
fn nothing(document: &mut Document, targets: usize) -> Json {
    let point = *document.point.get_or_insert_with(|| document.binary.positions(&[[0.0; 3]]));
    let mut out = json!({ "attributes": { "POSITION": point }, "mode": 0 });
    if targets > 0 {
        out["targets"] = json!(vec![json!({ "POSITION": point }); targets]);
    }
    out
}

fn face(document: &mut Document, (source, shapes): (&MeshSource, &Shapes), face: usize, colors: bool) -> Result<Json> {
    let mesh = &source.mesh;
    // Joints and targets bend what nothing has bent yet.
    let rest = source.rig.as_ref().map(|rig| &rig.rest);
    let (all_positions, all_normals) =
        rest.map_or((&mesh.positions, &mesh.normals), |rest| (&rest.positions, &rest.normals));
    let wrong = |what: &str| Error::new(source.at.clone(), format!("mesh `{}` face {face}: {what}", mesh.name));
    let range = mesh.faces.get(face).and_then(|range| Some((range.first, range.first.checked_add(range.count)?)));
    let triangles = range.and_then(|(first, end)| mesh.triangles.get(first as usize..end as usize));
    let triangles = triangles.ok_or_else(|| wrong("its triangles do not exist"))?;
    if triangles.is_empty() {
        return Ok(nothing(document, shapes.by.len()));
    }
    let mut used: Vec<u32> = triangles.as_flattened().to_vec();
    used.sort_unstable();
    used.dedup();
    let pick = |what: &str, count: usize| match used.last() {
        Some(last) if (*last as usize) < count => Ok(()),
        Some(_) | None => Err(wrong(what)),
    };
    pick("a vertex does not exist", all_positions.len())?;
    let positions: Vec<[f32; 3]> = used.iter().map(|vertex| all_positions[*vertex as usize]).collect();
    let mut attributes = json!({ "POSITION": document.binary.positions(&positions) });
    if !all_normals.is_empty() {
        pick("a normal does not exist", all_normals.len())?;
        let normals: Vec<[f32; 3]> = used.iter().map(|vertex| all_normals[*vertex as usize]).collect();
        attributes["NORMAL"] = Json::from(document.binary.normals(&normals));
    }
    // What a rig bends has tangents for its pose alone.
    let tangents = used.iter().map(|vertex| mesh.tangents.get(*vertex as usize).copied());
    let tangents: Option<Vec<[f32; 4]>> = tangents.map(|own| own.filter(|own| own[..3] != [0.0; 3])).collect();
    if let Some(tangents) = tangents.filter(|_| source.rig.is_none() && !all_normals.is_empty()) {
        attributes["TANGENT"] = Json::from(document.binary.tangents(&tangents));
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
    if let Some(skin) = source.rig.as_ref().and_then(|rig| rig.skin.as_ref()) {
        pick("a vertex has no joints", skin.influences.len() / skin.each.max(1))?;
        influences(document, skin, &used, &mut attributes).map_err(|joint| {
            wrong(&format!("joint number {joint} bends it"))
                .expected("joints 0 to 65535, as glTF counts them in 16 bits")
        })?;
    }
    let mut targets = Vec::new();
    for shape in &shapes.by {
        pick("a vertex is not in a target", shape.positions.len())?;
        let of = |all: &[[f32; 3]]| -> Vec<[f32; 3]> {
            used.iter().map(|vertex| all.get(*vertex as usize).copied().unwrap_or_default()).collect()
        };
        let mut target = json!({ "POSITION": document.binary.positions(&of(&shape.positions)) });
        if !all_normals.is_empty() {
            target["NORMAL"] = Json::from(document.binary.normals(&of(&shape.normals)));
        }
        targets.push(target);
    }
    let mut out = json!({ "attributes": attributes, "indices": document.binary.indices(&corners) });
    if !targets.is_empty() {
        out["targets"] = Json::Array(targets);
    }
    Ok(out)
}

/// `JOINTS_n` and `WEIGHTS_n` of the used vertices, four of them a set.
///
/// # Errors
/// A joint whose number is too large for glTF (2.0, section 3.7.3.3: unsigned short at most).
fn influences(
    document: &mut Document,
    skin: &Skin,
    used: &[u32],
    attributes: &mut Json,
) -> std::result::Result<(), u32> {
    for set in 0..skin.each.div_ceil(4) {
        let (mut joints, mut weights) = (Vec::with_capacity(used.len()), Vec::with_capacity(used.len()));
        for vertex in used {
            let start = *vertex as usize * skin.each;
            let own = skin.influences.get(start..start + skin.each).unwrap_or_default();
            let four: [(u32, f32); 4] =
                std::array::from_fn(|lane| own.get(4 * set + lane).copied().unwrap_or_default());
            let mut numbers = [0u16; 4];
            for (number, (joint, _)) in numbers.iter_mut().zip(four).filter(|(_, (_, weight))| *weight > 0.0) {
                *number = u16::try_from(joint).map_err(|_| joint)?;
            }
            joints.push(numbers);
            weights.push(four.map(|(_, weight)| weight));
        }
        attributes[format!("JOINTS_{set}")] = Json::from(document.binary.joints(&joints));
        attributes[format!("WEIGHTS_{set}")] = Json::from(document.binary.weights(&weights));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What has no weight may name any joint.
    #[test]
    fn joints_that_gltf_cannot_count_are_a_fault() {
        let bent = |joint: u32, weight: f32| {
            let skin = Skin { influences: vec![(3, 1.0 - weight), (joint, weight)], each: 2, ..Skin::default() };
            influences(&mut Document::default(), &skin, &[0], &mut json!({}))
        };
        assert_eq!((bent(65_535, 0.5), bent(65_536, 0.5), bent(65_536, 0.0)), (Ok(()), Err(65_536), Ok(())));
    }
}
