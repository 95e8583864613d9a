//! IES LM-63: ANSI/IES LM-63-2002 and -2019, IESNA LM-63-1995 and -1991, IES LM-63-1986.

use super::planes::{Symmetry, expand};
use super::text::{self, Lines, Numbers, shown};
use super::{Files, grid};
use eyebox_base::error::Result;
use eyebox_base::{Code, Where};
use eyebox_scene::Note;
use eyebox_scene::profile::{LuminousProfile, ProfileFacts};
use std::path::Path;

/// Metres of a foot, the other unit of LM-63.
const FOOT: f64 = 0.3048;

/// Reads `bytes` of `file`. Faults: whatever is not LM-63, with its line; a TILT file that cannot be read.
pub fn read(file: &Path, bytes: &[u8], files: Files<'_>, notes: &mut Vec<Note>) -> Result<LuminousProfile> {
    let lines = Lines::new(file, bytes);
    let mut rest = lines.iter();
    let mut facts = ProfileFacts { format: "IES LM-63-1986".to_owned(), ..ProfileFacts::default() };
    let mut with_lamp_factor = true;
    let (mut last, mut tilt) = (0, None);
    // The first line that is not blank may name the edition; 1986 has no such line.
    let (mut first, mut unnamed) = (true, None);
    for (line, text) in rest.by_ref() {
        last = line;
        let text = text.trim();
        if let Some(value) = text::tilt(text) {
            tilt = Some(value.to_owned());
            break;
        }
        if first && !text.is_empty() {
            first = false;
            match edition(text) {
                Header::Edition(year) => {
                    facts.format = format!("IES LM-63-{year}");
                    with_lamp_factor = matches!(year, "1986" | "1991");
                    continue;
                }
                Header::Unknown(year) => {
                    facts.format = format!("IES LM-63-{year}");
                    with_lamp_factor = matches!(year, "1986" | "1991");
                    let header = shown(text);
                    let text = format!("`{header}` names no edition that is known: read as LM-63-{year}");
                    let at = Where::Line { file: file.to_owned(), line };
                    notes.push(Note::warning(at, text));
                }
                Header::Label => unnamed = Some(line),
            }
        }
        keyword(text, &mut facts.keywords);
    }
    let Some(tilt) = tilt else {
        let what = if last == 0 { "the file is empty" } else { "the line TILT= is missing" };
        return Err(lines.fault(last.max(1), what).expected("an IES LM-63 file"));
    };
    let tilt_line = last;
    let mut numbers = Numbers::new(&lines, rest, tilt_line);
    let upright = match tilt.to_ascii_uppercase().as_str() {
        "NONE" => 1.0,
        "INCLUDE" => tilted(&mut numbers)?,
        _ => external(file, &tilt, &lines, tilt_line, files)?,
    };

    numbers.number("the number of lamps")?;
    let lumens = numbers.number("lumens per lamp")?;
    facts.absolute = lumens < 0.0;
    facts.lamp_lumens = (!facts.absolute).then_some(lumens);
    let multiplier = numbers.positive("the candela multiplier")?;
    let verticals = numbers.count("the number of vertical angles", 2)?;
    let horizontals = numbers.count("the number of horizontal angles", 1)?;
    let total = verticals.checked_mul(horizontals).filter(|total| *total <= numbers.bound());
    let Some(total) = total else {
        let what = format!("{verticals} vertical and {horizontals} horizontal angles");
        return Err(numbers.fault(what).expected(format!("at most {} candela values", numbers.bound())));
    };
    let kind = numbers.number("the photometric type")?;
    let units = numbers.number("the type of units")?;
    let metres = if units == 1.0 {
        FOOT
    } else if units == 2.0 {
        1.0
    } else {
        return Err(numbers.fault(format!("the type of units is {units}")).expected("1 (feet) or 2 (metres)"));
    };
    for (name, size) in ["width", "length", "height"].iter().zip(&mut facts.opening_m) {
        *size = metres * numbers.number(&format!("the {name} of the luminous opening"))?;
    }
    let ballast = numbers.positive("the ballast factor")?;
    // "Ballast-lamp photometric factor" in 1986 and 1991, "future use" in 1995 and 2002, the code of how the file was
    // made in 2019: only the first is a factor.
    let third = numbers.number("the third factor")?;
    numbers.number("input watts")?;
    if with_lamp_factor && third <= 0.0 {
        return Err(numbers.fault(format!("the ballast-lamp factor is {third}")).expected("a number > 0"));
    }
    if let Some(line) = unnamed
        && third != 1.0
    {
        let text = format!("no edition is named: read as LM-63-1986, in which the ballast-lamp factor {third} counts");
        let at = Where::Line { file: file.to_owned(), line };
        notes.push(Note::warning(at, text));
    }
    facts.scale = multiplier * ballast * upright * if with_lamp_factor { third } else { 1.0 };

    let of_type = |code: f64| ["C", "B", "A"].into_iter().zip([1.0, 2.0, 3.0]).find(|(_, own)| *own == code);
    let Some((letter, _)) = of_type(kind) else {
        return Err(numbers.fault(format!("the photometric type is {kind}")).expected("1 (C), 2 (B) or 3 (A)"));
    };
    facts.photometric_type = letter.to_owned();
    let range = if letter == "C" { [0.0, 180.0] } else { [-90.0, 90.0] };
    let vertical = numbers.rising(verticals, "a vertical angle", range)?;
    let range = if letter == "C" { [0.0, 360.0] } else { [-90.0, 90.0] };
    let horizontal = numbers.rising(horizontals, "a horizontal angle", range)?;
    let horizontal_line = numbers.line();
    let mut rows = Vec::with_capacity(horizontals);
    let mut read = 0;
    for angle in &horizontal {
        let mut row = Vec::with_capacity(verticals);
        for _ in 0..verticals {
            read += 1;
            let what = || format!("candela value {read} of {total}");
            let value = numbers.number_of(what)?;
            if value < 0.0 {
                return Err(numbers.fault(format!("{} is {value}", what())).expected("0 or more"));
            }
            row.push(value * facts.scale);
        }
        rows.push((*angle, row));
    }
    numbers.end()?;

    let at_angles = |what: String| lines.fault(horizontal_line, what);
    if letter == "C" {
        let symmetry = symmetry(&horizontal).ok_or_else(|| {
            let (first, last) = (horizontal.first().unwrap_or(&0.0), horizontal.last().unwrap_or(&0.0));
            at_angles(format!("the horizontal angles run from {first} to {last}"))
                .expected("0 alone, or 0 to 90, 0 to 180, 90 to 270 or 0 to 360 degrees")
        })?;
        let last = horizontal.last().copied().unwrap_or(0.0);
        if symmetry == Symmetry::Whole && last < 360.0 {
            let first = rows.first().map(|(_, row)| row.clone()).unwrap_or_default();
            rows.push((360.0, first));
            let text = format!("the horizontal angles end at {last}: 360 is taken as 0");
            let at = Where::Line { file: file.to_owned(), line: horizontal_line };
            notes.push(Note::warning(at, text).code(Code::ProfileMalformed));
        }
        let planes = expand(rows, symmetry).ok_or_else(|| at_angles("the horizontal angles do not close".into()))?;
        return grid(file, LuminousProfile::TYPE_C, planes, &vertical, facts)
            .ok_or_else(|| lines.fault(1, "no candela value is above 0").expected("a lamp that shines"));
    }
    let around = mirrored(horizontal, rows).ok_or_else(|| {
        at_angles(format!("one horizontal angle for photometric type {letter}"))
            .expected("at least two, from 0 or from below 0, up to 90 degrees")
    })?;
    // Latitudes from 0 up are those on both sides.
    let columns: Vec<Vec<f64>> =
        (0..verticals).map(|v| around.iter().filter_map(|(_, row)| row.get(v).copied()).collect()).collect();
    let tall = mirrored(vertical.clone(), vertical.iter().copied().zip(columns).collect())
        .ok_or_else(|| at_angles(format!("one vertical angle for photometric type {letter}")))?;
    let (axes, planes, gammas) = if letter == "B" {
        // Vertical angles turn about the pole, which is horizontal; γ rises from it with the horizontal angle.
        let gammas: Vec<f64> = around.iter().map(|(h, _)| 90.0 + h).collect();
        (LuminousProfile::TYPE_B, tall, gammas)
    } else {
        // Horizontal angles turn about the pole, which is up; γ falls with the vertical angle.
        let gammas: Vec<f64> = tall.iter().rev().map(|(v, _)| 90.0 - v).collect();
        let planes = (0..around.len())
            .map(|h| {
                (
                    around.get(h).map_or(0.0, |(c, _)| *c),
                    tall.iter().rev().filter_map(|(_, row)| row.get(h).copied()).collect(),
                )
            })
            .collect();
        (LuminousProfile::TYPE_A, planes, gammas)
    };
    grid(file, axes, planes, &gammas, facts)
        .ok_or_else(|| lines.fault(1, "no candela value is above 0").expected("a lamp that shines"))
}

/// Angles that start at 0 hold on both sides of it. None for less than two.
fn mirrored(angles: Vec<f64>, rows: Vec<(f64, Vec<f64>)>) -> Option<Vec<(f64, Vec<f64>)>> {
    if angles.len() < 2 {
        return None;
    }
    if angles.first() != Some(&0.0) {
        return Some(rows);
    }
    let mut all: Vec<_> = rows.iter().skip(1).rev().map(|(angle, row)| (-angle, row.clone())).collect();
    all.extend(rows);
    Some(all)
}

/// What the horizontal angles of a type C file say of its planes.
fn symmetry(angles: &[f64]) -> Option<Symmetry> {
    let (first, last) = (*angles.first()?, *angles.last()?);
    if angles.len() == 1 {
        return Some(Symmetry::Axial);
    }
    let widest = angles.windows(2).map(|pair| if let [a, b] = pair { b - a } else { 0.0 }).fold(0.0, f64::max);
    match (first, last) {
        (0.0, 90.0) => Some(Symmetry::Quadrant),
        (0.0, 180.0) => Some(Symmetry::Half),
        (90.0, 270.0) => Some(Symmetry::Across),
        (0.0, 360.0) => Some(Symmetry::Whole),
        // Some writers leave out the plane that is the first again.
        (0.0, last) if last > 180.0 && 360.0 - last <= 1.5 * widest => Some(Symmetry::Whole),
        (_, _) => None,
    }
}

/// What the first line of a file is.
enum Header {
    /// The year of an edition that it names.
    Edition(&'static str),
    /// It looks like the name of an edition, but of none that is known; with the year of the edition to read it as.
    Unknown(&'static str),
    /// A label, as in 1986.
    Label,
}

/// The years of the editions.
const EDITIONS: [&str; 5] = ["1986", "1991", "1995", "2002", "2019"];

/// The edition that a line names, in whatever case and with whatever punctuation: `IESNA:LM-63-2002`, `IESNA91`,
/// `IES: lm-63-2019`, `ANSI/IES LM-63-19`. A year between two editions holds for the earlier.
fn edition(text: &str) -> Header {
    let letters: String =
        text.chars().filter(char::is_ascii_alphanumeric).map(|letter| letter.to_ascii_uppercase()).collect();
    let own = letters.strip_prefix("ANSI").unwrap_or(&letters);
    let Some(rest) = own.strip_prefix("IESNA").or_else(|| own.strip_prefix("IES")) else { return Header::Label };
    let standard = rest.strip_prefix("LM63");
    let digits = standard.unwrap_or(rest);
    let number = digits.get(..digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len())).unwrap_or("");
    let year = match (number.len(), number.parse::<u32>()) {
        (4, Ok(year)) => year,
        (2, Ok(year)) => year + if year < 80 { 2000 } else { 1900 },
        // LM-63 without a year is not known; `IES` with other words is a label.
        (_, Ok(_) | Err(_)) if standard.is_some() => return Header::Unknown("2019"),
        (_, Ok(_) | Err(_)) => return Header::Label,
    };
    let known = EDITIONS.iter().rfind(|own| own.parse().is_ok_and(|own: u32| own <= year)).copied().unwrap_or("1986");
    if known.parse() == Ok(year) { Header::Edition(known) } else { Header::Unknown(known) }
}

/// `[KEY] value`; `[MORE]` goes on with the one before; lines without a keyword, as in 1986, are labels.
fn keyword(text: &str, all: &mut Vec<(String, String)>) {
    let entry = text.strip_prefix('[').and_then(|rest| rest.split_once(']'));
    match entry {
        Some((key, value)) if key.eq_ignore_ascii_case("MORE") => {
            if let Some((_, last)) = all.last_mut() {
                last.push('\n');
                last.push_str(value.trim());
            }
        }
        Some((key, value)) => all.push((key.to_owned(), value.trim().to_owned())),
        None if !text.is_empty() => all.push(("LABEL".to_owned(), text.to_owned())),
        None => {}
    }
}

/// Lamp-to-luminaire geometry, number of angles, angles, factors → the factor of the luminaire as it was measured, at an
/// angle of 0.
fn tilted<'a, I: Iterator<Item = (usize, &'a str)> + Clone>(numbers: &mut Numbers<'a, I>) -> Result<f64> {
    let geometry = numbers.number("the lamp-to-luminaire geometry")?;
    if ![1.0, 2.0, 3.0].contains(&geometry) {
        return Err(numbers.fault(format!("the lamp-to-luminaire geometry is {geometry}")).expected("1, 2 or 3"));
    }
    let count = numbers.count("the number of tilt angles", 1)?;
    let angles = numbers.rising(count, "a tilt angle", [0.0, 180.0])?;
    let factors = numbers.list(count, "tilt factor")?;
    let upright = match angles.first() {
        Some(0.0) => factors.first().copied().unwrap_or(1.0),
        Some(_) | None => 1.0,
    };
    if upright > 0.0 {
        Ok(upright)
    } else {
        Err(numbers.fault(format!("the tilt factor at 0 is {upright}")).expected("a number > 0"))
    }
}

fn external(file: &Path, name: &str, lines: &Lines<'_>, line: usize, files: Files<'_>) -> Result<f64> {
    let folder = file.parent().unwrap_or(Path::new(""));
    let tilt = folder.join(name);
    let at = Where::Line { file: file.to_owned(), line };
    let bytes = files(&tilt, &at).map_err(|fault| {
        lines
            .fault(line, format!("TILT={}: {}", shown(name), fault.what))
            .expected("NONE, INCLUDE or a file that is there")
    })?;
    let own = Lines::new(&tilt, &bytes);
    let mut numbers = Numbers::new(&own, own.iter(), 1);
    let factor = tilted(&mut numbers)?;
    Ok(factor)
}
