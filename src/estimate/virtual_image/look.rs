//! Rays from the pupil's middle over the field of view, and what they and their branches meet that may be a picture.

use super::sent;
use super::subject::Kind;
use super::tuning::subject::{LOOKS, MOST_FACES};
use crate::ledger::Ledger;
use crate::specular_event::Branch;
use crate::walk::{Meeting, Met, Vertex, Walker};
use eyebox_base::chain::{Chain, Step};
use eyebox_film::specular_chain::{Lens, SpecularChain};
use eyebox_world::World;
use eyebox_world::grating::Grating;
use eyebox_world::mode::Mono;
use eyebox_world::optics::Optics;
use eyebox_world::surface::Surface;
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;

/// How far the branches of a ray are followed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Effort {
    /// The share of what a ray started with that a way on has to have.
    pub least: f64,
    pub most_branches: usize,
}

/// Light from the eye that met a face.
pub(super) struct Landed {
    /// Tangents.
    pub film: DVec2,
    pub place: DVec3,
    pub normal: DVec3,
    pub dir: DVec3,
    pub carried: f64,
    pub train: SpecularChain,
}

/// What rays met, by kind, part, face and chain.
pub(super) type Found = BTreeMap<Way, Vec<Landed>>;

/// Kind of the picture, part, face, and the chain that leads there.
pub(super) type Way = (Kind, u32, u32, Chain);

/// Sends rays from the pupil's middle through the middles of cells between two corners of the field of view (tangents).
/// `wanted`: the part that is looked for, or any; `effort`: how far ways on are followed.
pub(super) fn look_around(
    tracing: (&World, &Optics<Mono>),
    [low, high]: [DVec2; 2],
    (wanted, effort): (Option<u32>, Effort),
) -> Found {
    let world = tracing.0;
    let mut found = Found::new();
    for look in 0..LOOKS * LOOKS {
        let share = |i: usize| (i as f64 + 0.5) / LOOKS as f64;
        let film = low + (high - low) * DVec2::new(share(look % LOOKS), share(look / LOOKS));
        let (origin, (_, dir), ..) = world.eye.ray_of(film, DVec2::ZERO);
        follow(tracing, (origin, dir), effort, |kind, vertex, walker, train| {
            let site = vertex.hit.site;
            if wanted.is_none_or(|part| part == site.part) {
                found.entry((kind, site.part, site.face, train.chain())).or_default().push(Landed {
                    film,
                    place: vertex.hit.point + world.geometry.origin(),
                    normal: vertex.hit.normal,
                    dir,
                    carried: walker.beam.weight(),
                    train: train.clone(),
                });
            }
        });
    }
    found
}

/// The ways on from a grating with at least the share `least` of what the ray started with, most light first; at least one if
/// light goes on at all.
fn orders<'w>(
    walker: &Walker<'w, Mono>,
    vertex: &Vertex,
    grating: &Grating,
    least: f64,
    ledger: &mut Ledger,
) -> Vec<Walker<'w, Mono>> {
    // What is left may go straight on.
    let rest = (!grating.orders.numbers().any(|order| order == 0)).then_some(0);
    let both = |order: i32| [Step::Through, Step::Back].map(|step| (step, order));
    let mut ways: Vec<(f64, Walker<'w, Mono>)> = Vec::new();
    for way in grating.orders.numbers().chain(rest).flat_map(both) {
        let mut on = walker.clone();
        on.order = Some(way);
        if matches!(on.meet(vertex, ledger), Meeting::Went) {
            ways.push((on.beam.weight(), on));
        }
    }
    ways.sort_by(|a, b| b.0.total_cmp(&a.0));
    let followed = ways.iter().skip(1).take_while(|(weight, _)| *weight >= least).count();
    ways.into_iter().take(1 + followed).map(|(_, way)| way).collect()
}

/// Follows a ray and its branches to the faces that may be a picture.
pub(super) fn follow<'w>(
    tracing: (&'w World, &'w Optics<Mono>),
    (origin, dir): (DVec3, DVec3),
    effort: Effort,
    mut each: impl FnMut(Kind, &Vertex, &Walker<'w, Mono>, &SpecularChain),
) {
    let mut ledger = Ledger::new(tracing.0.solids.len());
    let mut open = vec![(sent(tracing, origin, dir).recording(), SpecularChain::default(), 0)];
    let mut branches = 1;
    while let Some((mut walker, mut train, already)) = open.pop() {
        for met in already..MOST_FACES {
            let Met::Face(vertex) = walker.advance(&mut ledger) else { break };
            let site = vertex.hit.site;
            let picture = match &walker.face(&vertex).surface {
                Surface::Slide(_) => Some(Kind::Slide),
                Surface::Scatter(_) if train.0.is_empty() => Some(Kind::Object),
                Surface::Scatter(_) => Some(Kind::Image),
                Surface::Absorber
                | Surface::Absent
                | Surface::Sheet(_)
                | Surface::Splitter(_)
                | Surface::Grating(_)
                | Surface::Mirror(_)
                | Surface::Interface(_) => None,
            };
            let lamp = || tracing.0.lamps.of_face(site.part as usize, site.face as usize);
            let shines = || if train.0.is_empty() { Kind::Object } else { Kind::Image };
            if let Some(kind) = picture.or_else(|| lamp().map(|_| shines())) {
                each(kind, &vertex, &walker, &train);
                break;
            }
            let before = walker.part_around();
            if let Surface::Grating(grating) = &walker.face(&vertex).surface
                && !walker.is_passed(&vertex, &mut ledger)
            {
                let mut ways = orders(&walker, &vertex, grating, effort.least, &mut ledger);
                ways.truncate(1 + effort.most_branches.saturating_sub(branches));
                branches += ways.len().saturating_sub(1);
                // The brightest is followed first.
                for mut way in ways.into_iter().rev() {
                    way.events = way.events.min(1);
                    let mut on = train.clone();
                    linked(&mut on, &way, &vertex, before);
                    open.push((way, on, met + 1));
                }
                break;
            }
            let share = walker.beam.weight();
            let other = if branches < effort.most_branches && share > effort.least {
                walker.split(&vertex, effort.least / share, u8::MAX, &mut ledger)
            } else {
                None
            };
            // Nothing is left to chance: where one way is too faint to be followed the other one is.
            if walker.forced.is_none()
                && let Some(turn) = walker.look_ahead(&vertex, &mut ledger)
            {
                let [back, through] = turn.powers(&walker);
                let crosses = turn.refracts() && through >= back;
                walker.forced = Some(if crosses { Branch::Refracted } else { Branch::Reflected });
            }
            if let Some(reflected) = other {
                branches += 1;
                let mut other = train.clone();
                linked(&mut other, &reflected, &vertex, before);
                open.push((reflected, other, 0));
            }
            if !matches!(walker.meet(&vertex, &mut ledger), Meeting::Went) {
                break;
            }
            // Chance takes nothing: no branch is to be lost by it.
            walker.events = walker.events.min(1);
            linked(&mut train, &walker, &vertex, before);
        }
    }
}

/// Adds the face that a path has just met, unless it is one that is not there.
fn linked(train: &mut SpecularChain, walker: &Walker<'_, Mono>, vertex: &Vertex, before: Option<u32>) {
    let links = walker.chain().map_or(&[][..], |chain| &chain.0);
    if links.len() > train.0.len()
        && let Some(link) = links.last()
    {
        let after = walker.part_around();
        train.0.push(Lens { link: *link, about: vertex.hit.local.to_array(), before, after });
    }
}
