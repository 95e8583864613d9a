//! `shape`: the exact surface of a face.

use super::fields::union;
use crate::base::Fault;
use crate::base::fault::Result;
use crate::import::fit::Kind as Surface;
use crate::import::value::Value;
use crate::scene::Shape;
use crate::scene::attribute::Noun;
use glam::DVec3;

/// A shape as it is asked for.
#[derive(Debug, Clone, PartialEq)]
pub enum ShapeSpec {
    Exact(Shape),
    /// Recover it from the face's points; `radius` (its magnitude, mesh units) and `conic` replace what was found.
    Fit {
        surface: Option<Surface>,
        tolerance_um: f64,
        radius: Option<f64>,
        conic: Option<f64>,
    },
}

pub fn shape(value: &Value) -> Result<ShapeSpec> {
    let read = union(Noun::Shape, "shape", value)?;
    let fields = &read.fields;
    let vertex = || fields.need_numbers::<3>("vertex").map(DVec3::from_array);
    let axis = || fields.need_direction("axis");
    Ok(ShapeSpec::Exact(match read.kind.name {
        "mesh" => Shape::Mesh,
        "plane" => Shape::Plane { vertex: vertex()?, axis: axis()? },
        "sphere" => Shape::Sphere { vertex: vertex()?, axis: axis()?, radius: fields.need_number("radius")? },
        "conic" => Shape::Conic {
            vertex: vertex()?,
            axis: axis()?,
            radius: fields.need_number("radius")?,
            conic: fields.need_number("conic")?,
        },
        "fit" => {
            let surface = match fields.text("surface")? {
                None => None,
                Some("plane") => Some(Surface::Plane),
                Some("sphere") => Some(Surface::Sphere),
                Some("conic") => Some(Surface::Conic),
                Some(other) => {
                    return Err(Fault::new(fields.at().clone(), format!("can't fit the surface `{other}`"))
                        .expected("plane, sphere or conic")
                        .nearest(other, ["plane", "sphere", "conic"]));
                }
            };
            return Ok(ShapeSpec::Fit {
                surface,
                tolerance_um: fields.need_number("tolerance_um")?,
                radius: fields.number("radius")?,
                conic: fields.number("conic")?,
            });
        }
        name => return Err(super::fields::not_yet(&value.at, &format!("shape `{name}`"))),
    }))
}
