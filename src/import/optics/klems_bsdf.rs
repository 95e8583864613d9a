//! Measured scattering as WINDOW of the Lawrence Berkeley National Laboratory has it (XML, also of genBSDF and pyWinCalc): matrices
//! between the patches of an angle basis, of rings of equal patches about the normal (J. H. Klems, "A new method for predicting
//! the solar heat gain of complex fenestration systems", ASHRAE Transactions 100, 1994).
//!
//! A value holds for light that travels, seen along the face, towards the azimuth of its patch, and leaves towards that of the
//! other: what goes straight on, and what a mirror sends back, stays in its patch. With `Columns` the patches of incidence
//! vary fastest, with `Rows` those of leaving. (Orders, azimuths and the rings of the named bases as Radiance reads them,
//! `src/common/bsdf_m.c`.)

mod basis;
mod even;

use basis::{Basis, own_basis};
use even::even;
use eyebox_base::Where;
use eyebox_base::error::{Error, Result};
use eyebox_scene::Note;
use eyebox_scene::scatter_table::Measurement;
use roxmltree::{Document, Node, ParsingOptions};
use std::path::Path;

/// Share of a side's light by which patches of equal angles may differ unsaid.
const ALIKE: f64 = 0.1;

/// A file's measurements.
pub struct KlemsBsdf {
    /// Reflected and transmitted.
    pub sides: [Option<Measurement>; 2],
    /// Angles of incidence in degrees, and what the file says is scattered of light there.
    pub totals: [Vec<[f64; 2]>; 2],
}

/// Whether these are the bytes of such a file.
pub fn is_klems(text: &str) -> bool {
    let text = text.trim_start_matches('\u{feff}').trim_start();
    text.starts_with('<') && text.contains("<WindowElement")
}

/// Reads a file's text.
///
/// # Errors
/// By its line: what is no XML, another element or basis than these, matrices of another size, negative light. Tensor trees.
pub fn read(text: &str, file: &Path, notes: &mut Vec<Note>) -> Result<KlemsBsdf> {
    let whole = || Where::file(file);
    let options = ParsingOptions { nodes_limit: 1 << 20, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text.trim_start_matches('\u{feff}'), options).map_err(|fault| {
        Error::new(Where::Line { file: file.to_owned(), line: fault.pos().row as usize }, fault.to_string())
    })?;
    let at = |node: Node<'_, '_>| Where::Line {
        file: file.to_owned(),
        line: document.text_pos_at(node.range().start).row as usize,
    };
    let Some(layer) = find(document.root_element(), &["Optical", "Layer"]) else {
        return Err(Error::new(whole(), "the window element has no Optical/Layer").expected("a BSDF of WINDOW"));
    };
    let Some(structure) = find(layer, &["DataDefinition", "IncidentDataStructure"]) else {
        return Err(
            Error::new(at(layer), "the layer has no DataDefinition/IncidentDataStructure").expected("Columns or Rows")
        );
    };
    let columns = match said(structure) {
        word if word.eq_ignore_ascii_case("Columns") => true,
        word if word.eq_ignore_ascii_case("Rows") => false,
        word if word.to_ascii_lowercase().starts_with("tensortree") => {
            return Err(Error::new(at(structure), "a tensor tree is not read")
                .expected("a matrix: genBSDF without -t, or bsdf2klems of it"));
        }
        word => return Err(Error::new(at(structure), format!("data structure `{word}`")).expected("Columns or Rows")),
    };
    let mut bases = Vec::new();
    for basis in children(layer, "DataDefinition").flat_map(|all| children(all, "AngleBasis").collect::<Vec<_>>()) {
        let name = find(basis, &["AngleBasisName"]).map(said).unwrap_or_default();
        if Basis::named(&name).is_none() {
            bases.push((name, own_basis(basis, &at)?));
        }
    }
    let mut found: [Vec<Vec<f64>>; 2] = [Vec::new(), Vec::new()];
    let mut used: Option<Basis> = None;
    let (mut seen, mut coloured) = (false, false);
    for data in children(layer, "WavelengthData") {
        let of = find(data, &["Wavelength"]).map(said).unwrap_or_default().to_ascii_lowercase();
        // What the sun's heat does is no light; two more matrices give light its colour.
        coloured |= of.starts_with("cie");
        if of != "visible" {
            continue;
        }
        seen = true;
        for block in children(data, "WavelengthDataBlock") {
            let direction = find(block, &["WavelengthDataDirection"]).map(said).unwrap_or_default();
            let side = match direction.to_ascii_lowercase().as_str() {
                "reflection front" | "reflection back" => 0,
                "transmission front" | "transmission back" => 1,
                _ => {
                    return Err(Error::new(at(block), format!("direction `{direction}`"))
                        .expected("Transmission or Reflection, Front or Back"));
                }
            };
            for kind in ["ColumnAngleBasis", "RowAngleBasis"] {
                let name = find(block, &[kind]).map(said).unwrap_or_default();
                let own = bases.iter().find(|(own, _)| own.eq_ignore_ascii_case(&name)).map(|(_, basis)| basis.clone());
                let Some(basis) = own.or_else(|| Basis::named(&name)) else {
                    return Err(Error::new(at(block), format!("{kind} is `{name}`"))
                        .expected("LBNL/Klems Full, Half or Quarter, or a basis that the file defines"));
                };
                if used.as_ref().is_some_and(|used| *used != basis) {
                    return Err(Error::new(at(block), "the file's matrices have different angle bases").expected("one"));
                }
                used = Some(basis);
            }
            let patches = used.as_ref().map_or(0, Basis::patches);
            let Some(data) = find(block, &["ScatteringData"]) else {
                return Err(Error::new(at(block), "the block has no ScatteringData").expected("a matrix"));
            };
            let values = matrix(data, patches, &at)?;
            found[side].push(if columns { transposed(&values, patches) } else { values });
        }
    }
    let Some(basis) = used.filter(|_| seen) else {
        return Err(Error::new(at(layer), "nothing is measured of visible light")
            .expected("WavelengthData with Wavelength Visible and a WavelengthDataBlock"));
    };
    if coloured {
        notes.push(Note::warning(
            whole(),
            "the colours that the file has are not read: it scatters alike at all wavelengths",
        ));
    }
    let mut out = KlemsBsdf { sides: [None, None], totals: [Vec::new(), Vec::new()] };
    for (side, matrices) in found.into_iter().enumerate() {
        if matrices.is_empty() {
            continue;
        }
        let name = ["reflected", "transmitted"][side];
        if let Some(off) = front_to_back(&basis, &matrices).filter(|off| *off > ALIKE) {
            notes.push(Note::warning(
                whole(),
                format!(
                    "light {name} from the front and from the back differs by {:.0} %: the mean is taken",
                    100.0 * off
                ),
            ));
        }
        let count = matrices.len() as f64;
        let patches = basis.patches();
        let mean: Vec<f64> =
            (0..patches * patches).map(|k| matrices.iter().map(|matrix| matrix[k]).sum::<f64>() / count).collect();
        let (measurement, off) = even(&basis, &mean);
        if off > ALIKE {
            notes.push(Note::warning(
                whole(),
                format!(
                    "light {name} along and across the sample differs by {:.0} %: a finish scatters alike all round, so the mean \
                     over its rotations is taken",
                    100.0 * off
                ),
            ));
        }
        out.totals[side] = totals(&basis, &mean);
        out.sides[side] = Some(measurement);
    }
    Ok(out)
}

fn children<'d, 'i: 'd>(node: Node<'d, 'i>, name: &'static str) -> impl Iterator<Item = Node<'d, 'i>> {
    node.children().filter(move |child| child.tag_name().name() == name)
}

/// The first element down a path.
fn find<'d, 'i: 'd>(node: Node<'d, 'i>, path: &[&'static str]) -> Option<Node<'d, 'i>> {
    path.iter().try_fold(node, |node, name| children(node, name).next())
}

/// What an element says, in one line of no more than a name's length.
fn said(node: Node<'_, '_>) -> String {
    let words: Vec<&str> = node.text().unwrap_or("").split_whitespace().take(8).collect();
    words.join(" ").chars().take(60).collect()
}

/// The numbers of a matrix of so many rows and columns.
fn matrix(node: Node<'_, '_>, patches: usize, at: &dyn Fn(Node<'_, '_>) -> Where) -> Result<Vec<f64>> {
    let count = patches * patches;
    let mut values = Vec::with_capacity(count);
    let words =
        node.text().unwrap_or("").split(|c: char| c.is_whitespace() || c == ',').filter(|word| !word.is_empty());
    for word in words {
        // Rounding leaves some of nothing below 0.
        let value = word.parse::<f64>().ok().filter(|value| (-1e-3..=1e12).contains(value));
        let Some(value) = value.filter(|_| values.len() < count) else {
            return Err(Error::new(at(node), format!("value {} of the matrix, `{word}`, is none", values.len() + 1))
                .expected(format!("{count} numbers of 0 or more")));
        };
        values.push(value.max(0.0));
    }
    if values.len() != count {
        return Err(Error::new(at(node), format!("the matrix has {} values", values.len()))
            .expected(format!("{patches} × {patches} = {count}")));
    }
    Ok(values)
}

/// `[leaving][incidence]` → `[incidence][leaving]`.
fn transposed(values: &[f64], patches: usize) -> Vec<f64> {
    (0..values.len()).map(|k| values[k % patches * patches + k / patches]).collect()
}

/// Angles of incidence in degrees, one in the middle of each ring, and the share of light scattered there.
fn totals(basis: &Basis, matrix: &[f64]) -> Vec<[f64; 2]> {
    let ring = |(ring, ([low, high], count)): (usize, &([f64; 2], usize))| {
        let own = basis.first(ring)..basis.first(ring) + count;
        let sum: f64 = own.map(|patch| total(basis, matrix, patch)).sum();
        let middle = if ring == 0 { 0.0 } else { 0.5 * (low + high) };
        [middle.to_degrees(), sum / *count as f64]
    };
    basis.rings.iter().enumerate().map(ring).collect()
}

/// Share of the light in a patch that is scattered.
fn total(basis: &Basis, matrix: &[f64], from: usize) -> f64 {
    let ring = |ring: usize| {
        let to = basis.first(ring)..basis.first(ring) + basis.rings[ring].1;
        basis.solid_angle(ring) * to.map(|to| matrix[from * basis.patches() + to]).sum::<f64>()
    };
    (0..basis.rings.len()).map(ring).sum()
}

/// Of what a front and a back scatter of light along the normal, the difference over their mean; none of one alone.
fn front_to_back(basis: &Basis, matrices: &[Vec<f64>]) -> Option<f64> {
    let [front, back] = matrices else { return None };
    let [a, b] = [front, back].map(|matrix| total(basis, matrix, 0));
    (a + b > 0.0).then(|| 2.0 * (a - b).abs() / (a + b))
}

#[cfg(test)]
mod tests;
