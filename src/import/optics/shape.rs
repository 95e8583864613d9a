//! `shape`: the exact surface of a face.

use super::fields::{Fields, union};
use crate::fit::Kind as Surface;
use crate::value::Value;
use eyebox_base::Error;
use eyebox_base::error::Result;
use eyebox_scene::attribute::Noun;
use eyebox_scene::{Note, Shape};
use glam::DVec3;

/// A shape as it is asked for.
#[derive(Debug, Clone, PartialEq)]
pub enum ShapeSpec {
    Exact(Shape),
    /// Recover it from the face's points; `radius` and `tube_radius` (their magnitudes, mesh units) and `conic`
    /// replace what was found.
    Fit {
        surface: Option<Surface>,
        tolerance_um: f64,
        radius: Option<f64>,
        conic: Option<f64>,
        tube_radius: Option<f64>,
    },
}

/// Faults: attributes that are missing, of the wrong form or out of range, an x along the axis.
pub fn shape(value: &Value, notes: &mut Vec<Note>) -> Result<ShapeSpec> {
    let read = union(Noun::Shape, "shape", value)?;
    let fields = &read.fields;
    let vertex = || fields.need_numbers::<3>("vertex").map(DVec3::from_array);
    let axis = || fields.need_direction("axis");
    let number = |name: &str| fields.need_number(name);
    let mut x = || across(fields, notes);
    Ok(ShapeSpec::Exact(match read.kind.name {
        "mesh" => Shape::Mesh,
        "plane" => Shape::Plane { vertex: vertex()?, axis: axis()? },
        "sphere" => Shape::Sphere { vertex: vertex()?, axis: axis()?, radius: number("radius")? },
        "conic" => {
            Shape::Conic { vertex: vertex()?, axis: axis()?, radius: number("radius")?, conic: number("conic")? }
        }
        "asphere" => Shape::Asphere {
            vertex: vertex()?,
            axis: axis()?,
            radius: number("radius")?,
            conic: number("conic")?,
            even: fields.need_coefficients("even")?,
        },
        "cylinder" => Shape::Cylinder { vertex: vertex()?, axis: axis()?, x: x()?, radius: number("radius")? },
        "toroid" => Shape::Toroid {
            vertex: vertex()?,
            axis: axis()?,
            x: x()?,
            radius: number("radius")?,
            tube_radius: number("tube_radius")?,
        },
        "xy_poly" => Shape::XyPoly {
            vertex: vertex()?,
            axis: axis()?,
            x: x()?,
            radius: number("radius")?,
            conic: number("conic")?,
            coeffs: fields.need_coefficients("coeffs")?,
        },
        "zernike" => Shape::Zernike {
            vertex: vertex()?,
            axis: axis()?,
            x: x()?,
            radius: number("radius")?,
            conic: number("conic")?,
            norm_radius: number("norm_radius")?,
            coeffs: fields.need_coefficients("coeffs")?,
        },
        "bspline" => {
            let spans = fields.need_numbers::<2>("spans")?;
            if spans.iter().any(|n| n.fract() != 0.0) {
                let at = fields.value("spans").map_or(fields.at(), |value| &value.at);
                let what = format!("`spans` of a bspline is {} x {}", spans[0], spans[1]);
                return Err(Error::new(at.clone(), what).expected("two whole numbers from 1 to 1024"));
            }
            Shape::Bspline {
                vertex: vertex()?,
                axis: axis()?,
                x: x()?,
                radius: number("radius")?,
                conic: number("conic")?,
                half: fields.need_numbers::<2>("half")?,
                spans: spans.map(|n| n as u32),
                // Whether they are as many as the spans take is said where the surface is made.
                coeffs: fields.need_coefficients("coeffs")?,
            }
        }
        "fit" => {
            let surface = match fields.text("surface")? {
                None => None,
                Some(word) => Some(Surface::named(word).ok_or_else(|| {
                    let names = Surface::ALL.map(Surface::name);
                    Error::new(fields.at().clone(), format!("can't fit the surface `{word}`"))
                        .expected(super::fields::one_of(names.into_iter()))
                        .nearest(word, names)
                })?),
            };
            return Ok(ShapeSpec::Fit {
                surface,
                tolerance_um: number("tolerance_um")?,
                radius: fields.number("radius")?,
                conic: fields.number("conic")?,
                tube_radius: fields.number("tube_radius")?,
            });
        }
        name => return Err(super::fields::not_yet(&value.at, &format!("shape `{name}`"))),
    }))
}

/// The x direction at right angles to the axis, or the default with a note.
fn across(fields: &Fields, notes: &mut Vec<Note>) -> Result<DVec3> {
    let axis = fields.need_direction("axis")?;
    let Some(x) = fields.direction("x")? else {
        notes.push(fields.defaulted("x"));
        return Ok(Shape::default_x(axis));
    };
    let across = x - x.dot(axis) * axis;
    // Within what f32 files round, x along the axis has no direction across it.
    if across.length() <= 1e-6 {
        let at = fields.value("x").map_or(fields.at(), |value| &value.at);
        return Err(Error::new(at.clone(), "`x` of shape is along its axis").expected("a direction across the axis"));
    }
    Ok(across.normalize())
}
