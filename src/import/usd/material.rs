//! Material prims, each an entry of `Assembly::materials`: our own attributes, and what their surface shader says.

use super::attribute::PrimView;
use super::binding::Collections;
use super::reader::Reader;
use super::round_trip::RoundTrip;
use super::shader::{self, End};
use super::surface::{self, Row};
use super::{hierarchy, light, optics};
use crate::base::Where;
use crate::base::fault::Result;
use crate::import::assembly::Material;
use crate::import::value::{Data, Value};
use crate::scene::StandardSurface;
use openusd::sdf;
use std::collections::{HashMap, HashSet};

/// What was read so far.
#[derive(Debug, Default)]
pub(super) struct Known {
    /// By path; inside of instances the path in the prototype, which they share.
    by_path: HashMap<String, Option<usize>>,
    /// Those that the walk met, in the order of the stage.
    order: Vec<usize>,
    met: HashSet<usize>,
    pub collections: Collections,
}

/// The material at `path`; none if there is none.
///
/// # Errors
/// Values of the wrong kind.
pub(super) fn at(reader: &mut Reader, path: &sdf::Path) -> Result<Option<usize>> {
    if !path.is_prim_path() {
        return Ok(None);
    }
    let prim = reader.prim(path)?;
    if !prim.is_valid().map_err(|error| reader.moment.failed(path, error))? {
        return Ok(None);
    }
    let view = PrimView::new(prim, &reader.moment)?;
    of(reader, &view)
}

/// Notes that the walk met a Material.
///
/// # Errors
/// Values of the wrong kind.
pub(super) fn met(reader: &mut Reader, view: &PrimView) -> Result<()> {
    if let Some(index) = of(reader, view)?
        && reader.materials.met.insert(index)
    {
        reader.materials.order.push(index);
    }
    Ok(())
}

/// Meets the materials below a prim that is not walked itself.
///
/// # Errors
/// Values of the wrong kind; too many prims.
pub(super) fn meet_below(reader: &mut Reader, view: &PrimView, depth: usize) -> Result<()> {
    if depth > hierarchy::MOST_DEEP {
        return Ok(());
    }
    for child in view.children()? {
        let Reader { ledger, moment, opened, bound, .. } = &mut *reader;
        ledger.prim(|| moment.at(child.path()), opened.bytes())?;
        bound.check(moment, child.path())?;
        let failed = |error| moment.failed(child.path(), error);
        let defined = child.specifier().map_err(failed)? == Some(sdf::Specifier::Def);
        if !defined || child.get_metadata::<bool>("active").map_err(failed)? == Some(false) {
            continue;
        }
        let child = PrimView::new(child, moment)?;
        if child.type_name()? == "Material" {
            met(reader, &child)?;
        } else {
            meet_below(reader, &child, depth + 1)?;
        }
    }
    Ok(())
}

/// Puts the materials in the order of the stage, as a writer meant them; those that are only bound come last.
pub(super) fn sort(reader: &mut Reader) {
    let count = reader.assembly.materials.len();
    let mut place: Vec<Option<usize>> = vec![None; count];
    let rest = (0..count).filter(|index| !reader.materials.met.contains(index));
    let order: Vec<usize> = reader.materials.order.iter().copied().chain(rest).collect();
    let mut old: Vec<Option<Material>> = std::mem::take(&mut reader.assembly.materials).into_iter().map(Some).collect();
    for index in order {
        if let Some(material) = old.get_mut(index).and_then(Option::take) {
            place[index] = Some(reader.assembly.materials.len());
            reader.assembly.materials.push(material);
        }
    }
    for own in reader.assembly.meshes.iter_mut().flat_map(|mesh| &mut mesh.materials) {
        *own = own.and_then(|index| place.get(index).copied().flatten());
    }
}

fn of(reader: &mut Reader, view: &PrimView) -> Result<Option<usize>> {
    let shared = view.prim.prim_in_prototype().map_err(|error| reader.moment.failed(view.path(), error))?;
    let key = shared.map_or_else(|| view.path().as_str().to_owned(), |prim| prim.path().as_str().to_owned());
    if let Some(known) = reader.materials.by_path.get(&key) {
        return Ok(*known);
    }
    let index = match view.type_name()?.as_str() {
        "Material" => {
            let material = read(reader, view)?;
            textures(reader, view, 0)?;
            reader.assembly.materials.push(material);
            Some(reader.assembly.materials.len() - 1)
        }
        _ => None,
    };
    reader.materials.by_path.insert(key, index);
    Ok(index)
}

/// The pictures that shaders below a prim name.
fn textures(reader: &mut Reader, view: &PrimView, depth: usize) -> Result<()> {
    // Node graphs within node graphs.
    const MOST_DEEP: usize = 16;
    for child in view.children()? {
        let Reader { ledger, moment, opened, bound, .. } = &mut *reader;
        ledger.prim(|| moment.at(child.path()), opened.bytes())?;
        bound.check(moment, child.path())?;
        let child = PrimView::new(child, moment)?;
        if child.has("inputs:file")
            && let Ok(Some(file)) = light::file(&child, "inputs:file")
        {
            let at = child.at_property("inputs:file");
            reader.charge(child.path(), 1, 256 + file.as_os_str().len() + child.path().as_str().len())?;
            reader.assembly.textures.push((file, at));
        }
        if depth < MOST_DEEP {
            textures(reader, &child, depth + 1)?;
        }
    }
    Ok(())
}

fn read(reader: &mut Reader, view: &PrimView) -> Result<Material> {
    reader.charge(view.path(), 1, size_of::<Material>() + 2 * view.path().as_str().len())?;
    let marks = RoundTrip::of(view)?;
    let (mut known, mut glass) = (false, None);
    let (mut mapped, mut looks) = (Vec::new(), Vec::new());
    let mut standard = None;
    // MaterialX can say more than the universal surface.
    for context in ["outputs:mtlx:surface", "outputs:surface"] {
        let End::Node(shader, _) = shader::follow(reader, view, context)? else { continue };
        known = true;
        if let Some(found) = surface::read(reader, &shader)? {
            (mapped, looks) = (found.mapped, found.looks);
            standard = Some(found.standard);
            // Our own writer's surface: the marks have its numbers exactly.
            known = !found.preview;
            glass = found.glass;
            break;
        }
    }
    if !known {
        for (rows, key, keys) in [(&mut mapped, "mapped", &["ior"][..]), (&mut looks, "looks", &surface::LOOKS[..])] {
            if let Some(text) = marks.text(key) {
                reader.charge(view.path(), text.len(), size_of::<Row>())?;
                *rows = exact(parse(text, &view.at()), std::mem::take(rows), keys);
            }
        }
    }
    let other = |name: &&String| {
        let context = name.strip_prefix("outputs:").and_then(|rest| rest.strip_suffix(":surface"));
        context.is_some_and(|context| context != "mtlx")
    };
    if let Some(name) = view.property_names().iter().find(other) {
        reader.ledger.info(view.at_property(name), "a surface for another renderer alone is not used");
    }
    let attributes = optics::material(reader, view)?;
    if let Some(at) = glass.filter(|_| attributes.as_ref().is_none_or(|own| own.get("finish").is_none())) {
        let text = "an `opacity` below 1 with an `ior` is how others write glass: shown as a share of what is behind; say `polished`";
        reader.ledger.warn(at, text);
    }
    let name = marks.text("name").unwrap_or(view.name()).to_owned();
    let surface = standard.map(|found| StandardSurface { name: name.clone(), ..found }.into());
    Ok(Material { name, mapped, attributes, looks, surface, at: view.at() })
}

/// The rows of a mark: a list of [key, value] in JSON. Anything else is someone else's and says nothing.
fn parse(text: &str, at: &Where) -> Vec<Row> {
    let rows: Vec<(String, serde_json::Value)> = serde_json::from_str(text).unwrap_or_default();
    rows.into_iter().filter_map(|(key, json)| Some((key, value(&json, at)?))).collect()
}

fn value(json: &serde_json::Value, at: &Where) -> Option<Value> {
    let data = match json {
        serde_json::Value::Null => return None,
        serde_json::Value::Bool(flag) => Data::Bool(*flag),
        serde_json::Value::Number(number) => Data::Number(number.as_f64().filter(|x| x.is_finite())?),
        // JSON has no infinity.
        serde_json::Value::String(text) if text == "inf" => Data::Number(f64::INFINITY),
        serde_json::Value::String(text) => Data::Text(text.clone()),
        serde_json::Value::Array(items) => Data::List(items.iter().map(|item| value(item, at)).collect::<Option<_>>()?),
        serde_json::Value::Object(entries) => {
            let entries = entries.iter().map(|(key, item)| Some((key.clone(), value(item, at)?)));
            Data::Table(entries.collect::<Option<_>>()?)
        }
    };
    Some(Value::new(data, at.clone()))
}

/// The rows of the marks, where those that the shader can say, `keys`, still say what they said when it was written;
/// else the shader's.
fn exact(marks: Vec<Row>, mut shader: Vec<Row>, keys: &[&str]) -> Vec<Row> {
    let mut out = Vec::new();
    for (key, value) in marks {
        if !keys.contains(&key.as_str()) {
            out.push((key, value));
            continue;
        }
        match shader.iter().position(|(own, _)| *own == key) {
            Some(index) => {
                let (_, authored) = shader.remove(index);
                let kept = if rounds_to(&value, &authored) { value } else { authored };
                out.push((key, kept));
            }
            None if single(&value) => {}
            None => out.push((key, value)),
        }
    }
    out.extend(shader);
    out
}

/// Whether single precision can hold it, so that our writer said it in the shader, too.
fn single(value: &Value) -> bool {
    match &value.data {
        Data::Number(x) => (*x as f32).is_finite(),
        Data::List(items) => items.len() == 3 && items.iter().all(single),
        Data::Bool(_) | Data::Text(_) | Data::Table(_) => false,
    }
}

fn rounds_to(exact: &Value, rounded: &Value) -> bool {
    match (&exact.data, &rounded.data) {
        (Data::Number(a), Data::Number(b)) => f64::from(*a as f32) == *b,
        (Data::List(a), Data::List(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| rounds_to(a, b)),
        _ => false,
    }
}
