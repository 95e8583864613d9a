//! The one walk that light tracing and photon mapping share, and what an estimator does along it.

use super::{Emission, Origin};
use crate::ledger::Ledger;
use crate::walk::{Meeting, Met, Vertex, Walker};
use eyebox_world::eye::Arrival;
use eyebox_world::mode::Mode;
use eyebox_world::scatter::Scatter;

/// What an estimator does along a path from a lamp. All branches of a path are visited before the next path starts.
pub trait Visitor<M: Mode> {
    /// Share of the power that both ways on from an interface must carry for the path to be split there; none: it
    /// never is.
    fn split_from(&self, walker: &Walker<'_, M>) -> Option<f64>;
    /// Most splits of a path.
    fn most_splits(&self) -> u8 {
        Walker::<M>::MOST_SPLITS
    }
    /// See [`Walker::worth`].
    fn worth(&self) -> f64 {
        Walker::<M>::WORTH
    }
    /// Paths on average by which one goes on from a scatterer.
    fn copies(&self, _walker: &Walker<'_, M>) -> f64 {
        1.0
    }
    /// Least probability of either way on from an interface, see [`Walker::least_chance`].
    fn least_chance(&self) -> f64 {
        0.0
    }
    /// Paths keep the specular faces that they meet.
    fn records(&self) -> bool {
        false
    }
    /// The path has arrived in the pupil and ends there.
    fn pupil(&mut self, walker: &Walker<'_, M>, from: Origin, arrival: &Arrival);
    /// The path has met a scatterer; it goes on after this.
    fn scatterer(&mut self, walker: &Walker<'_, M>, from: Origin, vertex: &Vertex, scatter: &Scatter);
    /// The path has arrived at a face, with all that it carries.
    fn lands(&mut self, _walker: &Walker<'_, M>, _from: Origin, _vertex: &Vertex) {}
    /// The path goes on from a face that does not scatter.
    fn went(&mut self, _walker: &Walker<'_, M>, _vertex: &Vertex) {}
    /// Path number `sample` of its pass and all its branches have ended.
    fn end(&mut self, _sample: u64) {}
}

impl Emission {
    pub(super) fn walk<M: Mode, V: Visitor<M>>(
        &self,
        mut walker: Walker<'_, M>,
        from: Origin,
        visitor: &mut V,
        ledger: &mut Ledger,
    ) {
        let reach = &self.reach[from.group.index()];
        (walker.least_chance, walker.worth) = (visitor.least_chance(), visitor.worth());
        if visitor.records() && walker.chain().is_none() {
            walker = walker.recording();
        }
        loop {
            let vertex = match walker.advance(ledger) {
                Met::Sky => {
                    walker.escape(ledger);
                    return;
                }
                Met::Ended => return,
                Met::Pupil(arrival) => {
                    ledger.arrived += walker.beam.carried();
                    visitor.pupil(&walker, from, &arrival);
                    return;
                }
                Met::Face(vertex) => vertex,
            };
            visitor.lands(&walker, from, &vertex);
            if let Some(least) = visitor.split_from(&walker)
                && let Some(reflected) = walker.split(&vertex, least, visitor.most_splits(), ledger)
            {
                self.walk(reflected, from, visitor, ledger);
            }
            match walker.meet(&vertex, ledger) {
                Meeting::Ended => return,
                Meeting::Went => visitor.went(&walker, &vertex),
                Meeting::Scatter(scatter, frame) => {
                    visitor.scatterer(&walker, from, &vertex, scatter);
                    let copies = visitor.copies(&walker);
                    if copies != 1.0 {
                        for mut copy in walker.copied(copies, ledger) {
                            if copy.scatter(&vertex, scatter, &frame, ledger).is_none() {
                                continue;
                            }
                            if reach.allows(copy.trail) {
                                self.walk(copy, from, visitor, ledger);
                            } else {
                                ledger.not_owned += copy.beam.carried();
                            }
                        }
                        return;
                    }
                    if walker.scatter(&vertex, scatter, &frame, ledger).is_none() {
                        return;
                    }
                }
            }
            if !reach.allows(walker.trail) {
                ledger.not_owned += walker.beam.carried();
                return;
            }
        }
    }
}
