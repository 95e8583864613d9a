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
    pub absorption: Absorption,
}

/// Napierian absorption coefficient, 1/m (Beer–Lambert: exp(−a·length)).
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Absorption {
    /// The same at every wavelength.
    Constant(f64),
    /// Rows (λ nm, 1/m) by rising λ: linear between them, constant beyond them.
    Table(Vec<[f64; 2]>),
}

impl Absorption {
    pub const NONE: Absorption = Absorption::Constant(0.0);

    /// 1/m at a wavelength in vacuum.
    pub fn per_m(&self, nm: f64) -> f64 {
        match self {
            Absorption::Constant(per_m) => *per_m,
            Absorption::Table(rows) => {
                let after = rows.partition_point(|row| row[0] < nm);
                let above = rows.get(after).or(rows.last());
                let below = after.checked_sub(1).and_then(|i| rows.get(i)).or(above);
                match (below, above) {
                    (Some([x0, a0]), Some([x1, a1])) if x0 < x1 => a0 + (a1 - a0) * (nm - x0) / (x1 - x0),
                    (Some([_, a]), _) => *a,
                    (None, _) => 0.0,
                }
            }
        }
    }
}

impl Medium {
    /// Absorption at a wavelength in vacuum, 1/m: its own, and 4πk/λ of an imaginary index.
    pub fn absorption_per_m_at(&self, nm: f64) -> f64 {
        self.absorption.per_m(nm) + 4.0 * std::f64::consts::PI * self.index.index(nm).im / (nm * 1e-9)
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
