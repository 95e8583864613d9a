//! Paths from the lamps to the eye over specular faces alone; each knows its parts. What such paths bring.

use super::chain_sampling::All;
use super::part_sequence::Visits;
use eyebox_base::chain::Chain;
use eyebox_base::ids::GroupId;
use eyebox_base::path::Class;
use eyebox_base::rng::Stream;
use eyebox_estimate::ShouldStop;
use eyebox_estimate::emission::{Emission, Origin, Shots, Visitor};
use eyebox_estimate::walk::{Vertex, Walker};
use eyebox_film::accumulate::Light;
use eyebox_film::guide::Point;
use eyebox_world::World;
use eyebox_world::eye::Arrival;
use eyebox_world::geometry::Site;
use eyebox_world::mode::{Mode, components, lanes};
use eyebox_world::optics::Optics;
use eyebox_world::scatter::Scatter;
use glam::{DVec2, DVec3};
use std::cell::Cell;

/// What shines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Source {
    /// Index of a lamp in the world.
    Face(usize),
    /// Index of a light that is no face.
    Light(usize),
    Sky,
}

impl Source {
    /// Where paths by this source start inside of a part.
    fn is_inside(self, world: &World, part: u32) -> bool {
        let interior = match self {
            Source::Face(index) => world.lamp_interiors.get(index),
            Source::Light(index) => world.light_interiors.get(index),
            Source::Sky => None,
        };
        interior.is_some_and(|interior| interior.contains(part))
    }

    /// A chain from this source (or from a scatterer, if none) on, part by part.
    pub fn visits(from: Option<Source>, world: &World, chain: &Chain) -> Visits {
        let solid = |part: u32| world.solids.get(part as usize).is_some_and(Option::is_some);
        Visits::of(chain, solid, |part| from.is_some_and(|source| source.is_inside(world, part)))
    }
}

/// Which way the light came.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Way {
    /// Over specular faces alone.
    Vision(Visits),
    /// From the lamp (after other scatterers, if `again`) to the scatterer `at`, and from there to the eye.
    Scattered { again: bool, before: Visits, at: u32, after: Visits },
}

/// Light that one path brought to one pixel.
#[derive(Debug, Clone)]
pub struct Caught {
    pub group: GroupId,
    pub source: Source,
    pub way: Way,
    pub pixel: u32,
    pub lumens: f64,
    /// What it adds to the pixel's luminance, cd/m².
    pub luminance: f64,
    /// How it came, if that is asked for.
    pub trace: Option<Box<Trace>>,
}

/// How a path from the eye got to what shines.
#[derive(Debug, Clone)]
pub struct Trace {
    /// From the lamp.
    pub chain: Chain,
    /// Point of the unit cube of picture and pupil, see `EyeLens::unit_of`.
    pub start: Point,
    /// None: beyond the scene.
    pub end: Option<LampEnd>,
}

/// Where a path from the eye met a lamp, and its direction there.
#[derive(Debug, Clone, Copy)]
pub struct LampEnd {
    pub lamp: usize,
    pub point: DVec3,
    pub normal: DVec3,
    pub dir: DVec3,
    pub site: Site,
}

/// How paths are followed.
#[derive(Debug, Clone, Copy)]
pub struct Split {
    /// A path is followed both ways where each carries this share of what it started with; else chance decides.
    pub least: f64,
}

impl Split {
    /// Vertices of a path and its branches from which on chance alone decides.
    const MOST_VERTICES: u32 = 1 << 14;

    pub(super) fn at<M: Mode>(self, walker: &Walker<'_, M>, vertices: &Cell<u32>) -> Option<f64> {
        let share = walker.share();
        let count = vertices.get();
        vertices.set(count.saturating_add(1));
        (count < Self::MOST_VERTICES && share > self.least).then(|| self.least / share)
    }
}

/// The light of the beam, `each` times per unit.
pub fn light<M: Mode>(walker: &Walker<'_, M>, each: f64) -> f64 {
    let mut out = [Light::default(); 3];
    walker.beam.deposit(walker.optics, &mut out[..M::COMPONENTS], &lanes::<M, _>(|_| each));
    components::<M>().luminance_value(&out[..M::COMPONENTS])
}

/// What arrived in the picture by one branch of a path from a lamp.
pub(super) struct Arrived {
    pub group: GroupId,
    pub chain: Chain,
    pub pixel: u32,
    pub lumens: f64,
    pub luminance: f64,
    /// Places in the picture (tangents) and in the pupil (m).
    pub film: DVec2,
    pub pupil: DVec2,
}

/// What arrives in the picture of one path from a lamp.
pub(super) struct Arrivals {
    split: Split,
    vertices: Cell<u32>,
    found: Vec<Arrived>,
}

impl Arrivals {
    pub(super) fn new(split: Split) -> Self {
        Arrivals { split, vertices: Cell::new(0), found: Vec::new() }
    }

    pub(super) fn found(self) -> Vec<Arrived> {
        self.found
    }

    /// What arrived, but for chains that are `owned` by others.
    pub(super) fn caught(self, source: Source, world: &World, owned: &All) -> Vec<Caught> {
        let rest = self.found.into_iter().filter(|arrived| !owned.owns(arrived.group, &arrived.chain));
        let caught = |Arrived { group, chain, pixel, lumens, luminance, .. }: Arrived| {
            let way = Way::Vision(Source::visits(Some(source), world, &chain));
            Caught { group, source, way, pixel, lumens, luminance, trace: None }
        };
        rest.map(caught).collect()
    }
}

impl<M: Mode> Visitor<M> for Arrivals {
    fn split_from(&self, walker: &Walker<'_, M>) -> Option<f64> {
        self.split.at(walker, &self.vertices)
    }
    fn most_splits(&self) -> u8 {
        u8::MAX
    }
    fn records(&self) -> bool {
        true
    }
    fn pupil(&mut self, walker: &Walker<'_, M>, from: Origin, arrival: &Arrival) {
        let (Some(pixel), Some(chain)) = (arrival.pixel, walker.chain()) else { return };
        if from.visible && walker.trail.class_from_lamp() == Class::Vision {
            let lumens = light(walker, 1.0);
            let luminance = lumens * arrival.luminance_per_lumen;
            if luminance.is_finite() {
                let (group, chain, pixel) = (from.group, chain.clone(), pixel as u32);
                let (film, pupil) = (arrival.film, arrival.pupil);
                self.found.push(Arrived { group, chain, pixel, lumens, luminance, film, pupil });
            }
        }
    }
    fn scatterer(&mut self, _: &Walker<'_, M>, _: Origin, _: &Vertex, _: &Scatter) {}
}

/// The lamps of an emission, in its order: those with flux of the groups that are `given` to it.
pub fn sources(world: &World, given: impl Fn(GroupId) -> bool) -> Vec<Source> {
    let faces = world.lamps.all().iter().enumerate();
    let faces = faces.filter(|(_, lamp)| lamp.flux_lm > 0.0 && given(lamp.group));
    let lights = world.lights.all().iter().enumerate();
    let lights = lights.filter(|(_, light)| light.flux_lm() > 0.0 && given(light.group()));
    faces.map(|(index, _)| Source::Face(index)).chain(lights.map(|(index, _)| Source::Light(index))).collect()
}

/// One pass of paths from the lamps: what each that arrived brought, in their order, by chains that are not `owned` by others.
pub fn from_lamps<M: Mode>(
    (world, optics): (&World, &Optics<M>),
    (emission, sources): (&Emission, &[Source]),
    owned: &All,
    (shots, split): (Shots, Split),
    stop: &ShouldStop<'_>,
) -> Vec<Vec<Caught>> {
    let visitor = || Arrivals::new(split);
    emission.survey((world, optics), shots, stop, visitor, |lamp, _, _, arrivals: Arrivals| {
        let caught = arrivals.caught(*sources.get(lamp)?, world, owned);
        (!caught.is_empty()).then_some(caught)
    })
}

/// All that shines of a group.
pub fn sources_of(world: &World, group: GroupId) -> Vec<Source> {
    let faces = world.lamps.all().iter().enumerate().filter(|(_, lamp)| lamp.group == group);
    let lights = world.lights.all().iter().enumerate().filter(|(_, light)| light.group() == group);
    let sky = world.sky.iter().filter(|sky| sky.group == group).map(|_| Source::Sky);
    faces
        .map(|(index, _)| Source::Face(index))
        .chain(lights.map(|(index, _)| Source::Light(index)))
        .chain(sky)
        .collect()
}

/// Streams of random numbers of the surveys: passes of one stream never meet those of another.
pub const STREAM: Stream = Stream::Pilot;
