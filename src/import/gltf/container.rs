//! The two containers: `.gltf` is JSON text; `.glb` is a 12-byte header and chunks of length, type and bytes, the first
//! of them JSON, the second (if any) the first buffer (glTF 2.0, section 4.4). Told apart by their first bytes.

use super::notes::Notes;
use eyebox_base::{Error, Where, error::Result};
use eyebox_scene::Severity;
use serde_json::Value as Json;
use std::path::Path;

#[derive(Debug)]
pub(super) struct Container<'a> {
    pub json: Json,
    /// The binary chunk of a `.glb`.
    pub bin: Option<&'a [u8]>,
}

const MAGIC: &[u8] = b"glTF";
const JSON_CHUNK: u32 = 0x4E4F_534A;
const BIN_CHUNK: u32 = 0x004E_4942;
const BYTE_ORDER_MARK: &[u8] = &[0xEF, 0xBB, 0xBF];

/// Splits `bytes`, the content of `file`.
///
/// # Errors
/// A `.glb` that is cut short, of another container version, or without a JSON chunk; text that is not JSON.
pub(super) fn open<'a>(file: &Path, bytes: &'a [u8], notes: &mut Notes) -> Result<Container<'a>> {
    if bytes.is_empty() {
        return Err(Error::new(Where::file(file), "the file is empty").expected("a glTF 2.0 file"));
    }
    let (text, bin, is_glb) = match bytes.strip_prefix(MAGIC) {
        Some(_) => {
            let (text, bin) = chunks(file, bytes, notes)?;
            (text, bin, true)
        }
        None => (bytes, None, false),
    };
    let text = match text.strip_prefix(BYTE_ORDER_MARK) {
        Some(rest) => {
            notes.add_many(Severity::Info, Where::file(file), "the JSON starts with a byte order mark: ignored", 1);
            rest
        }
        None => text,
    };
    let json = serde_json::from_slice(text).map_err(|error| {
        let file = file.to_owned();
        let at = if is_glb { Where::File(file) } else { Where::Line { file, line: error.line() } };
        let what = if is_glb { "the JSON chunk is not valid JSON" } else { "not valid JSON (nor a .glb)" };
        Error::new(at, format!("{what}: {error}")).expected("a glTF 2.0 file")
    })?;
    Ok(Container { json, bin })
}

fn word(bytes: &[u8], offset: usize) -> Option<u32> {
    let word = bytes.get(offset..offset.checked_add(4)?)?;
    Some(u32::from_le_bytes(word.try_into().ok()?))
}

/// The JSON text and the binary chunk of a `.glb`.
fn chunks<'a>(file: &Path, bytes: &'a [u8], notes: &mut Notes) -> Result<(&'a [u8], Option<&'a [u8]>)> {
    let fault = |what: String| Error::new(Where::file(file), what);
    let short = || fault(format!("the .glb ends inside its header, after {} bytes", bytes.len()));
    let version = word(bytes, 4).ok_or_else(short)?;
    if version != 2 {
        return Err(fault(format!(".glb container version {version}")).expected("2"));
    }
    let length = word(bytes, 8).ok_or_else(short)? as usize;
    let Some(body) = bytes.get(..length) else {
        return Err(fault(format!("the .glb is cut short: it claims {length} bytes and has {}", bytes.len())));
    };
    if length < bytes.len() {
        let text = format!("{} bytes after the end of the .glb: ignored", bytes.len() - length);
        notes.add_many(Severity::Warning, Where::file(file), text, 1);
    }
    let (mut text, mut bin) = (None, None);
    let mut offset = 12;
    while offset < body.len() {
        let broken = |what: &str| fault(format!("the chunk at byte {offset} of the .glb {what}"));
        let size = word(body, offset).ok_or_else(|| broken("is cut short"))? as usize;
        let kind = word(body, offset + 4).ok_or_else(|| broken("is cut short"))?;
        let start = offset + 8;
        let end = start.checked_add(size).filter(|&end| end <= body.len());
        let end = end.ok_or_else(|| broken(&format!("claims {size} bytes, past the end of the file")))?;
        let content = body.get(start..end).ok_or_else(|| broken("is cut short"))?;
        match (kind, text.is_some()) {
            (JSON_CHUNK, false) => text = Some(content),
            (_, false) => return Err(broken("is not JSON").expected("JSON in the first chunk")),
            (BIN_CHUNK, true) if bin.is_none() => bin = Some(content),
            // The specification tells readers to skip chunks that they do not know.
            (_, true) => {}
        }
        offset = end;
    }
    Ok((text.ok_or_else(|| fault("the .glb has no JSON chunk".to_owned()))?, bin))
}
