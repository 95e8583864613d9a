//! EULUMDAT (A. Stockmar, 1990): a value on each line.

use super::grid;
use super::planes::{Symmetry, expand};
use super::text::{Lines, parse, shown};
use eyebox_base::Error;
use eyebox_base::error::Result;
use eyebox_scene::profile::{LuminousProfile, ProfileFacts};
use std::path::Path;

/// The lines of the file one after the other.
struct Reader<'a, I> {
    lines: &'a Lines<'a>,
    rest: I,
    line: usize,
}

impl<'a, I: Iterator<Item = (usize, &'a str)> + Clone> Reader<'a, I> {
    fn fault(&self, what: impl Into<String>) -> Box<Error> {
        self.lines.fault(self.line.max(1), what)
    }

    fn text(&mut self, what: &str) -> Result<&'a str> {
        match self.rest.next() {
            Some((line, text)) => {
                self.line = line;
                Ok(text.trim())
            }
            None => Err(self.fault(format!("the file ends where {what} should be")).expected("an EULUMDAT file")),
        }
    }

    /// A number; a comma is a point, as some of its writers have it.
    fn number(&mut self, what: &str) -> Result<f64> {
        let text = self.text(what)?;
        let number = if text.contains(',') { parse(&text.replace(',', ".")) } else { parse(text) };
        number.ok_or_else(|| self.fault(format!("{what} is `{}`", shown(text))).expected("a finite number"))
    }

    /// What may be empty.
    fn number_or(&mut self, what: &str, empty: f64) -> Result<f64> {
        let mut ahead = self.rest.clone();
        if ahead.next().is_some_and(|(_, text)| text.trim().is_empty()) {
            self.text(what)?;
            return Ok(empty);
        }
        self.number(what)
    }

    /// A whole number from `least` up, of which the file has as many lines left.
    fn count(&mut self, what: &str, least: usize) -> Result<usize> {
        let number = self.number(what)?;
        let most = self.rest.clone().take(super::text::MOST).count();
        let whole = number as usize;
        if number.fract() == 0.0 && number >= least as f64 && whole <= most {
            return Ok(whole);
        }
        Err(self.fault(format!("{what} is {number}")).expected(format!("a whole number from {least} to {most}")))
    }

    fn rising(&mut self, count: usize, what: &str, most: f64) -> Result<Vec<f64>> {
        let mut all: Vec<f64> = Vec::new();
        for _ in 0..count {
            let number = self.number(what)?;
            if !(0.0..=most).contains(&number) || all.last().is_some_and(|last| *last >= number) {
                return Err(self
                    .fault(format!("{what} is {number}"))
                    .expected(format!("rising angles from 0 to {most}")));
            }
            all.push(number);
        }
        Ok(all)
    }
}

/// Reads `bytes` of `file`. Faults: whatever is not EULUMDAT, with its line.
pub fn read(file: &Path, bytes: &[u8]) -> Result<LuminousProfile> {
    let lines = Lines::new(file, bytes);
    let mut reader = Reader { lines: &lines, rest: lines.iter(), line: 0 };
    let mut facts =
        ProfileFacts { format: "EULUMDAT".to_owned(), photometric_type: "C".to_owned(), ..ProfileFacts::default() };
    let company = reader.text("the company")?.to_owned();
    reader.number_or("the type of the luminaire", 0.0)?;
    let isym = reader.number("the symmetry Isym")?;
    let symmetry = [Symmetry::Whole, Symmetry::Axial, Symmetry::Half, Symmetry::Across, Symmetry::Quadrant];
    let found = symmetry.into_iter().enumerate().find(|(code, _)| *code as f64 == isym);
    let Some((_, symmetry)) = found else {
        return Err(reader.fault(format!("the symmetry Isym is {isym}")).expected("0, 1, 2, 3 or 4"));
    };
    let planes = reader.count("the number Mc of C planes", 1)?;
    reader.number_or("the distance Dc of C planes", 0.0)?;
    let gammas = reader.count("the number Ng of intensities in a plane", 2)?;
    reader.number_or("the distance Dg of intensities", 0.0)?;
    let mut texts = vec![("company".to_owned(), company)];
    for key in ["report", "luminaire", "number", "file", "date"] {
        texts.push((key.to_owned(), reader.text(key)?.to_owned()));
    }
    facts.keywords = texts;
    for what in ["the length", "the width", "the height"] {
        reader.number_or(what, 0.0)?;
    }
    let length = reader.number_or("the length of the luminous area", 0.0)?;
    let width = reader.number_or("the width of the luminous area", 0.0)?;
    let mut height = 0.0f64;
    for plane in ["C0", "C90", "C180", "C270"] {
        height = height.max(reader.number_or(&format!("the height of the luminous area at {plane}"), 0.0)?);
    }
    facts.opening_m = [width, length, height].map(|mm| mm * 1e-3);
    reader.number_or("the downward flux fraction", 0.0)?;
    reader.number_or("the light output ratio", 0.0)?;
    let conversion = reader.number("the conversion factor of intensities")?;
    if conversion <= 0.0 {
        return Err(reader.fault(format!("the conversion factor is {conversion}")).expected("a number > 0"));
    }
    reader.number_or("the tilt", 0.0)?;
    let sets = reader.count("the number of lamp sets", 1)?;
    let mut flux = 0.0;
    for set in 0..sets {
        let lamps = reader.number_or("the number of lamps", 1.0)?;
        reader.text("the type of lamps")?;
        let own = reader.number("the flux of the lamps")?;
        // The sets are alternatives, each with the flux of all its lamps: the first counts.
        if set == 0 {
            if own <= 0.0 {
                return Err(reader.fault(format!("the flux of the lamps is {own}")).expected("a number > 0 in lm"));
            }
            (flux, facts.absolute) = (own, lamps < 0.0);
        }
        for what in ["the colour temperature", "the colour rendering", "the wattage"] {
            reader.text(what)?;
        }
    }
    facts.lamp_lumens = Some(flux);
    // Intensities are in cd per 1000 lm of the lamps.
    facts.scale = flux / 1000.0 * conversion;
    for k in 1..=10 {
        reader.number_or(&format!("direct ratio {k} of 10"), 0.0)?;
    }
    let angles = reader.rising(planes, "a C angle", 360.0)?;
    let angles_line = reader.line;
    let gamma = reader.rising(gammas, "a γ angle", 180.0)?;
    let stored = stored(&angles, symmetry).ok_or_else(|| {
        let what = format!(
            "{planes} C planes from {} to {} for Isym {isym}",
            angles.first().unwrap_or(&0.0),
            angles.last().unwrap_or(&0.0)
        );
        lines.fault(angles_line, what).expected("planes that include those of symmetry: C0, C90, C180, C270")
    })?;
    let total = stored.len().saturating_mul(gammas);
    let mut rows = Vec::new();
    let mut read = 0;
    for angle in stored {
        let mut row = Vec::new();
        for _ in 0..gammas {
            read += 1;
            let value = reader.number("an intensity").map_err(|mut fault| {
                fault.what = format!("{} ({read} of {total})", fault.what);
                fault
            })?;
            if value < 0.0 {
                return Err(reader.fault(format!("intensity {read} of {total} is {value}")).expected("0 or more"));
            }
            row.push(value * facts.scale);
        }
        rows.push((angle, row));
    }
    for (line, text) in reader.rest.by_ref() {
        if !text.trim().is_empty() {
            return Err(lines
                .fault(line, format!("`{}` follows the last of {total} intensities", shown(text.trim())))
                .expected("the end of the file"));
        }
    }
    if symmetry == Symmetry::Whole {
        let first = rows.first().map(|(_, row)| row.clone()).unwrap_or_default();
        if rows.last().is_some_and(|(angle, _)| *angle < 360.0) {
            rows.push((360.0, first));
        }
    }
    let turn = expand(rows, symmetry)
        .ok_or_else(|| lines.fault(angles_line, "the C planes do not close").expected("planes from C0 on"))?;
    grid(file, LuminousProfile::TYPE_C, turn, &gamma, facts)
        .ok_or_else(|| lines.fault(1, "no intensity is above 0").expected("a lamp that shines"))
}

/// The angles of the planes that are stored, deg, rising: for symmetry about C90–C270 from −90.
fn stored(angles: &[f64], symmetry: Symmetry) -> Option<Vec<f64>> {
    let upto = |last: f64| {
        let end = angles.iter().position(|angle| *angle == last)?;
        (angles.first() == Some(&0.0)).then(|| angles.get(..=end).unwrap_or(&[]).to_vec())
    };
    match symmetry {
        Symmetry::Axial => Some(angles.get(..1)?.to_vec()),
        Symmetry::Whole => (angles.first() == Some(&0.0)).then(|| angles.to_vec()),
        Symmetry::Half => upto(180.0),
        Symmetry::Quadrant => upto(90.0),
        Symmetry::Across => {
            let from = angles.iter().position(|angle| *angle == 270.0)?;
            let mut all: Vec<f64> =
                angles.get(from..)?.iter().filter(|angle| **angle < 360.0).map(|angle| angle - 360.0).collect();
            all.extend(upto(90.0)?);
            Some(all)
        }
    }
}
