//! Material extensions that mean a finish or a coating to us, and how a material looks to other programs.

use super::at::At;
use super::notes::Ledger;
use crate::value::{Data, Value};
use eyebox_base::error::Result;

type Row = (String, Value);

fn row(name: &str, data: Data, at: &At<'_>) -> Row {
    (name.to_owned(), Value::new(data, at.place()))
}

/// `KHR_materials_iridescence` as a coating of one film: index `iridescenceIor` (1.3), thickness
/// `iridescenceThicknessMaximum` (400 nm), which holds where no texture says otherwise: that is for glass, ordinary surfaces have
/// all of it by [`super::standard`]. None for a factor of 0, its default.
///
/// # Errors
/// Values of the wrong kind or out of range.
pub(super) fn iridescence(at: &At<'_>) -> Result<Option<Row>> {
    let Some(film) = at.extension("KHR_materials_iridescence")? else { return Ok(None) };
    let number = |key: &str, default: f64, low: f64, high: f64| match film.get(key)? {
        Some(field) => field.number_in(low, high),
        None => Ok(default),
    };
    let factor = number("iridescenceFactor", 0.0, 0.0, 1.0)?;
    let index = number("iridescenceIor", 1.3, 1.0, f64::INFINITY)?;
    let thickness = number("iridescenceThicknessMaximum", 400.0, 0.0, f64::INFINITY)?;
    if factor == 0.0 {
        return Ok(None);
    }
    let entry = |name: &str, number: f64| row(name, Data::Number(number), &film);
    let layer = Data::Table(vec![entry("n", index), entry("thickness_nm", thickness)]);
    let stack = Data::List(vec![Value::new(layer, film.place())]);
    let name = row("name", Data::Text("iridescence".to_owned()), &film);
    Ok(Some(row("coating", Data::Table(vec![name, row("stack", stack, &film)]), &film)))
}

/// `pbrMetallicRoughness` without its textures, for writing: `base_color` (linear Rec.709), `opacity` (unless the
/// material is opaque), `metallic`, `roughness`; only what is said. Values out of range are left out, with a note. And what
/// means nothing to light here but is written again: `double_sided`, `unlit`.
///
/// # Errors
/// Values of the wrong kind.
pub(super) fn looks(at: &At<'_>, ledger: &mut Ledger) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    if let Some(both) = at.get("doubleSided")?
        && both.flag()?
    {
        rows.push(row("double_sided", Data::Bool(true), &both));
    }
    if let Some(unlit) = at.extension("KHR_materials_unlit")? {
        rows.push(row("unlit", Data::Bool(true), &unlit));
    }
    let Some(pbr) = at.get("pbrMetallicRoughness")? else { return Ok(rows) };
    let sound = |number: f64| (0.0..=1.0).contains(&number);
    if let Some(field) = pbr.get("baseColorFactor")? {
        let lanes: [f64; 4] = field.numbers()?;
        if lanes.iter().all(|&lane| sound(lane)) {
            let color = lanes.iter().take(3).map(|&lane| Value::new(Data::Number(lane), field.place())).collect();
            rows.push(row("base_color", Data::List(color), &field));
            let opaque = at.get("alphaMode")?.is_none_or(|mode| mode.json == "OPAQUE");
            if let (false, [_, _, _, alpha]) = (opaque, lanes) {
                rows.push(row("opacity", Data::Number(alpha), &field));
            }
        } else {
            ledger.notes.warn(&field, "a base colour outside 0 to 1: ignored");
        }
    }
    for (name, key) in [("metallic", "metallicFactor"), ("roughness", "roughnessFactor")] {
        let Some(field) = pbr.get(key)? else { continue };
        match field.number()? {
            number if sound(number) => rows.push(row(name, Data::Number(number), &field)),
            _ => ledger.notes.warn(&field, format!("`{key}` outside 0 to 1: ignored")),
        }
    }
    Ok(rows)
}
