//! Chains of faces that are measured each by paths of its own: they start where its light starts or arrives and do at every
//! face what the chain says, with the weight of reflection or transmission, so that nothing is left to chance but the start.

use super::discover::Start;
use super::eye_paths;
use super::lamp_paths::{self, Caught, Source, Way};
use super::tuning::chain_sampling::{BRIGHT, ERROR, EYE, FIRST, GAIN, LONGER, PATHS, WILD};
use crate::pilots::{self, Look, Narrow};
use eyebox_base::chain::Chain;
use eyebox_base::ids::GroupId;
use eyebox_base::parallel;
use eyebox_base::rng::{Rng, Stream};
use eyebox_base::sobol::Sobol;
use eyebox_estimate::ShouldStop;
use eyebox_estimate::emission::{Emission, Shots, Started, Starts};
use eyebox_estimate::ledger::Ledger;
use eyebox_estimate::walk::{Travel, Walker};
use eyebox_film::guide::{Guide, Point, Sample};
use eyebox_world::World;
use eyebox_world::geometry::Ray;
use eyebox_world::interior::Interior;
use eyebox_world::mode::{Mode, Mono};
use eyebox_world::optics::Optics;
use std::collections::BTreeSet;

/// The chains with paths of their own.
#[derive(Default)]
pub(super) struct All {
    pub chains: Vec<Directed>,
    owned: BTreeSet<(GroupId, Chain)>,
}

impl All {
    pub fn new(chains: Vec<Directed>) -> All {
        let owned = chains.iter().map(|directed| (directed.group, directed.chain.clone())).collect();
        All { chains, owned }
    }

    /// Whether the light of this chain (from the lamp) is measured by its own paths: the survey leaves it out.
    pub fn owns(&self, group: GroupId, chain: &Chain) -> bool {
        !self.owned.is_empty() && self.owned.contains(&(group, chain.clone()))
    }
}

/// A chain, whose light it carries, and where that starts.
pub(super) struct Directed {
    pub group: GroupId,
    /// From the lamp.
    chain: Chain,
    side: Side,
    /// What shines, and what the chain is called from there.
    ways: Vec<(Source, Way)>,
    /// Of all light that the pilot found.
    pub share: f64,
    /// Of the group's.
    of_group: f64,
    /// Variance of a path over its mean squared, as the pilot had it.
    spread: f64,
}

/// Where paths start: on lamps, or at places of the picture and the pupil.
enum Side {
    Lamps(Emission),
    Eye { guide: Guide, back: Chain },
}

/// A path that went all the way.
struct Whole {
    /// Index among the lamps of the emission (0: from the eye), the point of its cube, the density there.
    lamp: usize,
    x: Point,
    density: f64,
    source: Source,
    pixel: u32,
    lumens: f64,
    luminance: f64,
}

/// What a path counts by: flux, or luminance where the pupil is a point.
pub(super) fn weight(world: &World, lumens: f64, luminance: f64) -> f64 {
    if world.eye.pupil_radius_m() > 0.0 { lumens } else { luminance }
}

impl Side {
    fn flux(&self) -> &[f64] {
        match self {
            Side::Lamps(emission) => emission.flux(),
            Side::Eye { .. } => &EYE,
        }
    }

    /// One pass: what each path that went all the way found, in their order.
    fn run<M: Mode>(
        &self,
        (world, optics): (&World, &Optics<M>),
        (group, chain, ways): (GroupId, &Chain, &[(Source, Way)]),
        shots: Shots,
        stop: &ShouldStop<'_>,
    ) -> Vec<Vec<Whole>> {
        match self {
            Side::Lamps(emission) => emission.starts((world, optics), shots, stop, |started| {
                let Started { mut walker, origin, lamp, x, density } = started;
                if origin.group != group || !origin.visible {
                    return None;
                }
                let mut ledger = Ledger::new(world.solids.len());
                let arrival = walker.follow_to_pupil(chain.0.iter().copied(), &mut ledger)?;
                let pixel = arrival.pixel? as u32;
                let lumens = lamp_paths::light(&walker, 1.0);
                let luminance = lumens * arrival.luminance_per_lumen;
                let (source, _) = ways.get(lamp)?;
                Some(vec![Whole { lamp, x, density, source: *source, pixel, lumens, luminance }])
            }),
            Side::Eye { guide, back } => {
                let sobol = Sobol::new(shots.seed, shots.stream, shots.pass);
                let one = |sample: u64| {
                    let drawn = guide.draw(&EYE, 0.0, sobol.point(sample))?;
                    if stop() {
                        return None;
                    }
                    let (pixel, [film, lens]) = world.eye.pixel_at(&drawn.x);
                    let [width, height] = world.eye.size();
                    let (origin, dir) = world.eye.ray(pixel % width, pixel / width, film, lens);
                    let rng = Rng::new(shots.seed, shots.stream, shots.pass, sample);
                    let ray = Ray { origin, dir, from: None };
                    let mut walker =
                        Walker::new((world, optics), Travel::FromEye, ray, 1.0, Interior::default(), rng).recording();
                    let mut ledger = Ledger::new(world.solids.len());
                    if !walker.follow(back.0.iter().copied(), &mut ledger, |_, _, _| {}) {
                        return None;
                    }
                    let each = (width * height) as f64 / (shots.paths as f64 * drawn.density);
                    let lumens = world.eye.lumens_per_luminance(dir);
                    let mut found = Vec::new();
                    eye_paths::ends(&mut walker, group, &mut ledger, &mut |source, luminance| {
                        let luminance = luminance * each;
                        let (x, density, pixel) = (drawn.x, drawn.density, pixel as u32);
                        let lumens = luminance * lumens;
                        found.push(Whole { lamp: 0, x, density, source, pixel, lumens, luminance });
                    });
                    (!found.is_empty()).then_some(found)
                };
                parallel::filter_map(shots.paths, &one)
            }
        }
    }
}

/// Paths along one chain as a pilot sees them.
struct Along<'a> {
    world: &'a World,
    of: (GroupId, &'a Chain, &'a [(Source, Way)]),
    side: Side,
    paths: u64,
}

impl Look for Along<'_> {
    fn probe(&self, pass: u64, stop: &ShouldStop<'_>) -> Vec<Sample> {
        let optics = Mono::<f64>::optics(self.world, pilots::SEED, 0);
        let shots =
            Shots { seed: pilots::SEED, stream: Stream::Pilot, pass, paths: self.paths, starts: Starts::OfPass };
        let sample = |found: Vec<Whole>| {
            let first = found.first()?;
            let light: f64 = found.iter().map(|whole| weight(self.world, whole.lumens, whole.luminance)).sum();
            let weight = light * first.density * self.paths as f64;
            (weight > 0.0 && weight.is_finite()).then_some(Sample { lamp: first.lamp, x: first.x, weight })
        };
        self.side.run((self.world, &optics), self.of, shots, stop).into_iter().filter_map(sample).collect()
    }
    fn density(&self, lamp: usize, x: &Point) -> f64 {
        match &self.side {
            Side::Lamps(emission) => emission.density(lamp, x),
            Side::Eye { guide, .. } => guide.density(&EYE, lamp, x),
        }
    }
    fn flux(&self) -> &[f64] {
        self.side.flux()
    }
    fn group_of(&self, _: usize) -> GroupId {
        GroupId(0) // a chain is of one group
    }
}

/// Paths after which a chain of this share of its group's light is known well enough, if they were independent.
fn paths_for(share: f64, spread: f64) -> f64 {
    let error = ERROR * (BRIGHT / share).max(1.0).sqrt();
    let [least, most] = PATHS;
    (spread / (error * error)).clamp(least, most)
}

impl Directed {
    /// Learns where the light of a chain starts; none where no look found any of it. `starts`: some on lamps, some at
    /// the eye; shares: of all light, and of the group's.
    pub fn learn(
        start: Start<'_>,
        (group, chain): (GroupId, Chain),
        [share, of_group]: [f64; 2],
        starts: [Vec<Sample>; 2],
        stop: &ShouldStop<'_>,
    ) -> Option<Directed> {
        let world = start.world;
        let back = chain.reversed();
        // As the emission numbers them.
        let mut sources = start.lamps.map_or_else(Vec::new, |lamps| lamps.sources.clone());
        let own = lamp_paths::sources_of(world, group).into_iter().filter(|source| !sources.contains(source));
        sources.extend(own.collect::<Vec<_>>());
        let ways = sources.into_iter().map(|source| (source, Way::Vision(Source::visits(Some(source), world, &chain))));
        let ways: Vec<(Source, Way)> = ways.collect();
        let of = (group, &chain, ways.as_slice());
        let with = |eye: bool, guide: &Guide, paths: u64| {
            let side = match start.lamps.filter(|_| !eye) {
                Some(_) => Side::Lamps(Emission::new(world, start.route, start.groups, Some(guide))),
                None => Side::Eye { guide: guide.clone(), back: back.clone() },
            };
            Along { world, of, side, paths }
        };
        let [on_lamps, at_eye] = starts;
        let mut from_eye = Narrow::new(&EYE, at_eye);
        from_eye.look(|guide, paths| with(true, guide, paths), FIRST, stop);
        // Groups that are found from the eye have no emission.
        let from_lamps = start.lamps.filter(|_| !start.is_from_eye(group)).map(|lamps| {
            let mut narrow = Narrow::new(lamps.emission.flux(), on_lamps);
            narrow.look(|guide, paths| with(false, guide, paths), FIRST, stop);
            narrow
        });
        let (eye, mut narrow) = match from_lamps {
            Some(from_lamps) if from_lamps.is_better(&from_eye) => (false, from_lamps),
            Some(_) | None => (true, from_eye),
        };
        for paths in LONGER {
            let before = narrow.spread;
            if paths as f64 > paths_for(of_group, before) || stop() {
                break;
            }
            narrow.look(|guide, paths| with(eye, guide, paths), paths, stop);
            if narrow.spread < WILD && narrow.spread > GAIN * before {
                break;
            }
        }
        if narrow.spread.is_infinite() {
            return None;
        }
        let (guide, spread) = (narrow.learn(), narrow.spread);
        if stop() {
            return None;
        }
        let side = with(eye, &guide, 0).side;
        Some(Directed { group, side, ways, share, of_group, spread, chain })
    }

    /// Paths that measure the chain's light.
    pub fn paths(&self) -> f64 {
        paths_for(self.of_group, self.spread)
    }

    /// Whether any of its light comes by one of these ways.
    pub fn is_of(&self, ways: &[(GroupId, Way)]) -> bool {
        ways.iter().any(|(group, way)| *group == self.group && self.ways.iter().any(|(_, own)| own == way))
    }

    /// One pass: what each path that arrived brought, in their order.
    pub fn run<M: Mode>(&self, tracing: (&World, &Optics<M>), shots: Shots, stop: &ShouldStop<'_>) -> Vec<Vec<Caught>> {
        let caught = |Whole { source, pixel, lumens, luminance, .. }: Whole| {
            let (_, way) = self.ways.iter().find(|(own, _)| *own == source)?;
            let caught = Caught { group: self.group, source, way: way.clone(), pixel, lumens, luminance, trace: None };
            luminance.is_finite().then_some(caught)
        };
        let path = |found: Vec<Whole>| found.into_iter().filter_map(caught).collect();
        let of = (self.group, &self.chain, self.ways.as_slice());
        self.side.run(tracing, of, shots, stop).into_iter().map(path).collect()
    }
}
