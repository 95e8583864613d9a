//! Optical glasses, plastics, liquids and film materials by name, each with its source: a small catalogue of chosen rows, and
//! behind it the refractiveindex.info database ([`database`]).
//!
//! Two families of coefficients look alike and are not: formula 1 of refractiveindex.info prints resonance wavelengths,
//! which it squares; formula 2 (SCHOTT's) prints their squares. Formula 3 is a polynomial of n² in powers of λ.

pub mod database;

use super::dispersion::{Dispersion, Formula, FormulaKind};
use eyebox_base::Complex;
use std::sync::LazyLock;

/// The lines F, d and C, nm, between which catalogues give an Abbe number (ISO 7944).
pub const FDC_NM: [f64; 3] = [486.1327, 587.5618, 656.2725];

/// A catalogue row.
#[derive(Debug, Clone, PartialEq)]
pub struct Glass {
    pub name: &'static str,
    /// Other names that find it.
    pub also: &'static [&'static str],
    pub dispersion: Dispersion,
    /// The wavelengths that the law was made for, nm.
    pub valid_nm: [f64; 2],
    /// What bodies are made of; the others are films and metals.
    pub solid: bool,
    /// Where the coefficients come from.
    pub source: &'static str,
}

/// What a row of the catalogue is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Solids and liquids that bodies are made of.
    Body,
    /// A layer of a coating that lets light through.
    Film,
    /// k > n at the line d: ε < 0, so that light does not travel in it.
    Metal,
    Gas,
}

impl Kind {
    pub fn name(self) -> &'static str {
        match self {
            Kind::Body => "body",
            Kind::Film => "film",
            Kind::Metal => "metal",
            Kind::Gas => "gas",
        }
    }
}

impl Glass {
    pub fn kind(&self) -> Kind {
        let d = self.dispersion.index(FDC_NM[1]);
        match self.dispersion {
            _ if self.solid => Kind::Body,
            Dispersion::Gas { .. } | Dispersion::Formula(Formula { kind: FormulaKind::Gases, .. }) => Kind::Gas,
            _ if d.im > d.re => Kind::Metal,
            _ => Kind::Film,
        }
    }
    /// n + ik at the line d; none where the law was not made for it.
    pub fn index_d(&self) -> Option<Complex> {
        self.holds(FDC_NM[1]).then(|| self.dispersion.index(FDC_NM[1]))
    }
    /// V_d = (n_d − 1)/(n_F − n_C); none where the law was not made for all three lines, and of a metal, which has no
    /// light to disperse.
    pub fn abbe(&self) -> Option<f64> {
        let [f, d, c] = FDC_NM.map(|nm| self.dispersion.index(nm).re);
        (FDC_NM.iter().all(|nm| self.holds(*nm)) && self.kind() != Kind::Metal && f != c).then(|| (d - 1.0) / (f - c))
    }
    fn holds(&self, nm: f64) -> bool {
        self.beyond([nm; 2]).is_none()
    }
    /// What is beyond the law when light from `first` to `last` nm is traced, in words; none if it holds for all of it.
    pub fn beyond(&self, [first, last]: [f64; 2]) -> Option<String> {
        let [low, high] = self.valid_nm;
        (first < low || last > high).then(|| {
            let traced = if first == last { format!("{first} nm") } else { format!("{first} to {last} nm") };
            format!("{}: its index is known from {low} to {high} nm and extrapolated for {traced}", self.name)
        })
    }
}

const fn sellmeier(b: [f64; 3], c_um2: [f64; 3]) -> Dispersion {
    Dispersion::Sellmeier { b, c_um2 }
}

/// From the resonance wavelengths in µm, which formula 1 of refractiveindex.info squares.
const fn sellmeier_squared(b: [f64; 3], c_um: [f64; 3]) -> Dispersion {
    sellmeier(b, [c_um[0] * c_um[0], c_um[1] * c_um[1], c_um[2] * c_um[2]])
}

const fn solid(name: &'static str, dispersion: Dispersion, valid_nm: [f64; 2], source: &'static str) -> Glass {
    Glass { name, also: &[], dispersion, valid_nm, solid: true, source }
}

impl Glass {
    fn or(self, also: &'static [&'static str]) -> Self {
        Glass { also, ..self }
    }
    fn film(self) -> Self {
        Glass { solid: false, ..self }
    }
}

const SCHOTT: &str = "SCHOTT Zemax catalogue 2017-01-20b, relative to air at 20 °C";
const SULTANOVA: &str = "Sultanova, Kasarova, Nikolov, Acta Phys. Pol. A 116, 585 (2009), fit by refractiveindex.info";

/// The rows of `name` in films.csv.
fn film(name: &'static str, source: &'static str) -> Glass {
    let lines = include_str!("glass/films.csv").lines();
    let rows: Vec<(f64, f64, f64)> = lines
        .filter_map(|line| line.strip_prefix(name)?.strip_prefix(','))
        .filter_map(|line| {
            let mut numbers = line.split(',').filter_map(|field| field.parse::<f64>().ok());
            Some((numbers.next()?, numbers.next()?, numbers.next()?))
        })
        .collect();
    let valid_nm = [rows.first().map_or(0.0, |row| row.0), rows.last().map_or(0.0, |row| row.0)];
    solid(name, Dispersion::Table(rows), valid_nm, source).film()
}

#[rustfmt::skip]
static GLASSES: LazyLock<Vec<Glass>> = LazyLock::new(|| vec![
    solid("N-BK7", sellmeier([1.03961212, 0.231792344, 1.01046945], [0.00600069867, 0.0200179144, 103.560653]), [300.0, 2500.0], SCHOTT),
    solid("N-SK16", sellmeier([1.34317774, 0.241144399, 0.994317969], [0.00704687339, 0.0229005, 92.7508526]), [310.0, 2500.0], SCHOTT),
    solid("N-SF6", sellmeier([1.77931763, 0.338149866, 2.08734474], [0.0133714182, 0.0617533621, 174.01759]), [370.0, 2500.0], SCHOTT),
    solid("N-SF11", sellmeier([1.73759695, 0.313747346, 1.89878101], [0.013188707, 0.0623068142, 155.23629]), [370.0, 2500.0], SCHOTT),
    solid("F2", sellmeier([1.34533359, 0.209073176, 0.937357162], [0.00997743871, 0.0470450767, 111.886764]), [320.0, 2500.0], SCHOTT),
    solid("SF5", sellmeier([1.46141885, 0.247713019, 0.949995832], [0.0111826126, 0.0508594669, 112.041888]), [350.0, 2500.0], SCHOTT),
    solid(
        "fused silica", sellmeier_squared([0.6961663, 0.4079426, 0.8974794], [0.0684043, 0.1162414, 9.896161]), [210.0, 6700.0],
        "Malitson, J. Opt. Soc. Am. 55, 1205 (1965), 20 °C; range by Tan, J. Non-Cryst. Solids 223, 158 (1998)",
    ).or(&["SiO2"]),
    solid(
        "CaF2", sellmeier_squared([0.5675888, 0.4710914, 3.8484723], [0.050263605, 0.1003909, 34.64904]), [230.0, 9700.0],
        "Malitson, Appl. Opt. 2, 1103 (1963)",
    ),
    solid("PMMA", sellmeier([1.1819, 0.0, 0.0], [0.011313, 0.0, 0.0]), [436.8, 1052.0], SULTANOVA).or(&["PMMA_Sultanova"]),
    solid(
        "PMMA_Beadie",
        Dispersion::Polynomial {
            constant: 2.1778,
            terms: [[0.0061209, 2.0], [-0.0015004, 4.0], [0.023678, -2.0], [-0.0042137, -4.0], [0.00073417, -6.0], [-4.5042e-5, -8.0]],
        },
        [420.0, 1620.0], "Beadie, Brindza, Flynn, Rosenberg, Shirk, Appl. Opt. 54, F139 (2015), 20.1 °C",
    ),
    solid("polycarbonate", sellmeier([1.4182, 0.0, 0.0], [0.021304, 0.0, 0.0]), [436.8, 1052.0], SULTANOVA),
    solid(
        "water",
        Dispersion::Sellmeier4 {
            b: [0.5684027565, 0.1726177391, 0.02086189578, 0.1130748688],
            c_um2: [0.005101829712, 0.01821153936, 0.02620722293, 10.69792721],
        },
        [182.0, 1129.0], "Daimon, Masumura, Appl. Opt. 46, 3811 (2007), distilled, 20.0 °C",
    ).or(&["water_20C"]),
    // The air around everything counts as 1 here, as it does for the catalogues' glasses: for bodies in vacuum only.
    solid(
        "air_Ciddor", Dispersion::Gas { terms: [[0.05792105, 238.0185], [0.00167917, 57.362]] }, [230.0, 1690.0],
        "Ciddor, Appl. Opt. 35, 1566 (1996), relative to vacuum, 15 °C, 101325 Pa, 450 ppm CO2",
    ).film(),
    solid(
        "MgF2", sellmeier_squared([0.48755108, 0.39875031, 2.3120353], [0.04338408, 0.09461442, 23.793604]), [200.0, 7000.0],
        "Dodge, Appl. Opt. 23, 1980 (1984), ordinary ray of the crystal, 19 °C",
    ).film(),
    solid(
        "Al2O3", sellmeier_squared([1.4313493, 0.65054713, 5.3414021], [0.0726631, 0.1193242, 18.028251]), [200.0, 5000.0],
        "Malitson, Dodge, J. Opt. Soc. Am. 62, 1405 (1972), ordinary ray of sapphire, 20 °C",
    ).or(&["sapphire"]).film(),
    solid(
        "HfO2", Dispersion::Cauchy([1.875, 6.28e-3, 5.80e-4]), [200.0, 2000.0],
        "Al-Kuhaili, Opt. Mater. 27, 383 (2004), evaporated films",
    ).film(),
    film("TiO2", "Siefke et al., Adv. Opt. Mater. 4, 1780 (2016), films by atomic layer deposition"),
    film("Ta2O5", "Gao, Lemarchand, Lequime, Opt. Express 20, 15734 (2012), ion-assisted films"),
    film("Nb2O5", "Lemarchand (2013) by the method of Opt. Express 20, 15734 (2012), sputtered films"),
    film("Al", "Rakić, Appl. Opt. 34, 4755 (1995), evaporated films"),
    film("Ag", "Johnson, Christy, Phys. Rev. B 6, 4370 (1972)"),
    film("Au", "Johnson, Christy, Phys. Rev. B 6, 4370 (1972)"),
    film("Cr", "Johnson, Christy, Phys. Rev. B 9, 5056 (1974)"),
]);

/// The row called `name`, or the entry of the database; upper and lower case, `-`, `_` and spaces make no difference (`nbk7`
/// finds `N-BK7`) where none is spelt so. A row of the catalogue goes before an entry of the same name.
pub fn find(name: &str) -> Option<&'static Glass> {
    spelt(name).or_else(|| database::exact(name)).or_else(|| row(name)).or_else(|| database::find(name))
}

/// The row that is spelt so.
fn spelt(name: &str) -> Option<&'static Glass> {
    GLASSES.iter().find(|glass| known(glass).any(|own| own == name))
}

/// The row of the catalogue, without the database.
fn row(name: &str) -> Option<&'static Glass> {
    spelt(name).or_else(|| GLASSES.iter().find(|glass| known(glass).any(|own| letters(own).eq(letters(name)))))
}

fn known(glass: &Glass) -> impl Iterator<Item = &'static str> {
    std::iter::once(glass.name).chain(glass.also.iter().copied())
}

/// Every row, in the order of the catalogue; the database has its own [`database::names`].
pub fn all() -> &'static [Glass] {
    &GLASSES
}

/// The names as catalogue and database write them, second names among them.
pub fn names() -> impl Iterator<Item = &'static str> {
    GLASSES.iter().flat_map(known).chain(database::names())
}

/// A body that a word of a part's name may mean. Short names of the database are words as well (`PC3`, `K7`), so that they
/// count where `sure`: another word has said that the part is of glass.
pub fn body_in_words(word: &str, sure: bool) -> Option<&'static Glass> {
    let telling = || {
        word.len() > 2
            && word.contains(|c: char| c.is_ascii_digit())
            && word.contains(|c: char| c.is_ascii_alphabetic())
    };
    let entry = || if sure && telling() { database::find(word) } else { None };
    row(word).or_else(entry).filter(|glass| glass.solid)
}

fn letters(name: &str) -> impl Iterator<Item = char> {
    name.chars().filter(|c| !matches!(c, '-' | '_' | ' ')).map(|c| c.to_ascii_uppercase())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found_however_they_are_written() {
        for (given, name) in [
            ("NBK7", "N-BK7"),
            ("n_bk7", "N-BK7"),
            ("Fused_Silica", "fused silica"),
            ("sio2", "fused silica"),
            ("caf2", "CaF2"),
            ("Water 20C", "water"),
        ] {
            assert_eq!(find(given).map(|glass| glass.name), Some(name));
        }
        // Different glasses, not spellings.
        for missing in ["BK7", "SF6", "N-F2", "", "N-BK77", "air"] {
            assert_eq!(row(missing), None, "{missing}");
        }
        // A row goes before an entry, which its maker's name finds.
        assert_eq!([find("F2"), find("SCHOTT F2")].map(|glass| glass.unwrap().name), ["F2", "SCHOTT F2"]);
    }

    #[test]
    fn every_name_finds_its_own_row() {
        for name in GLASSES.iter().flat_map(known) {
            let glass = find(name).unwrap();
            assert!(known(glass).any(|own| own == name));
            assert!(!glass.source.is_empty() && glass.dispersion.problem().is_none(), "{name}");
            let [low, high] = glass.valid_nm;
            assert!(low < 440.0 && high > 830.0, "{name} {low} {high}");
            // A glass of the visible: normal dispersion, no absorption.
            let [blue, red] = [435.8, 656.3].map(|nm| glass.dispersion.index(nm));
            if glass.solid {
                assert!(blue.re > red.re && red.re > 1.3 && blue.im == 0.0, "{name}");
            }
        }
    }

    #[test]
    fn extrapolation_is_said() {
        let pmma = find("PMMA").unwrap();
        assert_eq!(pmma.beyond([550.0; 2]), None);
        assert_eq!(
            pmma.beyond([400.0, 700.0]).as_deref(),
            Some("PMMA: its index is known from 436.8 to 1052 nm and extrapolated for 400 to 700 nm")
        );
        assert!(pmma.beyond([400.0; 2]).is_some_and(|text| text.ends_with("for 400 nm")));
        assert_eq!(find("N-SF6").unwrap().beyond([400.0, 700.0]), None);
    }

    /// n_d and V_d of SCHOTT's data sheets, to their last digit.
    #[test]
    fn glasses_have_the_numbers_that_their_maker_publishes() {
        for (name, n_d, v_d) in [
            ("N-BK7", 1.51680, 64.17),
            ("N-SK16", 1.62041, 60.32),
            ("N-SF6", 1.80518, 25.36),
            ("N-SF11", 1.78472, 25.68),
            ("F2", 1.62004, 36.37),
            ("SF5", 1.67270, 32.21),
        ] {
            let glass = find(name).unwrap();
            let got = (glass.index_d().unwrap().re, glass.abbe().unwrap());
            assert!((got.0 - n_d).abs() <= 0.5e-5 && (got.1 - v_d).abs() <= 0.5e-2, "{name}: {got:?}");
        }
    }

    #[test]
    fn a_metal_and_a_law_of_another_range_have_no_abbe_number() {
        for (name, kind) in [
            ("N-BK7", Kind::Body),
            ("water", Kind::Body),
            ("TiO2", Kind::Film),
            ("Cr", Kind::Metal),
            ("Al", Kind::Metal),
            ("air_Ciddor", Kind::Gas),
        ] {
            let glass = find(name).unwrap();
            assert_eq!((glass.kind(), glass.abbe().is_some()), (kind, kind != Kind::Metal), "{name}");
        }
        let infrared = Glass {
            valid_nm: [500.0, 2000.0],
            ..solid("x", find("N-BK7").unwrap().dispersion.clone(), [0.0; 2], "test")
        };
        assert!(infrared.index_d().is_some() && infrared.abbe().is_none());
    }

    #[test]
    fn laws_are_not_confused() {
        // MgF2 and sapphire have squared constants, HfO2 has not; films as in the rows of their sources.
        for (name, nm, n, tolerance) in [
            ("MgF2", 587.6, 1.3777, 5e-5),
            ("Al2O3", 587.6, 1.7682, 5e-5),
            ("HfO2", 587.6, 1.8980, 1e-3),
            ("TiO2", 555.0, 2.43224, 1e-3),
            ("Ta2O5", 555.0, 2.155645, 1e-3),
            ("Nb2O5", 555.0, 2.357355, 1e-3),
        ] {
            let got = find(name).unwrap().dispersion.index(nm).re;
            assert!((got - n).abs() < tolerance, "{name}: {got}");
        }
    }
}
