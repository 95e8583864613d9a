//! Lobes of facets: alike all round, or longer along a direction of the surface.

use super::super::rough::Facets;
use glam::DVec3;

/// Facets of two widths, in a frame turned about the normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stretch {
    /// The direction that they are longer along: cosine and sine in the local frame.
    pub turn: [f64; 2],
    /// α along it and across.
    pub alphas: [f64; 2],
    pub strength: f64,
}

/// Facets, and how they lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Lobe {
    facets: Facets,
    stretch: Option<Stretch>,
}

impl Stretch {
    /// A direction of the local frame in that of the facets.
    fn turned(&self, w: DVec3) -> DVec3 {
        let [cos, sin] = self.turn;
        DVec3::new(cos * w.x + sin * w.y, cos * w.y - sin * w.x, w.z)
    }

    fn back(&self, w: DVec3) -> DVec3 {
        let [cos, sin] = self.turn;
        DVec3::new(cos * w.x - sin * w.y, cos * w.y + sin * w.x, w.z)
    }

    /// Square of the sine of the angle between a direction's projection and that of the facets.
    pub fn across(&self, w: DVec3) -> f64 {
        let w = self.turned(w);
        let flat = w.x * w.x + w.y * w.y;
        if flat > 0.0 { w.y * w.y / flat } else { 0.0 }
    }

    /// What turns these facets into ones alike all round, of α across.
    fn by(&self) -> DVec3 {
        DVec3::new(self.alphas[0] / self.alphas[1], 1.0, 1.0)
    }
}

impl Lobe {
    pub fn new(alpha: f64, stretch: Option<Stretch>) -> Self {
        Lobe { facets: Facets { alpha: stretch.map_or(alpha, |stretch| stretch.alphas[1]) }, stretch }
    }

    /// Value without the cosine and density of what perfect facets send from `wi` to `wo` (both away from the face), 1/sr,
    /// and the cosine at the facet; none where none does.
    pub fn mirrored(&self, wi: DVec3, wo: DVec3) -> Option<[f64; 3]> {
        let Some(stretch) = &self.stretch else { return self.facets.mirrored(wi, wo) };
        let h = (wi + wo).try_normalize().filter(|h| h.z > 0.0 && wi.dot(*h) > 0.0 && wo.z > 0.0)?;
        let by = stretch.by();
        let lambda = |w: DVec3| self.facets.lambda(stretch.turned(w) * by);
        let lambda_in = lambda(wi);
        // The area of a patch of facets grows as it is stretched, and D with its inverse.
        let share = 0.25 * self.facets.distribution(stretch.turned(h) / by) / (by.x * wi.z);
        let value = share * Facets::masking(lambda_in, lambda(wo)) / wo.z;
        let pdf = share / (1.0 + lambda_in);
        (value.is_finite() && pdf.is_finite()).then_some([value, pdf, wi.dot(h)])
    }

    /// A normal that is visible from `wi`, by its density.
    pub fn visible_normal(&self, wi: DVec3, at: [f64; 2]) -> DVec3 {
        let Some(stretch) = &self.stretch else { return self.facets.visible_normal(wi, at) };
        let by = stretch.by();
        stretch.back((self.facets.visible_normal(stretch.turned(wi) * by, at) * by).normalize())
    }

    /// Where `wi` goes from a visible facet, if it leaves.
    pub fn sample(&self, wi: DVec3, at: [f64; 2]) -> Option<DVec3> {
        let h = self.visible_normal(wi, at);
        let wo = (h * (2.0 * wi.dot(h)) - wi).normalize();
        (wo.z > 0.0).then_some(wo)
    }

    /// Share of what a visible facet sends from `wi` to `wo` that leaves for good.
    pub fn leaves(&self, wi: DVec3, wo: DVec3) -> f64 {
        let lambda = |w: DVec3| match &self.stretch {
            Some(stretch) => self.facets.lambda(stretch.turned(w) * stretch.by()),
            None => self.facets.lambda(w),
        };
        let lambda_in = lambda(wi);
        (1.0 + lambda_in) * Facets::masking(lambda_in, lambda(wo))
    }
}
