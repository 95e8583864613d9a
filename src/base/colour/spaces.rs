//! Colour spaces that files of others name: primaries, white and transfer curve, on the way to linear Rec.709.

use super::{Matrix, Rgb, XYZ_TO_REC709, apply};
use glam::{DMat3, DVec3};

/// CIE 1931 x and y of red, green, blue and white.
pub type Chromaticities = [[f64; 2]; 4];

const D65: [f64; 2] = [0.3127, 0.3290];
/// The white of ACES (SMPTE ST 2065-1:2012, section 4.4).
const ACES_WHITE: [f64; 2] = [0.32168, 0.33767];
/// ITU-R BT.709-6, table 1.
pub const REC709: Chromaticities = [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06], D65];
/// Academy S-2014-004, AP1.
pub const AP1: Chromaticities = [[0.713, 0.293], [0.165, 0.830], [0.128, 0.044], ACES_WHITE];
/// CIE XYZ as primaries: equal numbers are the white of equal energy, whatever white a picture has.
pub const XYZ: Chromaticities = [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [1.0 / 3.0, 1.0 / 3.0]];
/// By the middle part of a `colorInteropID` (Color Interop Forum recommendation, 2024): SMPTE ST 2065-1 (AP0), SMPTE EG
/// 432-1 (P3), ITU-R BT.2020-2, Adobe RGB (1998) color image encoding.
const PRIMARIES: [(&str, Chromaticities); 7] = [
    ("rec709", REC709),
    ("ap1", AP1),
    ("ap0", [[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.077], ACES_WHITE]),
    ("p3d65", [[0.680, 0.320], [0.265, 0.690], [0.150, 0.060], D65]),
    ("rec2020", [[0.708, 0.292], [0.170, 0.797], [0.131, 0.046], D65]),
    ("adobergb", [[0.64, 0.33], [0.21, 0.71], [0.15, 0.06], D65]),
    ("ciexyzd65", XYZ),
];
/// Chromaticities in files have three or four digits.
const SAME: f64 = 5e-4;

/// From stored values to linear ones.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Transfer {
    Linear,
    /// IEC 61966-2-1:1999, section 5.2.
    Srgb,
    Gamma(f64),
}

/// How the numbers of a file are to be read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FileSpace {
    transfer: Transfer,
    /// None: it is Rec.709 already.
    to_rec709: Option<Matrix>,
}

impl FileSpace {
    pub const LINEAR_REC709: FileSpace = FileSpace { transfer: Transfer::Linear, to_rec709: None };
    /// What PNG and JPEG hold that say nothing else.
    pub const SRGB: FileSpace = FileSpace { transfer: Transfer::Srgb, to_rec709: None };

    /// The space of a `colorInteropID`, e.g. `lin_ap1_scene`; none if it is none of those that the recommendation lists.
    pub fn of_interop_id(id: &str) -> Option<FileSpace> {
        let mut words = id.split('_');
        let (transfer, primaries, state) = (words.next()?, words.next()?, words.next()?);
        if words.next().is_some() || !["scene", "display"].contains(&state) {
            return None;
        }
        let transfer = match transfer {
            "lin" => Transfer::Linear,
            "srgb" => Transfer::Srgb,
            "g22" => Transfer::Gamma(2.2),
            "g18" => Transfer::Gamma(1.8),
            _ => return None,
        };
        let (_, chromaticities) = PRIMARIES.iter().find(|(name, _)| *name == primaries)?;
        Some(FileSpace { transfer, ..FileSpace::linear(chromaticities)? })
    }

    /// Linear with these primaries; none if they span nothing.
    pub fn linear(chromaticities: &Chromaticities) -> Option<FileSpace> {
        let near = |a: &[f64; 2], b: &[f64; 2]| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= SAME);
        let known = PRIMARIES.iter().map(|(_, known)| known);
        let nearest = known.into_iter().find(|known| known.iter().zip(chromaticities).all(|(a, b)| near(a, b)));
        let exact = nearest.unwrap_or(chromaticities);
        let to_rec709 = if *exact == REC709 {
            None
        } else if *exact == XYZ {
            // The picture's white is that of D65, as XYZ has no other.
            Some(XYZ_TO_REC709)
        } else {
            Some(to_rec709(exact)?)
        };
        Some(FileSpace { transfer: Transfer::Linear, to_rec709 })
    }

    /// Stored values as linear Rec.709 with the white of D65.
    pub fn to_rec709(&self, stored: Rgb) -> Rgb {
        let linear = match self.transfer {
            Transfer::Linear => stored,
            Transfer::Srgb => stored.map(srgb_to_linear),
            Transfer::Gamma(gamma) => stored.map(|value| value.signum() * value.abs().powf(gamma)),
        };
        let [r, g, b] = linear;
        match &self.to_rec709 {
            // Grey is grey in every space of red, green and blue.
            Some(matrix) if r != g || g != b || *matrix == XYZ_TO_REC709 => apply(matrix, linear),
            Some(_) | None => linear,
        }
    }

    /// Nothing is to be done.
    pub fn is_linear_rec709(&self) -> bool {
        *self == FileSpace::LINEAR_REC709
    }
}

/// IEC 61966-2-1, odd about 0 (as its annex for extended ranges has it).
fn srgb_to_linear(value: f64) -> f64 {
    let size = value.abs();
    value.signum() * if size <= 0.04045 { size / 12.92 } else { ((size + 0.055) / 1.055).powf(2.4) }
}

/// From linear values with these primaries to linear Rec.709, white to white (Bradford's transform).
fn to_rec709(chromaticities: &Chromaticities) -> Option<Matrix> {
    let [red, green, blue, white] = chromaticities;
    // SMPTE RP 177:1993, section 3.3, with the columns unscaled: y may be 0.
    let column = |[x, y]: &[f64; 2]| DVec3::new(*x, *y, 1.0 - x - y);
    let unscaled = DMat3::from_cols(column(red), column(green), column(blue));
    if !(white[1] > 0.0 && unscaled.determinant().abs() > f64::EPSILON) {
        return None;
    }
    let white_xyz = column(white) / white[1];
    let to_xyz = unscaled * DMat3::from_diagonal(unscaled.inverse() * white_xyz);
    let adapt = bradford(white_xyz, column(&D65) / D65[1]);
    let all = DMat3::from_cols_array_2d(&XYZ_TO_REC709).transpose() * adapt * to_xyz;
    let rows = all.transpose().to_cols_array_2d();
    rows.iter().flatten().all(|value| value.is_finite()).then_some(rows)
}

/// XYZ seen under one white → XYZ seen under another. The cone responses are those of K. M. Lam, "Metamerism and Colour
/// Constancy", thesis, University of Bradford, 1985, as ICC.1:2022, annex E prints them.
fn bradford(from: DVec3, to: DVec3) -> DMat3 {
    let cones =
        DMat3::from_cols_array_2d(&[[0.8951, -0.7502, 0.0389], [0.2664, 1.7135, -0.0685], [-0.1614, 0.0367, 1.0296]]);
    let (from, to) = (cones * from, cones * to);
    cones.inverse() * DMat3::from_diagonal(to / from) * cones
}

#[cfg(test)]
mod tests {
    use super::super::{ACESCG_TO_REC709, ColourSpace};
    use super::*;

    fn near(got: Rgb, want: Rgb, tolerance: f64) {
        assert!(got.iter().zip(want).all(|(got, want)| (got - want).abs() <= tolerance), "{got:?} {want:?}");
    }

    /// The oracle's matrix of ACEScg, and our own spaces by the names that we write.
    #[test]
    fn named_spaces_are_the_oracles() {
        let colour = [0.2, 0.7, 0.4];
        let ap1 = FileSpace::of_interop_id("lin_ap1_scene").expect("it is known");
        near(ap1.to_rec709(colour), apply(&ACESCG_TO_REC709, colour), 1e-6);
        for space in ColourSpace::ALL {
            let named = FileSpace::of_interop_id(space.interop_id()).expect("our own");
            near(named.to_rec709(colour), space.to_rec709(colour), 1e-6);
        }
        assert_eq!(FileSpace::of_interop_id("lin_rec709_scene"), Some(FileSpace::LINEAR_REC709));
        for unknown in ["data", "unknown", "lin_rec709", "log_ap1_scene", "lin_ap1_scene_x", "lin_ap9_scene", ""] {
            assert_eq!(FileSpace::of_interop_id(unknown), None, "{unknown}");
        }
    }

    /// IEC 61966-2-1: 0.5 is 0.214041 of white; Rec.2020's green is far outside of Rec.709 (BT.2087-0, table 2).
    #[test]
    fn curves_and_wide_primaries() {
        near(
            FileSpace::of_interop_id("srgb_rec709_scene").unwrap().to_rec709([0.5, 1.0, 0.0]),
            [0.214_041, 1.0, 0.0],
            1e-6,
        );
        near(FileSpace::of_interop_id("g22_rec709_scene").unwrap().to_rec709([0.5; 3]), [0.217_638; 3], 1e-6);
        let wide = FileSpace::of_interop_id("lin_rec2020_scene").unwrap();
        near(wide.to_rec709([0.0, 1.0, 0.0]), [-0.587_641, 1.132_900, -0.100_579], 1e-4);
        near(wide.to_rec709([1.0; 3]), [1.0; 3], 0.0);
    }

    #[test]
    fn chromaticities_of_files_have_few_digits() {
        assert_eq!(FileSpace::linear(&REC709), Some(FileSpace::LINEAR_REC709));
        let rounded = [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06], [0.313, 0.329]];
        assert_eq!(FileSpace::linear(&rounded), Some(FileSpace::LINEAR_REC709));
        assert_eq!(FileSpace::linear(&AP1), FileSpace::of_interop_id("lin_ap1_scene"));
        assert_eq!(FileSpace::linear(&[[0.3, 0.3], [0.3, 0.3], [0.3, 0.3], D65]), None);
        assert_eq!(FileSpace::linear(&[[f64::NAN; 2]; 4]), None);
    }
}
