//! What an importer has to say: nothing is repaired, defaulted or ignored silently.

use eyebox_base::units::significant;
use eyebox_base::{Code, Where};
use std::fmt;

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// For the record: a default that was used, a fit and its residual.
    Info,
    /// Probably not what the author meant, or repaired.
    Warning,
}

#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Note {
    pub severity: Severity,
    pub at: Where,
    pub text: String,
    /// What it is about, if `validate` is to find it. The words of `text` decide nothing.
    #[serde(skip)]
    pub code: Option<Code>,
    /// Nobody has said it, and all of the picture shows it: told wherever light is traced.
    #[serde(skip)]
    pub assumed: bool,
    /// The face of a mesh that it is about, where `at` is no closer than the mesh.
    #[serde(skip)]
    pub face: Option<usize>,
    /// How well the surface fits that was recovered from a face's points.
    #[serde(skip)]
    pub residual: Option<Residual>,
}

/// By how much a surface misses the points that it was fitted to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Residual {
    pub points: usize,
    pub rms_um: f64,
    pub greatest_um: f64,
    /// Of a freeform, how well the points determine it.
    pub known: Option<Known>,
}

/// Standard errors of a surface that was fitted to points: root mean squares over the face, and at worst.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Known {
    pub height_um: [f64; 2],
    pub slope_arcmin: [f64; 2],
    pub curvature_per_m: [f64; 2],
    /// Points that miss by so much more than the others that they don't count.
    pub strays: usize,
}

impl Note {
    pub fn new(severity: Severity, at: Where, text: impl Into<String>) -> Self {
        Note { severity, at, text: text.into(), code: None, assumed: false, face: None, residual: None }
    }
    pub fn info(at: Where, text: impl Into<String>) -> Self {
        Self::new(Severity::Info, at, text)
    }
    /// For the record, and told wherever light is traced.
    pub fn assumed(at: Where, text: impl Into<String>) -> Self {
        Note { assumed: true, ..Self::info(at, text) }
    }
    pub fn warning(at: Where, text: impl Into<String>) -> Self {
        Self::new(Severity::Warning, at, text)
    }
    /// Says what it is about.
    pub fn code(mut self, code: impl Into<Option<Code>>) -> Self {
        self.code = code.into();
        self
    }
    /// Says which face of a mesh it is about.
    pub fn face(mut self, number: usize) -> Self {
        self.face = Some(number);
        self
    }
    /// That `surface` was fitted to a face.
    pub fn fitted(at: Where, surface: &str, residual: Residual) -> Self {
        Note { residual: Some(residual), ..Self::info(at, format!("fitted {surface}: {residual}")) }
    }
}

impl fmt::Display for Residual {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (rms, greatest) = (significant(self.rms_um, 3), significant(self.greatest_um, 3));
        write!(f, "{} points miss it by {rms} µm rms, {greatest} µm at most", self.points)?;
        self.known.map_or(Ok(()), |known| write!(f, "; {known}"))
    }
}

impl fmt::Display for Known {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let pair = |[rms, worst]: [f64; 2]| (significant(rms, 2), significant(worst, 2));
        let ((height, height_worst), (slope, slope_worst)) = (pair(self.height_um), pair(self.slope_arcmin));
        let (curvature, curvature_worst) = pair(self.curvature_per_m);
        write!(
            f,
            "they leave {height} µm, {slope}′ of slope and {curvature} 1/m of curvature open \
             ({height_worst}, {slope_worst} and {curvature_worst} at worst)"
        )?;
        match self.strays {
            0 => Ok(()),
            1 => f.write_str("; 1 stray doesn't count"),
            n => write!(f, "; {n} strays don't count"),
        }
    }
}
