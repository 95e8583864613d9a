//! Zemax binary source files (.dat, .sdf): a header of 208 bytes and records of 7 or 8 numbers.
//!
//! Layout: <https://github.com/JuliusMuschaweck/TM25RaySetTools>, `ZemaxBinary.h` and `.cpp` (Unlicense), which cites the
//! manual of OpticStudio 19.4, "Binary Source File format": of the header OpticStudio uses the number of rays, the unit of
//! lengths, the format of rays and the kind of flux alone. So do we.

use super::RayFile;
use super::bundles::{Bundles, Colour, Given};
use super::fields::{Fields, column};
use eyebox_base::error::Result;
use glam::Vec3;

/// What such a file starts with.
pub(super) const IDENTIFIER: i32 = 1010;

const RAYS_AT: usize = 4;
const UNIT_AT: usize = 136;
const FORMAT_AT: usize = 192;
const FLUX_AT: usize = 196;
const HEADER: usize = 208;

/// Millimetres of the units of lengths, by their numbers: metres, inches, centimetres, feet, millimetres.
const UNITS_MM: [f32; 5] = [1000.0, 25.4, 10.0, 304.8, 1.0];

pub(super) fn read(fields: &Fields<'_>) -> Result<RayFile> {
    if fields.bytes.len() < HEADER {
        return Err(fields.cut_off(HEADER as u128));
    }
    let count = fields.u32(RAYS_AT)?;
    let unit = fields.u32(UNIT_AT)?;
    let mm = usize::try_from(unit).ok().and_then(|unit| UNITS_MM.get(unit)).ok_or_else(|| {
        fields.fault(format!("has the unit of lengths {unit}")).expected("0 m, 1 in, 2 cm, 3 ft or 4 mm")
    })?;
    let (format, flux) = (fields.i32(FORMAT_AT)?, fields.i32(FLUX_AT)?);
    let (columns, spectral) = match format {
        0 => (7, false),
        2 => (8, true),
        other => {
            return Err(fields
                .fault(format!("has rays of format {other}"))
                .expected("0, flux alone, or 2, flux and wavelength"));
        }
    };
    let luminous = match flux {
        0 => false,
        1 if !spectral => true,
        other => {
            let of = if spectral { "0, watts, of rays with wavelengths" } else { "0, watts, or 1, lumens" };
            return Err(fields.fault(format!("has flux of kind {other}")).expected(of));
        }
    };
    let wanted = HEADER as u128 + u128::from(count) * 4 * columns as u128;
    let has = fields.bytes.len() as u128;
    if has < wanted {
        return Err(fields.cut_off(wanted));
    }
    if has > wanted {
        return Err(fields.fault(format!("has {has} bytes, and {count} rays")).expected(format!("{wanted} bytes")));
    }
    let mut bundles = Bundles::default();
    for record in fields.bytes.get(HEADER..).unwrap_or_default().chunks_exact(4 * columns) {
        let at = |index: usize| column(record, index).unwrap_or(f32::NAN);
        bundles.add(
            fields,
            &Given {
                place_mm: *mm * Vec3::new(at(0), at(1), at(2)),
                dir: Vec3::new(at(3), at(4), at(5)),
                watts: (!luminous).then(|| at(6)),
                lumens: luminous.then(|| at(6)),
                // µm in the file.
                colour: if spectral { Colour::Line(1000.0 * at(7)) } else { Colour::Table(0) },
            },
        )?;
    }
    let (bundles, remarks) = bundles.end(fields, [None; 2], |_| None)?;
    Ok(RayFile { format: "Zemax binary source file", bundles, lumens: None, remarks })
}
