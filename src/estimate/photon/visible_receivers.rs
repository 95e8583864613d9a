//! What the eye sees of broad scatterers, as a pilot from the eye finds it: where photons are gathered.

use super::tuning::visible_receivers::{MOST_EVENTS, RAYS};
use super::{Landing, final_gather, on_side};
use crate::ShouldStop;
use crate::ledger::Ledger;
use crate::photon_map::cell_of;
use crate::walk::{Meeting, Met, SPLIT_FIRST_EVENTS, Travel, Vertex, Walker};
use eyebox_base::parallel;
use eyebox_base::path::Trail;
use eyebox_base::rng::{Rng, Stream};
use eyebox_base::sobol::Sobol;
use eyebox_base::warp::Frame;
use eyebox_world::World;
use eyebox_world::geometry::{Ray, Site};
use eyebox_world::interior::Interior;
use eyebox_world::mode::{Mode, Mono};
use eyebox_world::scatter::{Look, Scatter, Sides};
use eyebox_world::surface::Surface;
use glam::DVec3;
use std::collections::{BTreeSet, HashMap};

/// By part, face and cell.
type Cells = HashMap<(u32, u32, [i64; 3]), usize>;

/// Cells of the faces that the eye has met first among broad scatterers, and next where the first asks for final gathering.
#[derive(Debug, Clone, PartialEq)]
pub struct VisibleReceivers {
    cell_m: f64,
    /// Of the first, and of the next. Each with one of the points in it.
    cells: [Cells; 2],
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
    sides: [f64; 2],
    /// What an ordinary material is here.
    look: Option<Look>,
    index: [f64; 2],
    /// From the eye to here.
    trail: Trail,
    /// Rays go on from here.
    goes_on: bool,
    /// Of what the first scatterer was sent by the eye, what is left here.
    share: f64,
}

impl Sighting {
    fn new(&Place { walker, vertex, scatter, frame }: &Place<'_, '_>, share: f64) -> Sighting {
        let all = walker.sides(vertex, scatter);
        let Sides { here, beyond, look } = all.of(0);
        Sighting {
            site: vertex.hit.site,
            point: vertex.hit.point,
            d_in: frame.to_local(walker.ray.dir),
            frame,
            outside: vertex.outside,
            sides: [here, beyond],
            look: look.copied(),
            index: [false, true].map(|through| walker.beyond(vertex, through, 0.0).0.as_slice()[0]),
            trail: walker.trail,
            goes_on: final_gather::goes_on(walker.trail, scatter.asks_for_final_gather()),
            share,
        }
    }

    /// Seen by another broad scatterer.
    pub fn is_second(&self) -> bool {
        self.trail.has_broad()
    }

    /// Whether what a photon brings here is gathered, or connected. Seen by another scatterer, what comes straight from the
    /// lamp is, too.
    pub fn takes(&self, landing: &Landing) -> bool {
        final_gather::gathers(self.goes_on, landing.trail) && (self.is_second() || !landing.trail.is_empty())
    }

    /// Whether light that scatterers have sent is gathered here.
    pub fn takes_scattered(&self) -> bool {
        !self.goes_on
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
        let [here, beyond] = self.sides;
        let sides = Sides { here, beyond, look: self.look.as_ref() };
        self.share * scatter.eval(self.d_in, d_out, sides) / self.index[usize::from(through)].powi(2)
    }
}

impl VisibleReceivers {
    /// `pixel_m`: the distance between what neighbouring pixels see, m. Once `stop` says true the rest is left out, and
    /// the result is worthless.
    pub fn look(world: &World, pixel_m: f64, stop: &ShouldStop<'_>) -> VisibleReceivers {
        let [width, height] = world.eye.size();
        // Wide enough that the rays leave no holes: 3 times their mean distance.
        let cell_m = 3.0 * pixel_m * ((width * height) as f64 / RAYS as f64).sqrt().max(1.0);
        let optics = Mono::<f64>::optics(world, 0, 0);
        let points = Sobol::new(0, Stream::Pilot, 2);
        let one = |ray: u64, found: &mut Vec<Sighting>| {
            if stop() {
                return;
            }
            let [x, y, a, b] = points.point(ray);
            let place = |x: f64, size: usize| ((x * size as f64) as usize).min(size - 1);
            let (origin, dir) = world.eye.ray(place(x, width), place(y, height), [0.5; 2], [a, b]);
            let rng = Rng::new(0, Stream::Pilot, 2, ray);
            let ray = Ray { origin, dir, from: None };
            let walker = Walker::new((world, &optics), Travel::FromEye, ray, 1.0, Interior::default(), rng);
            // What the ray brought to the first broad scatterer, if it has met it.
            follow(walker, None, &mut |place, first: &mut Option<f64>| {
                if place.scatter.is_narrow() {
                    return true;
                }
                let weight = place.walker.beam.weight();
                let sight = Sighting::new(&place, first.map_or(1.0, |first| weight / first));
                found.push(sight);
                *first = Some(weight);
                sight.goes_on
            });
        };
        let points: Vec<Sighting> = parallel::flat_map(RAYS, &one);
        let cell = |sight: &Sighting| (sight.site.part, sight.site.face, cell_of(sight.point, cell_m));
        let cells = [false, true].map(|second| {
            let of = points.iter().enumerate().filter(|(_, sight)| sight.is_second() == second);
            of.map(|(index, sight)| (cell(sight), index)).collect()
        });
        VisibleReceivers { cell_m, cells, points }
    }

    /// Whether a photon is gathered within half a cell of where it is.
    pub fn sees(&self, landing: &Landing) -> bool {
        let [first, second] = &self.cells;
        let takes = |sight: &Sighting| sight.takes(landing);
        !landing.connected && self.about(first, landing).any(takes) || self.about(second, landing).any(takes)
    }

    /// How bright the eye sees what a photon brings, for one lumen, by the points that it sees about there: first among
    /// broad scatterers, and by another one.
    pub fn brightness(&self, world: &World, landing: &Landing) -> [f64; 2] {
        self.cells.each_ref().map(|cells| {
            let (mut sum, mut count) = (0.0, 0);
            for sight in self.about(cells, landing) {
                sum += if sight.takes(landing) { sight.brightness(world, landing) } else { 0.0 };
                count += 1;
            }
            sum / f64::from(count.max(1))
        })
    }

    /// How bright the eye sees what a photon brings, and how much of that specular connection does not have.
    pub fn shown(&self, world: &World, landing: &Landing) -> (f64, f64) {
        let [first, second] = self.brightness(world, landing).map(|brightness| landing.lumens * brightness);
        (first + second, if landing.connected { second } else { first + second })
    }

    /// Points that the eye sees of the photon's face, of each cell within half a cell of the photon.
    fn about<'a>(&'a self, cells: &'a Cells, landing: &Landing) -> impl Iterator<Item = &'a Sighting> {
        let (site, point) = (landing.site, landing.position);
        (0..8).filter_map(move |corner| {
            let side = |bit: u32| if corner >> bit & 1 == 0 { -0.5 } else { 0.5 };
            let offset = DVec3::new(side(0), side(1), side(2)) * self.cell_m;
            let index = cells.get(&(site.part, site.face, cell_of(point + offset, self.cell_m)))?;
            self.points.get(*index)
        })
    }

    /// Points that the eye sees, spread over the picture.
    pub fn points(&self) -> &[Sighting] {
        &self.points
    }

    /// The faces that it sees first among broad scatterers, as (part, face).
    pub fn faces(&self) -> BTreeSet<(u32, u32)> {
        self.points.iter().filter(|sight| !sight.is_second()).map(|sight| (sight.site.part, sight.site.face)).collect()
    }

    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }
}

/// Where a path from the eye has met a scatterer.
pub(super) struct Place<'p, 'w> {
    pub walker: &'p Walker<'w, Mono>,
    pub vertex: &'p Vertex,
    pub scatter: &'w Scatter,
    frame: Frame,
}

/// Follows a ray over specular faces, and over the first ones its branches, too. At each scatterer `visit` says whether a
/// branch scatters there and goes on; `carried` is a branch's own.
pub(super) fn follow<'w, S: Copy>(
    mut walker: Walker<'w, Mono>,
    mut carried: S,
    visit: &mut impl FnMut(Place<'_, 'w>, &mut S) -> bool,
) {
    let mut ledger = Ledger::new(walker.world.solids.len());
    while walker.events < MOST_EVENTS {
        let Met::Face(vertex) = walker.advance(&mut ledger) else { return };
        if walker.events < SPLIT_FIRST_EVENTS
            && let Some(reflected) = walker.split(&vertex, 0.0, Walker::<Mono>::MOST_SPLITS, &mut ledger)
        {
            follow(reflected, carried, visit);
        }
        match walker.meet(&vertex, &mut ledger) {
            Meeting::Ended => return,
            Meeting::Went => {}
            Meeting::Scatter(scatter, frame) => {
                let goes_on = visit(Place { walker: &walker, vertex: &vertex, scatter, frame }, &mut carried);
                if !goes_on || walker.scatter(&vertex, scatter, &frame, &mut ledger).is_none() {
                    return;
                }
            }
        }
    }
}
