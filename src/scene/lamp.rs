//! Whatever emits: faces, lamps that are no faces, and the sky.

use super::{RaySet, Spectrum};
use eyebox_base::Shared;
use eyebox_base::ids::{GroupId, PartId, ProfileId, SurfaceId};
use glam::{DMat3, DVec3};
use std::sync::Arc;

/// How strong an emitter is.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Photometry {
    /// Luminous flux of the whole face, lm.
    FluxLm(f64),
    /// Luminance (along the normal where it varies), cd/m².
    LuminanceCdM2(f64),
    /// Luminous intensity along the normal of the whole face, cd.
    IntensityCd(f64),
    /// What the measured distribution says: its own candela, for the whole face.
    AsMeasured,
}

/// How an emitter's intensity falls with the angle θ to its normal.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Angular {
    /// I ∝ cos θ.
    Lambert,
    /// I ∝ cosⁿ θ.
    CosN { n: f64 },
    /// I ∝ exp(−4 ln 2 (θ/`fwhm_deg`)²) in front of the face.
    Gauss { fwhm_deg: f64 },
    /// Measured. The profile's direction (0, 0) is the normal.
    Profile {
        profile: ProfileId,
        /// Direction of the plane C0 in the part's own axes, projected onto the face: not along its normal.
        c0: DVec3,
    },
}

/// Linear polarisation of the light that leaves.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct PolarisedLight {
    /// Direction of the electric field in the part's own axes, projected onto the face.
    pub axis: DVec3,
    /// 0 unpolarised … 1 fully polarised.
    pub degree: f64,
}

/// A face emits, one-sided, along its outward normal.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Emitter {
    pub group: GroupId,
    pub photometry: Photometry,
    /// It shines from the back of the face as from its front, which share a flux.
    pub both_sides: bool,
    pub angular: Angular,
    /// None if it isn't said: D65. It resolves ([`Spectrum::problem`] is none).
    pub spectrum: Option<Spectrum>,
    /// None: unpolarised.
    pub polarisation: Option<PolarisedLight>,
    /// The surface whose emission texture the light shines through: its own values are those of a white texture.
    pub pattern: Option<SurfaceId>,
}

/// A lamp that is no face: a point, a spot, a distant lamp or the rays of a file.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Beacon {
    /// For messages.
    pub name: String,
    pub group: GroupId,
    pub form: BeaconForm,
    /// None if it isn't said: D65. It resolves ([`Spectrum::problem`] is none).
    pub spectrum: Option<Spectrum>,
}

/// Where it is and how strong.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum BeaconForm {
    Point {
        /// World, m.
        position: DVec3,
        /// Along the axis of a spot; the same everywhere without one.
        intensity_cd: f64,
        spot: Option<SpotCone>,
    },
    /// A point with a measured distribution.
    Profile {
        /// World, m.
        position: DVec3,
        /// Photometric frame → world: a rotation.
        axes: DMat3,
        profile: ProfileId,
        /// Of the profile's candela.
        factor: f64,
    },
    /// From infinity.
    Distant {
        /// Unit direction that the light travels in.
        dir: DVec3,
        /// On a plane across `dir`, lx.
        illuminance_lx: f64,
        /// Full angle of its disc, 0 for parallel light, at most π: half of all directions.
        angle_rad: f64,
    },
    /// Rays of a file that leave a part: its own faces are not there for them until they have met another part.
    Rays {
        rays: Shared<RaySet>,
        /// In whose frame they are: the axes and the origin of its node, in millimetres whatever its scale.
        part: PartId,
        /// Luminous flux of all of them, lm.
        flux_lm: f64,
    },
}

/// A spot's intensity is full within the inner half angle and falls to 0 at the outer one, as the square of a line in
/// cos θ (KHR_lights_punctual).
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct SpotCone {
    /// Unit, away from the lamp.
    pub axis: DVec3,
    pub inner_rad: f64,
    pub outer_rad: f64,
}

/// Lat-long panorama. Looking along the axes of `to_world`: +y is the top row's pole; the centre of the picture is +z
/// and +x is left of it, as OpenEXR's latitude-longitude environment maps define it.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Sky {
    pub group: GroupId,
    pub width: usize,
    pub height: usize,
    /// Luminance of each pixel, cd/m², row-major from the top.
    #[serde(skip)]
    pub luminance: Arc<Vec<f32>>,
    /// Linear Rec.709 of each pixel, each component >= 0, whose luminance is that pixel of `luminance`; none if all are
    /// grey or one wavelength is traced.
    #[serde(skip)]
    pub rgb: Option<Arc<Vec<[f32; 3]>>>,
    /// Panorama axes → world axes: a rotation.
    pub to_world: DMat3,
    pub file: String,
}
