//! An entry of the database: name and source (text), whether a maker sells it as bodies (u8), number of parts, parts.
//!
//! A part is its kind (u8) and what that has. 1 to 9, a formula: a text of the shortest and longest wavelength in µm and the
//! coefficients, digits as in the source. 10, 11, 12, a table of n, of k, of both: number of rows, then the columns, wavelength
//! first, each of them all rows. A column of 0 has a number of decimal places and the steps from value to value in units of the
//! last of them; one of 1 has for each value the step of its exponent of ten, and its digits. A text is its length and UTF-8.
//! Numbers are seven bits a byte, lowest first; those with a sign have it in the lowest bit.

use crate::glass::Glass;
use crate::{Dispersion, Formula, FormulaKind};

/// An extinction below which a body of some tenths of a millimetre still lets light through.
const CLEAR: f64 = 1e-4;
/// Where kinds are told apart: the line d.
const D_NM: f64 = 587.5618;

/// Reads an entry; none where the bytes are no such.
pub(super) fn read(bytes: &[u8]) -> Option<Glass> {
    let mut reader = Reader(bytes);
    let (name, source) = (reader.text()?.to_owned(), reader.text()?.to_owned());
    let sold = reader.byte()? != 0;
    let parts = (0..reader.number()?).map(|_| reader.part()).collect::<Option<Vec<Part>>>()?;
    let (dispersion, valid_nm) = law(parts)?;
    let at_d = dispersion.index(D_NM);
    let gas = matches!(&dispersion, Dispersion::Formula(formula) if formula.kind == FormulaKind::Gases);
    let solid = sold || (!gas && at_d.im < CLEAR && at_d.re >= 1.0);
    Some(Glass { name: name.leak(), also: &[], dispersion, valid_nm, solid, source: source.leak() })
}

enum Part {
    Formula { kind: FormulaKind, valid_um: [f64; 2], c: Vec<f64> },
    N(Vec<(f64, f64)>),
    K(Vec<(f64, f64)>),
    Nk(Vec<(f64, f64, f64)>),
}

/// The law of the parts: one that has n, and perhaps one of k. It is known where its n is.
fn law(parts: Vec<Part>) -> Option<(Dispersion, [f64; 2])> {
    let mut parts = parts.into_iter();
    let first = parts.next()?;
    let k = match parts.next() {
        Some(Part::K(rows)) => rows,
        Some(Part::Formula { .. } | Part::N(_) | Part::Nk(_)) => return None,
        None => Vec::new(),
    };
    let range = |low: Option<f64>, high: Option<f64>| Some([low?, high?]);
    Some(match first {
        Part::Formula { kind, valid_um, c } => {
            // To the picometre, as catalogues print it: 0.3 µm are 300 nm, not 299.99999999999994.
            let valid_nm = valid_um.map(|um| (um * 1e6).round() / 1e3);
            (Dispersion::Formula(Formula { kind, c, k }), valid_nm)
        }
        Part::N(rows) => {
            let valid_nm = range(rows.first().map(|row| row.0), rows.last().map(|row| row.0))?;
            (Dispersion::Table(joined(&rows, &k)), valid_nm)
        }
        Part::Nk(rows) => {
            let valid_nm = range(rows.first().map(|row| row.0), rows.last().map(|row| row.0))?;
            (Dispersion::Table(rows), valid_nm)
        }
        Part::K(_) => return None,
    })
}

/// n and k of two tables at the wavelengths of both, which is exact as both are linear between.
fn joined(n: &[(f64, f64)], k: &[(f64, f64)]) -> Vec<(f64, f64, f64)> {
    let mut nm: Vec<f64> = n.iter().chain(k).map(|row| row.0).collect();
    nm.sort_by(f64::total_cmp);
    nm.dedup();
    let law = |rows: &[(f64, f64)]| Dispersion::Table(rows.iter().map(|&(nm, value)| (nm, value, 0.0)).collect());
    let (n_at, k_at) = (law(n), law(k));
    let k_of = |nm: f64| if k.is_empty() { 0.0 } else { k_at.index(nm).re };
    nm.into_iter().map(|nm| (nm, n_at.index(nm).re, k_of(nm))).collect()
}

struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    fn byte(&mut self) -> Option<u8> {
        let (first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(*first)
    }
    fn number(&mut self) -> Option<u64> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7f) << shift;
            if byte & 0x80 == 0 {
                return Some(value);
            }
        }
        None
    }
    fn signed(&mut self) -> Option<i64> {
        let value = self.number()?;
        let half = (value >> 1) as i64;
        Some(if value & 1 == 0 { half } else { -half - 1 })
    }
    fn text(&mut self) -> Option<&'a str> {
        let length = usize::try_from(self.number()?).ok()?;
        let (text, rest) = self.0.split_at_checked(length)?;
        self.0 = rest;
        std::str::from_utf8(text).ok()
    }

    fn part(&mut self) -> Option<Part> {
        let kind = self.byte()?;
        if let Some(kind) = FormulaKind::numbered(kind) {
            let numbers: Option<Vec<f64>> = self.text()?.split(' ').map(|word| word.parse().ok()).collect();
            let numbers = numbers?;
            let (valid, c) = numbers.split_first_chunk::<2>()?;
            return Some(Part::Formula { kind, valid_um: *valid, c: c.to_vec() });
        }
        let rows = usize::try_from(self.number()?).ok()?;
        let um = self.column(rows)?;
        // In nm by the decimal places, so that 0.55 µm are 550 nm to the bit.
        let nm = um.into_iter().map(|(digits, exponent)| scaled(digits, exponent + 3));
        let first = self.column(rows)?.into_iter().map(|(digits, exponent)| scaled(digits, exponent));
        Some(match kind {
            10 => Part::N(nm.zip(first).collect()),
            11 => Part::K(nm.zip(first).collect()),
            12 => {
                let k = self.column(rows)?.into_iter().map(|(digits, exponent)| scaled(digits, exponent));
                Part::Nk(nm.zip(first).zip(k).map(|((nm, n), k)| (nm, n, k)).collect())
            }
            _ => return None,
        })
    }

    /// Values as whole numbers with their exponents of ten.
    fn column(&mut self, rows: usize) -> Option<Vec<(i64, i64)>> {
        let (mut digits, mut exponent) = (0i64, 0i64);
        match self.byte()? {
            0 => {
                exponent = -i64::try_from(self.number()?).ok()?;
                let step = |_| {
                    digits = digits.checked_add(self.signed()?)?;
                    Some((digits, exponent))
                };
                (0..rows).map(step).collect()
            }
            1 => {
                let value = |_| {
                    exponent = exponent.checked_add(self.signed()?)?;
                    Some((self.signed()?, exponent))
                };
                (0..rows).map(value).collect()
            }
            _ => None,
        }
    }
}

/// digits · 10^exponent: correctly rounded as long as both are exact, which seventeen digits and 10²² are.
fn scaled(digits: i64, exponent: i64) -> f64 {
    let power = 10f64.powi(i32::try_from(exponent.abs()).unwrap_or(i32::MAX));
    if exponent < 0 { digits as f64 / power } else { digits as f64 * power }
}
