//! A small catalogue of optical glasses and plastics by name, each row with its source.

use super::dispersion::Dispersion;

/// A catalogue row.
#[derive(Debug, PartialEq)]
pub struct Glass {
    pub name: &'static str,
    pub dispersion: Dispersion,
    /// Where the coefficients come from.
    pub source: &'static str,
}

const fn sellmeier(b: [f64; 3], c_um2: [f64; 3]) -> Dispersion {
    Dispersion::Sellmeier { b, c_um2 }
}

/// From the resonance wavelengths in µm, which formula 1 of refractiveindex.info squares.
const fn sellmeier_squared(b: [f64; 3], c_um: [f64; 3]) -> Dispersion {
    sellmeier(b, [c_um[0] * c_um[0], c_um[1] * c_um[1], c_um[2] * c_um[2]])
}

const SCHOTT: &str = "SCHOTT Zemax catalogue 2017-01-20b, relative to air at 20 °C";
const SULTANOVA: &str =
    "Sultanova, Kasarova, Nikolov, Acta Phys. Pol. A 116, 585 (2009), 436.8–1052 nm, fit by refractiveindex.info";

static GLASSES: [Glass; 10] = [
    Glass {
        name: "N-BK7",
        dispersion: sellmeier([1.03961212, 0.231792344, 1.01046945], [0.00600069867, 0.0200179144, 103.560653]),
        source: SCHOTT,
    },
    Glass {
        name: "N-SK16",
        dispersion: sellmeier([1.34317774, 0.241144399, 0.994317969], [0.00704687339, 0.0229005, 92.7508526]),
        source: SCHOTT,
    },
    Glass {
        name: "N-SF6",
        dispersion: sellmeier([1.77931763, 0.338149866, 2.08734474], [0.0133714182, 0.0617533621, 174.01759]),
        source: SCHOTT,
    },
    Glass {
        name: "N-SF11",
        dispersion: sellmeier([1.73759695, 0.313747346, 1.89878101], [0.013188707, 0.0623068142, 155.23629]),
        source: SCHOTT,
    },
    Glass {
        name: "F2",
        dispersion: sellmeier([1.34533359, 0.209073176, 0.937357162], [0.00997743871, 0.0470450767, 111.886764]),
        source: SCHOTT,
    },
    Glass {
        name: "SF5",
        dispersion: sellmeier([1.46141885, 0.247713019, 0.949995832], [0.0111826126, 0.0508594669, 112.041888]),
        source: "SCHOTT's published coefficients; checked against the indices of oracles/04_lens",
    },
    Glass {
        name: "fused silica",
        dispersion: sellmeier_squared([0.6961663, 0.4079426, 0.8974794], [0.0684043, 0.1162414, 9.896161]),
        source: "Malitson, J. Opt. Soc. Am. 55, 1205 (1965), 20 °C",
    },
    Glass {
        name: "CaF2",
        dispersion: sellmeier_squared([0.5675888, 0.4710914, 3.8484723], [0.050263605, 0.1003909, 34.64904]),
        source: "Malitson, Appl. Opt. 2, 1103 (1963)",
    },
    Glass { name: "PMMA", dispersion: sellmeier([1.1819, 0.0, 0.0], [0.011313, 0.0, 0.0]), source: SULTANOVA },
    Glass { name: "polycarbonate", dispersion: sellmeier([1.4182, 0.0, 0.0], [0.021304, 0.0, 0.0]), source: SULTANOVA },
];

/// The row called `name`; upper and lower case, `-`, `_` and spaces make no difference (`nbk7` finds `N-BK7`).
pub fn find(name: &str) -> Option<&'static Glass> {
    GLASSES.iter().find(|glass| letters(glass.name).eq(letters(name)))
}

/// The names as the catalogue writes them.
pub fn names() -> impl Iterator<Item = &'static str> {
    GLASSES.iter().map(|glass| glass.name)
}

fn letters(name: &str) -> impl Iterator<Item = char> {
    name.chars().filter(|c| !matches!(c, '-' | '_' | ' ')).map(|c| c.to_ascii_uppercase())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found_however_they_are_written() {
        for (given, name) in [("NBK7", "N-BK7"), ("n_bk7", "N-BK7"), ("Fused_Silica", "fused silica"), ("caf2", "CaF2")]
        {
            assert_eq!(find(given).map(|glass| glass.name), Some(name));
        }
        // Different glasses, not spellings.
        for missing in ["BK7", "SF6", "N-F2", "", "N-BK77"] {
            assert_eq!(find(missing), None, "{missing}");
        }
    }

    #[test]
    fn every_name_finds_its_own_row() {
        for name in names() {
            let glass = find(name).unwrap();
            assert_eq!(glass.name, name);
            assert!(!glass.source.is_empty() && glass.dispersion.problem().is_none());
            // A glass of the visible: normal dispersion, no absorption.
            let [blue, red] = [435.8, 656.3].map(|nm| glass.dispersion.index(nm));
            assert!(blue.re > red.re && red.re > 1.3 && blue.im == 0.0);
        }
    }
}
