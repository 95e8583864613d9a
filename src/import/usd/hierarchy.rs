//! The walk over the stage: which prims are there for us, and the nodes they become. What is below an instance is
//! walked once per prototype; further instances copy its nodes and share its meshes.

use super::attribute::PrimView;
use super::handed::{Above, Handed, MOST_DEEP, Template};
use super::paint::Painted;
use super::reader::Reader;
use super::round_trip::RoundTrip;
use super::xform::{self, Local};
use super::{binding, camera, implicit, instancer, light, material, mesh, optics, skel, skel_binding, user};
use crate::assembly::{Camera, Node};
use eyebox_base::Where;
use eyebox_base::error::Result;
use eyebox_scene::user_property::UserProperty;
use openusd::sdf::{self, Specifier};
use openusd::usd::Prim;

/// Fills `assembly.nodes`, `meshes`, `cameras` and `lights`, depth first in the order of the stage.
pub(super) fn read(reader: &mut Reader) -> Result<()> {
    let handed = Handed {
        shown: true,
        material: binding::Inherited::default(),
        painted: Painted::default(),
        skel: skel_binding::Inherited::default(),
    };
    let above = Above { node: None, handed, instance: None, depth: 0, may_be_over: false };
    let root = sdf::Path::abs_root();
    let names = reader.stage.root_prims().map_err(|error| reader.moment.failed(&root, error))?;
    for name in names {
        let Ok(path) = root.append_path(name.as_str()) else { continue };
        let child = reader.prim(&path)?;
        prim(reader, child, &above)?;
    }
    Ok(())
}

/// Types that place nothing and hold nothing that is placed.
const BESIDE: [&str; 12] = [
    "Material",
    "NodeGraph",
    "Shader",
    "GeomSubset",
    "RenderSettings",
    "RenderProduct",
    "RenderVar",
    "RenderPass",
    "RenderDenoisePass",
    "SkelAnimation",
    "BlendShape",
    "OpenExecNode",
];

/// Types with a shape that is not read.
const UNUSED: [&str; 10] = [
    "BasisCurves",
    "NurbsCurves",
    "HermiteCurves",
    "NurbsPatch",
    "Points",
    "TetMesh",
    "Volume",
    "OpenVDBAsset",
    "Field3DAsset",
    "ParticleField",
];

/// Walks one prim and what is below it.
pub(super) fn prim(reader: &mut Reader, prim: Prim, above: &Above) -> Result<()> {
    let Reader { ledger, moment, opened, bound, .. } = &mut *reader;
    ledger.prim(|| moment.at(prim.path()), opened.bytes())?;
    bound.check(moment, prim.path())?;
    if above.depth > MOST_DEEP {
        return Err(moment.fault(prim.path(), "prims nested too deep").expected(format!("at most {MOST_DEEP} levels")));
    }
    let failed = |error| moment.failed(prim.path(), error);
    let specifier = prim.specifier().map_err(failed)?;
    let there = match specifier {
        Some(Specifier::Def) => true,
        Some(Specifier::Over | Specifier::Class) | None => above.may_be_over,
    };
    if !there || prim.get_metadata::<bool>("active").map_err(failed)? == Some(false) {
        return Ok(());
    }
    let view = PrimView::new(prim, moment)?;
    let type_name = view.type_name()?;
    if BESIDE.contains(&type_name.as_str()) {
        match type_name.as_str() {
            "Material" => material::met(reader, &view)?,
            "RenderSettings" => reader.render.settings.push(view.path().clone()),
            _ => {}
        }
        return Ok(());
    }
    // Prims without a type are not UsdGeomImageable: visibility and purpose say nothing there.
    let is_imageable = !type_name.is_empty();
    if is_imageable && view.token_of_schema("visibility", ledger)?.as_deref() == Some("invisible") {
        return material::meet_below(reader, &view, above.depth);
    }
    let purpose = if is_imageable { view.token_of_schema("purpose", ledger)? } else { None };
    let shown = match purpose.as_deref() {
        None => above.handed.shown,
        Some("default" | "render") => true,
        Some("proxy" | "guide") => false,
        Some(other) => {
            ledger
                .warn(view.at_property("purpose"), format!("the purpose `{other}` is none that USD knows: not shown"));
            false
        }
    };
    let mut local = xform::local(&view, ledger)?;
    let painted = above.handed.painted.below(&view, &mut reader.ledger)?;
    let skel = above.handed.skel.below(&view, &type_name);
    if implicit::Kind::of(&type_name).is_some()
        && let Some(transform) = skel::rigid(reader, &view, &skel)?
    {
        local = Local { transform, resets: false };
    }
    let handed = Handed { shown, material: above.handed.material.below(reader, &view)?, painted, skel };
    let marks = RoundTrip::of(&view)?;
    let node = place(reader, &view, local, above.node, marks.text("name").unwrap_or(view.name()))?;
    reader.placed.folds.extend(marks.fold().map(|fold| (node, fold)));
    reader.assembly.nodes[node].attributes = optics::node(reader, &view)?;
    reader.assembly.nodes[node].user = user::of(reader, &view, &marks)?;
    let mut below = Above {
        node: Some(node),
        handed,
        instance: above.instance.clone(),
        depth: above.depth + 1,
        may_be_over: false,
    };
    if shown {
        content(reader, &view, &type_name, &below)?;
    }
    if type_name != "PointInstancer" {
        let is_instance = view.prim.is_instance().map_err(|error| reader.moment.failed(view.path(), error))?;
        if is_instance { instance(reader, &view, &mut below)? } else { children(reader, &view, &below)? }
    } else {
        material::meet_below(reader, &view, above.depth)?;
    }
    // A container without contents, or one that is not shown, says nothing.
    let is_container = matches!(type_name.as_str(), "" | "Scope") || !shown;
    let own = &reader.assembly.nodes[node];
    if is_container && reader.assembly.nodes.len() == node + 1 && own.mesh.is_none() && is_silent(own) {
        reader.assembly.nodes.pop();
        reader.placed.resets.remove(&node);
        reader.placed.folds.remove(&node);
    }
    Ok(())
}

/// Whether nobody has said anything of a node.
fn is_silent(node: &Node) -> bool {
    node.attributes.is_none() && node.user.is_empty()
}

fn children(reader: &mut Reader, view: &PrimView, below: &Above) -> Result<()> {
    for child in view.children()? {
        prim(reader, child, below)?;
    }
    Ok(())
}

/// What is below an instance: walked if it is the first of its prototype, else copied.
fn instance(reader: &mut Reader, view: &PrimView, below: &mut Above) -> Result<()> {
    let prototype = view.prim.prototype().map_err(|error| reader.moment.failed(view.path(), error))?;
    let (Some(prototype), Some(node)) = (prototype, below.node) else { return children(reader, view, below) };
    if below.instance.is_none() {
        reader.placed.outermost.push(view.path().as_str().to_owned());
    }
    below.handed.material.inside(view);
    below.handed.skel.inside(view);
    let key = (prototype.as_str().to_owned(), below.handed.clone());
    if let Some(template) = reader.placed.instances.get(&key).cloned() {
        return copy(reader, view, &template, node);
    }
    below.instance = Some((view.path().clone(), prototype));
    let start = marks(reader);
    children(reader, view, below)?;
    let template = template(reader, node, start);
    reader.placed.instances.insert(key, template);
    Ok(())
}

/// How many nodes, cameras and lights there are.
pub(super) fn marks(reader: &Reader) -> [usize; 3] {
    [reader.assembly.nodes.len(), reader.assembly.cameras.len(), reader.assembly.lights.len()]
}

/// All that was added below `top` since `start`.
pub(super) fn template(reader: &Reader, top: usize, start: [usize; 3]) -> Template {
    let [nodes, cameras, lights] = marks(reader);
    Template { top, nodes: start[0]..nodes, cameras: start[1]..cameras, lights: start[2]..lights }
}

/// The node's name below a parent.
fn below(reader: &Reader, parent: Option<usize>, name: &str) -> String {
    match parent.and_then(|parent| reader.assembly.nodes.get(parent)) {
        Some(parent) if !parent.path.is_empty() => format!("{}/{name}", parent.path),
        Some(_) | None => name.to_owned(),
    }
}

/// Appends a node for `view`; its index.
pub(super) fn place(
    reader: &mut Reader,
    view: &PrimView,
    local: Local,
    parent: Option<usize>,
    name: &str,
) -> Result<usize> {
    let path = below(reader, parent, name);
    reader.charge(view.path(), 1, size_of::<Node>() + path.len() + name.len() + view.path().as_str().len())?;
    let frame = parent.and_then(|parent| reader.assembly.nodes.get(parent)).map(|parent| parent.to_world);
    let overflow = || view.fault("the prim's world transform overflows").expected("finite numbers");
    let resets = local.resets && frame.is_some();
    let (local, to_world) = match frame {
        Some(frame) if local.resets => (frame.inverse() * local.transform, local.transform),
        Some(frame) => (local.transform, frame * local.transform),
        // A product here, too: it has no −0, as in glTF.
        None => (local.transform, glam::DAffine3::IDENTITY * local.transform),
    };
    if !to_world.is_finite() || !local.is_finite() {
        return Err(overflow());
    }
    let node = reader.assembly.nodes.len();
    if resets {
        reader.placed.resets.insert(node);
    }
    let name = name.to_owned();
    reader.assembly.nodes.push(Node {
        name,
        path,
        parent,
        local,
        to_world,
        mesh: None,
        attributes: None,
        user: Vec::new(),
        at: view.at(),
    });
    Ok(node)
}

/// Appends copies of a template's nodes below `top`, which stands for `view`.
pub(super) fn copy(reader: &mut Reader, view: &PrimView, template: &Template, top: usize) -> Result<()> {
    let Some(old) = reader.assembly.nodes.get(template.top).map(|node| (node.path.clone(), node.at.clone())) else {
        return Ok(());
    };
    let base = reader.assembly.nodes.len();
    let bytes: usize = template.nodes.clone().filter_map(|i| reader.assembly.nodes.get(i)).map(cost).sum();
    reader.charge(view.path(), 1, bytes)?;
    for index in template.nodes.clone() {
        let Some(mut node) = reader.assembly.nodes.get(index).cloned() else { continue };
        let parent =
            node.parent.map(|parent| if parent == template.top { top } else { parent - template.nodes.start + base });
        let Some(above) = parent.and_then(|parent| reader.assembly.nodes.get(parent)) else { continue };
        let own = below(reader, parent, &node.name);
        let frame = above.to_world;
        if reader.placed.resets.contains(&index) {
            node.local = frame.inverse() * node.to_world;
            reader.placed.resets.insert(reader.assembly.nodes.len());
        } else {
            node.to_world = frame * node.local;
        }
        if !node.to_world.is_finite() {
            return Err(view.fault("the prim's world transform overflows").expected("finite numbers"));
        }
        if let Some(fold) = reader.placed.folds.get(&index).copied() {
            reader.placed.folds.insert(reader.assembly.nodes.len(), fold);
        }
        node.at = moved(&node.at, &old.1, &reader.moment.at(view.path()));
        (node.parent, node.path) = (parent, own);
        reader.assembly.nodes.push(node);
    }
    for index in template.lights.clone() {
        let Some(mut light) = reader.assembly.lights.get(index).cloned() else { continue };
        light.node = light.node - template.nodes.start + base;
        light.at = moved(&light.at, &old.1, &reader.moment.at(view.path()));
        reader.assembly.lights.push(light);
    }
    if !template.cameras.is_empty() {
        reader.ledger.info(view.at(), "cameras below further instances are not repeated");
    }
    Ok(())
}

fn cost(node: &Node) -> usize {
    let attributes = if node.attributes.is_some() { 1024 } else { 0 };
    let user: usize = node.user.iter().map(UserProperty::cost).sum();
    size_of::<Node>() + 2 * node.path.len() + 2 * node.name.len() + 64 + attributes + user
}

/// A place below `from`, as seen below `to`.
fn moved(at: &Where, from: &Where, to: &Where) -> Where {
    match (at, from, to) {
        (Where::Prim { file, prim }, Where::Prim { prim: from, .. }, Where::Prim { prim: to, .. }) => {
            let rest = prim.strip_prefix(from.as_str());
            Where::Prim { file: file.clone(), prim: rest.map_or_else(|| prim.clone(), |rest| format!("{to}{rest}")) }
        }
        _ => at.clone(),
    }
}

/// What a prim that is shown holds itself.
fn content(reader: &mut Reader, view: &PrimView, type_name: &str, below: &Above) -> Result<()> {
    let Some(node) = below.node else { return Ok(()) };
    let found = match type_name {
        "Mesh" => {
            light::of_mesh(reader, view, node)?;
            mesh::of(reader, view, below)?
        }
        "Camera" => {
            let to_world = reader.assembly.nodes[node].to_world;
            let camera = camera::read(view, to_world, &mut reader.ledger)?;
            reader.render.cameras.push((view.path().clone(), reader.assembly.cameras.len()));
            reader.assembly.cameras.push(Camera { node: Some(node), ..camera });
            None
        }
        "PointInstancer" => {
            instancer::read(reader, view, below)?;
            None
        }
        "Xform" | "Scope" | "" => None,
        other => {
            if let Some(shape) = implicit::Kind::of(other) {
                implicit::of(reader, view, shape, below)?
            } else if other.ends_with("Light") || other.ends_with("Light_1") {
                light::read(reader, view, node, other)?;
                None
            } else {
                if UNUSED.contains(&other) {
                    reader.ledger.warn(view.at(), format!("geometry of type {other} is not used"));
                    let unread = &mut reader.assembly.unread;
                    if !unread.iter().any(|known| known == other) {
                        unread.push(other.to_owned());
                    }
                }
                None
            }
        }
    };
    reader.assembly.nodes[node].mesh = found;
    Ok(())
}
