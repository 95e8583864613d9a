//! ABg scatter about a specular reflection: [`AbgLaw`] with its sampling.

use super::Sampled;
use crate::cdf::Cdf;
use eyebox_scene::AbgLaw;
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// The law, and the share that stays in the specular ray.
#[derive(Debug, Clone, PartialEq)]
pub struct Abg {
    law: AbgLaw,
    specular: f64,
    /// Radii about the specular direction on the face, and how much of the law lies in each ring; within a ring samples
    /// are even.
    radii: Vec<f64>,
    rings: Option<Cdf>,
    /// Scattered share at even steps of the fourth root of the cosine of incidence.
    albedo: Vec<f64>,
}

impl Abg {
    /// None unless A ≥ 0, B > 0, g ≥ 0 are finite and the specular share is one.
    pub fn new(abg: [f64; 3], specular: f64) -> Option<Self> {
        const COSINES: usize = 64;
        let law = AbgLaw::new(abg).filter(|_| (0.0..=1.0).contains(&specular))?;
        let radii = law.radii();
        let weights = radii.windows(2).map(|r| 0.5 * (law.value(r[0]) + law.value(r[1])) * area(r));
        let rings = Cdf::new(weights.collect::<Vec<_>>());
        // Dense at grazing light, where the horizon cuts the lobe.
        let cosine = |k: usize| (k as f64 / COSINES as f64).powi(4);
        let albedo = (0..=COSINES).map(|k| law.total(((1.0 - cosine(k)) * (1.0 + cosine(k))).sqrt())).collect();
        Some(Abg { law, specular, radii, rings, albedo })
    }

    pub(super) fn specular(&self) -> f64 {
        self.specular
    }

    /// Where the law is half of its peak, in sines.
    pub(super) fn half_width(&self) -> f64 {
        self.law.knee()
    }

    pub(super) fn eval(&self, d_in: DVec3, d_out: DVec3) -> f64 {
        if d_out.z > 0.0 { self.law.value(distance(d_in, d_out)) } else { 0.0 }
    }

    pub(super) fn pdf(&self, d_in: DVec3, d_out: DVec3) -> f64 {
        let Some(rings) = self.rings.as_ref().filter(|_| d_out.z > 0.0) else { return 0.0 };
        let ring = self.radii.partition_point(|r| *r <= distance(d_in, d_out)).saturating_sub(1);
        match self.radii.get(ring..ring + 2) {
            Some(edges) => rings.probability(ring) / area(edges) * d_out.z,
            None => 0.0,
        }
    }

    pub(super) fn sample(&self, d_in: DVec3, [a, b]: [f64; 2]) -> Option<Sampled> {
        let (ring, rest) = self.rings.as_ref()?.sample(a);
        let edges = self.radii.get(ring..ring + 2)?;
        let r = (edges[0] * edges[0] + rest * (edges[1] * edges[1] - edges[0] * edges[0])).sqrt();
        let (sin, cos) = (TAU * b).sin_cos();
        let beta = DVec2::new(d_in.x + r * cos, d_in.y + r * sin);
        let square = 1.0 - beta.length_squared();
        let dir = DVec3::new(beta.x, beta.y, square.max(0.0).sqrt());
        let pdf = self.pdf(d_in, dir);
        (square > 0.0 && pdf > 0.0).then(|| Sampled { dir, weight: self.eval(d_in, dir) * dir.z / pdf, pdf })
    }

    pub(super) fn albedo(&self, cos_in: f64) -> f64 {
        let place = cos_in.clamp(0.0, 1.0).powf(0.25) * (self.albedo.len() - 1) as f64;
        let below = (place as usize).min(self.albedo.len() - 2);
        self.albedo[below] + (place - below as f64) * (self.albedo[below + 1] - self.albedo[below])
    }
}

fn area(edges: &[f64]) -> f64 {
    PI * (edges[1] - edges[0]) * (edges[1] + edges[0])
}

/// Of the projected directions: the specular one has the projection of the arriving ray.
fn distance(d_in: DVec3, d_out: DVec3) -> f64 {
    DVec2::new(d_out.x - d_in.x, d_out.y - d_in.y).length()
}
