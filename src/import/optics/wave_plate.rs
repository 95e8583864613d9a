//! What a finish says of a wave plate.

use super::fields::{Fields, number, rows};
use crate::value::Data;
use eyebox_base::Error;
use eyebox_base::error::Result;
use eyebox_scene::attribute::{self, Noun};
use eyebox_scene::{Retardance, WavePlate};

/// The wave plate of a finish; none if there is neither a retardance nor, where indices alone are enough for a `quarter` wave
/// plate, those. Faults: both retardances, one index alone, wavelengths that do
/// not rise, a retardance of the other sign than the birefringence.
pub fn wave_plate(fields: &Fields<'_>, quarter: bool) -> Result<Option<WavePlate>> {
    let (nm, waves) = (retardance(fields, "retardance_nm")?, retardance(fields, "retardance_waves")?);
    let indices = match (fields.number("ordinary_index")?, fields.number("extraordinary_index")?) {
        (Some(o), Some(e)) => Some([o, e]),
        (None, None) => None,
        (Some(_), None) => return Err(fields.missing("extraordinary_index")),
        (None, Some(_)) => return Err(fields.missing("ordinary_index")),
    };
    let retardance = match (nm, waves) {
        (Some(rows), None) => Retardance::Nm(rows),
        (None, Some(rows)) => Retardance::Waves(rows),
        (None, None) => match indices.filter(|_| quarter) {
            // A quarter of the sign that the birefringence has.
            Some([o, e]) => Retardance::Waves(vec![[WavePlate::ANY_NM, if e < o { -0.25 } else { 0.25 }]]),
            None => return Ok(None),
        },
        (Some(_), Some(_)) => {
            return Err(Error::new(fields.at().clone(), "a wave plate has one retardance")
                .expected("`retardance_nm` or `retardance_waves`"));
        }
    };
    let plate = WavePlate { retardance, indices };
    match plate.problem() {
        Some(text) => Err(Error::new(fields.at().clone(), text).expected(
            "rows with rising wavelengths, and a retardance of the sign of extraordinary_index − ordinary_index",
        )),
        None => Ok(Some(plate)),
    }
}

/// A number, or rows over the wavelength.
fn retardance(fields: &Fields<'_>, name: &str) -> Result<Option<Vec<[f64; 2]>>> {
    let (Some(value), Some(row)) = (fields.value(name), attribute::row(Noun::Finish, name)) else { return Ok(None) };
    Ok(Some(match value.data {
        Data::List(_) => rows::<2>(value, row)?,
        Data::Number(_) | Data::Bool(_) | Data::Text(_) | Data::Table(_) => {
            vec![[WavePlate::ANY_NM, number(value, row)?]]
        }
    }))
}

/// Whether it is the second of two words.
pub fn word(fields: &Fields<'_>, name: &str, words: [&str; 2], default: Option<bool>) -> Result<bool> {
    match (fields.text(name)?, default) {
        (None, Some(default)) => Ok(default),
        (None, None) => Err(fields.missing(name)),
        (Some(said), _) if said == words[0] => Ok(false),
        (Some(said), _) if said == words[1] => Ok(true),
        (Some(said), _) => {
            let at = fields.value(name).map_or(fields.at(), |value| &value.at);
            Err(Error::new(at.clone(), format!("`{name}` is \"{said}\""))
                .expected(format!("\"{}\" or \"{}\"", words[0], words[1]))
                .nearest(said, words))
        }
    }
}
