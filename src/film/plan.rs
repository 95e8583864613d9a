//! The plan as data: who owns which (light group, path class), and why. Made on floor 5, read by all below.

use super::error_detail::ErrorDetail;
use super::glint::Glint;
use super::guide::{ApertureGuide, Guide, Portals};
use super::layer::Layer;
use super::specular_chain::{Connection, Screen};
use super::unseen::Doubts;
use eyebox_base::ids::GroupId;
use eyebox_base::path::{Class, Trail};

/// A way of tracing light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Estimator {
    /// Path tracing from the eye, with next-event estimation.
    Backward,
    /// Light tracing: paths from the lamps that arrive at the pupil.
    Forward,
    /// Photon map, gathered at the first broad scatterer seen by the eye, or at the next one behind a rough face.
    Photon,
    /// Specular connection: paths over known trains of specular faces, solved for.
    Manifold,
}

impl Estimator {
    pub const ALL: [Estimator; 4] = [Estimator::Backward, Estimator::Forward, Estimator::Photon, Estimator::Manifold];
    pub fn name(self) -> &'static str {
        match self {
            Estimator::Backward => "backward",
            Estimator::Forward => "forward",
            Estimator::Photon => "photon",
            Estimator::Manifold => "manifold",
        }
    }
}

/// Who owns the paths of one class from one light group.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// `owner` computes these paths. Where `owner` is `Photon`, paths without a broad scatterer are `Backward`'s.
    Own { owner: Estimator, because: String },
    /// Specular connection computes those of these paths that its solver returns for their ends, `rest` all others. Of
    /// vision, rays from the eye have what comes over trains that connection does not know, or over faint ones to where it has
    /// no start: no pilot has seen these, so paths from the lamps to there may have any weight, but no ray from the eye brings
    /// more than a lamp's luminance.
    Connect { rest: Estimator, because: String },
    /// Only paths that start on the lamps follow this light, the rays of a file: photons have what a broad scatterer gets of
    /// it, light tracing the rest.
    Emitted { because: String },
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

/// Most paths of a pixel in one pass.
const MOST_PATHS: u32 = 64;
/// Branches fainter than this would be too many to follow.
const LEAST_BRANCH: f64 = 1.0 / 4096.0;
/// Trains times lamps that tables are made for, towards the pupil and towards scatterers; with more lamps there are fewer
/// trains, and with more than this none.
pub const MOST_ENTRIES: usize = 512;
pub const MOST_LIT: usize = 128;

/// Radii within which photons are gathered, m.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct Radii {
    /// Light straight from specular faces, which may be as sharp as the picture.
    pub caustic: f64,
    /// Light that a scatterer has sent, which is soft.
    pub secondary: f64,
}

impl Radii {
    fn is_valid(self) -> bool {
        [self.caustic, self.secondary].iter().all(|radius| *radius >= 0.0 && radius.is_finite())
    }
    /// Both times a factor.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Radii {
        Radii { caustic: self.caustic * factor, secondary: self.secondary * factor }
    }
}

fn whole() -> f64 {
    1.0
}

#[allow(clippy::trivially_copy_pass_by_ref)] // as serde wants it
fn is_whole(share: &f64) -> bool {
    *share == 1.0
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
    /// They part at interfaces and go both ways.
    #[serde(default)]
    pub photons_part: bool,
    /// Radii of the first pass's photon gathering, m.
    pub photon_radii_m: Radii,
    /// Guided emission of the forward estimator, learned by a pilot; none: lamps by flux, directions by intensity.
    #[serde(default)]
    pub forward_guide: Option<Guide>,
    /// The same for photons.
    #[serde(default)]
    pub photon_guide: Option<Guide>,
    /// Guided aperture: where in the pupil the backward estimator's rays look for lamps through specular faces, learned by
    /// a pilot; none: all over it.
    #[serde(default)]
    pub pupil_guide: Option<ApertureGuide>,
    /// Guided sky: through which windows light of the sky gets in to the scatterers that the backward estimator meets, learned
    /// by a pilot; none: directions to the sky are chosen by its luminance alone. Plans without it read as they always did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sky_guide: Option<Portals>,
    /// Paths per pixel and pass of the backward estimator.
    pub backward_paths: u32,
    /// Branches with this share of a path's light and more are followed for certain on the way to the first scatterer,
    /// fainter ones as much less often; of faces that reflect more than a tenth both ways, down to a 512th. 1: behind the first
    /// two faces chance chooses one of two ways on. Plans without it read as they always did.
    #[serde(default = "whole", skip_serializing_if = "is_whole")]
    pub faintest_branch: f64,
    /// Share of the pixels that a pass of the backward estimator looks at: less than 1 where a pilot found no light of its.
    pub backward_share: f64,
    /// Share of the pixels that such a pass looks at for lamps over trains that connection does not know there.
    #[serde(default = "whole", skip_serializing_if = "is_whole")]
    pub unknown_share: f64,
    /// Share of the pixels that such a pass looks at for lamps over specular faces: less than 1 where pilots found no such path.
    #[serde(default = "whole", skip_serializing_if = "is_whole")]
    pub vision_share: f64,
    /// Trains over which lamps and eye are joined.
    pub connections: Vec<Connection>,
    /// Trains over which lamps and faces that scatter are joined.
    pub screens: Vec<Screen>,
    /// Places of the picture where lamps are seen, straight or over specular faces, that the backward estimator looks closer at.
    #[serde(default)]
    pub glints: Vec<Glint>,
    /// What rays from the eye may miss, as far as pilots tell. Plans without it read as they always did.
    #[serde(default, skip_serializing_if = "Doubts::is_none")]
    pub doubts: Doubts,
    pub mode: PathMode,
    /// Whose standard errors are kept.
    pub errors: ErrorDetail,
    /// What the plan wants a reader to know: skipped estimators and layers, the wavelength, assumptions.
    pub notes: Vec<String>,
}

impl Plan {
    /// Whether the numbers of a plan from a file fit a scene with so many light groups and parts. Faults in words.
    pub fn check(&self, groups: usize, parts: usize) -> Result<(), String> {
        if self.rows.len() != groups * Class::ALL.len() {
            let classes = Class::ALL.len();
            return Err(format!("has {} rows for {} groups of {classes} classes", self.rows.len(), groups));
        }
        let named = self.rows.iter().map(|row| row.group);
        let named = named.chain(self.connections.iter().map(|c| c.group)).chain(self.screens.iter().map(|s| s.group));
        if let Some(group) = named.into_iter().find(|group| group.index() >= groups) {
            return Err(format!("names group {} of {}", group.index(), groups));
        }
        let trains = self.connections.iter().map(|c| &c.train).chain(self.screens.iter().map(|s| &s.train));
        let lenses = trains.flat_map(|train| &train.0);
        let used = lenses.flat_map(|lens| [Some(lens.link.part), lens.before, lens.after]).flatten();
        let used = used.chain(self.screens.iter().map(|screen| screen.part));
        if let Some(part) = used.into_iter().find(|part| *part as usize >= parts) {
            return Err(format!("names part {part} of {}", parts));
        }
        for (named, count, most) in
            [("connections", self.connections.len(), MOST_ENTRIES), ("screens", self.screens.len(), MOST_LIT)]
        {
            if count > most {
                return Err(format!("has {count} {named}, more than {most}"));
            }
        }
        if !(1..=MOST_PATHS).contains(&self.backward_paths) {
            return Err(format!(
                "has {} backward paths per pixel and pass, not 1 to {MOST_PATHS}",
                self.backward_paths
            ));
        }
        if self.faintest_branch < LEAST_BRANCH {
            return Err(format!("follows branches down to shares of {}, not {LEAST_BRANCH}", self.faintest_branch));
        }
        let shares = [self.backward_share, self.unknown_share, self.vision_share, self.faintest_branch];
        if !(shares.iter().all(|share| *share > 0.0 && *share <= 1.0) && self.photon_radii_m.is_valid()) {
            return Err(format!("has shares of {shares:?} and radii of {:?} m", self.photon_radii_m));
        }
        if !self.doubts.is_valid() {
            return Err(format!("says of what rays may miss {:?}", self.doubts));
        }
        if let Some(at) = self.glints.iter().position(|glint| !glint.is_valid()) {
            return Err(format!("has a place of a lamp, number {at}, that is no parallelogram of finite size"));
        }
        Ok(())
    }

    /// A plan of these rows alone: no pilot has said anything yet.
    pub fn of(rows: Vec<Row>, mode: PathMode) -> Plan {
        Plan {
            rows,
            forward_paths: 0,
            photons: 0,
            photons_part: false,
            photon_radii_m: Radii::default(),
            backward_share: 1.0,
            unknown_share: 1.0,
            vision_share: 1.0,
            backward_paths: 1,
            faintest_branch: 1.0,
            connections: Vec::new(),
            screens: Vec::new(),
            glints: Vec::new(),
            doubts: Doubts::default(),
            forward_guide: None,
            photon_guide: None,
            pupil_guide: None,
            sky_guide: None,
            mode,
            errors: ErrorDetail::default(),
            notes: Vec::new(),
        }
    }

    pub fn row(&self, group: GroupId, class: Class) -> &Row {
        &self.rows[group.index() * Class::ALL.len() + class as usize]
    }

    /// The single owner of a complete path of light group `group` with trail `eye_trail` (walked from the eye).
    pub fn owner(&self, group: GroupId, class: Class, has_broad: bool) -> Option<Estimator> {
        match &self.row(group, class).verdict {
            Verdict::Own { owner: Estimator::Photon, .. } if !has_broad => Some(Estimator::Backward),
            Verdict::Own { owner, .. } => Some(*owner),
            // At a narrow lobe nothing is gathered, and nothing connected.
            Verdict::Connect { rest: Estimator::Photon, .. } if !has_broad => Some(Estimator::Backward),
            Verdict::Connect { .. } => Some(Estimator::Manifold),
            Verdict::Emitted { .. } if has_broad && class != Class::Vision => Some(Estimator::Photon),
            Verdict::Emitted { .. } => Some(Estimator::Forward),
            Verdict::Skip { .. } => None,
        }
    }

    /// Whether `estimator` computes paths of this class: as their owner, or as one that keeps what the owner's solver does
    /// not return.
    pub fn computes(&self, estimator: Estimator, group: GroupId, class: Class, has_broad: bool) -> bool {
        match &self.row(group, class).verdict {
            Verdict::Connect { rest, .. } if has_broad || *rest != Estimator::Photon => {
                let unknown = class == Class::Vision && estimator == Estimator::Backward;
                estimator == Estimator::Manifold || estimator == *rest || unknown
            }
            Verdict::Connect { .. } | Verdict::Own { .. } | Verdict::Emitted { .. } | Verdict::Skip { .. } => {
                self.owner(group, class, has_broad) == Some(estimator)
            }
        }
    }

    /// The layer that holds what `estimator` computes of a class: what connection leaves goes where its own light goes.
    pub fn layer(&self, estimator: Estimator, group: GroupId, class: Class, has_broad: bool) -> Layer {
        Layer::of(class, self.owner(group, class, has_broad).unwrap_or(estimator))
    }

    /// Whether `estimator` computes any path at all.
    pub fn runs(&self, estimator: Estimator) -> bool {
        // With and without a broad scatterer the owners differ; see `Verdict::Own`.
        let any = |row: &Row| [false, true].map(|has_broad| self.computes(estimator, row.group, row.class, has_broad));
        self.rows.iter().any(|row| any(row).contains(&true))
    }

    /// Whether `estimator` owns all paths of some kind, and does not just keep what connection leaves.
    pub fn owns(&self, estimator: Estimator) -> bool {
        let owner = |row: &Row| [false, true].map(|has_broad| self.owner(row.group, row.class, has_broad));
        self.rows.iter().any(|row| owner(row).contains(&Some(estimator)))
    }

    /// [`Plan::owner`] of the path whose trail was walked from the eye.
    pub fn owner_from_eye(&self, group: GroupId, trail: Trail) -> Option<Estimator> {
        self.owner(group, trail.class_from_eye(), trail.has_broad())
    }
}

#[cfg(test)]
#[path = "plan_tests.rs"]
mod tests;
