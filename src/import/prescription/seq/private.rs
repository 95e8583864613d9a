//! Glasses that a sequence defines itself, between PRV and END: indices at the wavelengths of PWL, or a formula by its name.

use super::words::bare;
use crate::prescription::After;
use eyebox_base::error::Result;
use eyebox_base::{Error, Where};
use std::collections::BTreeMap;

/// The formula that is read: Laurent's, n² = A₀ + A₁λ² + A₂λ⁻² + A₃λ⁻⁴ + A₄λ⁻⁶ + A₅λ⁻⁸, λ in µm (CODE V Reference Manual,
/// "Private Glass Catalogs").
const LAURENT: &str = "LAU";
/// Its coefficients, and the powers of λ that they stand before.
const POWERS: [i32; 6] = [0, 2, -2, -4, -6, -8];
/// What can be seen, nm, in steps so small that a line between two rows is right to a millionth or two.
const VISIBLE_NM: (u32, u32, usize) = (360, 830, 5);

/// What a sequence says of a glass of its own.
#[derive(Debug, Clone, PartialEq)]
enum Law {
    /// nm and n, rising.
    Rows(Vec<[f64; 2]>),
    /// Why it cannot be taken.
    Unread(String),
}

/// The glasses that are known so far.
#[derive(Debug, Default)]
pub(super) struct Private {
    /// Wavelengths of the indices, nm.
    at_nm: Vec<f64>,
    known: BTreeMap<String, Law>,
}

impl Private {
    /// A line between PRV and END: its first word, in capitals, and the others.
    pub fn take(&mut self, key: &str, words: &[&str]) {
        let number = |word: &&str| word.parse::<f64>().ok().filter(|n| n.is_finite());
        if key == "PWL" {
            self.at_nm = words.iter().filter_map(number).collect();
            return;
        }
        let formula = words.first().filter(|word| word.starts_with(|c: char| c.is_ascii_alphabetic()));
        let law = match formula.map(|word| word.to_uppercase()) {
            None => self.table(&words.iter().filter_map(number).collect::<Vec<f64>>(), words.len()),
            Some(formula) => by_formula(&formula, words.get(1..).unwrap_or(&[])),
        };
        self.known.insert(bare(key), law);
    }

    fn table(&self, n: &[f64], said: usize) -> Law {
        if n.len() != said || n.len() != self.at_nm.len() || n.is_empty() {
            return Law::Unread(format!("has {} indices for {} wavelengths of PWL", n.len(), self.at_nm.len()));
        }
        let mut rows: Vec<[f64; 2]> = self.at_nm.iter().zip(n).map(|(nm, n)| [*nm, *n]).collect();
        rows.sort_by(|a, b| a[0].total_cmp(&b[0]));
        rows.dedup_by(|b, a| a[0] == b[0]);
        Law::Rows(rows)
    }

    /// The glass of this name, if it is one of the file's own. Errors: one that is not read.
    pub fn glass(&self, name: &str, at: &Where) -> Result<Option<After>> {
        match self.known.get(name) {
            None => Ok(None),
            Some(Law::Rows(rows)) => Ok(Some(After::Private(rows.clone()))),
            Some(Law::Unread(why)) => Err(Error::new(at.clone(), format!("the private glass `{name}` {why}"))
                .expected("an index at each wavelength of PWL, or LAU and up to six coefficients")),
        }
    }
}

fn by_formula(formula: &str, words: &[&str]) -> Law {
    if formula != LAURENT {
        return Law::Unread(format!("is by the formula {formula}, which is not read"));
    }
    let c: Vec<f64> = words.iter().filter_map(|word| word.parse().ok()).filter(|c: &f64| c.is_finite()).collect();
    let more = c.iter().skip(POWERS.len()).any(|c| *c != 0.0);
    if c.len() != words.len() || c.is_empty() || more {
        return Law::Unread(format!("has the coefficients `{}`", words.join(" ")));
    }
    let n_squared = |um: f64| c.iter().zip(POWERS).map(|(c, power)| c * um.powi(power)).sum::<f64>();
    let (first, last, step) = VISIBLE_NM;
    let rows: Vec<[f64; 2]> =
        (first..=last).step_by(step).map(|nm| [f64::from(nm), n_squared(1e-3 * f64::from(nm)).sqrt()]).collect();
    if rows.iter().all(|[_, n]| n.is_finite()) { Law::Rows(rows) } else { Law::Unread("has an n² below 0".to_owned()) }
}
