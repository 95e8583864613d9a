//! How much each layer of a standard surface reflects and leaves to those below.

use super::diffuse::Body;
use super::film::{FilmLook, Interference};
use super::look::{self, Look, Tint};
use super::sheen::sheen_reflects;
use super::{Principled, energy};
use energy::Tally;
use glam::DVec3;
use std::f64::consts::PI;

/// What is left below layers, and the lobes without their colours, 1/sr.
pub(super) struct Layers {
    /// Below coat and sheen; below the sheen.
    pub under: f64,
    pub under_sheen: f64,
    /// Share that a coat leaves of what comes from below it, for what it absorbs; `under` has it.
    pub stain: f64,
    /// Of a smooth body, below all of them.
    pub body: f64,
    /// Share of the surface that is a dielectric with a body.
    pub dielectric: f64,
    /// What gets through to the body from both directions, and from all sides.
    pub open: [f64; 2],
    pub mean_open: f64,
    /// Of what facets lose.
    pub again: f64,
    /// Share of the dielectric that is a rough sheet.
    pub sheet: f64,
}

impl Principled {
    /// What perfect facets reflect of light from a direction, and the columns of the tables besides.
    pub(super) fn energy(&self, w: DVec3, look: &Look) -> Tally {
        match (&self.stretched, &look.stretch) {
            (Some(tables), Some(stretch)) => {
                tables.at(w.z.abs(), stretch.across(w), look.roughness(), stretch.strength)
            }
            (None, _) | (_, None) => self.base.at(w.z.abs(), look.roughness()),
        }
    }

    /// The same of light from all sides: its mean by the cosine.
    fn mean_energy(&self, look: &Look) -> Tally {
        match (&self.stretched, &look.stretch) {
            (Some(tables), Some(stretch)) => tables.mean(look.roughness(), stretch.strength),
            (None, _) | (_, None) => self.base.mean(look.roughness()),
        }
    }

    /// What reflects `bare` without a film, with as much film as is there: `by` its table and thickness, times `specular`.
    fn filmed(&self, bare: f64, look: &Look, specular: f64, by: impl FnOnce(&Interference, f64) -> [f64; 3]) -> f64 {
        match (&self.film, &look.film) {
            (Some(table), Some(film)) => {
                let colours = by(table, film.thickness_nm);
                bare + (in_lane(colours, film.lane) * specular - bare) * film.weight
            }
            (None, _) | (_, None) => bare,
        }
    }

    /// Reflectance of a facet of the dielectric at a cosine.
    pub(super) fn dielectric_reflects(&self, cos: f64, look: &Look) -> f64 {
        let [straight, grazing] = look.dielectric(look.tint.specular);
        let bare = straight + (grazing - straight) * energy::towards_grazing(self.base.ior(), cos);
        // Under a film the index alone counts, not the colour.
        self.filmed(bare, look, look.specular, |table, nm| table.at(nm, look.straight, cos))
    }

    /// Reflectance of a facet of the metal at a cosine.
    pub(super) fn metal_reflects(&self, cos: f64, look: &Look, tint: Tint) -> f64 {
        let bare = (look::schlick(tint.base, cos) - metal_lacks(tint) * energy::edge(cos)).max(0.0);
        self.filmed(bare, look, 1.0, |table, nm| table.at(nm, tint.base, cos))
    }

    /// Share that comes back of what facets of a metal lose by one bounce.
    pub(super) fn again(&self, look: &Look, tint: Tint) -> f64 {
        // Schlick's form averaged by the cosine, and that of the edge: 2 ∫ x² (1 − x)⁶ dx = 1/126.
        let mut fresnel = tint.base + (1.0 - tint.base) / 21.0 - metal_lacks(tint) / 126.0;
        if let (Some(_), Some(film)) = (&self.film, &look.film) {
            let under = Look { film: Some(FilmLook { weight: 1.0, ..*film }), ..*look };
            let mean: f64 = POINTS.iter().map(|[cos, w]| 2.0 * cos * w * self.metal_reflects(*cos, &under, tint)).sum();
            fresnel += (mean - fresnel) * film.weight;
        }
        let [mean, ..] = self.mean_energy(look);
        let rest = 1.0 - fresnel * (1.0 - mean);
        if rest > 0.0 { (fresnel * fresnel * mean / rest).max(0.0) } else { 0.0 }
    }

    /// Of light from a direction, for these colours: what gets into the body of the dielectric share, and what the facets of
    /// dielectric and metal reflect.
    pub(super) fn facets(&self, w: DVec3, look: &Look, tint: Tint) -> (f64, f64) {
        let tally = self.energy(w, look);
        let [whole, grazing, edge] = tally;
        let plain = self.dielectric_share(tally, w.z.abs(), look, tint);
        // Schlick's fifth power is nearly the t of glass.
        let bare = (tint.base * (whole - grazing) + grazing - metal_lacks(tint) * edge).max(0.0);
        let metal = match (&self.film, &look.film) {
            (Some(_), Some(_)) => whole * self.metal_reflects(w.z.abs(), look, tint),
            (None, _) | (_, None) => bare,
        };
        let dielectric = 1.0 - look.metallic;
        (dielectric * (1.0 - plain).max(0.0), dielectric * plain + look.metallic * metal)
    }

    /// What the dielectric's facets reflect of light under a cosine.
    fn dielectric_share(&self, [whole, edge, _]: Tally, cos: f64, look: &Look, tint: Tint) -> f64 {
        let [straight, grazing] = look.dielectric(tint.specular);
        let bare = straight * (whole - edge) + grazing * edge;
        self.filmed(bare, look, look.specular, |table, nm| table.whole(nm, look.roughness(), cos))
    }

    /// Reflectance of a facet of the coat at a cosine.
    pub(super) fn coat_facet(&self, cos: f64) -> f64 {
        let straight = energy::normal_reflectance(self.coat.ior());
        straight + (1.0 - straight) * energy::towards_grazing(self.coat.ior(), cos)
    }

    /// What the coat reflects of light from a direction.
    pub(super) fn coat_reflects(&self, w: DVec3, look: &Look) -> f64 {
        let cos = match look.coat_normal {
            None => w.z.abs(),
            Some(normal) => normal.dot(DVec3::new(w.x, w.y, w.z.abs())),
        };
        if cos <= 0.0 {
            return 0.0;
        }
        let [whole, edge, _] = self.coat.at(cos, look.coat_alpha.sqrt());
        let straight = energy::normal_reflectance(self.coat.ior());
        straight * (whole - edge) + edge
    }

    /// What a coat leaves of light that goes through it along these directions, for what it absorbs.
    pub(super) fn stained<const N: usize>(&self, ways: [DVec3; N], look: &Look) -> f64 {
        if look.coat == 0.0 || look.tint.coat >= 1.0 {
            return 1.0;
        }
        // A way through and back again of 1 each is what the colour is of: along others it is 1/cos long, inside of the coat.
        let ior = self.coat.ior();
        let length = |w: DVec3| {
            let sine2 = (1.0 - w.z * w.z).max(0.0) / (ior * ior);
            0.5 / (1.0 - sine2).max(0.0).sqrt()
        };
        let left = look.tint.coat.powf(ways.into_iter().map(length).sum());
        1.0 - look.coat * (1.0 - left)
    }

    /// Share of light from a direction that gets through coat, sheen and facets into the body.
    fn opening(&self, w: DVec3, look: &Look) -> f64 {
        let reflected = self.dielectric_share(self.energy(w, look), w.z.abs(), look, look.tint);
        let mut open = (1.0 - reflected).max(0.0);
        if look.coat > 0.0 {
            open *= 1.0 - look.coat * self.coat_reflects(w, look);
        }
        if look.most_sheen > 0.0 {
            open *= 1.0 - look.most_sheen * sheen_reflects(w.z.abs(), look.sheen_alpha);
        }
        open.max(0.0)
    }

    /// [`Principled::opening`] of light from all sides: its mean by the cosine.
    fn mean_opening(&self, look: &Look) -> f64 {
        if look.coat == 0.0 && look.most_sheen == 0.0 {
            let [straight, grazing] = look.dielectric(look.tint.specular);
            let [whole, edge, _] = self.mean_energy(look);
            let bare = straight * (whole - edge) + grazing * edge;
            let reflected = self.filmed(bare, look, look.specular, |table, nm| table.mean(nm, look.roughness()));
            return (1.0 - reflected).max(0.0);
        }
        POINTS.iter().map(|[cos, weight]| 2.0 * cos * weight * self.ring(*cos, look)).sum()
    }

    /// The same of light from all round under a cosine.
    pub(super) fn ring(&self, cos: f64, look: &Look) -> f64 {
        let round = if look.coat_normal.is_some() {
            &ALL_ROUND[..]
        } else if look.stretch.is_some() {
            &QUADRANT[..]
        } else {
            // From where does not matter.
            &QUADRANT[..1]
        };
        let turn = look.stretch.map_or([1.0, 0.0], |stretch| stretch.turn);
        let sin = (1.0 - cos * cos).sqrt();
        let at =
            |[x, y]: [f64; 2]| DVec3::new(sin * (turn[0] * x - turn[1] * y), sin * (turn[1] * x + turn[0] * y), cos);
        round.iter().map(|direction| self.opening(at(*direction), look)).sum::<f64>() / round.len() as f64
    }

    /// What the body scatters back between two directions under their layers, with its colour.
    pub(super) fn scatters_back(&self, between: [DVec3; 2], layers: &Layers, look: &Look) -> f64 {
        if look.diffuse_roughness == 0.0 || layers.mean_open == 0.0 {
            return layers.body * look.tint.base;
        }
        layers.dielectric * Body::new(self, look, layers.mean_open).value(between, layers.open, look.tint)
    }

    /// Share of light that has got into the body from a direction that it scatters, if all is scattered back.
    pub(super) fn body_albedo(&self, w: DVec3, look: &Look, tint: Tint) -> f64 {
        if look.diffuse_roughness == 0.0 {
            return tint.base;
        }
        let mean = self.mean_opening(look);
        if mean > 0.0 { Body::new(self, look, mean).albedo(w.z.abs(), tint) } else { 0.0 }
    }

    /// What layers leave to those below, between two directions.
    pub(super) fn layers(&self, wi: DVec3, wo: DVec3, look: &Look) -> Layers {
        let dielectric = (1.0 - look.metallic) * (1.0 - look.transmission);
        let mean = if dielectric > 0.0 { self.mean_opening(look) } else { 0.0 };
        let open = if mean > 0.0 { [wi, wo].map(|w| self.opening(w, look)) } else { [0.0; 2] };
        let smooth = if mean > 0.0 { open[0] * open[1] / (PI * mean) } else { 0.0 };
        let sheet = if look.is_clear() { 0.0 } else { (1.0 - look.metallic) * look.transmission };
        let again = if look.metallic > 0.0 || sheet > 0.0 {
            let lost = |w: DVec3| 1.0 - self.energy(w, look)[0];
            let mean = 1.0 - self.mean_energy(look)[0];
            if mean > 0.0 { lost(wi) * lost(wo) / (PI * mean) } else { 0.0 }
        } else {
            0.0
        };
        let coat = if look.coat > 0.0 {
            look.coat * self.coat_reflects(wi, look).max(self.coat_reflects(wo, look))
        } else {
            0.0
        };
        let grazing = wi.z.abs().min(wo.z.abs());
        let under_sheen = 1.0 - look.most_sheen * sheen_reflects(grazing, look.sheen_alpha);
        let stain = if wi.z * wo.z < 0.0 { self.stained([wi], look) } else { self.stained([wi, wo], look) };
        Layers {
            under: (under_sheen * (1.0 - coat)).max(0.0) * stain,
            stain,
            under_sheen: under_sheen.max(0.0),
            body: dielectric * smooth,
            dielectric,
            open,
            mean_open: mean,
            again,
            sheet,
        }
    }
}

/// Gauss and Legendre's six points of 0 to 1 (Abramowitz and Stegun 25.4.30), and their weights.
pub(super) const POINTS: [[f64; 2]; 6] = [
    [0.033_765_242_898_424, 0.085_662_246_189_585],
    [0.169_395_306_766_868, 0.180_380_786_524_069],
    [0.380_690_406_958_402, 0.233_956_967_286_346],
    [0.619_309_593_041_598, 0.233_956_967_286_346],
    [0.830_604_693_233_132, 0.180_380_786_524_069],
    [0.966_234_757_101_576, 0.085_662_246_189_585],
];

/// Middles of four equal pieces of a right angle, as cosine and sine.
const QUADRANT: [[f64; 2]; 4] = [
    [0.980_785_280_403_230, 0.195_090_322_016_128],
    [0.831_469_612_302_545, 0.555_570_233_019_602],
    [0.555_570_233_019_602, 0.831_469_612_302_545],
    [0.195_090_322_016_128, 0.980_785_280_403_230],
];

/// The same of eight of the whole circle.
const ALL_ROUND: [[f64; 2]; 8] = [
    [0.923_879_532_511_287, 0.382_683_432_365_090],
    [0.382_683_432_365_090, 0.923_879_532_511_287],
    [-0.382_683_432_365_090, 0.923_879_532_511_287],
    [-0.923_879_532_511_287, 0.382_683_432_365_090],
    [-0.923_879_532_511_287, -0.382_683_432_365_090],
    [-0.382_683_432_365_090, -0.923_879_532_511_287],
    [0.382_683_432_365_090, -0.923_879_532_511_287],
    [0.923_879_532_511_287, -0.382_683_432_365_090],
];

/// A colour in a lane that has these shares of red, green and blue.
fn in_lane([r, g, b]: [f64; 3], [x, y, z]: [f64; 3]) -> f64 {
    (r * x + g * y + b * z).clamp(0.0, 1.0)
}

/// What a metal's reflectance lacks of Schlick's form, per unit of [`energy::edge`].
fn metal_lacks(tint: Tint) -> f64 {
    if tint.edge >= 1.0 { 0.0 } else { look::lacks(tint.base, tint.edge) }
}
