//! What a standard surface is where light meets it, for one wavelength or primary.

use super::energy;
use super::film::FilmLook;
use super::lobe::{Lobe, Stretch};
use eyebox_base::warp::Frame;
use glam::DVec3;

/// Its colours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tint {
    pub base: f64,
    pub specular: f64,
    /// Of what scatters through.
    pub through: f64,
    pub sheen: f64,
    /// What the coat leaves on the way in and out.
    pub coat: f64,
    /// Of a metal at 82°.
    pub edge: f64,
}

/// A standard surface at a point, in a lane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    pub tint: Tint,
    /// Means over the primaries: what lobes are chosen by, alike for all lanes.
    pub mean: Tint,
    pub metallic: f64,
    /// Of the body.
    pub diffuse_roughness: f64,
    /// Of the facets of the base.
    pub alpha: f64,
    /// Where they are not alike all round.
    pub stretch: Option<Stretch>,
    pub film: Option<FilmLook>,
    /// Reflectance at normal incidence by the index alone.
    pub straight: f64,
    /// Weight of the dielectric's reflection.
    pub specular: f64,
    /// Share that goes straight through a sheet.
    pub transmission: f64,
    /// Share of what is scattered that goes through.
    pub diffuse_transmission: f64,
    pub coat: f64,
    pub coat_alpha: f64,
    /// The coat's normal in the local frame, where it is not that of the base.
    pub coat_normal: Option<DVec3>,
    /// The normal of the body in the local frame, where it is not that of the facets: they are seen from where it turns away.
    pub body_normal: Option<DVec3>,
    pub sheen_alpha: f64,
    /// The largest of the primaries of the sheen: how much it takes from below.
    pub most_sheen: f64,
    pub opacity: f64,
}

impl Look {
    /// Of the base.
    pub fn roughness(&self) -> f64 {
        self.alpha.sqrt()
    }

    /// Reflectance of the dielectric where light falls straight on, and where it grazes (KHR_materials_specular).
    pub fn dielectric(&self, colour: f64) -> [f64; 2] {
        [(self.straight * colour).min(1.0) * self.specular, self.specular]
    }

    /// Axes about the body's normal, where they are not those of the facets.
    pub(super) fn body_frame(&self) -> Option<Frame> {
        self.body_normal.map(Frame::about)
    }

    /// Facets of the base.
    pub(super) fn lobe(&self) -> Lobe {
        Lobe::new(self.alpha, self.stretch)
    }

    /// Whether a sheet that transmits does not bend what it lets through.
    pub fn is_clear(&self) -> bool {
        self.alpha <= energy::LEAST_ALPHA && self.stretch.is_none()
    }
}

/// What the reflectance of a metal lacks of Schlick's form, per unit of [`energy::edge`]: all of it where the edge is black.
pub fn lacks(straight: f64, edge: f64) -> f64 {
    // At 82°, cos = 1/7, where x(1 − x)⁶ is largest.
    const AT: f64 = 1.0 / 7.0;
    let there = schlick(straight, AT);
    there * (1.0 - edge) / energy::edge(AT)
}

/// Reflectance of a metal: C. Schlick, "An Inexpensive BRDF Model for Physically-based Rendering" (1994).
pub fn schlick(straight: f64, cos: f64) -> f64 {
    straight + (1.0 - straight) * (1.0 - cos).clamp(0.0, 1.0).powi(5)
}

/// Roughness as facets have it.
pub fn facets(roughness: f64) -> f64 {
    energy::alpha(roughness.clamp(0.0, 1.0))
}
