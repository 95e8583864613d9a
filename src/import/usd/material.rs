//! Material prims, each an entry of `Assembly::materials`: our own attributes, and what their surface shader says.

use super::attribute::PrimView;
use super::binding::Collections;
use super::reader::Reader;
use super::reads::{Folding, Reads};
use super::round_trip::RoundTrip;
use super::shader::{self, End};
use super::surface::{self, Row};
use super::{handed, light, network, optics, stranger, texture, user};
use crate::assembly::Material;
use crate::value::{Data, Value};
use eyebox_base::Where;
use eyebox_base::error::Result;
use eyebox_scene::{Colour, Opacity, Scalar, StandardSurface};
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
    /// What each reads of its mesh, in the order of `Assembly::materials` before they are sorted.
    pub reads: Vec<Reads>,
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
    if depth > handed::MOST_DEEP {
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
            reader.folding = Folding::default();
            let material = read(reader, view)?;
            let reads = std::mem::take(&mut reader.folding).reads;
            reader.materials.reads.push(reads);
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
            match texture::tiles_of(&file) {
                Some(tiles) => reader.assembly.textures.extend(tiles.into_iter().map(|(tile, _)| (tile, at.clone()))),
                None => reader.assembly.textures.push((file, at)),
            }
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
    // MaterialX can say more than the universal surface, and both more than those of one renderer.
    let foreign = |name: &&str| {
        let context = name.strip_prefix("outputs:").and_then(|rest| rest.strip_suffix(":surface"));
        context.is_some_and(|context| context != "mtlx")
    };
    let others = view.property_names().iter().map(String::as_str).filter(foreign);
    let contexts: Vec<&str> = ["outputs:mtlx:surface", "outputs:surface"].into_iter().chain(others).collect();
    let mut strangers = Vec::new();
    let mut unread = contexts.iter().copied();
    for context in unread.by_ref() {
        let End::Node(shader, _) = shader::follow(reader, view, context)? else { continue };
        known = true;
        let Some(found) = surface::read(reader, &shader)? else {
            strangers.push(shader);
            continue;
        };
        (mapped, looks) = (found.mapped, found.looks);
        standard = Some(found.standard);
        // It may be our own writer's surface: the marks have its numbers exactly.
        known = false;
        if let Some(surface) = standard.as_mut().filter(|_| !found.preview) {
            cut_out(reader, view, &shader, surface)?;
        }
        glass = found.glass;
        break;
    }
    for stranger in &strangers {
        if standard.is_some() {
            let text = "a surface shader of a kind that is not known: another one of the material is taken";
            reader.ledger.info(stranger.at(), text);
        } else if let Some(found) = stranger::read(reader, stranger)? {
            looks = found.looks;
            standard = Some(found.standard);
        }
    }
    if !known {
        for (rows, key, keys) in
            [(&mut mapped, "mapped", &surface::SAID[..]), (&mut looks, "looks", &surface::LOOKS[..])]
        {
            if let Some(text) = marks.text(key) {
                reader.charge(view.path(), text.len(), size_of::<Row>())?;
                *rows = exact(parse(text, &view.at()), std::mem::take(rows), keys);
            }
        }
    }
    if let Some(text) = marks.text("unsaid") {
        reader.charge(view.path(), text.len(), size_of::<Row>())?;
        let unsaid = parse(text, &view.at());
        looks.retain(|(key, value)| !unsaid.iter().any(|(own, there)| own == key && rounds_to(there, value)));
    }
    if let Some(name) = unread.find(|name| foreign(name)) {
        reader
            .ledger
            .info(view.at_property(name), "a surface for another renderer is not used: the material has its own");
    }
    let attributes = optics::material(reader, view)?;
    if let Some(at) = glass.filter(|_| attributes.as_ref().is_none_or(|own| own.get("finish").is_none())) {
        let text = "an `opacity` below 1 with an `ior` is how others write glass: shown as a share of what is behind; say `polished`";
        reader.ledger.warn(at, text);
    }
    if let Some(surface) = &mut standard {
        // No surface of USD's has it: our writer leaves it in marks.
        if let Some(share) = marks.number("diffuse_transmission") {
            surface.diffuse_transmission = Scalar::new(share.clamp(0.0, 1.0));
        }
        if let Some(color) = marks.triple("diffuse_transmission_color") {
            surface.diffuse_transmission_color = Colour::new(color.map(|lane| lane.max(0.0)));
        }
    }
    let name = marks.text("name").unwrap_or(view.name()).to_owned();
    let surface = standard.map(|found| StandardSurface { name: name.clone(), ..found }.into());
    let user = user::of(reader, view, &marks)?;
    Ok(Material { name, mapped, attributes, looks, surface, user, at: view.at() })
}

/// MaterialX' layered surfaces have no threshold: where a UsdPreviewSurface beside one cuts out, so does that.
fn cut_out(reader: &mut Reader, view: &PrimView, own: &PrimView, surface: &mut StandardSurface) -> Result<()> {
    if shader::id(own)?.contains("gltf_pbr") {
        return Ok(());
    }
    let alpha = match &surface.opacity {
        Opacity::Opaque => Scalar::new(1.0),
        Opacity::Blend { alpha } => alpha.clone(),
        Opacity::Mask { .. } => return Ok(()),
    };
    let End::Node(beside, _) = shader::follow(reader, view, "outputs:surface")? else { return Ok(()) };
    if shader::id(&beside)? == "UsdPreviewSurface" {
        let cutoff = network::number(reader, &beside, "opacityThreshold", 0.0)?;
        if cutoff > 0.0 {
            surface.opacity = Opacity::Mask { alpha, cutoff };
        }
    }
    Ok(())
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

/// The rows of the marks, where those that the shader says, too, still say what they said when it was written; else the
/// shader's. Those in `keys` would be in the shader, and are gone where they are not.
fn exact(marks: Vec<Row>, mut shader: Vec<Row>, keys: &[&str]) -> Vec<Row> {
    let mut out = Vec::new();
    for (key, value) in marks {
        match shader.iter().position(|(own, _)| *own == key) {
            Some(index) => {
                let (_, authored) = shader.remove(index);
                // Only its being there counts: the geometry has the thickness.
                let same = match key.as_str() {
                    "thickness" => true,
                    "emitter.spectrum" => is_one_hue(&value, &authored),
                    _ => rounds_to(&value, &authored),
                };
                out.push((key, if same { value } else { authored }));
            }
            None if keys.contains(&key.as_str()) && single(&value) => {}
            None => out.push((key, value)),
        }
    }
    out.extend(shader);
    out
}

/// Whether two colours of light are the same but for how bright they are, to single precision.
fn is_one_hue(exact: &Value, rounded: &Value) -> bool {
    let lanes = |value: &Value| -> Option<Vec<f64>> { value.get("rgb")?.list()?.iter().map(Value::number).collect() };
    let (Some(a), Some(b)) = (lanes(exact), lanes(rounded)) else { return rounds_to(exact, rounded) };
    let most = |lanes: &[f64]| lanes.iter().copied().fold(0.0, f64::max);
    let (of_a, of_b) = (most(&a), most(&b));
    // What is computed of single precision is a few roundings off.
    a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| (a * of_b - b * of_a).abs() <= 1e-6 * of_a * of_b)
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
        // What is computed of single precision is a few roundings off.
        (Data::Number(a), Data::Number(b)) => (a - b).abs() <= 1e-6 * b.abs(),
        (Data::Table(a), Data::Table(_)) => a.iter().all(|(key, a)| {
            // A name is for people.
            key == "name" || rounded.get(key).is_some_and(|b| rounds_to(a, b))
        }),
        (Data::List(a), Data::List(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| rounds_to(a, b)),
        _ => false,
    }
}
