//! Thin films on a face.

use super::Dispersion;

/// A coating of a polished face. Optical thicknesses never scale with the asset.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Coating {
    pub name: String,
    /// Films from outside the solid inwards.
    pub films: Vec<FilmLayer>,
}

/// One film of a stack.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct FilmLayer {
    pub index: Dispersion,
    pub thickness_nm: f64,
}
