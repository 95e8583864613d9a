//! What the facets of a surface do to polarisation: a dielectric's and the coat's as Fresnel's equations part s from p, a
//! metal's as one of this reflectance does. The body, fibres, what facets send on to each other and what rough sheets let
//! through depolarise, and so do facets under a film, whose colour says nothing of phases.

use super::look::Look;
use super::{Principled, coat_facets};
use crate::fresnel::fresnel_turning;
use crate::stokes::Facets;
use eyebox_base::Complex;
use glam::DVec3;

impl Principled {
    /// Whether any do, anywhere.
    pub fn has_facets(&self) -> bool {
        let surface = &self.surface;
        [&surface.specular, &surface.metallic, &surface.coat].into_iter().any(|weight| weight.factor > 0.0)
    }

    /// Between two directions, 1/sr, without the cosine.
    pub fn polarises(&self, d_in: DVec3, d_out: DVec3, look: &Look) -> Facets {
        let mut facets = Facets::NONE;
        if d_out.z <= 0.0 {
            return facets;
        }
        let wi = -d_in;
        let layers = self.layers(wi, d_out, look);
        if let Some([value, _, cos]) = look.lobe().mirrored(wi, d_out)
            && look.film.is_none()
        {
            let ior = self.base.ior();
            if ior.is_finite() {
                let plain = (1.0 - look.metallic) * self.dielectric_reflects(cos, look);
                facets.add(layers.under * value * plain, &fresnel_turning(1.0, Complex::real(ior), cos));
            }
            if look.metallic > 0.0 {
                let metal = look.metallic * self.metal_reflects(cos, look, look.tint);
                facets.add(layers.under * value * metal, &fresnel_turning(1.0, metal_index(look.tint.base), cos));
            }
        }
        if look.coat > 0.0
            && let Some(([value, _, cos], common)) = coat_facets(wi, d_out, look)
        {
            let coat = layers.under_sheen * look.coat * self.coat_facet(cos) * value * common;
            facets.add(coat, &fresnel_turning(1.0, Complex::real(self.coat.ior()), cos));
        }
        facets
    }
}

/// Index of a metal of which only the reflectance at normal incidence is known: n = 1, and the k that makes it so, which is
/// about that of aluminium for 0.9 and of iron for 0.6 (n = 1 and 2.9).
fn metal_index(straight: f64) -> Complex {
    // ((n − 1)² + k²)/((n + 1)² + k²) is k²/(4 + k²) of n = 1. Of a perfect mirror, one that is as good as perfect.
    const PERFECT: f64 = 1.0 - 1e-9;
    let straight = straight.clamp(0.0, PERFECT);
    Complex::new(1.0, 2.0 * (straight / (1.0 - straight)).sqrt())
}
