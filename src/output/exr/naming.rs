//! How a frame's layers are called in a file, and which parts of it they are in. In a frame they have their own names:
//! a prefix is put before them on the way out and taken away on the way in, so that nobody else meets one.

use std::collections::BTreeMap;

use super::super::compare::is_data;
use eyebox_base::error::{Error, Result, Where};
use eyebox_film::cryptomatte::{KEYS, Matte, renamed};
use eyebox_film::exr::{LAYER_PREFIX, is_matte_name, is_word};
use eyebox_film::frame::{Frame, Meta, split_name};
use eyebox_film::names;

/// Metadata: 1 where pictures are to be stored as half floats.
pub const HALF: &str = "halfFloat";
/// Metadata: the name of a [`Packing`](super::packing::Packing).
pub const COMPRESSION: &str = "compression";
/// Metadata: 1 where every layer has a part of its own.
pub const MULTI_PART: &str = "multiPart";
/// The part of the default image.
const FIRST_PART: &str = "picture";

/// A prefix as an option says it. Errors: what cannot begin a layer's name.
pub fn parse_prefix(text: &str) -> Result<String, String> {
    if is_word(text) {
        return Ok(text.to_owned());
    }
    Err(format!("`{text}` cannot begin a layer's name; write a letter and then letters, digits or `_`, e.g. eb_"))
}

/// A channel as it is stored.
pub struct Stored<'f> {
    pub name: String,
    pub data: &'f [f32],
    /// Its numbers are no picture, whatever it is called in the file: a half would damage them.
    pub exact: bool,
}

/// A part of a file.
pub struct Part<'f> {
    /// None: the file has one part.
    pub name: Option<String>,
    /// By the bytes of their names, as EXR demands.
    pub channels: Vec<Stored<'f>>,
    /// No picture: its numbers are no colours.
    pub data: bool,
}

/// The parts of a frame: one, or the default image and then the layers by their names.
///
/// Errors: a prefix that cannot begin a name.
pub fn parts<'f>(frame: &'f Frame, at: &dyn Fn() -> Where) -> Result<Vec<Part<'f>>> {
    let prefix = frame.text(LAYER_PREFIX).unwrap_or_default();
    if !prefix.is_empty()
        && let Err(what) = parse_prefix(prefix)
    {
        return Err(Error::new(at(), what));
    }
    let several = frame.integer(MULTI_PART).is_some_and(|parts| parts != 0);
    let mut parts: BTreeMap<String, Part> = BTreeMap::new();
    for channel in &frame.channels {
        let (layer, component) = split_name(&channel.name);
        // `R`, `G`, `B` and `A` are the picture; a lone `Z` is a layer.
        let (name, own) = match (several, layer) {
            (false, _) => (String::new(), ""),
            (true, "") if ["R", "G", "B", "A"].contains(&component) => (String::new(), ""),
            (true, "") => (component.to_owned(), component),
            (true, layer) => (format!("{prefix}{layer}"), layer),
        };
        let part = parts.entry(name).or_insert_with_key(|name| Part {
            name: several.then(|| name.clone()),
            channels: Vec::new(),
            data: !own.is_empty() && (is_data(own) || frame.rgb(own).is_none()),
        });
        let name = if layer.is_empty() { channel.name.clone() } else { format!("{prefix}{}", channel.name) };
        let exact = is_data(layer) || names::is_error(layer) || Matte::of_layer(layer).is_some();
        part.channels.push(Stored { name, data: &channel.data, exact });
    }
    let mut first = FIRST_PART.to_owned();
    while parts.values().any(|part| part.name.as_ref() == Some(&first)) {
        first.push('_');
    }
    let mut parts: Vec<Part> = parts.into_values().collect();
    for part in &mut parts {
        part.channels.sort_by(|a, b| a.name.as_bytes().cmp(b.name.as_bytes()));
        part.name = part.name.take().map(|name| if name.is_empty() { first.clone() } else { name });
    }
    Ok(parts)
}

/// What an entry of the metadata is called in a file: a matte's attributes by the hash of its name, prefix included.
pub fn stored_key(frame: &Frame, key: &str) -> String {
    let prefix = frame.text(LAYER_PREFIX).filter(|prefix| !prefix.is_empty() && key.starts_with(KEYS));
    let renamed = prefix.and_then(|prefix| {
        let mut all = Matte::ALL.iter().map(|matte| matte.name());
        all.find_map(|name| renamed(key, name, &format!("{prefix}{name}")))
    });
    renamed.unwrap_or_else(|| key.to_owned())
}

/// A matte's name in the header is the name of its layers, prefix included.
pub fn stored_meta(frame: &Frame, key: &str, value: &Meta) -> Meta {
    match (frame.text(LAYER_PREFIX), value) {
        (Some(prefix), Meta::Text(name)) if is_matte_name(key) => Meta::Text(format!("{prefix}{name}")),
        (_, value) => value.clone(),
    }
}
