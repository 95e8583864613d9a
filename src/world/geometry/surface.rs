//! What a face of a mesh is traced as: triangles, or an exact surface that they trim.

use super::curved::Curved;
use super::exact::Quadric;
use super::patch::{Projection, Shear};

/// The surface of a face.
#[derive(Debug, Clone, PartialEq)]
pub struct Sheet {
    /// The first face with the same exact surface (a ball may come as two faces), else the face itself.
    pub identity: u32,
    pub surface: Surface,
}

#[derive(Debug, Clone, PartialEq)]
pub enum Surface {
    /// Not traced.
    Absent,
    /// Triangles in one plane.
    Flat,
    /// Triangles that are not.
    Faceted,
    /// `outward` is the sign that turns the quadric's normal out of the solid.
    Exact { quadric: Quadric, projection: Projection, outward: f64 },
    /// The same beyond quadrics.
    Curved { curved: Box<Curved>, outward: f64 },
}

impl Surface {
    pub fn is_plane(&self) -> bool {
        match self {
            Surface::Absent | Surface::Faceted | Surface::Curved { .. } => false,
            Surface::Flat => true,
            Surface::Exact { quadric, .. } => quadric.curvature == 0.0,
        }
    }

    /// The direction along which an exact height field is shared out among its triangles.
    pub fn shear(&self) -> Option<&Shear> {
        match self {
            Surface::Exact { projection: Projection::Axial(shear), .. } => Some(shear),
            Surface::Curved { curved, .. } => curved.shear.as_ref(),
            Surface::Exact { projection: Projection::Central(_), .. }
            | Surface::Absent
            | Surface::Flat
            | Surface::Faceted => None,
        }
    }
}
