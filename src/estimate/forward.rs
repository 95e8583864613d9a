//! Light tracing: paths start on the lamps with equal shares of flux and *arrive* at the pupil by themselves. No shadow
//! ray is sent to the eye, since no lens would let one through. They start from even points (randomised quasi-Monte Carlo),
//! dealt to independent scrambles that tell the error.

use super::ShouldStop;
use super::emission::{Emission, Origin, Shots, Starts, Visitor};
use super::ledger::Ledger;
use super::ownership::Ownership;
use super::tuning::forward::{SPLIT_AGAIN_FROM, SPLIT_FROM};
use super::walk::{Vertex, Walker};
use crate::manifold::seeds::bands::Bands;
use crate::manifold::seeds::connections::{Connections, Rest};
use crate::manifold::solver::newton::Target;
use eyebox_base::ids::GroupId;
use eyebox_base::parallel;
use eyebox_base::path::Class;
use eyebox_base::rng::Stream;
use eyebox_film::accumulate::{Film, Light};
use eyebox_film::guide::{Guide, Point, Sample};
use eyebox_film::replicates::REPLICATES;
use eyebox_world::World;
use eyebox_world::eye::Arrival;
use eyebox_world::mode::{Mode, components, lanes};
use eyebox_world::optics::Optics;
use eyebox_world::scatter::Scatter;
use std::marker::PhantomData;
use std::sync::Arc;

/// The forward estimator, ready to run passes.
pub struct Forward<'w, M: Mode> {
    world: &'w World,
    mode: PhantomData<M>,
    route: Ownership,
    emission: Emission,
    paths: u64,
    /// What of the paths is not ours.
    connections: Arc<Bands>,
    seed: u64,
    starts: Starts,
}

/// Light that one path brought to a pixel; the entries of a plane, of which luminance alone needs the first.
struct Splat {
    pixel: u32,
    plane: u32,
    /// Of the path.
    scramble: u32,
    light: [Light; 3],
}

/// What paths bring to the picture.
struct Arrivals<'r, M: Mode> {
    route: &'r Ownership,
    optics: &'r Optics<M>,
    connections: &'r Connections,
    splats: Vec<Splat>,
    /// Where the splats of the path under way begin.
    first: usize,
    /// Counted work of asking what is connected.
    work: u64,
}

impl<'w, M: Mode> Forward<'w, M> {
    /// `paths` lamp paths per pass, for `groups` light groups.
    pub fn new(
        world: &'w World,
        route: Ownership,
        groups: usize,
        paths: u64,
        guide: Option<&Guide>,
        connections: Arc<Bands>,
        seed: u64,
    ) -> Self {
        let emission = Emission::new(world, &route, groups, guide);
        Forward { world, mode: PhantomData, route, emission, paths, connections, seed, starts: Starts::Scrambles }
    }

    /// The same with other numbers for the paths to start with.
    #[must_use]
    pub fn starting(self, starts: Starts) -> Self {
        Forward { starts, ..self }
    }

    /// Adds passes `first .. first + count` to the film.
    pub fn run(&self, film: &mut Film, first: u64, count: u64) -> Ledger {
        let mut total = Ledger::new(self.world.solids.len());
        let chunks = Shots::chunks(self.paths);
        // A bounded number of chunks is in flight, so memory does not grow with the number of paths.
        let all: Vec<(u64, u64)> = (first..first + count).flat_map(|p| (0..chunks).map(move |c| (p, c))).collect();
        for batch in all.chunks(256) {
            let first_pass = batch[0].0;
            let last_pass = batch[batch.len() - 1].0;
            let optics: Vec<Optics<M>> =
                (first_pass..=last_pass).map(|pass| M::optics(self.world, self.seed, pass)).collect();
            let of_chunk = |&(pass, chunk): &(u64, u64)| {
                let optics = &optics[(pass - first_pass) as usize];
                let mut arrivals = self.arrivals(optics);
                let shots = self.shots(Stream::Forward, pass);
                let mut ledger = self.emission.chunk((self.world, optics), shots, chunk, &mut arrivals);
                ledger.work += arrivals.work;
                (arrivals.splats, ledger)
            };
            let done: Vec<(Vec<Splat>, Ledger)> = parallel::map_all(batch, &of_chunk);
            for ((pass, _), (splats, ledger)) in batch.iter().zip(done) {
                film.add_work(*pass, ledger.work);
                for s in &splats {
                    film.splat(s.pixel as usize, s.plane as usize, s.scramble as usize, &s.light[..M::COMPONENTS]);
                }
                total.merge(&ledger);
            }
        }
        film.close(first, count);
        film.settle();
        total
    }

    /// Traces one pass for learning: the starts of the paths that arrived in the picture, with the luminance that they
    /// brought there, see [`Emission::probe`]. Once `stop` says true the rest is left out, and the result is worthless.
    pub fn probe(&self, pass: u64, stop: &ShouldStop<'_>) -> Vec<Sample> {
        let optics = M::optics(self.world, self.seed, pass);
        let luminance = |splat: &Splat| components::<M>().luminance(&splat.light[..M::COMPONENTS]).open();
        let arrived = |arrivals: &Arrivals<'_, M>| arrivals.splats.iter().map(luminance).sum();
        let shots = self.shots(Stream::Pilot, pass);
        self.emission.probe((self.world, &optics), shots, stop, || self.arrivals(&optics), arrived)
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
        Shots { seed: self.seed, stream, pass, paths: self.paths, starts: self.starts }
    }

    fn arrivals<'r>(&'r self, optics: &'r Optics<M>) -> Arrivals<'r, M> {
        let connections = self.connections.of(optics);
        Arrivals { route: &self.route, optics, connections, splats: Vec::new(), first: 0, work: 0 }
    }
}

impl<M: Mode> Visitor<M> for Arrivals<'_, M> {
    fn split_from(&self, walker: &Walker<'_, M>) -> Option<f64> {
        Some(if walker.was_split() { SPLIT_AGAIN_FROM } else { SPLIT_FROM })
    }

    fn records(&self) -> bool {
        !self.connections.is_empty()
    }

    fn pupil(&mut self, walker: &Walker<'_, M>, from: Origin, arrival: &Arrival) {
        if !from.visible && walker.trail.class_from_lamp() == Class::Vision {
            return;
        }
        if self.is_of_others(walker, from, arrival) {
            return;
        }
        let share = self.route.from_lamp(from.group, walker.trail);
        let pixel = arrival.pixel.filter(|pixel| walker.world.eye.wants_index(*pixel));
        if let (Some(pixel), Some(share)) = (pixel, share) {
            let plane = self.route.plane(share, |sieve| sieve.takes(sieve.eye(), walker.told));
            let mut light = [Light::default(); 3];
            let each = lanes::<M, _>(|_| arrival.luminance_per_lumen);
            walker.beam.deposit(self.optics, &mut light[..M::COMPONENTS], &each);
            self.splats.push(Splat { pixel: pixel as u32, plane: plane as u32, scramble: 0, light });
        }
    }

    fn scatterer(&mut self, _: &Walker<'_, M>, _: Origin, _: &Vertex, _: &Scatter) {}

    fn end(&mut self, sample: u64) {
        merge_equal(&mut self.splats, self.first);
        let scramble = (sample % REPLICATES as u64) as u32;
        self.splats[self.first..].iter_mut().for_each(|splat| splat.scramble = scramble);
        self.first = self.splats.len();
    }
}

impl<M: Mode> Arrivals<'_, M> {
    /// Whether the path is one that specular connection returns for its ends, or comes over a train that it does not know
    /// there: then rays from the eye have it.
    fn is_of_others(&mut self, walker: &Walker<'_, M>, from: Origin, arrival: &Arrival) -> bool {
        let (Some(chain), Some((lamp, point, normal))) = (walker.chain(), from.face) else { return false };
        let vision = arrival.pixel.is_some() && walker.trail.class_from_lamp() == Class::Vision;
        vision && self.route.is_connected(from.group) && {
            let target = Target::new(point, normal);
            let places = (arrival.film, arrival.pupil);
            let tracing = (walker.world, self.optics);
            self.connections.rest(chain, lamp, arrival.film) != Rest::Lamp
                || self.connections.owns(tracing, chain, (lamp, &target), places, &mut self.work)
        }
    }
}

/// Adds up what one path brought to the same pixel.
fn merge_equal(splats: &mut Vec<Splat>, first: usize) {
    let mut end = first;
    for index in first..splats.len() {
        let at = (splats[index].pixel, splats[index].plane);
        let light = splats[index].light;
        match splats[first..end].iter().position(|s| (s.pixel, s.plane) == at) {
            Some(same) => splats[first + same].light.iter_mut().zip(light).for_each(|(sum, light)| sum.add(light)),
            None => {
                splats.swap(end, index);
                end += 1;
            }
        }
    }
    splats.truncate(end);
}
