//! Photon mapping: each pass emits photons, stores them at broad scatterers, and gathers them at the first broad
//! scatterer that the eye sees through specular faces, or at the next one by final gathering. The radius shrinks with the
//! pass number so that the mean over passes converges (Knaus and Zwicker, "Progressive photon mapping: a probabilistic approach", 2011).

pub mod final_gather;
mod gather;
mod gather_samples;
mod record;
mod tuning;
pub mod visible_receivers;

use super::ShouldStop;
use super::emission::{Emission, Shots, Starts};
use super::ledger::{Ledger, cost};
use super::ownership::{Ownership, Reach};
use super::photon_map::Photon;
use crate::manifold::eye_table::EyeTable;
use crate::manifold::receiver::Receivers;
use eyebox_base::ids::GroupId;
use eyebox_base::parallel;
use eyebox_base::path::Trail;
use eyebox_base::rng::{Rng, Stream};
use eyebox_film::accumulate::Film;
use eyebox_film::guide::{Guide, Point, Sample};
use eyebox_film::plan::Radii;
use eyebox_world::World;
use eyebox_world::geometry::Site;
use eyebox_world::mode::{LaneArray, Mode};
use eyebox_world::optics::Optics;
use eyebox_world::surface::Surface;
use eyebox_world::wavelengths::SharedLight;
use gather::Maps;
pub use gather::on_side;
use gather_samples::GatherSamples;
use glam::DVec3;
use record::PhotonRecord;
use std::marker::PhantomData;
use std::sync::{Arc, OnceLock};
use tuning::photon::{ALPHA, ENOUGH, ENOUGH_AT_LEAST};
use visible_receivers::VisibleReceivers;

/// What kernels have in pass `pass` (from 0) of the area that they have in pass 0.
fn area_of_pass(pass: u64) -> f64 {
    ((pass + 1) as f64).powf(ALPHA - 1.0)
}

/// Radii of pass `pass` when pass 0 has `first`.
pub fn radii_of_pass(first: Radii, pass: u64) -> Radii {
    first.scaled(area_of_pass(pass).sqrt())
}

fn asks_for_final_gather(surface: &Surface) -> bool {
    matches!(surface, Surface::Scatter(scatter) if scatter.asks_for_final_gather())
}

/// The photon estimator, ready to run passes.
pub struct PhotonMapper<'w, M: Mode> {
    mode: PhantomData<M>,
    world: &'w World,
    route: Ownership,
    emission: Emission,
    reach_eye: Reach,
    photons: u64,
    first_radii_m: Radii,
    /// Photons part at interfaces.
    part: bool,
    /// A face asks for final gathering.
    final_gather: bool,
    /// What of the paths is not ours.
    screens: Arc<Receivers<M>>,
    /// Where the eye's rays land.
    glances: Option<Arc<EyeTable<M>>>,
    /// What the middles of pixels see, once photons are crowded.
    middles: OnceLock<GatherSamples>,
    /// What the wavelengths of passes make of light.
    shared: Option<SharedLight<'w>>,
    seed: u64,
    starts: Starts,
}

/// A path as a pilot sees it.
#[derive(Debug, Clone)]
pub struct Landed {
    /// Index in the emission's lamps, and the point of its cube.
    pub lamp: usize,
    pub x: Point,
    pub landings: Vec<Landing>,
}

/// A photon as a pilot sees it.
#[derive(Debug, Clone, Copy)]
pub struct Landing {
    pub site: Site,
    /// Recentred world, m.
    pub position: DVec3,
    /// Unit propagation direction, and whether it came from outside the part.
    pub dir: DVec3,
    pub outside: bool,
    /// With the slides open.
    pub lumens: f64,
    /// Specular connection has its path.
    pub connected: bool,
    /// From the lamp up to, but without, this vertex.
    pub trail: Trail,
}

impl Landing {
    fn of<M: Mode>(photon: &Photon<M>) -> Landing {
        Landing {
            site: photon.site,
            position: photon.position,
            dir: photon.dir,
            outside: photon.outside,
            lumens: photon.flux.as_slice().iter().map(|light| light.open()).sum(),
            connected: photon.claim.here(),
            trail: photon.trail,
        }
    }
}

impl<'w, M: Mode> PhotonMapper<'w, M> {
    #[allow(clippy::too_many_arguments)] // what a plan says of photons
    pub fn new(
        world: &'w World,
        route: Ownership,
        groups: usize,
        photons: u64,
        guide: Option<&Guide>,
        first_radii_m: Radii,
        screens: Arc<Receivers<M>>,
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
            final_gather: world.faces.iter().flatten().any(|face| asks_for_final_gather(&face.surface)),
            screens,
            glances: None,
            middles: OnceLock::new(),
            shared: SharedLight::new::<M>(world),
            seed,
            starts,
        }
    }

    /// The same with photons that part at interfaces and go both ways, or not.
    #[must_use]
    pub fn parting(self, part: bool) -> Self {
        PhotonMapper { part, ..self }
    }

    /// The same with tables that tell where rays from the eye land: not on faces that paths go on from, for what a table
    /// says may weigh less than nothing.
    #[must_use]
    pub fn glancing(self, glances: Option<Arc<EyeTable<M>>>) -> Self {
        let goes_on =
            |(part, face): (u32, u32)| asks_for_final_gather(&self.world.faces[part as usize][face as usize].surface);
        let glances = glances.filter(|glances| !glances.faces().any(goes_on));
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
        if let Some(shared) = &self.shared {
            film.know((first..first + count).map(|pass| (pass, shared.of_pass(1, self.seed, pass))));
        }
        for pass in first..first + count {
            let optics = M::optics(self.world, self.seed, pass);
            let screens = self.screens.of_pass(pass, self.world, &optics);
            let radii = radii_of_pass(self.first_radii_m, pass);
            let (photons, ledger) = self.emit((pass, &optics), (&screens, radii.caustic));
            let emitted = ledger.work;
            total.merge(&ledger);
            // Light of which connection leaves little may be soft.
            let enough = if self.part { f64::INFINITY } else { (ENOUGH * area_of_pass(pass)).max(ENOUGH_AT_LEAST) };
            let mut rng = Rng::new(self.seed, Stream::PhotonBoxes, pass, 0);
            let shift = DVec3::new(rng.uniform(), rng.uniform(), rng.uniform());
            let maps = Maps::new((photons, screens), radii, (enough, shift), self.final_gather);
            let gathered = self.gather(film, (pass, &optics), &maps);
            total.work += gathered;
            film.add_work(pass, emitted + gathered);
            film.close(pass, 1);
        }
        total
    }

    /// The photons of a pass. `reach_m`: how far from where they land those straight from specular faces are gathered.
    pub fn emit(
        &self,
        (pass, optics): (u64, &Optics<M>),
        (screens, reach_m): (&Receivers<M>, f64),
    ) -> (Vec<Photon<M>>, Ledger) {
        let shots = self.shots(Stream::PhotonEmission, pass);
        let of_chunk = |chunk: usize| {
            let mut stored = PhotonRecord::new(screens, reach_m, self.part);
            let mut ledger = self.emission.chunk((self.world, optics), shots, chunk as u64, &mut stored);
            ledger.work += stored.work + cost::STORED * stored.photons.len() as u64;
            (stored.photons, ledger)
        };
        let done: Vec<(Vec<Photon<M>>, Ledger)> = parallel::map(Shots::chunks(self.photons) as usize, &of_chunk);
        let mut all = Vec::with_capacity(done.iter().map(|(photons, _)| photons.len()).sum());
        let mut total = Ledger::new(self.world.solids.len());
        for (photons, ledger) in done {
            all.extend(photons);
            total.merge(&ledger);
        }
        (all, total)
    }

    /// Traces one pass for learning: the starts of paths, with the flux that they store where the eye sees it, see
    /// [`Emission::probe`]. Once `stop` says true the rest is left out, and the result is worthless.
    pub fn probe(&self, pass: u64, seen: &VisibleReceivers, stop: &ShouldStop<'_>) -> Vec<Sample> {
        let optics = M::optics(self.world, self.seed, pass);
        let useful = |stored: &PhotonRecord<'_, M>| {
            let landings = stored.photons.iter().map(Landing::of).filter(|landing| seen.sees(landing));
            landings.map(|landing| landing.lumens).sum()
        };
        let shots = self.shots(Stream::Pilot, pass);
        let new = || PhotonRecord::new(&self.screens, 0.0, self.part);
        self.emission.probe((self.world, &optics), shots, stop, new, useful)
    }

    /// Traces one pass for a pilot: where the photons of each path land that has any. Once `stop` says true the rest is left
    /// out, and the result is worthless.
    pub fn landings(&self, pass: u64, stop: &ShouldStop<'_>) -> Vec<Landed> {
        let optics = M::optics(self.world, self.seed, pass);
        let new = || PhotonRecord::new(&self.screens, 0.0, self.part);
        self.emission.survey((self.world, &optics), self.shots(Stream::Pilot, pass), stop, new, |lamp, x, _, stored| {
            let landings: Vec<Landing> = stored.photons.iter().map(Landing::of).collect();
            (!landings.is_empty()).then_some(Landed { lamp, x, landings })
        })
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
}
