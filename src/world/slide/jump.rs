//! How near a place of a pixel is to where the light that comes to it jumps, and places drawn the more often the nearer they are:
//! where a footprint is off by a hair, light and dark are taken for each other there and nowhere else.

use super::SlideMap;
use super::footprint::{Edge, Footprint, MOST};
use crate::World;
use arrayvec::ArrayVec;
use glam::DVec2;

/// Where over the square the light that comes jumps.
pub struct Jumps<'w> {
    edges: ArrayVec<Edge, MOST>,
    slides: ArrayVec<(&'w SlideMap, [Edge; 2]), MOST>,
}

impl<'w> Jumps<'w> {
    /// Past edges and through slides; more of them than [`MOST`] of either have no say.
    pub fn new(world: &'w World, edges: impl Iterator<Item = Edge>, footprints: &[Footprint]) -> Jumps<'w> {
        let slide = |footprint: &Footprint| {
            let map = &world.slides[footprint.slide];
            (map, map.lines(footprint))
        };
        Jumps { edges: edges.take(MOST).collect(), slides: footprints.iter().take(MOST).map(slide).collect() }
    }

    /// How far a place is from the next edge or other value of a slide's picture, in sides of the square; infinite where none is
    /// next to it.
    pub fn distance(&self, point: DVec2) -> f64 {
        let of_edges = self.edges.iter().map(|edge| edge.at(point).abs() / edge.by.length());
        let of_slides = self.slides.iter().map(|(map, lines)| map.to_jump(lines, point));
        of_edges.chain(of_slides).fold(f64::INFINITY, f64::min)
    }
}

/// One of so many places of the square, `first` among them, and what it stands for: 1 in the mean, whatever `weigh` says of a place
/// as long as it is above 0. `choice`: from 0 to 1.
///
/// Resampled importance sampling (J. Talbot, D. Cline, P. Egbert, "Importance resampling for global illumination", EGSR 2005): the
/// candidates are each even over the square, and that they keep apart from each other takes nothing from the mean.
pub fn draw<const N: usize>(first: DVec2, choice: f64, weigh: impl Fn(DVec2) -> f64) -> (DVec2, f64) {
    // The plane's most even additive sequence: powers of the inverse of the root of x³ = x + 1.
    const STEP: DVec2 = DVec2::new(0.754_877_666_246_692_8, 0.569_840_290_998_053_3);
    let place = |k: usize| (first + 0.5 + STEP * k as f64).fract_gl() - 0.5;
    let weights: [f64; N] = std::array::from_fn(|k| weigh(place(k)));
    let sum: f64 = weights.iter().sum();
    let mut left = choice * sum;
    for (k, weight) in weights.iter().enumerate() {
        if left < *weight || k + 1 == N {
            return (place(k), sum / (N as f64 * weight));
        }
        left -= weight;
    }
    (first, 1.0)
}

impl SlideMap {
    /// Of a place of the square to where the picture's value next to it changes, in sides of the square.
    fn to_jump(&self, lines: &[Edge; 2], point: DVec2) -> f64 {
        let [x, y] = lines.map(|lines| lines.at(point));
        let [across, down] = lines.map(|lines| lines.by.length());
        let (width, height) = (self.width as f64, self.height as f64);
        if !(x >= 0.0 && x < width && y >= 0.0 && y < height) {
            let beyond = |x: f64, end: f64, by: f64| (-x).max(x - end).max(0.0) / by;
            return beyond(x, width, across).max(beyond(y, height, down));
        }
        let (column, row) = (x as usize, y as usize);
        let at = row * self.width + column;
        let changes = |inside: bool, there: usize| !inside || !self.same(at, there);
        let to = |changes: bool, way: f64| if changes { way } else { f64::INFINITY };
        let (left, above) = (x - column as f64, y - row as f64);
        [
            to(changes(column > 0, at.wrapping_sub(1)), left / across),
            to(changes(column + 1 < self.width, at + 1), (1.0 - left) / across),
            to(changes(row > 0, at.wrapping_sub(self.width)), above / down),
            to(changes(row + 1 < self.height, at + self.width), (1.0 - above) / down),
        ]
        .into_iter()
        .fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::super::footprint::tests::{slide, turned};
    use super::*;
    use glam::DVec3;

    #[test]
    fn a_place_knows_how_far_it_is_from_the_next_jump() {
        let map = slide(4, &[0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0]);
        // A square of half a pixel's width, turned by 30°, whose middle lies 0.2 pixels left of the step.
        let footprint = turned(DVec3::new(-0.2, 0.4, 0.0), 0.5, 30f64.to_radians());
        assert!((map.to_jump(&map.lines(&footprint), DVec2::ZERO) - 0.4).abs() < 1e-12);
        // On the step, and beyond it the rim is nearer.
        let to_step = DVec2::new(0.4 * 30f64.to_radians().cos(), -0.4 * 30f64.to_radians().sin());
        assert!(map.to_jump(&map.lines(&footprint), to_step) < 1e-12);
        let far = turned(DVec3::new(1.9, 0.4, 0.0), 0.5, 0.0);
        assert!((map.to_jump(&map.lines(&far), DVec2::ZERO) - 0.2).abs() < 1e-12);
        assert!((map.to_jump(&map.lines(&far), DVec2::X * 0.4) - 0.2).abs() < 1e-12);
        // In the midst of what is even there is none.
        let even = slide(4, &[1.0; 12]);
        assert_eq!(
            even.to_jump(&even.lines(&turned(DVec3::new(-0.5, 0.0, 0.0), 0.5, 0.0)), DVec2::ZERO),
            f64::INFINITY
        );
    }

    /// ∫ f over the square, by places drawn near a line, is what it is.
    #[test]
    fn drawn_places_leave_the_mean_as_it_is() {
        let mut rng = eyebox_base::rng::Rng::new(7, eyebox_base::rng::Stream::Connection, 0, 0);
        let weigh = |place: DVec2| 1.0 + 1.0 / ((place.x - 0.1).abs() + 1e-3);
        let f = |place: DVec2| place.x * place.x + place.y + f64::from((place.x - 0.1).abs() < 2e-3) * 50.0;
        let (mut near, mut all) = (0u32, eyebox_base::stats::Moments::default());
        for _ in 0..100_000 {
            let first = DVec2::new(rng.uniform(), rng.uniform()) - 0.5;
            let (place, stands) = draw::<32>(first, rng.uniform(), weigh);
            near += u32::from((place.x - 0.1).abs() < 2e-3);
            all.add(f(place) * stands);
        }
        let want = 1.0 / 12.0 + 4e-3 * 50.0;
        let (mean, error) = (all.mean, all.stderr());
        assert!((mean - want).abs() < 4.0 * error, "{mean} ± {error}, want {want}");
        // Where it jumps it is looked at ten times as often as by chance at least.
        assert!(near > 10 * 400, "{near}");
    }
}
