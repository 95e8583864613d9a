//! Light that a path from the eye picks up where it is.

use super::walk::{Vertex, Walker};
use crate::film::accumulate::Light;
use crate::world::lamp::Lamp;
use crate::world::mode::{Mode, lanes};

/// A lamp that a path from the eye has met.
pub struct EmitterHit<'w> {
    pub lamp: &'w Lamp,
    /// Its number among the lamps.
    pub index: usize,
    /// Of the angle between the lamp's normal and the way to the eye.
    pub cos: f64,
    /// That way, cd/m²; above 0.
    pub luminance: f64,
    /// What the place has of it, if not all alike.
    pub glow: Option<[f64; 3]>,
}

impl<'w, M: Mode> Walker<'w, M> {
    /// Adds the light that a path from the eye picks up where it is: `amounts` per lane, luminance.
    ///
    /// Radiance over index squared is what such a path carries, so the factor (n_eye/n_here)² is applied here, once.
    pub fn pick_up(&self, out: &mut [Light], amounts: &M::Lanes<f64>) {
        self.pick_up_in(&self.index_here(), out, amounts);
    }

    /// Adds the light of a lamp that the path has met, `factor` times.
    pub fn see(&self, out: &mut [Light], seen: &EmitterHit<'_>, factor: f64) {
        let tint = self.optics.lamp_at(seen.index, seen.glow);
        let index = self.index_here();
        let amounts = lanes::<M, _>(|lane| seen.luminance * factor * tint[lane] / (index[lane] * index[lane]));
        match seen.lamp.polarisation {
            None => self.beam.deposit(self.optics, out, &amounts),
            Some(light) => self.beam.polarised(light, self.ray.dir, true).deposit(self.optics, out, &amounts),
        }
    }

    /// The light of a lamp that the path has met, as it arrives at the path's start: luminance per lane; whether the first
    /// lane stands for all.
    pub fn seen(&self, seen: &EmitterHit<'_>) -> (M::Lanes<Light>, bool) {
        let tint = self.optics.lamp_at(seen.index, seen.glow);
        let index = self.index_here();
        let beam = match seen.lamp.polarisation {
            None => self.beam,
            Some(light) => self.beam.polarised(light, self.ray.dir, true),
        };
        let (light, alone) = beam.stored();
        let factor = |lane: usize| seen.luminance * tint[lane] / (index[lane] * index[lane]);
        (lanes::<M, _>(|lane| light[lane].scaled(factor(lane))), alone)
    }

    /// [`Walker::pick_up`] in a medium of this index.
    pub fn pick_up_in(&self, index: &M::Lanes<f64>, out: &mut [Light], amounts: &M::Lanes<f64>) {
        self.beam.deposit(self.optics, out, &lanes::<M, _>(|lane| amounts[lane] / (index[lane] * index[lane])));
    }

    /// [`Walker::pick_up_in`], of the first lane alone, which stands for all.
    pub fn pick_up_alone(&self, index: &M::Lanes<f64>, out: &mut [Light], amounts: &M::Lanes<f64>) {
        let mut beam = self.beam;
        beam.part();
        beam.deposit(self.optics, out, &lanes::<M, _>(|lane| amounts[lane] / (index[lane] * index[lane])));
    }

    /// The lamp at `vertex` that shines along the path towards the eye.
    pub fn lamp_at(&self, vertex: &Vertex) -> Option<EmitterHit<'w>> {
        let (site, world) = (vertex.hit.site, self.world);
        let front = world.lamps.of_face(site.part as usize, site.face as usize)?;
        let towards = -self.ray.dir.dot(vertex.hit.normal);
        let (index, normal) = match world.lamps.back_of(front) {
            Some(back) if towards < 0.0 => (back, -vertex.hit.normal),
            Some(_) | None => (front, vertex.hit.normal),
        };
        let lamp = &world.lamps.all()[index];
        let cos = -self.ray.dir.dot(normal);
        let luminance = lamp.luminance_along(normal, -self.ray.dir);
        (luminance > 0.0).then(|| {
            let glow = lamp.glow(site.triangle, vertex.hit.point);
            EmitterHit { lamp, index, cos, luminance, glow }
        })
    }
}
