//! Blocks in B44 compression whose channels have fewer samples than pixels. The decoder (exr 1.74.2) counts their samples
//! wrongly, so it is given one channel at a time, as a picture of its own size: B44 packs channels one after another, in
//! cells of 4 × 4 samples of 3 or 14 bytes each (OpenEXR, "B44 compression").

use super::subsampled::lines;
use ::exr::block::UncompressedBlock;
use ::exr::block::chunk::{Chunk, CompressedBlock, CompressedScanLineBlock};
use ::exr::error::{Error, Result};
use ::exr::meta::MetaData;
use ::exr::meta::attribute::{ChannelDescription, ChannelList, SampleType};
use ::exr::meta::header::Header;
use ::exr::prelude::{SmallVec, Vec2};

/// The lines of a packed block that begins at row `first`, as they would lie in a file that is not compressed.
pub(super) fn unpacked(
    meta: &MetaData,
    (header, channels): (&Header, &ChannelList),
    packed: &[u8],
    (first, size): (usize, Vec2<usize>),
) -> Result<Vec<u8>> {
    let mut rest = packed;
    let mut planes = Vec::with_capacity(channels.list.len());
    for (index, channel) in channels.list.iter().enumerate() {
        let own = || lines(channels, first, size).filter(|line| line.channel == index);
        let samples = Vec2(own().next().map_or(0, |line| line.samples), own().count());
        let short = || Error::Invalid("B44 block is cut off".into());
        let length = length(channel, samples, rest).ok_or_else(short)?;
        let (mine, others) = rest.split_at_checked(length).ok_or_else(short)?;
        rest = others;
        planes.push(if samples.area() == 0 { Vec::new() } else { plane(meta, header, (channel, samples), mine)? });
    }
    let mut taken = vec![0; planes.len()];
    let mut out = Vec::new();
    for line in lines(channels, first, size) {
        let (from, bytes) = (taken[line.channel], line.samples * line.bytes);
        let missing = || Error::Invalid("B44 block has too few samples".into());
        out.extend_from_slice(planes[line.channel].get(from..from + bytes).ok_or_else(missing)?);
        taken[line.channel] += bytes;
    }
    Ok(out)
}

/// Bytes that a channel takes; none if there are not as many.
fn length(channel: &ChannelDescription, samples: Vec2<usize>, packed: &[u8]) -> Option<usize> {
    // Of a cell whose samples are all alike; the third byte tells by its shift, which no other cell has.
    const ALIKE: usize = 3;
    const CELL: usize = 14;
    const NO_SHIFT: u8 = 13 << 2;
    if channel.sample_type != SampleType::F16 {
        return samples.area().checked_mul(channel.sample_type.bytes_per_sample());
    }
    let cells = samples.0.div_ceil(4) * samples.1.div_ceil(4);
    (0..cells).try_fold(0_usize, |at, _| {
        let third = packed.get(at + 2)?;
        Some(at + if *third >= NO_SHIFT { ALIKE } else { CELL })
    })
}

/// The samples of a channel, line by line.
fn plane(
    meta: &MetaData,
    header: &Header,
    (channel, samples): (&ChannelDescription, Vec2<usize>),
    packed: &[u8],
) -> Result<Vec<u8>> {
    if channel.sample_type != SampleType::F16 {
        return Ok(packed.to_vec());
    }
    let alone = ChannelDescription { sampling: Vec2(1, 1), ..channel.clone() };
    let channels = ChannelList::new(SmallVec::from_iter([alone]));
    let mut compressed_pixels_le = packed.to_vec();
    if compressed_pixels_le.len() == samples.area() * channels.bytes_per_pixel {
        // The decoder would take it for samples that are not packed; what follows a block it does not read.
        compressed_pixels_le.push(0);
    }
    let mut header = Header { channels, layer_size: samples, ..header.clone() };
    header.own_attributes.layer_position = Vec2(0, 0);
    let block = CompressedBlock::ScanLine(CompressedScanLineBlock { y_coordinate: 0, compressed_pixels_le });
    let meta = MetaData { headers: SmallVec::from_iter([header]), ..meta.clone() };
    let chunk = Chunk { layer_index: 0, compressed_block: block };
    Ok(UncompressedBlock::decompress_chunk(chunk, &meta, false)?.data)
}
