//! A pilot that finds the trains of specular faces by which the light of each group reaches the pupil.

use super::eye_pilot;
use super::reached::is_reached;
use super::tuning::chains::{LEAST, LEAST_ON_FACE, MOST_SPLITS, PATHS, SCREEN_SEEDS, SEEDS, WORTH, WORTH_ON_FACE};
use eyebox_base::chain::Chain;
use eyebox_base::ids::GroupId;
use eyebox_base::path::Class;
use eyebox_base::rng::{Rng, Stream};
use eyebox_estimate::ShouldStop;
use eyebox_estimate::emission::{Emission, Origin, Shots, Starts, Visitor};
use eyebox_estimate::ledger::Ledger;
use eyebox_estimate::ownership::Ownership;
use eyebox_estimate::splitting::Splitting;
use eyebox_estimate::walk::{Travel, Vertex, Walker};
use eyebox_film::guide::Guide;
use eyebox_film::plan::{Estimator, MOST_ENTRIES, MOST_LIT, Plan};
use eyebox_film::specular_chain::{Connection, Lens, Screen, ScreenSeed, Seed, SpecularChain};
use eyebox_world::World;
use eyebox_world::eye::Arrival;
use eyebox_world::geometry::{Ray, Site};
use eyebox_world::interior::Interior;
use eyebox_world::mode::{Mode, Mono};
use eyebox_world::optics::Optics;
use eyebox_world::scatter::Scatter;
use glam::{DVec2, DVec3};
use std::collections::{BTreeMap, BTreeSet};

/// Pilots have a seed of their own: the plan is a function of the scene alone.
pub(crate) const SEED: u64 = 0x77a1;

/// Light that arrived over one chain, and where.
pub(crate) struct Arrived {
    pub group: GroupId,
    /// From the lamp.
    pub chain: Chain,
    pub lamp: usize,
    pub film: DVec2,
    pub pupil: DVec2,
    /// Place on the lamp and its normal there.
    pub on_lamp: [DVec3; 2],
    /// What it adds to the sum of all pixels' luminance, cd/m².
    pub luminance: f64,
}

struct Arrivals {
    found: Vec<Arrived>,
    both: Splitting,
}

impl Default for Arrivals {
    fn default() -> Self {
        Arrivals { found: Vec::new(), both: Splitting::new(LEAST, MOST_SPLITS) }
    }
}

impl Visitor<Mono> for Arrivals {
    fn split_from(&self, walker: &Walker<'_, Mono>) -> Option<f64> {
        self.both.from(walker)
    }
    fn most_splits(&self) -> u8 {
        u8::MAX
    }
    fn records(&self) -> bool {
        true
    }
    fn pupil(&mut self, walker: &Walker<'_, Mono>, from: Origin, arrival: &Arrival) {
        if arrival.pixel.is_none() || walker.trail.class_from_lamp() != Class::Vision {
            return;
        }
        if let (Some(chain), Some((lamp, point, normal))) = (walker.chain(), from.face) {
            // With the slides open: a dark place of the picture has the same trains.
            let luminance = walker.beam.weight() * arrival.luminance_per_lumen;
            let (film, pupil) = (arrival.film, arrival.pupil);
            let on_lamp = [point, normal];
            self.found.push(Arrived { group: from.group, chain: chain.clone(), lamp, film, pupil, on_lamp, luminance });
        }
    }
    fn scatterer(&mut self, _: &Walker<'_, Mono>, _: Origin, _: &Vertex, _: &Scatter) {}
}

/// What the pilot found.
pub struct Found {
    /// Brightest first.
    pub connections: Vec<Connection>,
    /// Share of the light on trains that are not among them: the largest of any light group that has some.
    pub left: f64,
}

/// The connections worth making for the groups whose vision paths the plan gives to specular connection. Once `stop` says true the rest is left out, and the result is worthless.
pub fn find(world: &World, plan: &Plan, groups: usize, guide: Option<&Guide>, stop: &ShouldStop<'_>) -> Found {
    let route = Ownership::new(plan, groups, Estimator::Manifold);
    let emission = Emission::new(world, &Ownership::new(plan, groups, Estimator::Forward), groups, guide);
    let optics = Mono::<f64>::optics(world, SEED, 0);
    let shots = Shots { seed: SEED, stream: Stream::Pilot, pass: 0, paths: PATHS, starts: Starts::OfPass };
    let all = emission.survey((world, &optics), shots, stop, Arrivals::default, |_, _, _, arrivals: Arrivals| {
        (!arrivals.found.is_empty()).then_some(arrivals.found)
    });
    let mut totals = vec![0.0; groups];
    let mut chains: BTreeMap<(GroupId, Chain), Vec<Arrived>> = BTreeMap::new();
    for arrived in all.into_iter().flatten() {
        if route.share(arrived.group, Class::Vision, false).is_some() {
            totals[arrived.group.index()] += arrived.luminance;
            chains.entry((arrived.group, arrived.chain.clone())).or_default().push(arrived);
        }
    }
    // What only rays from the eye have found; of the other chains they know more lamps and places.
    let mut reached: BTreeMap<(GroupId, Chain), bool> = BTreeMap::new();
    let mut glimpses: BTreeMap<(GroupId, Chain), Vec<Arrived>> = BTreeMap::new();
    for arrived in eye_pilot::look((world, &optics), stop) {
        if route.share(arrived.group, Class::Vision, false).is_some() {
            glimpses.entry((arrived.group, arrived.chain.clone())).or_default().push(arrived);
        }
    }
    for (key, arrived) in &chains {
        let seen = glimpses.get(key).map_or(&[][..], Vec::as_slice);
        reached.insert(key.clone(), is_reached(arrived, seen));
    }
    for (key, mut arrived) in glimpses {
        match chains.get_mut(&key) {
            Some(known) => known.extend(arrived.into_iter().map(|a| Arrived { luminance: 0.0, ..a })),
            None => {
                arrived.retain(|a| a.luminance > 0.0);
                totals[key.0.index()] += arrived.iter().map(|a| a.luminance).sum::<f64>();
                chains.insert(key, arrived);
            }
        }
    }
    let mut found: Vec<Connection> = chains
        .into_iter()
        .filter_map(|((group, chain), arrived)| {
            let luminance: f64 = arrived.iter().map(|a| a.luminance).sum();
            let share = luminance / totals[group.index()];
            if share.is_nan() || share < WORTH {
                return None;
            }
            let train = arrived.iter().find_map(|a| train((world, &optics), &chain, a.film, a.pupil))?;
            let reached = reached.get(&(group, chain)).is_some_and(|reached| *reached);
            Some(Connection { group, train, seeds: seeds(&arrived), share, reached })
        })
        .collect();
    found.sort_by(|a, b| b.share.total_cmp(&a.share));
    found.truncate(MOST_ENTRIES / world.lamps.all().len().max(1));
    // Groups without a train are not connected.
    let mut connected: BTreeMap<GroupId, f64> = BTreeMap::new();
    found.iter().for_each(|connection| *connected.entry(connection.group).or_default() += connection.share);
    let left = connected.into_values().map(|share| 1.0 - share).fold(0.0, f64::max);
    Found { connections: found, left }
}

/// A few arrivals of every lamp, apart from each other in the picture.
fn seeds(arrived: &[Arrived]) -> Vec<Seed> {
    let mut by_lamp: BTreeMap<usize, Vec<&Arrived>> = BTreeMap::new();
    arrived.iter().for_each(|a| by_lamp.entry(a.lamp).or_default().push(a));
    let mut seeds = Vec::new();
    for (lamp, all) in by_lamp {
        let mut kept: Vec<&Arrived> = Vec::new();
        while kept.len() < SEEDS.min(all.len()) {
            // The one that is farthest from those that are kept.
            let apart = |a: &Arrived| kept.iter().map(|k| k.film.distance(a.film)).fold(f64::INFINITY, f64::min);
            let Some(next) = all.iter().max_by(|a, b| apart(a).total_cmp(&apart(b))) else { break };
            kept.push(next);
        }
        seeds.extend(kept.iter().map(|a| Seed {
            lamp: lamp as u32,
            film: a.film.to_array(),
            pupil: a.pupil.to_array(),
        }));
    }
    seeds
}

/// The train of a chain from a lamp, as the ray from the eye through these places finds it.
pub(crate) fn train(
    tracing: (&World, &Optics<Mono>),
    chain: &Chain,
    film: DVec2,
    pupil: DVec2,
) -> Option<SpecularChain> {
    let (origin, (_, dir), ..) = tracing.0.eye.ray_of(film, pupil);
    follow(tracing, chain, Ray { origin, dir, from: None }, Interior::default())
}

/// The train that a ray meets if it follows a chain back to the lamp.
fn follow(
    (world, optics): (&World, &Optics<Mono>),
    chain: &Chain,
    ray: Ray,
    interior: Interior,
) -> Option<SpecularChain> {
    // The solver follows one wavelength, and Snell's law: what a grating bends is for paths to find.
    if chain.0.iter().any(|link| link.order != 0) {
        return None;
    }
    let rng = Rng::new(SEED, Stream::Pilot, 1, 0);
    let mut walker = Walker::new((world, optics), Travel::FromEye, ray, 1.0, interior, rng);
    let mut ledger = Ledger::new(world.solids.len());
    let links = chain.reversed().0;
    let mut order = links.iter();
    let mut train = SpecularChain::default();
    let whole = walker.follow(links.iter().copied(), &mut ledger, |before, vertex, after| {
        if let Some(link) = order.next() {
            train.0.push(Lens { link: *link, about: vertex.hit.local.to_array(), before, after });
        }
    });
    whole.then_some(train)
}

/// Light that met a scatterer over one chain.
struct Struck {
    group: GroupId,
    face: (u32, u32),
    chain: Chain,
    lamp: usize,
    place: DVec3,
    /// Towards where it came from.
    dir: DVec3,
    lumens: f64,
}

struct Strikes<'s> {
    seen: &'s BTreeSet<(u32, u32)>,
    both: Splitting,
    found: Vec<Struck>,
}

impl Visitor<Mono> for Strikes<'_> {
    fn split_from(&self, walker: &Walker<'_, Mono>) -> Option<f64> {
        if walker.trail.has_scatter() { None } else { self.both.from(walker) }
    }
    fn most_splits(&self) -> u8 {
        u8::MAX
    }
    fn records(&self) -> bool {
        true
    }
    fn pupil(&mut self, _: &Walker<'_, Mono>, _: Origin, _: &Arrival) {}
    fn scatterer(&mut self, walker: &Walker<'_, Mono>, from: Origin, vertex: &Vertex, scatter: &Scatter) {
        let face = (vertex.hit.site.part, vertex.hit.site.face);
        if walker.trail.has_scatter() || walker.trail.is_empty() || scatter.is_narrow() || !self.seen.contains(&face) {
            return;
        }
        // Which way light gets into the glass that it lies on is for paths to find.
        if walker.world.contacts.is_cover_or_covered(face.0, face.1) {
            return;
        }
        if let (Some(chain), Some((lamp, ..))) = (walker.chain(), from.face) {
            let (place, dir) = (vertex.hit.point, -walker.ray.dir);
            let lumens = walker.beam.weight();
            self.found.push(Struck { group: from.group, face, chain: chain.clone(), lamp, place, dir, lumens });
        }
    }
}

/// The connections of scatterers that the eye sees with lamps whose caustics the plan gives to specular connection. Once
/// `stop` says true the rest is left out, and the result is worthless.
pub fn screens(
    world: &World,
    plan: &Plan,
    groups: usize,
    seen: &BTreeSet<(u32, u32)>,
    guide: Option<&Guide>,
    stop: &ShouldStop<'_>,
) -> Vec<Screen> {
    let route = Ownership::new(plan, groups, Estimator::Manifold);
    let emission = Emission::new(world, &Ownership::new(plan, groups, Estimator::Photon), groups, guide);
    let optics = Mono::<f64>::optics(world, SEED, 0);
    let shots = Shots { seed: SEED, stream: Stream::Pilot, pass: 1, paths: PATHS, starts: Starts::OfPass };
    let visitor = || Strikes { seen, both: Splitting::new(LEAST_ON_FACE, MOST_SPLITS), found: Vec::new() };
    let all = emission.survey((world, &optics), shots, stop, visitor, |_, _, _, strikes: Strikes<'_>| {
        (!strikes.found.is_empty()).then_some(strikes.found)
    });
    let mut totals: BTreeMap<(GroupId, (u32, u32)), f64> = BTreeMap::new();
    let mut chains: BTreeMap<(GroupId, (u32, u32), Chain), Vec<Struck>> = BTreeMap::new();
    for struck in all.into_iter().flatten() {
        if route.share(struck.group, Class::Caustic, true).is_some() {
            *totals.entry((struck.group, struck.face)).or_default() += struck.lumens;
            chains.entry((struck.group, struck.face, struck.chain.clone())).or_default().push(struck);
        }
    }
    let mut found: Vec<Screen> = chains
        .into_iter()
        .filter_map(|((group, face, chain), struck)| {
            let lumens: f64 = struck.iter().map(|s| s.lumens).sum();
            let share = lumens / totals.get(&(group, face))?;
            if share.is_nan() || share < WORTH_ON_FACE {
                return None;
            }
            let train = struck.iter().find_map(|s| train_to((world, &optics), &chain, s))?;
            let (lo, hi) = struck
                .iter()
                .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), s| (lo.min(s.place), hi.max(s.place)));
            let step = struck.len().div_ceil(SCREEN_SEEDS);
            let seeds = struck
                .iter()
                .step_by(step)
                .map(|s| ScreenSeed { lamp: s.lamp as u32, place: s.place.to_array(), dir: s.dir.to_array() })
                .collect();
            let bounds = [lo.to_array(), hi.to_array()];
            Some(Screen { group, part: face.0, face: face.1, train, seeds, bounds, share })
        })
        .collect();
    found.sort_by(|a, b| b.share.total_cmp(&a.share));
    found.truncate(MOST_LIT / world.lamps.all().len().max(1));
    found
}

/// The train of a chain from a lamp to a scatterer, as the ray back from there finds it.
fn train_to((world, optics): (&World, &Optics<Mono>), chain: &Chain, struck: &Struck) -> Option<SpecularChain> {
    let from = Site { part: struck.face.0, face: struck.face.1, triangle: u32::MAX };
    let (lo, hi) = world.geometry.bounds();
    let interior =
        Interior::of(world.geometry.solids_containing(struck.place + struck.dir * (1e-9 * (hi - lo).length())));
    follow((world, optics), chain, Ray { origin: struck.place, dir: struck.dir, from: Some(from) }, interior)
}
