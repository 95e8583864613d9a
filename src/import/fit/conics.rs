//! The conic of a face among the minima that several starts lead to.

use super::conic::Conic;
use super::refine::{CONIC, Minimum, STILL, Walk, refine};
use super::start::Monomials;
use super::task::{Task, part};
use glam::DVec3;

/// A minimum and what was free to move to it.
type Found = (Minimum, &'static [bool; 8]);

/// Which of the minima is meant is judged on so many of the points at most.
const FEW: usize = 4000;

/// A start that is met earlier is kept unless a later one is better by more than what fitting noise with another axis
/// wins (a χ² of 2 directions, generously 20).
fn margin(points: &[DVec3]) -> f64 {
    1.0 - 20.0 / (points.len() as f64 + 20.0)
}

impl Task {
    /// The best conic of all starts, on a part of a large face. The first keeps the axis amid the face: that of the
    /// `sphere`, if there is one.
    pub fn conics(&self, sphere: Option<Conic>) -> Option<Found> {
        let few = part(&self.face.points, FEW);
        let sketch = &self.sketch;
        // Nothing but rounding is left to explain.
        let rounded = |found: &Minimum| few.iter().all(|&p| found.surface.distance(p).abs() <= self.noise);
        let still = sphere
            .and_then(|sphere| refine(sketch, sphere, &STILL, Walk::FAR))
            .and_then(|found| refine(&few, found.surface, &STILL, Walk::NEAR));
        if still.as_ref().is_some_and(&rounded) {
            return still.map(|found| (found, &STILL));
        }
        let loose = sphere.into_iter().chain(still.as_ref().map(|found| found.surface));
        let mut least = f64::INFINITY; // on the sketch
        let mut best: Option<Found> = still.map(|found| (found, &STILL));
        // True if there is nothing left to look for.
        let mut offer = |start: Minimum| {
            if start.cost >= least * margin(sketch) {
                return false; // a minimum that was seen before, or none better
            }
            least = start.cost;
            let Some(found) = refine(&few, start.surface, &CONIC, Walk::NEAR) else { return false };
            if best.as_ref().is_some_and(|(best, _)| found.cost >= best.cost * margin(&few)) {
                return false;
            }
            let done = rounded(&found);
            best = Some((found, &CONIC));
            done
        };
        let walked = |start: Conic| refine(sketch, start, &CONIC, Walk::FAR);
        let loose = loose.filter_map(walked).min_by(|x, y| x.cost.total_cmp(&y.cost));
        if !loose.is_some_and(&mut offer) {
            let monomials = Monomials::new(sketch);
            let algebraic = self.norms().into_iter().flat_map(|norm| monomials.conics(norm));
            let _ = algebraic.filter_map(walked).any(offer);
        }
        best
    }
}
