//! In what the strengths of an asset's own lights count: formats say candela, lux and nit, programs that make pictures for films
//! count in watts and some write these as they are.

use super::assembly::{Assembly, LightForm, LightSource};
use super::value::{Data, Value};
use eyebox_base::Where;
use eyebox_scene::Note;

/// Lumen a watt at 540 THz, the constant K_cd by which the candela is defined (SI brochure, 9th edition, 2.3.1).
const LUMEN_A_WATT: f64 = 683.0;

/// `--light-units`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LightUnits {
    /// As the format has it; a note tells of the other.
    #[default]
    Unsaid,
    /// As the format has it: nit, candela, lux.
    Nit,
    /// Watts in place of lumens.
    Watt,
}

impl LightUnits {
    const NAMES: [(&'static str, LightUnits); 2] = [("nit", LightUnits::Nit), ("watt", LightUnits::Watt)];

    /// # Errors
    /// Neither `nit` nor `watt`.
    pub fn parse(text: &str) -> Result<Self, String> {
        let found = Self::NAMES.iter().find(|(name, _)| *name == text).map(|(_, units)| *units);
        found.ok_or_else(|| format!("`{text}` is no unit of lights; write nit or watt"))
    }
}

/// Takes the strengths of the lights that an asset itself has in these units. Lights with a measured distribution have the
/// candela of its file.
pub(super) fn take(assembly: &mut Assembly, units: LightUnits) {
    match units {
        LightUnits::Unsaid | LightUnits::Nit => return,
        LightUnits::Watt => {}
    }
    for light in assembly.lights.iter_mut().filter(|light| counts(light)) {
        let strength = match &mut light.form {
            LightForm::Point { intensity_cd: strength, .. }
            | LightForm::Rect { luminance_cd_m2: strength, .. }
            | LightForm::Disk { luminance_cd_m2: strength, .. }
            | LightForm::Sphere { luminance_cd_m2: strength, .. }
            | LightForm::Cylinder { luminance_cd_m2: strength, .. }
            | LightForm::Distant { illuminance_lx: strength, .. }
            | LightForm::Dome { scale_cd_m2: strength, .. } => strength,
        };
        *strength *= LUMEN_A_WATT;
    }
    for attributes in assembly.nodes.iter_mut().filter_map(|node| node.attributes.as_mut()) {
        mesh_light(attributes);
    }
    // With other units it is another scene.
    assembly.variants.push("lights in watts".to_owned());
}

/// What should be said of the units: of lights of strengths that may be watts, unless somebody has said what they are.
pub(super) fn note(assembly: &Assembly, units: LightUnits) -> Option<Note> {
    let light = assembly.lights.iter().find(|light| counts(light) && !is_dome(light))?;
    let text = match units {
        LightUnits::Unsaid => {
            "lights have nit, candela and lux, as the format says; of a program that has written watts, `--light-units watt` \
             takes 683 lm/W"
        }
        LightUnits::Watt => "lights have watts: 683 lm/W",
        LightUnits::Nit => return None,
    };
    Some(Note::info(light.at.clone(), text))
}

/// Whether its strength is its own and not that of a measured distribution.
fn counts(light: &LightSource) -> bool {
    light.profile.as_ref().is_none_or(|profile| profile.normalize)
}

fn is_dome(light: &LightSource) -> bool {
    match light.form {
        LightForm::Dome { .. } => true,
        LightForm::Point { .. }
        | LightForm::Rect { .. }
        | LightForm::Disk { .. }
        | LightForm::Sphere { .. }
        | LightForm::Cylinder { .. }
        | LightForm::Distant { .. } => false,
    }
}

/// A mesh that is a light (MeshLightAPI of USD) has become a lamp, from its `inputs:intensity`.
fn mesh_light(attributes: &mut Value) {
    let Data::Table(rows) = &mut attributes.data else { return };
    let emitters = rows.iter_mut().filter(|(key, _)| key == "emitter").map(|(_, value)| value);
    for emitter in emitters.filter(|emitter| is_of_light(&emitter.at)) {
        let Data::Table(rows) = &mut emitter.data else { continue };
        for (_, value) in rows.iter_mut().filter(|(key, _)| key == "luminance_cd_m2") {
            if let Data::Number(luminance) = &mut value.data {
                *luminance *= LUMEN_A_WATT;
            }
        }
    }
}

fn is_of_light(at: &Where) -> bool {
    match at {
        Where::Prim { prim, .. } => prim.ends_with(".inputs:intensity"),
        Where::Nowhere
        | Where::File(_)
        | Where::Line { .. }
        | Where::Pointer { .. }
        | Where::Part { .. }
        | Where::Option(_) => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_have_names() {
        assert_eq!(LightUnits::parse("watt"), Ok(LightUnits::Watt));
        assert_eq!(LightUnits::parse("nit"), Ok(LightUnits::Nit));
        assert!(LightUnits::parse("lumen").is_err_and(|text| text.contains("nit or watt")));
    }
}
