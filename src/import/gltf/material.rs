//! Materials: the fields of the format that mean something to light, under our own names.

use super::at::At;
use super::notes::Ledger;
use super::{surface, user};
use crate::assembly::Material;
use crate::value::{Data, Value};
use eyebox_base::Code;
use eyebox_base::colour::luminance;
use eyebox_base::error::Result;

/// Reads material `index`. Only what the file says is mapped; its defaults are ours to choose.
///
/// | entry | from | unit |
/// |---|---|---|
/// | `ior` | `KHR_materials_ior` (default 1.5 when the extension is there) | – |
/// | `dispersion` | `KHR_materials_dispersion` | 20/V_d |
/// | `transmission` | `KHR_materials_transmission.transmissionFactor` | 0–1 |
/// | `thickness` | `KHR_materials_volume.thicknessFactor` | mesh units; > 0 says solid |
/// | `attenuation_distance`, `attenuation_color` | `KHR_materials_volume` | m; transmittance over that distance |
/// | `luminance_cd_m2` | `emissiveFactor` × `KHR_materials_emissive_strength`, if not black: of a white `emissiveTexture` | cd/m² |
/// | `emitter.spectrum` | `emissiveFactor`, if not grey | – |
/// | `coating` | `KHR_materials_iridescence`, see [`surface::iridescence`] | – |
///
/// # Errors
/// Values of the wrong kind or out of the range that the specification gives.
pub(super) fn read(at: &At<'_>, index: usize, ledger: &mut Ledger) -> Result<Material> {
    let mut mapped = Vec::new();
    let mut entry = |name: &str, data: Data, at: &At<'_>| mapped.push((name.to_owned(), Value::new(data, at.place())));

    if let Some(extension) = at.extension("KHR_materials_ior")? {
        let field = extension.get("ior")?;
        let place = field.as_ref().unwrap_or(&extension);
        let ior = field.as_ref().map_or(Ok(1.5), |field| field.number())?;
        if ior == 0.0 {
            // A workaround for specular-glossiness conversions: "reflects everything", not a refractive index.
            ledger.notes.warn_of(Code::IndexImpossible, place, "`ior` 0 is not a refractive index: ignored");
        } else if ior >= 1.0 {
            entry("ior", Data::Number(ior), place);
        } else {
            return Err(place
                .fault(format!("index of refraction {ior}"))
                .expected("at least 1 (or 0)")
                .code(Code::IndexImpossible));
        }
    }
    const NUMBERS: [(&str, &str, &str, f64); 3] = [
        ("dispersion", "KHR_materials_dispersion", "dispersion", f64::INFINITY),
        ("transmission", "KHR_materials_transmission", "transmissionFactor", 1.0),
        ("thickness", "KHR_materials_volume", "thicknessFactor", f64::INFINITY),
    ];
    for (name, extension, field, most) in NUMBERS {
        if let Some(extension) = at.extension(extension)?
            && let Some(field) = extension.get(field)?
        {
            entry(name, Data::Number(field.number_in(0.0, most)?), &field);
        }
    }
    if let Some(volume) = at.extension("KHR_materials_volume")? {
        if let Some(field) = volume.get("attenuationDistance")? {
            let distance = field.number()?;
            if distance <= 0.0 {
                return Err(field.fault(format!("attenuation distance {distance}")).expected("more than 0"));
            }
            entry("attenuation_distance", Data::Number(distance), &field);
        }
        if let Some(field) = volume.get("attenuationColor")? {
            let mut lanes = Vec::new();
            for lane in field.numbers::<3>().and_then(|_| field.items())? {
                lanes.push(Value::new(Data::Number(lane.number_in(0.0, 1.0)?), lane.place()));
            }
            entry("attenuation_color", Data::List(lanes), &field);
        }
    }
    if let Some(field) = at.get("emissiveFactor")? {
        let [r, g, b] = field.numbers()?;
        if r.min(g).min(b) < 0.0 {
            return Err(field.fault("negative emission").expected("numbers from 0"));
        }
        let strength = match at.extension("KHR_materials_emissive_strength")? {
            Some(extension) => match extension.get("emissiveStrength")? {
                Some(strength) => strength.number_in(0.0, f64::INFINITY)?,
                None => 1.0,
            },
            None => 1.0,
        };
        let luminance = strength * luminance([r, g, b]);
        if !luminance.is_finite() {
            return Err(field.fault("the emission overflows").expected("finite cd/m²"));
        }
        if luminance > 0.0 {
            entry("luminance_cd_m2", Data::Number(luminance), &field);
            if r != g || g != b {
                let lanes = [r, g, b].map(|lane| Value::new(Data::Number(lane), field.place()));
                let rgb = ("rgb".to_owned(), Value::new(Data::List(lanes.to_vec()), field.place()));
                entry("emitter.spectrum", Data::Table(vec![rgb]), &field);
            }
            if let Some(both) = at.get("doubleSided")?
                && both.flag()?
            {
                entry("emitter.sides", Data::Text("both".to_owned()), &both);
            }
        }
    }
    mapped.extend(surface::iridescence(at)?);
    let looks = surface::looks(at, ledger)?;
    Ok(Material {
        name: at.name("material", index)?,
        mapped,
        attributes: at.optics(&mut ledger.budget)?,
        looks,
        surface: None,
        user: user::of(at, ledger)?,
        at: at.place(),
    })
}
