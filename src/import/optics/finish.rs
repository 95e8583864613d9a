//! `finish`: what a face does with light.

use super::fields::{Fields, union};
use super::grating::GratingSpec;
use crate::value::Value;
use eyebox_base::error::Result;
use eyebox_base::{Code, Error, Where};
use eyebox_scene::attribute::Noun;
use eyebox_scene::{Finish, Note, ProjectedAxis, Retardance, StandardSurface, WavePlate};
use glam::DVec3;

/// A finish, a file that it names still to be read.
#[derive(Debug, Clone, PartialEq)]
pub enum FinishSpec {
    Given(Finish),
    /// As the face's own material says.
    Material,
    /// A wave plate of which more than one number is known, and what it is part of.
    Plate {
        plate: WavePlate,
        of: PlateOf,
    },
    /// A grating, its table still to be read.
    Grating(GratingSpec),
    /// The files as they are written, one or one of each side, and where.
    Measured {
        files: Vec<(String, Where)>,
    },
    /// An ordinary material, its pictures still to be read.
    Surface {
        surface: Box<StandardSurface>,
        at: Where,
    },
}

/// What a wave plate is part of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PlateOf {
    Retarder {
        axis: DVec3,
    },
    CircularPolariser {
        axis: DVec3,
        projected_axis: ProjectedAxis,
        transmittance: f64,
        extinction: f64,
        right: bool,
        front: bool,
    },
}

/// Faults: unknown kinds and parameters, shares out of range or together above 1.
pub fn finish(value: &Value, notes: &mut Vec<Note>) -> Result<FinishSpec> {
    let read = union(Noun::Finish, "finish", value)?;
    let fields = &read.fields;
    let mut shares = || -> Result<(f64, f64)> {
        let (reflectance, transmittance) =
            (fields.number_or("reflectance", 0.0, notes)?, fields.number_or("transmittance", 0.0, notes)?);
        if reflectance + transmittance > 1.0 {
            let what = format!("reflectance {reflectance} + transmittance {transmittance} is above 1");
            return Err(Error::new(value.at.clone(), what)
                .expected("shares that together are at most 1")
                .code(Code::ScatterGainsEnergy));
        }
        Ok((reflectance, transmittance))
    };
    Ok(FinishSpec::Given(match read.kind.name {
        "none" => Finish::None,
        "polished" => Finish::Polished,
        "absorber" => Finish::Absorber,
        "material" => return Ok(FinishSpec::Material),
        "surface" => {
            let surface = Box::new(super::surface::surface(fields, notes)?);
            return Ok(FinishSpec::Surface { surface, at: value.at.clone() });
        }
        "lambert" => {
            let (reflectance, transmittance) = shares()?;
            if let Some(surface) = super::surface::coloured_lambert(fields, [reflectance, transmittance])? {
                return Ok(FinishSpec::Surface { surface: Box::new(surface), at: value.at.clone() });
            }
            Finish::Lambert { reflectance, transmittance }
        }
        "gauss" => {
            let (reflectance, transmittance) = shares()?;
            Finish::Gauss { sigma_deg: fields.need_number("sigma_deg")?, reflectance, transmittance }
        }
        "mirror" => match (fields.number("reflectance")?, fields.number("n")?, fields.number("k")?) {
            (Some(reflectance), None, None) => Finish::MirrorIdeal { reflectance },
            (None, Some(n), Some(k)) => Finish::MirrorMetal { n, k },
            (Some(_), _, _) | (None, _, _) => {
                return Err(Error::new(value.at.clone(), "a mirror is a metal or a reflectance")
                    .expected("both `n` and `k`, or `reflectance` alone"));
            }
        },
        "polariser" => Finish::Polariser {
            axis: fields.need_direction("axis")?,
            projected_axis: projected_axis(fields)?,
            transmittance: fields.number("transmittance")?.unwrap_or(1.0),
            extinction: fields.number_or("extinction", 0.0, notes)?,
        },
        "reflective_polariser" => {
            let whole = |name: &str, leak: f64| -> Result<f64> { Ok(fields.number(name)?.unwrap_or(1.0 - leak)) };
            let transmittance_leak = fields.number_or("transmittance_leak", 0.0, notes)?;
            let reflectance_leak = fields.number_or("reflectance_leak", 0.0, notes)?;
            let (transmittance, reflectance) =
                (whole("transmittance", reflectance_leak)?, whole("reflectance", transmittance_leak)?);
            for (one, a, two, b) in [
                ("transmittance", transmittance, "reflectance_leak", reflectance_leak),
                ("reflectance", reflectance, "transmittance_leak", transmittance_leak),
            ] {
                if a + b > 1.0 {
                    return Err(Error::new(value.at.clone(), format!("{one} {a} + {two} {b} is above 1"))
                        .expected("shares of one polarisation that together are at most 1")
                        .code(Code::ScatterGainsEnergy));
                }
            }
            let (axis, projected_axis) = (fields.need_direction("axis")?, projected_axis(fields)?);
            Finish::ReflectivePolariser {
                axis,
                projected_axis,
                transmittance,
                transmittance_leak,
                reflectance,
                reflectance_leak,
            }
        }
        "retarder" => {
            let axis = fields.need_direction("axis")?;
            let plate = super::wave_plate::wave_plate(fields, false)?.ok_or_else(|| fields.missing("retardance_nm"))?;
            match (&plate.retardance, plate.indices) {
                (Retardance::Nm(rows), None) if rows.len() == 1 => Finish::Retarder { axis, retardance_nm: rows[0][1] },
                (Retardance::Nm(_) | Retardance::Waves(_), _) => {
                    return Ok(FinishSpec::Plate { plate, of: PlateOf::Retarder { axis } });
                }
            }
        }
        "grating" => return Ok(FinishSpec::Grating(super::grating::grating(fields, notes)?)),
        "circular_polariser" => {
            let of = PlateOf::CircularPolariser {
                axis: fields.need_direction("axis")?,
                projected_axis: projected_axis(fields)?,
                transmittance: fields.number("transmittance")?.unwrap_or(1.0),
                extinction: fields.number_or("extinction", 0.0, notes)?,
                right: super::wave_plate::word(fields, "handedness", ["left", "right"], None)?,
                front: !super::wave_plate::word(fields, "polariser_side", ["front", "back"], Some(false))?,
            };
            let plate = super::wave_plate::wave_plate(fields, true)?.unwrap_or_else(WavePlate::quarter);
            return Ok(FinishSpec::Plate { plate, of });
        }
        "cos_m" => {
            let (reflectance, transmittance) = shares()?;
            Finish::CosM { m: fields.need_number("m")?, reflectance, transmittance }
        }
        "rough" => Finish::Rough { alpha: fields.need_number("alpha")? },
        "abg" => Finish::Abg {
            a: fields.need_number("a")?,
            b: fields.need_number("b")?,
            g: fields.need_number("g")?,
            reflectance: fields.number_or("reflectance", 0.0, notes)?,
        },
        "measured" => {
            let at = |name: &str| fields.value(name).map_or_else(|| value.at.clone(), |value| value.at.clone());
            let mut files = vec![(fields.need_text("file")?.to_owned(), at("file"))];
            files.extend(fields.text("other_file")?.map(|file| (file.to_owned(), at("other_file"))));
            return Ok(FinishSpec::Measured { files });
        }
        name => return Err(super::fields::not_yet(&value.at, &format!("finish `{name}`"))),
    }))
}

/// The axis that light at an angle sees projected, that of absorption unless another one is said.
fn projected_axis(fields: &Fields<'_>) -> Result<ProjectedAxis> {
    let is_pass = super::wave_plate::word(fields, "projected_axis", ["absorption", "pass"], Some(false))?;
    Ok(if is_pass { ProjectedAxis::Pass } else { ProjectedAxis::Absorption })
}
