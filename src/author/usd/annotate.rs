//! Rows as a thin layer over the asset: `over` prims and nothing else. What is inside an instance cannot be said there,
//! USD ignores it; so the rows of its only part go to the instance itself, and an instance of several parts that are
//! spoken of stops being one.

use super::layer::{Datum, Layer, Prim, Property, Specifier};
use super::{Kind, bytes, optics, stage};
use crate::Written;
use eyebox_base::atomic::write_atomic;
use eyebox_base::error::Result;
use eyebox_base::relative_path::folder_of;
use eyebox_base::{Error, Where};
use eyebox_scene::annotation::Annotation;
use eyebox_scene::assembly::{Assembly, StageFacts};
use eyebox_scene::attribute::usd::UsdProperty;
use eyebox_scene::value::Value;
use std::collections::{HashMap, HashSet};
use std::path::Path;

/// Writes the layer `out` (.usda or .usdc) over the asset `assembly.file` with the rows of `annotation`.
///
/// # Errors
/// `out` is the asset itself or a package; rows on faces of a mesh that all its instances share, which only the asset's
/// own layer can say; the file cannot be written.
pub fn annotate(assembly: &Assembly, annotation: &Annotation, out: &Path) -> Result<Written> {
    let kind = Kind::of(out)?;
    if kind == Kind::Package {
        return Err(Error::new(Where::file(out), "a package cannot be a layer over another file")
            .expected("a .usda or .usdc file"));
    }
    let layer = layer(assembly, annotation, out)?;
    write_atomic(out, &bytes(layer, kind, out, &HashMap::new())?)?;
    Ok(Written { files: vec![out.to_owned()], notes: Vec::new() })
}

fn layer(assembly: &Assembly, annotation: &Annotation, out: &Path) -> Result<Layer> {
    let same = |a: &Path, b: &Path| matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b);
    if same(&assembly.file, out) {
        return Err(Error::new(Where::file(out), "the layer would replace the asset that it lies over")
            .expected("another file name"));
    }
    let none = StageFacts::default();
    let facts = assembly.stage.as_ref().unwrap_or(&none);
    let mut layer = Layer { sublayers: vec![optics::asset_path(&folder_of(out), &assembly.file)?], ..Layer::default() };
    // Layer metadata are the root layer's alone: those of a sublayer do not count (see design/interchange.md).
    layer.metadata.extend(facts.default_prim.clone().map(|name| ("defaultPrim", Datum::Token(name))));
    layer.metadata.push(("metersPerUnit", Datum::Double(assembly.unit_m)));
    layer.metadata.push(("upAxis", Datum::Token(stage::up(assembly)?.to_owned())));
    layer.metadata.extend(facts.times.iter().map(|(key, time)| (*key, Datum::Double(*time))));

    let mut overs = Overs::default();
    let lists = annotation.root.as_ref().or(assembly.optics.as_ref());
    if let Some(root) = &annotation.root {
        let path = match &facts.default_prim {
            Some(name) => format!("/{}", name.trim_start_matches('/')),
            None => assembly.nodes.first().map(|node| prim(&node.at)).transpose()?.unwrap_or_default(),
        };
        let old = assembly.optics.as_ref().map(optics::of_root).transpose()?;
        overs.say(&path, &optics::of_root(root)?, &old.unwrap_or_default())?;
    }
    let places = Places::new(assembly, annotation, facts)?;
    for (index, value) in &annotation.nodes {
        let Some(node) = assembly.nodes.get(*index) else { continue };
        let path = prim(&node.at)?;
        let new = optics::of(value, lists)?;
        match places.of(&path) {
            Place::Here => overs.say(&path, &new, &old(&node.attributes, assembly)?)?,
            Place::Lifted(instance) => overs.say(instance, &new, &[])?,
            Place::Opened(instance) => {
                overs.open(instance);
                overs.say(&path, &new, &old(&node.attributes, assembly)?)?;
            }
        }
    }
    for (index, value) in &annotation.materials {
        let Some(material) = assembly.materials.get(*index) else { continue };
        let path = prim(&material.at)?;
        if let Some(instance) = places.instance(&path) {
            overs.open(instance);
        }
        overs.say(&path, &optics::of(value, lists)?, &old(&material.attributes, assembly)?)?;
    }
    if let Some((_, _, value)) = annotation.faces.first() {
        return Err(Error::new(
            value.at.clone(),
            "a layer over the asset cannot say this of a face that instances share",
        )
        .expected("a layer in the folder of the asset, or `eyebox convert`"));
    }
    layer.prims = overs.prims();
    Ok(layer)
}

fn old(attributes: &Option<Value>, assembly: &Assembly) -> Result<Vec<UsdProperty>> {
    attributes.as_ref().map_or(Ok(Vec::new()), |value| optics::of(value, assembly.optics.as_ref()))
}

/// The path of the prim that something was read from.
fn prim(at: &Where) -> Result<String> {
    match at {
        Where::Prim { prim, .. } => Ok(prim.clone()),
        Where::Nowhere
        | Where::File(_)
        | Where::Line { .. }
        | Where::Pointer { .. }
        | Where::Part { .. }
        | Where::Option(_) => Err(Error::new(at.clone(), "this was read from no prim of a stage")),
    }
}

/// Where rows of a prim can be said.
enum Place<'a> {
    Here,
    /// On the instance that holds the prim.
    Lifted(&'a str),
    /// Here, if the instance that holds the prim stops being one.
    Opened(&'a str),
}

struct Places<'a> {
    instances: HashSet<&'a str>,
    /// Instances whose rows may stand on themselves: they hold one part, and nothing in them is said elsewhere.
    simple: HashSet<&'a str>,
}

impl<'a> Places<'a> {
    fn new(assembly: &Assembly, annotation: &Annotation, facts: &'a StageFacts) -> Result<Self> {
        let instances: HashSet<&str> = facts.instances.iter().map(String::as_str).collect();
        let mut places = Places { instances, simple: HashSet::new() };
        let mut parts: HashMap<&str, usize> = HashMap::new();
        let mut said: HashSet<&str> = HashSet::new();
        let rows: HashSet<usize> = annotation.nodes.iter().map(|(index, _)| *index).collect();
        for (index, node) in assembly.nodes.iter().enumerate() {
            let Where::Prim { prim, .. } = &node.at else { continue };
            let Some(instance) = places.holding(prim) else { continue };
            *parts.entry(instance).or_default() += usize::from(node.mesh.is_some());
            // Nearer to the part than the instance, or on the instance and to be replaced.
            let within = prim != instance;
            if within && node.attributes.is_some() || !within && (rows.contains(&index) || node.attributes.is_some()) {
                said.insert(instance);
            }
        }
        places.simple = parts
            .into_iter()
            .filter(|(path, parts)| *parts == 1 && !said.contains(path))
            .map(|(path, _)| path)
            .collect();
        Ok(places)
    }

    /// The outermost instance that is at or above `path`.
    fn holding(&self, path: &str) -> Option<&'a str> {
        let ends = path.match_indices('/').map(|(end, _)| end).skip(1).chain([path.len()]);
        ends.filter_map(|end| path.get(..end)).find_map(|above| self.instances.get(above).copied())
    }

    /// The outermost instance above `path`.
    fn instance(&self, path: &str) -> Option<&'a str> {
        self.holding(path).filter(|instance| *instance != path)
    }

    fn of(&self, path: &str) -> Place<'a> {
        match self.instance(path) {
            None => Place::Here,
            Some(instance) if self.simple.contains(instance) => Place::Lifted(instance),
            Some(instance) => Place::Opened(instance),
        }
    }
}

/// The `over` prims, as a tree in the order in which they were first spoken of.
#[derive(Default)]
struct Overs {
    all: Vec<Over>,
    roots: Vec<usize>,
    by_path: HashMap<String, usize>,
}

#[derive(Default)]
struct Over {
    prim: Prim,
    below: Vec<usize>,
}

impl Overs {
    /// The over at `path`, with those above it.
    fn at(&mut self, path: &str) -> Option<&mut Prim> {
        let mut above: Option<usize> = None;
        let starts: Vec<usize> = path.match_indices('/').map(|(start, _)| start).collect();
        for (depth, start) in starts.iter().enumerate() {
            let end = starts.get(depth + 1).copied().unwrap_or(path.len());
            let (whole, name) = (path.get(..end)?, path.get(start + 1..end)?);
            let index = match self.by_path.get(whole) {
                Some(index) => *index,
                None => {
                    let index = self.all.len();
                    let prim = Prim { specifier: Specifier::Over, ..Prim::def(depth, "", name) };
                    self.all.push(Over { prim, below: Vec::new() });
                    self.by_path.insert(whole.to_owned(), index);
                    match above.and_then(|above| self.all.get_mut(above)) {
                        Some(above) => above.below.push(index),
                        None => self.roots.push(index),
                    }
                    index
                }
            };
            above = Some(index);
        }
        above.and_then(|index| self.all.get_mut(index)).map(|over| &mut over.prim)
    }

    /// Says `new` at `path`, and blocks what `old` says and `new` does not.
    fn say(&mut self, path: &str, new: &[UsdProperty], old: &[UsdProperty]) -> Result<()> {
        let Some(prim) = self.at(path) else { return Ok(()) };
        optics::say(new, prim)?;
        for property in old {
            if !new.iter().any(|own| own.name == property.name) {
                prim.push(Property::new(property.name.clone(), Datum::Blocked(property.value.ty().name())));
            }
        }
        Ok(())
    }

    fn open(&mut self, instance: &str) {
        if let Some(prim) = self.at(instance) {
            prim.instanceable = Some(false);
        }
    }

    fn prims(mut self) -> Vec<Prim> {
        let mut out = Vec::with_capacity(self.all.len());
        let mut open: Vec<usize> = self.roots.iter().rev().copied().collect();
        while let Some(index) = open.pop() {
            let Some(over) = self.all.get_mut(index) else { continue };
            out.push(std::mem::take(&mut over.prim));
            open.extend(over.below.iter().rev());
        }
        out
    }
}
