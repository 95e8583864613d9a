//! Binding: which of the values offered for an attribute of a part or face holds. Everything happens on [`Value`]s; what
//! they mean is the readers' business.

use super::assembly::Assembly;
use super::asset_attributes::{AssetAttributes, entries};
use super::asset_rows;
use super::binding_slots::{Entry, PartBound, Rank, Slot, Slots};
use super::optics::{medium_entries, stray};
use super::select::{Candidate, Faces, is_glob, listed};
use super::value::{Data, Value};
use eyebox_base::error::Result;
use eyebox_base::{Code, Error};
use eyebox_scene::Note;
use eyebox_scene::attribute::Noun;
use std::rc::Rc;

/// The attributes that can be bound.
pub const BINDABLE: [&str; 15] = [
    "medium",
    "ior",
    "glass",
    "sellmeier",
    "cauchy",
    "abbe",
    "index_table",
    "absorption_per_m",
    "priority",
    "finish",
    "coating",
    "shape",
    "emitter",
    "slide",
    "sensor",
];
const SELECTORS: [&str; 6] = ["path", "name", "material", "mesh", "faces", "normal"];

/// Binds everything that the sheet and the asset say to `parts`.
/// Faults: unknown attributes, selectors that select nothing or too much, contradictions.
pub fn bind(
    sheet: &AssetAttributes,
    assembly: &Assembly,
    parts: &[Candidate],
    notes: &mut Vec<Note>,
) -> Result<Vec<PartBound>> {
    let mut bound: Vec<PartBound> = parts
        .iter()
        .map(|part| PartBound { part: Slots::default(), faces: vec![Slots::default(); part.faces] })
        .collect();
    if let Some(default) = &sheet.default {
        let said = said(entries(default, "`default`")?, sheet, "`[default]`", &[])?;
        for part in &mut bound {
            offer(part, &said, Rank::Default, None);
        }
    }
    asset_rows::offer_all(sheet, assembly, parts, &mut bound, notes)?;
    for value in &sheet.binds {
        one(value, sheet, assembly, parts, &mut bound, notes)?;
    }
    for (part, candidate) in bound.iter().zip(parts) {
        part.part.settled(&|| format!("part {}", candidate.path))?;
        for (number, face) in part.faces.iter().enumerate() {
            face.settled(&|| format!("part {} face {number}", candidate.path))?;
        }
    }
    Ok(bound)
}

pub(super) fn offer(part: &mut PartBound, said: &[Rc<Entry>], rank: Rank, faces: Option<&[usize]>) {
    for entry in said {
        if entry.slot.of_part() {
            part.part.offer(entry, rank);
            continue;
        }
        match faces {
            None => part.faces.iter_mut().for_each(|face| face.offer(entry, rank)),
            Some(faces) => {
                faces
                    .iter()
                    .for_each(|face| part.faces.iter_mut().skip(*face).take(1).for_each(|f| f.offer(entry, rank)));
            }
        }
    }
}

/// The attributes among `table`'s entries, those of a medium taken apart. `beside`: keys that are no attributes.
pub fn said(table: &[(String, Value)], sheet: &AssetAttributes, what: &str, beside: &[&str]) -> Result<Vec<Rc<Entry>>> {
    let mut all: Vec<Rc<Entry>> = Vec::new();
    let mut add = |entry: Entry| -> Result<()> {
        if let Some(other) = all.iter().find(|other| other.slot == entry.slot) {
            let what = format!("{what} gives both `{}` and `{}`", other.key, entry.key);
            return Err(Error::new(entry.at, what).expected("one of them").code(Code::SaidTwice));
        }
        all.push(Rc::new(entry));
        Ok(())
    };
    for (key, value) in table {
        if beside.contains(&key.as_str()) {
            continue;
        }
        let Some(slot) = Slot::of(key) else {
            let nouns = [(Noun::Finish, "finish"), (Noun::Coating, "coating"), (Noun::Shape, "shape")];
            let stray = |(noun, own)| stray(key, value, noun, what, &mut std::iter::once(own));
            if let Some(fault) = nouns.into_iter().find_map(stray) {
                return Err(fault);
            }
            let valid = || beside.iter().copied().chain(BINDABLE);
            return Err(Error::new(value.at.clone(), format!("unknown attribute `{key}` in {what}"))
                .expected(format!("one of {}", valid().collect::<Vec<_>>().join(", ")))
                .nearest(key, valid())
                .code(Code::AttributeUnknown));
        };
        if key != "medium" || value.text() == Some("none") {
            add(Entry { slot, key: key.clone(), value: value.clone(), label: None, at: value.at.clone() })?;
            continue;
        }
        let medium = sheet.media.follow(value)?;
        if let Data::Text(name) = &medium.data {
            return Err(Error::new(value.at.clone(), format!("unknown medium `{name}`"))
                .expected("the name of a [medium.NAME], or \"none\"; a catalogue glass is `glass = …`")
                .nearest(name, sheet.media.names())
                .code(Code::NameUnknown));
        }
        let inner = medium_entries(medium)?;
        let label = value.text().or_else(|| medium.get("name").and_then(Value::text)).map(str::to_owned);
        if !inner.iter().any(|(key, _)| Slot::of(key) == Some(Slot::Index)) {
            return Err(Error::new(medium.at.clone(), "this medium has no index")
                .expected("one of ior, glass, sellmeier, cauchy, abbe, index_table")
                .code(Code::IndexMissing));
        }
        for (key, item) in inner {
            if let Some(slot) = Slot::of(key) {
                add(Entry { slot, key: key.clone(), value: item.clone(), label: label.clone(), at: value.at.clone() })?;
            }
        }
    }
    Ok(all)
}

/// Applies one `[[bind]]`.
fn one(
    value: &Value,
    sheet: &AssetAttributes,
    assembly: &Assembly,
    parts: &[Candidate],
    bound: &mut [PartBound],
    notes: &mut Vec<Note>,
) -> Result<()> {
    let table = entries(value, "`bind`")?;
    let said = said(table, sheet, "`[[bind]]`", &SELECTORS)?;
    let text = |key: &str| -> Result<Option<&str>> {
        value
            .get(key)
            .map(|value| {
                value.text().ok_or_else(|| {
                    Error::new(value.at.clone(), format!("`{key}` is {} ({value})", value.kind())).expected("a text")
                })
            })
            .transpose()
    };
    let (path, name, material, mesh) = (text("path")?, text("name")?, text("material")?, text("mesh")?);
    let which = Faces::read(value.get("faces"), value.get("normal"))?;
    if path.is_none() && name.is_none() && material.is_none() && mesh.is_none() {
        return Err(Error::new(value.at.clone(), "this `[[bind]]` selects no parts")
            .expected("`path`, `name`, `material` or `mesh`; what holds for all parts goes to [default]")
            .code(Code::SelectsNothing));
    }
    if said.is_empty() {
        return Err(Error::new(value.at.clone(), "this `[[bind]]` says nothing about its parts")
            .expected(format!("one of {}", BINDABLE.join(", "))));
    }
    if let (true, Some(entry)) = (which != Faces::All, said.iter().find(|entry| entry.slot.of_part())) {
        return Err(Error::new(entry.at.clone(), format!("`{}` fills a whole part, not some of its faces", entry.key))
            .expected("a [[bind]] of its own without `faces` and `normal`"));
    }
    let mesh_name = |part: &Candidate| assembly.meshes.get(part.mesh).map_or("", |source| source.mesh.name.as_str());
    let matches =
        |pattern: &str, text: &str| if is_glob(pattern) { super::select::glob(pattern, text) } else { pattern == text };
    let chosen: Vec<usize> = (0..parts.len())
        .filter(|index| {
            let part = &parts[*index];
            path.is_none_or(|pattern| part.has_path(pattern))
                && name.is_none_or(|pattern| part.has_name(pattern))
                && mesh.is_none_or(|pattern| matches(pattern, mesh_name(part)))
        })
        .collect();
    if chosen.is_empty() {
        return Err(unmatched(value, assembly, parts, path, name, mesh));
    }
    let exact = [path, name].into_iter().flatten().any(|pattern| !is_glob(pattern));
    if chosen.len() > 1 && exact {
        let paths = listed(chosen.iter().map(|index| parts[*index].path.as_str()));
        if let Some(path) = path.filter(|path| !is_glob(path)) {
            let at = value.get("path").map_or(&value.at, |value| &value.at);
            return Err(Error::new(at.clone(), format!("path `{path}` means {} parts: {paths}", chosen.len()))
                .expected("the path of one part, or a pattern, e.g. `**/NAME`, for all of them")
                .code(Code::NameAmbiguous));
        }
        let text = format!("name `{}` means {} parts: {paths}", name.unwrap_or(""), chosen.len());
        notes.push(Note::info(value.at.clone(), text));
    }
    let rank = match (which == Faces::All, exact) {
        (true, false) => Rank::Glob,
        (true, true) => Rank::Exact,
        (false, false) => Rank::FaceGlob,
        (false, true) => Rank::FaceExact,
    };
    let at = value.get("faces").or(value.get("normal")).map_or(&value.at, |value| &value.at);
    let (mut any, mut without) = (false, Vec::new());
    for index in chosen {
        let part = &parts[index];
        let mut faces = which.of(part, assembly, at)?;
        if let Some(pattern) = material {
            let source = assembly.meshes.get(part.mesh);
            faces.retain(|face| {
                let own = source.and_then(|source| source.materials.get(*face).copied().flatten());
                own.and_then(|own| assembly.materials.get(own)).is_some_and(|own| matches(pattern, &own.name))
            });
        }
        if faces.is_empty() {
            without.push(part.path.as_str());
            continue;
        }
        any = true;
        let whole = which == Faces::All && material.is_none();
        offer(&mut bound[index], &said, rank, if whole { None } else { Some(&faces) });
    }
    if !any {
        let what = match (material, value.get("normal")) {
            (Some(material), _) => format!("no face of the selected parts has material `{material}`"),
            (None, Some(normal)) => format!("no face of {} looks along {normal}", listed(without.into_iter())),
            (None, None) => format!("{} has no faces", listed(without.into_iter())),
        };
        let names = assembly.materials.iter().map(|own| own.name.as_str());
        return Err(Error::new(at.clone(), what).nearest(material.unwrap_or(""), names).code(Code::SelectsNothing));
    }
    if let (Some(normal), false) = (value.get("normal"), without.is_empty()) {
        let text = format!("no face looks along {normal} in {}", listed(without.into_iter()));
        // A lamp, a slide or a sensor that gets lost leaves a plausible picture: that is no matter for a note.
        if ["emitter", "slide", "sensor"].iter().any(|key| value.get(key).is_some()) {
            return Err(Error::new(at.clone(), text)
                .expected("a face with an area that looks that way in every part")
                .code(Code::SelectsNothing));
        }
        notes.push(Note::warning(at.clone(), text).code(Code::SelectsNothing));
    }
    Ok(())
}

/// The fault of a selector that matches no part.
fn unmatched(
    value: &Value,
    assembly: &Assembly,
    parts: &[Candidate],
    path: Option<&str>,
    name: Option<&str>,
    mesh: Option<&str>,
) -> Box<Error> {
    let fault = |key: &str, what: String| {
        let at = value.get(key).map_or(&value.at, |value| &value.at);
        Error::new(at.clone(), what).code(Code::SelectsNothing)
    };
    let names = || parts.iter().map(|part| part.name.as_str());
    if let Some(path) = path.filter(|path| !parts.iter().any(|part| part.has_path(path))) {
        if let Some(node) = assembly.nodes.iter().find(|node| node.path == path || node.name == path) {
            return fault("path", format!("path `{path}` is a node without geometry"))
                .expected(format!("a part; `{}/**` selects the parts below it", node.path));
        }
        let paths = parts.iter().flat_map(|part| [part.path.as_str()].into_iter().chain(part.short.as_deref()));
        return fault("path", format!("path `{path}` matches no part")).nearest(path, paths.chain(names()));
    }
    if let Some(name) = name.filter(|name| !parts.iter().any(|part| part.has_name(name))) {
        return fault("name", format!("name `{name}` matches no part")).nearest(name, names());
    }
    match mesh {
        Some(mesh) => {
            let meshes = assembly.meshes.iter().map(|source| source.mesh.name.as_str());
            fault("mesh", format!("mesh `{mesh}` matches no part")).nearest(mesh, meshes)
        }
        None => fault("", "no part matches both `path` and `name`".to_owned()),
    }
}
