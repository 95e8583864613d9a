//! Colour: CIE 1931 colour-matching functions, colour spaces, sampling of wavelengths, RGB uplifted to spectra.
//!
//! The convention of every sum here: values each nm from 360 to 830 nm, XYZ = 683 lm/W · Σ S(λ) (x̄, ȳ, z̄)(λ) · 1 nm.

mod cmf;
mod grid;
mod illuminants;
mod matrices;
mod spaces; // that files of others name
mod uplift;
mod wavelengths;

pub use cmf::{cmf, cmf_for_sampling, xyz};
pub use grid::{COUNT, FIRST_NM, Grid, LAST_NM, grid, integral, lookup, nanometres, tabulated};
pub use illuminants::{d65, daylight, led, planck};
pub use matrices::{
    ACESCG_TO_REC709, ACESCG_TO_XYZ, AP1_TO_XYZ, BRADFORD_D65_TO_ACES, Matrix, REC709_TO_ACESCG, REC709_TO_XYZ,
    XYZ_TO_ACESCG, XYZ_TO_AP1, XYZ_TO_REC709, apply,
};
pub use spaces::{AP1, Chromaticities, FileSpace, REC709, XYZ};
pub use uplift::{basis, uplift_emission, uplift_reflectance};
pub use wavelengths::{Lane, density, hero, lanes};

/// Maximum of photopic luminous efficacy, lm/W, at 555 nm (with ȳ = 1 there).
pub const K_M: f64 = super::units::LUMINOUS_EFFICACY;

/// A colour in CIE XYZ; Y is the photometric quantity (lm, cd/m², …).
pub type Xyz = [f64; 3];
/// A colour in a linear RGB space.
pub type Rgb = [f64; 3];

/// Linear colour spaces that pictures are written in. White is D65 for `Rec709` and `Xyz`; ACEScg has its own, to which
/// Bradford's transform adapts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ColourSpace {
    #[default]
    Rec709,
    AcesCg,
    Xyz,
}

impl ColourSpace {
    pub const ALL: [ColourSpace; 3] = [ColourSpace::Rec709, ColourSpace::AcesCg, ColourSpace::Xyz];

    /// The name on the command line: `rec709`, `acescg`, `xyz`.
    pub fn name(self) -> &'static str {
        match self {
            ColourSpace::Rec709 => "rec709",
            ColourSpace::AcesCg => "acescg",
            ColourSpace::Xyz => "xyz",
        }
    }
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|space| space.name() == name)
    }
    /// The attribute `colorInteropID` of an EXR file (Color Interop Forum recommendation, 2024).
    pub fn interop_id(self) -> &'static str {
        match self {
            ColourSpace::Rec709 => "lin_rec709_scene",
            ColourSpace::AcesCg => "lin_ap1_scene",
            ColourSpace::Xyz => "lin_ciexyzd65_scene",
        }
    }
    /// Its primaries and white: the attribute `chromaticities` of an EXR file.
    pub fn chromaticities(self) -> &'static Chromaticities {
        match self {
            ColourSpace::Rec709 => &REC709,
            ColourSpace::AcesCg => &AP1,
            ColourSpace::Xyz => &XYZ,
        }
    }
    /// The space of a file's `colorInteropID`; everything unnamed or unknown is Rec.709.
    pub fn from_interop_id(id: Option<&str>) -> Self {
        Self::ALL.into_iter().find(|space| id == Some(space.interop_id())).unwrap_or_default()
    }
    pub fn from_xyz(self, xyz: Xyz) -> [f64; 3] {
        match self {
            ColourSpace::Rec709 => apply(&XYZ_TO_REC709, xyz),
            ColourSpace::AcesCg => apply(&XYZ_TO_ACESCG, xyz),
            ColourSpace::Xyz => xyz,
        }
    }
    pub fn to_xyz(self, colour: [f64; 3]) -> Xyz {
        match self {
            ColourSpace::Rec709 => apply(&REC709_TO_XYZ, colour),
            ColourSpace::AcesCg => apply(&ACESCG_TO_XYZ, colour),
            ColourSpace::Xyz => colour,
        }
    }
    pub fn from_rec709(self, rgb: Rgb) -> [f64; 3] {
        match self {
            ColourSpace::Rec709 => rgb,
            ColourSpace::AcesCg => apply(&REC709_TO_ACESCG, rgb),
            ColourSpace::Xyz => apply(&REC709_TO_XYZ, rgb),
        }
    }
    pub fn to_rec709(self, colour: [f64; 3]) -> Rgb {
        match self {
            ColourSpace::Rec709 => colour,
            ColourSpace::AcesCg => apply(&ACESCG_TO_REC709, colour),
            ColourSpace::Xyz => apply(&XYZ_TO_REC709, colour),
        }
    }
    /// Weights whose dot product with a colour is the luminance Y of [`ColourSpace::to_xyz`], in cd/m² for a picture.
    ///
    /// For ACEScg they differ in the third digit from those that AP1 has by itself (the second row of [`AP1_TO_XYZ`]):
    /// Bradford's transform keeps the luminance of white only.
    pub fn luminance_weights(self) -> [f64; 3] {
        match self {
            ColourSpace::Rec709 => REC709_TO_XYZ[1],
            ColourSpace::AcesCg => ACESCG_TO_XYZ[1],
            ColourSpace::Xyz => [0.0, 1.0, 0.0],
        }
    }
    /// The luminance of `colour`; that of (1, 1, 1) is exactly 1, as the weights add up to 1.
    pub fn luminance(self, colour: [f64; 3]) -> f64 {
        let [a, b, c] = colour;
        let [from_a, _, from_c] = self.luminance_weights();
        b + from_a * (a - b) + from_c * (c - b)
    }
}

/// Luminance of a linear Rec.709 colour, by the exact weights of its primaries, which ITU-R BT.709-6, item 3.2 rounds to
/// 0.2126, 0.7152 and 0.0722: what a colour loses and what its spectrum gains are then the same.
pub fn luminance(rgb: [f64; 3]) -> f64 {
    ColourSpace::Rec709.luminance(rgb)
}

#[cfg(test)]
mod tests;
