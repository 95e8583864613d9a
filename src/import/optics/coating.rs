//! `coating`: thin films on a face, or what it was measured to do.

use super::fields::{Fields, one_of, union};
use super::medium;
use crate::value::Value;
use eyebox_base::error::Result;
use eyebox_base::{Code, Error};
use eyebox_scene::attribute::{self, Noun};
use eyebox_scene::coating::SpectralAngular;
use eyebox_scene::{Coating, CoatingLaw, CoatingTable, Dispersion, FilmLayer, Note};

/// A coating, called `name` unless the value names itself; none for `"none"`.
pub fn coating(value: &Value, name: &str, notes: &mut Vec<Note>) -> Result<Option<Coating>> {
    let read = union(Noun::Coating, "coating", value)?;
    if read.kind.name == "none" {
        return Ok(None);
    }
    let name = read.fields.text("name")?.unwrap_or(name).to_owned();
    let law = match read.kind.name {
        "ideal" => ideal(&read.fields, notes)?,
        "table" => CoatingLaw::Table(table(&read.fields)?),
        _ => CoatingLaw::Stack(stack(&read.fields)?),
    };
    Ok(Some(Coating { name, law }))
}

fn stack(fields: &Fields<'_>) -> Result<Vec<FilmLayer>> {
    let Some(stack) = fields.value("stack") else { return Err(fields.missing("stack")) };
    let films = stack.list().ok_or_else(|| {
        Error::new(stack.at.clone(), format!("`stack` is {} ({stack})", stack.kind()))
            .expected("a list of films, e.g. [{ n = 1.38, thickness_nm = 99.6 }]")
    })?;
    if films.is_empty() {
        return Err(
            Error::new(stack.at.clone(), "`stack` is empty").expected("at least one film, or coating = \"none\"")
        );
    }
    films.iter().map(film).collect()
}

/// What measured or typed shares may add up to beyond 1: a rounding of theirs.
const ROUNDED: f64 = 1e-9;

fn ideal(fields: &Fields<'_>, notes: &mut Vec<Note>) -> Result<CoatingLaw> {
    let (r, t) = (fields.number_or("R", 0.0, notes)?, fields.number_or("T", 0.0, notes)?);
    if r + t > 1.0 + ROUNDED {
        return Err(Error::new(fields.at().clone(), format!("R {r} + T {t} of an ideal coating is above 1"))
            .expected("shares that together are at most 1")
            .code(Code::CoatingGainsEnergy));
    }
    Ok(CoatingLaw::Ideal { reflectance: r, transmittance: t })
}

/// Measured lines, from outside and, if they say so, from inside.
fn table(fields: &Fields<'_>) -> Result<CoatingTable> {
    let Some(value) = fields.value("table") else { return Err(fields.missing("table")) };
    let lines = value.list().filter(|lines| !lines.is_empty()).ok_or_else(|| {
        Error::new(value.at.clone(), format!("`table` is {} ({value})", value.kind()))
            .expected("a list of { wavelength_nm, angle_deg, R_s, R_p, T_s, T_p }")
    })?;
    let (mut outside, mut inside) = (Vec::new(), Vec::new());
    for (index, line) in lines.iter().enumerate() {
        let own = Fields::of(Noun::Coating, "line", line, &attribute::MEASURED)?;
        let (nm, angle) = (own.need_number("wavelength_nm")?, own.need_number("angle_deg")?.to_radians());
        let [r_s, r_p] = [own.need_number("R_s")?, own.need_number("R_p")?];
        match own.text("side")? {
            None | Some("outside") => {
                let [t_s, t_p] = [own.need_number("T_s")?, own.need_number("T_p")?];
                if let Some((name, sum)) = [("s", r_s + t_s), ("p", r_p + t_p)].iter().find(|(_, x)| *x > 1.0 + ROUNDED)
                {
                    let what = format!("R_{name} + T_{name} is {sum} in line {index} of `table`");
                    return Err(Error::new(line.at.clone(), what).expected("at most 1").code(Code::CoatingGainsEnergy));
                }
                outside.push((nm, angle, [r_s, r_p, t_s, t_p]));
            }
            Some("inside") => inside.push((nm, angle, [r_s, r_p])),
            Some(other) => {
                let at = own.value("side").map_or(&line.at, |value| &value.at);
                return Err(Error::new(at.clone(), format!("`side` is \"{other}\""))
                    .expected("\"outside\" or \"inside\"")
                    .nearest(other, ["outside", "inside"]));
            }
        }
    }
    let wrong = |side: &str, why: String| {
        Error::new(value.at.clone(), format!("`table` of a coating, {side}: {why}"))
            .expected("one line for every pair of a wavelength and an angle")
    };
    Ok(CoatingTable {
        outside: SpectralAngular::from_rows(outside).map_err(|why| wrong("outside", why))?,
        inside: if inside.is_empty() {
            None
        } else {
            Some(SpectralAngular::from_rows(inside).map_err(|why| wrong("inside", why))?)
        },
    })
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
            return Err(Error::new(value.at.clone(), "a film has an index or is of a material")
                .expected("`n` (with `k` if it absorbs), or `material`"));
        }
    };
    Ok(FilmLayer { index, thickness_nm })
}

/// The fault of a coating name that nobody defined.
pub fn unknown<'a>(name: &str, value: &Value, defined: impl Iterator<Item = &'a str> + Clone) -> Box<Error> {
    let kinds = attribute::kinds("coating").filter(|kind| kind.rendered && kind.parameters.is_empty());
    let valid: Vec<&str> = defined.chain(kinds.map(|kind| kind.name)).collect();
    Error::new(value.at.clone(), format!("unknown coating `{name}`"))
        .expected(one_of(valid.iter().copied()))
        .nearest(name, valid.iter().copied())
        .code(Code::NameUnknown)
}
