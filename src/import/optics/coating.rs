//! `coating`: thin films on a face.

use super::fields::{Fields, one_of, union};
use super::medium;
use crate::base::Fault;
use crate::base::fault::Result;
use crate::import::value::Value;
use crate::scene::attribute::{self, Noun};
use crate::scene::{Coating, Dispersion, FilmLayer};

/// A coating, called `name` unless the value names itself; none for `"none"`.
pub fn coating(value: &Value, name: &str) -> Result<Option<Coating>> {
    let read = union(Noun::Coating, "coating", value)?;
    if read.kind.name == "none" {
        return Ok(None);
    }
    let name = read.fields.text("name")?.unwrap_or(name).to_owned();
    let Some(stack) = read.fields.value("stack") else { return Err(read.fields.missing("stack")) };
    let films = stack.list().ok_or_else(|| {
        Fault::new(stack.at.clone(), format!("`stack` is {} ({stack})", stack.kind()))
            .expected("a list of films, e.g. [{ n = 1.38, thickness_nm = 99.6 }]")
    })?;
    if films.is_empty() {
        return Err(
            Fault::new(stack.at.clone(), "`stack` is empty").expected("at least one film, or coating = \"none\"")
        );
    }
    Ok(Some(Coating { name, films: films.iter().map(film).collect::<Result<_>>()? }))
}

fn film(value: &Value) -> Result<FilmLayer> {
    let fields = Fields::of(Noun::Coating, "film", value, &attribute::FILM)?;
    let thickness_nm = fields.need_number("thickness_nm")?;
    let index = match (fields.number("n")?, fields.number("k")?, fields.text("material")?) {
        (Some(n), None | Some(0.0), None) => Dispersion::Constant(n),
        (Some(n), Some(k), None) => {
            // One row holds at every wavelength.
            Dispersion::Table(vec![(550.0, n, k)])
        }
        (None, None, Some(name)) => medium::catalogue(name, &value.at)?.1,
        (None, Some(_), _) | (Some(_), _, Some(_)) | (None, None, None) => {
            return Err(Fault::new(value.at.clone(), "a film has an index or is of a material")
                .expected("`n` (with `k` if it absorbs), or `material`"));
        }
    };
    Ok(FilmLayer { index, thickness_nm })
}

/// The fault of a coating name that nobody defined.
pub fn unknown<'a>(name: &str, value: &Value, defined: impl Iterator<Item = &'a str> + Clone) -> Box<Fault> {
    let kinds = attribute::kinds("coating").filter(|kind| kind.rendered && kind.parameters.is_empty());
    let valid: Vec<&str> = defined.chain(kinds.map(|kind| kind.name)).collect();
    Fault::new(value.at.clone(), format!("unknown coating `{name}`"))
        .expected(one_of(valid.iter().copied()))
        .nearest(name, valid.iter().copied())
}
