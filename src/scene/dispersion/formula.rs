//! The nine dispersion formulas of the refractiveindex.info database, in which most catalogues of glasses are written, too.
//! Their definitions are in its `doc/Dispersion formulas.pdf` (public domain, CC0).

use eyebox_base::Complex;

/// A formula for n with its coefficients, and a table for k.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Formula {
    pub kind: FormulaKind,
    /// C1, C2, … as the kind numbers them; those that are not given are 0.
    pub c: Vec<f64>,
    /// Rows (λ nm, k) by rising λ: linear between them, constant beyond them; none where k is 0.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub k: Vec<(f64, f64)>,
}

/// Which formula, with λ in µm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FormulaKind {
    /// 1: n² − 1 = C1 + Σ C2 λ²/(λ² − C3²), and so on in pairs.
    Sellmeier,
    /// 2: n² − 1 = C1 + Σ C2 λ²/(λ² − C3).
    Sellmeier2,
    /// 3: n² = C1 + Σ C2 λ^C3.
    Polynomial,
    /// 4: n² = C1 + C2 λ^C3/(λ² − C4^C5) + C6 λ^C7/(λ² − C8^C9) + Σ C10 λ^C11.
    Mixed,
    /// 5: n = C1 + Σ C2 λ^C3.
    Cauchy,
    /// 6: n − 1 = C1 + Σ C2/(C3 − λ⁻²).
    Gases,
    /// 7: n = C1 + C2 L + C3 L² + C4 λ² + C5 λ⁴ + C6 λ⁶ with L = 1/(λ² − 0.028).
    Herzberger,
    /// 8: (n² − 1)/(n² + 2) = C1 + C2 λ²/(λ² − C3) + C4 λ².
    Retro,
    /// 9: n² = C1 + C2/(λ² − C3) + C4 (λ − C5)/((λ − C5)² + C6).
    Exotic,
}

impl FormulaKind {
    /// By the database's number.
    pub fn numbered(number: u8) -> Option<FormulaKind> {
        use FormulaKind::{Cauchy, Exotic, Gases, Herzberger, Mixed, Polynomial, Retro, Sellmeier, Sellmeier2};
        const KINDS: [FormulaKind; 9] =
            [Sellmeier, Sellmeier2, Polynomial, Mixed, Cauchy, Gases, Herzberger, Retro, Exotic];
        KINDS.get(usize::from(number).checked_sub(1)?).copied()
    }
}

impl Formula {
    /// n + ik. Where n² < 0, inside a resonance, n is imaginary and stands for k, unless there is a table.
    pub fn index(&self, nm: f64) -> Complex {
        let um = nm * 1e-3;
        let sq = um * um;
        let c = |number: usize| self.c.get(number - 1).copied().unwrap_or(0.0);
        let pairs = |first: usize| {
            self.c.get(first - 1..).unwrap_or(&[]).chunks(2).map(|pair| (pair[0], pair.get(1).copied().unwrap_or(0.0)))
        };
        let n = match self.kind {
            FormulaKind::Sellmeier => {
                Complex::real(1.0 + c(1) + pairs(2).map(|(b, l)| b * sq / (sq - l * l)).sum::<f64>()).sqrt()
            }
            FormulaKind::Sellmeier2 => {
                Complex::real(1.0 + c(1) + pairs(2).map(|(b, l)| b * sq / (sq - l)).sum::<f64>()).sqrt()
            }
            FormulaKind::Polynomial => Complex::real(c(1) + pairs(2).map(|(a, p)| power(a, um, p)).sum::<f64>()).sqrt(),
            FormulaKind::Mixed => {
                let resonance = |first: usize| match c(first) {
                    0.0 => 0.0,
                    a => power(a, um, c(first + 1)) / (sq - c(first + 2).powf(c(first + 3))),
                };
                Complex::real(c(1) + resonance(2) + resonance(6) + pairs(10).map(|(a, p)| power(a, um, p)).sum::<f64>())
                    .sqrt()
            }
            FormulaKind::Cauchy => Complex::real(c(1) + pairs(2).map(|(a, p)| power(a, um, p)).sum::<f64>()),
            FormulaKind::Gases => Complex::real(1.0 + c(1) + pairs(2).map(|(b, l)| b / (l - 1.0 / sq)).sum::<f64>()),
            FormulaKind::Herzberger => {
                let l = 1.0 / (sq - 0.028);
                Complex::real(c(1) + c(2) * l + c(3) * l * l + c(4) * sq + c(5) * sq * sq + c(6) * sq * sq * sq)
            }
            FormulaKind::Retro => {
                let share = c(1) + c(2) * sq / (sq - c(3)) + c(4) * sq;
                Complex::real((1.0 + 2.0 * share) / (1.0 - share)).sqrt()
            }
            FormulaKind::Exotic => {
                let off = um - c(5);
                Complex::real(c(1) + c(2) / (sq - c(3)) + c(4) * off / (off * off + c(6))).sqrt()
            }
        };
        if self.k.is_empty() { n } else { Complex::new(n.re, linear(&self.k, nm)) }
    }

    /// What is wrong with the numbers, in plain words, if anything is.
    pub fn problem(&self) -> Option<String> {
        let finite = self.c.iter().all(|c| c.is_finite());
        let rows = self.k.iter().all(|(nm, k)| nm.is_finite() && k.is_finite() && *nm > 0.0 && *k >= 0.0);
        let rising = self.k.windows(2).all(|pair| pair[0].0 < pair[1].0);
        match (finite && !self.c.is_empty(), rows && rising) {
            (false, _) => Some("a coefficient of the formula is missing or not a finite number".into()),
            (true, false) => Some("a row of the table of k is not (rising λ > 0 nm, k ≥ 0)".into()),
            (true, true) => None,
        }
    }
}

/// a·λ^p; an absent term is 0 at every wavelength.
fn power(a: f64, um: f64, p: f64) -> f64 {
    if a == 0.0 { 0.0 } else { a * um.powf(p) }
}

/// Linear between the rows, constant beyond them.
fn linear(rows: &[(f64, f64)], nm: f64) -> f64 {
    let after = rows.partition_point(|row| row.0 < nm);
    let above = rows.get(after).or(rows.last());
    let below = after.checked_sub(1).and_then(|i| rows.get(i)).or(above);
    match (below, above) {
        (Some((x0, k0)), Some((x1, k1))) if x0 < x1 => k0 + (k1 - k0) * (nm - x0) / (x1 - x0),
        (Some((_, k)), _) | (None, Some((_, k))) => *k,
        (None, None) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stand_for_kinds_and_problems_are_named() {
        assert_eq!(FormulaKind::numbered(0), None);
        assert_eq!(FormulaKind::numbered(1), Some(FormulaKind::Sellmeier));
        assert_eq!(FormulaKind::numbered(9), Some(FormulaKind::Exotic));
        assert_eq!(FormulaKind::numbered(10), None);
        let law = |c: &[f64], k: &[(f64, f64)]| Formula { kind: FormulaKind::Cauchy, c: c.to_vec(), k: k.to_vec() };
        assert_eq!(law(&[1.5], &[(400.0, 0.0), (500.0, 1.0)]).problem(), None);
        for (bad, word) in [
            (law(&[], &[]), "coefficient"),
            (law(&[f64::NAN], &[]), "coefficient"),
            (law(&[1.5], &[(400.0, -1.0)]), "k"),
            (law(&[1.5], &[(400.0, 0.0), (400.0, 0.0)]), "rising"),
        ] {
            assert!(bad.problem().is_some_and(|problem| problem.contains(word)), "{bad:?}");
        }
    }

    /// Any number of coefficients, at any wavelength: a number or NaN, no panic.
    #[test]
    fn nothing_panics() {
        for number in 1..=9 {
            for count in 0..20 {
                let kind = FormulaKind::numbered(number).unwrap();
                let law = Formula { kind, c: vec![0.5; count], k: Vec::new() };
                for nm in [f64::NAN, -1.0, 0.0, 550.0, f64::INFINITY] {
                    let _ = law.index(nm);
                }
            }
        }
    }

    #[test]
    fn k_is_linear_between_its_rows_and_constant_beyond() {
        let law = Formula { kind: FormulaKind::Cauchy, c: vec![1.5], k: vec![(400.0, 0.1), (500.0, 0.3)] };
        for (nm, k) in [(300.0, 0.1), (400.0, 0.1), (450.0, 0.2), (500.0, 0.3), (600.0, 0.3)] {
            assert!((law.index(nm).im - k).abs() < 1e-15, "{nm}");
        }
    }
}
