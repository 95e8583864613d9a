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

#[cfg(test)]
mod tests {
    use super::super::footprint::tests::{slide, turned};
    use super::*;
    use eyebox_base::rng::{Rng, Stream};
    use eyebox_base::warp::disk;
    use glam::DVec2;

    /// Nothing that a pixel sees from anywhere has another value where no edge is told, and edges far from it are not.
    #[test]
    fn no_edge_is_missed() {
        let values: Vec<f32> = (0..64).map(|k| f32::from(u8::from(k % 8 > 4 && k / 8 > 2))).collect();
        let map = slide(8, &values);
        let mut rng = Rng::new(7, Stream::Check, 0, 0);
        let (mut told, mut seen, mut moved) = (0, 0, 0.0f64);
        for _ in 0..400 {
            let [x, y, angle] = rng.triple();
            let [size, a, b] = rng.triple();
            let middle = DVec3::new(8.0 * x - 4.0, 8.0 * y - 4.0, 0.0);
            let footprint = turned(middle, 0.1 + size, 6.0 * angle);
            let along = |length: f64| {
                let [cos, sin] = [(6.0 * angle).cos(), (6.0 * angle).sin()].map(|part| length * part);
                [DVec3::new(cos, sin, 0.0), DVec3::new(-0.5 * sin, 0.5 * cos, 0.0)]
            };
            let discs = [along(a), along(0.5 * b)];
            let edge = map.edge_moves(&footprint, 1.0, &discs);
            let place = |rng: &mut Rng| {
                let ([u, v], [p, q]) = (rng.pair().map(|u| u - 0.5), [rng.pair(), rng.pair()].map(disk));
                let by = |disc: &Disc, at: DVec3| disc[0] * at.x + disc[1] * at.y;
                footprint.place(DVec2::new(u, v))
                    + by(&discs[0], DVec3::new(p.x, p.y, 0.0))
                    + by(&discs[1], DVec3::new(q.x, q.y, 0.0))
            };
            let index = |at: DVec3| {
                let (x, y) = (map.across.dot(at - map.centre) + 0.5, map.down.dot(at - map.centre) + 0.5);
                let inside = (0.0..1.0).contains(&x) && (0.0..1.0).contains(&y);
                inside.then(|| values[(8.0 * y) as usize * 8 + (8.0 * x) as usize])
            };
            let first = index(place(&mut rng));
            let differs = (0..400).any(|_| index(place(&mut rng)) != first);
            assert!(!differs || edge.is_some(), "{footprint:?} {discs:?}");
            told += u32::from(edge.is_some());
            seen += u32::from(differs);
            moved = moved.max(edge.unwrap_or(0.0));
        }
        assert!(seen > 100 && told < seen + seen / 3, "{told} told, {seen} seen");
        assert!(moved > 1.0 && moved.is_finite(), "{moved}");
    }
}
