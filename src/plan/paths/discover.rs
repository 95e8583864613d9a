//! Which chains of faces bring light from the lamps to the eye, and some starts of paths for each, found from both sides: a
//! lamp that is imaged into the pupil is found from the eye, one that is a speck in the picture from itself.

use super::chain_sampling::{All, Directed, weight};
use super::eye_paths::EyePaths;
use super::lamp_paths::{self, Split, Trace};
use super::start_side::Lamps;
use super::tuning::discover::{
    ENOUGH, KEPT_CHAINS, KEPT_STARTS, LEAST_LOOKS, LOOKS, MOST, MOST_LOOKS, MOST_STARTS, WORTH,
};
use crate::pilots;
use eyebox_base::chain::Chain;
use eyebox_base::ids::GroupId;
use eyebox_base::parallel;
use eyebox_base::rng::{Rng, Stream};
use eyebox_estimate::ShouldStop;
use eyebox_estimate::emission::{Shots, Starts};
use eyebox_estimate::ledger::Ledger;
use eyebox_estimate::ownership::Ownership;
use eyebox_estimate::walk::{Travel, Walker};
use eyebox_film::guide::{Point, Sample};
use eyebox_world::World;
use eyebox_world::geometry::Ray;
use eyebox_world::mode::{Mode, Mono};
use eyebox_world::optics::Optics;
use std::collections::BTreeMap;

/// What is needed to start paths.
#[derive(Clone, Copy)]
pub(super) struct Start<'a> {
    pub world: &'a World,
    pub route: &'a Ownership,
    pub groups: usize,
    /// Paths from the lamps; none if all is found from the eye.
    pub lamps: Option<&'a Lamps>,
    /// Per group: its light is found from the eye alone.
    pub eye: &'a [bool],
}

impl Start<'_> {
    pub fn is_from_eye(&self, group: GroupId) -> bool {
        self.eye.get(group.index()) == Some(&true)
    }
}

/// What one side found of a chain: its light, lm, and starts of its paths, weighted with it.
#[derive(Default)]
struct Half {
    lumens: f64,
    squares: f64,
    starts: Vec<Sample>,
}

impl Half {
    fn add(&mut self, sample: Sample) {
        self.lumens += sample.weight;
        self.squares += sample.weight * sample.weight;
        if self.starts.len() < KEPT_STARTS {
            self.starts.push(sample);
        }
    }

    /// Number of equally bright paths that would tell as much.
    fn effective(&self) -> f64 {
        if self.squares > 0.0 { self.lumens * self.lumens / self.squares } else { 0.0 }
    }
}

/// What was found of a chain.
#[derive(Default)]
pub(super) struct Found {
    from_lamps: Half,
    from_eye: Half,
    /// Where paths from the lamps arrived, as starts of paths from the eye.
    arrived: Half,
    /// Ends of some paths from the eye.
    traces: Vec<Trace>,
}

impl Found {
    /// By the side that knows more.
    fn lumens(&self) -> f64 {
        if self.from_eye.effective() > self.from_lamps.effective() {
            self.from_eye.lumens
        } else {
            self.from_lamps.lumens
        }
    }

    /// Starts on lamps, and starts at the eye.
    pub fn starts(&self) -> [Vec<Sample>; 2] {
        let eye = if self.from_eye.effective() > self.arrived.effective() { &self.from_eye } else { &self.arrived };
        [self.from_lamps.starts.clone(), eye.starts.clone()]
    }

    fn is_known(&self) -> bool {
        self.from_eye.starts.len().max(self.from_lamps.starts.len()) >= ENOUGH
    }
}

type Chains = BTreeMap<(GroupId, Chain), Found>;

/// Finds the chains with at least `least` of all light and learns where the light of each starts, most light first.
pub(super) fn discover(start: Start<'_>, split: Split, least: f64, stop: &ShouldStop<'_>) -> All {
    let mut chains = Chains::new();
    let optics = Mono::<f64>::optics(start.world, pilots::SEED, 0);
    let mut looks = 0;
    while looks < MOST_LOOKS && !stop() {
        from_lamps(start, &optics, (looks, split), &mut chains, stop);
        from_eye(start, &optics, (looks, split), &mut chains, stop);
        looks += 1;
        let all: f64 = chains.values().map(Found::lumens).sum();
        let enough = looks >= LEAST_LOOKS;
        if enough && chains.values().all(|found| found.lumens() < WORTH * all || found.is_known()) {
            break;
        }
    }
    let mut groups: BTreeMap<GroupId, f64> = BTreeMap::new();
    chains.iter().for_each(|((group, _), found)| *groups.entry(*group).or_default() += found.lumens());
    let all: f64 = groups.values().sum();
    let shares = |(group, _): &(GroupId, Chain), found: &Found| {
        [all, groups.get(group).copied().unwrap_or(all)].map(|all| found.lumens() / all)
    };
    let mut chains: Vec<_> = chains.into_iter().filter(|(_, found)| found.lumens() >= least * all).collect();
    // Equals stay in the order of their faces.
    chains.sort_by(|(_, a), (_, b)| b.lumens().total_cmp(&a.lumens()));
    let lamps = start.lamps.map_or(1, |lamps| lamps.sources.len());
    chains.truncate(MOST.min(MOST_STARTS / lamps.max(1)));
    let learned = parallel::map_all(&chains, &|(key, found)| {
        let wanted = start.is_from_eye(key.0) || is_the_lamps(start.world, &optics, &key.1, found);
        let shares = wanted.then(|| shares(key, found))?;
        Directed::learn(start, key.clone(), shares, found.starts(), stop)
    });
    All::new(learned.into_iter().flatten().collect())
}

/// The entry of a chain, a new one if there is room.
fn known(chains: &mut Chains, key: (GroupId, Chain)) -> Option<&mut Found> {
    let room = chains.len() < KEPT_CHAINS || chains.contains_key(&key);
    if room { Some(chains.entry(key).or_default()) } else { None }
}

fn shots(look: u64, side: u64) -> Shots {
    let pass = (1 << 21) + 2 * look + side;
    Shots { seed: pilots::SEED, stream: Stream::Pilot, pass, paths: LOOKS, starts: Starts::OfPass }
}

fn from_lamps(
    Start { world, lamps, .. }: Start<'_>,
    optics: &Optics<Mono>,
    (look, split): (u64, Split),
    chains: &mut Chains,
    stop: &ShouldStop<'_>,
) {
    let Some(Lamps { emission, .. }) = lamps else { return };
    let visitor = || lamp_paths::Arrivals::new(split);
    let take = |lamp: usize, x: Point, _: f64, arrivals: lamp_paths::Arrivals| {
        let found = arrivals.found();
        (!found.is_empty()).then_some((lamp, x, found))
    };
    for (lamp, x, found) in emission.survey((world, optics), shots(look, 0), stop, visitor, take) {
        for arrived in found {
            let Some(known) = known(chains, (arrived.group, arrived.chain)) else { continue };
            known.from_lamps.add(Sample { lamp, x, weight: arrived.lumens });
            let x = world.eye.unit_of(arrived.film, arrived.pupil);
            known.arrived.add(Sample { lamp: 0, x, weight: arrived.lumens });
        }
    }
}

fn from_eye(
    start: Start<'_>,
    optics: &Optics<Mono>,
    (look, split): (u64, Split),
    chains: &mut Chains,
    stop: &ShouldStop<'_>,
) {
    // Ends that are kept of a chain.
    const KEPT: usize = 8;
    let world = start.world;
    let from_lamps = |group: GroupId| {
        start
            .lamps
            .is_some_and(|lamps| (0..lamps.sources.len()).any(|lamp| lamps.emission.group_of(world, lamp) == group))
    };
    let looked: Vec<bool> =
        (0..start.groups).map(GroupId::from_index).map(|group| start.is_from_eye(group) || from_lamps(group)).collect();
    let vision = |group: GroupId| looked.get(group.index()) == Some(&true);
    let owned = &All::default();
    let looking = EyePaths { world, optics, split, vision: &vision, owned, traces: true, scattered: None };
    for caught in looking.run(shots(look, 1), stop).into_iter().flatten() {
        let Some(trace) = caught.trace else { continue };
        // What is found from lamps has a place on a face.
        if trace.end.is_none() && !start.is_from_eye(caught.group) {
            continue;
        }
        let Some(known) = known(chains, (caught.group, trace.chain.clone())) else { continue };
        known.from_eye.add(Sample { lamp: 0, x: trace.start, weight: weight(world, caught.lumens, caught.luminance) });
        if known.traces.len() < KEPT {
            known.traces.push(*trace);
        }
    }
}

/// Whether paths from the lamps call the chain the same. Where faces lie on each other the side may decide which of them is
/// met, and light must not count twice.
fn is_the_lamps(world: &World, optics: &Optics<Mono>, chain: &Chain, found: &Found) -> bool {
    !found.from_lamps.starts.is_empty() || found.traces.iter().any(|trace| is_met_from(world, optics, chain, trace.end))
}

fn is_met_from(world: &World, optics: &Optics<Mono>, chain: &Chain, end: Option<lamp_paths::LampEnd>) -> bool {
    let Some(end) = end else { return false };
    let Some(interior) = world.lamp_interiors.get(end.lamp) else { return false };
    let ray = Ray { origin: end.point, dir: -end.dir, from: Some(end.site) };
    let rng = Rng::new(pilots::SEED, Stream::Pilot, 3, 0);
    let walker = Walker::new((world, optics), Travel::FromLamp, ray, 1.0, *interior, rng);
    let mut walker = walker.from_face(end.normal);
    let mut ledger = Ledger::new(world.solids.len());
    walker.follow_to_pupil(chain.0.iter().copied(), &mut ledger).is_some()
}
