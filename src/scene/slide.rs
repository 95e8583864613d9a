//! A thin transmissive picture, such as an LCD's.

use glam::DVec3;
use std::sync::Arc;

/// T(x) = T_black + s(x)·(T_white − T_black), T_black = T_white/contrast. Opaque outside the picture.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Slide {
    pub name: String,
    pub file: String,
    pub width: usize,
    pub height: usize,
    /// s of each pixel, 0–1, row-major from the top left. A pixel is a cell of uniform transmittance.
    #[serde(skip)]
    pub pixels: Arc<Vec<f32>>,
    /// s of each pixel for red, green and blue (linear Rec.709, 0–1), of which `pixels` is the luminance; none if all
    /// are grey or one wavelength is traced.
    #[serde(skip)]
    pub rgb: Option<Arc<Vec<[f32; 3]>>>,
    /// Centre of the picture, mesh units.
    pub centre: DVec3,
    /// Unit vectors to the right and up as the picture is authored, mesh units.
    pub u: DVec3,
    pub v: DVec3,
    /// Width and height of the picture, mesh units.
    pub size: [f64; 2],
    /// T_white, 0–1.
    pub transmittance: f64,
    /// C = T_white/T_black, infinite if T_black = 0.
    pub contrast: f64,
    /// Of the light that leaves; none: unpolarised.
    pub polarisation: Option<Polarisation>,
    /// Of a display: what red, green and blue (Rec.709) of its white are to each other; none: those of the lamp's light, all alike.
    pub primaries: Option<[f64; 3]>,
}

/// Linear polarisation.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Polarisation {
    /// Direction of the electric field, from u towards v.
    pub angle_deg: f64,
    /// Polarised share of the power, 0–1.
    pub degree: f64,
}
