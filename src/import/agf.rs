//! Catalogues of glasses as makers publish them for lens design programs (`.agf`), named in place of a glass: `FILE.agf#NAME`.
//!
//! A line is a keyword and numbers, and those that do not fit go on in the next, which begins with one: NM starts a glass and has its formula, CD the coefficients, LD the wavelengths in µm that
//! the formula holds for, IT a wavelength, the transmittance inside of the glass and its thickness in mm. TD and ED are of heat,
//! which nothing here has. Formulas by number as in the manual of Zemax OpticStudio, "Using material catalogs".

use super::{files, text};
use eyebox_base::error::Result;
use eyebox_base::{Code, Error, Where};
use eyebox_scene::glass::Glass;
use eyebox_scene::{Dispersion, Formula, FormulaKind};
use std::path::{Path, PathBuf};

/// How far n_d of a melt may be from that of its catalogue (SCHOTT, TIE-29, "Refractive index and dispersion", step 3): a law
/// that is farther from the n_d beside it is of another glass.
const MELT: f64 = 5e-4;
/// The yellow line of helium, nm.
const D_NM: f64 = 587.5618;

/// `FILE.agf#NAME`, taken apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reference<'a> {
    pub file: &'a str,
    pub name: &'a str,
}

impl<'a> Reference<'a> {
    /// None where `text` is the name of a glass and not of one in a file.
    pub fn of(text: &'a str) -> Option<Reference<'a>> {
        let (file, name) = text.rsplit_once('#')?;
        let agf = Path::new(file).extension().is_some_and(|extension| extension.eq_ignore_ascii_case("agf"));
        agf.then_some(Reference { file, name })
    }

    /// The file, as named at `at`.
    pub fn path(self, at: &Where) -> PathBuf {
        files::resolve(self.file, at)
    }

    /// The glass.
    ///
    /// # Errors
    /// The file can't be read, has no such glass, or says of it what can't be.
    pub fn read(self, at: &Where) -> Result<Glass> {
        self.compared(at).map(|(glass, _)| glass)
    }

    /// The same, and what contradicts itself in its lines.
    pub fn compared(self, at: &Where) -> Result<(Glass, Option<String>)> {
        let path = self.path(at);
        let text = text::decoded(&files::read(&path, at, "catalogue of glasses")?);
        glass(&text, &path, self.name, at)
    }
}

/// Lines with their numbers; a line that begins with a number belongs to the one before.
fn lines(text: &str) -> Vec<(usize, Vec<&str>)> {
    let mut out: Vec<(usize, Vec<&str>)> = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let words = line.split_whitespace();
        let goes_on = words.clone().next().is_some_and(|word| word.parse::<f64>().is_ok());
        match out.last_mut().filter(|_| goes_on) {
            Some((_, own)) => own.extend(words),
            None => out.push((i + 1, words.collect())),
        }
    }
    out
}

/// The glass `name` of the catalogue `text`, and what contradicts itself in its lines. Where none is spelt so, upper and lower
/// case make no difference, and then `-`, `_` and spaces.
fn glass(text: &str, path: &Path, name: &str, at: &Where) -> Result<(Glass, Option<String>)> {
    let lines = lines(text);
    let letters = |name: &str| name.replace(['-', '_', ' '], "").to_ascii_uppercase();
    let starts = |words: &[&str]| words.first() == Some(&"NM");
    let spelt = |alike: &dyn Fn(&str) -> bool| {
        let named = |words: &[&str]| starts(words) && words.get(1).is_some_and(|own| alike(own));
        lines.iter().position(|(_, words)| named(words))
    };
    let found = spelt(&|own| own == name)
        .or_else(|| spelt(&|own| own.eq_ignore_ascii_case(name)))
        .or_else(|| spelt(&|own| letters(own) == letters(name)));
    let Some((line, head)) = found.and_then(|index| lines.get(index)).map(|(line, head)| (*line, head)) else {
        let names: Vec<&str> =
            text.lines().filter_map(|line| line.strip_prefix("NM")?.split_whitespace().next()).collect();
        return Err(Error::new(at.clone(), format!("no glass `{name}` in {}", path.display()))
            .nearest(name, names)
            .code(Code::NameUnknown));
    };
    let fault = |line: usize, what: String| {
        Error::new(Where::Line { file: path.to_owned(), line }, what).code(Code::IndexImpossible)
    };
    let numbers = |line: usize, words: &[&str]| -> Result<Vec<f64>> {
        let number = |word: &&str| match word.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            Ok(_) | Err(_) => Err(fault(line, format!("`{word}` of glass `{name}` is not a number"))),
        };
        words.iter().skip(1).map(number).collect()
    };
    let number = head.get(2).and_then(|word| word.parse::<f64>().ok()).unwrap_or(f64::NAN);
    let (mut c, mut valid_um, mut k) = (Vec::new(), None, Vec::new());
    let own = lines.iter().skip(found.map_or(0, |index| index + 1)).take_while(|(_, words)| !starts(words));
    for (line, words) in own {
        match words.first().copied() {
            Some("CD") => c = numbers(*line, words)?,
            Some("LD") => valid_um = numbers(*line, words)?.first_chunk::<2>().copied(),
            Some("IT") => k.extend(extinction(&numbers(*line, words)?)),
            Some(_) | None => {}
        }
    }
    k.sort_by(|a: &(f64, f64), b| a.0.total_cmp(&b.0));
    k.dedup_by(|b, a| a.0 == b.0);
    let Some((kind, c)) = formula(number, &c) else {
        return Err(
            fault(line, format!("glass `{name}` has formula {}", head.get(2).unwrap_or(&"none"))).expected("1 to 13")
        );
    };
    let law = Formula { kind, c, k };
    let Some([low, high]) = valid_um.filter(|[low, high]| 0.0 < *low && low < high) else {
        return Err(
            fault(line, format!("glass `{name}` has no range of wavelengths")).expected("LD, two rising numbers")
        );
    };
    if let Some(problem) = law.problem() {
        return Err(fault(line, format!("glass `{name}`: {problem}")));
    }
    let glass = Glass {
        name: head.get(1).copied().unwrap_or(name).to_owned().leak(),
        also: &[],
        dispersion: Dispersion::Formula(law),
        valid_nm: [low, high].map(|um| (um * 1e6).round() / 1e3),
        solid: true,
        source: format!("{}, line {line}", path.display()).leak(),
    };
    // 1 and less stand for no number.
    let stated = head.get(4).and_then(|word| word.parse::<f64>().ok()).filter(|n| *n > 1.0);
    let within = low <= 1e-3 * D_NM && 1e-3 * D_NM <= high;
    let law = glass.dispersion.index(D_NM).re;
    let doubt = stated.filter(|n_d| within && (law.is_nan() || (law - n_d).abs() > MELT)).map(|n_d| {
        format!("{}: glass `{}` says n_d {n_d}, and its coefficients give {law:.6}", glass.source, glass.name)
    });
    Ok((glass, doubt))
}

/// (nm, k) of an IT line: k = −λ ln τ / 4πd. None where nothing came through, as then no number is known.
fn extinction(numbers: &[f64]) -> Option<(f64, f64)> {
    let &[um, tau, mm, ..] = numbers else { return None };
    let sound = um > 0.0 && tau > 0.0 && mm > 0.0;
    sound.then(|| (um * 1e3, -um * 1e-3 * tau.min(1.0).ln() / (4.0 * std::f64::consts::PI * mm)))
}

/// The formula of a number and its coefficients, as one of ours.
fn formula(number: f64, c: &[f64]) -> Option<(FormulaKind, Vec<f64>)> {
    let at = |i: usize| c.get(i).copied().unwrap_or(0.0);
    // n² as powers of λ from the constant on.
    let powers = |exponents: &[f64]| {
        let terms = exponents.iter().enumerate().flat_map(|(i, p)| [at(i + 1), *p]);
        (FormulaKind::Polynomial, std::iter::once(at(0)).chain(terms).collect())
    };
    // n² − 1 as `count` resonances.
    let resonances = |count: usize| {
        let terms = (0..count).flat_map(|i| [at(2 * i), at(2 * i + 1)]);
        (FormulaKind::Sellmeier2, std::iter::once(0.0).chain(terms).collect())
    };
    let kinds = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0];
    let which = kinds.iter().position(|kind| *kind == number)?;
    Some(match which + 1 {
        1 => powers(&[2.0, -2.0, -4.0, -6.0, -8.0]),
        2 => resonances(3),
        3 => (FormulaKind::Herzberger, (0..6).map(at).collect()),
        // n² − 1 = A + B1 λ²/(λ² − λ1²) + B2/(λ² − λ2²).
        4 => (FormulaKind::Mixed, vec![1.0 + at(0), at(1), 2.0, at(2), 2.0, at(3), 0.0, at(4), 2.0]),
        // Conrady: n = n0 + A/λ + B/λ^3.5.
        5 => (FormulaKind::Cauchy, vec![at(0), at(1), -1.0, at(2), -3.5]),
        6 => resonances(4),
        // n² = A + B/(λ² − C) − Dλ², and the same with Bλ².
        7 => (FormulaKind::Mixed, vec![at(0), at(1), 0.0, at(2), 1.0, 0.0, 0.0, 0.0, 0.0, -at(3), 2.0]),
        8 => (FormulaKind::Mixed, vec![at(0), at(1), 2.0, at(2), 1.0, 0.0, 0.0, 0.0, 0.0, -at(3), 2.0]),
        // n² = A + Bλ²/(λ² − C) + Dλ²/(λ² − E).
        9 => (FormulaKind::Sellmeier2, vec![at(0) - 1.0, at(1), at(2), at(3), at(4)]),
        10 => powers(&[2.0, -2.0, -4.0, -6.0, -8.0, -10.0, -12.0]),
        11 => resonances(5),
        12 => powers(&[2.0, -2.0, -4.0, -6.0, -8.0, 4.0, 6.0]),
        _ => powers(&[2.0, 4.0, -2.0, -4.0, -6.0, -8.0, -10.0, -12.0]),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The maker's own coefficients in Zemax' syntax; n by the oracle of the catalogue.
    const FILE: &str = "CC test\nNM N-BK7 2 517642.251 1.5168 64.17 0 1 0\nED 7.1 8.3 2.51 -0.0009 0\n\
        CD 1.03961212 0.00600069867 0.231792344 0.0200179144 1.01046945 103.560653\nTD 1.86e-6 1.31e-8 0 0 0 0 20\n\
        LD 0.3 2.5\nIT 0.4 0.997 10\nIT 0.5 0.998 10.0\n\
        NM POLY 1 0 0 0 0 0 0\nCD 2.25 0 0 0 0 0\nLD 0.3 2.5\nNM BAD 14 0 0 0\nCD 1\nLD 0.3 2.5\nNM WORSE 2\nCD x\n";

    fn read(name: &str) -> Result<Glass> {
        glass(FILE, Path::new("x.agf"), name, &Where::Nowhere).map(|(glass, _)| glass)
    }

    /// Coefficients that go on in lines below, as a maker prints them: the index is that of the glass's own n_d and V_d. With
    /// the first line alone it is 0.009 too high, which NM's n_d tells.
    #[test]
    fn lines_that_go_on() {
        let wrapped = "NM SF11 1 785258 1.784721 25.833679 0 2 0\nGC\nCD 3.127487 -6.374660E-002 -9.890957E-004 1.363913E-002 \n\
            -1.588824E-003 9.646333E-005 0 0\n0 0\nTD 0 0 0 0\n0 0 20\nOD -1 -1\nLD 0.4 0.7\n";
        let of = |text: &str| glass(text, Path::new("x.agf"), "SF11", &Where::Nowhere).unwrap();
        let (read, doubt) = of(wrapped);
        let n = |nm: f64| read.dispersion.index(nm).re;
        assert!((n(D_NM) - 1.784_721).abs() < 1e-6, "{}", n(D_NM));
        let v = (n(D_NM) - 1.0) / (n(486.1327) - n(656.2725));
        assert!((v - 25.833_679).abs() < 1e-3, "{v}");
        assert_eq!((doubt, read.valid_nm), (None, [400.0, 700.0]));
        let (_, doubt) = of(&wrapped.replace("-1.588824E-003 9.646333E-005 0 0\n0 0\n", ""));
        let said = doubt.expect("n_d contradicts it");
        assert!(
            said.contains("x.agf, line 1: glass `SF11` says n_d 1.784721, and its coefficients give 1.79"),
            "{said}"
        );
        // 1 is what stands where nobody knows.
        assert_eq!(of(&wrapped.replace("1.784721", "1.000000")).1, None);
    }

    /// `CDS-E` and `CDSE` are two glasses, and so are `Bk7` and `BK7`.
    #[test]
    fn a_name_as_it_is_spelt_goes_first() {
        let text = "NM CDS-E 1 1\nCD 4\nLD 0.3 2\nNM CDSE 1 1\nCD 9\nLD 0.3 2\nNM Bk7 1 1\nCD 16\nLD 0.3 2\nNM BK7 1 1\nCD 25\n\
            LD 0.3 2\n";
        for (name, n) in
            [("CDSE", 3.0), ("CDS-E", 2.0), ("cdse", 3.0), ("CDS_E", 2.0), ("BK7", 5.0), ("bk7", 4.0), ("B-K7", 4.0)]
        {
            let (read, _) = glass(text, Path::new("x.agf"), name, &Where::Nowhere).unwrap();
            assert_eq!(read.dispersion.index(550.0).re, n, "{name}");
        }
    }

    #[test]
    fn a_glass_and_its_transmittance() {
        let bk7 = read("nbk7").unwrap();
        let row = eyebox_scene::glass::find("N-BK7").unwrap();
        for nm in [400.0, 587.5618, 700.0] {
            assert!((bk7.dispersion.index(nm).re - row.dispersion.index(nm).re).abs() < 1e-14, "{nm}");
        }
        assert_eq!((bk7.name, bk7.valid_nm, bk7.source), ("N-BK7", [300.0, 2500.0], "x.agf, line 2"));
        // 10 mm at 400 nm let 0.997 through.
        let per_m = 4.0 * std::f64::consts::PI * bk7.dispersion.index(400.0).im / 400e-9;
        assert!(((-per_m * 0.01).exp() - 0.997).abs() < 1e-12, "{per_m}");
        assert_eq!(read("POLY").unwrap().dispersion.index(550.0).re, 1.5);
    }

    #[test]
    fn faults_are_one_line_with_their_place() {
        for (name, what) in [
            ("N-BK8", "no glass `N-BK8` in x.agf; did you mean `N-BK7`?"),
            ("BAD", "x.agf:12: glass `BAD` has formula 14; expected 1 to 13"),
            ("WORSE", "x.agf:16: `x` of glass `WORSE` is not a number"),
        ] {
            assert_eq!(read(name).unwrap_err().to_string(), what);
        }
    }

    /// At one wavelength, each formula as the manual writes it, by hand.
    #[test]
    fn every_formula() {
        let c = [1.9, 0.2, 0.03, 0.004, 0.02, 0.0006, 0.0007, 0.0008, 0.0009, 0.001];
        let um = 0.6f64;
        let p = |power: i32| um.powi(power);
        let s = |b: f64, l: f64| b * p(2) / (p(2) - l);
        let l = 1.0 / (p(2) - 0.028);
        let schott = c[0] + c[1] * p(2) + c[2] * p(-2) + c[3] * p(-4) + c[4] * p(-6) + c[5] * p(-8);
        let want = [
            schott.sqrt(),
            (1.0 + s(c[0], c[1]) + s(c[2], c[3]) + s(c[4], c[5])).sqrt(),
            c[0] + c[1] * l + c[2] * l * l + c[3] * p(2) + c[4] * p(4) + c[5] * p(6),
            (1.0 + c[0] + c[1] * p(2) / (p(2) - c[2] * c[2]) + c[3] / (p(2) - c[4] * c[4])).sqrt(),
            c[0] + c[1] / um + c[2] / um.powf(3.5),
            (1.0 + s(c[0], c[1]) + s(c[2], c[3]) + s(c[4], c[5]) + s(c[6], c[7])).sqrt(),
            (c[0] + c[1] / (p(2) - c[2]) - c[3] * p(2)).sqrt(),
            (c[0] + c[1] * p(2) / (p(2) - c[2]) - c[3] * p(2)).sqrt(),
            (c[0] + s(c[1], c[2]) + s(c[3], c[4])).sqrt(),
            (schott + c[6] * p(-10) + c[7] * p(-12)).sqrt(),
            (1.0 + s(c[0], c[1]) + s(c[2], c[3]) + s(c[4], c[5]) + s(c[6], c[7]) + s(c[8], c[9])).sqrt(),
            (schott + c[6] * p(4) + c[7] * p(6)).sqrt(),
            (c[0]
                + c[1] * p(2)
                + c[2] * p(4)
                + c[3] * p(-2)
                + c[4] * p(-4)
                + c[5] * p(-6)
                + c[6] * p(-8)
                + c[7] * p(-10)
                + c[8] * p(-12))
            .sqrt(),
        ];
        for (i, want) in want.into_iter().enumerate() {
            let (kind, c) = formula((i + 1) as f64, &c).unwrap();
            let got = Formula { kind, c, k: Vec::new() }.index(600.0);
            assert!((got.re - want).abs() < 1e-13 && got.im == 0.0, "formula {}: {got:?}, not {want}", i + 1);
        }
    }
}
