//! Photon mapping: each pass emits photons, stores them at broad scatterers, and gathers them at the first broad
//! scatterer that the eye sees through specular faces. The radius shrinks with the pass number so that the mean over
//! passes converges (Knaus and Zwicker, "Progressive photon mapping: a probabilistic approach", 2011).

use super::ShouldStop;
use super::both::Both;
use super::emission::{Emission, Origin, Shots, Starts, Visitor};
use super::ledger::{Ledger, cost};
use super::manifold::glances::{Glanced, Glances, Rest};
use super::manifold::screens::Screens;
use super::manifold::solve::Target;
use super::photon_map::{Photon, PhotonMap};
use super::pixel::Pixel;
use super::route::{Reach, Route};
use super::seen::Seen;
use super::turn::Faint;
use super::walk::{Meeting, Met, SPLIT_FIRST_EVENTS, Travel, Vertex, Walker};
use crate::base::ids::GroupId;
use crate::base::lpe::Letter;
use crate::base::path::{Event, Trail};
use crate::base::rng::Stream;
use crate::base::warp::{Frame, disk};
use crate::film::accumulate::{Film, Light, Row};
use crate::film::guide::{Guide, Point, Sample};
use crate::film::plan::Radii;
use crate::world::World;
use crate::world::eye::Arrival;
use crate::world::geometry::{Hit, Ray, Site};
use crate::world::interior::Interior;
use crate::world::mode::{LaneArray, Mode, lanes, plane_of};
use crate::world::optics::Optics;
use crate::world::scatter::Scatter;
use crate::world::surface::Surface;
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
    /// Photons part at interfaces.
    part: bool,
    /// What of the paths is not ours.
    screens: Arc<Screens<M>>,
    /// Where the eye's rays land.
    glances: Option<Arc<Glances<M>>>,
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

/// Photons of which only a little is left by connection part at every interface: a lens's ghost has some 1e-4 of the light,
/// and out of ten thousand photons that choose one way thirty would make a way through two reflections. Those that part
/// bring all ghosts each.
mod parting {
    /// Share of what a photon started with that both ways on must have: two reflections by coated lenses have 1e-4, three
    /// 1e-6.
    pub const LEAST: f64 = 1e-5;
    /// Interfaces at which a photon and all its branches may part.
    pub const MOST: u32 = 1024;
    /// Paths by which a whole one goes on from the first scatterer.
    pub const COPIES: f64 = 8.0;
}

/// What paths leave at broad scatterers.
struct Stored<'s, M: Mode> {
    photons: Vec<Photon<M>>,
    screens: &'s Screens<M>,
    /// Where photons part, if they do.
    parts: Option<Both>,
    /// Counted work of asking what is connected.
    work: u64,
}

impl<'s, M: Mode> Stored<'s, M> {
    fn new(screens: &'s Screens<M>, part: bool) -> Self {
        let parts = part.then(|| Both::new(parting::LEAST, parting::MOST));
        Stored { photons: Vec::new(), screens, parts, work: 0 }
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
        if self.screens.is_empty() || self.parts.is_some() { 0.0 } else { OF_THE_REST }
    }

    fn split_from(&self, walker: &Walker<'_, M>) -> Option<f64> {
        self.parts.as_ref()?.from(walker)
    }

    fn most_splits(&self) -> u8 {
        if self.parts.is_some() { u8::MAX } else { Walker::<M>::MOST_SPLITS }
    }

    /// A branch has its share for good.
    fn worth(&self) -> f64 {
        if self.parts.is_some() { parting::LEAST } else { Walker::<M>::WORTH }
    }

    fn copies(&self, walker: &Walker<'_, M>) -> f64 {
        if self.parts.is_some() && !walker.trail.has_scatter() { parting::COPIES * walker.share() } else { 1.0 }
    }

    fn end(&mut self, _: u64) {
        if let Some(parts) = &self.parts {
            parts.next();
        }
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
            part: false,
            screens,
            glances: None,
            seed,
            starts,
        }
    }

    /// The same with photons that part at interfaces and go both ways, or not.
    #[must_use]
    pub fn parting(self, part: bool) -> Self {
        PhotonMapper { part, ..self }
    }

    /// The same with tables that tell where rays from the eye land.
    #[must_use]
    pub fn glancing(self, glances: Option<Arc<Glances<M>>>) -> Self {
        PhotonMapper { glances, ..self }
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
                let mut stored = Stored::new(screens, self.part);
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
        let new = || Stored::new(&self.screens, self.part);
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
                self.pixel((pixel, optics), maps, &mut light, &mut ledger);
                ledger.work += cost::KEPT;
                row.add_pass(x, &light);
            }
            ledger.work
        };
        rows.par_iter_mut().map(of_row).sum()
    }

    /// Gathers what is seen in a pixel. What tables know of where its ray lands is read there, as specular connection does,
    /// and now and then the ray itself makes good what they have wrong.
    fn pixel(&self, (pixel, optics): (Pixel, &Optics<M>), maps: &Maps<M>, out: &mut [Light], ledger: &mut Ledger) {
        let world = self.world;
        let mut rng = pixel.rng(self.seed, Stream::PhotonGather);
        let [x, y, u, v] = pixel.start(self.seed, Stream::PhotonGather, pixel.pass);
        let film = world.eye.film_of(pixel.x, pixel.y, [x, y]);
        let pupil = disk([u, v]) * world.eye.pupil_radius_m();
        let read = |walker: &mut Walker<'_, M>, vertex: &Vertex, _: f64| {
            let Surface::Scatter(scatter) = &walker.face(vertex).surface else { return };
            ledger.work += cost::STEP;
            self.gather_at(walker, (vertex, scatter, &Frame::about(vertex.normal)), maps, out, ledger);
        };
        let rest = self.glances.as_ref().map_or(Some(Rest::ALL), |glances| {
            let of = if self.part { Glanced::Little } else { Glanced::All };
            glances.read((world, optics), (film, pupil), (1.0, of), &mut rng, read)
        });
        let Some(rest) = rest else { return };
        let (origin, (_, dir), ..) = world.eye.ray_of(film, pupil);
        let ray = Ray { origin, dir, from: None };
        let walker = Walker::new((world, optics), Travel::FromEye, ray, 1.0 / rest.share, Interior::default(), rng);
        self.eye_path(if rest.leaves_out() { walker.recording() } else { walker }, rest, maps, out, ledger);
    }

    /// Gathers along a ray and its branches. `rest`: what of it tables have not read.
    fn eye_path(&self, mut walker: Walker<'_, M>, rest: Rest, maps: &Maps<M>, out: &mut [Light], ledger: &mut Ledger) {
        let faint = Faint { whole: 1.0 / rest.share, often: 1.0 / rest.share };
        loop {
            let Met::Face(vertex) = walker.advance(ledger) else { return };
            let other = if walker.events < SPLIT_FIRST_EVENTS {
                walker.split(&vertex, 0.0, Walker::<M>::MOST_SPLITS, ledger)
            } else {
                walker.spare(&vertex, faint, ledger)
            };
            if let Some(reflected) = other {
                self.eye_path(reflected, rest, maps, out, ledger);
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
                    if !self.glances.as_ref().is_some_and(|glances| glances.has_read(rest, &walker, &vertex)) {
                        self.gather_at(&walker, (&vertex, scatter, &frame), maps, out, ledger);
                    }
                    return;
                }
            }
            if !self.reach_eye.allows(walker.trail) {
                return;
            }
        }
    }

    /// Adds what photons bring to where a path has met a scatterer.
    fn gather_at(
        &self,
        walker: &Walker<'_, M>,
        (vertex, scatter, frame): (&Vertex, &Scatter, &Frame),
        maps: &Maps<M>,
        out: &mut [Light],
        ledger: &mut Ledger,
    ) {
        let d_in = frame.to_local(walker.ray.dir);
        let sides = walker.sides(vertex, scatter);
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
            let (index, _) = walker.beyond(vertex, through, 0.0);
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
        maps.each(self.world, vertex, visit);
    }
}
