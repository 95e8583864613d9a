//! Compressed geometry becomes plain: what `KHR_draco_mesh_compression` and `EXT_meshopt_compression` hold is decoded into
//! buffers of its own, and the document is changed to point at those. Everything after this reads one kind of file.

use super::at::At;
use super::buffers::Buffers;
use super::draco;
use super::features::{DRACO, MESHOPT, MESHOPT_KHR};
use super::meshopt;
use super::notes::{Budget, Ledger};
use eyebox_base::error::Result;
use serde_json::{Value as Json, json};
use std::path::Path;

/// A decoded block and what shall point at it.
enum Edit {
    View { index: usize, block: Block },
    Primitive { mesh: usize, primitive: usize, arrays: Vec<Array> },
}

/// Decoded bytes; `stride` of their elements, if they are attributes.
pub(super) struct Block {
    pub bytes: Vec<u8>,
    pub stride: Option<usize>,
}

/// A decoded array of a primitive: the attribute's name (none for the indices), its accessor's type, component type
/// and count.
pub(super) struct Array {
    pub name: Option<String>,
    pub kind: &'static str,
    pub component: u32,
    pub count: usize,
    pub bytes: Vec<u8>,
}

/// Decodes what has no uncompressed twin in the file. The decoded bytes are charged, and then allow for what is made of
/// them.
///
/// # Errors
/// A compressed stream that is broken, of a version that is not known, or larger than the file can honestly mean.
pub(super) fn decode(file: &Path, json: &mut Json, buffers: &mut Buffers<'_>, ledger: &mut Ledger) -> Result<()> {
    let mut edits = Vec::new();
    let root = At::root(file, json);
    for (index, view) in root.list("bufferViews")?.iter().enumerate() {
        let Some(name) = extension_of(view, &[MESHOPT, MESHOPT_KHR]) else { continue };
        let buffer = view.want("buffer")?.count()?;
        if buffers.data.get(buffer).is_some_and(Option::is_some) {
            continue; // the fallback is there
        }
        let extension = view.extension(name)?.ok_or_else(|| view.fault("a broken extension"))?;
        edits.push(Edit::View { index, block: meshopt::decode(&extension, buffers, &mut ledger.budget)? });
    }
    for (mesh, at) in root.list("meshes")?.iter().enumerate() {
        for (primitive, at) in at.list("primitives")?.iter().enumerate() {
            let Some(name) = extension_of(at, &[DRACO]) else { continue };
            if has_fallback(&root, at)? {
                continue;
            }
            let extension = at.extension(name)?.ok_or_else(|| at.fault("a broken extension"))?;
            let arrays = draco::decode(&root, at, &extension, buffers, ledger)?;
            edits.push(Edit::Primitive { mesh, primitive, arrays });
        }
    }
    drop(root);
    for edit in edits {
        apply(edit, json, buffers, &mut ledger.budget);
    }
    Ok(())
}

fn extension_of(at: &At<'_>, names: &[&'static str]) -> Option<&'static str> {
    let extensions = at.json.get("extensions")?;
    names.iter().copied().find(|name| extensions.get(name).is_some())
}

/// Whether the positions of a primitive are there uncompressed, too.
fn has_fallback(root: &At<'_>, primitive: &At<'_>) -> Result<bool> {
    let Some(reference) = primitive.want("attributes")?.get("POSITION")? else { return Ok(true) };
    let accessors = root.list("accessors")?;
    let index = reference.index(accessors.len(), "accessor")?;
    Ok(accessors.get(index).is_some_and(|accessor| accessor.json.get("bufferView").is_some()))
}

/// What can be made of decoded bytes, per byte of them: vertices and triangles are copied, compacted, mended.
const BYTES_PER_DECODED_BYTE: usize = 5;

fn apply(edit: Edit, json: &mut Json, buffers: &mut Buffers<'_>, budget: &mut Budget) {
    match edit {
        Edit::View { index, block } => {
            budget.grow(block.bytes.len().saturating_mul(BYTES_PER_DECODED_BYTE));
            let mut view = json!({ "byteLength": block.bytes.len() });
            if let Some(stride) = block.stride {
                view["byteStride"] = json!(stride);
            }
            view["buffer"] = json!(buffers.add(block.bytes));
            if let Some(slot) = json.get_mut("bufferViews").and_then(|views| views.get_mut(index)) {
                *slot = view;
            }
        }
        Edit::Primitive { mesh, primitive, arrays } => {
            for array in arrays {
                budget.grow(array.bytes.len().saturating_mul(BYTES_PER_DECODED_BYTE));
                let length = array.bytes.len();
                let buffer = buffers.add(array.bytes);
                let view = push(json, "bufferViews", json!({ "buffer": buffer, "byteLength": length }));
                let accessor = json!({
                    "bufferView": view, "componentType": array.component, "count": array.count, "type": array.kind,
                });
                let accessor = push(json, "accessors", accessor);
                let at = json.pointer_mut(&format!("/meshes/{mesh}/primitives/{primitive}"));
                let Some(Json::Object(at)) = at else { continue };
                at.insert("mode".to_owned(), json!(4));
                match (array.name, at.get_mut("attributes")) {
                    (Some(name), Some(Json::Object(attributes))) => {
                        attributes.insert(name, json!(accessor));
                    }
                    (Some(_), _) => {}
                    (None, _) => {
                        at.insert("indices".to_owned(), json!(accessor));
                    }
                }
            }
        }
    }
}

/// Appends to a root list, made if absent; its place.
fn push(json: &mut Json, list: &str, item: Json) -> usize {
    let Json::Object(root) = json else { return 0 };
    let list = root.entry(list).or_insert_with(|| json!([]));
    let Json::Array(items) = list else { return 0 };
    items.push(item);
    items.len() - 1
}
