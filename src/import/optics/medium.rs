//! The attributes of a medium: its index in one of several laws, absorption, priority.

use super::fields::{Fields, code, number};
use crate::agf::Reference;
use crate::value::{Data, Value};
use eyebox_base::error::Result;
use eyebox_base::{Code, Error, Where};
use eyebox_scene::attribute::{self, Noun, Range, Row};
use eyebox_scene::{Absorption, Dispersion, glass};

/// A glass of the catalogue or of a catalogue file: its name there and its law.
pub(super) fn catalogue(name: &str, at: &Where) -> Result<(String, Dispersion)> {
    if let Some(from) = Reference::of(name) {
        let found = from.read(at)?;
        return Ok((found.name.to_owned(), found.dispersion));
    }
    match glass::find(name) {
        Some(found) => Ok((found.name.to_owned(), found.dispersion.clone())),
        None => Err(Error::new(at.clone(), format!("unknown glass `{name}`"))
            .expected("a name of the catalogue")
            .nearest(name, glass::names())
            .code(Code::NameUnknown)),
    }
}

/// As [`law`], with an index that is [`possible`] at the traced wavelength `nm`.
pub fn index(key: &str, value: &Value, nm: f64) -> Result<(String, Dispersion)> {
    let (name, law) = law(key, value)?;
    possible(key, value, &law, nm)?;
    Ok((name, law))
}

/// Whether light can be traced through a medium of this law at `nm`: n from 1 to 10 (the longest-known transparent solids
/// end at 5), no gain.
pub fn possible(key: &str, value: &Value, law: &Dispersion, nm: f64) -> Result<()> {
    let at_nm = law.index(nm);
    if at_nm.re >= 1.0 && at_nm.re <= 10.0 && at_nm.im >= 0.0 && at_nm.im.is_finite() {
        return Ok(());
    }
    let what = format!("impossible index: `{key}` gives n = {} at {nm} nm", at_nm.re);
    Err(Error::new(value.at.clone(), what).expected("n from 1 to 10 and k >= 0").code(Code::IndexImpossible))
}

/// The law of the index that the attribute `key` (`ior`, `glass`, …) gives, with a name for the medium.
pub fn law(key: &str, value: &Value) -> Result<(String, Dispersion)> {
    let row = row(key, value)?;
    let (name, law) = match key {
        "ior" => {
            let n = number(value, row)?;
            (format!("n={n}"), Dispersion::Constant(n))
        }
        "glass" => {
            let name = value.text().ok_or_else(|| form(value, row))?;
            catalogue(name, &value.at)?
        }
        "sellmeier" => {
            let terms = |name: &str| -> Result<[f64; 3]> {
                let item = value.get(name).ok_or_else(|| form(value, row))?;
                let list = item.list().filter(|list| (1..=3).contains(&list.len())).ok_or_else(|| form(value, row))?;
                coefficients(list, row)
            };
            if let Some((key, odd)) = value.table().and_then(|t| t.iter().find(|(key, _)| key != "b" && key != "c_um2"))
            {
                return Err(Error::new(odd.at.clone(), format!("unknown attribute `{key}` of sellmeier"))
                    .expected("b and c_um2")
                    .nearest(key, ["b", "c_um2"])
                    .code(Code::AttributeUnknown));
            }
            ("Sellmeier".to_owned(), Dispersion::Sellmeier { b: terms("b")?, c_um2: terms("c_um2")? })
        }
        "cauchy" => {
            let list = value.list().filter(|list| (1..=3).contains(&list.len())).ok_or_else(|| form(value, row))?;
            ("Cauchy".to_owned(), Dispersion::Cauchy(coefficients(list, row)?))
        }
        "abbe" => match value.list() {
            Some([n_d, v_d]) => {
                let (n_d, v_d) = (number(n_d, row)?, number(v_d, row)?);
                (format!("n_d={n_d} V_d={v_d}"), Dispersion::Abbe { n_d, v_d })
            }
            Some(_) | None => return Err(form(value, row)),
        },
        "index_table" => {
            let columns =
                [("λ", Range::Positive, "nm"), ("n", Range::AtLeast(0.0), ""), ("k", Range::AtLeast(0.0), "")];
            let rows = table(value, row, columns)?;
            ("index table".to_owned(), Dispersion::Table(rows.into_iter().map(|[nm, n, k]| (nm, n, k)).collect()))
        }
        _ => return Err(Error::new(value.at.clone(), format!("`{key}` gives no index")).code(Code::IndexImpossible)),
    };
    if let Some(problem) = law.problem() {
        return Err(Error::new(value.at.clone(), format!("`{key}`: {problem}")).expected(row.expected()));
    }
    Ok((name, law))
}

/// `absorption_per_m`. A table must have rows on both sides of `nm`, the wavelength that is traced or the middle of those
/// that are.
pub fn absorption(value: &Value, nm: f64) -> Result<Absorption> {
    let row = row("absorption_per_m", value)?;
    if let Data::Number(_) = value.data {
        return Ok(Absorption::Constant(number(value, row)?));
    }
    if let (Some(colour), Some(distance)) = (value.get("attenuation_color"), value.get("attenuation_distance")) {
        // What `mapped` makes of a format's own fields.
        let lanes: Vec<f64> = colour.list().unwrap_or(&[]).iter().filter_map(Value::number).collect();
        let sound = |rgb: &[f64; 3]| rgb.iter().all(|c| (0.0..=1.0).contains(c));
        let rgb = <[f64; 3]>::try_from(lanes).ok().filter(sound);
        return match (rgb, distance.number().filter(|d| *d > 0.0 && d.is_finite())) {
            (Some(rgb), Some(distance_m)) => Ok(Absorption::Colour { rgb, distance_m }),
            (Some(_) | None, _) => Err(form(value, row)),
        };
    }
    let lines = table(value, row, [("λ", Range::Positive, "nm"), ("absorption", Range::AtLeast(0.0), "1/m")])?;
    if let Some(pair) = lines.windows(2).find(|pair| pair[0][0] >= pair[1][0]) {
        let what = format!("the wavelengths of `absorption_per_m` do not rise at {} nm", pair[1][0]);
        return Err(Error::new(value.at.clone(), what).expected(row.expected()));
    }
    let covered = lines.first().is_some_and(|first| first[0] <= nm) && lines.last().is_some_and(|last| nm <= last[0]);
    if !covered {
        return Err(Error::new(value.at.clone(), format!("`absorption_per_m` does not cover {nm} nm"))
            .expected("rows on both sides of it")
            .code(Code::TableTooShort));
    }
    Ok(Absorption::Table(lines))
}

/// `priority`.
pub fn priority(value: &Value) -> Result<i32> {
    let row = row("priority", value)?;
    let number = number(value, row)?;
    let whole = number as i32;
    if f64::from(whole) == number { Ok(whole) } else { Err(form(value, row)) }
}

fn row(key: &str, value: &Value) -> Result<&'static Row> {
    attribute::row(Noun::Medium, key).ok_or_else(|| {
        Error::new(value.at.clone(), format!("unknown attribute `{key}` of a medium")).code(Code::AttributeUnknown)
    })
}

fn form(value: &Value, row: &Row) -> Box<Error> {
    Error::new(value.at.clone(), format!("`{}` is {} ({value})", row.name, value.kind()))
        .expected(row.expected())
        .code(code(row))
}

/// Up to three coefficients, the rest 0.
fn coefficients(list: &[Value], row: &Row) -> Result<[f64; 3]> {
    let mut out = [0.0; 3];
    for (out, item) in out.iter_mut().zip(list) {
        *out = number(item, row)?;
    }
    Ok(out)
}

/// What a column of a table is called, which numbers it takes, and their unit.
type Column = (&'static str, Range, &'static str);

/// Rows of N numbers, at least one.
fn table<const N: usize>(value: &Value, row: &Row, columns: [Column; N]) -> Result<Vec<[f64; N]>> {
    let items = value.list().filter(|list| !list.is_empty()).ok_or_else(|| form(value, row))?;
    let cell = |index: usize, (name, range, unit): Column, item: &Value| match item.data {
        Data::Number(number) if range.holds(number) => Ok(number),
        Data::Number(number) => {
            let unit = if unit.is_empty() { String::new() } else { format!(" in {unit}") };
            Err(Error::new(item.at.clone(), format!("{name} is {number} in row {index} of `{}`", row.name))
                .expected(format!("{range}{unit}")))
        }
        Data::Bool(_) | Data::Text(_) | Data::List(_) | Data::Table(_) => Err(form(item, row)),
    };
    let rows = items.iter().enumerate().map(|(index, item)| {
        let list = item.list().filter(|list| list.len() == N).ok_or_else(|| form(item, row))?;
        let mut out = [0.0; N];
        for ((out, column), item) in out.iter_mut().zip(columns).zip(list) {
            *out = cell(index, column, item)?;
        }
        Ok(out)
    });
    rows.collect()
}

/// The table `value` of medium attributes, checked for unknown names. Returns its entries.
pub fn entries(value: &Value) -> Result<&[(String, Value)]> {
    Fields::of(Noun::Medium, "a medium", value, &attribute::MEDIUM)?;
    Ok(value.table().unwrap_or(&[]))
}
