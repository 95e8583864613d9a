//! The refractive index of a medium as a function of wavelength.

mod formula;

pub use formula::{Formula, FormulaKind};

use eyebox_base::Complex;

/// A dispersion law. Wavelengths are in nm at the surface, in µm inside the formulas; air counts as 1.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Dispersion {
    /// The same n at every wavelength.
    Constant(f64),
    /// n² = 1 + Σ B λ²/(λ² − C): the SCHOTT form, formula 2 of refractiveindex.info, with C in µm² and not squared.
    /// (Formula 1 prints the resonance in µm and squares it.) Unused terms are 0.
    Sellmeier { b: [f64; 3], c_um2: [f64; 3] },
    /// The same with four terms.
    Sellmeier4 { b: [f64; 4], c_um2: [f64; 4] },
    /// n² = constant + Σ a λᵖ over the terms [a, p], λ in µm: formula 3 of refractiveindex.info. Unused terms are 0.
    Polynomial { constant: f64, terms: [[f64; 2]; 6] },
    /// n = 1 + Σ a/(b − λ⁻²) over the terms [a, b], λ in µm: formula 6 of refractiveindex.info, for gases.
    Gas { terms: [[f64; 2]; 2] },
    /// n = A + B/λ² + C/λ⁴ with A, B in µm², C in µm⁴.
    Cauchy([f64; 3]),
    /// n = max(n_d + (n_d − 1)/V_d · (523655/λ² − 1.5168), 1), λ in nm: the law of KHR_materials_dispersion.
    /// An infinite V_d means no dispersion.
    Abbe { n_d: f64, v_d: f64 },
    /// Rows (λ nm, n, k) by rising λ, k ≥ 0 absorbs: linear in λ between them, constant beyond them.
    Table(Vec<(f64, f64, f64)>),
    /// A formula of the refractiveindex.info database or of a maker's catalogue.
    Formula(Formula),
    /// Another law and a number added to n at all wavelengths: a melt that is off.
    Offset { law: Box<Dispersion>, by: f64 },
}

impl Dispersion {
    /// Whether it says that n is the same at every wavelength. Laws that only happen to come to that say no.
    pub fn is_constant(&self) -> bool {
        match self {
            Dispersion::Constant(_) => true,
            Dispersion::Cauchy([_, b, c]) => [*b, *c] == [0.0; 2],
            Dispersion::Abbe { v_d, .. } => v_d.is_infinite(),
            Dispersion::Table(rows) => rows.windows(2).all(|pair| pair[0].1 == pair[1].1),
            Dispersion::Offset { law, .. } => law.is_constant(),
            Dispersion::Sellmeier { .. }
            | Dispersion::Sellmeier4 { .. }
            | Dispersion::Polynomial { .. }
            | Dispersion::Gas { .. }
            | Dispersion::Formula(_) => false,
        }
    }

    /// n + ik at `wavelength_nm` (in air). Never panics; a law that fails [`Dispersion::problem`] may give NaN.
    ///
    /// Where a Sellmeier law has n² < 0 (inside a resonance, far from the visible) the index is purely imaginary.
    pub fn index(&self, wavelength_nm: f64) -> Complex {
        let um_sq = (wavelength_nm * 1e-3).powi(2);
        match self {
            Dispersion::Constant(n) => Complex::real(*n),
            Dispersion::Sellmeier { b, c_um2 } => sellmeier(b, c_um2, um_sq),
            Dispersion::Sellmeier4 { b, c_um2 } => sellmeier(b, c_um2, um_sq),
            Dispersion::Polynomial { constant, terms } => {
                let um = wavelength_nm * 1e-3;
                let sum: f64 = terms.iter().map(|[a, p]| a * um.powf(*p)).sum();
                Complex::real(constant + sum).sqrt()
            }
            Dispersion::Gas { terms } => {
                let sum: f64 = terms.iter().map(|[a, b]| a / (b - 1.0 / um_sq)).sum();
                Complex::real(1.0 + sum)
            }
            Dispersion::Cauchy([a, b, c]) => Complex::real(a + (b + c / um_sq) / um_sq),
            Dispersion::Abbe { n_d, v_d } => {
                let slope = (n_d - 1.0) / v_d;
                Complex::real((n_d + slope * (523_655.0 / (wavelength_nm * wavelength_nm) - 1.5168)).max(1.0))
            }
            Dispersion::Table(rows) => interpolate(rows, wavelength_nm),
            Dispersion::Formula(formula) => formula.index(wavelength_nm),
            Dispersion::Offset { law, by } => {
                let Complex { re, im } = law.index(wavelength_nm);
                Complex::new(re + by, im)
            }
        }
    }

    /// What is wrong with the numbers of this law, in plain words, if anything is.
    pub fn problem(&self) -> Option<String> {
        let finite = |values: &[f64]| values.iter().all(|v| v.is_finite());
        match self {
            Dispersion::Constant(n) if !(finite(&[*n]) && *n > 0.0) => {
                Some(format!("index {n} is not a positive number"))
            }
            Dispersion::Sellmeier { b, c_um2 } if !(finite(b) && finite(c_um2)) => {
                Some("a Sellmeier coefficient is not a finite number".into())
            }
            Dispersion::Sellmeier4 { b, c_um2 } if !(finite(b) && finite(c_um2)) => {
                Some("a Sellmeier coefficient is not a finite number".into())
            }
            Dispersion::Polynomial { constant, terms } if !(constant.is_finite() && finite(terms.as_flattened())) => {
                Some("a coefficient of the polynomial is not a finite number".into())
            }
            Dispersion::Gas { terms } if !finite(terms.as_flattened()) => {
                Some("a coefficient of the gas is not a finite number".into())
            }
            Dispersion::Cauchy(abc) if !finite(abc) => Some("a Cauchy coefficient is not a finite number".into()),
            Dispersion::Abbe { n_d, .. } if !(finite(&[*n_d]) && *n_d >= 1.0) => {
                Some(format!("n_d = {n_d} is not a number of 1 or more"))
            }
            Dispersion::Abbe { v_d, .. } if v_d.is_nan() || *v_d <= 0.0 => Some(format!("V_d = {v_d} is not positive")),
            Dispersion::Table(rows) if rows.is_empty() => Some("the index table has no rows".into()),
            Dispersion::Table(rows) => rows
                .iter()
                .position(|&(nm, n, k)| !(finite(&[nm, n, k]) && nm > 0.0 && n >= 0.0 && k >= 0.0 && n + k > 0.0))
                .map(|i| format!("row {i} of the index table is not (λ > 0 nm, n ≥ 0, k ≥ 0, not both 0)"))
                .or_else(|| {
                    let i = rows.windows(2).position(|pair| pair[0].0 >= pair[1].0)?;
                    Some(format!("the wavelengths of the index table do not rise after row {i}"))
                }),
            Dispersion::Formula(formula) => formula.problem(),
            Dispersion::Offset { by, .. } if !by.is_finite() => Some(format!("{by} is added to the index")),
            Dispersion::Offset { law, .. } => law.problem(),
            Dispersion::Constant(_)
            | Dispersion::Sellmeier { .. }
            | Dispersion::Sellmeier4 { .. }
            | Dispersion::Polynomial { .. }
            | Dispersion::Gas { .. }
            | Dispersion::Cauchy(_)
            | Dispersion::Abbe { .. } => None,
        }
    }
}

fn sellmeier(b: &[f64], c_um2: &[f64], um_sq: f64) -> Complex {
    let sum: f64 = b.iter().zip(c_um2).map(|(b, c)| b * um_sq / (um_sq - c)).sum();
    Complex::real(1.0 + sum).sqrt()
}

/// Linear in λ, clamped to the ends; NaN for an empty table.
fn interpolate(rows: &[(f64, f64, f64)], nm: f64) -> Complex {
    let after = rows.partition_point(|row| row.0 < nm);
    let above = rows.get(after).or(rows.last());
    let below = after.checked_sub(1).and_then(|i| rows.get(i)).or(above);
    let (Some(&(x0, n0, k0)), Some(&(x1, n1, k1))) = (below, above) else {
        return Complex::new(f64::NAN, f64::NAN);
    };
    if x0 == x1 {
        return Complex::new(n0, k0);
    }
    let t = (nm - x0) / (x1 - x0);
    Complex::new(n0 * (1.0 - t) + n1 * t, k0 * (1.0 - t) + k1 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    // Fraunhofer F, d, C in nm (ISO 7944).
    const FDC: [f64; 3] = [486.1327, 587.5618, 656.2725];

    #[test]
    fn abbe_law_has_the_number_it_is_named_after() {
        let law = Dispersion::Abbe { n_d: 1.5168, v_d: 64.17 };
        let [f, d, c] = FDC.map(|nm| law.index(nm).re);
        // The constants of the extension are rounded: 523655 nm² and 1.5168 place d to 1e-5 and V to 1e-4.
        assert!((d - 1.5168).abs() < 1e-6, "{d}");
        assert!(((d - 1.0) / (f - c) / 64.17 - 1.0).abs() < 1e-4, "{}", (d - 1.0) / (f - c));
        assert_eq!(Dispersion::Abbe { n_d: 1.5, v_d: f64::INFINITY }.index(400.0), Complex::real(1.5));
        assert_eq!(Dispersion::Abbe { n_d: 1.01, v_d: 1.0 }.index(2000.0), Complex::ONE);
    }

    #[test]
    fn cauchy_constant_and_table_by_hand() {
        let cauchy = Dispersion::Cauchy([1.5, 0.004, 0.0001]);
        assert!((cauchy.index(500.0).re - (1.5 + 0.004 / 0.25 + 0.0001 / 0.0625)).abs() < 1e-15);
        assert_eq!(Dispersion::Constant(1.52).index(1.0), Complex::real(1.52));
        let table = Dispersion::Table(vec![(400.0, 1.0, 4.0), (500.0, 2.0, 5.0), (700.0, 1.0, 7.0)]);
        for (nm, n, k) in
            [(300.0, 1.0, 4.0), (400.0, 1.0, 4.0), (450.0, 1.5, 4.5), (600.0, 1.5, 6.0), (900.0, 1.0, 7.0)]
        {
            assert_eq!(table.index(nm), Complex::new(n, k), "{nm} nm");
        }
        assert_eq!(Dispersion::Table(vec![(550.0, 1.3, 0.2)]).index(780.0), Complex::new(1.3, 0.2));
    }

    #[test]
    fn problems_are_named_and_nothing_panics() {
        let table = |rows: &[(f64, f64, f64)]| Dispersion::Table(rows.to_vec());
        for (bad, word) in [
            (Dispersion::Constant(0.0), "positive"),
            (Dispersion::Constant(f64::NAN), "positive"),
            (Dispersion::Sellmeier { b: [1.0, f64::INFINITY, 0.0], c_um2: [0.0; 3] }, "Sellmeier"),
            (Dispersion::Sellmeier4 { b: [f64::NAN; 4], c_um2: [0.0; 4] }, "Sellmeier"),
            (Dispersion::Polynomial { constant: 2.0, terms: [[f64::INFINITY; 2]; 6] }, "polynomial"),
            (Dispersion::Gas { terms: [[f64::NAN; 2]; 2] }, "gas"),
            (Dispersion::Cauchy([f64::NAN; 3]), "Cauchy"),
            (Dispersion::Abbe { n_d: 0.9, v_d: 50.0 }, "n_d"),
            (Dispersion::Abbe { n_d: 1.5, v_d: 0.0 }, "V_d"),
            (table(&[]), "no rows"),
            (table(&[(400.0, 1.0, -1.0)]), "row 0"),
            (table(&[(500.0, 1.0, 0.0), (400.0, 1.0, 0.0)]), "rise"),
        ] {
            assert!(bad.problem().is_some_and(|p| p.contains(word)), "{bad:?}: {:?}", bad.problem());
            for nm in [f64::NAN, 0.0, -1.0, 550.0, f64::INFINITY] {
                let _ = bad.index(nm);
            }
        }
        assert_eq!(table(&[(400.0, 1.0, 0.0), (500.0, 0.5, 3.0)]).problem(), None);
    }

    #[test]
    fn written_and_read_back() {
        for law in [
            Dispersion::Constant(1.5),
            Dispersion::Sellmeier { b: [1.1819, 0.0, 0.0], c_um2: [0.011313, 0.0, 0.0] },
            Dispersion::Sellmeier4 { b: [0.5, 0.1, 0.0, 0.2], c_um2: [0.01, 0.0, 0.0, 10.0] },
            Dispersion::Polynomial { constant: 2.0, terms: [[0.1, -2.0]; 6] },
            Dispersion::Gas { terms: [[0.05, 238.0]; 2] },
            Dispersion::Cauchy([1.5, 0.004, 0.0]),
            Dispersion::Abbe { n_d: 1.5168, v_d: 64.17 },
            Dispersion::Table(vec![(400.0, 1.0, 4.0)]),
        ] {
            let text = serde_json::to_string(&law).unwrap();
            assert_eq!(serde_json::from_str::<Dispersion>(&text).unwrap(), law, "{text}");
        }
    }
}
