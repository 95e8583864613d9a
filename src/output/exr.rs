//! EXR files: the layered result, and sky pictures to read.
//!
//! Written: one part (or one per layer on request), scan lines, 32-bit float, lossless ZIP, increasing line order, the same bytes for the same
//! frame. Read: any flat float or half file, single- or multi-part, scan lines or tiles.
//! Attribute names and meanings: openexr.com, "Standard Attributes"; `colorInteropID` values: Color Interop Forum.

mod header;
mod naming;
mod read;
mod write;

pub use naming::{LAYER_PREFIX, MULTI_PART, parse_prefix};
pub use read::read_exr;
pub use write::{warnings, write_exr};

/// The attribute that names the colour space of the pictures.
pub const COLOR_INTEROP_ID: &str = "colorInteropID";
/// Linear Rec. 709 / D65: the colour space when a frame names none.
pub const DEFAULT_COLOR: &str = "lin_rec709_scene";
/// What it is for numbers that are no colours.
const DATA: &str = "data";
/// cd/m² of the value (1, 1, 1).
pub const WHITE_LUMINANCE: &str = "whiteLuminance";
/// Every other metadata entry `key` is the attribute `eyebox.key`, less those of Cryptomatte.
pub const PREFIX: &str = "eyebox.";

#[cfg(test)]
mod tests;
