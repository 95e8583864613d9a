//! Photon mapping: each pass emits photons, stores them at broad scatterers, and gathers them at the first broad
//! scatterer that the eye sees through specular faces. The radius shrinks with the pass number so that the mean over
//! passes converges (Knaus and Zwicker, "Progressive photon mapping: a probabilistic approach", 2011).

use super::ShouldStop;
use super::emission::{Emission, Origin, Shots, Starts, Visitor};
use super::ledger::{Ledger, cost};
use super::manifold::screens::Screens;
use super::manifold::solve::Target;
use super::photon_map::{Photon, PhotonMap};
use super::pixel::Pixel;
use super::route::{Reach, Route};
use super::seen::Seen;
use super::walk::{Meeting, Met, SPLIT_FIRST_EVENTS, Travel, Vertex, Walker};
use crate::base::ids::GroupId;
use crate::base::lpe::Letter;
use crate::base::path::{Event, Trail};
use crate::base::rng::Stream;
use crate::film::accumulate::{Film, Light, Row};
use crate::film::guide::{Guide, Point, Sample};
use crate::film::plan::Radii;
use crate::world::World;
use crate::world::eye::Arrival;
use crate::world::geometry::{Hit, Site};
use crate::world::interior::Interior;
use crate::world::mode::{LaneArray, Mode, lanes, plane_of};
use crate::world::optics::Optics;
use crate::world::scatter::Scatter;
use glam::DVec3;
use rayon::prelude::*;
use std::marker::PhantomData;
use std::sync::Arc;

/// The squared radius falls as (pass + 1)^(α − 1): bias and variance of the mean both vanish for 0 < α < 1.
const ALPHA: f64 = 2.0 / 3.0;

/// Radii of pass `pass` (from 0) when pass 0 has `first`.
pub fn radii_of_pass(first: Radii, pass: u64) -> Radii {
    first.scaled(((pass + 1) as f64).powf((ALPHA - 1.0) / 2.0))
}

/// The photon estimator, ready to run passes.
pub struct PhotonMapper<'w, M: Mode> {
    mode: PhantomData<M>,
    world: &'w World,
    route: Route,
    emission: Emission,
    reach_eye: Reach,
    photons: u64,
    first_radii_m: Radii,
    /// What of the paths is not ours.
    screens: Arc<Screens<M>>,
    seed: u64,
    starts: Starts,
}

/// The photons of a pass.
struct Maps<M: Mode> {
    caustic: PhotonMap<M>,
    secondary: PhotonMap<M>,
}

impl<M: Mode> Maps<M> {
    fn new(photons: Vec<Photon<M>>, radii: Radii) -> Self {
        let (secondary, caustic) = photons.into_iter().partition(|photon| photon.trail.has_scatter());
        Maps { caustic: PhotonMap::new(caustic, radii.caustic), secondary: PhotonMap::new(secondary, radii.secondary) }
    }

    /// Calls `visit` with each photon near a vertex and the kernel's density there, 1/m².
    fn each(&self, world: &World, vertex: &Vertex, mut visit: impl FnMut(&Photon<M>, f64)) {
        let Hit { point, site, normal, .. } = vertex.hit;
        for map in [&self.caustic, &self.secondary] {
            // What of the kernel lies beside the face, or behind what stands on it, is made up for by the rest.
            let around = world.rims.around(site, point, normal, map.radius());
            map.gather(point, site, |photon, density| {
                if around.counts(photon.position) {
                    visit(photon, density / around.share);
                }
            });
        }
    }
}

/// A photon as a pilot sees it.
#[derive(Debug, Clone, Copy)]
pub struct Landing {
    pub site: Site,
    /// Recentred world, m.
    pub position: DVec3,
    /// With the slides open.
    pub lumens: f64,
    /// Specular connection has its path.
    pub connected: bool,
    /// A scatterer has sent it.
    pub scattered: bool,
}

/// What paths leave at broad scatterers.
struct Stored<'s, M: Mode> {
    photons: Vec<Photon<M>>,
    screens: &'s Screens<M>,
    /// Counted work of asking what is connected.
    work: u64,
}

impl<'s, M: Mode> Stored<'s, M> {
    fn new(screens: &'s Screens<M>) -> Self {
        Stored { photons: Vec::new(), screens, work: 0 }
    }

    /// Whether the path up to here is one that specular connection returns for its ends.
    fn is_connected(&mut self, walker: &Walker<'_, M>, from: Origin, vertex: &Vertex) -> bool {
        let (Some(chain), Some((lamp, point, normal))) = (walker.chain(), from.face) else { return false };
        !walker.trail.has_scatter() && !walker.trail.is_empty() && {
            let target = Target::new(point, normal);
            let arrives = (vertex.hit.point, vertex.hit.site, walker.ray.dir);
            self.screens.owns((walker.world, walker.optics), chain, (lamp, &target), arrives, &mut self.work)
        }
    }
}

impl<M: Mode> Visitor<M> for Stored<'_, M> {
    fn records(&self) -> bool {
        !self.screens.is_empty()
    }

    /// What connection leaves comes by faint reflections: photons of that kind should be many and faint, not few and bright.
    fn least_chance(&self) -> f64 {
        const OF_THE_REST: f64 = 0.1;
        if self.screens.is_empty() { 0.0 } else { OF_THE_REST }
    }

    fn split_from(&self, _: &Walker<'_, M>) -> Option<f64> {
        None
    }

    fn pupil(&mut self, _: &Walker<'_, M>, _: Origin, _: &Arrival) {}

    fn scatterer(&mut self, walker: &Walker<'_, M>, from: Origin, vertex: &Vertex, scatter: &Scatter) {
        if !scatter.is_narrow() {
            let connected = self.is_connected(walker, from, vertex);
            let (flux, alone) = walker.beam.stored();
            self.photons.push(Photon {
                position: vertex.hit.point,
                dir: walker.ray.dir,
                flux,
                alone,
                group: from.group,
                trail: walker.trail,
                told: walker.told,
                connected,
                site: vertex.hit.site,
                outside: vertex.outside,
            });
        }
    }
}

/// Where a photon came from, local to the point that gathers it, on the side of the face at which it arrived. On a
/// curved face the two normals differ: what grazes the face at the photon may be below the horizon here, and without it
/// a concave wall of radius R loses the share r²/12R² of its light.
pub fn on_side(dir: DVec3, through: bool) -> DVec3 {
    DVec3::new(dir.x, dir.y, if through { -dir.z.abs() } else { dir.z.abs() })
}

impl<'w, M: Mode> PhotonMapper<'w, M> {
    #[allow(clippy::too_many_arguments)] // what a plan says of photons
    pub fn new(
        world: &'w World,
        route: Route,
        groups: usize,
        photons: u64,
        guide: Option<&Guide>,
        first_radii_m: Radii,
        screens: Arc<Screens<M>>,
        seed: u64,
    ) -> Self {
        let emission = Emission::new(world, &route, groups, guide);
        let reach_eye = Reach::from_eye(&route);
        let starts = Starts::OfPass;
        PhotonMapper {
            mode: PhantomData,
            world,
            route,
            emission,
            reach_eye,
            photons,
            first_radii_m,
            screens,
            seed,
            starts,
        }
    }

    /// The same with other numbers for the photons' paths to start with.
    #[must_use]
    pub fn starting(self, starts: Starts) -> Self {
        PhotonMapper { starts, ..self }
    }

    /// Adds passes `first .. first + count` to the film. Returns the ledger of the photons' side.
    pub fn run(&self, film: &mut Film, first: u64, count: u64) -> Ledger {
        let mut total = Ledger::new(self.world.solids.len());
        for pass in first..first + count {
            let optics = M::optics(self.world, self.seed, pass);
            let screens = self.screens.of_pass(self.world, &optics);
            let (photons, ledger) = self.emit(self.shots(Stream::PhotonEmission, pass), &optics, &screens);
            total.merge(&ledger);
            let maps = Maps::new(photons, radii_of_pass(self.first_radii_m, pass));
            total.work += self.gather(film, (pass, &optics), &maps);
            film.passes += 1;
        }
        total
    }

    fn emit(&self, shots: Shots, optics: &Optics<M>, screens: &Screens<M>) -> (Vec<Photon<M>>, Ledger) {
        let done: Vec<(Vec<Photon<M>>, Ledger)> = (0..Shots::chunks(self.photons))
            .into_par_iter()
            .map(|chunk| {
                let mut stored = Stored::new(screens);
                let mut ledger = self.emission.chunk((self.world, optics), shots, chunk, &mut stored);
                ledger.work += stored.work + cost::STORED * stored.photons.len() as u64;
                (stored.photons, ledger)
            })
            .collect();
        let mut all = Vec::with_capacity(done.iter().map(|(photons, _)| photons.len()).sum());
        let mut total = Ledger::new(self.world.solids.len());
        for (photons, ledger) in done {
            all.extend(photons);
            total.merge(&ledger);
        }
        (all, total)
    }

    /// Traces one pass for learning: the starts of paths, with the flux that they store where the eye sees it and that did
    /// not come straight from the lamp, see [`Emission::probe`]. Once `stop` says true the rest is left out, and the result
    /// is worthless.
    pub fn probe(&self, pass: u64, seen: &Seen, stop: &ShouldStop<'_>) -> Vec<Sample> {
        let optics = M::optics(self.world, self.seed, pass);
        let open = |photon: &Photon<M>| -> f64 { photon.flux.as_slice().iter().map(|light| light.open()).sum() };
        let counts = |photon: &&Photon<M>| {
            !photon.trail.is_empty() && !photon.connected && seen.sees(photon.site, photon.position)
        };
        let useful = |stored: &Stored<'_, M>| stored.photons.iter().filter(counts).map(open).sum();
        let shots = self.shots(Stream::Pilot, pass);
        let new = || Stored::new(&self.screens);
        self.emission.probe((self.world, &optics), shots, stop, new, useful)
    }

    /// Traces one pass for a pilot: where photons land that did not come straight from the lamp.
    pub fn landings(&self, pass: u64) -> Vec<Landing> {
        let optics = M::optics(self.world, self.seed, pass);
        let (photons, _) = self.emit(self.shots(Stream::Pilot, pass), &optics, &self.screens);
        let landed = photons.iter().filter(|photon| !photon.trail.is_empty()).map(|photon| Landing {
            site: photon.site,
            position: photon.position,
            lumens: photon.flux.as_slice().iter().map(|light| light.open()).sum(),
            connected: photon.connected,
            scattered: photon.trail.has_scatter(),
        });
        landed.collect()
    }

    /// [`Emission::density`].
    pub fn density(&self, lamp: usize, x: &Point) -> f64 {
        self.emission.density(lamp, x)
    }

    /// Flux of each traced lamp, lm.
    pub fn flux(&self) -> &[f64] {
        self.emission.flux()
    }

    /// The light group of a traced lamp.
    pub fn group_of(&self, lamp: usize) -> GroupId {
        self.emission.group_of(self.world, lamp)
    }

    fn shots(&self, stream: Stream, pass: u64) -> Shots {
        Shots { seed: self.seed, stream, pass, paths: self.photons, starts: self.starts }
    }

    /// Returns the counted work.
    fn gather(&self, film: &mut Film, (pass, optics): (u64, &Optics<M>), maps: &Maps<M>) -> u64 {
        let width = film.width;
        let mut rows: Vec<_> = film.rows().collect();
        let of_row = |(y, row): &mut (usize, Row<'_>)| {
            let mut light = vec![Light::default(); self.route.planes.len() * M::COMPONENTS];
            let mut ledger = Ledger::new(self.world.solids.len());
            for x in 0..width {
                light.fill(Light::default());
                let pixel = Pixel::new((x, *y), width, pass);
                let rng = pixel.rng(self.seed, Stream::PhotonGather);
                let ray = pixel.ray(&self.world.eye, self.seed, Stream::PhotonGather);
                let walker = Walker::new((self.world, optics), Travel::FromEye, ray, 1.0, Interior::default(), rng);
                self.eye_path(walker, maps, &mut light, &mut ledger);
                ledger.work += cost::KEPT;
                row.add_pass(x, &light);
            }
            ledger.work
        };
        rows.par_iter_mut().map(of_row).sum()
    }

    fn eye_path(&self, mut walker: Walker<'_, M>, maps: &Maps<M>, out: &mut [Light], ledger: &mut Ledger) {
        loop {
            let Met::Face(vertex) = walker.advance(ledger) else { return };
            let other = if walker.events < SPLIT_FIRST_EVENTS {
                walker.split(&vertex, 0.0, Walker::<M>::MOST_SPLITS, ledger)
            } else {
                walker.spare(&vertex, 1.0, ledger)
            };
            if let Some(reflected) = other {
                self.eye_path(reflected, maps, out, ledger);
            }
            match walker.meet(&vertex, ledger) {
                Meeting::Ended => return,
                Meeting::Went => {}
                Meeting::Scatter(scatter, frame) if scatter.is_narrow() => {
                    if walker.scatter(&vertex, scatter, &frame, ledger).is_none() {
                        return;
                    }
                }
                Meeting::Scatter(scatter, frame) => {
                    let d_in = frame.to_local(walker.ray.dir);
                    let sides = walker.sides(&vertex, scatter);
                    let visit = |photon: &Photon<M>, density: f64| {
                        ledger.work += cost::GATHERED;
                        // Of what connection has, the path over one scatterer is not ours.
                        if photon.connected && !walker.trail.has_scatter() {
                            return;
                        }
                        let trail = Trail::join(walker.trail, Event::Diffuse, photon.trail);
                        let Some(share) = self.route.from_eye(photon.group, trail) else { return };
                        let through = photon.outside != vertex.outside;
                        let d_out = on_side(frame.to_local(-photon.dir), through);
                        let (index, _) = walker.beyond(&vertex, through, 0.0);
                        let (values, alone) = sides.eval(scatter, d_in, d_out);
                        if values.as_slice().iter().all(|value| *value == 0.0) {
                            return;
                        }
                        let plane = self.route.plane(share, |sieve| {
                            sieve.takes(sieve.after(walker.told, Letter::of(Event::Diffuse, through)), photon.told)
                        });
                        let factors = lanes::<M, _>(|lane| values[lane] * density / (index[lane] * index[lane]));
                        let out = plane_of::<M>(out, plane);
                        walker.beam.join(walker.optics, out, (&photon.flux, photon.alone || alone), &factors);
                    };
                    maps.each(self.world, &vertex, visit);
                    return;
                }
            }
            if !self.reach_eye.allows(walker.trail) {
                return;
            }
        }
    }
}
