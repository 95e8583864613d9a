//! A rough dielectric interface: microfacets with the distribution of Trowbridge and Reitz (GGX), each of which reflects
//! and refracts by Fresnel's equations.
//!
//! The distribution, its transmitted half and the half vectors are those of Walter et al., "Microfacet Models for
//! Refraction through Rough Surfaces", EGSR 2007; visible normals are sampled as by Heitz, JCGT 7(4), 2018, in the form of
//! Dupuy and Benyoub, "Sampling Visible GGX Normals with Spherical Caps", HPG 2023. Masking is Smith's with heights
//! correlated, 1/(1 + Λi + Λo) (Heitz, JCGT 3(2), 2014), for what goes through, too: the B(1 + Λi, 1 + Λo) of Heitz et al.,
//! "Multiple-Scattering Microfacet BSDFs with the Smith Model", SIGGRAPH 2016, masks nearly all that arrives grazing
//! at a rough face, which only a walk from facet to facet would bring back where it belongs.
//!
//! What one bounce loses comes back as in [`super::lost`], so that nothing is absorbed.

use super::lost::Lost;
use super::{Sampled, Sides};
use crate::fresnel::{fresnel, refract};
use eyebox_base::Complex;
use glam::DVec3;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// Roughness, and what it loses.
#[derive(Debug, Clone)]
pub struct Rough {
    facets: Facets,
    lost: Arc<Lost>,
}

impl PartialEq for Rough {
    fn eq(&self, other: &Self) -> bool {
        self.facets == other.facets && Arc::ptr_eq(&self.lost, &other.lost)
    }
}

impl Rough {
    /// With the tables that belong to this roughness.
    pub fn new(lost: Arc<Lost>) -> Self {
        Rough { facets: lost.facets(), lost }
    }

    /// Half width at half maximum of the reflected lobe where light falls straight on: twice the slope where D is half.
    pub(super) fn half_width_rad(&self) -> f64 {
        half_width_rad(self.facets.alpha)
    }

    pub(super) fn eval(&self, d_in: DVec3, d_out: DVec3, n: Sides<'_>) -> f64 {
        let split = self.lost.split(n);
        let share = self.lost.at(&split, false, -d_in.z);
        finite(self.facets.eval(-d_in, d_out, n) + self.lost.eval(&split, share, d_out.z))
    }

    pub(super) fn pdf(&self, d_in: DVec3, d_out: DVec3, n: Sides<'_>) -> f64 {
        let split = self.lost.split(n);
        let share = self.lost.at(&split, false, -d_in.z);
        finite((1.0 - share) * self.facets.pdf(-d_in, d_out, n) + share * self.lost.pdf(&split, d_out.z))
    }

    pub(super) fn sample(&self, d_in: DVec3, n: Sides<'_>, u: [f64; 3]) -> Option<Sampled> {
        let split = self.lost.split(n);
        let share = self.lost.at(&split, false, -d_in.z);
        let dir = if u[0] < share {
            self.lost.sample(&split, u[0] / share, [u[1], u[2]])?
        } else {
            self.facets.sample(-d_in, n, (u[0] - share) / (1.0 - share), [u[1], u[2]])?
        };
        let [value, pdf] = self.facets.value_and_pdf(-d_in, dir, n);
        let pdf = finite((1.0 - share) * pdf + share * self.lost.pdf(&split, dir.z));
        let value = finite(value + self.lost.eval(&split, share, dir.z));
        Some(Sampled { dir, weight: value * dir.z.abs() / pdf, pdf })
    }
}

/// Half width at half maximum of what facets of this roughness reflect where light falls straight on.
pub(super) fn half_width_rad(alpha: f64) -> f64 {
    2.0 * (alpha * (std::f64::consts::SQRT_2 - 1.0).sqrt()).atan()
}

/// Directions along the face have no value.
fn finite(value: f64) -> f64 {
    if value.is_finite() { value } else { 0.0 }
}

/// Microfacets of a roughness, with one bounce.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Facets {
    pub alpha: f64,
}

impl Facets {
    /// Smith's Λ of a direction (any side).
    pub fn lambda(self, w: DVec3) -> f64 {
        let slope = self.alpha * ((w.x * w.x + w.y * w.y) / (w.z * w.z)).sqrt();
        if slope < 1e100 { 0.5 * slope * slope / (1.0 + (1.0 + slope * slope).sqrt()) } else { 0.5 * slope }
    }

    /// D of a microfacet's normal.
    pub fn distribution(self, h: DVec3) -> f64 {
        let (square, z2) = (self.alpha * self.alpha, h.z * h.z);
        let steep = 1.0 + (h.x * h.x + h.y * h.y) / (z2 * square);
        1.0 / (PI * square * (z2 * steep) * (z2 * steep))
    }

    /// Share of the light that is masked at neither end, the heights of both being those of one facet.
    pub fn masking(lambda_in: f64, lambda_out: f64) -> f64 {
        1.0 / (1.0 + lambda_in + lambda_out)
    }

    /// Reflected share at a facet under the cosine `cos`.
    fn fresnel(n: Sides<'_>, cos: f64) -> f64 {
        fresnel(n.here, Complex::real(n.beyond), cos).reflectance()
    }

    /// The facet that sends `wi` to `wo` (both away from the face), and the length of the sum of both, each times its
    /// index.
    fn half(wi: DVec3, wo: DVec3, n: Sides<'_>) -> Option<(DVec3, f64)> {
        let sum = if wo.z > 0.0 { wi + wo } else { wi * n.here + wo * n.beyond };
        let length = sum.length();
        let h = if sum.z > 0.0 { sum / length } else { -sum / length };
        let faces = wi.dot(h) > 0.0 && (wo.dot(h) > 0.0) == (wo.z > 0.0);
        (length > 0.0 && h.z > 0.0 && faces).then_some((h, length))
    }

    pub fn eval(self, wi: DVec3, wo: DVec3, n: Sides<'_>) -> f64 {
        self.value_and_pdf(wi, wo, n)[0]
    }

    /// Density of [`Facets::sample`].
    pub fn pdf(self, wi: DVec3, wo: DVec3, n: Sides<'_>) -> f64 {
        self.value_and_pdf(wi, wo, n)[1]
    }

    /// Value without the cosine and density of [`Facets::sample`], 1/sr.
    #[inline]
    fn value_and_pdf(self, wi: DVec3, wo: DVec3, n: Sides<'_>) -> [f64; 2] {
        let Some((h, length)) = Self::half(wi, wo, n) else { return [0.0; 2] };
        let (ci, co) = (wi.dot(h), wo.dot(h).abs());
        let f = Self::fresnel(n, ci);
        let lambda_in = self.lambda(wi);
        // The share of the facets with this normal, seen from `wi`, and what one of them does.
        let share = self.distribution(h) / wi.z;
        let turns = if wo.z > 0.0 { 0.25 * f } else { (1.0 - f) * ci * co * (n.beyond / length) * (n.beyond / length) };
        let value = Self::masking(lambda_in, self.lambda(wo)) / wo.z.abs();
        [share * turns * value, share * turns / (1.0 + lambda_in)]
    }

    /// Of facets that reflect everything, on one side: the value without the cosine and the density of what they send from
    /// `wi` to `wo`, 1/sr, and the cosine at the facet; none where none does.
    pub fn mirrored(self, wi: DVec3, wo: DVec3) -> Option<[f64; 3]> {
        let (h, _) = Self::half(wi, wo, Sides::AIR).filter(|_| wo.z > 0.0)?;
        let lambda_in = self.lambda(wi);
        let share = 0.25 * self.distribution(h) / wi.z;
        let value = finite(share * Self::masking(lambda_in, self.lambda(wo)) / wo.z);
        Some([value, finite(share / (1.0 + lambda_in)), wi.dot(h)])
    }

    /// A normal that is visible from `wi`, by its density.
    pub fn visible_normal(self, wi: DVec3, [a, b]: [f64; 2]) -> DVec3 {
        let stretched = DVec3::new(self.alpha * wi.x, self.alpha * wi.y, wi.z).normalize();
        // A cap of the unit sphere, uniform in z from −wi.z to 1; its sum with wi is the half vector.
        let z = (1.0 - b) * (1.0 + stretched.z) - stretched.z;
        let sin = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
        let (sin_phi, cos_phi) = (TAU * a).sin_cos();
        let half =
            DVec3::new(sin * cos_phi + stretched.x, sin * sin_phi + stretched.y, (1.0 - b) * (1.0 + stretched.z));
        DVec3::new(self.alpha * half.x, self.alpha * half.y, half.z).normalize()
    }

    /// Where `wi` goes from a facet, if it leaves on the side it should; reflected for `u` below Fresnel's share.
    pub fn sample(self, wi: DVec3, n: Sides<'_>, u: f64, at: [f64; 2]) -> Option<DVec3> {
        let h = self.visible_normal(wi, at);
        let ci = wi.dot(h);
        if u < Self::fresnel(n, ci) {
            let wo = (h * (2.0 * ci) - wi).normalize();
            (wo.z > 0.0).then_some(wo)
        } else {
            refract(-wi, h, n.here / n.beyond).filter(|wo| wo.z < 0.0)
        }
    }

    /// Shares of what arrives from `wi` at one visible normal that leave for good, back and through.
    #[cfg(test)]
    pub fn bounce(self, wi: DVec3, n: Sides<'_>, at: [f64; 2]) -> [f64; 2] {
        let lambda_in = self.lambda(wi);
        let seen = |wo: DVec3| (1.0 + lambda_in) * Self::masking(lambda_in, self.lambda(wo));
        let h = self.visible_normal(wi, at);
        let f = Self::fresnel(n, wi.dot(h));
        let back = h * (2.0 * wi.dot(h)) - wi;
        let through = if f < 1.0 { refract(-wi, h, n.here / n.beyond).filter(|wo| wo.z < 0.0) } else { None };
        [if back.z > 0.0 { f * seen(back) } else { 0.0 }, through.map_or(0.0, |wo| (1.0 - f) * seen(wo))]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A facet's own direction: what is refracted at a normal has that normal as its half vector.
    #[test]
    fn half_vectors_are_the_facets() {
        let wi = DVec3::new(0.6, 0.0, 0.8);
        let h = DVec3::new(0.1, -0.2, 1.0).normalize();
        for n in [Sides::between(1.0, 1.5), Sides::between(1.5, 1.0)] {
            for wo in [h * (2.0 * wi.dot(h)) - wi, refract(-wi, h, n.here / n.beyond).unwrap()] {
                let (found, _) = Facets::half(wi, wo, n).unwrap();
                assert!((found - h).length() < 1e-14, "{found} {h}");
            }
        }
    }
}
