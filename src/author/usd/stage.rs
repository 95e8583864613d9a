//! The hierarchy: nodes as prims, with materials and prototypes beside them.
//!
//! | `customData["eyebox"]` | on | means |
//! |---|---|---|
//! | `name` | any prim | the name as it was, where the prim could not have it |
//! | `wrapper` | the root prim | not a node: it only holds several roots together |
//! | `part` | a mesh, an instance, a light, a camera | belongs to the node above it, is not a node itself |

use super::layer::{Datum, Layer, Prim, Property, Specifier};
use super::name::Siblings;
use super::picture::Pictures;
use super::skel::{self, Skeletons};
use super::{light, material, mesh, optics, samples, user};
use eyebox_base::error::Result;
use eyebox_base::{Error, Where};
use eyebox_scene::assembly::{Assembly, Camera, LightSource, Node};
use glam::{DAffine3, DMat3};
use std::collections::HashMap;
use std::path::Path;

/// Deeper than any assembly; readers walk prims by recursion.
const MOST_DEEP: usize = 400;

/// What the parts of the writer share.
pub(super) struct Writing<'a> {
    pub assembly: &'a Assembly,
    /// The folder of the file: what asset paths are relative to.
    pub folder: &'a Path,
    /// The path of each material's prim.
    pub materials: Vec<String>,
    /// The prototype of each mesh that several nodes use.
    pub prototypes: Vec<Option<String>>,
    /// The lights of a node, and its cameras.
    pub lights: HashMap<usize, Vec<&'a LightSource>>,
    pub cameras: HashMap<usize, Vec<&'a Camera>>,
    pub skeletons: Skeletons,
}

impl Writing<'_> {
    pub fn fault(&self, at: &Where, what: impl Into<String>) -> Box<Error> {
        let at = if *at == Where::Nowhere { Where::file(&self.assembly.file) } else { at.clone() };
        Error::new(at, what)
    }
}

/// The name that a prim has, and the marks that keep the one it should have had.
pub(super) fn named(prim: &mut Prim, original: &str) {
    if prim.name != original {
        if !original.is_empty() {
            prim.display_name = Some(original.to_owned());
        }
        prim.marks.push(("name", Datum::Text(original.to_owned())));
    }
}

/// The layer of `assembly`. `stem` is the default prim's name if the assembly has not just one root.
pub(super) fn layer(assembly: &Assembly, stem: &str, folder: &Path, pictures: &mut Pictures) -> Result<Layer> {
    let mut children: Vec<Vec<usize>> = vec![Vec::new(); assembly.nodes.len()];
    let mut roots = Vec::new();
    for (index, node) in assembly.nodes.iter().enumerate() {
        match node.parent {
            None => roots.push(index),
            // Parents stand before their children, so that there are no cycles.
            Some(parent) if parent < index => children[parent].push(index),
            Some(parent) => {
                let what = format!("node {index} lies below node {parent}, which stands after it");
                return Err(Error::new(node.at.clone(), what));
            }
        }
    }
    let mut top = Siblings::default();
    let mut below_top = Siblings::default();
    // Joints are written in the axes of the world, below a root that is nowhere else.
    let has_rigs = assembly.meshes.iter().any(|source| source.rig.is_some());
    let wrapped = roots.len() != 1 || has_rigs;
    let root_name = match roots.as_slice() {
        [root] => top.name(&assembly.nodes[*root].name, "Node"),
        _ => top.name(stem, "Asset"),
    };
    let first =
        if wrapped { roots.clone() } else { roots.first().map(|root| children[*root].clone()).unwrap_or_default() };
    // The children of the root take their names first, then what we put beside them.
    let first_names: Vec<String> =
        first.iter().map(|child| below_top.name(&assembly.nodes[*child].name, "Node")).collect();
    let looks = below_top.name("Looks", "Looks");
    let mut of_materials = Siblings::default();
    let materials: Vec<String> = assembly
        .materials
        .iter()
        .map(|material| format!("/{root_name}/{looks}/{}", of_materials.name(&material.name, "Material")))
        .collect();
    let library = top.name("_Prototypes", "_Prototypes");
    let mut of_prototypes = Siblings::default();
    let mut uses = vec![0usize; assembly.meshes.len()];
    for node in &assembly.nodes {
        if let Some(mesh) = node.mesh {
            *uses.get_mut(mesh).ok_or_else(|| Error::new(node.at.clone(), format!("there is no mesh {mesh}")))? += 1;
        }
    }
    let prototypes = assembly.meshes.iter().zip(&uses).map(|(source, uses)| {
        (*uses > 1 && source.rig.is_none())
            .then(|| format!("/{library}/{}", of_prototypes.name(&source.mesh.name, "Mesh")))
    });
    let prototypes = prototypes.collect();
    let mut lights: HashMap<usize, Vec<&LightSource>> = HashMap::new();
    for light in &assembly.lights {
        lights.entry(light.node).or_default().push(light);
    }
    let mut cameras: HashMap<usize, Vec<&Camera>> = HashMap::new();
    for camera in &assembly.cameras {
        if let Some(node) = camera.node.filter(|node| *node < assembly.nodes.len()) {
            cameras.entry(node).or_default().push(camera);
        }
    }
    let skeletons = Skeletons::of(assembly, &format!("/{root_name}"), &mut below_top);
    let writing = Writing { assembly, folder, materials, prototypes, lights, cameras, skeletons };

    let mut layer = Layer {
        metadata: vec![
            ("defaultPrim", Datum::Token(root_name.clone())),
            ("metersPerUnit", Datum::Double(optics::unit(assembly))),
            ("upAxis", Datum::Token(up(assembly)?.to_owned())),
        ],
        ..Layer::default()
    };
    if let Some(motion) = &assembly.motion {
        let times = [("startTimeCode", motion.frames.first()), ("endTimeCode", motion.frames.last())];
        layer.metadata.extend(times.into_iter().filter_map(|(key, at)| Some((key, Datum::Double(*at?)))));
        let rates = ["timeCodesPerSecond", "framesPerSecond"].map(|key| (key, Datum::Double(motion.rate)));
        layer.metadata.extend(rates);
    }
    let mut root = Prim::def(0, if has_rigs { "SkelRoot" } else { "Xform" }, root_name);
    root.kind = Some("assembly");
    if wrapped {
        root.marks.push(("wrapper", Datum::Bool(true)));
    }
    let mut walk = Walk { writing: &writing, children: &children, layer: &mut layer };
    let own = if wrapped { None } else { roots.first().copied() };
    walk.root(root, own, first.into_iter().zip(first_names).collect(), &mut below_top)?;
    material::library(&writing, &looks, pictures, &mut layer.prims)?;
    prototypes_of(&writing, library, &mut layer.prims)?;
    Ok(layer)
}

fn prototypes_of(writing: &Writing<'_>, library: String, prims: &mut Vec<Prim>) -> Result<()> {
    if writing.prototypes.iter().all(Option::is_none) {
        return Ok(());
    }
    prims.push(Prim { specifier: Specifier::Class, ..Prim::def(0, "Scope", library) });
    for (index, path) in writing.prototypes.iter().enumerate() {
        let Some(name) = path.as_deref().and_then(|path| path.rsplit('/').next()) else { continue };
        prims.push(Prim::def(1, "Xform", name));
        mesh::write(writing, mesh::Own { mesh: index, node: None }, 2, &mut Siblings::default(), prims)?;
    }
    Ok(())
}

pub(super) fn up(assembly: &Assembly) -> Result<&'static str> {
    let turned = DMat3::from_cols_array(&[1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0]);
    if assembly.axes == DMat3::IDENTITY {
        Ok("Y")
    } else if assembly.axes == turned {
        Ok("Z")
    } else {
        Err(Error::new(Where::file(&assembly.file), "the asset's world is turned in a way that USD cannot say")
            .expected("+y or +z up"))
    }
}

struct Walk<'a> {
    writing: &'a Writing<'a>,
    children: &'a [Vec<usize>],
    layer: &'a mut Layer,
}

impl Walk<'_> {
    /// Writes the default prim and everything below it; `own` is the node that it is.
    fn root(
        &mut self,
        mut prim: Prim,
        own: Option<usize>,
        first: Vec<(usize, String)>,
        siblings: &mut Siblings,
    ) -> Result<()> {
        let assembly = self.writing.assembly;
        optics::root(self.writing, &mut prim)?;
        match own.and_then(|index| assembly.nodes.get(index).map(|node| (index, node))) {
            Some((index, node)) => self.node(index, node, prim, !first.is_empty(), siblings)?,
            None => self.layer.prims.push(prim),
        }
        light::cameras(self.writing, siblings, &mut self.layer.prims)?;
        skel::write(self.writing, &mut self.layer.prims);
        // To be written, the next one last.
        let mut open: Vec<(usize, String, usize)> =
            first.into_iter().rev().map(|(index, name)| (index, name, 1)).collect();
        while let Some((index, name, depth)) = open.pop() {
            let Some(node) = assembly.nodes.get(index) else { continue };
            if depth > MOST_DEEP {
                return Err(self
                    .writing
                    .fault(&node.at, "the hierarchy is too deep for USD readers")
                    .expected(format!("at most {MOST_DEEP} levels")));
            }
            let mut siblings = Siblings::default();
            let below: Vec<_> = self.children.get(index).into_iter().flatten().copied().collect();
            let names: Vec<_> = below
                .iter()
                .map(|child| siblings.name(assembly.nodes.get(*child).map_or("", |node| &node.name), "Node"))
                .collect();
            let prim = Prim::def(depth, "Xform", name);
            self.node(index, node, prim, !below.is_empty(), &mut siblings)?;
            let children = below.into_iter().zip(names).map(|(child, name)| (child, name, depth + 1));
            let start = open.len();
            open.extend(children);
            open[start..].reverse();
        }
        Ok(())
    }

    /// Writes the prim of a node with what it holds itself; its children follow.
    fn node(
        &mut self,
        index: usize,
        node: &Node,
        mut prim: Prim,
        has_children: bool,
        siblings: &mut Siblings,
    ) -> Result<()> {
        let writing = self.writing;
        let depth = prim.depth;
        named(&mut prim, &node.name);
        transform(writing, index, &mut prim)?;
        if let Some(attributes) = &node.attributes {
            optics::apply(writing, attributes, &mut prim)?;
        }
        user::say(writing, &node.user, &mut prim);
        let lights = writing.lights.get(&index).map_or(&[][..], Vec::as_slice);
        let prototype = node.mesh.and_then(|mesh| writing.prototypes.get(mesh)).and_then(Option::as_ref);
        let cameras = writing.cameras.get(&index).map_or(&[][..], Vec::as_slice);
        let leaf = !has_children && lights.is_empty() && cameras.is_empty() && depth > 0;
        match (node.mesh, prototype) {
            (Some(_), Some(prototype)) if leaf => {
                prim.kind = Some("component");
                prim.instanceable = Some(true);
                prim.reference = Some(prototype.clone());
                self.layer.prims.push(prim);
            }
            (Some(mesh), Some(prototype)) => {
                // What is below an instance comes from its prototype alone, so the instance gets a prim of its own.
                self.layer.prims.push(prim);
                let name = writing.assembly.meshes.get(mesh).map_or("", |source| &source.mesh.name);
                let mut instance = Prim::def(depth + 1, "Xform", siblings.name(name, "Mesh"));
                instance.marks.push(("part", Datum::Bool(true)));
                instance.instanceable = Some(true);
                instance.reference = Some(prototype.clone());
                self.layer.prims.push(instance);
            }
            (Some(mesh), None) => {
                self.layer.prims.push(prim);
                let own = mesh::Own { mesh, node: Some(index) };
                mesh::write(writing, own, depth + 1, siblings, &mut self.layer.prims)?;
            }
            (None, _) => self.layer.prims.push(prim),
        }
        for source in lights {
            light::write(writing, source, depth + 1, siblings, &mut self.layer.prims)?;
        }
        for camera in cameras {
            light::camera(writing, (camera, true), depth + 1, siblings, &mut self.layer.prims)?;
        }
        Ok(())
    }
}

/// The node's transform, unless it is none.
fn transform(writing: &Writing<'_>, index: usize, prim: &mut Prim) -> Result<()> {
    let Some(node) = writing.assembly.nodes.get(index) else { return Ok(()) };
    if !node.local.is_finite() {
        return Err(writing.fault(&node.at, format!("the transform of node `{}` is not finite", node.path)));
    }
    let motion = writing.assembly.motion.as_ref();
    if let Some((motion, moved)) = motion.and_then(|motion| Some((motion, motion.of_node(index)?))) {
        for property in samples::transform(motion, node.local, &moved.locals) {
            prim.push(property);
        }
    } else if node.local != DAffine3::IDENTITY {
        prim.push(Property::new("xformOp:transform", matrix(node.local)));
        prim.push(Property::new("xformOpOrder", Datum::Tokens(vec!["xformOp:transform".to_owned()])).uniform());
    }
    Ok(())
}

/// USD's rows: point · matrix.
pub(super) fn matrix(affine: DAffine3) -> Datum {
    Datum::Matrix(rows(affine))
}

pub(super) fn rows(affine: DAffine3) -> [[f64; 4]; 4] {
    let [x, y, z] = affine.matrix3.to_cols_array_2d();
    let t = affine.translation;
    let row = |[a, b, c]: [f64; 3], w: f64| [a, b, c, w];
    [row(x, 0.0), row(y, 0.0), row(z, 0.0), row(t.to_array(), 1.0)]
}
