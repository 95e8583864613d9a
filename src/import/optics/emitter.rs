//! `emitter`: a face that emits.

use super::fields::{Fields, not_yet, union};
use super::spectrum::{SpectrumSpec, spectrum};
use crate::base::fault::Result;
use crate::base::{Fault, Where};
use crate::import::value::Value;
use crate::scene::attribute::Noun;
use crate::scene::{Angular, Note, Photometry};

/// An emitter with its group still by name.
#[derive(Debug, Clone, PartialEq)]
pub struct EmitterSpec {
    pub group: String,
    pub photometry: Photometry,
    pub angular: Angular,
    pub spectrum: Option<SpectrumSpec>,
}

/// The attributes that say how strong an emitter is; one of them holds.
pub const STRENGTHS: [&str; 5] = ["flux_lm", "luminance_cd_m2", "intensity_cd", "illuminance_lx", "radiant_flux_w"];

pub use crate::scene::attribute::EMITTER as ATTRIBUTES;

pub fn emitter(value: &Value, notes: &mut Vec<Note>) -> Result<EmitterSpec> {
    let fields = Fields::of(Noun::Emitter, "emitter", value, &ATTRIBUTES)?;
    let group = match fields.text("group")? {
        Some(name) => group_name(name, fields.value("group").map_or(&value.at, |value| &value.at))?,
        None => {
            notes.push(fields.defaulted("group"));
            "lamp".to_owned()
        }
    };
    let given: Vec<&str> = STRENGTHS.into_iter().filter(|name| fields.has(name)).collect();
    let photometry = match given.as_slice() {
        ["flux_lm"] => Photometry::FluxLm(fields.need_number("flux_lm")?),
        ["luminance_cd_m2"] => Photometry::LuminanceCdM2(fields.need_number("luminance_cd_m2")?),
        ["intensity_cd"] => Photometry::IntensityCd(fields.need_number("intensity_cd")?),
        several => {
            let what = if several.is_empty() {
                "the emitter has no strength".into()
            } else {
                format!("the emitter has {}", several.join(" and "))
            };
            return Err(Fault::new(value.at.clone(), what).expected("one of flux_lm, luminance_cd_m2, intensity_cd"));
        }
    };
    let angular = match fields.value("angular") {
        Some(value) => angular(value)?,
        None => {
            notes.push(fields.defaulted("angular"));
            Angular::Lambert
        }
    };
    let spectrum = match fields.value("spectrum") {
        Some(value) => Some(spectrum(value)?),
        None => None,
    };
    Ok(EmitterSpec { group, photometry, angular, spectrum })
}

fn angular(value: &Value) -> Result<Angular> {
    let read = union(Noun::Emitter, "angular", value)?;
    match read.kind.name {
        "lambert" => Ok(Angular::Lambert),
        "cos_n" => Ok(Angular::CosN { n: read.fields.need_number("n")? }),
        name => Err(not_yet(&value.at, &format!("angular `{name}`"))),
    }
}

/// A name that may be part of a layer name: `[A-Za-z][A-Za-z0-9_]*`.
pub fn group_name(name: &str, at: &Where) -> Result<String> {
    let first = name.chars().next().is_some_and(|c| c.is_ascii_alphabetic());
    if first && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
        return Ok(name.to_owned());
    }
    Err(Fault::new(at.clone(), format!("group `{name}` can't be part of a layer name"))
        .expected("letters, digits and _, a letter first"))
}
