//! `slide`: a thin transmissive picture on a face.

use super::fields::Fields;
use crate::base::error::Result;
use crate::base::{Error, Where};
use crate::import::value::Value;
use crate::scene::attribute::Noun;
use crate::scene::{Note, Polarisation};
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
}

pub use crate::scene::attribute::SLIDE as ATTRIBUTES;

pub fn slide(value: &Value, notes: &mut Vec<Note>) -> Result<SlideSpec> {
    let fields = Fields::of(Noun::Slide, "slide", value, &ATTRIBUTES)?;
    let (u, v) = (fields.need_direction("u")?, fields.need_direction("v")?);
    if u.dot(v).abs() > ORTHOGONAL {
        let at = fields.value("v").map_or(&value.at, |value| &value.at);
        return Err(Error::new(at.clone(), "`u` and `v` of slide are not orthogonal")
            .expected(format!("a right angle; it is {:.3}°", u.angle_between(v).to_degrees())));
    }
    Ok(SlideSpec {
        image: fields.need_text("image")?.to_owned(),
        image_at: fields.value("image").map_or_else(|| value.at.clone(), |value| value.at.clone()),
        layer: fields.text("layer")?.map(str::to_owned),
        at: value.at.clone(),
        size: fields.need_numbers("size")?,
        u,
        v,
        centre: fields.numbers("centre")?.map(DVec3::from_array),
        transmittance: fields.number_or("transmittance", 1.0, notes)?,
        contrast: fields.number_or("contrast", f64::INFINITY, notes)?,
        polarisation: fields.value("polarisation").map(polarisation).transpose()?,
    })
}

/// `{ angle_deg, degree }`.
pub fn polarisation(value: &Value) -> Result<Polarisation> {
    let fields = Fields::of(Noun::Slide, "polarisation", value, &["angle_deg", "degree"])?;
    Ok(Polarisation { angle_deg: fields.need_number("angle_deg")?, degree: fields.need_number("degree")? })
}

/// Cosine of the angle by which two directions may miss a right angle: what people round away when they write decimals.
pub const ORTHOGONAL: f64 = 1e-3;
