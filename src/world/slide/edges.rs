//! Whether a slide's picture has an edge in what a pixel may see of it, from any place of the pupil and of a lamp.

use super::SlideMap;
use super::footprint::{Footprint, cells};
use glam::DVec3;

/// Where a disc's points move a place to: from its middle along these, to its rim.
pub type Disc = [DVec3; 2];

impl SlideMap {
    /// By how many of the eye's pixels an edge of the picture moves from the middles of discs to their rims, if any comes within the
    /// box that a footprint moved by all of them lies in, along columns and rows. `wider`: how many times larger than the pixel what is asked
    /// about is. None, too, where all of it is beside the picture.
    pub fn edge_moves(&self, footprint: &Footprint, wider: f64, discs: &[Disc]) -> Option<f64> {
        let axes = [(self.across, self.width), (self.down, self.height)];
        let mut most = 0.0f64;
        let mut reached = [[0usize; 2]; 2];
        let mut inside = true;
        for ((line, (axis, count)), reached) in self.lines(footprint).into_iter().zip(axes).zip(&mut reached) {
            let along = |moved: &DVec3| axis.dot(*moved) * count as f64;
            let pixel = line.by.x.abs() + line.by.y.abs();
            let moves: f64 = discs.iter().map(|[a, b]| along(a).hypot(along(b))).sum();
            let reach = 0.5 * wider * pixel + moves;
            let span = [line.first - reach, line.first + reach];
            if !span.iter().all(|end| end.is_finite()) {
                return None;
            }
            *reached = cells(span, count)?;
            inside &= span[0] >= 0.0 && span[1] <= count as f64;
            most = if pixel > 0.0 { most.max(moves / pixel) } else { most };
        }
        let [[first, last], [first_row, last_row]] = reached;
        (!inside || !self.is_even([first, last], [first_row, last_row])).then_some(most)
    }
}
