//! The standard surface: a base that is a metal or a dielectric over a diffuse body, under a clear coat and a sheen, as
//! glTF 2.0 and OpenPBR 1.1 have them.
//!
//! Facets are those of [`rough`](super::rough), with one bounce. What a metal's lose by their masking comes back by the lobe of
//! Kulla and Conty, "Revisiting Physically Based Shading at Imageworks" (SIGGRAPH 2017 courses), with its colour. Under the
//! facets of a dielectric the body is Lambertian but for what gets in and out: ρ T(i) T(o)/(π T̄), T = what all
//! layers above leave under that cosine. That is reciprocal, and nothing is lost of a white body (Ashikhmin and Shirley, "An Anisotropic
//! Phong BRDF Model", JGT 5(2), 2000, by numbers instead of Schlick's form). To lobes of facets a coat and a sheen
//! leave 1 − the larger of what they reflect under the two cosines: reciprocal, and never a gain.

pub mod energy;
mod look;
mod point;

pub use look::{Look, Tint};
pub use point::Point;

use super::rough::Facets;
use super::{Sampled, mirrored};
use crate::base::Shared;
use crate::base::warp::cosine_hemisphere;
use crate::scene::StandardSurface;
use crate::scene::mesh::Mesh;
use energy::Energy;
use glam::DVec3;
use std::f64::consts::PI;
use std::sync::Arc;

/// Index of the coat (KHR_materials_clearcoat).
const COAT_IOR: f64 = 1.5;

/// A standard surface on a face.
#[derive(Debug, Clone)]
pub struct Principled {
    pub surface: Shared<StandardSurface>,
    /// What texture coordinates and colours of vertices are read from.
    mesh: Shared<Mesh>,
    base: Arc<Energy>,
    coat: Arc<Energy>,
}

impl PartialEq for Principled {
    fn eq(&self, other: &Self) -> bool {
        self.surface == other.surface && self.mesh == other.mesh
    }
}

impl Principled {
    pub fn new(surface: Shared<StandardSurface>, mesh: Shared<Mesh>) -> Self {
        let base = Energy::of(surface.ior);
        Principled { surface, mesh, base, coat: Energy::of(COAT_IOR) }
    }

    /// Whether all that it sends out stays within a lobe narrower than this half width at half maximum: a metal that is
    /// smooth everywhere.
    pub(super) fn is_narrow(&self, half_width_rad: f64) -> bool {
        let surface = &self.surface;
        let metal = surface.metallic.texture.is_none() && surface.metallic.factor >= 1.0;
        // A texture's values are at most 1.
        let alpha = energy::alpha(surface.roughness.factor);
        metal && super::rough::half_width_rad(alpha) < half_width_rad
    }

    /// Bidirectional distribution, 1/sr, without the cosine.
    pub(super) fn eval(&self, d_in: DVec3, d_out: DVec3, look: &Look) -> f64 {
        let wi = -d_in;
        let layers = self.layers(wi.z, d_out.z.abs(), look);
        let body = layers.body;
        if d_out.z < 0.0 {
            return body * look.tint.through * look.diffuse_transmission;
        }
        let mut sum = body * look.tint.base * (1.0 - look.diffuse_transmission);
        sum += layers.under * look.metallic * layers.again * look.again(look.tint.base, &self.base);
        if let Some([value, _, cos]) = (Facets { alpha: look.alpha }).mirrored(wi, d_out) {
            let [straight, grazing] = look.dielectric(look.tint.specular);
            let plain = straight + (grazing - straight) * energy::towards_grazing(self.base.ior(), cos);
            let metal = look::schlick(look.tint.base, cos);
            sum += layers.under * value * (plain + (metal - plain) * look.metallic);
        }
        if look.coat > 0.0
            && let Some([value, _, cos]) = (Facets { alpha: look.coat_alpha }).mirrored(wi, d_out)
        {
            let straight = energy::normal_reflectance(COAT_IOR);
            let share = straight + (1.0 - straight) * energy::towards_grazing(COAT_IOR, cos);
            sum += layers.under_sheen * look.coat * share * value;
        }
        sum + look.tint.sheen * sheen(wi, d_out, look.sheen_alpha)
    }

    /// Density of [`Principled::sample`], 1/sr.
    pub(super) fn pdf(&self, d_in: DVec3, d_out: DVec3, look: &Look) -> f64 {
        self.density(-d_in, d_out, look, &self.chances(-d_in.z, look))
    }

    /// `u[0]` chooses the lobe, the others the direction.
    pub(super) fn sample(&self, d_in: DVec3, look: &Look, u: [f64; 3]) -> Option<Sampled> {
        let wi = -d_in;
        let chances = self.chances(wi.z, look);
        let at = [u[1], u[2]];
        let facets = |alpha: f64| {
            let h = Facets { alpha }.visible_normal(wi, at);
            let wo = (h * (2.0 * wi.dot(h)) - wi).normalize();
            (wo.z > 0.0).then_some(wo)
        };
        let [body, through, base, _] = chances;
        let dir = if u[0] < body {
            cosine_hemisphere(at)
        } else if u[0] < body + through {
            mirrored(cosine_hemisphere(at))
        } else if u[0] < body + through + base {
            facets(look.alpha)?
        } else if look.coat > 0.0 {
            facets(look.coat_alpha)?
        } else {
            // Rounding of the sum.
            return None;
        };
        if dir.z == 0.0 {
            return None;
        }
        let pdf = self.density(wi, dir, look, &chances);
        Some(Sampled { dir, weight: self.eval(d_in, dir, look) * dir.z.abs() / pdf, pdf })
    }

    fn density(&self, wi: DVec3, wo: DVec3, look: &Look, [body, through, base, coat]: &[f64; 4]) -> f64 {
        if wo.z < 0.0 {
            return through * -wo.z / PI;
        }
        let facets = |chance: f64, alpha: f64| {
            let found = if chance > 0.0 { Facets { alpha }.mirrored(wi, wo) } else { None };
            chance * found.map_or(0.0, |[_, pdf, _]| pdf)
        };
        body * wo.z / PI + facets(*base, look.alpha) + facets(*coat, look.coat_alpha)
    }

    /// The chance of each lobe: what scatters back, what scatters through, the facets of the base and of the coat; by what they
    /// carry of light of all colours. They sum to 1, or are all 0.
    fn chances(&self, cos: f64, look: &Look) -> [f64; 4] {
        let mean = look.mean;
        let layers = self.layers(cos, cos, look);
        let (inside, facets) = self.facets(cos, look, mean);
        let again = look.metallic * (1.0 - self.base.at(cos, look.roughness())[0]) * look.again(mean.base, &self.base);
        let back = mean.base * (1.0 - look.diffuse_transmission);
        let all = [
            layers.under * (inside * (1.0 - look.transmission) * back + again) + mean.sheen,
            layers.under * inside * (1.0 - look.transmission) * look.diffuse_transmission * mean.through,
            layers.under * facets,
            layers.under_sheen * look.coat * self.coat_reflects(cos, look),
        ];
        let sum: f64 = all.iter().sum();
        if sum > 0.0 && sum.is_finite() { all.map(|x| x / sum) } else { [0.0; 4] }
    }

    /// Of light under a cosine, for these colours: what gets into the body of the dielectric share, and what the facets of
    /// dielectric and metal reflect.
    fn facets(&self, cos: f64, look: &Look, tint: Tint) -> (f64, f64) {
        let [whole, edge] = self.base.at(cos, look.roughness());
        let [straight, grazing] = look.dielectric(tint.specular);
        let plain = straight * (whole - edge) + grazing * edge;
        // Schlick's fifth power is nearly the t of glass.
        let metal = tint.base * (whole - edge) + edge;
        let dielectric = 1.0 - look.metallic;
        (dielectric * (1.0 - plain).max(0.0), dielectric * plain + look.metallic * metal)
    }

    fn coat_reflects(&self, cos: f64, look: &Look) -> f64 {
        let [whole, edge] = self.coat.at(cos, look.coat_alpha.sqrt());
        let straight = energy::normal_reflectance(COAT_IOR);
        straight * (whole - edge) + edge
    }

    /// Share of light under a cosine that gets through coat, sheen and facets into the body.
    fn opening(&self, cos: f64, look: &Look) -> f64 {
        let [straight, grazing] = look.dielectric(look.tint.specular);
        let [whole, edge] = self.base.at(cos, look.roughness());
        let mut open = (1.0 - straight * (whole - edge) - grazing * edge).max(0.0);
        if look.coat > 0.0 {
            open *= 1.0 - look.coat * self.coat_reflects(cos, look);
        }
        if look.most_sheen > 0.0 {
            open *= 1.0 - look.most_sheen * look::sheen_reflects(cos, look.sheen_alpha);
        }
        open.max(0.0)
    }

    /// [`Principled::opening`] of light from all sides: its mean by the cosine.
    fn mean_opening(&self, look: &Look) -> f64 {
        if look.coat == 0.0 && look.most_sheen == 0.0 {
            let [straight, grazing] = look.dielectric(look.tint.specular);
            let [whole, edge] = self.base.mean(look.roughness());
            return (1.0 - straight * (whole - edge) - grazing * edge).max(0.0);
        }
        // Gauss and Legendre's six points of 0 to 1 (Abramowitz and Stegun 25.4.30).
        const POINTS: [[f64; 2]; 6] = [
            [0.033_765_242_898_424, 0.085_662_246_189_585],
            [0.169_395_306_766_868, 0.180_380_786_524_069],
            [0.380_690_406_958_402, 0.233_956_967_286_346],
            [0.619_309_593_041_598, 0.233_956_967_286_346],
            [0.830_604_693_233_132, 0.180_380_786_524_069],
            [0.966_234_757_101_576, 0.085_662_246_189_585],
        ];
        POINTS.iter().map(|[cos, weight]| 2.0 * cos * weight * self.opening(*cos, look)).sum()
    }

    /// What layers leave to those below, between two directions.
    fn layers(&self, cos_in: f64, cos_out: f64, look: &Look) -> Layers {
        let dielectric = (1.0 - look.metallic) * (1.0 - look.transmission);
        let mean = if dielectric > 0.0 { self.mean_opening(look) } else { 0.0 };
        let body =
            if mean > 0.0 { self.opening(cos_in, look) * self.opening(cos_out, look) / (PI * mean) } else { 0.0 };
        let again = if look.metallic > 0.0 {
            let lost = |cos: f64| 1.0 - self.base.at(cos, look.roughness())[0];
            let mean = 1.0 - self.base.mean(look.roughness())[0];
            if mean > 0.0 { lost(cos_in) * lost(cos_out) / (PI * mean) } else { 0.0 }
        } else {
            0.0
        };
        let coat = if look.coat > 0.0 {
            look.coat * self.coat_reflects(cos_in, look).max(self.coat_reflects(cos_out, look))
        } else {
            0.0
        };
        let under_sheen = 1.0 - look.most_sheen * look::sheen_reflects(cos_in.min(cos_out), look.sheen_alpha);
        Layers {
            under: (under_sheen * (1.0 - coat)).max(0.0),
            under_sheen: under_sheen.max(0.0),
            body: dielectric * body,
            again,
        }
    }

    /// Share of light under a cosine that goes straight through: past what is cut out, and through a sheet that transmits.
    pub fn passes(&self, cos: f64, look: &Look) -> f64 {
        if look.transmission == 0.0 {
            return 1.0 - look.opacity;
        }
        let (inside, _) = self.facets(cos, look, look.tint);
        let through = self.layers(cos, cos, look).under * inside * look.transmission * look.tint.base;
        1.0 - look.opacity + look.opacity * through
    }

    /// About what share of light that falls straight on is scattered, for a guess without the place.
    pub(super) fn albedo(&self, cos: f64) -> f64 {
        let look = Point::plain(&self.surface).look(None);
        self.scatters(cos, &look)
    }

    /// Share of light under a cosine that is scattered where it meets the surface.
    pub fn scatters(&self, cos: f64, look: &Look) -> f64 {
        let (inside, facets) = self.facets(cos, look, look.tint);
        let layers = self.layers(cos, cos, look);
        let d = look.diffuse_transmission;
        let body = (1.0 - look.transmission) * ((1.0 - d) * look.tint.base + d * look.tint.through);
        let again =
            look.metallic * (1.0 - self.base.at(cos, look.roughness())[0]) * look.again(look.tint.base, &self.base);
        let coat = layers.under_sheen * look.coat * self.coat_reflects(cos, look);
        let sheen = look.tint.sheen * look::sheen_reflects(cos, look.sheen_alpha);
        (layers.under * (inside * body + facets + again) + coat + sheen).min(1.0)
    }
}

/// What is left below layers, and the lobes without their colours, 1/sr.
struct Layers {
    /// Below coat and sheen; below the sheen.
    under: f64,
    under_sheen: f64,
    /// Of the body, below all of them.
    body: f64,
    again: f64,
}

/// Fibres: the distribution of Estevez and Kulla, "Production Friendly Microfacet Sheen BRDF" (SIGGRAPH 2017 courses), with
/// the visibility of Ashikhmin and Premože, "Distribution-based BRDFs" (2007), as KHR_materials_sheen has it.
fn sheen(wi: DVec3, wo: DVec3, alpha: f64) -> f64 {
    let h = (wi + wo).normalize_or_zero();
    let sin = (1.0 - h.z * h.z).max(0.0).sqrt();
    let distribution = (2.0 + 1.0 / alpha) * sin.powf(1.0 / alpha) / (2.0 * PI);
    let value = distribution / (4.0 * (wi.z + wo.z - wi.z * wo.z));
    if value.is_finite() { value } else { 0.0 }
}

#[cfg(test)]
mod tests;
