//! A ray from the eye and all ways on from it, the brightest first, until what is left out together is little: of a light guide with
//! gratings no way has much light, and all of them have the picture's.

use super::sent;
use super::subject::Kind;
use super::tuning::ways::{MOST_FACES, SMALL};
use crate::ledger::Ledger;
use crate::specular_event::Branch;
use crate::walk::{Meeting, Met, Vertex, Walker};
use eyebox_base::chain::Step;
use eyebox_film::specular_chain::{Lens, SpecularChain};
use eyebox_world::World;
use eyebox_world::grating::Grating;
use eyebox_world::mode::Mono;
use eyebox_world::optics::Optics;
use eyebox_world::surface::Surface;
use glam::DVec3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// How far the ways of a ray are followed. Shares are of what it started with.
#[derive(Debug, Clone, Copy)]
pub(super) struct Effort {
    /// What a way has to carry to be one at all.
    pub least: f64,
    /// What all that are left out may carry together.
    pub left_out: f64,
    /// At most so many are followed: between two mirrors there would be no end.
    pub most_ways: usize,
}

/// Follows a ray and all its ways to the faces that may be a picture. What is returned is the share of its light that ways carry which
/// were not followed to their end: more than the effort allows where there were too many of them.
pub(super) fn follow<'w>(
    tracing: (&'w World, &'w Optics<Mono>),
    (origin, dir): (DVec3, DVec3),
    effort: Effort,
    mut each: impl FnMut(Kind, &Vertex, &Walker<'w, Mono>, &SpecularChain),
) -> f64 {
    let mut ledger = Ledger::new(tracing.0.solids.len());
    let mut open = Open::new(effort);
    open.put(Way { walker: sent(tracing, origin, dir).recording(), train: SpecularChain::default(), met: 0 });
    while let Some(mut way) = open.brightest() {
        loop {
            if way.met >= MOST_FACES || open.is_small(way.walker.share()) {
                open.dropped += way.walker.share();
                break;
            }
            let Met::Face(vertex) = way.walker.advance(&mut ledger) else { break };
            way.met += 1;
            if let Some(kind) = picture(tracing.0, &way, &vertex) {
                each(kind, &vertex, &way.walker, &way.train);
                break;
            }
            let mut on = way.on(&vertex, &mut ledger).into_iter();
            // The brightest goes on at once, so that there is always a whole way.
            let Some(next) = on.next() else { break };
            on.for_each(|other| open.put(other));
            if next.walker.share() < effort.least {
                break;
            }
            way = next;
        }
    }
    open.left_out()
}

/// What a face is, if it may be a picture.
fn picture(world: &World, way: &Way<'_>, vertex: &Vertex) -> Option<Kind> {
    let shines = if way.train.0.is_empty() { Kind::Object } else { Kind::Image };
    let site = vertex.hit.site;
    match &way.walker.face(vertex).surface {
        Surface::Slide(_) => Some(Kind::Slide),
        Surface::Scatter(_) => Some(shines),
        Surface::Absorber
        | Surface::Absent
        | Surface::Sheet(_)
        | Surface::Splitter(_)
        | Surface::Grating(_)
        | Surface::Mirror(_)
        | Surface::Interface(_) => world.lamps.of_face(site.part as usize, site.face as usize).map(|_| shines),
    }
}

/// Light on its way, and the faces that it has met.
struct Way<'w> {
    walker: Walker<'w, Mono>,
    train: SpecularChain,
    met: usize,
}

impl<'w> Way<'w> {
    /// The ways on from a face, the brightest first. Nothing is left to chance.
    fn on(mut self, vertex: &Vertex, ledger: &mut Ledger) -> Vec<Way<'w>> {
        let before = self.walker.part_around();
        let mut walkers = if let Surface::Grating(grating) = &self.walker.face(vertex).surface
            && !self.walker.is_passed(vertex, ledger)
        {
            orders(&self.walker, vertex, grating, ledger)
        } else {
            parted(self.walker, vertex, ledger)
        };
        walkers.retain(|walker| walker.beam.weight() > 0.0);
        walkers.sort_by(|a, b| b.beam.weight().total_cmp(&a.beam.weight()));
        let (last, met) = (walkers.len().saturating_sub(1), self.met);
        let mut train = Some(self.train);
        let on = walkers.into_iter().enumerate().map(|(index, mut walker)| {
            // Chance takes nothing: no way is to be lost by it.
            walker.events = walker.events.min(1);
            let own = if index == last { train.take() } else { train.clone() };
            let mut train = own.unwrap_or_default();
            linked(&mut train, &walker, vertex, before);
            Way { walker, train, met }
        });
        on.collect()
    }
}

/// Back and through, where an interface parts light; else the one way there is.
fn parted<'w>(mut walker: Walker<'w, Mono>, vertex: &Vertex, ledger: &mut Ledger) -> Vec<Walker<'w, Mono>> {
    let mut ways: Vec<Walker<'w, Mono>> =
        walker.split(vertex, f64::MIN_POSITIVE, u8::MAX, ledger).into_iter().collect();
    // Where nothing goes one way, or none parts any more, it goes the brighter one.
    if walker.forced.is_none()
        && let Some(turn) = walker.look_ahead(vertex, ledger)
    {
        let [back, through] = turn.powers(&walker);
        let crosses = turn.refracts() && through >= back;
        walker.forced = Some(if crosses { Branch::Refracted } else { Branch::Reflected });
    }
    if matches!(walker.meet(vertex, ledger), Meeting::Went) {
        ways.push(walker);
    }
    ways
}

/// The ways on from a grating: its orders, and what is left straight on.
fn orders<'w>(
    walker: &Walker<'w, Mono>,
    vertex: &Vertex,
    grating: &Grating,
    ledger: &mut Ledger,
) -> Vec<Walker<'w, Mono>> {
    let rest = (!grating.orders.numbers().any(|order| order == 0)).then_some(0);
    let both = |order: i32| [Step::Through, Step::Back].map(|step| (step, order));
    let ways = grating.orders.numbers().chain(rest).flat_map(both).filter_map(|way| {
        let mut on = walker.clone();
        on.order = Some(way);
        matches!(on.meet(vertex, ledger), Meeting::Went).then_some(on)
    });
    ways.collect()
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

/// The ways that wait to be followed.
struct Open<'w> {
    effort: Effort,
    waiting: BinaryHeap<Waiting<'w>>,
    /// What those carry together, and what those carried that were not worth waiting.
    carried: f64,
    dropped: f64,
    /// How many were put and followed.
    put: usize,
    followed: usize,
}

impl<'w> Open<'w> {
    fn new(effort: Effort) -> Self {
        Open { effort, waiting: BinaryHeap::new(), carried: 0.0, dropped: 0.0, put: 0, followed: 0 }
    }

    /// So little that it may be left out: all together that stay below half of what may be.
    fn is_small(&self, share: f64) -> bool {
        share <= SMALL * (0.5 * self.effort.left_out - self.dropped)
    }

    fn put(&mut self, way: Way<'w>) {
        let share = way.walker.share();
        if share < self.effort.least {
            return;
        }
        if self.is_small(share) {
            self.dropped += share;
            return;
        }
        self.carried += share;
        self.waiting.push(Waiting { share, number: self.put, way });
        self.put += 1;
    }

    /// The brightest of those that wait, if it is still to be followed.
    fn brightest(&mut self) -> Option<Way<'w>> {
        if self.left_out() <= self.effort.left_out || self.followed >= self.effort.most_ways {
            return None;
        }
        let first = self.waiting.pop()?;
        self.followed += 1;
        // Rounding leaves nothing behind.
        self.carried = if self.waiting.is_empty() { 0.0 } else { self.carried - first.share };
        Some(first.way)
    }

    fn left_out(&self) -> f64 {
        self.carried + self.dropped
    }
}

/// In the order in which ways are followed: by what they carry, and the first of several that carry the same.
struct Waiting<'w> {
    share: f64,
    number: usize,
    way: Way<'w>,
}

impl Ord for Waiting<'_> {
    fn cmp(&self, other: &Self) -> Ordering {
        self.share.total_cmp(&other.share).then(other.number.cmp(&self.number))
    }
}

impl PartialOrd for Waiting<'_> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Waiting<'_> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Waiting<'_> {}
