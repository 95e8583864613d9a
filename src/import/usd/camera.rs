//! UsdGeomCamera. Apertures and focal length are in tenths of a scene unit, `focusDistance` in scene units.

use super::attribute::PrimView;
use super::ledger::Ledger;
use super::marks::{Marks, refined};
use crate::base::fault::Result;
use crate::import::assembly::Camera;
use glam::DAffine3;

/// Fallbacks of the schema: a 50 mm lens before a 35 mm full aperture, in tenths of a unit.
const FOCAL_LENGTH: f64 = 50.0;
const HORIZONTAL: f64 = 20.955;
const VERTICAL: f64 = 15.2908;

/// # Errors
/// Apertures or a focal length that are not > 0.
pub(super) fn read(view: &PrimView, to_world: DAffine3, ledger: &mut Ledger) -> Result<Camera> {
    let positive = |name: &str, fallback: f64| -> Result<f64> {
        let x = view.number(name)?.unwrap_or(fallback);
        if x.is_finite() && x > 0.0 {
            return Ok(x);
        }
        Err(view.fault_in(name, format!("the value {x}")).expected("a finite number > 0"))
    };
    let marks = Marks::of(view)?;
    let name = marks.text("name").unwrap_or(view.name()).to_owned();
    if view.token("projection")?.as_deref() == Some("orthographic") {
        ledger.warn(view.at(), "an orthographic camera is no eye: not used");
        return Ok(Camera { name, to_world, yfov: None, aspect: None });
    }
    let (width, height) = (positive("horizontalAperture", HORIZONTAL)?, positive("verticalAperture", VERTICAL)?);
    let focal = positive("focalLength", FOCAL_LENGTH)?;
    for offset in ["horizontalApertureOffset", "verticalApertureOffset"] {
        if view.number(offset)?.is_some_and(|x| x != 0.0) {
            ledger.warn(view.at_property(offset), "a shifted aperture is not used");
        }
    }
    if view.number("fStop")?.is_some_and(|x| x > 0.0) {
        ledger.info(view.at_property("fStop"), "fStop is not used: the eye's pupil is said by `pupil_diameter`");
    }
    let yfov = refined(marks.number("yfov"), 2.0 * (0.5 * height / focal).atan());
    Ok(Camera { name, to_world, yfov: Some(yfov), aspect: Some(refined(marks.number("aspect"), width / height)) })
}
