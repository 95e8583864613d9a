//! Paths that start on lamps: where they start, and the one walk that light tracing and photon mapping share.

mod shots;
mod tuning;
mod visit;

use super::ShouldStop;
use super::ledger::Ledger;
use super::ownership::{Ownership, Reach};
use super::walk::{Travel, Walker};
use eyebox_base::ids::GroupId;
use eyebox_base::lpe;
use eyebox_base::parallel;
use eyebox_base::path::Trail;
use eyebox_base::rng::Rng;
use eyebox_film::guide::{Guide, Point, Sample};
use eyebox_world::World;
use eyebox_world::geometry::{Ray, Site};
use eyebox_world::lamp::LampPoint;
use eyebox_world::mode::{Mode, lanes};
use eyebox_world::optics::Optics;
use glam::DVec3;
use shots::Points;
pub use shots::{Shots, Starts};
pub use visit::Visitor;

/// Where a path comes from.
#[derive(Debug, Clone, Copy)]
pub struct Origin {
    pub group: GroupId,
    /// The lamp has a luminance; a point and parallel light have none, so no pixel can show them.
    pub visible: bool,
    /// Of an emitting face: its number among the world's lamps, the point and its unit normal.
    pub face: Option<(usize, DVec3, DVec3)>,
}

/// Starts paths on the lamps whose light an estimator traces: by flux and intensity, or as a guide says.
pub struct Emission {
    sources: Vec<Source>,
    /// lm
    flux: Vec<f64>,
    guide: Guide,
    /// Per light group: how far a trail from it can still lead to paths that are owned.
    reach: Vec<Reach>,
}

/// Index of a lamp in the world: an emitting face, or a light that is no face.
#[derive(Debug, Clone, Copy)]
enum Source {
    Face(usize),
    Light(usize),
}

/// A path that starts on a lamp.
pub struct Started<'w, M: Mode> {
    pub walker: Walker<'w, M>,
    pub origin: Origin,
    /// Index in the emission's lamps, the point of its cube, and the density of both, for learning.
    pub lamp: usize,
    pub x: Point,
    pub density: f64,
}

/// Starts a path at a place on an emitting face, with so many lumens of its even light; none where a display is dark around its picture.
pub fn leave_face<'w, M: Mode>(
    (world, optics): (&'w World, &'w Optics<M>),
    index: usize,
    (point, dir): (&LampPoint, DVec3),
    lumens: f64,
    rng: Rng,
) -> Option<(Walker<'w, M>, Origin)> {
    let lamp = world.lamps.get(index)?;
    let from = Site { part: lamp.part as u32, face: lamp.face as u32, triangle: point.triangle };
    let ray = Ray { origin: point.position, dir, from: Some(from) };
    let origin = Origin { group: lamp.group, visible: true, face: Some((index, point.position, point.normal)) };
    let tint = optics.lamp_at(index, lamp.glow(point, dir));
    let (interior, weights) = (world.lamp_interiors[index], lanes::<M, _>(|lane| lumens * tint[lane]));
    let walker = Walker::with_weights((world, optics), Travel::FromLamp, ray, weights, interior, rng);
    let mut walker = walker.from_face(point.normal);
    if let Some(sieve) = &world.sieve {
        walker.told = sieve.lamp(origin.group.index(), lpe::Source::Face);
    }
    if let Some(light) = lamp.polarisation {
        walker.beam = walker.beam.polarised(light, dir, false);
    }
    walker.beam = walker.beam.shown((world, optics), lamp, point.position)?;
    Some((walker, origin))
}

impl Emission {
    pub fn new(world: &World, route: &Ownership, groups: usize, guide: Option<&Guide>) -> Self {
        let reach: Vec<Reach> = (0..groups).map(|g| Reach::from_lamp(route, GroupId::from_index(g))).collect();
        let faces = world.lamps.all().iter().enumerate();
        let faces = faces.map(|(index, lamp)| (Source::Face(index), lamp.group, lamp.flux_lm));
        let lights = world.lights.all().iter().enumerate();
        let lights = lights.map(|(index, light)| (Source::Light(index), light.group(), light.flux_lm()));
        let (sources, flux): (Vec<Source>, Vec<f64>) = faces
            .chain(lights)
            .filter(|(_, group, flux)| *flux > 0.0 && reach[group.index()].allows(Trail::START))
            .map(|(source, _, flux)| (source, flux))
            .unzip();
        // A guide for other lamps would be no use.
        let guide = guide.filter(|guide| guide.lamps() == flux.len()).cloned();
        let guide = guide.unwrap_or_else(|| Guide::unguided(&flux));
        Emission { sources, flux, guide, reach }
    }

    /// Flux of each lamp that is traced, lm.
    pub fn flux(&self) -> &[f64] {
        &self.flux
    }

    /// The light group of a traced lamp.
    pub fn group_of(&self, world: &World, lamp: usize) -> GroupId {
        match self.sources[lamp] {
            Source::Face(index) => world.lamps.all()[index].group,
            Source::Light(index) => world.lights.all()[index].group(),
        }
    }

    /// The place of a light that is no face among the lamps that are traced, if it is.
    pub fn place_of_light(&self, index: usize) -> Option<usize> {
        self.sources.iter().position(|source| matches!(source, Source::Light(own) if *own == index))
    }

    /// Starts one path of a pass. None if there is no lamp, or where a display is dark around its picture.
    fn start<'w, M: Mode>(
        &self,
        (world, optics): (&'w World, &'w Optics<M>),
        points: &Points,
        sample: u64,
    ) -> Option<Started<'w, M>> {
        let shots = &points.shots;
        let mut rng = Rng::new(shots.seed, shots.stream, shots.pass, sample);
        let (choice, point) = points.of(sample, &mut rng);
        let drawn = self.guide.draw(&self.flux, choice, point)?;
        let total: f64 = self.flux.iter().sum();
        let flux_lm = total / shots.paths as f64 / drawn.density;
        let [place, uv] = [[drawn.x[0], drawn.x[1]], [drawn.x[2], drawn.x[3]]];
        let (walker, origin) = match self.sources[drawn.lamp] {
            Source::Face(index) => {
                let lamp = &world.lamps.all()[index];
                let point = lamp.sample_point(place);
                let dir = lamp.sample_direction(point.normal, uv);
                leave_face((world, optics), index, (&point, dir), flux_lm, rng)?
            }
            Source::Light(index) => {
                let light = &world.lights.all()[index];
                let (ray, interior) = world.start_of_light(index, place, uv);
                let origin = Origin { group: light.group(), visible: light.has_luminance(), face: None };
                let tint = optics.light(index);
                let weights = lanes::<M, _>(|lane| flux_lm * tint[lane]);
                let mut walker = Walker::with_weights((world, optics), Travel::FromLamp, ray, weights, interior, rng);
                if let Some(sieve) = &world.sieve {
                    walker.told = sieve.lamp(origin.group.index(), lpe::Source::Light);
                }
                (walker, origin)
            }
        };
        Some(Started { walker, origin, lamp: drawn.lamp, x: drawn.x, density: drawn.density })
    }

    /// Traces one chunk of a pass.
    pub fn chunk<M: Mode, V: Visitor<M>>(
        &self,
        (world, optics): (&World, &Optics<M>),
        shots: Shots,
        chunk: u64,
        visitor: &mut V,
    ) -> Ledger {
        let mut ledger = Ledger::new(world.solids.len());
        let points = Points::new(shots);
        for sample in shots.samples(chunk) {
            let balance = ledger.imbalance();
            if let Some(started) = self.start((world, optics), &points, sample) {
                ledger.paths += 1;
                ledger.emitted += started.walker.beam.carried();
                self.walk(started.walker, started.origin, visitor, &mut ledger);
                visitor.end(sample);
                ledger.close_path(balance);
            }
        }
        ledger
    }

    /// Density with which paths start at a point of a lamp's cube, over that by flux and intensity.
    pub fn density(&self, lamp: usize, x: &Point) -> f64 {
        self.guide.density(&self.flux, lamp, x)
    }

    /// Traces a pass for learning: of each path that gained its start, weighted with what `gain` makes of its visit times
    /// its density and the number of paths. Once `stop` says true the rest is left out, and the result is worthless.
    pub fn probe<M: Mode, V: Visitor<M>>(
        &self,
        tracing: (&World, &Optics<M>),
        shots: Shots,
        stop: &ShouldStop<'_>,
        visitor: impl Fn() -> V + Sync,
        gain: impl Fn(&V) -> f64 + Sync,
    ) -> Vec<Sample> {
        self.survey(tracing, shots, stop, visitor, |lamp, x, density, visitor| {
            let weight = gain(&visitor) * density * shots.paths as f64;
            (weight > 0.0 && weight.is_finite()).then_some(Sample { lamp, x, weight })
        })
    }

    /// Traces a pass and keeps what `take` makes of each path's lamp, point of its cube, density and visit, in the order of
    /// the paths. Once `stop` says true the rest is left out, and the result is worthless.
    pub fn survey<M: Mode, V: Visitor<M>, T: Send>(
        &self,
        (world, optics): (&World, &Optics<M>),
        shots: Shots,
        stop: &ShouldStop<'_>,
        visitor: impl Fn() -> V + Sync,
        take: impl Fn(usize, Point, f64, V) -> Option<T> + Sync,
    ) -> Vec<T> {
        self.starts((world, optics), shots, stop, |started| {
            let mut visitor = visitor();
            let mut ledger = Ledger::new(world.solids.len());
            let Started { walker, origin, lamp, x, density } = started;
            self.walk(walker, origin, &mut visitor, &mut ledger);
            take(lamp, x, density, visitor)
        })
    }

    /// Starts the paths of a pass and keeps what `take` makes of each, in their order; as [`Emission::survey`], but where they
    /// go is for `take` to say.
    pub fn starts<'w, M: Mode, T: Send>(
        &self,
        tracing: (&'w World, &'w Optics<M>),
        shots: Shots,
        stop: &ShouldStop<'_>,
        take: impl Fn(Started<'w, M>) -> Option<T> + Sync,
    ) -> Vec<T> {
        let points = Points::new(shots);
        let start = |sample| if stop() { None } else { self.start(tracing, &points, sample) };
        parallel::filter_map(shots.paths, &|sample| take(start(sample)?))
    }
}
