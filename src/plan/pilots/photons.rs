//! The photons' pilot: where they start, how many there are, and within which radii they are gathered.

use super::pilot_cache::PilotCache;
use super::tuning::photons::{FEWEST, FEWEST_GUIDED, MOST, PER_BLUR, PER_PIXEL, SHARP, SOFT, STRONG};
use super::{LAST, LITTLE, Look, SEED, look};
use eyebox_base::ids::GroupId;
use eyebox_base::rng::{Rng, Stream};
use eyebox_estimate::ShouldStop;
use eyebox_estimate::emission::Starts;
use eyebox_estimate::ledger::Ledger;
use eyebox_estimate::manifold::receiver::Receivers;
use eyebox_estimate::ownership::Ownership;
use eyebox_estimate::photon::visible_receivers::{Sighting, VisibleReceivers};
use eyebox_estimate::photon::{Landed, Landing, PhotonMapper};
use eyebox_estimate::walk::{Meeting, Met, Travel, Walker};
use eyebox_film::guide::{Guide, Point, Sample};
use eyebox_film::plan::{Estimator, Plan, Radii};
use eyebox_film::specular_chain::Screen;
use eyebox_world::World;
use eyebox_world::geometry::Ray;
use eyebox_world::interior::Interior;
use eyebox_world::mode::{Mode, Mono};
use eyebox_world::optics::Optics;
use glam::DVec3;
use std::sync::Arc;

/// Photons, and where they are gathered.
struct Photons<'w> {
    mapper: PhotonMapper<'w, Mono>,
    seen: &'w VisibleReceivers,
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

/// What photons are for a plan: where they start, how many there are, and within which radii they are gathered.
pub struct PhotonPilot {
    pub guide: Guide,
    pub photons: u64,
    /// They part at interfaces.
    pub part: bool,
    pub radii_m: Radii,
}

/// Learns what photons the plan needs. `pixel_m`: the distance between what neighbouring pixels see; `seen`: at that.
pub(crate) fn photon(
    world: &World,
    plan: &Plan,
    groups: usize,
    (pixel_m, seen): (f64, &VisibleReceivers),
    made: &PilotCache,
    stop: &ShouldStop<'_>,
) -> PhotonPilot {
    const PATHS: u64 = 1 << 12;
    /// A photon that parts is as much work as so many that do not.
    const PARTED_WORK: u64 = 16;
    /// By so many it is seen whether connection leaves little.
    const PARTED_FIRST: u64 = 1 << 6;
    let optics = Mono::<f64>::optics(world, SEED, 0);
    let radii = Radii { caustic: pixel_m, secondary: pixel_m };
    let with = |guide: Option<&Guide>, paths: u64, screens: &Arc<Receivers<Mono>>| {
        let route = Ownership::new(plan, groups, Estimator::Photon);
        PhotonMapper::new(world, route, groups, paths, guide, radii, screens.clone(), SEED).starting(Starts::OfPass)
    };
    let nothing = Arc::new(Receivers::new(world, &optics, &[]));
    let pixels = world.eye.size().iter().product::<usize>() as u64;
    if seen.is_empty() {
        // Nowhere to gather, nothing to learn.
        let guide = Guide::unguided(with(None, 1, &nothing).flux());
        return PhotonPilot { guide, photons: 1, part: false, radii_m: radii };
    }
    // By all light of the faces, connected or not.
    let (looks, mut guide) =
        look(|guide, paths| Photons { mapper: with(guide, paths, &nothing), seen }, || true, groups, stop);
    let coarse = |screens: &[Screen]| made.screens(world, screens);
    let (strong, weak) = by_light(&plan.screens);
    let land = |guide: &Guide, paths: u64, connected: &Arc<Receivers<Mono>>, part: bool| {
        with(Some(guide), paths, connected).parting(part).landings(LAST, stop)
    };
    // Photons that part tell best what little is left by the trains with most of the light. The others are worth their
    // tables only where it is little.
    let strong = Arc::new(coarse(&strong));
    let part = !strong.is_empty() && rest_share(world, &land(&guide, PARTED_FIRST, &strong, true), seen) < LITTLE;
    let mut knows_rest = false;
    let (landed, paths) = if part {
        let paths = PATHS / PARTED_WORK;
        let landed = land(&guide, paths, &Arc::new(strong.and(&coarse(&weak))), true);
        // The little that is left starts elsewhere than the light that all looks were for.
        if let Some(learned) = looks.learn_rest(&of_rest(world, &landed, seen)) {
            (guide, knows_rest) = (learned, true);
        }
        (landed, paths)
    } else {
        (land(&guide, PATHS, &strong, false), PATHS)
    };
    // Photons for a little light need not be many.
    let rest = rest_share(world, &landed, seen);
    let landings: Vec<Landing> = landed.into_iter().flat_map(|path| path.landings).collect();
    let fewest = if knows_rest { FEWEST_GUIDED } else { FEWEST };
    let photons = (pixels as f64 * (PER_PIXEL * rest).clamp(fewest, MOST)) as u64;
    let photons = photons.max(if rest < LITTLE { 1 << 12 } else { 1 << 14 });
    let photons = if part { photons / PARTED_WORK } else { photons };
    let radius = |at: &dyn Fn(&&Sighting) -> bool, counts: &Counts<'_>, (gathered, most_blur): (f64, f64)| {
        let of_pilot = spacing(&landings, seen, at, counts);
        of_pilot.map_or(pixel_m, |of_pilot| {
            (of_pilot * (gathered * paths as f64 / photons as f64).sqrt()).clamp(pixel_m, most_blur * pixel_m)
        })
    };
    let longer = world.eye.size().into_iter().max().unwrap_or(1) as f64;
    let soft = (SOFT.0, SOFT.1.min(longer / PER_BLUR).max(1.0));
    // Of a little light a soft picture errs less than a noisy one.
    let little = (SHARP.0, soft.1);
    let scattered = |landing: &Landing| landing.trail.has_scatter();
    // What is seen by another scatterer is soft, whatever brings it.
    let at_soft = |sight: &Sighting, landing: &Landing| sight.is_second() || scattered(landing);
    let secondary = radius(&|sight| sight.takes_scattered(), &at_soft, if part { little } else { soft });
    let sharp = if part { little } else { SHARP };
    let at_sharp = |_: &Sighting, landing: &Landing| !scattered(landing) && !landing.connected;
    let caustic = radius(&|sight| !sight.is_second(), &at_sharp, sharp);
    PhotonPilot { guide, photons, part, radii_m: Radii { caustic, secondary } }
}

/// Whether a train has more.
pub fn is_strong(screen: &Screen) -> bool {
    screen.share >= STRONG
}

/// The trains with more, and the others.
pub fn by_light(screens: &[Screen]) -> (Vec<Screen>, Vec<Screen>) {
    screens.iter().cloned().partition(is_strong)
}

/// Of what the eye sees by the photons, the share that specular connection leaves to them.
fn rest_share(world: &World, landed: &[Landed], seen: &VisibleReceivers) -> f64 {
    let (mut all, mut rest) = (0.0, 0.0);
    for landing in landed.iter().flat_map(|path| &path.landings) {
        let (shown, left) = seen.shown(world, landing);
        all += shown;
        rest += left;
    }
    if all > 0.0 { rest / all } else { 1.0 }
}

/// Starts of paths, weighted with what the eye sees of them that specular connection leaves.
fn of_rest(world: &World, landed: &[Landed], seen: &VisibleReceivers) -> Vec<Sample> {
    let start = |path: &Landed| {
        let weight = path.landings.iter().map(|landing| seen.shown(world, landing).1).sum::<f64>();
        (weight > 0.0).then_some(Sample { lamp: path.lamp, x: path.x, weight })
    };
    landed.iter().filter_map(start).collect()
}

/// Whether a photon counts where it is seen.
type Counts<'c> = dyn Fn(&Sighting, &Landing) -> bool + 'c;

/// The radius about what the eye sees within which one of the photons that count has landed: the median over the points
/// `at` which they might, m; none if there are too few.
fn spacing(
    landings: &[Landing],
    seen: &VisibleReceivers,
    at: &dyn Fn(&&Sighting) -> bool,
    counts: &Counts<'_>,
) -> Option<f64> {
    const NEIGHBOURS: usize = 8;
    const POINTS: usize = 256;
    let sights: Vec<&Sighting> = seen.points().iter().filter(at).collect();
    let step = sights.len().div_ceil(POINTS).max(1);
    let mut radii: Vec<f64> = sights
        .iter()
        .step_by(step)
        .map(|sight| {
            let here = landings.iter().filter(|landing| {
                landing.site.is_on_face_of(sight.site) && sight.takes(landing) && counts(sight, landing)
            });
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
