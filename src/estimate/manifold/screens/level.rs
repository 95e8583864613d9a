//! How fine the table of a face is: as fine as pays. A first one tells by how much it errs, and so how many of a finer one's
//! cells would do; what they cost to fill is held against what they save in a run.

use super::lit::Lit;
use super::sheet::Cell;
use super::{FEWEST_LAMPS, MOST_SLACK, WORTH_EVERY_LAMP};
use crate::film::train::Screen;
use crate::world::World;
use crate::world::mode::Mode;
use crate::world::optics::Optics;

/// Cells along the longer side of a face's map.
const CELLS: [usize; 4] = [16, 24, 32, 48];
/// Of a pilot, and first of a train with little of the light.
pub(super) const COARSE: usize = 8;
/// What a cell costs to fill and to try, in connections that are solved for.
const CELL: f64 = 2.0;
/// Passes of a run, in each of which a pixel asks for a connection. What pays for so many is not far from the best for a
/// half or twice of them.
const RUN: f64 = 32.0;
/// How much is saved where what errs is interpolated between nodes half as far from each other: by cubics.
const ORDER: i32 = 4;

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

impl<M: Mode> Lit<M> {
    /// With a map as fine as pays for a run of this picture.
    pub(super) fn new(world: &World, optics: &Optics<M>, screen: &Screen) -> Option<Lit<M>> {
        let first = if slack(screen) >= MOST_SLACK { Some(COARSE) } else { None };
        let mut levels = first.into_iter().chain(CELLS);
        let (first, lit) = levels.find_map(|cells| Some((cells, Lit::with_cells(world, optics, screen, cells)?)))?;
        let pixels = world.eye.size().iter().product::<usize>() as f64;
        let asks = RUN * pixels * (screen.share / WORTH_EVERY_LAMP).clamp(FEWEST_LAMPS, 1.0);
        let cells = lit.cells() / lit.entries.len().max(1) as f64;
        let mut best = (None, asks * lit.solved_share(1.0));
        for level in levels {
            let finer = level as f64 / first as f64;
            let cost = CELL * cells * finer.powi(2) + asks * lit.solved_share(finer);
            if cost < best.1 {
                best = (Some(level), cost);
            }
        }
        match best.0 {
            Some(level) => Lit::with_cells(world, optics, screen, level).or(Some(lit)),
            None => Some(lit),
        }
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
