//! How the light of a face spreads about its normal: intensity in a unit of the distribution's own, and directions with
//! density ∝ intensity.

use super::web::Web;
use eyebox_base::warp::{self, Frame};
use eyebox_scene::LuminousProfile;
use eyebox_scene::angular::GaussBeam;
use glam::{DMat3, DVec3};
use std::f64::consts::{PI, TAU};

/// An angular distribution.
#[derive(Debug, Clone)]
pub enum Beam {
    /// I = cosⁿ θ.
    CosN(f64),
    /// I = exp(−4 ln 2 (θ/fwhm)²).
    Gauss(Box<GaussBeam>),
    /// Measured, cd; `c0`: direction of the plane C0 in the world, to be projected onto the face.
    Profile { web: Box<Web>, c0: DVec3 },
}

impl Beam {
    /// A face's part of a profile: what lies in front of it. None if that is dark.
    pub fn of_profile(profile: &LuminousProfile, c0: DVec3) -> Option<Beam> {
        Some(Beam::Profile { web: Box::new(Web::new(profile.front())?), c0 })
    }

    /// ∫ I dω.
    pub fn whole(&self) -> f64 {
        match self {
            Beam::CosN(n) => TAU / (n + 1.0),
            Beam::Gauss(beam) => beam.whole(),
            Beam::Profile { web, .. } => web.flux_lm(),
        }
    }

    /// Intensity along the unit direction `dir` from a face with this normal; `cos` is their product, above 0.
    pub fn intensity(&self, normal: DVec3, dir: DVec3, cos: f64) -> f64 {
        match self {
            Beam::CosN(n) => cos.powf(*n),
            Beam::Gauss(beam) => beam.intensity(angle(normal, dir)),
            Beam::Profile { web, c0 } => web.intensity(photometric(normal, *c0).transpose() * dir),
        }
    }

    /// A unit direction with density ∝ intensity.
    pub fn sample(&self, normal: DVec3, uv: [f64; 2]) -> DVec3 {
        match self {
            Beam::CosN(n) => {
                let local = if *n == 1.0 { warp::cosine_hemisphere(uv) } else { warp::cos_n_hemisphere(uv, *n) };
                Frame::about(normal).to_world(local)
            }
            Beam::Gauss(beam) => {
                let (sin, cos) = beam.theta(uv[0]).sin_cos();
                let (y, x) = (2.0 * PI * uv[1]).sin_cos();
                Frame::about(normal).to_world(DVec3::new(sin * x, sin * y, cos))
            }
            Beam::Profile { web, c0 } => photometric(normal, *c0) * web.sample(uv),
        }
    }
}

/// The angle between unit vectors, exact for small ones too.
fn angle(a: DVec3, b: DVec3) -> f64 {
    2.0 * (a - b).length().atan2((a + b).length())
}

/// Photometric frame → world of a face: it shines along its normal, +x is C0 along the face. Where C0 is along the normal
/// any direction of the face will do.
pub fn photometric(normal: DVec3, c0: DVec3) -> DMat3 {
    let x = (c0 - normal * normal.dot(c0)).try_normalize().unwrap_or_else(|| Frame::about(normal).x);
    DMat3::from_cols(x, x.cross(normal), -normal)
}
