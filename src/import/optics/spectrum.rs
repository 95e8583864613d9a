//! `spectrum`: the colour of an emitter's light.

use super::fields::{not_yet, union};
use crate::value::Value;
use eyebox_base::error::Result;
use eyebox_base::{Code, Error, Where};
use eyebox_scene::attribute::Noun;
use eyebox_scene::{Led, Spectrum};
use std::path::Path;

/// A spectrum before its file is read.
#[derive(Debug, Clone, PartialEq)]
pub enum SpectrumSpec {
    Given(Spectrum),
    /// The file as it is written, and where.
    Csv {
        file: String,
        at: Where,
    },
}

/// Faults: unknown kinds, numbers out of range, a spectrum without visible light.
pub fn spectrum(value: &Value) -> Result<SpectrumSpec> {
    let read = union(Noun::Emitter, "spectrum", value)?;
    let spectrum = match read.kind.name {
        "D65" => Spectrum::D65,
        "A" => Spectrum::A,
        "equal" => Spectrum::Equal,
        "cct" => Spectrum::Cct(read.fields.need_number("cct")?),
        "rgb" => Spectrum::Rgb(read.fields.need_numbers("rgb")?),
        "table" => {
            let rows = read.fields.need_rows::<2>("table")?;
            Spectrum::Table(rows.into_iter().map(|[nm, power]| (nm, power)).collect())
        }
        "csv" => {
            let at = read.fields.value("csv").map_or(&value.at, |value| &value.at).clone();
            return Ok(SpectrumSpec::Csv { file: read.fields.need_text("csv")?.to_owned(), at });
        }
        name => match Led::from_name(name) {
            Some(led) => Spectrum::Led(led),
            None => return Err(not_yet(&value.at, &format!("spectrum `{name}`"))),
        },
    };
    checked(spectrum, &value.at).map(SpectrumSpec::Given)
}

fn checked(spectrum: Spectrum, at: &Where) -> Result<Spectrum> {
    match spectrum.problem() {
        None => Ok(spectrum),
        Some(problem) => Err(Error::new(at.clone(), format!("`spectrum`: {problem}"))
            .expected("power at some wavelength from 360 to 830 nm")
            .code(Code::SpectrumUnusable)),
    }
}

/// No spectrometer writes more rows; a file that has them is not a spectrum.
const MOST_ROWS: usize = 1 << 20;

/// The table in a text file `file`, named at `named`: lines of a wavelength in nm and a power, separated by comma,
/// semicolon, tab or spaces. Empty lines, those that begin with `#` and a first line of column names are passed over; more
/// columns have no say.
///
/// Faults: lines without two numbers, wavelengths that do not rise, negative powers, no visible light.
pub fn spectrum_table(bytes: &[u8], file: &Path, named: &Where) -> Result<Spectrum> {
    let text = std::str::from_utf8(bytes).map_err(|_| {
        Error::new(named.clone(), format!("the spectrum {} is not a text", file.display()))
            .expected("lines of a wavelength in nm and a power")
            .code(Code::SpectrumUnusable)
    })?;
    let mut rows: Vec<(f64, f64)> = Vec::new();
    let mut headed = false;
    for (i, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let at = || Where::Line { file: file.to_owned(), line: i + 1 };
        let mut fields = line.split([',', ';', '\t', ' ']).map(str::trim).filter(|field| !field.is_empty());
        let mut number = || fields.next().and_then(|field| field.parse::<f64>().ok());
        match (number(), number()) {
            (Some(nm), Some(power)) if nm > 0.0 && nm.is_finite() && power >= 0.0 && power.is_finite() => {
                rows.push((nm, power));
            }
            (None, _) if rows.is_empty() && !headed => headed = true,
            (Some(_) | None, Some(_) | None) => {
                let shown: String = line.chars().take(60).collect();
                return Err(Error::new(at(), format!("`{shown}` is no line of a spectrum"))
                    .expected("a wavelength in nm and a power >= 0")
                    .code(Code::SpectrumUnusable));
            }
        }
        if let [.., (before, _), (nm, _)] = rows.as_slice()
            && before >= nm
        {
            return Err(Error::new(at(), format!("the wavelength {nm} nm does not rise"))
                .expected("rising wavelengths")
                .code(Code::SpectrumUnusable));
        }
        if rows.len() > MOST_ROWS {
            return Err(Error::new(at(), "the spectrum has too many lines")
                .expected(format!("{MOST_ROWS} at most"))
                .code(Code::SpectrumUnusable));
        }
    }
    checked(Spectrum::Table(rows), &Where::file(file))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Spectrum> {
        spectrum_table(text.as_bytes(), Path::new("led.csv"), &Where::Nowhere)
    }

    #[test]
    fn files_are_tables() {
        let want = Spectrum::Table(vec![(450.0, 1.0), (460.5, 0.5)]);
        for text in [
            "450,1\n460.5,0.5\n",
            "\u{feff}nm,W\r\n450,1\r\n460.5,5e-1\r\n",
            "# made\n\nwavelength;power\n450;1;9\n460.5 ; 0.5",
            "450\t1\n  460.5   0.5",
        ] {
            assert_eq!(read(text).unwrap(), want, "{text:?}");
        }
        for (text, fault) in [
            ("450,1\nx,1", "led.csv:2: `x,1` is no line of a spectrum; expected a wavelength in nm and a power >= 0"),
            ("nm,W\nnm,W", "led.csv:2: `nm,W` is no line"),
            ("450,1\n450,1", "led.csv:2: the wavelength 450 nm does not rise"),
            ("450,-1", "led.csv:1: `450,-1` is no line"),
            ("450,NaN", "led.csv:1: `450,NaN` is no line"),
            ("450", "led.csv:1: `450` is no line"),
            ("", "led.csv: `spectrum`: the spectrum has no visible light"),
            ("900,1\n950,1", "led.csv: `spectrum`: the spectrum has no visible light"),
        ] {
            let got = read(text).unwrap_err().to_string();
            assert!(got.starts_with(fault), "{got}");
        }
        assert!(
            spectrum_table(&[0xff, 0xfe], Path::new("a"), &Where::Nowhere)
                .unwrap_err()
                .to_string()
                .contains("not a text")
        );
    }
}
