//! Pilots: small deterministic runs that measure what facts do not tell.

use super::shared_faces;
use crate::base::ids::GroupId;
use crate::base::rng::{Rng, Stream};
use crate::estimate::ShouldStop;
use crate::estimate::emission::Starts;
use crate::estimate::forward::Forward;
use crate::estimate::ledger::Ledger;
use crate::estimate::manifold::screens::Screens;
use crate::estimate::photon::{Landing, PhotonMapper};
use crate::estimate::route::Route;
use crate::estimate::seen::Seen;
use crate::estimate::walk::{Meeting, Met, Travel, Walker};
use crate::film::guide::{Even, Guide, Point, Sample};
use crate::film::plan::{Estimator, Plan, Radii};
use crate::film::train::Screen;
use crate::world::World;
use crate::world::geometry::Ray;
use crate::world::interior::Interior;
use crate::world::mode::{Mode, Mono};
use crate::world::optics::Optics;
use glam::DVec3;
use std::cmp::Ordering;
use std::sync::Arc;

/// Paths of the first look, which knows nothing; most of them if little is found; and of each look after it.
const WIDE: u64 = 1 << 13;
const MOST_WIDE: u64 = 1 << 16;
const NARROW: [u64; 2] = [1 << 11, 3 << 11];
/// Paths that have to count before a look can be guided by them, in all and of each group.
const ENOUGH: [usize; 2] = [48, 4];
/// A pass that no look has.
const LAST: u64 = 1 << 20;
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
    /// A guide for the very light that the pilot has looked for: few paths are spent on what may be elsewhere.
    pub fn sure(&self) -> Guide {
        Guide::learn(&self.flux, &self.found, Even::FEW)
    }
}

/// An estimator's paths with one guide, as a pilot sees them.
pub(super) trait Look {
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

/// Photons, and where they are gathered.
struct Photons<'w> {
    mapper: PhotonMapper<'w, Mono>,
    seen: &'w Seen,
}

impl Look for Photons<'_> {
    fn probe(&self, pass: u64, stop: &ShouldStop<'_>) -> Vec<Sample> {
        self.mapper.probe(pass, self.seen, stop)
    }
    fn density(&self, lamp: usize, x: &Point) -> f64 {
        self.mapper.density(lamp, x)
    }
    fn flux(&self) -> &[f64] {
        self.mapper.flux()
    }
    fn group_of(&self, lamp: usize) -> GroupId {
        self.mapper.group_of(lamp)
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

/// Learns where lamp paths have to start to arrive in the picture.
pub fn forward(world: &World, plan: &Plan, groups: usize, stop: &ShouldStop<'_>) -> ForwardPilot {
    let with = |guide: Option<&Guide>, paths: u64| {
        let route = Route::new(plan, groups, Estimator::Forward);
        Forward::<Mono>::new(world, route, groups, paths, guide, Arc::default(), SEED).starting(Starts::OfPass)
    };
    pilot(with, || shared_faces::may_meet(world, plan, groups, stop), groups, stop)
}

/// A pilot of paths to the picture, see [`look`].
pub(super) fn pilot<L: Look>(
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
pub(super) struct Narrow<L: Look> {
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

/// What photons are for a plan: where they start, how many there are, and within which radii they are gathered.
pub struct PhotonPilot {
    pub guide: Guide,
    pub photons: u64,
    /// They part at interfaces.
    pub part: bool,
    pub radii_m: Radii,
}

/// Photons per pixel by the share of the light that connection leaves to them, and their limits.
const PER_PIXEL: f64 = 8.0;
const FEWEST: f64 = 0.125;
const MOST: f64 = 4.0;
/// Share of the light below which a small picture needs fewer photons than others of its size.
const LITTLE: f64 = 0.03;
/// Photons to be gathered in the first pass, and the most of the radius in distances between what neighbouring pixels see.
/// Scattered light is soft: on scene A1 twelve pixels blur it by less than 1 % (5e-5 of relMSE), and four pixels blur its
/// caustic more than their noise would be.
const SOFT: (f64, f64) = (64.0, 12.0);
/// Pixels of the longer side for one of blur: what is soft in a large picture is not in a small one.
const PER_BLUR: f64 = 20.0;
const SHARP: (f64, f64) = (16.0, 2.0);

/// Learns what photons the plan needs. `pixel_m`: the distance between what neighbouring pixels see; `seen`: at that.
pub fn photon(
    world: &World,
    plan: &Plan,
    groups: usize,
    (pixel_m, seen): (f64, &Seen),
    stop: &ShouldStop<'_>,
) -> PhotonPilot {
    const PATHS: u64 = 1 << 12;
    /// A photon that parts is as much work as so many that do not.
    const PARTED_WORK: u64 = 16;
    let optics = Mono::<f64>::optics(world, SEED, 0);
    let radii = Radii { caustic: pixel_m, secondary: pixel_m };
    let with = |guide: Option<&Guide>, paths: u64, screens: &Arc<Screens<Mono>>| {
        let route = Route::new(plan, groups, Estimator::Photon);
        PhotonMapper::new(world, route, groups, paths, guide, radii, screens.clone(), SEED).starting(Starts::OfPass)
    };
    // What specular connection owns of the paths is bright where the rest is, too: one guide for both.
    let nothing = Arc::new(Screens::new(world, &optics, &[]));
    let pixels = world.eye.size().iter().product::<usize>() as u64;
    if seen.is_empty() {
        // Nowhere to gather, nothing to learn.
        let guide = Guide::unguided(with(None, 1, &nothing).flux());
        return PhotonPilot { guide, photons: 1, part: false, radii_m: radii };
    }
    let (_, guide) = look(|guide, paths| Photons { mapper: with(guide, paths, &nothing), seen }, || true, groups, stop);
    let coarse = |screens: &[Screen]| Screens::coarse(world, &optics, screens);
    let (strong, weak) = by_light(&plan.screens);
    let land = |connected: &Arc<Screens<Mono>>, part: bool| {
        let paths = if part { PATHS / PARTED_WORK } else { PATHS };
        (with(Some(&guide), paths, connected).parting(part).landings(LAST), paths)
    };
    // Photons that part tell best what little is left by the trains with most of the light. The others are worth their
    // tables only where it is little.
    let strong = Arc::new(coarse(&strong));
    let part = !strong.is_empty() && rest_share(world, &land(&strong, true).0, seen) < LITTLE;
    let (landings, paths) = if part { land(&Arc::new(strong.and(&coarse(&weak))), true) } else { land(&strong, false) };
    // Photons for a little light need not be many.
    let rest = rest_share(world, &landings, seen);
    let photons = (pixels as f64 * (PER_PIXEL * rest).clamp(FEWEST, MOST)) as u64;
    let photons = photons.max(if rest < LITTLE { 1 << 12 } else { 1 << 14 });
    let photons = if part { photons / PARTED_WORK } else { photons };
    let radius = |counts: &dyn Fn(&Landing) -> bool, (gathered, most_blur): (f64, f64)| {
        let of_pilot = spacing(&landings, seen, counts);
        of_pilot.map_or(pixel_m, |of_pilot| {
            (of_pilot * (gathered * paths as f64 / photons as f64).sqrt()).clamp(pixel_m, most_blur * pixel_m)
        })
    };
    let longer = world.eye.size().into_iter().max().unwrap_or(1) as f64;
    let soft = (SOFT.0, SOFT.1.min(longer / PER_BLUR).max(1.0));
    // Of a little light a soft picture errs less than a noisy one.
    let little = (SHARP.0, soft.1);
    let secondary = radius(&|landing| landing.scattered, if part { little } else { soft });
    let sharp = if part { little } else { SHARP };
    let caustic = radius(&|landing| !landing.scattered && !landing.connected, sharp);
    PhotonPilot { guide, photons, part, radii_m: Radii { caustic, secondary } }
}

/// Trains with less of a face's light than this are connected only where almost all else is.
const STRONG: f64 = 2e-3;

/// The trains with more, and the others.
pub fn by_light(screens: &[Screen]) -> (Vec<Screen>, Vec<Screen>) {
    screens.iter().cloned().partition(|screen| screen.share >= STRONG)
}

/// Of what the eye sees by the photons, the share that specular connection leaves to them.
fn rest_share(world: &World, landings: &[Landing], seen: &Seen) -> f64 {
    let (mut all, mut rest) = (0.0, 0.0);
    for landing in landings {
        let light = landing.lumens * seen.brightness(world, landing);
        all += light;
        rest += if landing.connected { 0.0 } else { light };
    }
    if all > 0.0 { rest / all } else { 1.0 }
}

/// The radius about what the eye sees within which one of the photons that count has landed: the median over points, m;
/// none if there are too few.
fn spacing(landings: &[Landing], seen: &Seen, counts: &dyn Fn(&Landing) -> bool) -> Option<f64> {
    const NEIGHBOURS: usize = 8;
    const POINTS: usize = 256;
    let counted: Vec<&Landing> = landings.iter().filter(|landing| counts(landing)).collect();
    let step = seen.points().len().div_ceil(POINTS).max(1);
    let mut radii: Vec<f64> = seen
        .points()
        .iter()
        .step_by(step)
        .map(|sight| {
            let of_face = (sight.site.part, sight.site.face);
            let here = counted.iter().filter(|landing| (landing.site.part, landing.site.face) == of_face);
            let mut distances: Vec<f64> = here.map(|landing| landing.position.distance(sight.point)).collect();
            if distances.len() < NEIGHBOURS {
                return f64::INFINITY;
            }
            *distances.select_nth_unstable_by(NEIGHBOURS - 1, f64::total_cmp).1 / (NEIGHBOURS as f64).sqrt()
        })
        .collect();
    let middle = radii.len() / 2;
    let median = (!radii.is_empty()).then(|| *radii.select_nth_unstable_by(middle, f64::total_cmp).1)?;
    median.is_finite().then_some(median)
}

/// Groups whose light no path of a pilot brought.
pub fn without_arrivals(pilot: &ForwardPilot) -> Vec<GroupId> {
    (0..pilot.arrived.len()).filter(|&g| pilot.arrived[g] == 0).map(GroupId::from_index).collect()
}

/// The median distance between the points that neighbouring pixels see on broad scatterers, m. Falls back to
/// 1/500 of the scene if no pixel sees one.
pub fn pixel_m(world: &World, [width, height]: [usize; 2]) -> f64 {
    const GRID: usize = 24;
    let optics = Mono::<f64>::optics(world, 0, 0);
    let start = (world, &optics);
    let mut spacings = Vec::new();
    for j in 0..GRID {
        for i in 0..GRID {
            let (x, y) = ((2 * i + 1) * width / (2 * GRID), (2 * j + 1) * height / (2 * GRID));
            let neighbour = if x + 1 < width { (x + 1, y) } else { (x.saturating_sub(1), y) };
            for salt in 0..4 {
                // The same random choices for both rays: they take the same faces unless they meet different ones.
                let here = first_broad(start, (x, y), salt);
                let there = first_broad(start, neighbour, salt);
                if let (Some((face, a)), Some((other, b))) = (here, there)
                    && face == other
                    && a != b
                {
                    spacings.push(a.distance(b));
                }
            }
        }
    }
    spacings.sort_by(f64::total_cmp);
    match spacings.get(spacings.len() / 2) {
        Some(median) => *median,
        None => {
            let (low, high) = world.geometry.bounds();
            (high - low).length() / 500.0
        }
    }
}

fn first_broad(
    (world, optics): (&World, &Optics<Mono>),
    (x, y): (usize, usize),
    salt: u64,
) -> Option<((u32, u32), DVec3)> {
    let (origin, dir) = world.eye.ray(x, y, [0.5; 2], [0.5; 2]);
    let rng = Rng::new(0, Stream::Pilot, 0, salt);
    let ray = Ray { origin, dir, from: None };
    let mut walker = Walker::new((world, optics), Travel::FromEye, ray, 1.0, Interior::default(), rng);
    let mut ledger = Ledger::new(world.solids.len());
    for _ in 0..64 {
        let Met::Face(vertex) = walker.advance(&mut ledger) else { return None };
        match walker.meet(&vertex, &mut ledger) {
            Meeting::Ended => return None,
            Meeting::Went => {}
            Meeting::Scatter(scatter, frame) if scatter.is_narrow() => {
                walker.scatter(&vertex, scatter, &frame, &mut ledger)?;
            }
            Meeting::Scatter(..) => {
                return Some(((vertex.hit.site.part, vertex.hit.site.face), vertex.hit.point));
            }
        }
    }
    None
}
