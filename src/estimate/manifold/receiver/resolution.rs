//! How fine the table of a face is: as fine as pays. A first one tells by how much it errs, and so how many of a finer one's
//! cells would do; what they cost to fill is held against what they save in a run. The finer one comes when so many passes have
//! gone by as would have paid for it: a short run does without, a long one has lost no more than its price.

use super::build::Filled;
use super::connect::Connector;
use super::table::Cell;
use super::tuning::resolution::{CELL, CELLS, ORDER};
pub(super) use super::tuning::resolution::{COARSE, RUN};
use super::{FEWEST_LAMPS, MOST_SLACK, WORTH_EVERY_LAMP};
use eyebox_film::specular_chain::Screen;
use eyebox_world::World;
use eyebox_world::mode::Mode;
use eyebox_world::optics::Optics;
use std::sync::{Arc, OnceLock};

/// What the trial of a cell with solutions has shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Errs {
    /// What is interpolated errs by so many tolerances, at the most; infinite: it never does, however near the nodes are.
    By(f64),
    /// Nodes are missing, where what is lit ends.
    AtEdge,
}

impl Errs {
    /// The cell can be interpolated.
    pub(super) fn are_small(self) -> bool {
        match self {
            Errs::By(tolerances) => tolerances <= 1.0,
            Errs::AtEdge => false,
        }
    }
}

/// How much more a train's tables may err than those of one that has all light.
pub(super) fn slack(screen: &Screen) -> f64 {
    (1.0 / screen.share).clamp(1.0, MOST_SLACK)
}

/// The first of these levels that is lit. Where a map has found nothing, the next that is tried is twice as fine, and after that
/// none: what it would cost is soon more than all that it may save.
fn first_lit<M: Mode>(
    levels: &mut impl Iterator<Item = usize>,
    fill: impl Fn(usize) -> Filled<M>,
) -> Option<(usize, Connector<M>)> {
    let first = levels.next()?;
    match fill(first) {
        Filled::Lit(lit) => return Some((first, *lit)),
        Filled::LampsTooLarge => return None,
        Filled::Nothing => {}
    }
    let next = levels.find(|cells| *cells >= 2 * first)?;
    Some((next, fill(next).lit()?))
}

/// The map of a face, and the one that takes its place.
#[derive(Debug, Clone)]
pub(super) struct Resolution<M: Mode> {
    pub(super) lit: Arc<Connector<M>>,
    finer: Option<Arc<Finer<M>>>,
}

#[derive(Debug)]
struct Finer<M: Mode> {
    /// Along the longer side.
    cells: usize,
    /// First pass that has it.
    from: u64,
    screen: Screen,
    /// None where it has nothing.
    made: OnceLock<Option<Arc<Connector<M>>>>,
}

impl<M: Mode> Resolution<M> {
    /// A map that stays.
    pub(super) fn only(lit: Connector<M>) -> Self {
        Resolution { lit: Arc::new(lit), finer: None }
    }

    /// For runs of `run` passes of this picture. None where nothing is lit.
    pub(super) fn new(world: &World, optics: &Optics<M>, screen: &Screen, run: f64) -> Option<Self> {
        let first = if slack(screen) >= MOST_SLACK { Some(COARSE) } else { None };
        let mut levels = first.into_iter().chain(CELLS);
        let (first, lit) = first_lit(&mut levels, |cells| Connector::with_cells(world, optics, screen, cells))?;
        let pixels = world.eye.size().iter().product::<usize>() as f64;
        let asks = pixels * lit.chance(1.0);
        let known = lit.cells() / lit.entries.len().max(1) as f64;
        let now = asks * lit.solved_share(1.0);
        let mut best = (None, run * now);
        for cells in levels {
            let finer = cells as f64 / first as f64;
            let (price, then) = (CELL * known * finer.powi(2), asks * lit.solved_share(finer));
            if price + run * then < best.1 {
                // More than `run` passes can't be asked for: it is saved in fewer.
                best = (Some((cells, (price / (now - then)) as u64)), price + run * then);
            }
        }
        let finer = best.0.map(|(cells, from)| Finer { cells, from, screen: screen.clone(), made: OnceLock::new() });
        let level = Resolution { lit: Arc::new(lit), finer: finer.map(Arc::new) };
        Some(level.at(0, world, optics).unwrap_or(level))
    }

    /// The first pass from which another map is used.
    pub(super) fn changes(&self) -> Option<u64> {
        Some(self.finer.as_ref()?.from)
    }

    /// The same for a pass from which on there is another map; none: it stays.
    pub(super) fn at(&self, pass: u64, world: &World, optics: &Optics<M>) -> Option<Self> {
        let finer = self.finer.as_ref().filter(|finer| finer.from <= pass)?;
        let make = || Connector::with_cells(world, optics, &finer.screen, finer.cells).lit().map(Arc::new);
        let lit = finer.made.get_or_init(make).as_ref().unwrap_or(&self.lit);
        Some(Resolution { lit: lit.clone(), finer: None })
    }
}

impl<M: Mode> Connector<M> {
    /// The share of lamps that is asked where the eye sees this much of the face's light.
    pub(super) fn chance(&self, seen: f64) -> f64 {
        let fewest = FEWEST_LAMPS.max(1.0 / self.entries.len().max(1) as f64);
        (self.share * seen / WORTH_EVERY_LAMP).clamp(fewest, 1.0)
    }

    /// Cells with solutions, of all lamps.
    fn cells(&self) -> f64 {
        let sheets = self.entries.iter().flat_map(|entry| &entry.sheets);
        sheets.flat_map(|sheet| &sheet.cells).filter(|cell| **cell != Cell::Nothing).count() as f64
    }

    /// Of the cells with solutions of a map so many times finer, the share in which each connection would be solved for.
    fn solved_share(&self, finer: f64) -> f64 {
        let errs = || self.entries.iter().flat_map(|entry| &entry.sheets).flat_map(|sheet| &sheet.errs);
        let least = finer.powi(ORDER);
        // Cells at an edge are along a line, the others are on all of the face.
        let solved = errs().map(|errs| match *errs {
            Errs::By(tolerances) => f64::from(u8::from(tolerances > least)),
            Errs::AtEdge => finer.recip(),
        });
        let (sum, count) = solved.fold((0.0, 0.0), |(sum, count), share| (sum + share, count + 1.0));
        if count > 0.0 { sum / count } else { 0.0 }
    }
}
