//! Channels with fewer samples than pixels, as luminance and chroma have them. The decoder knows how such blocks are
//! compressed but refuses their headers: it is shown headers without the sampling, and blocks with it.

use super::{b44, copy_samples};
use crate::frame::Frame;
use ::exr::block::chunk::{Chunk, CompressedBlock};
use ::exr::block::{BlockIndex, UncompressedBlock};
use ::exr::compression::Compression;
use ::exr::error::{Error, Result};
use ::exr::meta::MetaData;
use ::exr::meta::attribute::ChannelList;
use ::exr::prelude::Vec2;
use std::borrow::Cow;

/// Pixels per sample, across and down, by part and channel.
#[derive(Debug, Default)]
pub(super) struct Sampling(Vec<Vec<[usize; 2]>>);

impl Sampling {
    /// The file as if every channel had all samples, and how many they have. What is no header is left alone: the decoder
    /// says what is wrong with it.
    pub fn taken_out(bytes: &[u8]) -> (Cow<'_, [u8]>, Sampling) {
        let Some(places) = places(bytes) else { return (Cow::Borrowed(bytes), Sampling::default()) };
        let number = |at: usize| -> usize {
            let raw = bytes.get(at..at + 4).and_then(|raw| raw.try_into().ok()).unwrap_or([0; 4]);
            usize::try_from(i32::from_le_bytes(raw)).unwrap_or(0)
        };
        let by_part: Vec<Vec<[usize; 2]>> =
            places.iter().map(|part| part.iter().map(|at| [number(*at), number(*at + 4)]).collect()).collect();
        let all = |sampling: &[usize; 2]| *sampling == [1, 1];
        // No sampling at all is a broken header.
        if by_part.iter().flatten().all(all) || by_part.iter().flatten().flatten().any(|pixels| *pixels == 0) {
            return (Cow::Borrowed(bytes), Sampling::default());
        }
        let mut whole = bytes.to_vec();
        for at in places.into_iter().flatten() {
            if let Some(raw) = whole.get_mut(at..at + 8) {
                raw.copy_from_slice(&[1, 0, 0, 0, 1, 0, 0, 0]);
            }
        }
        (Cow::Owned(whole), Sampling(by_part))
    }

    fn of(&self, part: usize, channel: usize) -> [usize; 2] {
        self.0.get(part).and_then(|part| part.get(channel)).copied().unwrap_or([1, 1])
    }

    /// Whether a part has fewer samples anywhere.
    pub fn concerns(&self, part: usize) -> bool {
        self.0.get(part).is_some_and(|part| part.iter().any(|sampling| *sampling != [1, 1]))
    }

    /// As [`UncompressedBlock::decompress_chunk`].
    pub fn decompress(&self, chunk: Chunk, meta: &MetaData) -> Result<UncompressedBlock> {
        let part = chunk.layer_index;
        if !self.concerns(part) {
            return UncompressedBlock::decompress_chunk(chunk, meta, false);
        }
        let header = meta.headers.get(part).ok_or_else(|| Error::Invalid("chunk layer index".into()))?;
        let CompressedBlock::ScanLine(packed) = &chunk.compressed_block else {
            return Err(Error::Invalid("subsampling is only allowed in flat scan line images".into()));
        };
        let indices = header.get_block_data_indices(&chunk.compressed_block)?;
        let at = header.get_absolute_block_pixel_coordinates(indices)?;
        let first = at.position.to_usize("block")?.1;
        let mut own = MetaData { headers: meta.headers.clone(), ..meta.clone() };
        let header = own.headers.get_mut(part).ok_or_else(|| Error::Invalid("chunk layer index".into()))?;
        for (index, channel) in header.channels.list.iter_mut().enumerate() {
            let [across, down] = self.of(part, index);
            channel.sampling = Vec2(across, down);
        }
        // The decoder multiplies the area by this; lines without chroma are shorter.
        let bytes = lines(&header.channels, first, at.size).map(|line| line.samples * line.bytes).sum::<usize>();
        // What packing would have made larger is stored as it is.
        let is_packed = packed.compressed_pixels_le.len() != bytes;
        if is_packed && matches!(header.compression, Compression::B44 | Compression::B44A) {
            let channels = (&*header, &header.channels);
            let data = b44::unpacked(meta, channels, &packed.compressed_pixels_le, (first, at.size))?;
            let pixel_position = at.position.to_usize("block")?;
            let level = indices.level_index;
            return Ok(UncompressedBlock {
                data,
                index: BlockIndex { layer: part, pixel_position, level, pixel_size: at.size },
            });
        }
        if at.size.area() == 0 || bytes % at.size.area() != 0 {
            return Err(Error::NotSupported("this pattern of subsampling".into()));
        }
        header.channels.bytes_per_pixel = bytes / at.size.area();
        UncompressedBlock::decompress_chunk(chunk, &own, false)
    }

    /// Copies the samples of a block of such a part to the pixels that they stand at; `None` if one lies outside.
    pub fn store(
        &self,
        frame: &mut Frame,
        channels: &ChannelList,
        first: usize,
        block: &UncompressedBlock,
    ) -> Option<()> {
        let part = block.index.layer;
        let mut own = channels.clone();
        for (index, channel) in own.list.iter_mut().enumerate() {
            let [across, down] = self.of(part, index);
            channel.sampling = Vec2(across, down);
        }
        let mut from = 0_usize;
        for line in lines(&own, block.index.pixel_position.1, block.index.pixel_size) {
            let channel = own.list.get(line.channel)?;
            let bytes = block.data.get(from..from.checked_add(line.samples.checked_mul(line.bytes)?)?)?;
            from += bytes.len();
            let mut samples = vec![0.0; line.samples];
            copy_samples(&mut samples, bytes, channel.sample_type);
            let (width, step) = (frame.width, channel.sampling.0);
            let row = line.y.checked_mul(width)?.checked_add(block.index.pixel_position.0)?;
            let to = frame.channels.get_mut(first.checked_add(line.channel)?)?.data.get_mut(row..row + width)?;
            for (sample, value) in samples.into_iter().enumerate() {
                *to.get_mut(sample * step)? = value;
            }
        }
        Some(())
    }

    /// Between the samples: linear along rows and columns, as the last one beyond it.
    pub fn spread(&self, frame: &mut Frame, first_of_part: &[usize]) {
        let (width, height) = (frame.width, frame.height);
        for (part, first) in first_of_part.iter().enumerate().filter(|(part, _)| self.concerns(*part)) {
            let count = self.0.get(part).map_or(0, Vec::len);
            for index in 0..count {
                let [across, down] = self.of(part, index);
                let Some(channel) = frame.channels.get_mut(first + index).filter(|_| [across, down] != [1, 1]) else {
                    continue;
                };
                let known = channel.data.to_vec();
                let at = |x: usize, y: usize| known.get(y * width + x).copied().unwrap_or(0.0);
                let along = |x: usize, y: usize| {
                    let left = x - x % across;
                    let right = if left + across < width { left + across } else { left };
                    at(left, y) + (at(right, y) - at(left, y)) * (x % across) as f32 / across as f32
                };
                for y in 0..height {
                    let top = y - y % down;
                    let bottom = if top + down < height { top + down } else { top };
                    for x in 0..width {
                        let value =
                            along(x, top) + (along(x, bottom) - along(x, top)) * (y % down) as f32 / down as f32;
                        if let Some(pixel) = channel.data.get_mut(y * width + x) {
                            *pixel = value;
                        }
                    }
                }
            }
        }
    }
}

/// A line of a channel in a block.
pub(super) struct Line {
    pub y: usize,
    pub channel: usize,
    pub samples: usize,
    pub bytes: usize,
}

/// The lines of a block that begins at row `first`, in the order of the file.
pub(super) fn lines(channels: &ChannelList, first: usize, size: Vec2<usize>) -> impl Iterator<Item = Line> + '_ {
    (first..first + size.1).flat_map(move |y| {
        channels.list.iter().enumerate().filter_map(move |(index, channel)| {
            let Vec2(across, down) = channel.sampling;
            (y % down == 0).then(|| Line {
                y,
                channel: index,
                samples: size.0 / across,
                bytes: channel.sample_type.bytes_per_sample(),
            })
        })
    })
}

/// Where the sampling of each channel of each part is said, in bytes from the start (OpenEXR file layout, "Header" and
/// "Channel list"); none if this is no whole header.
fn places(bytes: &[u8]) -> Option<Vec<Vec<usize>>> {
    const MULTIPART: u8 = 0x10;
    let several = bytes.get(5)? & MULTIPART != 0;
    let (mut at, mut parts) = (8, Vec::new());
    let text = |at: &mut usize| -> Option<std::ops::Range<usize>> {
        let length = bytes.get(*at..)?.iter().position(|byte| *byte == 0)?;
        let found = *at..*at + length;
        *at += length + 1;
        Some(found)
    };
    loop {
        if several && *bytes.get(at)? == 0 {
            return Some(parts);
        }
        let mut channels = Vec::new();
        loop {
            let name = text(&mut at)?;
            if name.is_empty() {
                break;
            }
            text(&mut at)?;
            let size = i32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?);
            let begin = at + 4;
            let end = begin.checked_add(usize::try_from(size).ok()?)?;
            if bytes.get(name)? == b"channels" {
                let mut within = begin;
                while within < end && *bytes.get(within)? != 0 {
                    text(&mut within)?;
                    // Type, whether it is perceived as linear, three bytes that are not used.
                    channels.push(within + 8);
                    within += 16;
                }
            }
            at = end;
        }
        parts.push(channels);
        if !several {
            return Some(parts);
        }
    }
}
