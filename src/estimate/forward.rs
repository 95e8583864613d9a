//! Light tracing: paths start on the lamps with equal shares of flux and *arrive* at the pupil by themselves. No shadow
//! ray is sent to the eye, since no lens would let one through.

use super::ShouldStop;
use super::ledger::Ledger;
use super::route::{Reach, Route};
use super::walk::{Meeting, Met, Travel, Walker};
use crate::base::ids::GroupId;
use crate::base::path::Trail;
use crate::base::rng::{Rng, Stream};
use crate::film::accumulate::{Film, Light};
use crate::film::guide::Guide;
use crate::world::World;
use crate::world::geometry::{Ray, Site};
use rayon::prelude::*;

/// Lamp paths that one thread traces before it hands its splats over; the order of hand-overs is fixed.
const CHUNK: u64 = 1 << 13;

/// A lamp path is split where reflection and transmission both carry this share: at combiners, not at lenses.
const SPLIT_FROM: f64 = 0.1;
/// Behind such a face the ghost from the next one counts too.
const SPLIT_AGAIN_FROM: f64 = 0.005;

/// Starts paths on the lamps whose light an estimator traces: by flux and intensity, or as a guide says.
pub struct Emission {
    /// Index into the world's lamps, and flux in lm.
    lamps: Vec<usize>,
    flux: Vec<f64>,
    guide: Guide,
    /// Per light group: how far a trail from it can still lead to paths that are owned.
    pub reach: Vec<Reach>,
}

/// A path that starts on a lamp.
pub struct Started<'w> {
    pub walker: Walker<'w>,
    pub group: GroupId,
    /// Index in the emission's lamps and point of the square of directions, for learning.
    pub lamp: usize,
    pub uv: [f64; 2],
    /// lm that the path carries; its mean over paths is the lamps' flux over their number.
    pub flux_lm: f64,
}

impl Emission {
    pub fn new(world: &World, route: &Route, groups: usize, guide: Option<&Guide>) -> Self {
        let reach: Vec<Reach> = (0..groups).map(|g| Reach::from_lamp(route, GroupId::from_index(g))).collect();
        let traced =
            |lamp: &crate::world::lamp::Lamp| lamp.flux_lm > 0.0 && reach[lamp.group.index()].allows(Trail::START);
        let (lamps, flux): (Vec<usize>, Vec<f64>) = world
            .lamps
            .all()
            .iter()
            .enumerate()
            .filter(|(_, lamp)| traced(lamp))
            .map(|(index, lamp)| (index, lamp.flux_lm))
            .unzip();
        let guide = guide.cloned().unwrap_or_else(|| Guide::unguided(&flux));
        Emission { lamps, flux, guide, reach }
    }

    /// Flux of each lamp that is traced, lm.
    pub fn flux(&self) -> &[f64] {
        &self.flux
    }

    /// Starts one of `paths` paths. None if there is no lamp.
    pub fn start<'w>(&self, world: &'w World, mut rng: Rng, paths: u64) -> Option<Started<'w>> {
        let total: f64 = self.flux.iter().sum();
        let drawn = self.guide.draw(&self.flux, [rng.uniform(), rng.uniform(), rng.uniform(), rng.uniform()])?;
        let flux_lm = total / paths as f64 / drawn.density;
        let index = self.lamps[drawn.lamp];
        let lamp = &world.lamps.all()[index];
        let point = lamp.sample_point(rng.pair());
        let dir = lamp.sample_direction(point.normal, drawn.uv);
        let from = Site { part: lamp.part as u32, face: lamp.face as u32, triangle: point.triangle };
        let ray = Ray { origin: point.position, dir, from: Some(from) };
        let interior = world.lamp_interiors[index].clone();
        let walker = Walker::new(world, Travel::FromLamp, ray, flux_lm, interior, rng);
        Some(Started { walker, group: lamp.group, lamp: drawn.lamp, uv: drawn.uv, flux_lm })
    }
}

/// The forward estimator, ready to run passes.
pub struct Forward<'w> {
    world: &'w World,
    route: Route,
    emission: Emission,
    paths: u64,
    seed: u64,
}

struct Splat {
    pixel: u32,
    plane: u32,
    light: Light,
}

impl<'w> Forward<'w> {
    /// `paths` lamp paths per pass, for `groups` light groups.
    pub fn new(world: &'w World, route: Route, groups: usize, paths: u64, guide: Option<&Guide>, seed: u64) -> Self {
        let emission = Emission::new(world, &route, groups, guide);
        Forward { world, route, emission, paths, seed }
    }

    /// Adds passes `first .. first + count` to the film.
    pub fn run(&self, film: &mut Film, first: u64, count: u64) -> Ledger {
        let mut total = Ledger::new(self.world.solids.len());
        let chunks = self.paths.div_ceil(CHUNK);
        // A bounded number of chunks is in flight, so memory does not grow with the number of paths.
        let all: Vec<(u64, u64)> = (first..first + count).flat_map(|p| (0..chunks).map(move |c| (p, c))).collect();
        for batch in all.chunks(256) {
            let done: Vec<(Vec<Splat>, Ledger)> =
                batch.par_iter().map(|&(pass, chunk)| self.chunk(pass, chunk)).collect();
            for (splats, ledger) in done {
                splats.iter().for_each(|s| film.splat(s.pixel as usize, s.plane as usize, s.light));
                total.merge(&ledger);
            }
        }
        film.passes += count;
        total
    }

    /// Traces one pass for learning: (lamp, uv, flux that arrived in the picture) of each path that arrived.
    /// Once `stop` says true the rest is left out, and the result is worthless.
    pub fn probe(&self, pass: u64, stop: &ShouldStop<'_>) -> Vec<(usize, [f64; 2], f64)> {
        (0..self.paths)
            .into_par_iter()
            .filter_map(|sample| {
                if stop() {
                    return None;
                }
                let rng = Rng::new(self.seed, Stream::Pilot, pass, sample);
                let started = self.emission.start(self.world, rng, self.paths)?;
                let mut splats = Vec::new();
                self.follow(started.walker, started.group, &mut splats, &mut Ledger::new(self.world.solids.len()));
                let arrived: f64 = splats.iter().map(|splat| splat.light.open()).sum();
                (arrived > 0.0).then_some((started.lamp, started.uv, arrived))
            })
            .collect()
    }

    /// Flux of each traced lamp, lm.
    pub fn flux(&self) -> &[f64] {
        self.emission.flux()
    }

    /// The light group of a traced lamp.
    pub fn group_of(&self, lamp: usize) -> GroupId {
        self.world.lamps.all()[self.emission.lamps[lamp]].group
    }

    fn chunk(&self, pass: u64, chunk: u64) -> (Vec<Splat>, Ledger) {
        let mut splats = Vec::new();
        let mut ledger = Ledger::new(self.world.solids.len());
        for sample in chunk * CHUNK..((chunk + 1) * CHUNK).min(self.paths) {
            let rng = Rng::new(self.seed, Stream::Forward, pass, sample);
            let balance = ledger.imbalance();
            if let Some(started) = self.emission.start(self.world, rng, self.paths) {
                ledger.paths += 1;
                ledger.emitted += started.flux_lm;
                let first = splats.len();
                self.follow(started.walker, started.group, &mut splats, &mut ledger);
                merge_equal(&mut splats, first);
                ledger.close_path(balance);
            }
        }
        (splats, ledger)
    }

    fn follow(&self, mut walker: Walker<'w>, group: GroupId, splats: &mut Vec<Splat>, ledger: &mut Ledger) {
        let reach = &self.emission.reach[group.index()];
        loop {
            let vertex = match walker.advance(ledger) {
                Met::Sky => {
                    ledger.escaped += walker.beam.carried();
                    return;
                }
                Met::Ended => return,
                Met::Pupil(arrival) => {
                    ledger.arrived += walker.beam.carried();
                    let plane = self.route.from_lamp(group, walker.trail);
                    let light = walker.beam.light(arrival.luminance_per_lumen);
                    if let (Some(pixel), Some(plane)) = (arrival.pixel, plane) {
                        splats.push(Splat { pixel: pixel as u32, plane: plane as u32, light });
                    }
                    return;
                }
                Met::Face(vertex) => vertex,
            };
            let least = if walker.was_split() { SPLIT_AGAIN_FROM } else { SPLIT_FROM };
            if let Some(reflected) = walker.split(&vertex, least, Walker::MOST_SPLITS, ledger) {
                self.follow(reflected, group, splats, ledger);
            }
            match walker.meet(&vertex, ledger) {
                Meeting::Ended => return,
                Meeting::Went => {}
                Meeting::Scatter(scatter, frame) => {
                    if walker.scatter(&vertex, scatter, &frame, ledger).is_none() {
                        return;
                    }
                }
            }
            if !reach.allows(walker.trail) {
                ledger.not_owned += walker.beam.carried();
                return;
            }
        }
    }
}

/// Adds up what one path brought to the same pixel: the variance counts paths.
fn merge_equal(splats: &mut Vec<Splat>, first: usize) {
    let mut end = first;
    for index in first..splats.len() {
        let at = (splats[index].pixel, splats[index].plane);
        let light = splats[index].light;
        match splats[first..end].iter().position(|s| (s.pixel, s.plane) == at) {
            Some(same) => splats[first + same].light.add(light),
            None => {
                splats.swap(end, index);
                end += 1;
            }
        }
    }
    splats.truncate(end);
}
