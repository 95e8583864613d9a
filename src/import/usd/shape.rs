//! What shapes a light: cones, profiles; and what of UsdLux means nothing here.

use super::attribute::PrimView;
use super::light::{file, flag};
use super::reader::Reader;
use super::round_trip::{RoundTrip, refined};
use crate::assembly::{LightForm, LightProfile, ProfileSource};
use eyebox_base::error::Result;

/// (inner, outer) half angle of a cone, if one is said: full inside angle · (1 − softness), nothing outside of angle
/// (UsdLuxShapingAPI).
///
/// # Errors
/// Values that are negative or not finite.
pub(super) fn cone(view: &PrimView, marks: &RoundTrip) -> Result<Option<(f64, f64)>> {
    let Some(angle) = angle(view)? else { return Ok(None) };
    let softness = view.length("inputs:shaping:cone:softness")?.unwrap_or(0.0).min(1.0);
    let outer = refined(marks.number("cone_outer"), angle.to_radians());
    if angle >= 180.0 {
        return Ok(None);
    }
    let rounded = outer * (1.0 - softness);
    // The softness is a difference: its rounding counts against the whole cone.
    let exact = marks.number("cone_inner").filter(|inner| (inner - rounded).abs() <= 1e-6 * outer);
    Ok(Some((exact.unwrap_or(rounded), outer)))
}

/// The half angle of the cone in degrees: 90 where the schema is applied and says nothing else. Beside a profile only what
/// is said counts: the schema's own would cut half of it off.
fn angle(view: &PrimView) -> Result<Option<f64>> {
    if let Some(angle) = view.length("inputs:shaping:cone:angle")? {
        return Ok(Some(angle));
    }
    if view.has("inputs:shaping:ies:file") {
        return Ok(None);
    }
    let schemas = view.prim.api_schemas().map_err(|error| view.moment.failed(view.path(), error))?;
    Ok(schemas.iter().any(|schema| schema.as_str() == "ShapingAPI").then_some(90.0))
}

/// The measured intensity distribution. UsdLux multiplies the light's luminance by the file's candela, which is neither;
/// here intensity · 2^exposure · colour, 1 for a lamp as it was measured, is a factor of the candela, whatever the size of
/// the light.
///
/// # Errors
/// A value of another type.
pub(super) fn profile(
    reader: &mut Reader,
    view: &PrimView,
    strength: f64,
    marks: &RoundTrip,
) -> Result<Option<LightProfile>> {
    let Some(found) = file(view, "inputs:shaping:ies:file")? else { return Ok(None) };
    let angle_scale = view.number("inputs:shaping:ies:angleScale")?.unwrap_or(0.0);
    if !angle_scale.is_finite() {
        reader.ledger.warn(view.at_property("inputs:shaping:ies:angleScale"), "not a finite number: ignored");
    }
    Ok(Some(LightProfile {
        source: ProfileSource::File(found),
        factor: refined(marks.number("profile_factor"), strength),
        normalize: flag(view, "inputs:shaping:ies:normalize")?,
        angle_scale: if angle_scale.is_finite() { angle_scale } else { 0.0 },
    }))
}

/// Notes on what is said and not used.
///
/// # Errors
/// Values of the wrong type.
pub(super) fn unused(reader: &mut Reader, view: &PrimView, form: &LightForm) -> Result<()> {
    // From where on the cone holds all that the light sends, in degrees. What is far away has no cone in USD, either.
    let all = match form {
        LightForm::Point { .. } | LightForm::Distant { .. } | LightForm::Dome { .. } => 0.0,
        LightForm::Rect { .. } | LightForm::Disk { .. } => 90.0,
        LightForm::Sphere { .. } | LightForm::Cylinder { .. } => 180.0,
    };
    if angle(view)?.is_some_and(|angle| angle < all) {
        let text = "the cone of a light with a surface is not used: it shines to all of its front";
        reader.ledger.warn(view.at_property("inputs:shaping:cone:angle"), text);
    }
    for (name, neutral) in [
        ("inputs:shaping:focus", 0.0),
        ("inputs:diffuse", 1.0),
        ("inputs:specular", 1.0),
        ("inputs:shadow:enable", 1.0),
    ] {
        if view.number(name)?.is_some_and(|x| x != neutral) {
            reader.ledger.warn(view.at_property(name), format!("`{name}` is not used: light does what it does"));
        }
    }
    if !view.targets("light:filters")?.is_empty() {
        reader.ledger.warn(view.at_property("light:filters"), "light filters are not used");
    }
    if view.has("portals") {
        reader.ledger.info(view.at_property("portals"), "portals change no light, only how it is found");
    }
    for link in ["lightLink", "shadowLink"] {
        for end in ["includes", "excludes"] {
            let name = format!("collection:{link}:{end}");
            if !view.targets(&name)?.is_empty() {
                reader.ledger.warn(view.at_property(&name), format!("`{link}` is not used: light reaches everything"));
            }
        }
    }
    Ok(())
}
