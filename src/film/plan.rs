//! The plan as data: who owns which (light group, path class), and why. Made on floor 5, read by all below.

use super::detail::ErrorDetail;
use super::guide::Guide;
use crate::base::ids::GroupId;
use crate::base::path::{Class, Trail};

/// A way of tracing light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Estimator {
    /// Path tracing from the eye, with next-event estimation.
    Backward,
    /// Light tracing: paths from the lamps that arrive at the pupil.
    Forward,
    /// Photon map, gathered at the first broad scatterer seen by the eye.
    Photon,
}

impl Estimator {
    pub const ALL: [Estimator; 3] = [Estimator::Backward, Estimator::Forward, Estimator::Photon];
    pub fn name(self) -> &'static str {
        match self {
            Estimator::Backward => "backward",
            Estimator::Forward => "forward",
            Estimator::Photon => "photon",
        }
    }
}

/// Who owns the paths of one class from one light group.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// `owner` computes these paths. Where `owner` is `Photon`, paths without a broad scatterer are `Backward`'s.
    Own { owner: Estimator, because: String },
    /// There are no such paths, or nobody is asked for them.
    Skip { because: String },
}

/// What the lanes of a path stand for: how many wavelengths it carries at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Spectral {
    /// Luminance at one wavelength, or of light that nothing in the scene tells apart by wavelength.
    #[default]
    Mono,
    /// Linear Rec.709 values: the colours are given, and nothing bends or splits them.
    Rgb,
    /// Four wavelengths.
    Hero,
}

impl Spectral {
    pub fn name(self) -> &'static str {
        match self {
            Spectral::Mono => "mono",
            Spectral::Rgb => "rgb",
            Spectral::Hero => "hero",
        }
    }
}

/// How paths are traced: the smallest mode that is exact for the scene, and why.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct PathMode {
    pub spectral: Spectral,
    pub spectral_because: String,
    /// Paths carry Stokes vectors.
    pub polarised: bool,
    pub polarised_because: String,
}

/// One row per light group and class.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Row {
    pub group: GroupId,
    pub class: Class,
    pub verdict: Verdict,
}

/// Everything that was decided before pass 0.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Plan {
    /// Rows for group 0 in the order of [`Class::ALL`], then group 1, …
    pub rows: Vec<Row>,
    /// Lamp paths per pass of the forward estimator; 0 if it does not run.
    pub forward_paths: u64,
    /// Photons emitted per pass of the photon estimator; 0 if it does not run.
    pub photons: u64,
    /// Radius of the first pass's photon gathering, m.
    pub photon_radius_m: f64,
    /// Guided emission of the forward estimator, learned by a pilot; none: lamps by flux, directions by intensity.
    #[serde(skip)]
    pub forward_guide: Option<Guide>,
    /// The same for photons.
    #[serde(skip)]
    pub photon_guide: Option<Guide>,
    pub mode: PathMode,
    /// Whose standard errors are kept.
    pub errors: ErrorDetail,
    /// What the plan wants a reader to know: skipped estimators and layers, the wavelength, assumptions.
    pub notes: Vec<String>,
}

impl Plan {
    pub fn row(&self, group: GroupId, class: Class) -> &Row {
        &self.rows[group.index() * Class::ALL.len() + class as usize]
    }

    /// The single owner of a complete path of light group `group` with trail `eye_trail` (walked from the eye).
    pub fn owner(&self, group: GroupId, class: Class, has_broad: bool) -> Option<Estimator> {
        match &self.row(group, class).verdict {
            Verdict::Own { owner: Estimator::Photon, .. } if !has_broad => Some(Estimator::Backward),
            Verdict::Own { owner, .. } => Some(*owner),
            Verdict::Skip { .. } => None,
        }
    }

    /// Whether `estimator` owns any path at all.
    pub fn runs(&self, estimator: Estimator) -> bool {
        self.rows.iter().any(|row| match &row.verdict {
            Verdict::Own { owner, .. } => {
                *owner == estimator
                    // The rest of the photon map's classes (narrow lobes only) is backward's; see `Verdict::Own`.
                    || (*owner == Estimator::Photon && estimator == Estimator::Backward)
            }
            Verdict::Skip { .. } => false,
        })
    }

    /// [`Plan::owner`] of the path whose trail was walked from the eye.
    pub fn owner_from_eye(&self, group: GroupId, trail: Trail) -> Option<Estimator> {
        self.owner(group, trail.class_from_eye(), trail.has_broad())
    }
}
