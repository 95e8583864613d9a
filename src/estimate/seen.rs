//! What the eye sees of broad scatterers, as a pilot from the eye finds it: where photons are gathered.

use super::ShouldStop;
use super::ledger::Ledger;
use super::photon_map::cell_of;
use super::walk::{Meeting, Met, SPLIT_FIRST_EVENTS, Travel, Walker};
use crate::base::rng::{Rng, Stream};
use crate::base::sobol::Sobol;
use crate::world::World;
use crate::world::geometry::{Ray, Site};
use crate::world::interior::Interior;
use crate::world::mode::{Mode, Mono};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::{BTreeSet, HashSet};

/// Rays from the eye.
const RAYS: u64 = 1 << 11;
/// Bounces off narrow lobes that a ray is followed for.
const MOST_EVENTS: u32 = 64;

/// Cells of the faces that the eye has met first among broad scatterers.
#[derive(Debug, Clone, PartialEq)]
pub struct Seen {
    cell_m: f64,
    cells: HashSet<(u32, u32, [i64; 3])>,
    /// What was met.
    points: Vec<(Site, DVec3)>,
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
        let points: Vec<_> = (0..RAYS).into_par_iter().flat_map_iter(one).collect();
        let cells = points.iter().map(|(site, point)| (site.part, site.face, cell_of(*point, cell_m))).collect();
        Seen { cell_m, cells, points }
    }

    /// Whether the eye sees something within half a cell of a point of a face.
    pub fn sees(&self, site: Site, point: DVec3) -> bool {
        (0..8).any(|corner| {
            let side = |bit: u32| if corner >> bit & 1 == 0 { -0.5 } else { 0.5 };
            let offset = DVec3::new(side(0), side(1), side(2)) * self.cell_m;
            self.cells.contains(&(site.part, site.face, cell_of(point + offset, self.cell_m)))
        })
    }

    /// Points that the eye sees, spread over the picture.
    pub fn points(&self) -> &[(Site, DVec3)] {
        &self.points
    }

    /// The faces that it sees, as (part, face).
    pub fn faces(&self) -> BTreeSet<(u32, u32)> {
        self.points.iter().map(|(site, _)| (site.part, site.face)).collect()
    }

    pub fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }
}

/// The first broad scatterers on a ray's way and on its branches.
fn follow(mut walker: Walker<'_, Mono>, found: &mut Vec<(Site, DVec3)>) {
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
            Meeting::Scatter(..) => {
                found.push((vertex.hit.site, vertex.hit.point));
                return;
            }
        }
    }
}
