//! How a face's light spreads: the integrals that tie flux, intensity and luminance together.

use super::{Angular, Emitter, LuminousProfile, Photometry};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, LN_2, TAU};

/// An angular distribution in numbers. Intensities are in a unit of its own: 1 along the normal, cd for a profile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// ∫ I dω over the half space in front of the face.
    pub whole: f64,
    /// Along the normal.
    pub normal: f64,
    /// The greatest.
    pub peak: f64,
    /// Angle from the normal within which the intensity stays above half of the peak, rad; a mean over the planes of a
    /// profile, none for one of type A or B.
    pub half_angle_rad: Option<f64>,
}

impl Angular {
    /// The distribution in numbers; none for a profile that is not there.
    pub fn spread(&self, profiles: &[LuminousProfile]) -> Option<Spread> {
        let cos_n = |n: f64| Spread {
            // Formula sheet, section 5: I0 = Φ (n + 1)/(2π).
            whole: TAU / (n + 1.0),
            normal: 1.0,
            peak: 1.0,
            half_angle_rad: Some(if n > 0.0 { 0.5f64.powf(1.0 / n).acos() } else { FRAC_PI_2 }),
        };
        Some(match *self {
            Angular::Lambert => cos_n(1.0),
            Angular::CosN { n } => cos_n(n),
            Angular::Gauss { fwhm_deg } => {
                let half = (0.5 * fwhm_deg).to_radians();
                let beam = GaussBeam::new(fwhm_deg);
                Spread { whole: beam.whole(), normal: 1.0, peak: 1.0, half_angle_rad: Some(half.min(FRAC_PI_2)) }
            }
            Angular::Profile { profile, .. } => {
                let front = profiles.get(profile.index())?.front();
                Spread {
                    whole: front.flux_lm(),
                    normal: front.along(DVec3::NEG_Z),
                    peak: front.peak_cd(),
                    half_angle_rad: front.half_angle_rad(),
                }
            }
        })
    }
}

impl Emitter {
    /// What the distribution's own unit is worth for a face of `area_m2`, cd.
    pub fn unit_cd(&self, spread: &Spread, area_m2: f64) -> f64 {
        match self.photometry {
            Photometry::FluxLm(flux) => flux / spread.whole,
            Photometry::LuminanceCdM2(luminance) => luminance * area_m2 / spread.normal,
            Photometry::IntensityCd(intensity) => intensity / spread.normal,
            Photometry::AsMeasured => 1.0,
        }
    }
}

/// I(θ) = exp(−4 ln 2 (θ/fwhm)²) up to 90°, and its flux within each θ.
#[derive(Debug, Clone, PartialEq)]
pub struct GaussBeam {
    /// 4 ln 2/fwhm², 1/rad².
    steep: f64,
    /// Beyond this there is no light, rad.
    top: f64,
    /// ∫ I sin θ dθ up to each of [`GaussBeam::PANELS`] equal steps to `top`.
    within: Vec<f64>,
}

impl GaussBeam {
    const PANELS: usize = 256;

    /// `fwhm_deg` above 0.
    pub fn new(fwhm_deg: f64) -> Self {
        let fwhm = fwhm_deg.to_radians();
        let steep = 4.0 * LN_2 / (fwhm * fwhm);
        // Where the intensity is below 1e-18 of the peak.
        let top = (18.0 * std::f64::consts::LN_10 / steep).sqrt().min(FRAC_PI_2);
        let mut beam = GaussBeam { steep, top, within: vec![0.0] };
        let mut sum = 0.0;
        for panel in 0..Self::PANELS {
            sum += beam.between(beam.edge(panel), beam.edge(panel + 1));
            beam.within.push(sum);
        }
        beam
    }

    fn edge(&self, panel: usize) -> f64 {
        self.top * panel as f64 / Self::PANELS as f64
    }

    /// Relative to the peak.
    pub fn intensity(&self, theta: f64) -> f64 {
        if theta <= self.top { (-self.steep * theta * theta).exp() } else { 0.0 }
    }

    /// ∫ I dω.
    pub fn whole(&self) -> f64 {
        TAU * self.within.last().copied().unwrap_or(0.0)
    }

    /// ∫ I sin θ dθ within a panel, by the Gauss–Legendre rule of five points: 1e-15 of the whole.
    fn between(&self, from: f64, to: f64) -> f64 {
        const POINTS: [(f64, f64); 3] = [
            (0.0, 0.568_888_888_888_888_9),
            (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
            (0.906_179_845_938_664, 0.236_926_885_056_189_08),
        ];
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let at = |x: f64| {
            let theta = middle + half * x;
            (-self.steep * theta * theta).exp() * theta.sin()
        };
        let sum = POINTS.iter().map(|(x, w)| if *x == 0.0 { w * at(0.0) } else { w * (at(*x) + at(-x)) }).sum::<f64>();
        half * sum
    }

    /// The angle within which the share `u` of the flux lies: with uniform `u` a sample with density ∝ I.
    pub fn theta(&self, u: f64) -> f64 {
        let want = u.clamp(0.0, 1.0) * self.within.last().copied().unwrap_or(0.0);
        let panel = self.within.partition_point(|sum| *sum <= want).clamp(1, Self::PANELS) - 1;
        let (mut low, mut high) = (self.edge(panel), self.edge(panel + 1));
        let (from, target) = (low, want - self.within.get(panel).copied().unwrap_or(0.0));
        let mut theta = 0.5 * (low + high);
        for _ in 0..60 {
            let off = self.between(from, theta) - target;
            if off > 0.0 {
                high = theta;
            } else {
                low = theta;
            }
            let next = theta - off / (self.intensity(theta) * theta.sin());
            let next = if next > low && next < high { next } else { 0.5 * (low + high) };
            if (next - theta).abs() <= 1e-15 * high {
                return next;
            }
            theta = next;
        }
        theta
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Narrow beams: 2π·(1/2a)(1 − 1/(6a)·…); wide ones against a sum of a million steps by Simpson's rule.
    #[test]
    fn the_flux_of_a_gaussian_beam() {
        let narrow = GaussBeam::new(0.01);
        let s = 1.0 / narrow.steep;
        // ∫ e^(−t²/s)(t − t³/6) dt = s/2 − s²/12.
        assert!((narrow.whole() / (TAU * (s / 2.0 - s * s / 12.0)) - 1.0).abs() < 1e-13);
        for fwhm in [5.0, 30.0, 120.0, 179.0] {
            let beam = GaussBeam::new(fwhm);
            // Simpson's rule.
            let count = 1_000_000;
            let step = FRAC_PI_2 / f64::from(count);
            let at = |k: i32| (-beam.steep * (f64::from(k) * step).powi(2)).exp() * (f64::from(k) * step).sin();
            let weight = |k: i32| if k == 0 || k == count { 1.0 } else { f64::from(2 + 2 * (k % 2)) };
            let sum: f64 = (0..=count).map(|k| weight(k) * at(k) * step / 3.0).sum();
            assert!((beam.whole() / (TAU * sum) - 1.0).abs() < 1e-11, "{fwhm}: {}", beam.whole() / (TAU * sum));
            assert!((beam.intensity((fwhm / 2.0).to_radians()) - 0.5).abs() < 1e-12);
            // θ(u) is the inverse of the flux within θ.
            for u in [0.0, 1e-9, 0.1, 0.5, 0.9, 1.0 - 1e-12] {
                let theta = beam.theta(u);
                let panel = beam.within.len() - 1;
                let within: f64 =
                    (0..panel).map(|k| beam.between(beam.edge(k).min(theta), beam.edge(k + 1).min(theta))).sum();
                assert!((within * TAU / beam.whole() - u).abs() < 1e-14, "{fwhm} {u}");
            }
        }
    }
}
