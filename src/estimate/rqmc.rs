//! Numbers in [0, 1) by which paths from the eye scatter. They are even over a pixel's paths as their starts are, so that
//! what comes over a second scatterer converges nearly as edges do.

use super::pixel::Pixel;
use eyebox_base::rng::{Rng, Stream};
use eyebox_base::sobol::Sobol;

/// Triples for the first decisions of a path.
pub struct Rqmc([[f64; 3]; 2]);

impl Rqmc {
    /// `path`: number of the path among all of the pixel that `stream` makes.
    pub fn new(seed: u64, stream: Stream, pixel: Pixel, path: u64) -> Rqmc {
        // Each pixel has a sequence of its own.
        let of_pixel = Rng::new(seed, Stream::Bounce, stream as u64, pixel.index).next_u64();
        // The first coordinate is even as the wavelengths of passes are: with it, a pixel would always scatter the same of them
        // the same way.
        // Those that are most even together are the direction's; which lobe it is of is seldom asked.
        let [_, b, c, d, e, f, a] = Sobol::new(of_pixel, Stream::Bounce, 0).point(path);
        Rqmc([[a, b, c], [d, e, f]])
    }

    /// The triple of this number; those beyond are chance.
    pub fn take(&self, number: u32, rng: &mut Rng) -> [f64; 3] {
        self.0.get(number as usize).copied().unwrap_or_else(|| rng.triple())
    }
}
