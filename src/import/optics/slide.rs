//! `slide`: a thin transmissive picture on a face.

use super::fields::Fields;
use crate::value::Value;
use eyebox_base::error::Result;
use eyebox_base::{Error, Where};
use eyebox_scene::attribute::Noun;
use eyebox_scene::{Note, Polarisation};
use glam::DVec3;

/// A slide before its picture is read and placed. Lengths in mesh units.
#[derive(Debug, Clone, PartialEq)]
pub struct SlideSpec {
    /// The file as it is written, and where.
    pub image: String,
    pub image_at: Where,
    /// Of an EXR file.
    pub layer: Option<String>,
    pub at: Where,
    pub size: [f64; 2],
    pub u: DVec3,
    pub v: DVec3,
    pub centre: Option<DVec3>,
    pub transmittance: f64,
    pub contrast: f64,
    pub polarisation: Option<Polarisation>,
    /// Luminances of red, green and blue that a display has at full, if they are said.
    pub primaries: Option<[f64; 3]>,
}

pub use eyebox_scene::attribute::SLIDE as ATTRIBUTES;

pub fn slide(value: &Value, notes: &mut Vec<Note>) -> Result<SlideSpec> {
    let fields = Fields::of(Noun::Slide, "slide", value, &ATTRIBUTES)?;
    Ok(SlideSpec {
        transmittance: fields.number_or("transmittance", 1.0, notes)?,
        polarisation: fields.value("polarisation").map(polarisation).transpose()?,
        ..picture(&fields, notes)?
    })
}

/// What a slide and a display's own picture have in common; transmittance and polarisation are an ideal slide's.
pub(super) fn picture(fields: &Fields<'_>, notes: &mut Vec<Note>) -> Result<SlideSpec> {
    let (u, v) = (fields.need_direction("u")?, fields.need_direction("v")?);
    let place = |name: &str| fields.value(name).map_or(fields.at(), |value| &value.at).clone();
    if u.dot(v).abs() > ORTHOGONAL {
        return Err(Error::new(place("v"), format!("`u` and `v` of {} are not orthogonal", fields.what()))
            .expected(format!("a right angle; it is {:.3}°", u.angle_between(v).to_degrees())));
    }
    Ok(SlideSpec {
        image: fields.need_text("image")?.to_owned(),
        image_at: place("image"),
        layer: fields.text("layer")?.map(str::to_owned),
        at: fields.at().clone(),
        size: fields.need_numbers("size")?,
        u,
        v,
        centre: fields.numbers("centre")?.map(DVec3::from_array),
        transmittance: 1.0,
        contrast: fields.number_or("contrast", f64::INFINITY, notes)?,
        polarisation: None,
        primaries: None,
    })
}

/// `{ angle_deg, degree }`.
pub fn polarisation(value: &Value) -> Result<Polarisation> {
    let fields = Fields::of(Noun::Slide, "polarisation", value, &["angle_deg", "degree"])?;
    Ok(Polarisation { angle_deg: fields.need_number("angle_deg")?, degree: fields.need_number("degree")? })
}

/// Cosine of the angle by which two directions may miss a right angle: what people round away when they write decimals.
pub const ORTHOGONAL: f64 = 1e-3;
