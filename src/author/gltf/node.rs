//! The hierarchy: one node per node, in their order, with exact transforms.

use super::animation::{self, Animation};
use super::document::Document;
use super::geometry;
use super::lamp;
use super::light::{self, PUNCTUAL};
use super::skin::Skins;
use super::user;
use super::value::{self, OPTICS};
use eyebox_base::error::Result;
use eyebox_scene::assembly::{Assembly, Node};
use eyebox_scene::motion::parts;
use eyebox_scene::value::Value;
use glam::{DAffine3, DMat3};
use serde_json::{Map, Value as Json, json};

/// The mark of the node that turns and scales an asset to glTF's metres and axes. Our reader takes it off again: transforms
/// keep their bits, paths and frames their names.
pub const WORLD: &str = "eyebox_world";

/// Metres per unit that hold: what the asset's attributes say, or else what its format declared.
pub fn unit(assembly: &Assembly) -> f64 {
    let said = assembly.optics.as_ref().and_then(|optics| optics.get("unit")).and_then(Value::number);
    said.filter(|unit| *unit > 0.0 && unit.is_finite()).unwrap_or(assembly.unit_m)
}

/// Writes all nodes, cameras and lights; returns the roots of the scene.
pub fn nodes(document: &mut Document, assembly: &Assembly) -> Result<Vec<usize>> {
    let mut children: Vec<Vec<usize>> = vec![Vec::new(); assembly.nodes.len()];
    let mut roots = Vec::new();
    for (index, node) in assembly.nodes.iter().enumerate() {
        match node.parent.and_then(|parent| children.get_mut(parent)).filter(|_| node.parent < Some(index)) {
            Some(siblings) => siblings.push(index),
            None => roots.push(index),
        }
    }
    if !depth_first(&roots, &children) {
        let at = eyebox_base::Where::file(&assembly.file);
        document.note(&at, "the parts come back in another order: glTF is read depth first".into());
    }
    let cameras = cameras(document, assembly)?;
    let lights = lights(document, assembly);
    let mut animation = Animation::of(document, assembly);
    let motion = assembly.motion.as_ref();
    for (index, node) in assembly.nodes.iter().enumerate() {
        let mut out = Map::new();
        out.insert("name".into(), Json::from(node.name.as_str()));
        if let Some(children) = children.get(index).filter(|children| !children.is_empty()) {
            out.insert("children".into(), json!(children));
        }
        let moved = motion.and_then(|motion| Some((motion, motion.of_node(index)?)));
        let parts =
            moved.and_then(|(motion, moved)| animation.node(document, motion, index, (node.local, &moved.locals)));
        if parts.is_none() && moved.is_some() {
            let text = format!("`{}` moves with a shear, which glTF cannot say: it stands still", node.path);
            document.note(&node.at, text);
        }
        match parts {
            Some(parts) => out.extend(parts),
            None => out.extend(matrix(&node.local)),
        }
        if let Some(mesh) = node.mesh {
            out.insert("mesh".into(), Json::from(mesh));
        }
        if let Some(camera) = cameras.get(index).copied().flatten() {
            out.insert("camera".into(), Json::from(camera));
        }
        let mut extensions = Map::new();
        if let Some(light) = lights.get(index).copied().flatten() {
            extensions.insert(PUNCTUAL.into(), json!({ "light": light }));
        }
        if let Some(attributes) = &node.attributes {
            document.uses(OPTICS);
            extensions.insert(OPTICS.into(), value::json(attributes)?);
        }
        if !extensions.is_empty() {
            out.insert("extensions".into(), Json::Object(extensions));
        }
        if let Some(extras) = user::extras(&node.user) {
            out.insert("extras".into(), extras);
        }
        document.nodes.push(Json::Object(out));
    }
    let mut skins = Skins::default();
    for (index, node) in assembly.nodes.iter().enumerate() {
        let Some(mesh) = node.mesh else { continue };
        if let Some(skin) = skins.of(document, &mut animation, assembly, index)
            && let Some(Json::Object(own)) = document.nodes.get_mut(index)
        {
            own.insert("skin".into(), Json::from(skin));
        }
        let Some(motion) = motion else { continue };
        let weights = match (motion.of_rig(mesh), motion.of_mesh(mesh)) {
            (Some(rig), _) => rig.poses.iter().map(|pose| pose.weights.clone()).collect(),
            (None, Some(moved)) => geometry::tents(motion, moved),
            (None, None) => continue,
        };
        let still = weights.first();
        if still.is_some_and(|still| weights.iter().any(|own| own != still)) {
            animation.weights(document, motion, index, &weights);
            unmatrix(document, node, index);
        }
    }
    for light in &assembly.lights {
        lamp::write(document, assembly, light)?;
    }
    document.animations.extend(animation.finish(motion));
    roots.extend(skins.roots);
    let unit = unit(assembly);
    if unit == 1.0 && assembly.axes == DMat3::IDENTITY || roots.is_empty() {
        return Ok(roots);
    }
    let world = DAffine3::from_mat3(assembly.axes * unit);
    let mut out = Map::new();
    out.insert("name".into(), Json::from(unique(assembly)));
    out.insert("children".into(), json!(roots));
    out.extend(matrix(&world));
    out.insert("extras".into(), json!({ WORLD: true }));
    document.nodes.push(Json::Object(out));
    Ok(vec![document.nodes.len() - 1])
}

/// Takes the `matrix` from a node that an animation changes in any way, which glTF forbids (2.0, section 3.5.2), for what it is
/// made of.
fn unmatrix(document: &mut Document, node: &Node, index: usize) {
    let Some(Json::Object(own)) = document.nodes.get_mut(index).filter(|own| own.get("matrix").is_some()) else {
        return;
    };
    match parts(&[node.local]).as_deref() {
        Some([parts]) => {
            own.remove("matrix");
            own.extend(animation::entries(parts));
        }
        Some(_) | None => {
            let text = format!(
                "`{}` stands sheared and its mesh moves: it has a matrix, to which validators object",
                node.path
            );
            document.note(&node.at, text);
        }
    }
}

/// Whether the nodes stand in the order in which a reader of the tree meets them.
fn depth_first(roots: &[usize], children: &[Vec<usize>]) -> bool {
    let mut stack: Vec<usize> = roots.iter().rev().copied().collect();
    let mut expected = 0;
    while let Some(index) = stack.pop() {
        if index != expected {
            return false;
        }
        expected += 1;
        stack.extend(children.get(index).into_iter().flatten().rev());
    }
    true
}

/// The entry `matrix`, column by column; none for the identity.
pub fn matrix(local: &DAffine3) -> Option<(String, Json)> {
    let bits = |affine: &DAffine3| affine.to_cols_array().map(f64::to_bits);
    if bits(local) == bits(&DAffine3::IDENTITY) {
        return None;
    }
    let m = local.to_cols_array();
    let columns = m.chunks(3).zip([0, 0, 0, 1]);
    let numbers = columns.flat_map(|(column, last)| {
        column.iter().map(|number| value::number(*number).unwrap_or_default()).chain([Json::from(last)])
    });
    Some(("matrix".into(), Json::Array(numbers.collect())))
}

/// A name for the node above all others: that of the asset, unless another node has it.
fn unique(assembly: &Assembly) -> String {
    let stem = assembly.file.file_stem().map_or_else(|| "asset".into(), |stem| stem.to_string_lossy().into_owned());
    let taken = |name: &str| assembly.nodes.iter().any(|node| node.name == name);
    let mut name = stem.clone();
    let mut number = 1;
    while taken(&name) {
        number += 1;
        name = format!("{stem}_{number}");
    }
    name
}

/// The camera of each node. A camera that stands where no node does is left out, with a note.
fn cameras(document: &mut Document, assembly: &Assembly) -> Result<Vec<Option<usize>>> {
    let mut held = vec![None; assembly.nodes.len()];
    for camera in &assembly.cameras {
        let stands = |index: &usize| {
            held.get(*index) == Some(&None) && assembly.nodes.get(*index).is_some_and(|n| n.to_world == camera.to_world)
        };
        let all = 0..assembly.nodes.len();
        let own = camera.node.filter(|node| held.get(*node) == Some(&None));
        let place = own.or_else(|| all.clone().find(stands));
        match place.and_then(|place| held.get_mut(place)) {
            Some(place) => {
                *place = Some(document.cameras.len());
                document.cameras.push(light::camera(camera, unit(assembly))?);
            }
            None => {
                let at = eyebox_base::Where::file(&assembly.file);
                document.note(
                    &at,
                    format!("camera `{}` is on no node, or shares its node with another: not written", camera.name),
                );
            }
        }
    }
    Ok(held)
}

/// The light of each node.
fn lights(document: &mut Document, assembly: &Assembly) -> Vec<Option<usize>> {
    let mut held = vec![None; assembly.nodes.len()];
    for light in &assembly.lights {
        let Some(json) = light::light(document, light) else { continue };
        match held.get_mut(light.node) {
            Some(place @ None) => {
                document.uses(PUNCTUAL);
                *place = Some(document.lights.len());
                document.lights.push(json);
            }
            Some(Some(_)) | None => {
                document.note(&light.at, format!("light `{}` shares its node with another: not written", light.name));
            }
        }
    }
    held
}
