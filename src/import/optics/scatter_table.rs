//! Measured scattering from a text file: lines of side (R or T), angle of incidence, leaving angle, azimuth (deg) and value
//! (1/sr), separated by commas; the lines of a side make a whole grid, in any order. `#` starts a comment, a first line of
//! names is allowed.

use crate::base::error::Result;
use crate::base::{Code, Error, Where};
use crate::scene::ScatterTable;
use crate::scene::scatter_table::{Flaw, Measurement};
use std::path::Path;

/// The names of the columns.
const COLUMNS: &str = "side,theta_in_deg,theta_out_deg,phi_deg,bsdf_per_sr";

/// The table in these bytes of `file`, which is named at `at`.
///
/// # Errors
/// By its line: what is no number or out of range, a point twice. A grid with holes, a table that gains energy.
pub fn scatter_table(bytes: &[u8], file: &Path, at: &Where) -> Result<ScatterTable> {
    let text = String::from_utf8_lossy(bytes);
    let mut sides: [Vec<[f64; 4]>; 2] = [Vec::new(), Vec::new()];
    for (index, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or("").trim();
        if line.is_empty() || line.replace(' ', "").eq_ignore_ascii_case(COLUMNS) {
            continue;
        }
        let here = || Where::Line { file: file.to_owned(), line: index + 1 };
        let mut cells = line.split(',').map(str::trim);
        let side = match cells.next() {
            Some("R" | "r") => 0,
            Some("T" | "t") => 1,
            other => {
                let what = format!("`{}` is no side", other.unwrap_or(""));
                return Err(Error::new(here(), what).expected("R or T, then four numbers"));
            }
        };
        let numbers: Vec<f64> = cells.map_while(|cell| cell.parse().ok()).collect();
        let (Ok(row), 5) = (<[f64; 4]>::try_from(numbers), line.split(',').count()) else {
            return Err(Error::new(here(), format!("`{line}` has not four numbers")).expected(COLUMNS));
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
    let names = ["R", "T"];
    let mut measured = [None, None];
    for (side, rows) in sides.into_iter().enumerate() {
        if !rows.is_empty() {
            measured[side] = Some(grid(rows).map_err(|why| wrong(format!("side {}: {why}", names[side])))?);
        }
    }
    let name = file.display().to_string();
    ScatterTable::new(&name, &measured).map_err(|flaw| {
        let code = match flaw {
            Flaw::TooLarge { .. } => None,
            Flaw::GainsEnergy { .. } => Some(Code::ScatterGainsEnergy),
        };
        wrong(flaw.to_string()).expected("a table that scatters at most what arrives").code(code)
    })
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
        scatter_table(text.as_bytes(), Path::new("a.csv"), &Where::Nowhere)
    }

    #[test]
    fn tables_and_their_faults() {
        let good = "# a diffuser\nside, theta_in_deg, theta_out_deg, phi_deg, bsdf_per_sr\nT,0,0,0,0.2\nT,0,90,0,0.1\n";
        let table = read(good).unwrap();
        // The mean of light at 0° that leaves at 45°, 0.15, and the other way round, 0.2.
        assert!((table.at(1, 0.0, 45f64.to_radians(), 3.0) - 0.175).abs() < 1e-15);
        assert_eq!(table.at(0, 0.0, 0.0, 0.0), 0.0);
        for (bad, why) in [
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
