//! Nodes of the scene with their world transforms, their meshes, instances, cameras and lights.

use super::accessor::{Component, Document};
use super::at::At;
use super::hierarchy::{self, Tree};
use super::notes::Ledger;
use super::pose::Pose;
use super::shapes::Shapes;
use super::{animation, features, light, transform, user, world};
use crate::assembly::{Assembly, Camera, Frustum, Node};
use crate::{ReadOptions, Rigs};
use eyebox_base::Code;
use eyebox_base::error::Result;
use eyebox_scene::assembly::Film;
use eyebox_scene::user_property::UserProperty;
use glam::{DAffine3, DQuat};
use std::mem::size_of;

/// What nodes are read from.
struct Source<'a> {
    document: &'a Document<'a>,
    pose: Pose<'a>,
    shapes: Shapes<'a>,
}

/// Fills `assembly.nodes`, `meshes`, `cameras` and `lights`, depth first in the order of the file, at the moment that
/// `options` ask for.
pub(super) fn read(
    document: &Document<'_>,
    options: &ReadOptions,
    assembly: &mut Assembly,
    ledger: &mut Ledger,
) -> Result<()> {
    let tree = hierarchy::read(document, &mut ledger.notes)?;
    let moved = animation::moved(document, &tree.nodes, options, ledger)?;
    if options.rigs != Rigs::No {
        assembly.clock = animation::clock(document, &tree.nodes, options, ledger)?;
    }
    let pose = Pose::new(&tree, moved);
    let shapes = Shapes::read(document, &pose, options.rigs, ledger)?;
    let mut source = Source { document, pose, shapes };
    // Where each node of the file went.
    let mut placed = vec![None; tree.nodes.len()];
    let Tree { nodes, children, mut roots, .. } = tree;
    let mut all_hidden = false;
    if let [root] = roots.as_slice()
        && let Some((axes, unit_m)) = nodes.get(*root).map_or(Ok(None), |at| world::read(at))?
    {
        (assembly.axes, assembly.unit_m) = (axes, unit_m);
        source.pose.take_off(*root);
        all_hidden = nodes.get(*root).map_or(Ok(false), features::hides)?;
        roots = children.get(*root).cloned().unwrap_or_default();
    }
    // (node, index of its parent in `assembly.nodes`, whether something above hides it); the last is taken first.
    let mut stack: Vec<(usize, Option<usize>, bool)> =
        roots.iter().rev().map(|&root| (root, None, all_hidden)).collect();
    while let Some((index, parent, above_hidden)) = stack.pop() {
        let at = &nodes[index];
        let place = assembly.nodes.len();
        let hidden = above_hidden || features::hides(at)?;
        if hidden && !above_hidden {
            ledger.notes.info(at, "hidden by `KHR_node_visibility`, with meshes and lights below it: left out");
        }
        if let Some(slot) = placed.get_mut(index) {
            *slot = Some(place);
        }
        one(&mut source, index, (parent, hidden), assembly, ledger)?;
        stack.extend(children[index].iter().rev().map(|&child| (child, Some(place), hidden)));
    }
    if assembly.nodes.is_empty() {
        ledger.notes.warn_of(Code::NothingToTrace, &document.root, "the scene has no nodes");
    }
    assembly.meshes = source.shapes.finish(document, ledger)?;
    for joint in
        assembly.meshes.iter_mut().filter_map(|mesh| mesh.rig.as_mut()?.skin.as_mut()).flat_map(|skin| &mut skin.joints)
    {
        joint.node = joint.node.and_then(|node| placed.get(node).copied().flatten());
    }
    Ok(())
}

/// Appends the node, and after it the instances that it stands for. One that is hidden keeps its place and its camera.
fn one(
    source: &mut Source<'_>,
    index: usize,
    (parent, hidden): (Option<usize>, bool),
    assembly: &mut Assembly,
    ledger: &mut Ledger,
) -> Result<()> {
    let Source { document, pose, shapes } = source;
    let Some(at) = pose.node(index).cloned() else { return Ok(()) };
    let name = at.name("node", index)?;
    let above = parent.and_then(|parent| assembly.nodes.get(parent));
    let prefix = above.map_or("", |above| above.path.as_str());
    ledger.budget.charge(&at, 1, size_of::<Node>() + prefix.len() + 2 * name.len() + at.pointer.len())?;
    let below = |name: &str| if prefix.is_empty() { name.to_owned() } else { format!("{prefix}/{name}") };
    let local = pose.local(index, ledger)?;
    let mut to_world = pose.world(index, ledger)?;
    let mesh = match at.get("mesh")?.filter(|_| !hidden) {
        Some(reference) => {
            // A skinned mesh stands where its joints take it. Written in its node's axes it keeps the node in place; a node
            // that is flat has no axes to write in.
            let flat = at.get("skin")?.is_some() && transform::is_singular(to_world);
            let axes = (!flat).then_some(to_world);
            if flat {
                to_world = DAffine3::IDENTITY;
            }
            Some(shapes.of(document, (index, &reference), axes, pose, ledger)?)
        }
        None => None,
    };
    if let Some(reference) = at.get("camera")? {
        let camera = camera(document, &reference, &name, to_world, assembly.unit_m)?;
        assembly.cameras.push(Camera { node: Some(assembly.nodes.len()), ..camera });
    }
    let attributes = if hidden {
        None
    } else {
        assembly.lights.extend(light::read(document, &at, assembly.nodes.len(), &name, ledger)?);
        at.optics(&mut ledger.budget)?
    };
    let user = user::of_node(document, &at, ledger)?;
    let node = Node { path: below(&name), name, parent, local, to_world, mesh, attributes, user, at: at.place() };
    let Some(instancing) = at.extension("EXT_mesh_gpu_instancing")?.filter(|_| mesh.is_some()) else {
        assembly.nodes.push(node);
        return Ok(());
    };
    let transforms = instances(document, &instancing, ledger)?;
    let size = size_of::<Node>() + node.path.len() + 2 * node.name.len() + at.pointer.len() + 64;
    let carried = at.extension("EYEBOX_optics")?.map_or(0, |optics| optics.weight());
    let said = node.user.iter().map(UserProperty::cost).sum::<usize>();
    ledger.budget.charge(&instancing, transforms.len(), size.saturating_add(carried).saturating_add(said))?;
    let frame = pose.above(index, ledger)?;
    let mut copies = Vec::with_capacity(transforms.len());
    for (i, transform) in transforms.into_iter().enumerate() {
        let name = format!("{}[{i}]", node.name);
        let local = node.local * transform;
        // The product of what the hierarchy says, so that an asset with a node for each instance has the same bits.
        let to_world = frame * local;
        if !to_world.is_finite() {
            return Err(at.fault("the node's world transform overflows").expected("finite numbers"));
        }
        copies.push(Node { path: below(&name), name, local, to_world, ..node.clone() });
    }
    // The node itself stays for its children; its mesh and attributes are the instances'.
    assembly.nodes.push(Node { mesh: None, attributes: None, ..node });
    assembly.nodes.extend(copies);
    Ok(())
}

/// The transforms of `EXT_mesh_gpu_instancing`, in the node's own frame.
fn instances(document: &Document<'_>, at: &At<'_>, ledger: &mut Ledger) -> Result<Vec<DAffine3>> {
    let attributes = at.want("attributes")?;
    let mut open = |key: &str, lanes: usize, types: &[Component]| {
        let Some(reference) = attributes.get(key)? else { return Ok(None) };
        let accessor = document.accessor(&reference)?;
        ledger.budget.charge(&reference, accessor.opening_cost(), 8)?;
        let integer = accessor.component != Component::F32;
        if accessor.lanes != lanes || !types.contains(&accessor.component) || integer && !accessor.normalized {
            let expected = if lanes == 4 { "VEC4 of floats or normalised signed integers" } else { "VEC3 of floats" };
            return Err(reference.fault(format!("an accessor of another type for {key}")).expected(expected));
        }
        Ok(Some(accessor))
    };
    let translation = open("TRANSLATION", 3, &[Component::F32])?;
    let rotation = open("ROTATION", 4, &[Component::F32, Component::I8, Component::I16])?;
    let scale = open("SCALE", 3, &[Component::F32])?;
    let mut given = [&translation, &rotation, &scale].into_iter().flatten();
    let Some(first) = given.next() else {
        return Err(attributes.fault("instances without transforms").expected("TRANSLATION, ROTATION or SCALE"));
    };
    let count = first.count;
    if let Some(other) = given.find(|other| other.count != count) {
        return Err(attributes.fault(format!("{count} and {} instances", other.count)).expected("equal counts"));
    }
    ledger.budget.charge(at, count, size_of::<DAffine3>())?;
    let mut out = Vec::with_capacity(count);
    for i in 0..count {
        let wide = |x: [f32; 3]| glam::DVec3::from(x.map(f64::from));
        let shift = translation.as_ref().map_or(glam::DVec3::ZERO, |accessor| wide(accessor.floats(i)));
        let size = scale.as_ref().map_or(glam::DVec3::ONE, |accessor| wide(accessor.floats(i)));
        let turn = match &rotation {
            Some(accessor) => {
                // A normalised byte is good to half a step of 1/127 in each of four components.
                let tolerance = if accessor.component == Component::F32 { 1e-3 } else { 0.02 };
                let xyzw = accessor.floats::<4>(i).map(f64::from);
                transform::unit_rotation(&accessor.at, xyzw, tolerance, &mut ledger.notes)?
            }
            None => DQuat::IDENTITY,
        };
        out.push(DAffine3::from_scale_rotation_translation(size, turn, shift));
    }
    Ok(out)
}

fn camera(document: &Document<'_>, reference: &At<'_>, node: &str, to_world: DAffine3, unit_m: f64) -> Result<Camera> {
    let at = document.find("cameras", "camera", reference)?;
    let name = match at.get("name")? {
        Some(name) => name.text()?.to_owned(),
        None => node.to_owned(),
    };
    // Other programs' business, which is in metres, whatever scales the node: what is no number is nothing.
    let length = |lens: &str, key: &str| {
        let found = at.json.get(lens).and_then(|lens| lens.get(key)?.as_f64());
        found.filter(|x| x.is_finite() && *x > 0.0).map(|x| x / unit_m)
    };
    fn numbers_of<const N: usize>(extras: Option<&serde_json::Value>, key: &str) -> Option<[f64; N]> {
        let list: Option<Vec<f64>> = extras?.get(key)?.as_array()?.iter().map(serde_json::Value::as_f64).collect();
        <[f64; N]>::try_from(list?).ok().filter(|all| all.iter().all(|x| x.is_finite()))
    }
    let extras = at.json.get("extras");
    let film = |[focal, wide, high, right, up]: [f64; 5]| {
        let sound = [focal, wide, high].iter().all(|x| *x > 0.0);
        sound.then_some(Film { focal, size: [wide, high], offset: [right, up] })
    };
    let frustum = |lens: &str| Frustum {
        near: length(lens, "znear"),
        far: length(lens, "zfar"),
        half: length(lens, "xmag").and_then(|x| Some([x, length(lens, "ymag")?])),
        film: numbers_of::<5>(extras, "eyebox_film_m").map(|all| all.map(|x| x / unit_m)).and_then(film),
        shutter: numbers_of(extras, "eyebox_shutter_frames"),
    };
    let kind = at.want("type")?;
    match kind.text()? {
        "perspective" => {
            let lens = at.want("perspective")?;
            let angle = lens.want("yfov")?;
            let yfov = angle.number()?;
            if !(yfov > 0.0 && yfov < std::f64::consts::PI) {
                return Err(angle.fault(format!("field of view {yfov} rad")).expected("between 0 and π"));
            }
            let aspect = match lens.get("aspectRatio")? {
                Some(field) if field.number()? > 0.0 => Some(field.number()?),
                Some(field) => return Err(field.fault("aspect ratio out of range").expected("more than 0")),
                None => None,
            };
            Ok(Camera {
                name,
                node: None,
                to_world,
                yfov: Some(yfov),
                aspect,
                pupil: length("extras", "eyebox_pupil_m"),
                focus: length("extras", "eyebox_focus_m"),
                frustum: frustum("perspective"),
            })
        }
        "orthographic" => Ok(Camera {
            name,
            node: None,
            to_world,
            yfov: None,
            aspect: None,
            pupil: None,
            focus: None,
            frustum: frustum("orthographic"),
        }),
        other => Err(kind
            .fault("unknown camera type")
            .expected("perspective or orthographic")
            .nearest(other, ["perspective", "orthographic"])),
    }
}
