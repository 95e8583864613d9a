//! Measured scattering from a text file: lines of side (R or T), angle of incidence, leaving angle, azimuth (deg) and value
//! (1/sr), with commas, semicolons, tabs or blanks between them; the lines of a side make a whole grid, in any order. `#` starts a comment, a first line of
//! names is allowed.

use super::klems_bsdf::{self, KlemsBsdf};
use super::zemax_bsdf::{self, ZemaxBsdf};
use crate::text::{SEPARATORS, cells};
use eyebox_base::error::Result;
use eyebox_base::{Code, Error, Where};
use eyebox_scene::scatter_table::{Flaw, Measurement};
use eyebox_scene::{Note, ScatterTable};
use std::path::Path;

/// The names of the columns.
const COLUMNS: &str = "side,theta_in_deg,theta_out_deg,phi_deg,bsdf_per_sr";

/// A file of measured scattering, and where it is named.
pub struct MeasuredFile<'a> {
    pub bytes: Vec<u8>,
    pub file: &'a Path,
    pub at: &'a Where,
}

/// Reflected and transmitted.
type BothSides = [Option<Measurement>; 2];

const SIDES: [&str; 2] = ["R", "T"];

/// What a table of these files is called.
pub fn name_of_table(files: &[impl AsRef<Path>]) -> String {
    files.iter().map(|file| file.as_ref().display().to_string()).collect::<Vec<_>>().join(", ")
}

/// The table that the files give together: ours, or those of `zemax_bsdf` and `klems_bsdf`.
///
/// # Errors
/// By its line: what is no number or out of range, a point twice. A grid with holes, a side that two files have, a table that gains
/// energy.
pub fn scatter_table(files: &[MeasuredFile<'_>], notes: &mut Vec<Note>) -> Result<ScatterTable> {
    let (mut measured, mut totals): (BothSides, _) = ([None, None], Vec::new());
    for source in files {
        let text = String::from_utf8_lossy(&source.bytes);
        let found = if zemax_bsdf::is_zemax(&text) {
            let ZemaxBsdf { side, measurement, totals: said } = zemax_bsdf::read(&text, source.file)?;
            totals.push((source, side, said, "in steps of a degree", "TIS"));
            let mut out: BothSides = [None, None];
            out[side] = Some(measurement);
            out
        } else if klems_bsdf::is_klems(&text) {
            let KlemsBsdf { sides, totals: said } = klems_bsdf::read(&text, source.file, notes)?;
            for (side, said) in said.into_iter().enumerate() {
                totals.push((source, side, said, "alike all round", "a sum of"));
            }
            sides
        } else {
            rows(&text, source)?
        };
        for (side, new) in found.into_iter().enumerate() {
            if new.is_some() && measured[side].is_some() {
                let what = format!("measured scattering: side {} is in both files", SIDES[side]);
                return Err(Error::new(source.at.clone(), what).expected("a file of each side"));
            }
            measured[side] = new.or(measured[side].take());
        }
    }
    let name = name_of_table(&files.iter().map(|source| source.file).collect::<Vec<_>>());
    let table = ScatterTable::new(&name, &measured).map_err(|flaw| {
        let code = match flaw {
            Flaw::TooLarge { .. } => None,
            Flaw::GainsEnergy { .. } => Some(Code::ScatterGainsEnergy),
        };
        let at = files.first().map_or(Where::Nowhere, |source| source.at.clone());
        Error::new(at, format!("measured scattering {name}: {flaw}"))
            .expected("a table that scatters at most what arrives")
            .code(code)
    })?;
    notes.extend(totals.iter().filter_map(|(source, side, said, how, name)| {
        let (_, [angle, total, sum]) = apart(&table, *side, said)?;
        let what = format!(
            "measured scattering {}: of light at {angle}° the table made of it, {how}, scatters {sum:.4}, the file says {name} \
             {total:.4}: a lobe too narrow for it, or values that are not those of that sum",
            source.file.display()
        );
        Some(Note::warning(source.at.clone(), what))
    }));
    Ok(table)
}

/// Where a table scatters another share of light than its file says, most of all: by how much of that, the angle in degrees, and
/// both shares. None if they are alike everywhere.
fn apart(table: &ScatterTable, side: usize, said: &[[f64; 2]]) -> Option<(f64, [f64; 3])> {
    /// Of the total that a file says, what may be missed unsaid.
    const ALIKE: f64 = 0.1;
    let off = |[angle, total]: &[f64; 2]| {
        let sum = table.shares(angle.to_radians())[side];
        ((sum - total).abs() / total, [*angle, *total, sum])
    };
    let worst = said.iter().filter(|[_, total]| *total > 0.0).map(off).max_by(|a, b| a.0.total_cmp(&b.0));
    worst.filter(|(off, _)| *off > ALIKE)
}

/// Lines of our own form.
fn rows(text: &str, source: &MeasuredFile<'_>) -> Result<BothSides> {
    let (file, at) = (source.file, source.at);
    let mut sides: [Vec<[f64; 4]>; 2] = [Vec::new(), Vec::new()];
    for (index, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or("").trim();
        if line.is_empty() || cells(line).join(",").eq_ignore_ascii_case(COLUMNS) {
            continue;
        }
        let here = || Where::Line { file: file.to_owned(), line: index + 1 };
        let cells = cells(line);
        let side = match cells.first().copied() {
            Some("R" | "r") => 0,
            Some("T" | "t") => 1,
            other => {
                let what = format!("`{}` is no side", other.unwrap_or(""));
                let form = format!("R or T, then four numbers, with {SEPARATORS}");
                return Err(Error::new(here(), what).expected(form));
            }
        };
        let numbers: Vec<f64> = cells.iter().skip(1).map_while(|cell| cell.parse().ok()).collect();
        let (Ok(row), 5) = (<[f64; 4]>::try_from(numbers), cells.len()) else {
            let form = format!("{COLUMNS}, with {SEPARATORS}");
            return Err(Error::new(here(), format!("`{line}` has not four numbers")).expected(form));
        };
        let ranges = [(0.0, 90.0), (0.0, 90.0), (0.0, 180.0), (0.0, 1e12)];
        let odd = row
            .iter()
            .zip(ranges)
            .zip(COLUMNS.split(',').skip(1))
            .find(|((x, (low, high)), _)| !(low..=high).contains(x));
        if let Some(((x, (low, high)), name)) = odd {
            return Err(Error::new(here(), format!("{name} is {x}")).expected(format!("a number from {low} to {high}")));
        }
        sides[side].push(row);
    }
    let wrong = |why: String| Error::new(at.clone(), format!("measured scattering {}: {why}", file.display()));
    if sides.iter().all(Vec::is_empty) {
        return Err(wrong("it has no lines".to_owned()).expected(COLUMNS));
    }
    let mut measured = [None, None];
    for (side, rows) in sides.into_iter().enumerate() {
        if !rows.is_empty() {
            measured[side] = Some(grid(rows).map_err(|why| wrong(format!("side {}: {why}", SIDES[side])))?);
        }
    }
    Ok(measured)
}

/// Rows (deg, deg, deg, 1/sr) as a grid.
fn grid(mut rows: Vec<[f64; 4]>) -> Result<Measurement, String> {
    let angles = |column: usize| {
        let mut all: Vec<f64> = rows.iter().map(|row| row[column]).collect();
        all.sort_by(f64::total_cmp);
        all.dedup();
        all
    };
    let [theta_in, theta_out, phi] = [0, 1, 2].map(angles);
    let count = theta_in.len().saturating_mul(theta_out.len()).saturating_mul(phi.len());
    rows.sort_by(|a, b| {
        a.iter().zip(b).map(|(a, b)| a.total_cmp(b)).find(|o| o.is_ne()).unwrap_or(a.len().cmp(&b.len()))
    });
    if let Some(pair) = rows.windows(2).find(|pair| pair[0][..3] == pair[1][..3]) {
        let [i, o, p, _] = pair[0];
        return Err(format!("two values at {i}°, {o}°, {p}°"));
    }
    if rows.len() != count {
        let [i, o, p] = [theta_in.len(), theta_out.len(), phi.len()];
        return Err(format!("{} lines do not fill a grid of {i} × {o} × {p} angles", rows.len()));
    }
    let radians = |angles: Vec<f64>| angles.into_iter().map(f64::to_radians).collect();
    let values = rows.iter().map(|row| row[3]).collect();
    Ok(Measurement { theta_in: radians(theta_in), theta_out: radians(theta_out), phi: radians(phi), values })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<ScatterTable> {
        let source = MeasuredFile { bytes: text.as_bytes().to_vec(), file: Path::new("a.csv"), at: &Where::Nowhere };
        scatter_table(&[source], &mut Vec::new())
    }

    #[test]
    fn tables_and_their_faults() {
        let good = "# a diffuser\nside, theta_in_deg, theta_out_deg, phi_deg, bsdf_per_sr\nT,0,0,0,0.2\nT,0,90,0,0.1\n";
        let table = read(good).unwrap();
        // The mean of light at 0° that leaves at 45°, 0.15, and the other way round, 0.2.
        assert!((table.at(1, 0.0, 45f64.to_radians(), 3.0) - 0.175).abs() < 1e-15);
        assert_eq!(table.at(0, 0.0, 0.0, 0.0), 0.0);
        for separator in [";", "\t", "  "] {
            let same = good.replace(", ", ",").replace(',', separator);
            assert_eq!(read(&same).unwrap().at(1, 0.0, 0.7, 3.0), table.at(1, 0.0, 0.7, 3.0), "{same}");
        }
        for (bad, why) in [
            (
                "R|0|0|0|1",
                "`R|0|0|0|1` is no side; expected R or T, then four numbers, with commas, semicolons, tabs or blanks",
            ),
            ("", "no lines"),
            ("X,0,0,0,1", "is no side"),
            ("R,0,0,0", "four numbers"),
            ("R,0,0,0,1,2", "four numbers"),
            ("R,0,0,0,nan", "bsdf_per_sr is NaN"),
            ("R,91,0,0,1", "theta_in_deg is 91"),
            ("R,0,0,0,0.1\nR,0,0,0,0.2", "two values"),
            ("R,0,0,0,0.1\nR,10,20,0,0.2", "do not fill a grid"),
            ("R,0,0,0,0.4", "gains energy"),
        ] {
            let fault = read(bad).unwrap_err().to_string();
            assert!(fault.contains(why), "{bad}: {fault}");
        }
    }
}
