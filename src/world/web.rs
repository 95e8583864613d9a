//! Directions from a measured intensity distribution, with density exactly ∝ the bilinear intensity.

use eyebox_scene::LuminousProfile;
use eyebox_scene::profile::band;
use glam::DVec3;

/// A profile with the sums that sampling needs. The marginal over γ has the density (∫ I dC) sin γ, where ∫ I dC is
/// linear between rings; given γ, the density over C is I, piecewise linear, whose running integrals are those of the two
/// rings mixed. Both are inverted, so there are no weights.
#[derive(Debug, Clone)]
pub struct Web {
    profile: LuminousProfile,
    /// ∫ I dC of each ring.
    rings: Vec<f64>,
    /// Flux up to each ring, lm.
    flux: Vec<f64>,
    /// For each ring: ∫ I dC up to each plane.
    around: Vec<Vec<f64>>,
}

impl Web {
    /// None without light, or beyond the range of numbers.
    pub fn new(profile: LuminousProfile) -> Option<Web> {
        let rings = profile.rings_cd();
        let mut flux = vec![0.0];
        let mut sum = 0.0;
        for (g, r) in profile.gamma_rad.windows(2).zip(rings.windows(2)) {
            let ([g0, g1], [r0, r1]) = (g, r) else { continue };
            sum += band(*g0, *g1, *r0, *r1);
            flux.push(sum);
        }
        let around = (0..profile.rings())
            .map(|ring| {
                let value = |plane: usize| profile.candela.get(plane * profile.rings() + ring).copied().unwrap_or(0.0);
                let mut sum = 0.0;
                let mut sums = vec![0.0];
                for (plane, c) in profile.c_rad.windows(2).enumerate() {
                    let [from, to] = c else { continue };
                    sum += 0.5 * (to - from) * (value(plane) + value(plane + 1));
                    sums.push(sum);
                }
                sums
            })
            .collect();
        (sum > 0.0 && sum.is_finite()).then_some(Web { profile, rings, flux, around })
    }

    /// lm.
    pub fn flux_lm(&self) -> f64 {
        self.flux.last().copied().unwrap_or(0.0)
    }

    /// cd along a unit direction of the photometric frame.
    pub fn intensity(&self, dir: DVec3) -> f64 {
        self.profile.along(dir)
    }

    /// A unit direction of the photometric frame with density [`Web::intensity`]/[`Web::flux_lm`].
    pub fn sample(&self, [u, v]: [f64; 2]) -> DVec3 {
        let want = u * self.flux_lm();
        let bands = self.flux.len().saturating_sub(2);
        let ring = (self.flux.partition_point(|sum| *sum <= want).max(1) - 1).min(bands);
        let at = |list: &[f64], index: usize| list.get(index).copied().unwrap_or(0.0);
        let (g0, g1) = (at(&self.profile.gamma_rad, ring), at(&self.profile.gamma_rad, ring + 1));
        let (r0, r1) = (at(&self.rings, ring), at(&self.rings, ring + 1));
        let gamma = polar([g0, g1], [r0, r1], want - at(&self.flux, ring));
        let t = ((gamma - g0) / (g1 - g0)).clamp(0.0, 1.0);
        self.profile.direction(self.azimuth(ring, t, v), gamma)
    }

    /// C at the share `v` of ∫ I dC between two rings.
    fn azimuth(&self, ring: usize, t: f64, v: f64) -> f64 {
        let empty = Vec::new();
        let (low, high) = (self.around.get(ring).unwrap_or(&empty), self.around.get(ring + 1).unwrap_or(&empty));
        let sum = |plane: usize| {
            let at = |list: &[f64]| list.get(plane).copied().unwrap_or(0.0);
            at(low) * (1.0 - t) + at(high) * t
        };
        let planes = self.profile.c_rad.len();
        let want = v * sum(planes - 1);
        // The last plane with no more than `want` before it.
        let (mut from, mut to) = (0, planes - 1);
        while to - from > 1 {
            let middle = (from + to) / 2;
            if sum(middle) <= want { from = middle } else { to = middle }
        }
        let c = |plane: usize| self.profile.c_rad.get(plane).copied().unwrap_or(0.0);
        let value = |plane: usize| {
            let at =
                |ring: usize| self.profile.candela.get(plane * self.profile.rings() + ring).copied().unwrap_or(0.0);
            at(ring) * (1.0 - t) + at(ring + 1) * t
        };
        let (a, b, width) = (value(from), value(to), c(to) - c(from));
        let part = (want - sum(from)) / width;
        // ∫ (a + (b − a) x) dx = part: x = 2 part/(a + √(a² + 2 (b − a) part)).
        let root = (a * a + 2.0 * (b - a) * part).max(0.0).sqrt();
        let x = if a + root > 0.0 { 2.0 * part / (a + root) } else { 0.5 };
        c(from) + width * x.clamp(0.0, 1.0)
    }
}

/// γ up to which the band holds `want` lm: Newton's method inside a bracket.
fn polar([g0, g1]: [f64; 2], [r0, r1]: [f64; 2], want: f64) -> f64 {
    let slope = (r1 - r0) / (g1 - g0);
    let (mut low, mut high) = (g0, g1);
    let mut gamma = 0.5 * (g0 + g1);
    for _ in 0..60 {
        let ring = r0 + slope * (gamma - g0);
        let off = band(g0, gamma, r0, ring) - want;
        if off > 0.0 {
            high = gamma;
        } else {
            low = gamma;
        }
        let next = gamma - off / (ring * gamma.sin());
        let next = if next > low && next < high { next } else { 0.5 * (low + high) };
        if (next - gamma).abs() <= 4.0 * f64::EPSILON * g1 {
            return next;
        }
        gamma = next;
    }
    gamma
}

#[cfg(test)]
#[path = "web_tests.rs"]
mod tests;
