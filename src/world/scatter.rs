//! Faces that scatter: the bidirectional distribution of Lambertian and Gaussian finishes, and its sampling.
//!
//! Local frame: z is the face's normal on the side where the traced ray arrives. `d_in` is the propagation direction of
//! the arriving ray (z < 0), `d_out` that of the leaving one (z > 0 reflected, z < 0 transmitted). Both distributions
//! are reciprocal, so they are the same whether light or importance travels.

use super::gauss::GaussLobe;
use crate::base::path::Event;
use crate::base::warp;
use crate::scene::Finish;
use glam::DVec3;
use std::f64::consts::PI;

/// A face that scatters light out of the specular directions.
#[derive(Debug, Clone, PartialEq)]
pub enum Scatter {
    /// The same luminance in every direction of each side.
    Lambert { reflectance: f64, transmittance: f64 },
    /// `share · C exp(−t²/2σ²)/max(cos_i, cos_o)`: t is the angle to the mirrored direction for reflection, to the
    /// straight one for transmission. With the larger cosine below, no direction of incidence gains energy.
    Gauss { lobe: GaussLobe, reflectance: f64, transmittance: f64 },
}

/// A sampled direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampled {
    /// Unit propagation direction in the local frame.
    pub dir: DVec3,
    /// BSDF · |cos| / pdf.
    pub weight: f64,
    /// Density of `dir`, 1/sr.
    pub pdf: f64,
}

impl Scatter {
    /// None if the finish does not scatter, or if its numbers are outside their ranges (which `check` reports).
    pub fn from_finish(finish: &Finish) -> Option<Scatter> {
        let share = |x: f64| (0.0..=1.0).contains(&x);
        match *finish {
            Finish::Lambert { reflectance, transmittance } => {
                (share(reflectance) && share(transmittance)).then_some(Scatter::Lambert { reflectance, transmittance })
            }
            Finish::Gauss { sigma_deg, reflectance, transmittance } => {
                let lobe = GaussLobe::new(sigma_deg.to_radians())?;
                (share(reflectance) && share(transmittance)).then_some(Scatter::Gauss {
                    lobe,
                    reflectance,
                    transmittance,
                })
            }
            Finish::None
            | Finish::Polished
            | Finish::MirrorMetal { .. }
            | Finish::MirrorIdeal { .. }
            | Finish::Polariser { .. }
            | Finish::Retarder { .. }
            | Finish::Absorber => None,
        }
    }

    /// A lobe too narrow to gather photons at.
    pub fn is_narrow(&self) -> bool {
        match self {
            Scatter::Lambert { .. } => false,
            Scatter::Gauss { lobe, .. } => lobe.sigma_rad() < Finish::NARROW_SIGMA_DEG.to_radians(),
        }
    }

    /// What scattering here is in a path's event string.
    pub fn event(&self) -> Event {
        if self.is_narrow() { Event::Glossy } else { Event::Diffuse }
    }

    fn shares(&self) -> [f64; 2] {
        match *self {
            Scatter::Lambert { reflectance, transmittance } | Scatter::Gauss { reflectance, transmittance, .. } => {
                [reflectance, transmittance]
            }
        }
    }

    /// The share of the side that `d_out` leaves on and the lobe's axis there; none for directions that are not
    /// arriving or run in the face.
    fn side(&self, d_in: DVec3, d_out: DVec3) -> Option<(f64, DVec3)> {
        if d_in.z.is_nan() || d_in.z >= 0.0 {
            return None;
        }
        let [reflectance, transmittance] = self.shares();
        if d_out.z > 0.0 {
            Some((reflectance, mirrored(d_in)))
        } else if d_out.z < 0.0 {
            Some((transmittance, d_in))
        } else {
            None
        }
    }

    /// Bidirectional scattering distribution, 1/sr, without a cosine. Unit directions.
    pub fn eval(&self, d_in: DVec3, d_out: DVec3) -> f64 {
        let Some((share, axis)) = self.side(d_in, d_out) else { return 0.0 };
        match self {
            Scatter::Lambert { .. } => share / PI,
            Scatter::Gauss { lobe, .. } => share * lobe.value(axis, d_out) / (-d_in.z).max(d_out.z.abs()),
        }
    }

    /// Density with which [`Scatter::sample`] returns `d_out`, 1/sr. Its integral is less than 1 by the share of
    /// samples that land in the wrong half space.
    pub fn pdf(&self, d_in: DVec3, d_out: DVec3) -> f64 {
        let Some((share, axis)) = self.side(d_in, d_out) else { return 0.0 };
        let total: f64 = self.shares().iter().sum();
        if total <= 0.0 {
            return 0.0;
        }
        match self {
            Scatter::Lambert { .. } => share / total * d_out.z.abs() / PI,
            Scatter::Gauss { lobe, .. } => share / total * lobe.pdf(axis, d_out),
        }
    }

    /// Samples a direction; `u[0]` chooses the side, the others the direction. None is a sample of weight 0: absorbed,
    /// or in the wrong half space.
    pub fn sample(&self, d_in: DVec3, u: [f64; 3]) -> Option<Sampled> {
        let [reflectance, transmittance] = self.shares();
        let total = reflectance + transmittance;
        if !(d_in.z < 0.0 && total > 0.0) {
            return None;
        }
        let reflects = u[0] * total < reflectance;
        let (dir, weight) = match self {
            Scatter::Lambert { .. } => {
                let up = warp::cosine_hemisphere([u[1], u[2]]);
                (if reflects { up } else { -up }, total)
            }
            Scatter::Gauss { lobe, .. } => {
                let axis = if reflects { mirrored(d_in) } else { d_in };
                let (dir, ratio) = lobe.sample(axis, [u[1], u[2]]);
                (dir, total * ratio * dir.z.abs() / (-d_in.z).max(dir.z.abs()))
            }
        };
        let right_side = if reflects { dir.z > 0.0 } else { dir.z < 0.0 };
        let pdf = self.pdf(d_in, dir);
        (right_side && pdf > 0.0).then_some(Sampled { dir, weight, pdf })
    }

    /// Shares of the arriving light that are reflected and transmitted at incidence `cos_in` in (0, 1]; Gaussian lobes
    /// by a table good to 5e-5.
    pub fn albedo(&self, cos_in: f64) -> [f64; 2] {
        match self {
            Scatter::Lambert { .. } => self.shares(),
            // The transmitted lobe is the mirror image of the reflected one: the same share of both leaves.
            Scatter::Gauss { lobe, .. } => self.shares().map(|share| share * lobe.albedo(cos_in)),
        }
    }
}

fn mirrored(d: DVec3) -> DVec3 {
    DVec3::new(d.x, d.y, -d.z)
}

#[cfg(test)]
#[path = "scatter_tests.rs"]
mod tests;
