//! Light that a path from the eye picks up where it is.

use super::throughput::Throughput;
use super::walk::{Vertex, Walker};
use eyebox_film::accumulate::Light;
use eyebox_world::World;
use eyebox_world::lamp::{Lamp, LampPoint};
use eyebox_world::mode::{Mode, lanes};
use eyebox_world::optics::Optics;
use glam::{DVec2, DVec3};

/// A lamp that a path from the eye has met.
#[derive(Clone, Copy)]
pub struct EmitterHit<'w> {
    pub lamp: &'w Lamp,
    /// Its number among the lamps.
    pub index: usize,
    /// Of the angle between the lamp's normal and the way to the eye.
    pub cos: f64,
    /// That way, cd/m²; above 0.
    pub luminance: f64,
    /// What the place has of it towards the eye, if not all alike.
    pub glow: Option<[f64; 3]>,
    /// The same without the texture that the lamp shines through.
    veiled: Option<[f64; 3]>,
    /// The place, recentred world, and the mesh's triangle that it lies on.
    place: DVec3,
    triangle: u32,
}

impl EmitterHit<'_> {
    /// Recentred world, m.
    pub fn place(&self) -> DVec3 {
        self.place
    }

    /// Where in the texture that the lamp shines through, if any, it was met, in columns and rows of texels.
    pub fn in_texture(&self) -> Option<DVec2> {
        self.lamp.in_texture(self.triangle, self.place)
    }

    /// The same with the mean light of the texture that the lamp shines through.
    #[must_use]
    pub fn even(self) -> Self {
        EmitterHit { glow: self.veiled, ..self }
    }

    /// The picture that the lamp shows, if any, and where in it, in its mesh units, it was met.
    pub fn shown(&self) -> Option<(usize, DVec3)> {
        self.lamp.shown.map(|shown| (shown.slide, shown.local(self.place)))
    }
}

impl<M: Mode> Throughput<M> {
    /// With the picture that a lamp shows at a place; none where the display is dark, around its picture.
    pub fn shown(mut self, (world, optics): (&World, &Optics<M>), lamp: &Lamp, place: DVec3) -> Option<Self> {
        if let Some(shown) = &lamp.shown {
            let slide = &world.slides[shown.slide];
            self.show((slide, world.rank(shown.slide)), &optics.slide(slide, shown.local(place))?);
        }
        Some(self)
    }
}

impl<'w, M: Mode> Walker<'w, M> {
    /// Adds the light that a path from the eye picks up where it is: `amounts` per lane, luminance.
    ///
    /// Radiance over index squared is what such a path carries, so the factor (n_eye/n_here)² is applied here, once.
    pub fn pick_up(&self, out: &mut [Light], amounts: &M::Lanes<f64>) {
        let index = self.index_here();
        self.beam.deposit(self.optics, out, &lanes::<M, _>(|lane| amounts[lane] / (index[lane] * index[lane])));
    }

    /// Adds the light of a lamp that the path has met, `factor` times.
    pub fn see(&self, out: &mut [Light], seen: &EmitterHit<'_>, factor: f64) {
        let tint = self.optics.lamp_at(seen.index, seen.glow);
        let index = self.index_here();
        let amounts = lanes::<M, _>(|lane| seen.luminance * factor * tint[lane] / (index[lane] * index[lane]));
        self.beam_of(seen).deposit(self.optics, out, &amounts);
    }

    /// The light of a lamp that the path has met, as it arrives at the path's start: luminance per lane; whether the first
    /// lane stands for all.
    pub fn seen(&self, seen: &EmitterHit<'_>) -> (M::Lanes<Light>, bool) {
        let tint = self.optics.lamp_at(seen.index, seen.glow);
        let index = self.index_here();
        let beam = self.beam_of(seen);
        let (light, alone) = beam.stored();
        let factor = |lane: usize| seen.luminance * tint[lane] / (index[lane] * index[lane]);
        (lanes::<M, _>(|lane| light[lane].scaled(factor(lane))), alone)
    }

    /// The share of a lamp's light at the place that the path has met, without its picture, which arrives at the path's start.
    pub fn carried_of(&self, seen: &EmitterHit<'_>) -> f64 {
        self.beam_of(seen).weight()
    }

    /// What the path carries of a lamp's light: as it is polarised there, through the picture that it shows.
    fn beam_of(&self, seen: &EmitterHit<'_>) -> Throughput<M> {
        let beam = match seen.lamp.polarisation {
            None => self.beam,
            Some(light) => self.beam.polarised(light, self.ray.dir, true),
        };
        // What is met is in the picture (`lamp_at`).
        beam.shown((self.world, self.optics), seen.lamp, seen.place).unwrap_or(beam)
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
        let place = vertex.hit.point;
        let dark = || lamp.shown.is_some_and(|shown| world.slides[shown.slide].s(shown.local(place)).is_none());
        (luminance > 0.0 && !dark()).then(|| {
            let (towards, triangle) = (-self.ray.dir, site.triangle);
            let at = LampPoint { position: place, normal, triangle };
            let veiled = lamp.veiled(&at, towards);
            let glow = if lamp.texture().is_some() { lamp.glow(&at, towards) } else { veiled };
            EmitterHit { lamp, index, cos, luminance, glow, veiled, place, triangle }
        })
    }
}
