//! Following a lamp's path both ways from an interface, within limits.

use super::walk::Walker;
use eyebox_world::mode::Mode;
use std::cell::Cell;

/// Which interfaces split a path, for [`Visitor::split_from`](super::emission::Visitor::split_from).
pub struct Splitting {
    /// Share of what the path started with that each way must carry.
    least: f64,
    /// Interfaces at which one path and all its branches may split: among a hundred plates of glass there would be no end.
    most: u32,
    /// Interfaces met so far.
    asked: Cell<u32>,
}

impl Splitting {
    pub fn new(least: f64, most: u32) -> Self {
        Splitting { least, most, asked: Cell::new(0) }
    }

    /// Share of the power here that both ways on must carry; none: the path is not split. Every interface asks, so both
    /// splits and work have an end.
    pub fn from<M: Mode>(&self, walker: &Walker<'_, M>) -> Option<f64> {
        let share = walker.share();
        self.asked.set(self.asked.get().saturating_add(1));
        (share > self.least && self.asked.get() <= self.most).then(|| self.least / share)
    }

    /// The next path starts.
    pub fn next(&self) {
        self.asked.set(0);
    }
}
