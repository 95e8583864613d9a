//! EXR → frame. The file is not trusted: sizes are checked against the file's length before anything is allocated.

mod b44;
mod luminance_chroma;
mod subsampled;

use std::collections::HashSet;
use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use ::exr::block::UncompressedBlock;
use ::exr::block::chunk::Chunk;
use ::exr::block::lines::LineIndex;
use ::exr::block::reader::ChunksReader;
use ::exr::meta::attribute::{AttributeValue, EnvironmentMap, SampleType, Text};
use ::exr::meta::header::Header;
use ::exr::prelude::{Vec2, f16};
use rayon::prelude::*;

use super::colours;
pub use super::colours::{CHROMATICITIES, COLOR_INTEROP_ID};
use super::crop::Window;
use super::cryptomatte;
use super::frame::{Channel, Frame, Meta, split_name};
use eyebox_base::colour::Chromaticities;
use eyebox_base::error::{Error, Result, Where};
use subsampled::Sampling;

/// cd/m² of the value (1, 1, 1).
pub const WHITE_LUMINANCE: &str = "whiteLuminance";
/// Every other metadata entry `key` is the attribute `eyebox.key`, less those of Cryptomatte.
pub const PREFIX: &str = "eyebox.";
/// Metadata: what stands before the name of every layer in the file but the default image.
pub const LAYER_PREFIX: &str = "layerPrefix";
/// No file is refused below this many decoded bytes, however short it is.
const ALWAYS_ALLOWED: usize = 1 << 28;
/// Deflate cannot expand more than 1032-fold (zlib, "Technical Details"); a header that claims more is not believed.
const EXPANSION: usize = 1100;
/// Chunks decoded at the same time.
const BATCH: usize = 16;

/// Reads any flat EXR (scan lines or tiles, one or several parts, float, half or 32-bit integer samples, any lossless
/// or lossy compression of the format) into a frame; of mip maps the largest level. The frame is the data window. Channels with
/// fewer samples are filled in between them, and luminance with chroma (Y, RY, BY) becomes red, green and blue.
///
/// A channel without a dot in the second or a later part gets the part's name as its layer, unless it is called so itself.
/// The prefix that `eyebox.layerPrefix` names is taken from the layers' names. Integer samples become
/// the nearest f32. Metadata as written by `output::exr::write_exr`: `colorInteropID`, `whiteLuminance`,
/// `cryptomatte/…` and what stands under `eyebox.`, without the prefix; other attributes are not kept.
///
/// Errors: not a readable file, not EXR, deep data, parts of different sizes, missing or damaged chunks,
/// a picture larger than the file could hold.
pub fn read_exr(path: &Path) -> Result<Frame> {
    let at = || Where::file(path);
    let unreadable = |error: std::io::Error| Error::new(at(), format!("cannot be read: {error}"));
    if !std::fs::metadata(path).map_err(unreadable)?.is_file() {
        return Err(Error::new(at(), "is not a file").expected("an EXR file"));
    }
    let bytes = std::fs::read(path).map_err(unreadable)?;
    decode(&bytes).map_err(|what| Error::new(at(), what).expected("a complete flat EXR file"))
}

/// Whether these bytes begin an OpenEXR file.
pub fn is_exr(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01])
}

/// What a file says of its picture as a whole.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct About {
    /// Left, top, width and height of the display window, in pixels from the top left of the data window, which is the frame.
    pub display: [i64; 4],
    pub chromaticities: Option<Chromaticities>,
    /// Its attribute `envmap`: six faces below each other.
    pub is_cube: bool,
}

impl About {
    /// Where a frame of this size lies, if it is not the whole picture.
    fn window(&self, size: [usize; 2]) -> Option<Window> {
        let [left, top, width, height] = self.display;
        let [Ok(width), Ok(height)] = [width, height].map(usize::try_from) else { return None };
        let [Ok(x), Ok(y)] = [left, top].map(|at| i32::try_from(at.saturating_neg())) else { return None };
        let whole = [x, y] == [0, 0] && [width, height] == size;
        (!whole).then_some(Window { corner: [x, y], picture: [width, height] })
    }
}

/// The frame in these bytes, or what is wrong with them.
pub fn decode(bytes: &[u8]) -> Result<Frame, String> {
    decode_all(bytes).map(|(frame, _)| frame)
}

/// The same with what the file says of it.
pub fn decode_all(bytes: &[u8]) -> Result<(Frame, About), String> {
    // The decoder checks what it reads, but its own assertions are not ours to rely on: a file must not end the program.
    catch_unwind(AssertUnwindSafe(|| decode_trusting(bytes)))
        .unwrap_or_else(|_| Err("the EXR decoder stumbled over damaged contents".into()))
}

fn about(header: &Header) -> About {
    let shared = &header.shared_attributes;
    let (window, data) = (shared.display_window, header.own_attributes.layer_position);
    let from = |display: i32, data: i32| i64::from(display) - i64::from(data);
    let display = [
        from(window.position.0, data.0),
        from(window.position.1, data.1),
        i64::try_from(window.size.0).unwrap_or(i64::MAX),
        i64::try_from(window.size.1).unwrap_or(i64::MAX),
    ];
    let chromaticities = shared
        .chromaticities
        .map(|all| [all.red, all.green, all.blue, all.white].map(|Vec2(x, y)| [f64::from(x), f64::from(y)]));
    let is_cube = header.own_attributes.environment_map == Some(EnvironmentMap::Cube);
    About { display, chromaticities, is_cube }
}

fn said(error: ::exr::error::Error) -> String {
    format!("cannot be read as EXR: {error}")
}

fn decode_trusting(bytes: &[u8]) -> Result<(Frame, About), String> {
    let (bytes, sampling) = Sampling::taken_out(bytes);
    let reader = ::exr::block::read(Cursor::new(&bytes), false).map_err(said)?;
    let size = check_sizes(reader.headers(), bytes.len())?;
    let mut frame = Frame::new(size.0, size.1);
    let about = reader.headers().first().map(about).unwrap_or_default();
    frame.window = about.window([size.0, size.1]);
    let channels = reader.headers().iter().flat_map(|header| &header.channels.list);
    let half = channels.into_iter().any(|channel| channel.sample_type == SampleType::F16);
    frame.half = half || reader.headers().iter().any(|header| header.compression.may_loose_data());
    frame.meta = reader.headers().first().into_iter().flat_map(metadata).collect();
    let pixels = size.area();
    // The frame's channels are the parts' channels one after the other.
    let (mut first_of_part, mut names) = (Vec::new(), HashSet::new());
    for (part, header) in reader.headers().iter().enumerate() {
        first_of_part.push(frame.channels.len());
        let part_name = header.own_attributes.layer_name.as_ref().map(string).unwrap_or_default();
        for channel in &header.channels.list {
            let name = channel_name(&mut names, part, &part_name, &string(&channel.name))?;
            frame.channels.push(Channel { name, data: vec![0.0; pixels].into() });
        }
    }

    let largest = Vec2(0, 0);
    let mut chunks = reader.filter_chunks(false, |_, tile, _| tile.level_index == largest).map_err(said)?;
    let mut seen = HashSet::new();
    let mut covered = vec![0_usize; first_of_part.len()];
    loop {
        let batch: Vec<Chunk> = chunks.by_ref().take(BATCH).collect::<Result<_, _>>().map_err(said)?;
        if batch.is_empty() {
            break;
        }
        let meta = chunks.meta_data();
        let blocks: Vec<UncompressedBlock> = batch
            .into_par_iter()
            .map(|chunk| sampling.decompress(chunk, meta))
            .collect::<Result<_, _>>()
            .map_err(said)?;
        for block in blocks {
            let index = block.index;
            // A killed writer leaves offsets of 0, damage points two offsets at one chunk: both show here.
            if index.level != largest || !seen.insert((index.layer, index.pixel_position.0, index.pixel_position.1)) {
                return Err("a part of the picture is stored twice, another is missing".into());
            }
            let stored = match (meta.headers.get(index.layer), first_of_part.get(index.layer)) {
                (Some(header), Some(first)) if sampling.concerns(index.layer) => {
                    sampling.store(&mut frame, &header.channels, *first, &block)
                }
                _ => store(&mut frame, &meta.headers, &first_of_part, &block),
            };
            stored.ok_or("a chunk does not fit the picture")?;
            if let Some(covered) = covered.get_mut(index.layer) {
                *covered += index.pixel_size.area();
            }
        }
    }
    if covered.iter().any(|covered| *covered != pixels) {
        return Err("a part of the picture is missing".into());
    }
    sampling.spread(&mut frame, &first_of_part);
    without_prefix(&mut frame);
    luminance_chroma::to_rgb(&mut frame, about.chromaticities.as_ref());
    if let Some(own) = &about.chromaticities {
        colours::keep(&mut frame, own);
    }
    Ok((frame, about))
}

/// The common size of all parts, if the file can hold as much as its headers claim.
fn check_sizes(headers: &[Header], length: usize) -> Result<Vec2<usize>, String> {
    let size = headers.first().ok_or("has no part")?.layer_size;
    let (mut decoded, mut chunks) = (Some(0_usize), Some(0_usize));
    for header in headers {
        if header.layer_size != size {
            return Err(format!(
                "has parts of different sizes, {} × {} and {} × {} pixels",
                size.0, size.1, header.layer_size.0, header.layer_size.1
            ));
        }
        let part = size.0.checked_mul(size.1).and_then(|area| area.checked_mul(header.channels.bytes_per_pixel));
        decoded = decoded.zip(part).and_then(|(sum, part)| sum.checked_add(part));
        chunks = chunks.and_then(|sum| sum.checked_add(header.chunk_count));
    }
    let limit = length.saturating_mul(EXPANSION).max(ALWAYS_ALLOWED);
    let table_fits =
        chunks.and_then(|chunks| chunks.checked_mul(size_of::<u64>())).is_some_and(|table| table <= length);
    if size.0 == 0 || size.1 == 0 || !table_fits || decoded.is_none_or(|decoded| decoded > limit) {
        return Err(format!("claims {} × {} pixels, which its {length} bytes cannot hold", size.0, size.1));
    }
    Ok(size)
}

/// The channel's name in the frame, entered into `names`.
fn channel_name(names: &mut HashSet<String>, part: usize, part_name: &str, name: &str) -> Result<String, String> {
    let long = format!("{part_name}.{name}");
    // A lone channel in the part of its name is a layer without components: `Z`.
    let bare = part > 0 && !part_name.is_empty() && !name.contains('.') && name != part_name;
    let short = if bare { long.clone() } else { name.to_owned() };
    if names.insert(short.clone()) {
        return Ok(short);
    }
    // Stereo pairs repeat all names in both parts.
    if part_name.is_empty() || !names.insert(long.clone()) {
        return Err(format!("has the channel `{short}` twice"));
    }
    Ok(long)
}

/// Copies the block's lines into the frame; `None` if a line lies outside it.
fn store(frame: &mut Frame, headers: &[Header], first_of_part: &[usize], block: &UncompressedBlock) -> Option<()> {
    let channels = &headers.get(block.index.layer)?.channels;
    let first = *first_of_part.get(block.index.layer)?;
    for (range, line) in LineIndex::lines_in_block(block.index, channels) {
        let Vec2(x, y) = line.position;
        let bytes = block.data.get(range)?;
        if x.checked_add(line.sample_count)? > frame.width {
            return None;
        }
        let start = y.checked_mul(frame.width)?.checked_add(x)?;
        let channel = frame.channels.get_mut(first.checked_add(line.channel)?)?;
        let to = channel.data.get_mut(start..start.checked_add(line.sample_count)?)?;
        copy_samples(to, bytes, channels.list.get(line.channel)?.sample_type);
    }
    Some(())
}

fn copy_samples(to: &mut [f32], bytes: &[u8], kind: SampleType) {
    // The decoder hands out samples in the machine's byte order.
    match kind {
        SampleType::F32 => copy(to, bytes, f32::from_ne_bytes),
        SampleType::F16 => copy(to, bytes, |raw| f16::from_ne_bytes(raw).to_f32()),
        SampleType::U32 => copy(to, bytes, |raw| u32::from_ne_bytes(raw) as f32),
    }
}

fn copy<const N: usize>(to: &mut [f32], bytes: &[u8], sample: impl Fn([u8; N]) -> f32) {
    let (raw, _) = bytes.as_chunks::<N>();
    for (to, raw) in to.iter_mut().zip(raw) {
        *to = sample(*raw);
    }
}

fn metadata(header: &Header) -> Vec<(String, Meta)> {
    let own = &header.own_attributes;
    let white = own.white_luminance.map(|white| (WHITE_LUMINANCE.to_owned(), Meta::Number(f64::from(white))));
    let others = own.other.iter().chain(&header.shared_attributes.other).filter_map(|(name, value)| {
        let name = string(name);
        let own_name = name == COLOR_INTEROP_ID || name.starts_with(cryptomatte::KEYS);
        let key = if own_name { &name } else { name.strip_prefix(PREFIX)? };
        Some((key.to_owned(), meta(value)?))
    });
    white.into_iter().chain(others).collect()
}

/// The attribute types that `write_exr` uses, and `float`, which other programs write.
fn meta(value: &AttributeValue) -> Option<Meta> {
    if let AttributeValue::Text(text) = value {
        Some(Meta::Text(string(text)))
    } else if let AttributeValue::F64(number) = value {
        Some(Meta::Number(*number))
    } else if let AttributeValue::F32(number) = value {
        Some(Meta::Number(f64::from(*number)))
    } else if let AttributeValue::I32(integer) = value {
        Some(Meta::Integer(i64::from(*integer)))
    } else {
        None
    }
}

fn string(text: &Text) -> String {
    String::from_utf8_lossy(text.as_slice()).into_owned()
}

/// Whether Nuke and Blender take it for a layer's name.
pub fn is_word(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_alphabetic()) && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

/// Whether a header's entry is a matte's name.
pub fn is_matte_name(key: &str) -> bool {
    key.starts_with(cryptomatte::KEYS) && key.ends_with("/name")
}

/// Takes the prefix that the header names from the names of layers that begin with it. A name that would come twice
/// keeps it.
pub fn without_prefix(frame: &mut Frame) {
    let Some(prefix) = frame.text(LAYER_PREFIX).filter(|prefix| is_word(prefix)).map(str::to_owned) else { return };
    let mut names: HashSet<String> = frame.channels.iter().map(|channel| channel.name.clone()).collect();
    for channel in frame.channels.iter_mut().filter(|channel| channel.name.contains('.')) {
        let Some(own) = channel.name.strip_prefix(&prefix) else { continue };
        if is_word(split_name(own).0) && names.insert(own.to_owned()) {
            channel.name = own.to_owned();
        }
    }
    let mut mattes = Vec::new();
    for (_, value) in frame.meta.iter_mut().filter(|(key, _)| is_matte_name(key)) {
        if let Meta::Text(name) = value
            && let Some(own) = name.strip_prefix(&prefix).map(str::to_owned)
        {
            mattes.push((std::mem::replace(name, own.clone()), own));
        }
    }
    // Attributes of a matte go by the hash of its name.
    for (stored, own) in &mattes {
        let old: Vec<String> = frame.meta.keys().filter(|key| key.starts_with(cryptomatte::KEYS)).cloned().collect();
        for (old, new) in old.iter().filter_map(|key| Some((key, cryptomatte::renamed(key, stored, own)?))) {
            if let Some(value) = frame.meta.remove(old) {
                frame.meta.insert(new, value);
            }
        }
    }
}
