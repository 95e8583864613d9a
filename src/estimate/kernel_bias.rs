//! Which pixels an edge may be blurred into: the eye is focused at one distance, and what lies at another is seen as wide
//! as the pupil makes it. Elsewhere in the picture the ray through the middle of pixel and pupil stands for all of them,
//! since what is linear in both is exact there.

use eyebox_world::eye::EyeLens;

/// Radius, in pixels, of the disc that a point at a distance of `z_m` along the viewing axis is blurred into:
/// r·|1/z − 1/focus| in tangents.
pub(super) fn radius_px(eye: &EyeLens, z_m: f64) -> f64 {
    let [width, height] = eye.pixel();
    let tangent = eye.pupil_radius_m() * (1.0 / z_m - eye.per_focus()).abs();
    tangent / width.min(height)
}

/// Edges in a picture, and how far they are blurred.
pub(super) struct Edges {
    width: usize,
    height: usize,
    /// How far an edge still reaches from here, in pixels; 0: none does.
    reach: Vec<f64>,
}

impl Edges {
    pub(super) fn new(width: usize, height: usize) -> Edges {
        Edges { width, height, reach: vec![0.0; width * height] }
    }

    /// Between two neighbours is an edge that is blurred by this radius, in pixels.
    pub(super) fn add(&mut self, pixels: [usize; 2], radius: f64) {
        for pixel in pixels {
            self.reach[pixel] = self.reach[pixel].max(radius + 1.0);
        }
    }

    /// Per pixel, whether it lies within that radius of an edge, or touches it; distances are the larger of those along rows
    /// and columns.
    pub(super) fn near(self) -> Vec<bool> {
        spread(self.width, self.height, self.reach)
    }
}

fn spread(width: usize, height: usize, mut reach: Vec<f64>) -> Vec<bool> {
    // From neighbour to neighbour, once towards the end of the picture and once back.
    let pull = |reach: &mut [f64], x: usize, y: usize, steps: [(isize, isize); 4]| {
        for (dx, dy) in steps {
            let (Some(from_x), Some(from_y)) = (x.checked_add_signed(dx), y.checked_add_signed(dy)) else { continue };
            if from_x < width && from_y < height {
                reach[y * width + x] = reach[y * width + x].max(reach[from_y * width + from_x] - 1.0);
            }
        }
    };
    for y in 0..height {
        for x in 0..width {
            pull(&mut reach, x, y, [(-1, 0), (-1, -1), (0, -1), (1, -1)]);
        }
    }
    for y in (0..height).rev() {
        for x in (0..width).rev() {
            pull(&mut reach, x, y, [(1, 0), (1, 1), (0, 1), (-1, 1)]);
        }
    }
    reach.into_iter().map(|reach| reach > 0.0).collect()
}

#[cfg(test)]
mod tests {
    use super::Edges;

    fn near_edges(width: usize, height: usize, differ: impl Fn(usize, usize) -> Option<f64>) -> Vec<bool> {
        let mut edges = Edges::new(width, height);
        for pixel in 0..width * height {
            let right = (pixel % width + 1 < width).then(|| pixel + 1);
            let below = (pixel + width < width * height).then(|| pixel + width);
            for other in [right, below].into_iter().flatten() {
                differ(pixel, other).into_iter().for_each(|radius| edges.add([pixel, other], radius));
            }
        }
        edges.near()
    }

    /// An upright edge between columns 5 and 6 that is blurred by 2.5 pixels, and a speck.
    #[test]
    fn edges_reach_as_far_as_they_are_blurred() {
        let value = |pixel: usize| usize::from(pixel % 20 > 5) + 10 * usize::from(pixel == 4 * 20 + 15);
        let near =
            near_edges(20, 9, |a, b| (value(a) != value(b)).then_some(if value(a) + value(b) > 9 { 0.0 } else { 2.5 }));
        for (pixel, near) in near.into_iter().enumerate() {
            let (x, y) = (pixel % 20, pixel / 20);
            let edge = (2..=9).contains(&x);
            let speck = x.abs_diff(15) + y.abs_diff(4) <= 1;
            assert_eq!(near, edge || speck, "{x} {y}");
        }
        assert!(near_edges(7, 7, |_, _| None).into_iter().all(|near| !near));
        assert!(near_edges(7, 7, |_, _| Some(f64::INFINITY)).into_iter().all(|near| near));
    }
}
