//! The attributes of the whole asset: wavelengths, unit, version of the vocabulary.

use super::fields::{not_yet, number, union};
use crate::value::Value;
use eyebox_base::error::Result;
use eyebox_base::{Code, Error, Where};
use eyebox_scene::attribute::{self, Noun};
use eyebox_scene::{Note, Wavelengths};

/// `{ mono_nm = 550 }` or `"visible"` (the default, noted).
pub fn wavelengths(value: Option<&Value>, notes: &mut Vec<Note>) -> Result<Wavelengths> {
    let Some(value) = value else {
        let text = "`wavelengths` is not said: visible".to_owned();
        notes.push(Note::info(Where::Nowhere, text));
        return Ok(Wavelengths::Visible);
    };
    let read = union(Noun::Asset, "wavelengths", value)?;
    match read.kind.name {
        "visible" => Ok(Wavelengths::Visible),
        "mono_nm" => Ok(Wavelengths::Mono { nm: read.fields.need_number("mono_nm")? }),
        name => Err(not_yet(&value.at, &format!("wavelengths `{name}`"))),
    }
}

/// `unit`, metres per unit of the asset.
pub fn unit(value: &Value) -> Result<f64> {
    match attribute::row(Noun::Asset, "unit") {
        Some(row) => number(value, row),
        None => Err(Error::new(value.at.clone(), "there is no attribute `unit`")),
    }
}

/// Checks the version `name` (`schema` of a sidecar, `version` of an asset's root).
pub fn version(table: &Value, name: &str) -> Result<()> {
    let Some(value) = table.get(name) else {
        return Err(Error::new(table.at.clone(), format!("`{name}` is missing")).expected(format!("{name} = 1")));
    };
    match value.number() {
        Some(1.0) => Ok(()),
        Some(newer) if newer > 1.0 => {
            Err(Error::new(value.at.clone(), format!("{name} {newer} is newer than this program"))
                .expected(format!("{name} = 1"))
                .code(Code::SchemaNewer))
        }
        Some(_) | None => {
            Err(Error::new(value.at.clone(), format!("`{name}` is {value}")).expected(format!("{name} = 1")))
        }
    }
}
