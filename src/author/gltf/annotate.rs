//! Rows put into a copy of a glTF asset. The JSON text is edited in place, so that order, white space and the texts of
//! numbers stay; the other chunks of a `.glb` are copied.

use super::super::Written;
use super::splice::{Span, Splice};
use super::uri;
use super::value::{self, OPTICS};
use eyebox_base::atomic::write_atomic;
use eyebox_base::error::Result;
use eyebox_base::relative_path::folder_of;
use eyebox_base::{Error, Where};
use eyebox_scene::annotation::Annotation;
use eyebox_scene::assembly::Assembly;
use eyebox_scene::value::Value;
use serde_json::Value as Json;
use std::collections::BTreeMap;
use std::path::Path;

/// Writes a copy of `assembly.file` with the rows of `annotation`. Buffers and images stay where they are: their URIs
/// are rewritten if `out` is in another folder.
///
/// Faults: `out` is of the other container; the asset changed since it was read; instances of one
/// `EXT_mesh_gpu_instancing` with different rows.
pub fn annotate(assembly: &Assembly, annotation: &Annotation, out: &Path) -> Result<Written> {
    let file = &assembly.file;
    let fault = |what: String| Error::new(Where::file(file), what);
    let bytes = std::fs::read(file).map_err(|error| fault(format!("cannot read the asset: {error}")))?;
    let binary = bytes.starts_with(b"glTF");
    let asked = out.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("glb"));
    if binary != asked {
        let expected = if binary { "a name that ends in .glb" } else { "a name that ends in .gltf" };
        let what = "an annotated copy has the container of its asset; `eyebox convert` changes it";
        return Err(Error::new(Where::file(out), what).expected(expected));
    }
    let changed = || fault("the asset is not what it was when it was read".into());
    let range = if binary { chunk(&bytes).ok_or_else(changed)? } else { 0..bytes.len() };
    let content = bytes.get(range.clone()).ok_or_else(changed)?;
    let mark = content.strip_prefix("\u{feff}".as_bytes()).map_or(0, |_| 3);
    let text = std::str::from_utf8(content.get(mark..).unwrap_or_default()).map_err(|_| changed())?;
    let document: Json = serde_json::from_str(text).map_err(|_| changed())?;
    let edited = edited(text, &document, assembly, annotation, out)?;
    let bytes = if edited == text {
        bytes
    } else {
        let new = [content.get(..mark).unwrap_or_default(), edited.as_bytes()].concat();
        if binary {
            replaced(&bytes, range, new).ok_or_else(|| fault("the copy is larger than 4 GiB".into()))?
        } else {
            new
        }
    };
    write_atomic(out, &bytes)?;
    Ok(Written { files: vec![out.to_owned()], notes: Vec::new() })
}

/// The bytes of the JSON chunk.
fn chunk(bytes: &[u8]) -> Option<std::ops::Range<usize>> {
    let size = u32::from_le_bytes(bytes.get(12..16)?.try_into().ok()?) as usize;
    let end = 20usize.checked_add(size)?;
    (end <= bytes.len() && bytes.get(16..20)? == b"JSON").then_some(20..end)
}

/// The container with another JSON chunk.
fn replaced(bytes: &[u8], range: std::ops::Range<usize>, json: Vec<u8>) -> Option<Vec<u8>> {
    let mut json = json;
    while json.last() == Some(&b' ') {
        json.pop();
    }
    // Chunks end on multiples of four bytes, JSON is padded with spaces (glTF 2.0, section 4.4.3).
    json.resize(json.len().next_multiple_of(4), b' ');
    let length = u32::from_le_bytes(bytes.get(8..12)?.try_into().ok()?) as usize;
    let length = length.checked_sub(range.len())?.checked_add(json.len())?;
    let mut out = bytes.get(..8)?.to_vec();
    out.extend(u32::try_from(length).ok()?.to_le_bytes());
    out.extend(u32::try_from(json.len()).ok()?.to_le_bytes());
    out.extend(bytes.get(16..20)?);
    out.extend(json);
    out.extend(bytes.get(range.end..)?);
    Some(out)
}

/// The JSON text with the rows, and with URIs that lead to the same files from the folder of `out`.
fn edited(text: &str, document: &Json, assembly: &Assembly, annotation: &Annotation, out: &Path) -> Result<String> {
    let mut splice = Splice::new(text);
    let broken = || Error::new(Where::file(&assembly.file), "the JSON can't be edited");
    let root = splice.document().ok_or_else(broken)?;
    let prefix = uri::prefix(&folder_of(&assembly.file), &folder_of(out));
    if !prefix.is_empty() {
        uris(&mut splice, &root, &prefix);
    }
    let places = Places::new(&splice, &root);
    for (place, value) in rows(assembly, annotation)? {
        let Some(span) = places.find(&splice, place) else { return Err(broken()) };
        put(&mut splice, &span, &value::json(value)?.to_string());
    }
    let named = document.get("extensionsUsed").and_then(Json::as_array);
    if !annotation.is_empty() && !named.is_some_and(|names| names.iter().any(|name| name == OPTICS)) {
        match splice.entry(&root, "extensionsUsed") {
            Some(list) => splice.add_element(&list, &format!("\"{OPTICS}\"")),
            None => splice.add_entry(&root, "extensionsUsed", &format!("[\"{OPTICS}\"]")),
        }
    }
    Ok(splice.finish())
}

/// Which object gets which row: list, index in it, primitive.
type Place = (&'static str, usize, Option<usize>);

/// The rows by their places. Faults: an object that would need two.
fn rows<'a>(assembly: &Assembly, annotation: &'a Annotation) -> Result<Vec<(Place, &'a Value)>> {
    let lost = |at: &Where| Error::new(at.clone(), "this stands nowhere in the asset's JSON");
    let mut all: Vec<(Place, &Value)> = Vec::new();
    if let Some(root) = &annotation.root {
        all.push((("", 0, None), root));
    }
    let mut nodes: BTreeMap<usize, &Value> = BTreeMap::new();
    for (index, value) in &annotation.nodes {
        let Some(node) = assembly.nodes.get(*index) else { continue };
        let place = index_of(&node.at, "nodes").ok_or_else(|| lost(&node.at))?;
        if nodes.insert(place, value).is_some_and(|other| !other.same(value)) {
            return Err(instances(&node.at));
        }
    }
    for (index, node) in assembly.nodes.iter().enumerate().filter(|(_, node)| node.mesh.is_some()) {
        // The instances of one node, those without a new row among them.
        let Some(value) = index_of(&node.at, "nodes").and_then(|place| nodes.get(&place)) else { continue };
        let new = annotation.nodes.iter().any(|(own, _)| *own == index);
        if !new && !node.attributes.as_ref().is_some_and(|own| own.same(value)) {
            return Err(instances(&node.at));
        }
    }
    all.extend(nodes.into_iter().map(|(index, value)| (("nodes", index, None), value)));
    for (index, value) in &annotation.materials {
        let Some(material) = assembly.materials.get(*index) else { continue };
        let place = index_of(&material.at, "materials").ok_or_else(|| lost(&material.at))?;
        all.push((("materials", place, None), value));
    }
    for (mesh, face, value) in &annotation.faces {
        let Some(mesh) = assembly.meshes.get(*mesh) else { continue };
        let place = index_of(&mesh.at, "meshes").ok_or_else(|| lost(&mesh.at))?;
        all.push((("meshes", place, Some(*face)), value));
    }
    Ok(all)
}

fn instances(at: &Where) -> Box<Error> {
    Error::new(at.clone(), "the instances of this node get different attributes, which one node can't say")
        .expected("`eyebox convert`, which makes a node of each instance")
}

/// N of the pointer `/LIST/N`.
fn index_of(at: &Where, list: &str) -> Option<usize> {
    match at {
        Where::Pointer { pointer, .. } => {
            pointer.strip_prefix('/')?.strip_prefix(list)?.strip_prefix('/')?.parse().ok()
        }
        Where::Nowhere
        | Where::File(_)
        | Where::Line { .. }
        | Where::Prim { .. }
        | Where::Part { .. }
        | Where::Option(_) => None,
    }
}

/// Where the objects of the lists stand, found once.
struct Places {
    root: Span,
    lists: [(&'static str, Vec<Span>); 3],
}

impl Places {
    fn new(splice: &Splice<'_>, root: &Span) -> Self {
        let list = |name| (name, splice.entry(root, name).map_or(Vec::new(), |span| splice.elements(&span)));
        Places { root: root.clone(), lists: ["nodes", "materials", "meshes"].map(list) }
    }
    fn find(&self, splice: &Splice<'_>, (list, index, primitive): Place) -> Option<Span> {
        if list.is_empty() {
            return Some(self.root.clone());
        }
        let object = self.lists.iter().find(|(name, _)| *name == list)?.1.get(index)?.clone();
        match primitive {
            None => Some(object),
            Some(primitive) => splice.elements(&splice.entry(&object, "primitives")?).get(primitive).cloned(),
        }
    }
}

/// Puts the row into the extensions of the object at `span`.
fn put(splice: &mut Splice<'_>, span: &Span, json: &str) {
    match splice.entry(span, "extensions") {
        None => splice.add_entry(span, "extensions", &format!("{{\"{OPTICS}\":{json}}}")),
        Some(extensions) => match splice.entry(&extensions, OPTICS) {
            Some(old) => splice.replace(old, json.to_owned()),
            None => splice.add_entry(&extensions, OPTICS, json),
        },
    }
}

/// Rewrites the URIs of buffers, images and profiles, wherever they stand but in `extras` and in our rows (whose file
/// names are rewritten already).
fn uris(splice: &mut Splice<'_>, span: &Span, prefix: &str) {
    let mut stack = vec![span.clone()];
    let mut edits = Vec::new();
    while let Some(span) = stack.pop() {
        stack.extend(splice.elements(&span));
        for (key, value) in splice.entries(&span) {
            if key == "extras" || key == OPTICS {
                continue;
            }
            let text: Option<String> = if key == "uri" { serde_json::from_str(splice.text(&value)).ok() } else { None };
            match text {
                Some(text) if uri::is_relative(&text) => {
                    edits.push((value, Json::from(format!("{prefix}{text}")).to_string()));
                }
                Some(_) => {}
                None => stack.push(value),
            }
        }
    }
    for (span, json) in edits {
        splice.replace(span, json);
    }
}
