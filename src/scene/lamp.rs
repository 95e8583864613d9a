//! Whatever emits: faces, and the sky.

use crate::base::ids::GroupId;
use glam::DMat3;
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
}

/// How an emitter's intensity falls with the angle θ to its normal.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Angular {
    /// I ∝ cos θ.
    Lambert,
    /// I ∝ cosⁿ θ.
    CosN { n: f64 },
}

/// A face emits, one-sided, along its outward normal.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Emitter {
    pub group: GroupId,
    pub photometry: Photometry,
    pub angular: Angular,
    /// Name of the spectrum; colour is rendered from a later version on, until then it is kept and reported.
    pub spectrum: Option<String>,
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
    /// Panorama axes → world axes: a rotation.
    pub to_world: DMat3,
    pub file: String,
}
