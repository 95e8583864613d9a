//! What the eye sees of broad scatterers, as a pilot from the eye finds it: where photons are gathered.

use super::ShouldStop;
use super::ledger::Ledger;
use super::photon::{Landing, on_side};
use super::photon_map::cell_of;
use super::walk::{Meeting, Met, SPLIT_FIRST_EVENTS, Travel, Vertex, Walker};
use crate::base::rng::{Rng, Stream};
use crate::base::sobol::Sobol;
use crate::base::warp::Frame;
use crate::world::World;
use crate::world::geometry::{Ray, Site};
use crate::world::interior::Interior;
use crate::world::mode::{Mode, Mono};
use crate::world::scatter::{Scatter, Sides};
use crate::world::surface::Surface;
use glam::DVec3;
use rayon::prelude::*;
use std::collections::{BTreeSet, HashMap};

/// Rays from the eye.
const RAYS: u64 = 1 << 11;
/// Bounces off narrow lobes that a ray is followed for.
const MOST_EVENTS: u32 = 64;

/// Cells of the faces that the eye has met first among broad scatterers.
#[derive(Debug, Clone, PartialEq)]
pub struct Seen {
    cell_m: f64,
    /// Each with one of the points in it.
    cells: HashMap<(u32, u32, [i64; 3]), usize>,
    /// What was met.
    points: Vec<Sighting>,
}

/// A point of a broad scatterer as a ray from the eye has met it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sighting {
    pub site: Site,
    /// Recentred world, m.
    pub point: DVec3,
    /// Of the face on the ray's side, and the ray's direction in it.
    frame: Frame,
    d_in: DVec3,
    /// Whether the ray came from outside the part.
    outside: bool,
    /// Refractive indices about the face; and on the side of the light for light from the ray's side, and from beyond.
    sides: Sides,
    index: [f64; 2],
}

impl Sighting {
    fn new(walker: &Walker<'_, Mono>, vertex: &Vertex, scatter: &Scatter, frame: Frame) -> Sighting {
        Sighting {
            site: vertex.hit.site,
            point: vertex.hit.point,
            d_in: frame.to_local(walker.ray.dir),
            frame,
            outside: vertex.outside,
            sides: walker.sides(vertex, scatter).of(0),
            index: [false, true].map(|through| walker.beyond(vertex, through, 0.0).0.as_slice()[0]),
        }
    }

    /// Luminance that the eye sees here per illuminance of light that arrives as that of a photon, 1/sr.
    fn brightness(&self, world: &World, landing: &Landing) -> f64 {
        let Some(face) = world.faces.get(self.site.part as usize).and_then(|faces| faces.get(self.site.face as usize))
        else {
            return 0.0;
        };
        let Surface::Scatter(scatter) = &face.surface else { return 0.0 };
        let through = landing.outside != self.outside;
        let d_out = on_side(self.frame.to_local(-landing.dir), through);
        scatter.eval(self.d_in, d_out, self.sides) / self.index[usize::from(through)].powi(2)
    }
}

impl Seen {
    /// `pixel_m`: the distance between what neighbouring pixels see, m. Once `stop` says true the rest is left out, and
    /// the result is worthless.
    pub fn look(world: &World, pixel_m: f64, stop: &ShouldStop<'_>) -> Seen {
        let [width, height] = world.eye.size();
        // Wide enough that the rays leave no holes: 3 times their mean distance.
        let cell_m = 3.0 * pixel_m * ((width * height) as f64 / RAYS as f64).sqrt().max(1.0);
        let optics = Mono::<f64>::optics(world, 0, 0);
        let points = Sobol::new(0, Stream::Pilot, 2);
        let one = |ray: u64| {
            let mut found = Vec::new();
            if stop() {
                return found;
            }
            let [x, y, a, b] = points.point(ray);
            let place = |x: f64, size: usize| ((x * size as f64) as usize).min(size - 1);
            let (origin, dir) = world.eye.ray(place(x, width), place(y, height), [0.5; 2], [a, b]);
            let rng = Rng::new(0, Stream::Pilot, 2, ray);
            let ray = Ray { origin, dir, from: None };
            let walker = Walker::new((world, &optics), Travel::FromEye, ray, 1.0, Interior::default(), rng);
            follow(walker, &mut found);
            found
        };
        let points: Vec<Sighting> = (0..RAYS).into_par_iter().flat_map_iter(one).collect();
        let cell = |sight: &Sighting| (sight.site.part, sight.site.face, cell_of(sight.point, cell_m));
        let cells = points.iter().enumerate().map(|(index, sight)| (cell(sight), index)).collect();
        Seen { cell_m, cells, points }
    }

    /// Whether the eye sees something within half a cell of a point of a face.
    pub fn sees(&self, site: Site, point: DVec3) -> bool {
        self.about(site, point).next().is_some()
    }

    /// How bright the eye sees what a photon brings, for one lumen, by the points that it sees about there.
    pub fn brightness(&self, world: &World, landing: &Landing) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for sight in self.about(landing.site, landing.position) {
            sum += sight.brightness(world, landing);
            count += 1;
        }
        sum / f64::from(count.max(1))
    }

    /// Points that the eye sees of a face, of each cell within half a cell of a place.
    fn about(&self, site: Site, point: DVec3) -> impl Iterator<Item = &Sighting> {
        (0..8).filter_map(move |corner| {
            let side = |bit: u32| if corner >> bit & 1 == 0 { -0.5 } else { 0.5 };
            let offset = DVec3::new(side(0), side(1), side(2)) * self.cell_m;
            let index = self.cells.get(&(site.part, site.face, cell_of(point + offset, self.cell_m)))?;
            self.points.get(*index)
        })
    }

    /// Points that the eye sees, spread over the picture.
    pub fn points(&self) -> &[Sighting] {
        &self.points
    }

    /// The faces that it sees, as (part, face).
    pub fn faces(&self) -> BTreeSet<(u32, u32)> {
        self.points.iter().map(|sight| (sight.site.part, sight.site.face)).collect()
    }

    pub fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }
}

/// The first broad scatterers on a ray's way and on its branches.
fn follow(mut walker: Walker<'_, Mono>, found: &mut Vec<Sighting>) {
    let mut ledger = Ledger::new(walker.world.solids.len());
    while walker.events < MOST_EVENTS {
        let Met::Face(vertex) = walker.advance(&mut ledger) else { return };
        if walker.events < SPLIT_FIRST_EVENTS
            && let Some(reflected) = walker.split(&vertex, 0.0, Walker::<Mono>::MOST_SPLITS, &mut ledger)
        {
            follow(reflected, found);
        }
        match walker.meet(&vertex, &mut ledger) {
            Meeting::Ended => return,
            Meeting::Went => {}
            Meeting::Scatter(scatter, frame) if scatter.is_narrow() => {
                if walker.scatter(&vertex, scatter, &frame, &mut ledger).is_none() {
                    return;
                }
            }
            Meeting::Scatter(scatter, frame) => {
                found.push(Sighting::new(&walker, &vertex, scatter, frame));
                return;
            }
        }
    }
}
