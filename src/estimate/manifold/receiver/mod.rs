//! Faces that scatter, joined with lamps over trains of specular faces.
//!
//! For a point y of the face and a point x of the lamp the solver finds the direction from y. What a train brings is
//! smooth over a face but for the slides' pictures: so per train and lamp the solutions are kept at the nodes of a grid,
//! and between them direction, strength and places on slides are interpolated wherever a solution in the middle of a cell
//! (or, where that is dark, eight about it) says that this errs by no more than `TOLERANCE`. In other cells every connection is solved for. Cells without a
//! solution are left to whoever computes the rest.

mod build;
mod connect;
mod ownership;
mod resolution;
mod surface_param;
mod table;
mod tuning;

use crate::ledger::{Ledger, cost};
use crate::manifold::pixel_span::Span;
use crate::manifold::solver::bicubic::Spot;
use crate::manifold::solver::newton::Target;
use arrayvec::ArrayVec;
use connect::{Connector, Entry, Solution};
use eyebox_base::lpe::Letter;
use eyebox_base::rng::Rng;
use eyebox_film::accumulate::Light;
use eyebox_film::specular_chain::Screen;
use eyebox_world::World;
use eyebox_world::geometry::Site;
use eyebox_world::interior::Interior;
use eyebox_world::mode::{Mode, lanes, wavelengths_change};
use eyebox_world::optics::Optics;
use glam::DVec3;
pub use ownership::{Asked, Claim};
use resolution::{COARSE, RUN, Resolution};
use std::sync::Arc;
use table::{Cell, ReceiverTable};
pub(super) use table::{Crossing, SLIDES};
use tuning::receiver::{
    ABOUT_SAME, FEWEST_LAMPS, FORETOLD, MOST_SHEETS, MOST_SLACK, NEARLY_SAME, SAME, TOLERANCE, WORTH_EVERY_LAMP,
};

/// All of a plan, at the wavelengths of one pass.
#[derive(Debug)]
pub struct Receivers<M: Mode> {
    levels: Vec<Resolution<M>>,
    plan: Arc<[Screen]>,
}

/// Directions found so far, each with the distance within which another is the same: sheets that meet at a fold may both
/// have its solutions, which count once.
#[derive(Default)]
struct Known(ArrayVec<(DVec3, f64), MOST_SHEETS>);

impl Known {
    /// Whether a direction is new.
    fn add(&mut self, dir: DVec3, same: f64) -> bool {
        let new = !self.0.iter().any(|(other, about)| other.distance(dir) <= same.max(*about));
        if new && !self.0.is_full() {
            self.0.push((dir, same));
        }
        new
    }
}

/// What a point of a scatterer asks lamps for.
#[derive(Debug, Clone, Copy)]
pub struct Ask {
    /// Where on them.
    pub uv: [f64; 2],
    /// The share of what a pixel shows that comes from here.
    pub seen: f64,
    /// Where the turns begin if not all lamps are asked, from 0 to 1.
    pub turn: f64,
    /// How the point moves over the pixel that sees it, where that is known: the slides' pictures are cut by what it crosses.
    pub span: Option<Span>,
}

/// Light that comes to a point of a scatterer.
pub struct Incoming<'s, M: Mode> {
    pub lamp: usize,
    /// What happened on its way, from the lamp.
    pub letters: &'s [Letter],
    /// Unit direction towards where it comes from.
    pub dir: DVec3,
    /// Luminance × solid angle per lane, cd/m²·sr, with the slides as polynomials.
    pub light: M::Lanes<Light>,
    pub alone: bool,
}

impl<M: Mode> Receivers<M> {
    /// For the first passes of a run. Where each pass has its own, see [`Receivers::of_pass`], there is nothing yet.
    pub fn new(world: &World, optics: &Optics<M>, screens: &[Screen]) -> Receivers<M> {
        let level = |screen| Resolution::new(world, optics, screen, RUN);
        let known = if wavelengths_change::<M>() { &[][..] } else { screens };
        Receivers { levels: known.iter().filter_map(level).collect(), plan: screens.into() }
    }

    /// The same with coarse maps, for a pilot: what they can't interpolate is solved for.
    pub fn coarse(world: &World, optics: &Optics<M>, screens: &[Screen]) -> Receivers<M> {
        let lit = screens.iter().filter_map(|screen| Connector::with_cells(world, optics, screen, COARSE).lit());
        Receivers { levels: lit.map(Resolution::only).collect(), plan: screens.into() }
    }

    /// Both together; their tables are not copied.
    #[must_use]
    pub fn and(&self, others: &Receivers<M>) -> Receivers<M> {
        let levels = self.levels.iter().chain(&others.levels).cloned().collect();
        let plan = self.plan.iter().chain(&*others.plan).cloned().collect();
        Receivers { levels, plan }
    }

    /// The same for a pass: where each has wavelengths of its own, faces are lit at them; else finer maps come when enough
    /// passes have gone by.
    pub fn of_pass(self: &Arc<Self>, pass: u64, world: &World, optics: &Optics<M>) -> Arc<Self> {
        if self.plan.is_empty() {
            return self.clone();
        }
        if wavelengths_change::<M>() {
            let levels = self.plan.iter().filter_map(|screen| Resolution::new(world, optics, screen, 1.0));
            return Arc::new(Receivers { levels: levels.collect(), plan: self.plan.clone() });
        }
        if self.levels.iter().all(|level| level.changes().is_none_or(|from| from > pass)) {
            return self.clone();
        }
        let levels = self.levels.iter().map(|level| level.at(pass, world, optics).unwrap_or_else(|| level.clone()));
        Arc::new(Receivers { levels: levels.collect(), plan: self.plan.clone() })
    }

    /// The first pass after this one that may have other maps.
    pub fn next_change(&self, pass: u64) -> u64 {
        let later = self.levels.iter().filter_map(Resolution::changes).filter(|from| *from > pass);
        if wavelengths_change::<M>() { pass.saturating_add(1) } else { later.min().unwrap_or(u64::MAX) }
    }

    fn lit(&self) -> impl Iterator<Item = &Connector<M>> {
        self.levels.iter().map(|level| &*level.lit)
    }

    /// Whether a face (part, face) is joined with lamps.
    pub fn has_face(&self, face: (u32, u32)) -> bool {
        self.lit().any(|lit| (lit.map.part, lit.map.face) == face)
    }

    /// Whether light of any train crosses slides.
    pub fn cross_slides(&self) -> bool {
        self.lit().flat_map(|lit| &lit.entries).flat_map(|entry| &entry.sheets).any(ReceiverTable::crosses_any_slides)
    }

    /// By how many pixels an edge of a slide's picture that a pixel sees of a face, from any place of the pupil and of lamps, moves from
    /// their middles to their rims; none where it sees no edge. `by_pupil`: how the place on the face moves from the middle of the
    /// pupil to its rim, m.
    pub fn edge_moves(
        &self,
        world: &World,
        (point, site): (DVec3, Site),
        span: &Span,
        by_pupil: [DVec3; 2],
    ) -> Option<f64> {
        let own = |lit: &&Connector<M>| (lit.map.part, lit.map.face) == (site.part, site.face);
        let of_lit = |lit: &Connector<M>| {
            let spot = lit.map.spot(point)?;
            let along = |by: DVec3| spot.rows_along(lit.map.step_of(by));
            let (rows, over, pupil) = (spot.rows(), span.by.map(along), by_pupil.map(along));
            let near = (spot.cell, &rows);
            let of_entry = |entry: &Entry<M>| {
                let interpolated = |sheet: &&ReceiverTable<M>| sheet.cell(&lit.map, &spot) == Cell::Interpolated;
                let moves =
                    |sheet: &ReceiverTable<M>| sheet.edge_moves(world, near, (&over, span), (&pupil, entry.size));
                entry.sheets.iter().filter(interpolated).filter_map(moves).reduce(f64::max)
            };
            lit.entries.iter().filter_map(of_entry).reduce(f64::max)
        };
        self.lit().filter(own).filter_map(of_lit).reduce(f64::max)
    }

    /// Nothing is connected.
    pub fn is_empty(&self) -> bool {
        self.levels.is_empty()
    }

    /// Calls `visit` with what comes to a point of a face from each lamp. `interior`: around the ray that leaves the point
    /// towards a lamp.
    #[allow(clippy::too_many_arguments)] // what a point of a face knows
    pub fn gather(
        &self,
        (world, optics): (&World, &Optics<M>),
        (point, site): (DVec3, Site),
        interior: &dyn Fn(DVec3) -> Interior,
        ask: Ask,
        rng: &mut Rng,
        ledger: &mut Ledger,
        mut visit: impl FnMut(Incoming<'_, M>),
    ) {
        for lit in self.lit().filter(|lit| (lit.map.part, lit.map.face) == (site.part, site.face)) {
            let Some(spot) = lit.map.spot(point) else { continue };
            let rows = spot.rows();
            let along = ask.span.map(|span| (span.by.map(|by| spot.rows_along(lit.map.step_of(by))), span));
            // Where a table tells but a part of a pixel it says nothing of all of it.
            let corners = ask.span.map(|span| span.corners().map(|moved| lit.map.spot(point + moved)));
            let over_all = |sheet: &ReceiverTable<M>| {
                let is_known = |spot: &Option<Spot>| {
                    spot.as_ref().is_some_and(|spot| sheet.cell(&lit.map, spot) == Cell::Interpolated)
                };
                corners.as_ref().is_some_and(|corners| corners.iter().all(is_known))
            };
            let chance = lit.chance(ask.seen);
            let mut turn = ask.turn;
            for entry in &lit.entries {
                turn += chance;
                if turn < 1.0 {
                    continue;
                }
                turn -= 1.0;
                let Some(lamp) = world.lamps.get(entry.lamp) else { continue };
                let of = |wanted: Cell| entry.sheets.iter().filter(move |sheet| sheet.cell(&lit.map, &spot) == wanted);
                let x = lamp.sample_point(ask.uv);
                let off = entry.middle.local(x.position - entry.middle.point);
                let mut known = Known::default();
                for sheet in of(Cell::Interpolated) {
                    ledger.work += cost::READ;
                    let near = (spot.cell, &rows);
                    let incoming = match &along {
                        Some((along, span)) if sheet.crosses_slides(spot.cell) && over_all(sheet) => {
                            sheet.interpolate_over((world, optics), near, (along, span), entry.lamp, off)
                        }
                        Some(_) | None => sheet.interpolate((world, optics), near, entry.lamp, off),
                    };
                    let Some(mut incoming) = incoming else { continue };
                    // One sheet has no solution twice.
                    if entry.sheets.len() > 1 && !known.add(incoming.dir, NEARLY_SAME * lit.tolerance) {
                        continue;
                    }
                    if chance < 1.0 {
                        incoming.light = lanes::<M, _>(|lane| incoming.light[lane].scaled(1.0 / chance));
                    }
                    visit(Incoming { letters: &lit.letters, ..incoming });
                }
                for sheet in of(Cell::Solved) {
                    let target = Target::new(x.position, x.normal);
                    ledger.work += cost::SOLVED * lit.chain.0.len() as u64;
                    let root = lit.solve((world, optics), entry, sheet, &spot, (point, site), &target);
                    let Some(Solution { dir, factor }) = root.filter(|root| known.add(root.dir, SAME)) else {
                        continue;
                    };
                    let start = (point, site, interior(dir), rng.fork());
                    let found = lit.follow((world, optics), entry.lamp, start, dir, ledger, |_| {});
                    let Some((light, alone)) = found else { continue };
                    let light = lanes::<M, _>(|lane| light[lane].scaled(factor / chance));
                    visit(Incoming { lamp: entry.lamp, letters: &lit.letters, dir, light, alone });
                }
            }
        }
    }
}
