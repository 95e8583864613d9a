//! How a place on a face moves over the pixel that sees it: what it takes to have a slide's picture cut by the pixel's footprint.

use glam::{DVec2, DVec3};

/// How the place where a ray lands moves over its pixel.
#[derive(Debug, Clone, Copy)]
pub struct Span {
    /// m from one pixel to the next, to the right and down.
    pub by: [DVec3; 2],
    /// Where the ray is in its pixel, from the middle, in pixels to the right and down.
    pub within: DVec2,
    /// What is even over the pixel, of all light that the visit stands for; the rest is of the ray alone. Not from 0 to 1 where a
    /// followed ray stands for some of it.
    pub whole: f64,
}

impl Span {
    /// From where the ray lands to where the pixel's corners do, m.
    pub fn corners(&self) -> [DVec3; 4] {
        let [right, down] = self.by;
        [[-0.5, -0.5], [0.5, -0.5], [-0.5, 0.5], [0.5, 0.5]]
            .map(|[x, y]| right * (x - self.within.x) + down * (y - self.within.y))
    }
}
