//! A rough diffuse body under layers.
//!
//! The facets of the body scatter once by the law of Fujii as Portsmouth, Kutz and Hill have it ("EON: A Practical
//! Energy-Preserving Rough Diffuse BRDF", JCGT 14(1), 2025): f = ρ/π·(A + B·s/t). What light gets in under T(i) and out
//! under T(o), T being what the layers above leave. What neither leaves at once nor is absorbed, for facets face each other and
//! the layers reflect it back, leaves by the lobe of Kulla and Conty: (T − S)(i)·(T − S)(o)/(π·(T̄ − S̄)), S = what of light from a
//! direction has left after one bounce. Without layers this is EON; without roughness, ρ T(i) T(o)/(π T̄). It is reciprocal,
//! and nothing is lost of a white body.

use super::Principled;
use super::layers::POINTS;
use super::look::{Look, Tint};
use glam::DVec3;
use std::f64::consts::PI;

/// The law's constants for a roughness of 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Fujii {
    a: f64,
    b: f64,
}

impl Fujii {
    fn new(roughness: f64) -> Self {
        let a = 1.0 / (1.0 + (0.5 - 2.0 / (3.0 * PI)) * roughness);
        Fujii { a, b: roughness * a }
    }

    /// π f of a white body.
    fn value(self, wi: DVec3, wo: DVec3) -> f64 {
        let s = wi.x * wo.x + wi.y * wo.y;
        let t = if s > 0.0 { wi.z.abs().max(wo.z.abs()) } else { 1.0 };
        self.a + self.b * s / t
    }

    /// What of light under a cosine leaves after one bounce.
    fn albedo(self, cos: f64) -> f64 {
        let cos = cos.clamp(0.0, 1.0);
        let sin = (1.0 - cos * cos).sqrt();
        // tan · (1 − sin³), without the differences that cancel where light grazes.
        let far = sin * cos * (1.0 + sin + sin * sin) / (1.0 + sin);
        let g = sin * (cos.acos() - sin * cos) + 2.0 / 3.0 * (far - sin);
        self.a + self.b * g / PI
    }

    /// The same of light from all sides.
    fn mean_albedo(self) -> f64 {
        self.a + self.b * (2.0 / 3.0 - 28.0 / (15.0 * PI))
    }
}

/// A rough body under the layers of a look: their openings at the points of the quadrature, and the means.
pub(super) struct Body {
    law: Fujii,
    /// What gets through the layers, from all sides; its mean.
    open: [f64; POINTS.len()],
    mean_open: f64,
    /// Mean of what has left after one bounce.
    mean_once: f64,
}

impl Body {
    /// Of `look`, whose layers leave `mean_open` of light from all sides.
    pub fn new(principled: &Principled, look: &Look, mean_open: f64) -> Self {
        let open = POINTS.map(|[cos, _]| principled.ring(cos, look));
        let mut body = Body { law: Fujii::new(look.diffuse_roughness), open, mean_open, mean_once: 0.0 };
        let once = |k: usize| body.open[k] * body.leaves(POINTS[k][0]);
        body.mean_once = (0..POINTS.len()).map(|k| 2.0 * POINTS[k][0] * POINTS[k][1] * once(k)).sum();
        body
    }

    /// Of light under a cosine that has got in, what gets out again after one bounce: ∫ f T(o) cos o dω.
    fn leaves(&self, cos: f64) -> f64 {
        // All round, ∫ s/t dφ is 2 sin sin' (1/max(cos, cos') − 1). The integral with the mean of T is known; that of its
        // departures is small and smooth.
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let departs: f64 = POINTS
            .iter()
            .zip(self.open)
            .map(|([other, weight], open)| {
                let both = sin * (1.0 - other * other).sqrt();
                weight * other * (open - self.mean_open) * 2.0 * both * (1.0 / cos.max(*other) - 1.0)
            })
            .sum();
        self.mean_open * self.law.albedo(cos) + self.law.b / PI * departs
    }

    /// What stays in of light under a cosine of which `open` has got in.
    fn stays(&self, cos: f64, open: f64) -> f64 {
        (open * (1.0 - self.leaves(cos))).max(0.0)
    }

    /// Albedo of what has stayed in and leaves all the same, for a base of this colour: EON's of what facets send to each
    /// other, the body's own of what the layers send back.
    fn again(&self, base: f64) -> f64 {
        let lost = 1.0 - self.law.mean_albedo();
        let stays = self.mean_open - self.mean_once;
        let facets = if stays > 0.0 { (self.mean_open * lost / stays).clamp(0.0, 1.0) } else { 0.0 };
        let between = base * (1.0 - lost) / (1.0 - base * lost);
        base * (1.0 - facets + facets * between)
    }

    /// Distribution between two directions on the same side, under which the layers leave `open`, 1/sr.
    pub fn value(&self, [wi, wo]: [DVec3; 2], open: [f64; 2], tint: Tint) -> f64 {
        let once = tint.base * open[0] * open[1] * self.law.value(wi, wo);
        let rest = self.mean_open - self.mean_once;
        let stays = self.stays(wi.z.abs(), open[0]) * self.stays(wo.z.abs(), open[1]);
        let again = if rest > 0.0 { self.again(tint.base) * stays / rest } else { 0.0 };
        (once + again) / PI
    }

    /// Share of light from a direction that has got in under `open` and leaves again.
    pub fn albedo(&self, cos: f64, tint: Tint) -> f64 {
        let once = self.leaves(cos);
        tint.base * once + self.again(tint.base) * (1.0 - once).max(0.0)
    }
}
