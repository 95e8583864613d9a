//! Where paths from the eye start: each pixel has a lattice of its own over its area and the pupil, on which the passes go
//! from point to point. Edges then converge faster than with independent points, and passes differ by less than their
//! variance says.

use eyebox_base::lattice::lattice;
use eyebox_base::rng::{Rng, Stream};
use eyebox_world::eye::EyeLens;
use eyebox_world::geometry::Ray;

/// Which pixel in which pass.
#[derive(Debug, Clone, Copy)]
pub struct Pixel {
    pub x: usize,
    pub y: usize,
    /// Row-major.
    pub index: u64,
    pub pass: u64,
}

impl Pixel {
    /// `width`: of the picture, pixels.
    pub fn new((x, y): (usize, usize), width: usize, pass: u64) -> Pixel {
        Pixel { x, y, index: (y * width + x) as u64, pass }
    }

    /// Start number `index` of the pixel's lattice for paths of one stream.
    pub fn start<const D: usize>(&self, seed: u64, stream: Stream, index: u64) -> [f64; D] {
        let mut shift = Rng::new(seed, Stream::PixelShift, stream as u64, self.index);
        lattice(std::array::from_fn(|_| shift.next_u64()), index)
    }

    /// The ray of this pass for paths of one stream.
    pub fn ray(&self, eye: &EyeLens, seed: u64, stream: Stream) -> Ray {
        let [x, y, u, v] = self.start(seed, stream, self.pass);
        let (origin, dir) = eye.ray(self.x, self.y, [x, y], [u, v]);
        Ray { origin, dir, from: None }
    }

    /// Random numbers of this pass for a path of one stream.
    pub fn rng(&self, seed: u64, stream: Stream) -> Rng {
        Rng::new(seed, stream, self.pass, self.index)
    }
}
