//! Going on past a fault: what is faulty is replaced by something harmless, so that the next fault can be found, too.
//! Nothing that is made here is ever rendered or written.

use super::missing;
use eyebox_base::{Code, Error, Where};
use eyebox_import::toml;
use eyebox_scene::assembly::Assembly;
use eyebox_scene::texture::{PictureSource, Texels};
use eyebox_scene::value::{Data, Value};
use std::path::Path;

const EYE: &str = "position = [\"0 mm\", \"0 mm\", \"0 mm\"]\nlook = [0, 0, -1]\nup = [0, 1, 0]\nfov_deg = 12\n";
const SELECTORS: [&str; 6] = ["path", "name", "material", "mesh", "faces", "normal"];

/// Takes what `fault` is about out of the sidecar or of the asset's own attributes. False if that place is not known, so
/// that there is nothing more to find.
pub fn heal(assembly: &mut Assembly, sheet: &mut Option<Value>, fault: &Error) -> bool {
    if fault.code == Some(Code::PartUnbound) {
        return cover(assembly, sheet);
    }
    if fault.code == Some(Code::SchemaNewer) {
        // What else it says may mean something else by then.
        return false;
    }
    if fault.code == Some(Code::EyeMissing) {
        return give_eye(assembly, sheet);
    }
    if let Some(texture) = missing::texture_of(fault)
        && stand_in_texture(assembly, &texture)
    {
        return true;
    }
    // One of two that contradict has to go; whatever it said, the other says.
    let drop = fault.code == Some(Code::BoundTwice);
    if let Some(sheet) = sheet
        && in_sheet(sheet, &fault.at, drop)
    {
        return true;
    }
    in_asset(assembly, &fault.at, drop)
}

fn text(word: &str, at: &Where) -> Value {
    Value::new(Data::Text(word.to_owned()), at.clone())
}

fn table<'a>(value: &'a mut Value, key: &str) -> Option<&'a mut Value> {
    match &mut value.data {
        Data::Table(entries) => entries.iter_mut().find(|(name, _)| name == key).map(|(_, value)| value),
        Data::Bool(_) | Data::Number(_) | Data::Text(_) | Data::List(_) => None,
    }
}

/// Gives every part a finish; false if there is one for all already.
fn cover(assembly: &mut Assembly, sheet: &mut Option<Value>) -> bool {
    let Some(root) = sheet.as_mut().or(assembly.optics.as_mut()) else {
        // An asset that says nothing of light: there is nothing more to look for.
        return false;
    };
    let at = root.at.clone();
    let Data::Table(entries) = &mut root.data else { return false };
    if !entries.iter().any(|(key, _)| key == "default") {
        entries.push(("default".to_owned(), Value::new(Data::Table(Vec::new()), at.clone())));
    }
    let Some(Value { data: Data::Table(default), .. }) = table(root, "default") else { return false };
    let bare = !default.iter().any(|(key, _)| key == "finish");
    if bare {
        default.push(("finish".to_owned(), text("absorber", &at)));
    }
    bare
}

fn give_eye(assembly: &mut Assembly, sheet: &mut Option<Value>) -> bool {
    let Some(root) = sheet.as_mut().or(assembly.optics.as_mut()) else { return false };
    let Some(eye) = stand_in_eye() else { return false };
    let Data::Table(entries) = &mut root.data else { return false };
    if entries.iter().any(|(key, _)| key == "eye") {
        return false;
    }
    entries.push(("eye".to_owned(), eye));
    true
}

/// Has every material do without the picture that is missing; false if none of them names it.
fn stand_in_texture(assembly: &mut Assembly, texture: &Path) -> bool {
    let mut found = false;
    let surfaces = assembly.materials.iter_mut().filter_map(|material| material.surface.as_mut());
    for input in surfaces.flat_map(|surface| surface.textures_mut()) {
        if let Texels::Encoded(PictureSource::File(file)) = &input.texture.texels
            && input.fallback.is_none()
            && missing::is_same(file, texture)
        {
            input.fallback = Some([1.0; 4]);
            found = true;
        }
    }
    found
}

fn stand_in_eye() -> Option<Value> {
    toml::parse(EYE, Path::new("eye")).ok()
}

/// A piece of a sidecar: a key of the top level, an item of a list, an entry of a table of named things.
struct Piece {
    key: String,
    item: Option<usize>,
    line: usize,
}

fn line_of(at: &Where) -> usize {
    if let Where::Line { line, .. } = at { *line } else { 0 }
}

/// Replaces the piece of the sidecar that stands at `at`.
fn in_sheet(sheet: &mut Value, at: &Where, drop: bool) -> bool {
    let (Where::Line { file, line }, Where::Line { file: own, .. }) = (at, &sheet.at) else { return false };
    if file != own {
        // A file that the sidecar names: the piece is not known from the line in there.
        return false;
    }
    let Data::Table(entries) = &mut sheet.data else { return false };
    let mut pieces = Vec::new();
    for (key, value) in entries.iter() {
        pieces.push(Piece { key: key.clone(), item: None, line: line_of(&value.at) });
        let inner: Vec<&Value> = match &value.data {
            Data::List(items) if key == "bind" => items.iter().collect(),
            Data::Table(named) if key == "coating" || key == "medium" => named.iter().map(|(_, value)| value).collect(),
            Data::List(_) | Data::Table(_) | Data::Bool(_) | Data::Number(_) | Data::Text(_) => Vec::new(),
        };
        let item =
            |(index, value): (usize, &Value)| Piece { key: key.clone(), item: Some(index), line: line_of(&value.at) };
        pieces.extend(inner.into_iter().enumerate().map(item));
    }
    let Some(piece) = pieces.into_iter().filter(|piece| piece.line <= *line).max_by_key(|p| (p.line, p.item.is_some()))
    else {
        return false;
    };
    let index = entries.iter().position(|(key, _)| *key == piece.key);
    let Some(index) = index else { return false };
    let value = &mut entries[index].1;
    match (piece.key.as_str(), piece.item, &mut value.data) {
        ("bind", Some(item), Data::List(binds)) => {
            if let Some(bind) = binds.get_mut(item)
                && !mend_entries(bind, *line, drop)
            {
                binds.remove(item);
            }
        }
        ("coating" | "medium", Some(item), Data::Table(named)) => {
            if let Some((_, value)) = named.get_mut(item) {
                *value = stand_in(&piece.key, &value.at);
            }
        }
        ("default", _, _) => {
            *value = Value::new(Data::Table(vec![("finish".to_owned(), text("absorber", at))]), at.clone())
        }
        ("eye", _, _) => match stand_in_eye() {
            Some(eye) => *value = eye,
            None => return false,
        },
        // Without it, it would be missing next.
        ("schema", _, _) => value.data = Data::Number(1.0),
        _ => std::mem::drop(entries.remove(index)),
    }
    true
}

/// A coating that does nothing, a medium like glass.
fn stand_in(noun: &str, at: &Where) -> Value {
    let number = |x: f64| Value::new(Data::Number(x), at.clone());
    let entries = if noun == "coating" {
        let shares = vec![("R".to_owned(), number(0.0)), ("T".to_owned(), number(1.0))];
        vec![("ideal".to_owned(), Value::new(Data::Table(shares), at.clone()))]
    } else {
        vec![("ior".to_owned(), number(1.5))]
    };
    Value::new(Data::Table(entries), at.clone())
}

/// Replaces the last entry of a table that begins at or before `line`; false if the table has to go as a whole.
fn mend_entries(bind: &mut Value, line: usize, drop: bool) -> bool {
    let own = line_of(&bind.at);
    let Data::Table(entries) = &mut bind.data else { return false };
    let found = entries.iter().enumerate().filter(|(_, (_, value))| line_of(&value.at) <= line && line > own);
    let Some(index) = found.max_by_key(|(_, (_, value))| line_of(&value.at)).map(|(index, _)| index) else {
        return false;
    };
    mend_entry(entries, index, drop) && entries.iter().any(|(key, _)| !SELECTORS.contains(&key.as_str()))
}

/// Replaces or removes one attribute; false for what selects.
fn mend_entry(entries: &mut Vec<(String, Value)>, index: usize, drop: bool) -> bool {
    let Some((key, value)) = entries.get_mut(index) else { return false };
    match key.as_str() {
        key if SELECTORS.contains(&key) => return false,
        _ if drop => std::mem::drop(entries.remove(index)),
        "finish" => value.data = Data::Text("absorber".to_owned()),
        "glass" | "ior" | "sellmeier" | "cauchy" | "abbe" | "index_table" | "medium" => {
            *key = "ior".to_owned();
            value.data = Data::Number(1.5);
        }
        _ => std::mem::drop(entries.remove(index)),
    }
    // Two indices became one.
    let mut seen = Vec::new();
    entries.retain(|(key, _)| {
        let first = !seen.contains(key);
        seen.push(key.clone());
        first
    });
    true
}

/// Takes the attribute at `at` out of what the asset says of itself.
fn in_asset(assembly: &mut Assembly, at: &Where, drop: bool) -> bool {
    if matches!(at, Where::Nowhere | Where::File(_) | Where::Part { .. } | Where::Option(_)) {
        return false;
    }
    if let Some(optics) = &mut assembly.optics
        && let Data::Table(entries) = &mut optics.data
        && let Some(index) = entries.iter().position(|(_, value)| holds(value, at))
    {
        // Lists are named by index, so an item can't go.
        let (key, value) = &mut entries[index];
        match (key.as_str(), &mut value.data) {
            ("media" | "coatings", Data::List(items)) => {
                let noun = if key == "media" { "medium" } else { "coating" };
                let Some(item) = items.iter_mut().find(|item| holds(item, at)) else { return false };
                *item = stand_in(noun, &item.at);
            }
            ("emitters" | "slides", _) => return false,
            ("eye", _) => match stand_in_eye() {
                Some(eye) => *value = eye,
                None => return false,
            },
            ("version", _) => value.data = Data::Number(1.0),
            _ => std::mem::drop(entries.remove(index)),
        }
        return true;
    }
    let nodes = assembly.nodes.iter_mut().flat_map(|node| &mut node.attributes);
    let faces = assembly.meshes.iter_mut().flat_map(|mesh| mesh.attributes.iter_mut().flatten());
    let materials = assembly.materials.iter_mut();
    for material in materials {
        if let Some(index) = material.mapped.iter().position(|(_, value)| holds(value, at)) {
            material.mapped.remove(index);
            return true;
        }
        if material.attributes.as_mut().is_some_and(|value| drop_entry(value, at, drop)) {
            return true;
        }
    }
    nodes.chain(faces).any(|value| drop_entry(value, at, drop))
}

fn drop_entry(value: &mut Value, at: &Where, drop: bool) -> bool {
    let Data::Table(entries) = &mut value.data else { return false };
    let Some(index) = entries.iter().position(|(_, value)| holds(value, at)) else { return false };
    if !mend_entry(entries, index, drop) {
        entries.remove(index);
    }
    true
}

/// Whether `at` is the place of a value or of something in it.
fn holds(value: &Value, at: &Where) -> bool {
    if value.at == *at {
        return true;
    }
    match &value.data {
        Data::Bool(_) | Data::Number(_) | Data::Text(_) => false,
        Data::List(items) => items.iter().any(|item| holds(item, at)),
        Data::Table(entries) => entries.iter().any(|(_, value)| holds(value, at)),
    }
}
