//! The standard surface: a base that is a metal or a dielectric over a diffuse body, under a clear coat and a sheen, as
//! glTF 2.0 and OpenPBR 1.1 have them.
//!
//! Facets are those of [`rough`](super::rough), with one bounce. What a metal's lose by their masking comes back by the lobe of
//! Kulla and Conty, "Revisiting Physically Based Shading at Imageworks" (SIGGRAPH 2017 courses), with its colour. Under the
//! facets of a dielectric the body is Lambertian but for what gets in and out: ρ T(i) T(o)/(π T̄), T = what all
//! layers above leave under that cosine ([`diffuse`]: of a rough one). That is reciprocal, and nothing is lost of a white body (Ashikhmin and Shirley, "An Anisotropic
//! Phong BRDF Model", JGT 5(2), 2000, by numbers instead of Schlick's form). To lobes of facets a coat and a sheen
//! leave 1 − the larger of what they reflect under the two cosines: reciprocal, and never a gain. What the coat absorbs is by the way
//! through it, in and out.
//!
//! A sheet that transmits is clear where its facets are smooth ([`Principled::passes`]). Where they are rough it sends on through
//! the face what they do not reflect, as the mirror image of their lobe, and what they lose by masking by a lobe as that of metals.
//! A coat with normals of its own has facets about those, times what the cosines about both normals have in common:
//! min(1, cos coat/cos base) at both ends, which is reciprocal and gives no light that was not there.

mod diffuse;
pub mod energy;
mod film;
mod frame;
mod layers;
mod lobe;
mod look;
mod outwards;
mod point;
mod polarisation;
mod sheen;
mod stretched;
#[cfg(any(test, feature = "testing"))]
pub mod trials;

pub use look::Look;
pub use point::Point;

use super::{Sampled, mirrored};
use energy::Energy;
use eyebox_base::Shared;
use eyebox_base::warp::{Frame, cosine_hemisphere};
use eyebox_scene::StandardSurface;
use eyebox_scene::mesh::Mesh;
use film::Interference;
use glam::DVec3;
use lobe::Lobe;
use sheen::{sheen, sheen_reflects};
use std::f64::consts::PI;
use std::sync::Arc;
use stretched::Stretched;

/// A standard surface on a face.
#[derive(Debug, Clone)]
pub struct Principled {
    pub surface: Shared<StandardSurface>,
    /// What texture coordinates and colours of vertices are read from.
    mesh: Shared<Mesh>,
    base: Arc<Energy>,
    coat: Arc<Energy>,
    /// Of facets that are not alike all round.
    stretched: Option<Arc<Stretched>>,
    film: Option<Arc<Interference>>,
}

impl PartialEq for Principled {
    fn eq(&self, other: &Self) -> bool {
        self.surface == other.surface && self.mesh == other.mesh
    }
}

/// The lobes of a surface, by what is chosen between them.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Chances {
    /// What the body scatters back, and what scatters through.
    back: f64,
    through: f64,
    /// Fibres, and what facets of a metal lose and send back all the same.
    fuzz: f64,
    /// Facets of the base and of the coat.
    base: f64,
    coat: f64,
    /// What facets send through a sheet.
    sheet: f64,
    /// What those lose and send through all the same.
    sheet_again: f64,
}

impl Principled {
    pub fn new(surface: Shared<StandardSurface>, mesh: Shared<Mesh>) -> Self {
        let base = Energy::of(surface.ior);
        let stretched = surface.anisotropy.as_ref().filter(|found| found.strength.factor > 0.0).map(|found| {
            let strength = &found.strength;
            Stretched::of(surface.ior, found.law, strength.factor.clamp(0.0, 1.0), strength.texture.is_some())
        });
        let film = surface.film.as_ref().filter(|film| film.weight.factor > 0.0);
        let film = film.map(|film| Interference::of(film, energy::normal_reflectance(surface.ior)));
        Principled { base, coat: Energy::of(surface.coat_ior), stretched, film, surface, mesh }
    }

    /// Whether all that it sends out stays within a lobe narrower than this half width at half maximum: a metal that is
    /// smooth everywhere.
    pub(super) fn is_narrow(&self, half_width_rad: f64) -> bool {
        let surface = &self.surface;
        let metal = surface.metallic.texture.is_none() && surface.metallic.factor >= 1.0;
        // A texture's values are at most 1.
        let alpha = energy::alpha(surface.roughness.factor);
        metal && surface.anisotropy.is_none() && super::rough::half_width_rad(alpha) < half_width_rad
    }

    /// Bidirectional distribution, 1/sr, without the cosine.
    pub(super) fn eval(&self, d_in: DVec3, d_out: DVec3, look: &Look) -> f64 {
        let wi = -d_in;
        let layers = self.layers(wi, d_out, look);
        let frame = look.body_frame();
        // The body scatters by the cosine about its own normal.
        let share = frame.as_ref().map_or(1.0, |frame| (frame.to_local(d_out).z / d_out.z).max(0.0));
        if d_out.z < 0.0 {
            let sheet = if layers.sheet > 0.0 { self.through_sheet(wi, mirrored(d_out), look) } else { 0.0 };
            return layers.stain * layers.body * share * look.tint.through * look.diffuse_transmission
                + layers.under * layers.sheet * look.tint.base * (sheet + layers.again);
        }
        let about_body = frame.map_or([wi, d_out], |frame| [wi, d_out].map(|w| frame.to_local(w)));
        let back = layers.stain * self.scatters_back(about_body, &layers, look);
        let mut sum = share * back * (1.0 - look.diffuse_transmission);
        if look.metallic > 0.0 {
            sum += layers.under * look.metallic * layers.again * self.again(look, look.tint);
        }
        if let Some([value, _, cos]) = look.lobe().mirrored(wi, d_out) {
            let plain = self.dielectric_reflects(cos, look);
            let metal = if look.metallic > 0.0 { self.metal_reflects(cos, look, look.tint) } else { 0.0 };
            sum += layers.under * value * (plain + (metal - plain) * look.metallic);
        }
        if look.coat > 0.0
            && let Some(([value, _, cos], common)) = coat_facets(wi, d_out, look)
        {
            sum += layers.under_sheen * look.coat * self.coat_facet(cos) * value * common;
        }
        if look.tint.sheen > 0.0 {
            sum += look.tint.sheen * sheen(wi, d_out, look.sheen_alpha);
        }
        sum
    }

    /// What rough facets of a sheet send through it, to the mirror image of `wo`, without the tint.
    fn through_sheet(&self, wi: DVec3, wo: DVec3, look: &Look) -> f64 {
        let found = look.lobe().mirrored(wi, wo);
        found.map_or(0.0, |[value, _, cos]| value * (1.0 - self.dielectric_reflects(cos, look)).max(0.0))
    }

    /// Density of [`Principled::sample`], 1/sr.
    pub(super) fn pdf(&self, d_in: DVec3, d_out: DVec3, look: &Look) -> f64 {
        density(-d_in, d_out, look, &self.chances(-d_in, look))
    }

    /// `u[0]` chooses the lobe, the others the direction.
    pub(super) fn sample(&self, d_in: DVec3, look: &Look, u: [f64; 3]) -> Option<Sampled> {
        let wi = -d_in;
        let chances = self.chances(wi, look);
        let at = [u[1], u[2]];
        let mut left = u[0];
        let mut chosen = |chance: f64| {
            let yes = left < chance;
            left -= chance;
            yes
        };
        let dir = if chosen(chances.back) {
            about_body(look, cosine_hemisphere(at), 1.0)?
        } else if chosen(chances.through) {
            about_body(look, mirrored(cosine_hemisphere(at)), -1.0)?
        } else if chosen(chances.fuzz) {
            cosine_hemisphere(at)
        } else if chosen(chances.sheet_again) {
            mirrored(cosine_hemisphere(at))
        } else if chosen(chances.base) {
            look.lobe().sample(wi, at)?
        } else if chosen(chances.sheet) {
            mirrored(look.lobe().sample(wi, at)?)
        } else if chances.coat > 0.0 {
            let frame = look.coat_normal.map(Frame::about);
            let local = |w: DVec3| frame.as_ref().map_or(w, |frame| frame.to_local(w));
            let wo = Lobe::new(look.coat_alpha, None).sample(local(wi), at)?;
            frame.as_ref().map_or(wo, |frame| frame.to_world(wo))
        } else {
            // Rounding of the sum.
            return None;
        };
        if dir.z == 0.0 {
            return None;
        }
        let pdf = density(wi, dir, look, &chances);
        Some(Sampled { dir, weight: self.eval(d_in, dir, look) * dir.z.abs() / pdf, pdf })
    }

    /// The chance of each lobe, by what they carry of light of all colours. They sum to 1, or are all 0.
    fn chances(&self, wi: DVec3, look: &Look) -> Chances {
        let mean = look.mean;
        let layers = self.layers(wi, wi, &Look { tint: mean, ..*look });
        let (inside, facets) = self.facets(wi, look, mean);
        let lost = 1.0 - self.energy(wi, look)[0];
        let again = if look.metallic > 0.0 { look.metallic * lost * self.again(look, mean) } else { 0.0 };
        let back = mean.base * (1.0 - look.diffuse_transmission);
        let sheet = layers.under * layers.sheet * mean.base;
        let all = Chances {
            back: layers.under * inside * (1.0 - look.transmission) * back,
            through: layers.under * inside * (1.0 - look.transmission) * look.diffuse_transmission * mean.through,
            fuzz: layers.under * again + mean.sheen,
            base: layers.under * facets,
            coat: layers.under_sheen * look.coat * self.coat_reflects(wi, look),
            // A mean of what one facet lets through serves: 1 − what it reflects straight on.
            sheet: sheet * (1.0 - lost) * (1.0 - look.straight * look.specular),
            sheet_again: sheet * lost,
        };
        let sum = all.back + all.through + all.fuzz + all.base + all.coat + all.sheet + all.sheet_again;
        let scale = if sum > 0.0 && sum.is_finite() { 1.0 / sum } else { 0.0 };
        Chances {
            back: all.back * scale,
            through: all.through * scale,
            fuzz: all.fuzz * scale,
            base: all.base * scale,
            coat: all.coat * scale,
            sheet: all.sheet * scale,
            sheet_again: all.sheet_again * scale,
        }
    }

    /// Share of light from a direction that goes straight through: past what is cut out, and through a clear sheet.
    pub fn passes(&self, wi: DVec3, look: &Look) -> f64 {
        if look.transmission == 0.0 || !look.is_clear() {
            return 1.0 - look.opacity;
        }
        let (inside, _) = self.facets(wi, look, look.tint);
        let through = self.lets_out(wi, look) * inside * look.transmission * look.tint.base;
        1.0 - look.opacity + look.opacity * through
    }

    /// About what share of light that falls straight on is scattered, for a guess without the place.
    pub(super) fn albedo(&self, cos: f64) -> f64 {
        let look = Point::plain(&self.surface).look(None);
        self.scatters(DVec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos), &look)
    }

    /// Share of light from a direction that is scattered where it meets the surface.
    pub fn scatters(&self, wi: DVec3, look: &Look) -> f64 {
        let (inside, facets) = self.facets(wi, look, look.tint);
        let layers = self.layers(wi, wi, look);
        let d = look.diffuse_transmission;
        let body =
            (1.0 - look.transmission) * ((1.0 - d) * self.body_albedo(wi, look, look.tint) + d * look.tint.through);
        let sheet = if layers.sheet > 0.0 { look.transmission * look.tint.base } else { 0.0 };
        let lost = 1.0 - self.energy(wi, look)[0];
        let again = if look.metallic > 0.0 { look.metallic * lost * self.again(look, look.tint) } else { 0.0 };
        let coat = layers.under_sheen * look.coat * self.coat_reflects(wi, look);
        let sheen = look.tint.sheen * sheen_reflects(wi.z.abs(), look.sheen_alpha);
        (layers.under * (inside * (body + sheet) + facets + again) + coat + sheen).min(1.0)
    }
}

/// A direction about the body's normal; none where that leads to the other side.
fn about_body(look: &Look, w: DVec3, side: f64) -> Option<DVec3> {
    let dir = look.body_frame().map_or(w, |frame| frame.to_world(w));
    (dir.z * side > 0.0).then_some(dir)
}

fn density(wi: DVec3, wo: DVec3, look: &Look, chances: &Chances) -> f64 {
    let own = look.body_frame().map_or(wo.z, |frame| frame.to_local(wo).z);
    if wo.z < 0.0 {
        let lobe = if chances.sheet > 0.0 { look.lobe().mirrored(wi, mirrored(wo)) } else { None };
        let sheet = lobe.map_or(0.0, |[_, pdf, _]| chances.sheet * pdf);
        return (chances.through * (-own).max(0.0) - chances.sheet_again * wo.z) / PI + sheet;
    }
    let base = if chances.base > 0.0 { look.lobe().mirrored(wi, wo) } else { None };
    let coat = if chances.coat > 0.0 { coat_facets(wi, wo, look) } else { None };
    (chances.back * own.max(0.0) + chances.fuzz * wo.z) / PI
        + base.map_or(0.0, |[_, pdf, _]| chances.base * pdf)
        + coat.map_or(0.0, |([_, pdf, _], _)| chances.coat * pdf)
}

/// Value, density and cosine of the coat's facets, and what the cosines about its own normal and the base's have in common.
fn coat_facets(wi: DVec3, wo: DVec3, look: &Look) -> Option<([f64; 3], f64)> {
    let lobe = Lobe::new(look.coat_alpha, None);
    let Some(normal) = look.coat_normal else { return lobe.mirrored(wi, wo).map(|found| (found, 1.0)) };
    let frame = Frame::about(normal);
    let (own_in, own_out) = (frame.to_local(wi), frame.to_local(wo));
    if own_in.z <= 0.0 || own_out.z <= 0.0 || wo.z <= 0.0 {
        return None;
    }
    let common = (own_in.z / wi.z).min(1.0) * (own_out.z / wo.z).min(1.0);
    lobe.mirrored(own_in, own_out).map(|found| (found, common))
}

#[cfg(test)]
mod tests;
