//! A path from the eye over specular faces, with all its branches, to the first broad scatterers.

use crate::ledger::Ledger;
use crate::specular_event::Faint;
use crate::walk::{Meeting, Met, SPLIT_FIRST_EVENTS, Vertex, Walker};
use eyebox_base::warp::Frame;
use eyebox_world::mode::Mode;
use eyebox_world::scatter::Scatter;

/// Follows a path and its branches to the first broad scatterers.
pub fn to_scatterer<'w, M: Mode>(
    mut walker: Walker<'w, M>,
    faint: Faint,
    ledger: &mut Ledger,
    each: &mut impl FnMut(&mut Walker<'w, M>, &Vertex, &'w Scatter, Frame, &mut Ledger),
) {
    loop {
        let vertex = match walker.advance(ledger) {
            Met::Sky => return walker.escape(ledger),
            Met::Pupil(_) | Met::Ended => return,
            Met::Face(vertex) => vertex,
        };
        let other = if walker.events < SPLIT_FIRST_EVENTS {
            walker.split(&vertex, 0.0, Walker::<M>::MOST_SPLITS, ledger)
        } else {
            walker.spare(&vertex, faint, ledger)
        };
        if let Some(reflected) = other {
            to_scatterer(reflected, faint, ledger, each);
        }
        match walker.meet(&vertex, ledger) {
            Meeting::Ended => return,
            Meeting::Went => {}
            // Narrow lobes are left to rays from the eye.
            Meeting::Scatter(scatter, _) if scatter.is_narrow() => {
                ledger.not_owned += walker.beam.carried();
                return;
            }
            Meeting::Scatter(scatter, frame) => return each(&mut walker, &vertex, scatter, frame, ledger),
        }
    }
}
