//! Frame → EXR.

use std::collections::HashMap;
use std::fs::File;
use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::Path;

use ::exr::block::UncompressedBlock;
use ::exr::block::writer::ChunksWriter;
use ::exr::meta::BlockDescription;
use ::exr::meta::attribute::{
    AttributeValue, ChannelDescription, Chromaticities, IntegerBounds, LineOrder, SampleType, Text,
};
use ::exr::meta::header::{Header, ImageAttributes, LayerAttributes};
use ::exr::prelude::{Vec2, f16};

use super::naming::{self, Part, Stored};
use super::packing::{sample_type, too_bright};
use super::{COLOR_INTEROP_ID, COMPRESSION, DATA, LAYER_PREFIX, PREFIX, Packing, WHITE_LUMINANCE, camera, header};
use eyebox_base::atomic::write_atomic_by;
use eyebox_base::error::{Error, Result, Where};
use eyebox_film::colours::{self, Colours};
use eyebox_film::crop::Window;
use eyebox_film::exr::{CHROMATICITIES, is_word};
use eyebox_film::frame::{Frame, Meta, split_name};
use eyebox_film::{cryptomatte, names};

/// Nuke stops at 1023 channels and slows down long before (`design/layers.md`).
const MANY_CHANNELS: usize = 500;
/// Longest name of a channel or an attribute in EXR, bytes.
const LONGEST_NAME: usize = 255;
/// Names beyond this many bytes need the file's long-name flag.
const SHORT_NAME: usize = 31;

/// Writes the frame: one part, 32-bit float, ZIP, scan lines in increasing order, the same bytes for the same frame.
///
/// With the metadata `multiPart` = 1 every layer has a part of its own that is called as the layer, the default image the
/// first; channels keep their whole names, and all metadata is in the first part. `layerPrefix` stands before the names of
/// all layers but the default image in the file ([`read_exr`](super::read_exr) takes it away).
///
/// Metadata: `colorInteropID` (text, default `lin_rec709_scene`) and `whiteLuminance` (number, default 1: values are
/// cd/m²) and Cryptomatte's (`cryptomatte/…`) under their own names, every other entry `key` as `eyebox.key`: text as `string`, numbers as `double`,
/// integers as `int`, or as `string` when they need more than 32 bits ([`Frame::integer`] reads both back).
/// Where the metadata tell of an `eye`, `worldToCamera` and `worldToNDC` say where it was, as OpenEXR defines them (`camera.rs`).
/// `halfFloat` = 1 stores pictures as halves where these hold them, and `compression` names a [`Packing`].
///
/// Returns [`warnings`].
///
/// Errors, before anything is written: a channel name that Nuke and Blender would not split alike, a name twice, data
/// of another size than the frame, a value that is not finite (with its channel and pixel). On any error, the file
/// system's included, no file is left behind and an older file at `path` stays as it was.
pub fn write_exr(path: &Path, frame: &Frame) -> Result<Vec<String>> {
    let at = || Where::file(path);
    let parts = naming::parts(frame, &at)?;
    check_channels(frame, &parts, &at)?;
    let attributes = attributes(frame, &at)?;
    let names = parts.iter().flat_map(|part| &part.channels).map(|channel| channel.name.len());
    let long_names = names.chain(attributes.keys().map(|name| name.len())).any(|length| length > SHORT_NAME);
    write_atomic_by(path, |file| {
        // Piece by piece into the file: the bytes of a large picture need not be in memory as well.
        let mut buffered = BufWriter::new(&mut *file);
        encode(&mut buffered, frame, &parts, &attributes).map_err(|error| match error {
            ::exr::error::Error::Io(error) => error,
            ::exr::error::Error::Aborted | ::exr::error::Error::NotSupported(_) | ::exr::error::Error::Invalid(_) => {
                io::Error::other(format!("it cannot be encoded as EXR: {error}"))
            }
        })?;
        buffered.flush()?;
        drop(buffered);
        put_in_order(file, long_names)
    })?;
    let bright = too_bright(frame, &parts).into_iter().map(|layer| {
        let name = if layer.is_empty() { "the default image".to_owned() } else { format!("the layer `{layer}`") };
        format!("{name} is brighter than half floats hold (65504): it has whole ones")
    });
    Ok(warnings(frame).into_iter().chain(bright).collect())
}

/// Puts the headers at the beginning of a file in order.
fn put_in_order(file: &mut File, long_names: bool) -> io::Result<()> {
    let length = file.metadata()?.len();
    // How long they are is known only when they have been read.
    let mut most = 1 << 16;
    loop {
        let mut bytes = Vec::new();
        file.seek(SeekFrom::Start(0))?;
        Read::by_ref(file).take(most).read_to_end(&mut bytes)?;
        let sorted = header::sort_attributes(&mut bytes)
            .and_then(|()| if long_names { header::set_long_names(&mut bytes) } else { Some(()) });
        if sorted.is_some() {
            file.seek(SeekFrom::Start(0))?;
            return file.write_all(&bytes);
        }
        if most >= length {
            return Err(io::Error::other("the EXR encoder made a header that cannot be put in order"));
        }
        most *= 2;
    }
}

/// What may trouble a reader although the file is right.
pub fn warnings(frame: &Frame) -> Vec<String> {
    let count = frame.channels.len();
    if count <= MANY_CHANNELS {
        return Vec::new();
    }
    vec![format!(
        "{count} channels; Nuke stops at 1023 and slows down above {MANY_CHANNELS}: ask for fewer layers or light groups"
    )]
}

fn check_channels(frame: &Frame, parts: &[Part], at: &dyn Fn() -> Where) -> Result<()> {
    let pixels = frame.width.checked_mul(frame.height).filter(|pixels| *pixels > 0).ok_or_else(|| {
        Error::new(at(), format!("a frame of {} × {} pixels cannot be written", frame.width, frame.height))
            .expected("at least one pixel")
    })?;
    if let (Some(packing), [Part { name: None, .. }]) = (packing_of(frame), parts) {
        packing.spares_data(false).map_err(|text| Error::new(at(), text).expected("--multi-part with it"))?;
    }
    if parts.is_empty() {
        return Err(Error::new(at(), "the frame has no channel").expected("at least one"));
    }
    for part in parts {
        for pair in part.channels.windows(2) {
            if let [first, second] = pair
                && first.name == second.name
            {
                return Err(Error::new(at(), format!("channel `{}` is there twice", first.name)));
            }
        }
    }
    for Stored { name, data, .. } in parts.iter().flat_map(|part| &part.channels) {
        check_name(name, at)?;
        if data.len() != pixels {
            return Err(Error::new(at(), format!("channel `{name}` has {} values", data.len()))
                .expected(format!("{} × {} = {pixels}", frame.width, frame.height)));
        }
        let layer = own_layer(frame, name);
        let bad = |(_, value): &(usize, &f32)| !names::may_hold(layer, **value);
        if let Some((index, value)) = data.iter().enumerate().find(bad) {
            let (x, y) = (index % frame.width, index / frame.width);
            return Err(Error::new(at(), format!("channel `{name}` is {value} at pixel ({x}, {y})"))
                .expected("a finite value (0 where a ray hits nothing)"));
        }
    }
    Ok(())
}

/// The compression that a frame asks for.
fn packing_of(frame: &Frame) -> Option<Packing> {
    frame.text(COMPRESSION).and_then(|name| Packing::parse(name).ok())
}

/// The layer of a stored channel, without the prefix of the file.
fn own_layer<'n>(frame: &Frame, name: &'n str) -> &'n str {
    let layer = split_name(name).0;
    layer.strip_prefix(frame.text(LAYER_PREFIX).unwrap_or_default()).unwrap_or(layer)
}

/// Nuke and Blender split names at different dots, so there is at most one; what stands before it must be a name that
/// both accept (`design/layers.md`).
fn check_name(name: &str, at: &dyn Fn() -> Where) -> Result<()> {
    let good = match name.split_once('.') {
        Some((layer, component)) => is_word(layer) && is_word(component),
        None => is_word(name),
    };
    if good && name.len() <= LONGEST_NAME {
        return Ok(());
    }
    Err(Error::new(at(), format!("`{name}` cannot name a channel")).expected(format!(
        "`layer.component` or `component`, each a letter and then letters, digits or `_`, at most {LONGEST_NAME} in all"
    )))
}

fn attributes(frame: &Frame, at: &dyn Fn() -> Where) -> Result<HashMap<String, AttributeValue>> {
    let mut attributes = HashMap::new();
    match Colours::of(frame) {
        Colours::Own(space) => {
            attributes.insert(COLOR_INTEROP_ID.to_owned(), AttributeValue::Text(text(space.interop_id())));
        }
        // Its own name, if it has one, or its primaries.
        Colours::Foreign(_) => {}
    }
    for (key, value) in &frame.meta {
        // A typed field of the header, too.
        if key == CHROMATICITIES {
            continue;
        }
        if key == WHITE_LUMINANCE {
            // A typed field of the header, see `encode`.
            if frame.number(key).is_none_or(|number| !(number > 0.0 && number.is_finite())) {
                return Err(Error::new(at(), format!("`{key}` is {value:?}")).expected("a positive number, cd/m²"));
            }
            continue;
        }
        let own_name = key == COLOR_INTEROP_ID || key.starts_with(cryptomatte::KEYS);
        let name = if own_name { naming::stored_key(frame, key) } else { format!("{PREFIX}{key}") };
        if key.is_empty() || name.len() > LONGEST_NAME || !name.bytes().all(|byte| byte.is_ascii_graphic()) {
            return Err(Error::new(at(), format!("`{key}` cannot name an attribute"))
                .expected(format!("1 to {} visible ASCII characters without spaces", LONGEST_NAME - PREFIX.len())));
        }
        let value = match &naming::stored_meta(frame, key, value) {
            Meta::Text(value) => AttributeValue::Text(text(value)),
            Meta::Number(number) => AttributeValue::F64(*number),
            Meta::Integer(integer) => match i32::try_from(*integer) {
                Ok(small) => AttributeValue::I32(small),
                Err(_) => AttributeValue::Text(text(&integer.to_string())),
            },
        };
        attributes.insert(name, value);
    }
    Ok(attributes)
}

fn put<const N: usize>(line: &mut [u8], samples: &[f32], bytes: impl Fn(f32) -> [u8; N]) {
    let (to, _) = line.as_chunks_mut::<N>();
    for (to, sample) in to.iter_mut().zip(samples) {
        *to = bytes(*sample);
    }
}

/// UTF-8 bytes as they are: the crate's own conversion is Latin-1 and refuses `²`'s neighbours.
fn text(value: &str) -> Text {
    Text::from_slice_unchecked(value.as_bytes())
}

fn encode(
    file: impl Write + Seek,
    frame: &Frame,
    parts: &[Part],
    attributes: &HashMap<String, AttributeValue>,
) -> ::exr::error::UnitResult {
    let size = Vec2(frame.width, frame.height);
    let compression = packing_of(frame).unwrap_or_default();
    let matrices = camera::matrices(frame);
    let header = |(index, part): (usize, &Part)| {
        let describe =
            |channel: &Stored| ChannelDescription::new(text(&channel.name), sample_type(frame, part, channel), false);
        // The first part says everything, the others only what kind of numbers they hold.
        let other = if index == 0 {
            attributes.iter().map(|(name, value)| (text(name), value.clone())).collect()
        } else {
            let colour = if part.data { Some(AttributeValue::Text(text(DATA))) } else { None };
            let colour = colour.or_else(|| attributes.get(COLOR_INTEROP_ID).cloned());
            colour.map(|colour| (text(COLOR_INTEROP_ID), colour)).into_iter().collect()
        };
        // Of the whole file, so that they stand in the first part, as all that is said of the picture.
        let camera = matrices.filter(|_| index == 0);
        let own = LayerAttributes {
            world_to_camera: camera.map(|both| both.world_to_camera),
            world_to_normalized_device: camera.map(|both| both.world_to_ndc),
            layer_name: part.name.as_deref().map(text),
            white_luminance: Some(frame.number(WHITE_LUMINANCE).unwrap_or(1.0) as f32).filter(|_| !part.data),
            other,
            layer_position: frame.window.map_or(Vec2(0, 0), |Window { corner: [x, y], .. }| Vec2(x, y)),
            ..LayerAttributes::default()
        };
        let chromaticities = colours::chromaticities(frame).map(|all| {
            let [red, green, blue, white] = all.map(|[x, y]| Vec2(x as f32, y as f32));
            Chromaticities { red, green, blue, white }
        });
        let picture = frame.window.map_or(size, |Window { picture: [width, height], .. }| Vec2(width, height));
        let mut shared = ImageAttributes::new(IntegerBounds::from_dimensions(picture));
        shared.chromaticities = chromaticities;
        Header {
            shared_attributes: shared,
            own_attributes: own,
            ..Header::new(text(""), size, part.channels.iter().map(describe).collect())
        }
        .with_encoding(compression.of_part(part), BlockDescription::ScanLines, LineOrder::Increasing)
    };

    ::exr::block::write(file, parts.iter().enumerate().map(header).collect(), true, |meta, writer| {
        let blocks = ::exr::block::enumerate_ordered_header_block_indices(&meta.headers).map(|(number, index)| {
            // Indices are the encoder's own, within the sizes that `check_channels` has checked.
            let (header, channels) = (&meta.headers[index.layer], &parts[index.layer].channels);
            let block = UncompressedBlock::from_lines(&header.channels, index, |line| {
                let Vec2(x, y) = line.location.position;
                let start = y * frame.width + x;
                let end = start + line.location.sample_count;
                let samples = channels.get(line.location.channel).and_then(|channel| channel.data.get(start..end));
                let samples = samples.unwrap_or(&[]);
                match header.channels.list[line.location.channel].sample_type {
                    SampleType::F16 => put(line.value, samples, |sample| f16::from_f32(sample).to_ne_bytes()),
                    SampleType::F32 | SampleType::U32 => put(line.value, samples, f32::to_ne_bytes),
                }
            });
            (number, block)
        });
        // Parallel inside, but the chunks are written in the order of the blocks: the bytes do not depend on timing.
        writer.on_progress(|_| {}).compress_all_blocks_parallel(&meta, blocks)
    })
}
