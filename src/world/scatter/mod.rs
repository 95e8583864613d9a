//! Faces that scatter: the bidirectional distribution of each finish, and its sampling.
//!
//! Local frame: z is the face's normal on the side where the traced ray arrives. `d_in` is the propagation direction of
//! the arriving ray (z < 0), `d_out` that of the leaving one (z > 0 reflected, z < 0 transmitted).
//!
//! Values are shares of flux: ∫ value · |cos| dω is what leaves of what arrives, whichever way light runs. Paths from the
//! eye carry radiance over index squared, which a face hands on by the same shares: with f the distribution for
//! radiance from side 2 to side 1, reciprocity f(2→1)/n₁² = f(1→2)/n₂² makes (n₂/n₁)² f(2→1) the value here.

mod abg;
mod albedo;
mod gauss;
mod lambert;
mod lost;
mod measured;
mod principled;
mod rough;
#[cfg(any(test, feature = "testing"))]
pub use principled::trials;

pub use abg::Abg;
pub use lost::Lost;
pub use measured::Measured;
pub use principled::{Look, Point, Principled};
pub use rough::Rough;

use super::gauss::GaussLobe;
use eyebox_base::path::Event;
use eyebox_scene::Finish;
use glam::DVec3;
use std::sync::Arc;

/// A face that scatters light out of the specular directions.
#[derive(Debug, Clone, PartialEq)]
pub enum Scatter {
    /// The same luminance in every direction of each side.
    Lambert(Shares),
    /// Gaussian about the specular directions.
    Gauss(GaussLobe, Shares),
    /// Microfacets between two media.
    Rough(Rough),
    /// Polish that is not perfect, besides what it reflects specularly.
    Abg(Abg),
    /// Read from a table.
    Measured(Arc<Measured>),
    /// An ordinary material; the same in both directions of light, and from both sides.
    Principled(Box<Principled>),
}

/// Shares that are reflected and transmitted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shares {
    pub reflectance: f64,
    pub transmittance: f64,
}

impl Shares {
    fn total(self) -> f64 {
        self.reflectance + self.transmittance
    }
    fn side(self, d_out: DVec3) -> f64 {
        if d_out.z > 0.0 { self.reflectance } else { self.transmittance }
    }
    /// Whether the random number `u` chooses reflection.
    fn reflects(self, u: f64) -> bool {
        u * self.total() < self.reflectance
    }
}

/// What values depend on at a place: refractive indices on the side where the ray arrives and behind the face, and what an
/// ordinary material is there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sides<'a> {
    pub here: f64,
    pub beyond: f64,
    pub look: Option<&'a Look>,
}

impl Sides<'_> {
    pub const AIR: Sides<'static> = Sides { here: 1.0, beyond: 1.0, look: None };

    /// Between these indices.
    pub const fn between(here: f64, beyond: f64) -> Sides<'static> {
        Sides { here, beyond, look: None }
    }

    /// Seen from behind.
    #[must_use]
    pub fn swapped(self) -> Self {
        Sides { here: self.beyond, beyond: self.here, ..self }
    }
}

/// A sampled direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampled {
    /// Unit propagation direction in the local frame.
    pub dir: DVec3,
    /// Value · |cos| / pdf.
    pub weight: f64,
    /// Density of `dir`, 1/sr.
    pub pdf: f64,
}

impl Scatter {
    /// None if the finish does not scatter, if it takes tables (rough, measured, an ordinary material), or if its numbers are outside their
    /// ranges (which `check` reports).
    pub fn from_finish(finish: &Finish) -> Option<Scatter> {
        let shares = |reflectance: f64, transmittance: f64| {
            let share = |x: f64| (0.0..=1.0).contains(&x);
            (share(reflectance) && share(transmittance)).then_some(Shares { reflectance, transmittance })
        };
        match *finish {
            Finish::Lambert { reflectance, transmittance } => {
                Some(Scatter::Lambert(shares(reflectance, transmittance)?))
            }
            Finish::Gauss { sigma_deg, reflectance, transmittance } => {
                let lobe = GaussLobe::new(sigma_deg.to_radians())?;
                Some(Scatter::Gauss(lobe, shares(reflectance, transmittance)?))
            }
            Finish::CosM { m, reflectance, transmittance } => {
                let lobe = GaussLobe::cosine(m)?;
                Some(Scatter::Gauss(lobe, shares(reflectance, transmittance)?))
            }
            Finish::Abg { a, b, g, reflectance } => Some(Scatter::Abg(Abg::new([a, b, g], reflectance)?)),
            Finish::None
            | Finish::Polished
            | Finish::Rough { .. }
            | Finish::Measured { .. }
            | Finish::MirrorMetal { .. }
            | Finish::MirrorIdeal { .. }
            | Finish::Polariser { .. }
            | Finish::Retarder { .. }
            | Finish::WavePlate { .. }
            | Finish::CircularPolariser { .. }
            | Finish::ReflectivePolariser { .. }
            | Finish::Grating { .. }
            | Finish::Surface { .. }
            | Finish::Absorber => None,
        }
    }

    /// A lobe too narrow to gather photons at: its half width at half maximum is below that of the widest Gaussian that
    /// is narrow.
    pub fn is_narrow(&self) -> bool {
        let limit = Finish::NARROW_SIGMA_DEG.to_radians();
        let half_width = limit * (2.0 * std::f64::consts::LN_2).sqrt();
        match self {
            Scatter::Lambert(_) | Scatter::Measured(_) => false,
            Scatter::Gauss(lobe, _) => lobe.sigma_rad() < limit,
            Scatter::Rough(rough) => rough.half_width_rad() < half_width,
            Scatter::Abg(abg) => abg.half_width() < half_width,
            Scatter::Principled(principled) => principled.is_narrow(half_width),
        }
    }

    /// Whether light of other scatterers is better gathered at those than through this lobe: the eye sees a rough face of a
    /// solid through a lobe of few degrees, and the solid sends back to it what it has scattered itself, so that few photons
    /// hit the lobe and are as bright as the picture.
    ///
    /// Variance × time of gathering here over that of going on, for the pane of `eyebox bench --generate 11` (18 for 22°) at
    /// half widths of 1.5°, 3.7°, 12°, 22°, 42° and 66°: 380, 50, 25, 7, 0.8, 0.65. A sheet that diffuses has no solid
    /// behind it: 0.2 to 0.35 for seeds 8, 15 and 29, with Gaussian lobes of 3° to 20°.
    pub fn asks_for_final_gather(&self) -> bool {
        const WIDEST_DEG: f64 = 35.0;
        match self {
            Scatter::Rough(rough) => rough.half_width_rad() < WIDEST_DEG.to_radians(),
            Scatter::Lambert(_)
            | Scatter::Gauss(..)
            | Scatter::Abg(_)
            | Scatter::Measured(_)
            | Scatter::Principled(_) => false,
        }
    }

    /// What scattering here is in a path's event string.
    pub fn event(&self) -> Event {
        if self.is_narrow() { Event::Glossy } else { Event::Diffuse }
    }

    /// The interface between two media: its values depend on their indices.
    pub fn refracts(&self) -> bool {
        match self {
            Scatter::Rough(_) => true,
            Scatter::Lambert(_)
            | Scatter::Gauss(..)
            | Scatter::Abg(_)
            | Scatter::Measured(_)
            | Scatter::Principled(_) => false,
        }
    }

    /// The ordinary material here, if it is one.
    pub fn principled(&self) -> Option<&Principled> {
        match self {
            Scatter::Principled(principled) => Some(principled),
            Scatter::Lambert(_) | Scatter::Gauss(..) | Scatter::Rough(_) | Scatter::Abg(_) | Scatter::Measured(_) => {
                None
            }
        }
    }

    /// Share that is reflected specularly besides.
    pub fn specular(&self) -> f64 {
        match self {
            Scatter::Abg(abg) => abg.specular(),
            Scatter::Lambert(_)
            | Scatter::Gauss(..)
            | Scatter::Rough(_)
            | Scatter::Measured(_)
            | Scatter::Principled(_) => 0.0,
        }
    }

    /// Bidirectional scattering distribution, 1/sr, without a cosine. Unit directions.
    pub fn eval(&self, d_in: DVec3, d_out: DVec3, n: Sides<'_>) -> f64 {
        if !(d_in.z < 0.0 && d_out.z.abs() > 0.0) {
            return 0.0;
        }
        match self {
            Scatter::Lambert(shares) => lambert::eval(*shares, d_out),
            Scatter::Gauss(lobe, shares) => gauss::eval(lobe, *shares, d_in, d_out),
            Scatter::Rough(rough) => rough.eval(d_in, d_out, n),
            Scatter::Abg(abg) => abg.eval(d_in, d_out),
            Scatter::Measured(measured) => measured.eval(d_in, d_out),
            Scatter::Principled(principled) => n.look.map_or(0.0, |look| principled.eval(d_in, d_out, look)),
        }
    }

    /// Density with which [`Scatter::sample`] returns `d_out`, 1/sr. Its integral is less than 1 by the share of
    /// samples that have no direction.
    pub fn pdf(&self, d_in: DVec3, d_out: DVec3, n: Sides<'_>) -> f64 {
        if !(d_in.z < 0.0 && d_out.z.abs() > 0.0) {
            return 0.0;
        }
        match self {
            Scatter::Lambert(shares) | Scatter::Gauss(_, shares) if shares.total() <= 0.0 => 0.0,
            Scatter::Lambert(shares) => lambert::pdf(*shares, d_out),
            Scatter::Gauss(lobe, shares) => gauss::pdf(lobe, *shares, d_in, d_out),
            Scatter::Rough(rough) => rough.pdf(d_in, d_out, n),
            Scatter::Abg(abg) => abg.pdf(d_in, d_out),
            Scatter::Measured(measured) => measured.pdf(d_in, d_out),
            Scatter::Principled(principled) => n.look.map_or(0.0, |look| principled.pdf(d_in, d_out, look)),
        }
    }

    /// Samples a direction; `u[0]` chooses the side, the others the direction. None is a sample of weight 0: absorbed,
    /// or in the wrong half space.
    pub fn sample(&self, d_in: DVec3, n: Sides<'_>, u: [f64; 3]) -> Option<Sampled> {
        if d_in.z.is_nan() || d_in.z >= 0.0 {
            return None;
        }
        let sampled = match self {
            Scatter::Lambert(shares) | Scatter::Gauss(_, shares) if shares.total() <= 0.0 => None,
            Scatter::Lambert(shares) => lambert::sample(*shares, u),
            Scatter::Gauss(lobe, shares) => gauss::sample(lobe, *shares, d_in, u),
            Scatter::Rough(rough) => rough.sample(d_in, n, u),
            Scatter::Abg(abg) => abg.sample(d_in, [u[1], u[2]]),
            Scatter::Measured(measured) => measured.sample(d_in, u),
            Scatter::Principled(principled) => n.look.and_then(|look| principled.sample(d_in, look, u)),
        };
        sampled.filter(|s| s.pdf > 0.0 && s.pdf.is_finite() && s.weight.is_finite())
    }

    /// Share of the arriving light that is scattered, either way, at incidence `cos_in` in (0, 1]. What rough faces lose or gain by their tables, up to 3e-4, is not told apart from 1. Of an ordinary
    /// material a guess: that of its factors, without its textures.
    pub fn albedo(&self, cos_in: f64) -> f64 {
        match self {
            Scatter::Lambert(shares) | Scatter::Gauss(_, shares) => shares.total(),
            Scatter::Rough(_) => 1.0,
            Scatter::Abg(abg) => abg.albedo(cos_in),
            Scatter::Measured(measured) => measured.albedo(cos_in),
            Scatter::Principled(principled) => principled.albedo(cos_in),
        }
    }
}

fn mirrored(d: DVec3) -> DVec3 {
    DVec3::new(d.x, d.y, -d.z)
}

#[cfg(test)]
mod tests;
