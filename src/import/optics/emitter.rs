//! `emitter`: a face that emits.

use super::fields::{Fields, union};
use super::slide::{SlideSpec, picture};
use super::spectrum::{SpectrumSpec, spectrum};
use crate::value::Value;
use eyebox_base::colour::ColourSpace;
use eyebox_base::error::Result;
use eyebox_base::{Code, Error, Where};
use eyebox_scene::attribute::{Noun, PICTURE};
use eyebox_scene::{Note, Photometry, Spectrum};
use glam::DVec3;

/// An emitter with its group still by name.
#[derive(Debug, Clone, PartialEq)]
pub struct EmitterSpec {
    pub group: String,
    pub strength: Strength,
    pub both_sides: bool,
    pub angular: Spreading,
    pub spectrum: Option<SpectrumSpec>,
    /// Unit, in the part's axes.
    pub u: Option<DVec3>,
    /// Angle from `u` in rad, and degree.
    pub polarisation: Option<(f64, f64)>,
    /// What a display shows.
    pub picture: Option<SlideSpec>,
}

/// How strong it is; a radiant flux still without its spectrum.
#[derive(Debug, Clone, PartialEq)]
pub enum Strength {
    Said(Photometry),
    RadiantFluxW { watts: f64, at: Where },
}

/// The angular distribution, its file still to be read.
#[derive(Debug, Clone, PartialEq)]
pub enum Spreading {
    Lambert,
    CosN {
        n: f64,
    },
    Gauss {
        fwhm_deg: f64,
    },
    /// The file as it is written, and where.
    Profile {
        file: String,
        at: Where,
    },
    /// The same, of rays with places and directions of their own.
    RayFile {
        file: String,
        at: Where,
    },
}

/// The attributes that say how strong an emitter is; one of them holds.
pub const STRENGTHS: [&str; 6] =
    ["flux_lm", "luminance_cd_m2", "primaries_cd_m2", "intensity_cd", "illuminance_lx", "radiant_flux_w"];

pub use eyebox_scene::attribute::EMITTER as ATTRIBUTES;

/// What goes with a ray file: all else says of a face what its rays have of their own.
const OF_RAYS: [&str; 6] = ["name", "group", "flux_lm", "radiant_flux_w", "angular", "spectrum"];

pub fn emitter(value: &Value, notes: &mut Vec<Note>) -> Result<EmitterSpec> {
    let fields = Fields::of(Noun::Emitter, "emitter", value, &ATTRIBUTES)?;
    let group = match fields.text("group")? {
        Some(name) => group_name(name, fields.value("group").map_or(&value.at, |value| &value.at))?,
        None => {
            notes.push(fields.defaulted("group"));
            "lamp".to_owned()
        }
    };
    let angular = match fields.value("angular") {
        Some(value) => angular(value)?,
        None => {
            notes.push(fields.defaulted("angular"));
            Spreading::Lambert
        }
    };
    if matches!(angular, Spreading::RayFile { .. })
        && let Some(name) = ATTRIBUTES.into_iter().find(|name| fields.has(name) && !OF_RAYS.contains(name))
    {
        let at = fields.value(name).map_or(&value.at, |value| &value.at);
        return Err(Error::new(
            at.clone(),
            format!("`{name}` of emitter is of a face, and the rays of a file are none"),
        )
        .expected("group, flux_lm or radiant_flux_w, and spectrum beside a ray file"));
    }
    let primaries = fields.numbers::<3>("primaries_cd_m2")?;
    let given: Vec<&str> = STRENGTHS.into_iter().filter(|name| fields.has(name)).collect();
    let strength = match given.as_slice() {
        ["flux_lm"] => Strength::Said(Photometry::FluxLm(fields.need_number("flux_lm")?)),
        ["luminance_cd_m2"] => Strength::Said(Photometry::LuminanceCdM2(fields.need_number("luminance_cd_m2")?)),
        ["primaries_cd_m2"] => Strength::Said(Photometry::LuminanceCdM2(primaries.iter().flatten().sum())),
        ["intensity_cd"] => Strength::Said(Photometry::IntensityCd(fields.need_number("intensity_cd")?)),
        ["radiant_flux_w"] => Strength::RadiantFluxW {
            watts: fields.need_number("radiant_flux_w")?,
            at: fields.value("radiant_flux_w").map_or_else(|| value.at.clone(), |value| value.at.clone()),
        },
        [] if matches!(angular, Spreading::Profile { .. } | Spreading::RayFile { .. }) => {
            Strength::Said(Photometry::AsMeasured)
        }
        ["illuminance_lx"] => {
            let at = fields.value("illuminance_lx").map_or(&value.at, |value| &value.at);
            return Err(Error::new(at.clone(), "`illuminance_lx` is of a distant source, and a face is none")
                .expected("flux_lm, luminance_cd_m2 or intensity_cd here, or a [sun] with illuminance_lx"));
        }
        several => {
            let (code, what) = if several.is_empty() {
                (Code::StrengthMissing, "the emitter has no strength".into())
            } else {
                (Code::StrengthTwice, format!("the emitter has {}", several.join(" and ")))
            };
            return Err(Error::new(value.at.clone(), what)
                .expected("one of flux_lm, luminance_cd_m2, primaries_cd_m2, intensity_cd, radiant_flux_w")
                .code(code));
        }
    };
    let spectrum = match (fields.value("spectrum"), primaries) {
        (Some(value), Some(_)) => {
            return Err(Error::new(value.at.clone(), "the emitter has primaries_cd_m2 and spectrum")
                .expected("one of them: the primaries say the colour of white"));
        }
        (Some(value), None) => Some(spectrum(value)?),
        (None, Some(luminances)) => white_of(luminances).map(|rgb| SpectrumSpec::Given(Spectrum::Rgb(rgb))),
        (None, None) => None,
    };
    let polarisation = match fields.value("polarisation") {
        Some(value) => {
            let own = Fields::of(Noun::Emitter, "polarisation", value, &["angle_deg", "degree"])?;
            Some((own.need_number("angle_deg")?.to_radians(), own.need_number("degree")?))
        }
        None => None,
    };
    let both_sides = match fields.text("sides")? {
        None | Some("front") => false,
        Some(_) => true,
    };
    let picture = match (fields.has("image"), PICTURE.into_iter().find(|name| fields.has(name))) {
        (true, _) => Some(SlideSpec { primaries, ..picture(&fields, notes)? }),
        (false, None) => None,
        (false, Some(name)) => {
            let at = fields.value(name).map_or(&value.at, |value| &value.at);
            return Err(Error::new(at.clone(), format!("`{name}` of emitter is that of a picture, and there is none"))
                .expected("image = \"FILE\" beside it"));
        }
    };
    Ok(EmitterSpec { group, strength, both_sides, angular, spectrum, u: fields.direction("u")?, polarisation, picture })
}

/// The colour of Rec.709's primaries together that have these luminances; none of dark ones.
pub fn white_of(luminances: [f64; 3]) -> Option<[f64; 3]> {
    let weights = ColourSpace::Rec709.luminance_weights();
    let rgb: [f64; 3] = std::array::from_fn(|c| luminances[c] / weights[c]);
    let most = rgb.into_iter().fold(0.0, f64::max);
    (most > 0.0).then(|| rgb.map(|c| c / most))
}

fn angular(value: &Value) -> Result<Spreading> {
    let read = union(Noun::Emitter, "angular", value)?;
    match read.kind.name {
        "lambert" => Ok(Spreading::Lambert),
        "cos_n" => Ok(Spreading::CosN { n: read.fields.need_number("n")? }),
        "gauss" => Ok(Spreading::Gauss { fwhm_deg: read.fields.need_number("fwhm_deg")? }),
        name => {
            let file = read.fields.need_text("file")?.to_owned();
            let at = read.fields.value("file").map_or_else(|| value.at.clone(), |value| value.at.clone());
            Ok(if name == "ray_file" { Spreading::RayFile { file, at } } else { Spreading::Profile { file, at } })
        }
    }
}

/// A name that may be part of a layer name: `[A-Za-z][A-Za-z0-9_]*`.
pub fn group_name(name: &str, at: &Where) -> Result<String> {
    let first = name.chars().next().is_some_and(|c| c.is_ascii_alphabetic());
    if first && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
        return Ok(name.to_owned());
    }
    Err(Error::new(at.clone(), format!("group `{name}` can't be part of a layer name"))
        .expected("letters, digits and _, a letter first")
        .code(Code::GroupUnusable))
}
