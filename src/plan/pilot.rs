//! Pilots: small deterministic runs that measure what facts do not tell.

use crate::base::ids::GroupId;
use crate::base::rng::{Rng, Stream};
use crate::estimate::ShouldStop;
use crate::estimate::forward::Forward;
use crate::estimate::ledger::Ledger;
use crate::estimate::photon::PhotonMapper;
use crate::estimate::route::Route;
use crate::estimate::walk::{Meeting, Met, Travel, Walker};
use crate::film::guide::Guide;
use crate::film::plan::{Estimator, Plan};
use crate::world::World;
use crate::world::geometry::Ray;
use crate::world::interior::Interior;
use crate::world::mode::{Mode, Mono};
use crate::world::optics::Optics;
use glam::DVec3;

/// Lamp paths per round of a pilot: a small picture is not worth many.
fn paths(world: &World) -> u64 {
    let [width, height] = world.eye.size();
    (2 * (width * height) as u64).clamp(1 << 15, 1 << 17)
}
const ROUNDS: u64 = 2;
/// Pilots have a seed of their own: the plan is a function of the scene alone.
const SEED: u64 = 0x9107;

/// What a pilot of the forward estimator found.
pub struct ForwardPilot {
    pub guide: Guide,
    /// Per light group: paths that arrived in the picture.
    pub arrived: Vec<u64>,
    /// Paths that were traced.
    pub traced: u64,
}

/// Learns where lamp paths have to start to arrive in the picture, in rounds that each use what the last one learned.
pub fn forward(world: &World, plan: &Plan, groups: usize, stop: &ShouldStop<'_>) -> ForwardPilot {
    let mut guide = None;
    let mut arrived = vec![0; groups];
    for round in 0..ROUNDS {
        let route = Route::new(plan, groups, Estimator::Forward);
        let forward = Forward::<Mono>::new(world, route, groups, paths(world), guide.as_ref(), SEED);
        let samples = forward.probe(round, stop);
        samples.iter().for_each(|(lamp, _, _)| arrived[forward.group_of(*lamp).index()] += 1);
        guide = Some(Guide::learn(forward.flux(), &samples));
    }
    ForwardPilot { guide: guide.unwrap_or_else(|| Guide::unguided(&[])), arrived, traced: ROUNDS * paths(world) }
}

/// Learns where photons have to start to be stored.
pub fn photon(world: &World, plan: &Plan, groups: usize, stop: &ShouldStop<'_>) -> Guide {
    let mut guide = None;
    for round in 0..ROUNDS {
        let route = Route::new(plan, groups, Estimator::Photon);
        let mapper = PhotonMapper::<Mono>::new(world, route, groups, paths(world), guide.as_ref(), 1.0, SEED);
        let samples = mapper.probe(round, stop);
        guide = Some(Guide::learn(mapper.flux(), &samples));
    }
    guide.unwrap_or_else(|| Guide::unguided(&[]))
}

/// Groups whose light no path of a pilot brought.
pub fn without_arrivals(pilot: &ForwardPilot) -> Vec<GroupId> {
    (0..pilot.arrived.len()).filter(|&g| pilot.arrived[g] == 0).map(GroupId::from_index).collect()
}

/// First gathering radius: the median distance between the points that neighbouring pixels see on broad scatterers, so
/// that a photon's disk is about a pixel's footprint. Falls back to 1/500 of the scene if no pixel sees one.
pub fn photon_radius_m(world: &World, [width, height]: [usize; 2]) -> f64 {
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
