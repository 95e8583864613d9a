//! Pilots: small deterministic runs that measure what facts do not tell.

#[cfg(test)]
mod border_tests;
pub mod chains;
pub(super) mod eye_pilot;
pub mod glint_pilot;
mod photons;
pub(super) mod pilot_cache;
pub(super) mod pilot_resolution;
pub mod pupil;
pub(super) mod pupil_guide;
pub(super) mod reached;
pub(super) mod shared_faces;
pub(super) mod sky_guide;
pub(super) mod split_threshold;
#[cfg(test)]
mod tests;
mod tuning;

use eyebox_base::ids::GroupId;
use eyebox_estimate::ShouldStop;
use eyebox_estimate::emission::Starts;
use eyebox_estimate::forward::Forward;
use eyebox_estimate::manifold::seeds::bands::Bands;
use eyebox_estimate::manifold::seeds::connections::Connections;
use eyebox_estimate::ownership::Ownership;
use eyebox_film::guide::{Even, Guide, Point, Sample};
use eyebox_film::plan::{Estimator, Plan, Row, Verdict};
use eyebox_world::World;
use eyebox_world::mode::Mono;
pub(crate) use photons::photon;
pub use photons::{by_light, is_strong, pixel_m};
use std::cmp::Ordering;
use std::sync::Arc;
use tuning::pilots::{ENOUGH, ENOUGH_OF_REST, FEWEST, LAST, LEFT, LITTLE, MOST_WIDE, NARROW, OF_LIGHT, WIDE};

/// Pilots have a seed of their own: the plan is a function of the scene alone.
pub const SEED: u64 = 0x9107;

/// What a pilot of the forward estimator found.
pub struct ForwardPilot {
    pub guide: Guide,
    /// Per light group: paths that arrived in the picture.
    pub arrived: Vec<u64>,
    /// Paths that were traced.
    pub traced: u64,
    flux: Vec<f64>,
    /// What the guide was learned from.
    found: Vec<Sample>,
}

impl ForwardPilot {
    /// No path arrived, and eyes and lamps were not found to share a face: there is hardly a path between them.
    pub fn is_hopeless(&self) -> bool {
        self.traced <= WIDE && self.arrived.iter().all(|paths| *paths == 0)
    }

    /// A guide for the very light that the pilot has looked for: few paths are spent on what may be elsewhere.
    pub fn sure(&self) -> Guide {
        Guide::learn(&self.flux, &self.found, Even::FEW)
    }
}

/// An estimator's paths with one guide, as a pilot sees them.
pub(crate) trait Look {
    fn probe(&self, pass: u64, stop: &ShouldStop<'_>) -> Vec<Sample>;
    fn density(&self, lamp: usize, x: &Point) -> f64;
    fn flux(&self) -> &[f64];
    fn group_of(&self, lamp: usize) -> GroupId;
}

impl Look for Forward<'_, Mono> {
    fn probe(&self, pass: u64, stop: &ShouldStop<'_>) -> Vec<Sample> {
        self.probe(pass, stop)
    }
    fn density(&self, lamp: usize, x: &Point) -> f64 {
        self.density(lamp, x)
    }
    fn flux(&self) -> &[f64] {
        self.flux()
    }
    fn group_of(&self, lamp: usize) -> GroupId {
        self.group_of(lamp)
    }
}

/// Looks taken so far.
struct Looks<L> {
    /// Each with its number of paths.
    looks: Vec<(L, u64)>,
    /// What they found, weighted as each look alone would: light times density.
    found: Vec<Sample>,
    /// Per light group: paths that counted.
    arrived: Vec<u64>,
}

impl<L: Look> Looks<L> {
    fn new(groups: usize) -> Self {
        Looks { looks: Vec::new(), found: Vec::new(), arrived: vec![0; groups] }
    }

    fn take(&mut self, look: L, paths: u64, stop: &ShouldStop<'_>) {
        let found = look.probe(self.looks.len() as u64, stop);
        found.iter().for_each(|sample| self.arrived[look.group_of(sample.lamp).index()] += 1);
        self.found.extend(found);
        self.looks.push((look, paths));
    }

    /// What all looks teach together: each sample weighs what it found over the density of all paths that might have
    /// started there (the balance heuristic of E. Veach, 1997).
    fn learn(&self) -> Guide {
        Guide::learn(self.flux(), &self.weighted(), Even::MANY)
    }

    /// Flux of each lamp, lm.
    fn flux(&self) -> &[f64] {
        self.looks.first().map_or(&[], |(first, _)| first.flux())
    }

    fn weighted(&self) -> Vec<Sample> {
        let weighted = |sample: &Sample| {
            let paths = self.looks.iter().map(|(look, paths)| *paths as f64 * look.density(sample.lamp, &sample.x));
            Sample { weight: sample.weight / paths.sum::<f64>(), ..*sample }
        };
        self.found.iter().map(weighted).collect()
    }

    /// A guide for light that connection leaves: half by what all looks found, for the light that it has nearly all of may be
    /// left where its tables end, and half by what it was seen to leave. None if that is too little to learn from, or nearly
    /// all one path's: with so much weight it would hide what the looks found.
    fn learn_rest(&self, rest: &[Sample]) -> Option<Guide> {
        let weights = rest.iter().map(|sample| sample.weight);
        let (sum, squares) = weights.fold((0.0, 0.0), |(sum, squares), w| (sum + w, squares + w * w));
        if sum * sum < ENOUGH_OF_REST * squares || squares <= 0.0 {
            return None;
        }
        let half = |samples: &[Sample]| {
            let sum: f64 = samples.iter().map(|sample| sample.weight).sum();
            let scaled = |sample: &Sample| Sample { weight: 0.5 * sample.weight / sum, ..*sample };
            samples.iter().map(scaled).filter(|sample| sample.weight.is_finite()).collect::<Vec<Sample>>()
        };
        Some(Guide::learn(self.flux(), &[half(&self.weighted()), half(rest)].concat(), Even::MANY))
    }

    fn traced(&self) -> u64 {
        self.looks.iter().map(|(_, paths)| paths).sum()
    }

    /// Whether a guided look is worth its paths.
    fn enough(&self) -> bool {
        let Some((first, _)) = self.looks.first() else { return false };
        let each = (0..first.flux().len()).all(|lamp| self.arrived[first.group_of(lamp).index()] as usize >= ENOUGH[1]);
        each && self.found.len() >= ENOUGH[0]
    }
}

/// Looks for paths that count: first everywhere, until there are some, then where they came from. `with`: the estimator
/// with a guide (none: by flux and intensity) and a number of paths. `worth`: whether it is worth going on if the first look
/// has found nothing.
fn look<L: Look>(
    with: impl Fn(Option<&Guide>, u64) -> L,
    worth: impl Fn() -> bool,
    groups: usize,
    stop: &ShouldStop<'_>,
) -> (Looks<L>, Guide) {
    let mut looks = Looks::new(groups);
    let wide = Guide::wide(with(None, 1).flux());
    while !looks.enough() && looks.traced() < MOST_WIDE && !stop() {
        let paths = looks.traced().max(WIDE);
        looks.take(with(Some(&wide), paths), paths, stop);
        if looks.looks.len() == 1 && looks.found.is_empty() && !worth() {
            break;
        }
    }
    for paths in NARROW {
        if looks.found.is_empty() || stop() {
            break;
        }
        let guide = looks.learn();
        looks.take(with(Some(&guide), paths), paths, stop);
    }
    let guide = looks.learn();
    (looks, guide)
}

/// Whether paths start on a row's lamps to arrive in the pupil.
pub(super) fn starts_paths(row: &Row) -> bool {
    match &row.verdict {
        Verdict::Own { owner: by, .. } | Verdict::Connect { rest: by, .. } => *by == Estimator::Forward,
        Verdict::Emitted { .. } => true,
        Verdict::Skip { .. } => false,
    }
}

/// Learns where lamp paths have to start to arrive in the picture.
pub fn forward(world: &World, plan: &Plan, groups: usize, stop: &ShouldStop<'_>) -> ForwardPilot {
    let with = |guide: Option<&Guide>, paths: u64| {
        let route = Ownership::new(plan, groups, Estimator::Forward);
        Forward::<Mono>::new(world, route, groups, paths, guide, Arc::default(), SEED).starting(Starts::OfPass)
    };
    pilot(with, || shared_faces::may_meet(world, plan, groups, stop), groups, stop)
}

/// Of the light that arrives in the picture, the share that the plan's connections leave to light tracing: the largest of
/// any light group. `pilot`: of all of it; `connections`: the plan's.
pub fn left(
    world: &World,
    plan: &Plan,
    groups: usize,
    pilot: &ForwardPilot,
    connections: Arc<Connections>,
    stop: &ShouldStop<'_>,
) -> f64 {
    let route = Ownership::new(plan, groups, Estimator::Forward);
    let connections = Arc::new(Bands::from(connections));
    let forward = Forward::<Mono>::new(world, route, groups, LEFT, Some(&pilot.guide), connections, SEED);
    let forward = forward.starting(Starts::OfPass);
    let sums = |samples: &mut dyn Iterator<Item = (usize, f64)>| {
        let mut sums = vec![0.0; groups];
        samples.for_each(|(lamp, light)| sums[forward.group_of(lamp).index()] += light);
        sums
    };
    let of_path = |s: &Sample| (s.lamp, s.weight / (LEFT as f64 * forward.density(s.lamp, &s.x)));
    let rest = sums(&mut forward.probe(LAST, stop).iter().map(of_path));
    let all = sums(&mut pilot.found.iter().map(|s| (s.lamp, s.weight)));
    let shares = rest.iter().zip(&all).filter(|(_, all)| **all > 0.0).map(|(rest, all)| rest / all);
    shares.fold(0.0, f64::max).min(1.0)
}

/// Paths per pass for light tracing with this share of the light, in a picture of so many pixels.
pub fn forward_paths(share: f64, pixels: u64) -> u64 {
    let per_pixel = (OF_LIGHT[1] * 2.0 * share).clamp(OF_LIGHT[0], OF_LIGHT[1]);
    let fewest = if share < LITTLE { FEWEST[0] } else { FEWEST[1] };
    ((pixels as f64 * per_pixel) as u64).max(fewest)
}

/// A pilot of paths to the picture, see [`look`].
pub(crate) fn pilot<L: Look>(
    with: impl Fn(Option<&Guide>, u64) -> L,
    worth: impl Fn() -> bool,
    groups: usize,
    stop: &ShouldStop<'_>,
) -> ForwardPilot {
    let (looks, guide) = look(with, worth, groups, stop);
    let (flux, found) = (looks.flux().to_vec(), looks.weighted());
    ForwardPilot { guide, traced: looks.traced(), arrived: looks.arrived, flux, found }
}

/// Looks that narrow down where paths start of which some starts are known.
pub(crate) struct Narrow<L: Look> {
    looks: Looks<L>,
    flux: Vec<f64>,
    known: Vec<Sample>,
    /// Variance of a path over its mean squared, by the last look; infinite if that found nothing.
    pub spread: f64,
}

impl<L: Look> Narrow<L> {
    /// `known`: starts, each weighted with its light.
    pub fn new(flux: &[f64], known: Vec<Sample>) -> Self {
        Narrow { looks: Looks::new(1), flux: flux.to_vec(), known, spread: f64::INFINITY }
    }

    /// What was learned. What was known and what the looks found are both light by start; each has as much say as it has
    /// points.
    pub fn learn(&self) -> Guide {
        let mut all = by_effect(self.known.clone());
        all.extend(by_effect(self.looks.weighted()));
        Guide::learn(&self.flux, &all, Even::MANY)
    }

    /// Paths tell more than those of another; where neither found anything, more was known before.
    pub fn is_better(&self, other: &Self) -> bool {
        match self.spread.total_cmp(&other.spread) {
            Ordering::Less => true,
            Ordering::Greater => false,
            Ordering::Equal => self.known.len() > other.known.len(),
        }
    }

    /// Paths of all looks that counted.
    pub fn found(&self) -> usize {
        self.looks.found.len()
    }

    /// A look guided by all before. `with`: the paths with a guide and their number.
    pub fn look(&mut self, with: impl Fn(&Guide, u64) -> L, paths: u64, stop: &ShouldStop<'_>) {
        let before = self.looks.found.len();
        self.looks.take(with(&self.learn(), paths), paths, stop);
        self.spread = spread(&self.looks, before).unwrap_or(f64::INFINITY);
    }
}

/// The same samples, with the number of equally heavy ones that would tell as much as the sum of their weights.
fn by_effect(mut samples: Vec<Sample>) -> Vec<Sample> {
    let sums = samples.iter().fold((0.0, 0.0), |(sum, squares), s| (sum + s.weight, squares + s.weight * s.weight));
    if sums.1 > 0.0 {
        samples.iter_mut().for_each(|sample| sample.weight *= sums.0 / sums.1);
    }
    samples
}

/// The variance of a path of the last look, which found all samples from `first` on, over its mean squared.
fn spread<L: Look>(looks: &Looks<L>, first: usize) -> Option<f64> {
    let (look, paths) = looks.looks.last()?;
    let found = looks.found.get(first..)?;
    let brought = found.iter().map(|sample| sample.weight / look.density(sample.lamp, &sample.x));
    let (sum, squares) = brought.fold((0.0, 0.0), |(sum, squares), x| (sum + x, squares + x * x));
    (sum > 0.0).then(|| (*paths as f64 * squares / (sum * sum) - 1.0).max(0.0))
}

/// Groups whose light no path of a pilot brought.
pub fn without_arrivals(pilot: &ForwardPilot) -> Vec<GroupId> {
    (0..pilot.arrived.len()).filter(|&g| pilot.arrived[g] == 0).map(GroupId::from_index).collect()
}
