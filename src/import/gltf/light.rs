//! Lights that are no geometry: `KHR_lights_punctual` and `EXT_lights_ies`, on the nodes that hold them.

use super::accessor::Document;
use super::at::At;
use super::buffers;
use super::notes::Ledger;
use crate::assembly::{LightForm, LightProfile, LightSource, ProfileSource};
use eyebox_base::error::Result;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
use std::sync::Arc;

const PUNCTUAL: &str = "KHR_lights_punctual";
const IES: &str = "EXT_lights_ies";

/// The lights that the node `at` holds; `index` is its place in `Assembly::nodes`, `name` its name.
///
/// | form | from | unit |
/// |---|---|---|
/// | `Point` | `point` and `spot` (with its cones), `intensity` × luminance of `color` | cd |
/// | `Distant` | `directional` | lx |
/// | `Point` with a profile | `EXT_lights_ies`, `multiplier` × luminance of `color`; the profile's candela count | – |
///
/// # Errors
/// A light that does not exist, an unknown type, numbers out of the range that the specification gives.
pub(super) fn read(
    document: &Document<'_>,
    at: &At<'_>,
    index: usize,
    name: &str,
    ledger: &mut Ledger,
) -> Result<Vec<LightSource>> {
    let mut lights = Vec::new();
    if let Some(use_at) = at.extension(PUNCTUAL)?
        && let Some(reference) = use_at.get("light")?
    {
        let light = find(document, PUNCTUAL, &reference)?;
        let (strength, color) = colour(&light, "intensity", ledger)?;
        lights.push(LightSource {
            name: named(&light, name, ledger)?,
            node: index,
            form: punctual(&light, strength, ledger)?,
            color,
            kelvin: None,
            profile: None,
            attributes: None,
            at: light.place(),
        });
    }
    if let Some(use_at) = at.extension(IES)?
        && let Some(reference) = use_at.get("light")?
    {
        let light = find(document, IES, &reference)?;
        let (strength, color) = colour(&use_at, "multiplier", ledger)?;
        let source = match (light.get("uri")?, light.get("bufferView")?) {
            (Some(uri), _) => match buffers::data_scheme(uri.text()?) {
                Some(rest) => ProfileSource::Embedded(Arc::new(buffers::data_uri(&uri, rest)?)),
                None => ProfileSource::File(buffers::resolve(&uri, uri.text()?)?),
            },
            (None, Some(view)) => ProfileSource::Embedded(Arc::new(document.view(&view)?.bytes.to_vec())),
            (None, None) => return Err(light.fault("a light profile without data").expected("`uri` or `bufferView`")),
        };
        if let ProfileSource::Embedded(bytes) = &source {
            ledger.budget.charge(&light, 1, bytes.len())?;
        }
        let profile = Some(LightProfile::of(source, strength));
        lights.push(LightSource {
            name: named(&light, name, ledger)?,
            node: index,
            form: LightForm::Point { intensity_cd: strength, cone: None },
            color,
            kelvin: None,
            profile,
            attributes: None,
            at: light.place(),
        });
    }
    Ok(lights)
}

fn find<'a>(document: &Document<'a>, extension: &str, reference: &At<'_>) -> Result<At<'a>> {
    let missing = || reference.fault(format!("the asset has no `{extension}` with `lights`"));
    let lights = document.root.extension(extension)?.ok_or_else(missing)?.list("lights")?;
    let index = reference.index(lights.len(), "light")?;
    lights.into_iter().nth(index).ok_or_else(missing)
}

fn named(light: &At<'_>, node: &str, ledger: &mut Ledger) -> Result<String> {
    let name = light.get("name")?.map_or(Ok(node), |name| name.text())?;
    ledger.budget.charge(light, 1, size_of::<LightSource>() + name.len() + light.pointer.len())?;
    Ok(if name.is_empty() { node } else { name }.to_owned())
}

/// Strength (its entry `key`, 1 if absent) times the luminance of `color`, and the colour at luminance 1.
fn colour(at: &At<'_>, key: &str, ledger: &mut Ledger) -> Result<(f64, [f64; 3])> {
    let strength = at.get(key)?.map_or(Ok(1.0), |field| field.number_in(0.0, f64::INFINITY))?;
    let Some(field) = at.get("color")? else { return Ok((strength, [1.0; 3])) };
    let color: [f64; 3] = field.numbers()?;
    if color.iter().any(|lane| *lane < 0.0) {
        return Err(field.fault("a negative colour").expected("3 numbers from 0 to 1"));
    }
    let luminance = eyebox_base::colour::luminance(color);
    let whole = strength * luminance;
    if !whole.is_finite() {
        return Err(field.fault("the light overflows").expected("3 numbers from 0 to 1"));
    }
    if luminance <= 0.0 {
        ledger.notes.warn(&field, "a black light");
        return Ok((0.0, [1.0; 3]));
    }
    let color = color.map(|lane| lane / luminance);
    Ok((whole, if color.iter().all(|lane| lane.is_finite()) { color } else { [1.0; 3] }))
}

fn punctual(light: &At<'_>, strength: f64, ledger: &mut Ledger) -> Result<LightForm> {
    if let Some(range) = light.get("range")? {
        range.number()?;
        ledger.notes.info(&range, "`range` of a light is for drawing programs: light reaches everywhere here");
    }
    let kind = light.want("type")?;
    match kind.text()? {
        "directional" => Ok(LightForm::Distant { illuminance_lx: strength, angle: 0.0 }),
        "point" => Ok(LightForm::Point { intensity_cd: strength, cone: None }),
        "spot" => {
            let spot = light.want("spot")?;
            let angle = |key: &str, default: f64| {
                spot.get(key)?.map_or(Ok(default), |field| field.number_in(0.0, FRAC_PI_2 + 1e-6))
            };
            let (inner, outer) = (angle("innerConeAngle", 0.0)?, angle("outerConeAngle", FRAC_PI_4)?);
            if inner >= outer {
                return Err(spot
                    .fault(format!("the inner cone {inner} is not inside the outer {outer}"))
                    .expected("innerConeAngle < outerConeAngle"));
            }
            Ok(LightForm::Point { intensity_cd: strength, cone: Some((inner, outer)) })
        }
        other => {
            let kinds = ["point", "spot", "directional"];
            Err(kind.fault("unknown type of light").expected(kinds.join(", ")).nearest(other, kinds))
        }
    }
}
