//! Paths from the lamps that arrive at a sensor.

use super::tuning::sensor::SPLIT_FROM;
use super::{Caught, measured};
use crate::ShouldStop;
use crate::emission::{Emission, Origin, Shots, Starts, Visitor};
use crate::ownership::Ownership;
use crate::walk::{Vertex, Walker};
use eyebox_base::ids::GroupId;
use eyebox_base::parallel;
use eyebox_base::rng::Stream;
use eyebox_film::accumulate::PlaneKey;
use eyebox_film::guide::{Guide, Point, Sample};
use eyebox_film::layer::Layer;
use eyebox_world::World;
use eyebox_world::eye::Arrival;
use eyebox_world::mode::Mode;
use eyebox_world::optics::Optics;
use eyebox_world::scatter::Scatter;
use eyebox_world::sensor::{SensorFace, Side};
use std::marker::PhantomData;

/// Light tracing onto a sensor, ready to run passes.
pub struct Forward<'w, M: Mode> {
    world: &'w World,
    mode: PhantomData<M>,
    sensor: &'w SensorFace,
    emission: Emission,
    /// Per light group, where wavelengths are not traced.
    watts_per_lumen: &'w [f64],
    paths: u64,
    seed: u64,
}

/// What the paths of a chunk bring.
struct Arrivals<'r, M: Mode> {
    optics: &'r Optics<M>,
    sensor: &'r SensorFace,
    watts_per_lumen: &'r [f64],
    caught: Vec<Caught>,
}

impl<'w, M: Mode> Forward<'w, M> {
    /// `paths` in a pass. Per light group of the scene: `watts_per_lumen`, and whether it is left out.
    pub fn new(
        world: &'w World,
        sensor: &'w SensorFace,
        (watts_per_lumen, left_out): (&'w [f64], &[bool]),
        paths: u64,
        guide: Option<&Guide>,
        seed: u64,
    ) -> Self {
        let groups = watts_per_lumen.len();
        let is_out = |group: GroupId| left_out.get(group.index()).copied().unwrap_or(false);
        // All light of the others, whatever has happened to it.
        let all = |group: GroupId, _, _| (!is_out(group)).then_some(PlaneKey { layer: Layer::Direct, group, takes: 0 });
        let emission = Emission::new(world, &Ownership::by(groups, &all), groups, guide);
        Forward { world, mode: PhantomData, sensor, emission, watts_per_lumen, paths, seed }
    }

    /// What a pass brings, in the order of its paths.
    pub fn pass(&self, pass: u64) -> Vec<Caught> {
        let optics = M::optics(self.world, self.seed, pass);
        let shots = self.shots(Stream::Sensor, pass);
        let of_chunk = |chunk: usize| {
            let mut arrivals = self.arrivals(&optics);
            self.emission.chunk((self.world, &optics), shots, chunk as u64, &mut arrivals);
            arrivals.caught
        };
        parallel::map(Shots::chunks(self.paths) as usize, &of_chunk).concat()
    }

    /// Traces one pass for learning: the starts of paths that arrived, with what they brought, see [`Emission::probe`].
    pub fn probe(&self, pass: u64, stop: &ShouldStop<'_>) -> Vec<Sample> {
        let optics = M::optics(self.world, self.seed, pass);
        let brought = |arrivals: &Arrivals<'_, M>| arrivals.caught.iter().map(|caught| caught.lumens).sum();
        let shots = self.shots(Stream::Pilot, pass);
        self.emission.probe((self.world, &optics), shots, stop, || self.arrivals(&optics), brought)
    }

    /// [`Emission::density`].
    pub fn density(&self, lamp: usize, x: &Point) -> f64 {
        self.emission.density(lamp, x)
    }

    /// Flux of each traced lamp, lm.
    pub fn flux(&self) -> &[f64] {
        self.emission.flux()
    }

    /// [`Emission::place_of_light`].
    pub fn place_of_light(&self, index: usize) -> Option<usize> {
        self.emission.place_of_light(index)
    }

    /// The light group of a traced lamp.
    pub fn group_of(&self, lamp: usize) -> GroupId {
        self.emission.group_of(self.world, lamp)
    }

    fn shots(&self, stream: Stream, pass: u64) -> Shots {
        Shots { seed: self.seed, stream, pass, paths: self.paths, starts: Starts::OfPass }
    }

    fn arrivals<'r>(&'r self, optics: &'r Optics<M>) -> Arrivals<'r, M> {
        Arrivals { optics, sensor: self.sensor, watts_per_lumen: self.watts_per_lumen, caught: Vec::new() }
    }
}

impl<M: Mode> Visitor<M> for Arrivals<'_, M> {
    fn split_from(&self, _: &Walker<'_, M>) -> Option<f64> {
        Some(SPLIT_FROM)
    }

    fn lands(&mut self, walker: &Walker<'_, M>, from: Origin, vertex: &Vertex) {
        let is_ours = |part: u32, face: u32| (part, face) == (self.sensor.part, self.sensor.face);
        let own = is_ours(vertex.hit.site.part, vertex.hit.site.face).then_some(vertex.outside);
        // Two faces that are one interface are both met here; one looks where the other does, or against it.
        let other = vertex.touching.filter(|other| is_ours(other.site.part, other.site.face));
        let outside = own.or(other.map(|other| vertex.outside == other.flush));
        let Some(outside) = outside else { return };
        let side = if outside { Side::Front } else { Side::Back };
        let per_lumen = self.watts_per_lumen.get(from.group.index()).copied().unwrap_or(0.0);
        let (lumens, watts) = measured::<M>(self.optics, walker.beam.stored(), per_lumen);
        if lumens != 0.0 || watts != 0.0 {
            let pixel = self.sensor.pixel_of(vertex.hit.point) as u32;
            self.caught.push(Caught { pixel, side, group: from.group, lumens, watts });
        }
    }

    fn pupil(&mut self, _: &Walker<'_, M>, _: Origin, _: &Arrival) {}
    fn scatterer(&mut self, _: &Walker<'_, M>, _: Origin, _: &Vertex, _: &Scatter) {}
}
