//! Why a face could not be recovered, in words for people.

use super::Kind;
use eyebox_base::units::significant;
use eyebox_base::{Code, Error, Where};
use glam::DVec3;
use std::fmt;

/// Lengths are in mesh units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FitError {
    /// A coordinate of this vertex is NaN or infinite.
    NotFinite { vertex: usize },
    /// A triangle names a vertex that is not there.
    BadIndex { triangle: usize, index: u32, points: usize },
    /// Fewer distinct points than the surface has unknowns.
    TooFew { kind: Kind, points: usize, need: usize },
    /// The points lie so that many surfaces pass through them.
    Undetermined { kind: Kind, why: &'static str },
    /// The best surface (of this kind if it was `asked` for, else of all kinds) misses the tolerance.
    /// `worst` is the point that it misses by the most.
    Misses { kind: Kind, asked: bool, rms: f64, max: f64, worst: DVec3, tolerance: f64 },
    /// A freeform passes by the points, but these are too few to say what is between: it misses those that are left out
    /// by more than the tolerance, in the root mean square.
    Open { kind: Kind, points: usize, left_out: f64, tolerance: f64 },
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FitError {
    /// The error as a fault at `at`, lengths in µm; `metres_per_unit` is the mesh unit.
    pub fn fault(&self, at: Where, metres_per_unit: f64) -> Box<Error> {
        let text = |x: f64| format!("{} µm", three(x * metres_per_unit * 1e6));
        let code = match self {
            FitError::NotFinite { .. } => Some(Code::DataNotFinite),
            FitError::TooFew { .. }
            | FitError::Undetermined { .. }
            | FitError::Misses { .. }
            | FitError::Open { .. } => Some(Code::ShapeOffMesh),
            FitError::BadIndex { .. } => None,
        };
        let fault = Error::new(at, self.what(text)).code(code);
        match self {
            FitError::Misses { tolerance, .. } | FitError::Open { tolerance, .. } => {
                fault.expected(format!("at most {}", text(*tolerance)))
            }
            FitError::TooFew { need, .. } => fault.expected(format!("at least {need}")),
            FitError::NotFinite { .. } | FitError::BadIndex { .. } | FitError::Undetermined { .. } => fault,
        }
    }

    /// The error in words, lengths in µm.
    pub fn text(&self, metres_per_unit: f64) -> String {
        self.what(|x| format!("{} µm", three(x * metres_per_unit * 1e6)))
    }

    fn what(&self, text: impl Fn(f64) -> String) -> String {
        match *self {
            FitError::NotFinite { vertex } => format!("vertex {vertex} has a coordinate that is not a number"),
            FitError::BadIndex { triangle, index, points } => {
                format!("triangle {triangle} names vertex {index}, but there are {points} vertices")
            }
            FitError::TooFew { kind, points, need } => {
                format!("a {kind} cannot be fitted to {points} distinct points (it takes {need})")
            }
            FitError::Undetermined { kind, why } => format!("a {kind} cannot be fitted: {why}"),
            FitError::Misses { kind, asked, rms, max, worst, .. } => {
                let best = if asked { "" } else { "best " };
                let [x, y, z] = worst.to_array().map(|x| significant(x, 6));
                format!("the {best}{kind} misses the points by {} rms, {} max at ({x}, {y}, {z})", text(rms), text(max))
            }
            FitError::Open { kind, points, left_out, .. } => format!(
                "{points} points are too few for a {kind}: it misses each that it is fitted without by {} rms",
                text(left_out)
            ),
        }
    }
}

impl fmt::Display for FitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.what(|x| format!("{x:.3e} mesh units")))
    }
}

impl std::error::Error for FitError {}

/// Three significant digits without an exponent where one can do without.
fn three(x: f64) -> String {
    if !(1e-4..1e6).contains(&x.abs()) {
        return format!("{x:.2e}");
    }
    let digits = (2.0 - x.abs().log10().floor()).max(0.0) as usize;
    format!("{x:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_line_in_micrometres() {
        let error = FitError::Misses {
            kind: Kind::Conic,
            asked: false,
            rms: 0.0021,
            max: 0.00884,
            worst: DVec3::new(1.5, -20.0, 3.25),
            tolerance: 5e-5,
        };
        let at = Where::Part { path: "HUD/LENS_02".into(), face: Some(0) };
        assert_eq!(
            error.fault(at, 1e-3).to_string(),
            "part HUD/LENS_02 face 0: the best conic misses the points by 2.10 µm rms, 8.84 µm max at (1.5, -20, 3.25); expected at most 0.0500 µm"
        );
    }
}
