//! What the fields that a format has of its own for materials mean in our vocabulary: the weakest that an asset can say.

use super::assembly::Material;
use super::value::{Data, Value};
use eyebox_base::colour::luminance;
use eyebox_base::error::Result;
use eyebox_base::{Code, Error};
use eyebox_scene::Note;

/// The attributes that `material.mapped` amounts to. Names that our vocabulary has pass as they are, dotted ones as
/// tables. `transmission`, `thickness`, `dispersion`, `attenuation_*` and `luminance_cd_m2` are taken as the ratified
/// glTF extensions define them: dispersion = 20/V_d, thickness > 0 is a solid, T = colour^(x/distance).
///
/// Faults: a solid that lets nothing through and yet transmits.
pub fn mapped(material: &Material, notes: &mut Vec<Note>) -> Result<Vec<(String, Value)>> {
    let find = |name: &str| material.mapped.iter().find(|(key, _)| key == name).map(|(_, value)| value);
    let number = |name: &str| find(name).and_then(|value| value.number().map(|number| (number, value)));
    let mut note = |note: Note| {
        notes.push(Note { text: format!("material `{}`: {}", material.name, note.text), ..note });
    };
    let mut all: Vec<(String, Value)> = Vec::new();
    for (key, value) in &material.mapped {
        match key.as_str() {
            "ior" | "dispersion" | "transmission" | "thickness" | "attenuation_distance" | "attenuation_color" => {}
            "luminance_cd_m2" => nest(&mut all, "emitter", key, value),
            dotted => match dotted.split_once('.') {
                Some((head, tail)) => nest(&mut all, head, tail, value),
                None => all.push((key.clone(), value.clone())),
            },
        }
    }
    let solid = number("thickness").filter(|(thickness, _)| *thickness > 0.0);
    let clear = match number("transmission") {
        Some((share, value)) if share >= 1.0 => Some(value),
        Some((share, value)) if share > 0.0 && solid.is_some() => {
            let text =
                format!("transmission {share} of a solid is between 0 and 1: its faces are taken as thin sheets");
            note(Note::warning(value.at.clone(), text).code(Code::TransmissionPartial));
            None
        }
        Some(_) | None => None,
    };
    if let Some(value) = clear {
        // What nothing is said of is polished: the formats' own defaults, fully rough or nearly so, mean no glass.
        let roughness = material.looks.iter().find(|(key, _)| key == "roughness").and_then(|(_, value)| value.number());
        let finish = match (solid, roughness) {
            (Some(_), Some(roughness)) if roughness > 0.0 => {
                let alpha = (roughness * roughness).clamp(1e-4, 1.0);
                let row = |key: &str, data: Data| (key.to_owned(), Value::new(data, value.at.clone()));
                Data::Table(vec![row("kind", Data::Text("rough".into())), row("alpha", Data::Number(alpha))])
            }
            (Some(_) | None, _) => Data::Text("polished".into()),
        };
        all.push(("finish".to_owned(), Value::new(finish, value.at.clone())));
    }
    // What transmits and is not said to be solid is a thin sheet, which no medium is behind.
    let sheet = clear.is_some() && solid.is_none();
    match (number("ior"), number("dispersion").filter(|(dispersion, _)| *dispersion > 0.0)) {
        (_, _) if sheet => {}
        (ior, Some((dispersion, value))) => {
            // KHR_materials_ior: 1.5 where it isn't said.
            let n_d = Value::new(Data::Number(ior.map_or(1.5, |(ior, _)| ior)), value.at.clone());
            let v_d = Value::new(Data::Number(20.0 / dispersion), value.at.clone());
            all.push(("abbe".to_owned(), Value::new(Data::List(vec![n_d, v_d]), value.at.clone())));
        }
        (Some((_, value)), None) => all.push(("ior".to_owned(), value.clone())),
        (None, None) => {
            if let (Some((_, value)), Some(_)) = (solid, clear) {
                note(Note::info(value.at.clone(), "`ior` is not said: 1.5"));
                all.push(("ior".to_owned(), Value::new(Data::Number(1.5), value.at.clone())));
            }
        }
    }
    if let (Some(_), Some((distance, value))) = (solid, number("attenuation_distance").filter(|(d, _)| d.is_finite())) {
        let lanes: Vec<f64> =
            find("attenuation_color").and_then(Value::list).unwrap_or(&[]).iter().filter_map(Value::number).collect();
        let rgb = match lanes.as_slice() {
            [r, g, b] => [*r, *g, *b].map(|c| c.min(1.0)),
            _ => [1.0; 3],
        };
        if luminance(rgb) <= 0.0 && clear.is_none() {
            note(Note::warning(value.at.clone(), "attenuates to black, and transmits nothing: not used"));
            return Ok(all);
        }
        if luminance(rgb) <= 0.0 {
            return Err(Error::new(value.at.clone(), format!("material `{}` attenuates to black", material.name))
                .expected("an attenuation colour above 0, or an absorbing finish"));
        }
        let number = |x: f64| Value::new(Data::Number(x), value.at.clone());
        let data = if rgb[0] == rgb[1] && rgb[1] == rgb[2] {
            Data::Number(-rgb[0].ln() / distance)
        } else {
            // Falls by the three primaries (`Absorption::Colour`).
            let colour = Value::new(Data::List(rgb.map(number).to_vec()), value.at.clone());
            Data::Table(vec![
                ("attenuation_color".to_owned(), colour),
                ("attenuation_distance".to_owned(), number(distance)),
            ])
        };
        all.push(("absorption_per_m".to_owned(), Value::new(data, value.at.clone())));
    }
    Ok(all)
}

/// Puts `key = value` into the table `head`.
fn nest(all: &mut Vec<(String, Value)>, head: &str, key: &str, value: &Value) {
    let entry = (key.to_owned(), value.clone());
    match all.iter_mut().find(|(own, _)| own == head) {
        Some((_, Value { data: Data::Table(table), .. })) => table.push(entry),
        Some(_) | None => all.push((head.to_owned(), Value::new(Data::Table(vec![entry]), value.at.clone()))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::assembly;
    use eyebox_base::Where;

    fn said(rows: &[(&str, f64)]) -> (Vec<String>, usize) {
        let mut material = assembly(&[]).materials.remove(0);
        let value = |x: f64| Value::new(Data::Number(x), Where::Nowhere);
        for (key, x) in rows {
            let value = if *key == "attenuation_color" {
                Value::new(Data::List(vec![value(*x); 3]), Where::Nowhere)
            } else {
                value(*x)
            };
            material.mapped.push(((*key).to_owned(), value));
        }
        let mut notes = Vec::new();
        let all = mapped(&material, &mut notes).unwrap();
        (all.into_iter().map(|(key, value)| format!("{key} = {value}")).collect(), notes.len())
    }

    #[test]
    fn gltf_materials_in_our_words() {
        assert_eq!(said(&[("ior", 1.4)]), (vec!["ior = 1.4".into()], 0));
        assert_eq!(said(&[("ior", 1.4), ("dispersion", 0.5)]), (vec!["abbe = [1.4, 40]".into()], 0));
        assert_eq!(said(&[("luminance_cd_m2", 7.0)]), (vec!["emitter = { luminance_cd_m2 = 7 }".into()], 0));
        assert_eq!(said(&[("transmission", 0.5), ("thickness", 1.0)]), (vec![], 1));
        let mut frosted = assembly(&[]).materials.remove(0);
        let value = |x: f64| Value::new(Data::Number(x), Where::Nowhere);
        frosted.mapped = vec![("transmission".into(), value(1.0)), ("thickness".into(), value(1.0))];
        frosted.looks = vec![("roughness".into(), value(0.5))];
        let (_, finish) = mapped(&frosted, &mut Vec::new()).unwrap().remove(0);
        assert_eq!(finish.to_string(), "{ kind = \"rough\", alpha = 0.25 }");
        assert_eq!(
            said(&[("transmission", 1.0), ("thickness", 1.0)]),
            (vec!["finish = \"polished\"".into(), "ior = 1.5".into()], 1)
        );
        // Thin-walled: no volume.
        let thin = [("transmission", 1.0), ("attenuation_distance", 2.0), ("attenuation_color", 0.5)];
        assert_eq!(said(&thin), (vec!["finish = \"polished\"".into()], 0));
        let (rows, _) = said(&[("thickness", 1.0), ("attenuation_distance", 2.0), ("attenuation_color", 0.5)]);
        // 0.5 over 2 m: ln 2 / 2 per metre.
        let per_m: f64 = rows[0].strip_prefix("absorption_per_m = ").unwrap().parse().unwrap();
        assert!((per_m - 2f64.ln() / 2.0).abs() < 1e-12);
    }

    /// A colour stays one, as the reader of media takes it.
    #[test]
    fn coloured_volumes() {
        let mut material = assembly(&[]).materials.remove(0);
        let value = |data: Data| Value::new(data, Where::Nowhere);
        let lanes = [1.0, 0.5, 0.25].map(|x| value(Data::Number(x)));
        material.mapped.push(("thickness".to_owned(), value(Data::Number(1.0))));
        material.mapped.push(("attenuation_distance".to_owned(), value(Data::Number(0.05))));
        material.mapped.push(("attenuation_color".to_owned(), value(Data::List(lanes.to_vec()))));
        let all = mapped(&material, &mut Vec::new()).unwrap();
        let (_, absorption) = all.iter().find(|(key, _)| key == "absorption_per_m").unwrap();
        let read = crate::optics::absorption(absorption, 555.0).unwrap();
        assert_eq!(read, eyebox_scene::Absorption::Colour { rgb: [1.0, 0.5, 0.25], distance_m: 0.05 });
    }
}
