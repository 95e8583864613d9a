//! EXR files: the layered result, and sky pictures to read.
//!
//! Written: one part (or one per layer on request), scan lines, 32-bit float, lossless ZIP, increasing line order, the same bytes for the same
//! frame. Read: any flat float or half file, single- or multi-part, scan lines or tiles.
//! Attribute names and meanings: openexr.com, "Standard Attributes"; `colorInteropID` values: Color Interop Forum.

mod camera;
mod header;
mod naming;
mod packing;
mod write;

pub use eyebox_film::exr::{COLOR_INTEROP_ID, LAYER_PREFIX, PREFIX, WHITE_LUMINANCE, read_exr};
pub use naming::{COMPRESSION, HALF, MULTI_PART, parse_prefix};
pub use packing::Packing;
pub use write::{warnings, write_exr};

/// What it is for numbers that are no colours.
const DATA: &str = "data";

#[cfg(test)]
mod tests;
