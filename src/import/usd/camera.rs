//! UsdGeomCamera. Apertures and focal length are in tenths of a scene unit, `focusDistance` in scene units.

use super::attribute::PrimView;
use super::notes::Ledger;
use super::round_trip::{RoundTrip, refined};
use crate::base::error::Result;
use crate::import::assembly::Camera;
use glam::DAffine3;

/// Fallbacks of the schema: a 50 mm lens before a 35 mm full aperture, in tenths of a unit.
const FOCAL_LENGTH: f64 = 50.0;
const HORIZONTAL: f64 = 20.955;
const VERTICAL: f64 = 15.2908;
/// Scene units of a unit of focal length.
const TENTH: f64 = 0.1;

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
    let marks = RoundTrip::of(view)?;
    let name = marks.text("name").unwrap_or(view.name()).to_owned();
    if view.token("projection")?.as_deref() == Some("orthographic") {
        ledger.warn(view.at(), "an orthographic camera is no eye: not used");
        return Ok(Camera { name, node: None, to_world, yfov: None, aspect: None, pupil: None, focus: None });
    }
    let (width, height) = (positive("horizontalAperture", HORIZONTAL)?, positive("verticalAperture", VERTICAL)?);
    let focal = positive("focalLength", FOCAL_LENGTH)?;
    for offset in ["horizontalApertureOffset", "verticalApertureOffset"] {
        if view.number(offset)?.is_some_and(|x| x != 0.0) {
            ledger.warn(view.at_property(offset), "a shifted aperture is not used");
        }
    }
    // 0, the fallback of both, says nothing: no depth of field, no distance that is sharp.
    let said = |name: &str| -> Result<Option<f64>> { Ok(view.length(name)?.filter(|x| *x > 0.0)) };
    // f-number: focal length by diameter. A tenth: see above.
    let pupil = said("fStop")?.map(|number| focal * TENTH / number);
    Ok(Camera {
        name,
        node: None,
        to_world,
        yfov: Some(refined(marks.number("yfov"), 2.0 * (0.5 * height / focal).atan())),
        aspect: Some(refined(marks.number("aspect"), width / height)),
        pupil: pupil.map(|pupil| refined(marks.number("pupil"), pupil)),
        focus: said("focusDistance")?.map(|focus| refined(marks.number("focus"), focus)),
    })
}
