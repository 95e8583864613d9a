//! Parts: nodes with geometry, and what each of their faces is optically.

use super::{Dispersion, Emitter, Finish, Shape};
use crate::base::ids::{CoatingId, MediumId, MeshId, SlideId};
use glam::DAffine3;

/// What fills a closed solid.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Medium {
    /// Glass name, or what it was made from.
    pub name: String,
    pub index: Dispersion,
    /// Napierian absorption coefficient, 1/m (Beer–Lambert: exp(−a·length)).
    pub absorption_per_m: f64,
}

impl Medium {
    /// Absorption at a wavelength in vacuum, 1/m: `absorption_per_m`, and 4πk/λ of an imaginary index.
    pub fn absorption_per_m_at(&self, nm: f64) -> f64 {
        self.absorption_per_m + 4.0 * std::f64::consts::PI * self.index.index(nm).im / (nm * 1e-9)
    }
}

/// A node with geometry.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Part {
    /// Last segment of `path`.
    pub name: String,
    /// Root-relative path, e.g. `HUD_B/LENS_01_PMMA`.
    pub path: String,
    pub mesh: MeshId,
    /// Mesh units → world metres.
    pub to_world: DAffine3,
    /// The medium of the solid, or none: an opaque body or a thin sheet.
    pub medium: Option<MediumId>,
    /// Where solids overlap or touch, the higher priority wins.
    pub priority: i32,
    /// One entry per CAD face of the mesh, in order.
    pub faces: Vec<Face>,
}

/// What a CAD face of a part is optically.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Face {
    pub finish: Finish,
    /// Only on `Finish::Polished`.
    pub coating: Option<CoatingId>,
    pub shape: Shape,
    pub emitter: Option<Emitter>,
    /// A face with a slide transmits straight through, weighted by the picture, whatever its finish.
    pub slide: Option<SlideId>,
}
