//! How the tables are filled: trains as rays from the eye find them, node by node, and cell by cell on trial.

use super::eye_hit::{EyeHit, EyeHits, OVER_PUPIL};
use super::first_scatterer::to_scatterer;
use super::tuning::make::{LEAST, LITTLE, LOOKS, MOST, POOR, SHARP, WORTH};
use super::{EyeTable, Glance, OUTER, Use, follow};
use crate::ledger::Ledger;
use crate::manifold::receiver::Receivers;
use crate::manifold::solver::bicubic::{SIDES, Spot};
use crate::specular_event::Faint;
use crate::walk::{Travel, Vertex, Walker};
use eyebox_base::chain::{Chain, Link};
use eyebox_base::parallel;
use eyebox_base::rng::{Rng, Stream};
use eyebox_world::World;
use eyebox_world::geometry::Ray;
use eyebox_world::interior::Interior;
use eyebox_world::mode::{LaneArray, Mode, lanes};
use eyebox_world::optics::Optics;
use eyebox_world::stokes::Amount;
use eyebox_world::surface::Surface;
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;

/// Where a cell is tried, in radii of the pupil.
const TRIALS: [DVec2; 4] = [DVec2::new(0.6, 0.3), DVec2::new(-0.3, 0.6), DVec2::new(-0.6, -0.3), DVec2::new(0.3, -0.6)];

/// The ray itself is always followed.
const NONE: Use = Use { share: 1.0, off: f64::INFINITY, known: 0, in_part: 0, whole: false, aside: [0; 2] };

/// What rays on trial say of a table.
#[derive(Debug, Clone, Copy)]
struct Trial {
    /// By how much it is off, as a share.
    off: f64,
    /// What light it brings.
    weight: f64,
    /// Some rays do not land.
    cut: bool,
}

/// Specular faces, and the scatterer behind them as (part, face).
type Way = (Chain, (u32, u32));

type Tracing<'t, M> = (&'t World, &'t Optics<M>);

impl<M: Mode> EyeTable<M> {
    pub(super) fn make(mut self, tracing: Tracing<'_, M>, screens: &Receivers<M>) -> Self {
        let trains = self.trains(tracing, screens);
        let best = trains.iter().fold(0.0, |best: f64, (_, weight)| best.max(*weight));
        for (index, ((chain, face), weight)) in trains.into_iter().enumerate() {
            let usable = index < MOST && chain.0.iter().all(|link| is_smooth(tracing.0, link));
            let glance = if usable { self.fill(tracing, (chain, face), weight / best) } else { None };
            if glance.is_none() && weight > LITTLE * best {
                // Light that only followed rays bring: they must not be few.
                self.glances.clear();
                break;
            }
            self.glances.extend(glance);
        }
        let cells: Vec<usize> = self.over.nodes.cells().collect();
        let uses: Vec<(usize, Use)> = parallel::map_all(&cells, &|cell| (*cell, self.use_of(tracing, *cell)));
        self.uses = vec![NONE; self.over.nodes.number()];
        for (cell, usage) in uses {
            self.uses[cell] = usage;
        }
        self
    }

    /// The trains over which rays from the eye come to faces that are joined with lamps, those with the most light first.
    fn trains(&self, (world, optics): Tracing<'_, M>, screens: &Receivers<M>) -> Vec<(Way, f64)> {
        let mut found: BTreeMap<Way, f64> = BTreeMap::new();
        let mut ledger = Ledger::new(world.solids.len());
        for k in 0..LOOKS * LOOKS {
            let at = DVec2::new((k % LOOKS) as f64 + 0.5, (k / LOOKS) as f64 + 0.5) / LOOKS as f64;
            let film = self.over.film_at(at);
            let rng = Rng::new(0, Stream::Pilot, 5, k as u64);
            let walker = start((world, optics), film, DVec2::ZERO, rng).recording();
            let all = Faint { whole: 1.0, often: f64::INFINITY };
            to_scatterer(walker, all, &mut ledger, &mut |walker: &mut Walker<'_, M>, vertex: &Vertex, _, _, _| {
                let face = (vertex.hit.site.part, vertex.hit.site.face);
                let chain = walker.chain().filter(|_| screens.has_face(face));
                if let Some(chain) = chain {
                    *found.entry((chain.clone(), face)).or_default() += walker.beam.weight();
                }
            });
        }
        let best = found.values().fold(0.0, |a: f64, b| a.max(*b));
        let mut found: Vec<_> = found.into_iter().filter(|(_, weight)| *weight >= WORTH * best).collect();
        found.sort_by(|a, b| b.1.total_cmp(&a.1));
        found
    }

    /// Follows a ray over a train to a face.
    fn follow<'w>(
        &self,
        tracing: Tracing<'w, M>,
        (film, pupil): (DVec2, DVec2),
        chain: &Chain,
        face: (u32, u32),
    ) -> Option<(Walker<'w, M>, Vertex)> {
        follow(start(tracing, film, pupil, Rng::new(0, Stream::Pilot, 6, 0)), chain, face)
    }

    fn fill(&self, tracing: Tracing<'_, M>, (chain, face): Way, share: f64) -> Option<Glance<M>> {
        let over_pupil = |k: usize| DVec2::new(k as f64 % 3.0 - 1.0, (k / 3) as f64 - 1.0) * (OUTER * self.radius);
        let landed = |at: usize| -> [Option<(Walker<'_, M>, Vertex)>; OVER_PUPIL] {
            let film = self.over.film(self.over.nodes.at_node(at));
            std::array::from_fn(|k| self.follow(tracing, (film, over_pupil(k)), &chain, face))
        };
        let first = (0..self.over.nodes.number()).find_map(|at| landed(at).into_iter().flatten().next());
        let (walker, vertex) = first?;
        if vertex.then.is_some() || vertex.back.is_some() {
            // What lies on it there is not known here.
            return None;
        }
        // What the nodes do not say has to be the same everywhere.
        let alike = |(other, at): &(Walker<'_, M>, Vertex)| {
            let touching =
                |vertex: &Vertex| vertex.touching.map(|other| (other.site.part, other.site.face, other.flush));
            other.trail == walker.trail
                && other.told == walker.told
                && other.interior == walker.interior
                && at.outside == vertex.outside
                && touching(at) == touching(&vertex)
        };
        let node = |at: usize| -> (bool, Option<Vec<EyeHit<M>>>) {
            let all = landed(at);
            let any = all.iter().any(Option::is_some);
            let landing = |one: &Option<(Walker<'_, M>, Vertex)>| one.as_ref().filter(|one| alike(one)).map(landing);
            (any, all.iter().map(landing).collect())
        };
        let (lands, nodes): (Vec<bool>, Vec<_>) = parallel::map(self.over.nodes.number(), &node).into_iter().unzip();
        let Walker { trail, told, interior, events, .. } = walker;
        Some(Glance { chain, share, vertex, trail, told, interior, events, lands, landings: EyeHits::new(&nodes) })
    }

    /// How a cell is to be used, by rays through its middle.
    fn use_of(&self, tracing: Tracing<'_, M>, cell: usize) -> Use {
        let middle = self.over.nodes.at_node(cell) + 0.5;
        // Those nodes by which most light is known.
        let known = |spot: &Spot| -> f64 {
            let whole = |glance: &&Glance<M>| spot.nodes().all(|(node, _)| glance.landings.has(node));
            self.glances.iter().filter(whole).map(|glance| glance.share).sum()
        };
        let spots = SIDES.iter().filter_map(|aside| Some((*aside, self.over.nodes.spot_by(middle, *aside)?)));
        let Some((aside, spot)) = spots.rev().max_by(|a, b| known(&a.1).total_cmp(&known(&b.1))) else { return NONE };
        let film = self.over.film(middle);
        let (mut known, mut in_part, mut worst, mut best, mut always) = (0u32, 0u32, 0f64, 0f64, false);
        for (k, glance) in self.glances.iter().enumerate() {
            let has = |(node, _): &(usize, f64)| glance.landings.has(*node);
            let count = spot.nodes().filter(has).count();
            let trial = if count == 16 { self.error(tracing, glance, &spot, film) } else { None };
            // Where a part of the pupil is cut off tables are of use where rays are always followed, but only if there is much.
            let cut = trial.is_some_and(|trial| trial.cut);
            let seldom = cut && (glance.is_faint() || self.share_beside(tracing, glance, film, best) <= LITTLE);
            let Some(Trial { off, weight, .. }) = trial.filter(|_| !seldom) else {
                if glance.is_faint() {
                    let beside = self.over.nodes.spot(middle).into_iter().flat_map(|spot| spot.nodes());
                    let lands = spot.nodes().chain(beside).any(|(node, _)| glance.lands[node]);
                    in_part |= u32::from(lands) << k;
                    continue;
                }
                // Its light is left to the rays that are followed: of much of it all are.
                always |= !seldom && self.share_beside(tracing, glance, film, best) > LITTLE;
                continue;
            };
            always |= cut;
            best = best.max(weight);
            known |= 1 << k;
            worst = worst.max(off * weight / best);
        }
        if known == 0 {
            return NONE;
        }
        let whole = !TRIALS.iter().any(|trial| self.lands_elsewhere(tracing, film, *trial * self.radius));
        let off = worst / POOR;
        let share = if always { 1.0 } else { off.clamp(LEAST, 1.0) };
        Use { share, off, known, in_part, whole, aside }
    }

    /// Whether a ray meets scatterers that no train of ours leads to.
    fn lands_elsewhere(&self, tracing: Tracing<'_, M>, film: DVec2, pupil: DVec2) -> bool {
        let mut ledger = Ledger::new(tracing.0.solids.len());
        let mut elsewhere = false;
        let walker = start(tracing, film, pupil, Rng::new(0, Stream::Pilot, 6, 2));
        to_scatterer(
            walker,
            Faint { whole: 1.0, often: 1.0 },
            &mut ledger,
            &mut |_: &mut Walker<'_, M>, vertex: &Vertex, _, _, _| {
                let face = (vertex.hit.site.part, vertex.hit.site.face);
                elsewhere |= !self.glances.iter().any(|glance| glance.face() == face);
            },
        );
        // Narrow lobes, and what leaves its class.
        elsewhere || ledger.not_owned > 0.0
    }

    /// Of the light of the best train, the share that comes over another one to a place in the picture.
    fn share_beside(&self, tracing: Tracing<'_, M>, glance: &Glance<M>, film: DVec2, best: f64) -> f64 {
        let face = glance.face();
        let weight = |trial: &DVec2| {
            let found = self.follow(tracing, (film, *trial * self.radius), &glance.chain, face);
            found.map_or(0.0, |(walker, _)| walker.beam.weight())
        };
        let most = TRIALS.iter().map(weight).fold(0.0, f64::max);
        if best > 0.0 { most / best } else { most }
    }

    /// A table of a train in the middle of a cell; none where no ray lands.
    fn error(&self, tracing: Tracing<'_, M>, glance: &Glance<M>, spot: &Spot, film: DVec2) -> Option<Trial> {
        let (mut worst, mut light, mut cut, mut any) = (0f64, 0f64, false, false);
        let point = |node: usize| Some(glance.landings.middle(node)?.point);
        // The first two are neighbours in a row, and known.
        let mut nodes = spot.nodes().map(|(node, _)| point(node));
        let pixel_m = nodes.next()??.distance(nodes.next()??) / self.over.pixels;
        for trial in TRIALS {
            let pupil = trial * self.radius;
            let Some((walker, vertex)) = self.follow(tracing, (film, pupil), &glance.chain, glance.face()) else {
                cut = true;
                continue;
            };
            any = true;
            let look = self.look_at(*spot, pupil, None);
            let blend = glance.landings.blend(&look.rows, &look.pupil)?;
            let (table, _) = glance.land(tracing, &blend, 1.0, Rng::new(0, Stream::Pilot, 6, 1))?;
            let real = landing(&(walker, vertex));
            let of_lane = |lane: usize| (table.beam.amount(lane).power() / real.weight[lane] - 1.0).abs();
            let strength = (0..M::LANES).map(of_lane).fold(0.0, f64::max);
            let place = SHARP * blend.point.distance(real.point) / pixel_m;
            let turned = blend.dir.normalize_or_zero().distance(real.dir);
            worst = worst.max(strength + place + turned);
            light = light.max(real.weight.as_slice().iter().sum::<f64>() / M::LANES as f64);
        }
        (any && worst.is_finite()).then_some(Trial { off: worst, weight: light, cut })
    }
}

/// Whether what a face of a train lets through is smooth: a slide's picture is not, and a lobe beside a reflection is chance.
fn is_smooth(world: &World, link: &Link) -> bool {
    let face = world.faces.get(link.part as usize).and_then(|faces| faces.get(link.face as usize));
    face.is_some_and(|face| !matches!(face.surface, Surface::Slide(_) | Surface::Scatter(_)))
}

fn start<'w, M: Mode>((world, optics): Tracing<'w, M>, film: DVec2, pupil: DVec2, rng: Rng) -> Walker<'w, M> {
    let (origin, (_, dir), ..) = world.eye.ray_of(film, pupil);
    let ray = Ray { origin, dir, from: None };
    Walker::new((world, optics), Travel::FromEye, ray, 1.0, Interior::default(), rng)
}

fn landing<M: Mode>((walker, vertex): &(Walker<'_, M>, Vertex)) -> EyeHit<M> {
    let weight = lanes::<M, _>(|lane| walker.beam.amount(lane).power());
    let point: DVec3 = vertex.hit.point;
    EyeHit { point, dir: walker.ray.dir, weight }
}
