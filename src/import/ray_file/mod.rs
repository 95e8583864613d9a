//! Ray files of lamps → [`LampRay`]s: IES TM-25-13 and Zemax' binary source files.
//!
//! Written here because no crate could be used (searched in 2026): `tm25ray` 0.2.5 is under the AGPL and reads TM-25 alone.
//! Neither standard is public; the layouts are those of the public-domain readers that each file names, which agree with each
//! other but where it is said.

mod bundles;
mod fields;
mod tm25;
mod zemax;

use crate::files;
use eyebox_base::error::Result;
use eyebox_base::{Code, Where};
use eyebox_scene::{LampRay, Spectrum};
use fields::Fields;
use std::path::Path;

/// The most bytes of a ray file: 150 million rays.
const MOST_BYTES: u64 = 1 << 32;

/// What a ray file says.
#[derive(Debug, Clone, PartialEq)]
pub struct RayFile {
    /// In words.
    pub format: &'static str,
    /// Rays by their spectra; at least one with rays.
    pub bundles: Vec<Bundle>,
    /// Luminous flux of all, lm, as the header states it.
    pub lumens: Option<f64>,
    /// What of the file is not used, or was put right.
    pub remarks: Vec<String>,
}

/// Rays with one spectrum, and what their flux is a share of.
#[derive(Debug, Clone, PartialEq)]
pub struct Bundle {
    /// None if the file does not say it.
    pub spectrum: Option<Spectrum>,
    pub rays: Vec<LampRay>,
    /// Sum of their luminous flux, lm.
    pub lumens: Option<f64>,
    /// Sum of their radiant flux from 360 to 830 nm, W.
    pub watts: Option<f64>,
    /// Of `watts` by each ray's own wavelength, lm.
    pub by_wavelength: Option<f64>,
}

/// Reads a ray file that is named at `at`. What it is its first bytes tell.
///
/// # Errors
/// A file that is not there, too large, cut off or none of these; a ray that is none.
pub fn read(file: &Path, at: &Where) -> Result<RayFile> {
    parse(file, &files::read_at_most(file, at, "ray file", (MOST_BYTES, Code::ProfileMissing))?)
}

/// The rays in these bytes of `file`.
///
/// # Errors
/// As [`read`].
pub fn parse(file: &Path, bytes: &[u8]) -> Result<RayFile> {
    let fields = Fields::new(file, bytes);
    match bytes.first_chunk::<4>() {
        Some(b"TM25") => tm25::read(&fields),
        Some(start) if i32::from_le_bytes(*start) == zemax::IDENTIFIER => zemax::read(&fields),
        Some(_) | None => Err(fields
            .fault("is no ray file that is known".to_owned())
            .expected("IES TM-25-13 (it starts with TM25) or a Zemax binary source file (with the number 1010)")),
    }
}
