//! `EXT_meshopt_compression` and `KHR_meshopt_compression`: one buffer view, decoded by a Rust port of the library that defines
//! the format. Its decoders are made for untrusted bytes; what is wrong is told here in the asset's own words.

use super::at::At;
use super::buffers::Buffers;
use super::compressed::Block;
use super::notes::Budget;
use eyebox_base::error;
use meshoptimizer_rs::{Error, Workspace, codec};

/// Decodes the view whose extension object is `at`.
///
/// # Errors
/// Sizes that the extension does not allow, bytes outside of the buffer, a broken stream, an unknown mode or filter.
pub(super) fn decode(at: &At<'_>, buffers: &Buffers<'_>, budget: &mut Budget) -> error::Result<Block> {
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
    let mode = match mode.text()? {
        "ATTRIBUTES" => {
            if stride == 0 || stride > 256 || stride % 4 != 0 {
                return Err(stride_at.fault(format!("byteStride {stride}")).expected("a multiple of 4 up to 256"));
            }
            let filter = Filter::parse(filter_name, stride).ok_or_else(|| {
                let place = filter.as_ref().unwrap_or(at);
                let what = format!("filter `{}` with byteStride {stride}", filter_name.escape_debug());
                place.fault(what).expected("NONE, OCTAHEDRAL (4, 8), QUATERNION (8), EXPONENTIAL or COLOR (4, 8)")
            })?;
            Mode::Attributes(filter)
        }
        name @ ("TRIANGLES" | "INDICES") => {
            if stride != 2 && stride != 4 {
                return Err(stride_at.fault(format!("indices of {stride} bytes")).expected("2 or 4"));
            }
            if name == "INDICES" {
                Mode::Indices
            } else if count % 3 == 0 {
                Mode::Triangles
            } else {
                return Err(at.want("count")?.fault(format!("{count} indices of triangles")).expected("3 for each"));
            }
        }
        other => {
            let modes = ["ATTRIBUTES", "TRIANGLES", "INDICES"];
            return Err(mode.fault("unknown mode").expected(modes.join(", ")).nearest(other, modes));
        }
    };
    let bytes = unpacked(mode, count, stride, inside).map_err(|error| {
        at.fault(format!("the meshopt stream is broken: {error}")).expected("a stream that matches `mode` and `count`")
    })?;
    // Accessors over views with a stride of their own end at 252.
    let stride = (matches!(mode, Mode::Attributes(_)) && stride <= 252).then_some(stride);
    Ok(Block { bytes, stride })
}

/// What a view holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mode {
    Attributes(Filter),
    Triangles,
    Indices,
}

/// What was done to attributes before they were packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Filter {
    None,
    Octahedral,
    Quaternion,
    Exponential,
    Color,
}

impl Filter {
    /// The filter of this name, if it is one for this stride.
    pub(super) fn parse(name: &str, stride: usize) -> Option<Filter> {
        match (name, stride) {
            ("NONE", _) => Some(Filter::None),
            ("OCTAHEDRAL", 4 | 8) => Some(Filter::Octahedral),
            ("QUATERNION", 8) => Some(Filter::Quaternion),
            ("EXPONENTIAL", _) => Some(Filter::Exponential),
            ("COLOR", 4 | 8) => Some(Filter::Color),
            _ => None,
        }
    }
}

/// `count` elements of `stride` bytes. Streams of both versions are taken in both extensions, as the library that defines them
/// does; only the later extension allows version 1.
pub(super) fn unpacked(mode: Mode, count: usize, stride: usize, stream: &[u8]) -> Result<Vec<u8>, Error> {
    let work = &mut Workspace::default();
    match mode {
        Mode::Triangles => codec::decode_index_buffer(count, stride, stream, work),
        Mode::Indices => codec::decode_index_sequence(count, stride, stream, work),
        Mode::Attributes(filter) => {
            let mut bytes = codec::decode_vertex_buffer(count, stride, stream, work)?;
            match filter {
                Filter::None => {}
                Filter::Octahedral => codec::decode_filter_oct(&mut bytes, count, stride, work)?,
                Filter::Quaternion => codec::decode_filter_quat(&mut bytes, count, stride, work)?,
                Filter::Exponential => codec::decode_filter_exp(&mut bytes, count, stride, work)?,
                Filter::Color => codec::decode_filter_color(&mut bytes, count, stride, work)?,
            }
            Ok(bytes)
        }
    }
}
