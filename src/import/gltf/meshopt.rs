//! `EXT_meshopt_compression` and `KHR_meshopt_compression`: one buffer view, decoded by the library that defines the
//! format. Its decoders are made for untrusted bytes; what they assert of the caller is checked here.

use super::at::At;
use super::buffers::Buffers;
use super::compressed::Block;
use super::notes::Budget;
use crate::base::fault::Result;
use ::meshopt::encoding as codec;

/// Decodes the view whose extension object is `at`.
///
/// # Errors
/// Sizes that the extension does not allow, bytes outside of the buffer, a broken stream, an unknown mode or filter.
pub(super) fn decode(at: &At<'_>, buffers: &Buffers<'_>, budget: &mut Budget) -> Result<Block> {
    let buffer = at.want("buffer")?;
    let index = buffer.index(buffers.data.len(), "buffer")?;
    let Some(Some(slice)) = buffers.data.get(index) else {
        return Err(buffer.fault(format!("buffer {index}, which holds compressed data, has no bytes")));
    };
    let bytes = buffers.bytes(*slice);
    let (start, length) = (at.count_or("byteOffset", 0)?, at.want("byteLength")?.count()?);
    let inside = start.checked_add(length).and_then(|end| bytes.get(start..end)).ok_or_else(|| {
        at.fault(format!("{length} compressed bytes from byte {start} of buffer {index}"))
            .expected(format!("within its {} bytes", bytes.len()))
    })?;
    let (stride_at, count) = (at.want("byteStride")?, at.want("count")?.count()?);
    let stride = stride_at.count()?;
    // Before anything is allocated; a decoder works in copies.
    budget.charge(at, count, stride.saturating_mul(2).saturating_add(4))?;
    let mode = at.want("mode")?;
    let filter = at.get("filter")?;
    let filter_name = filter.as_ref().map_or(Ok("NONE"), |filter| filter.text())?;
    let broken = || at.fault("the meshopt stream is broken").expected("a stream that matches `mode` and `count`");
    let bytes = match mode.text()? {
        "ATTRIBUTES" => {
            if stride == 0 || stride > 256 || stride % 4 != 0 {
                return Err(stride_at.fault(format!("byteStride {stride}")).expected("a multiple of 4 up to 256"));
            }
            let plain = attributes(inside, count, stride).ok_or_else(broken)?;
            filtered(plain, stride, filter_name).ok_or_else(|| {
                let place = filter.as_ref().unwrap_or(at);
                let what = format!("filter `{}` with byteStride {stride}", filter_name.escape_debug());
                place.fault(what).expected("NONE, OCTAHEDRAL (4, 8), QUATERNION (8), EXPONENTIAL or COLOR (4, 8)")
            })?
        }
        name @ ("TRIANGLES" | "INDICES") => {
            if name == "TRIANGLES" && count % 3 != 0 {
                return Err(at.want("count")?.fault(format!("{count} indices of triangles")).expected("3 for each"));
            }
            match (name, stride) {
                ("TRIANGLES", 2) => halves(codec::decode_index_buffer::<u16>(inside, count).map_err(|_| broken())?),
                ("TRIANGLES", 4) => words(codec::decode_index_buffer::<u32>(inside, count).map_err(|_| broken())?),
                (_, 2) => halves(codec::decode_index_sequence::<u16>(inside, count).map_err(|_| broken())?),
                (_, 4) => words(codec::decode_index_sequence::<u32>(inside, count).map_err(|_| broken())?),
                _ => return Err(stride_at.fault(format!("indices of {stride} bytes")).expected("2 or 4")),
            }
        }
        other => {
            let modes = ["ATTRIBUTES", "TRIANGLES", "INDICES"];
            return Err(mode.fault("unknown mode").expected(modes.join(", ")).nearest(other, modes));
        }
    };
    let stride = (mode.text()? == "ATTRIBUTES").then_some(stride);
    Ok(Block { bytes, stride: stride.filter(|&stride| stride <= 252) })
}

/// An element of `N` bytes.
#[derive(Clone)]
struct Element<const N: usize>([u8; N]);

impl<const N: usize> Default for Element<N> {
    fn default() -> Self {
        Element([0; N])
    }
}

/// The elements of a vertex stream, `stride` bytes each: a multiple of 4 up to 256, which the decoder asserts.
fn attributes(bytes: &[u8], count: usize, stride: usize) -> Option<Vec<u8>> {
    fn sized<const N: usize>(bytes: &[u8], count: usize) -> Option<Vec<u8>> {
        let elements: Vec<Element<N>> = codec::decode_vertex_buffer(bytes, count).ok()?;
        Some(elements.iter().flat_map(|element| element.0).collect())
    }
    macro_rules! by_stride {
        ($($n:literal)*) => { match stride { $($n => sized::<$n>(bytes, count),)* _ => None } };
    }
    by_stride!(4 8 12 16 20 24 28 32 36 40 44 48 52 56 60 64 68 72 76 80 84 88 92 96 100 104 108 112 116 120 124 128
        132 136 140 144 148 152 156 160 164 168 172 176 180 184 188 192 196 200 204 208 212 216 220 224 228 232 236 240
        244 248 252 256)
}

/// Undoes a filter; none if it does not exist or not for this stride.
fn filtered(bytes: Vec<u8>, stride: usize, filter: &str) -> Option<Vec<u8>> {
    let quads = |bytes: &[u8]| -> Vec<[i8; 4]> {
        bytes.as_chunks::<4>().0.iter().map(|chunk| chunk.map(|byte| byte as i8)).collect()
    };
    let wide = |bytes: &[u8]| -> Vec<[i16; 4]> {
        let lanes = |chunk: &[u8; 8]| std::array::from_fn(|i| i16::from_le_bytes([chunk[2 * i], chunk[2 * i + 1]]));
        bytes.as_chunks::<8>().0.iter().map(lanes).collect()
    };
    let narrow_bytes = |quads: Vec<[i8; 4]>| quads.into_iter().flatten().map(|lane| lane as u8).collect();
    let wide_bytes = |quads: Vec<[i16; 4]>| quads.into_iter().flatten().flat_map(i16::to_le_bytes).collect();
    Some(match (filter, stride) {
        ("NONE", _) => bytes,
        ("OCTAHEDRAL", 4) => {
            let mut lanes = quads(&bytes);
            codec::decode_filter_oct(&mut lanes);
            narrow_bytes(lanes)
        }
        ("OCTAHEDRAL", 8) => {
            let mut lanes = wide(&bytes);
            codec::decode_filter_oct(&mut lanes);
            wide_bytes(lanes)
        }
        ("QUATERNION", 8) => {
            let mut lanes = wide(&bytes);
            codec::decode_filter_quat(&mut lanes);
            wide_bytes(lanes)
        }
        ("EXPONENTIAL", _) => {
            let mut lanes: Vec<[u32; 1]> =
                bytes.as_chunks::<4>().0.iter().map(|chunk| [u32::from_le_bytes(*chunk)]).collect();
            codec::decode_filter_exp(&mut lanes);
            words(lanes.into_iter().flatten().collect())
        }
        // Colours are not used here: whatever they decode to.
        ("COLOR", 4 | 8) => bytes,
        _ => return None,
    })
}

fn halves(indices: Vec<u16>) -> Vec<u8> {
    indices.into_iter().flat_map(u16::to_le_bytes).collect()
}

fn words(indices: Vec<u32>) -> Vec<u8> {
    indices.into_iter().flat_map(u32::to_le_bytes).collect()
}
