//! How far gathering within a radius blurs a picture. A kernel that reaches as far as the radius r errs by some c·r²; one
//! of half its area, with the same photons, by half of that. So twice what the whole brings beyond the half is what it errs
//! by, as long as light changes little within the radius; where it changes more that is too little.
//!
//! Each pass shows that difference d with noise, N passes their sum D and the sum Q of squares. Passes are independent, so
//! (D² − Q)/(N(N − 1)) has the mean of the squared difference: negative by chance where there is no more than noise, as
//! good as nothing in the sum over a picture.

use crate::base::twofold::Sum;

/// The sums of a film.
#[derive(Debug, Clone, PartialEq)]
pub struct Blur {
    /// `[pixel]`: d and d², of the luminance of all planes.
    pub(super) sums: Vec<[Sum; 2]>,
}

/// How many sums a pixel has.
pub const PER_PIXEL: usize = 2;

impl Blur {
    pub fn new(pixels: usize) -> Self {
        Blur { sums: vec![[Sum::ZERO; PER_PIXEL]; pixels] }
    }

    /// The rows of a film that is `width` pixels wide.
    pub fn rows(&mut self, width: usize) -> impl Iterator<Item = &mut [[Sum; PER_PIXEL]]> {
        self.sums.chunks_mut(width.max(1))
    }

    /// The square of what the mean over `passes` errs by in a pixel, (cd/m²)², by chance less than 0; 0 before the second.
    pub fn square(&self, pixel: usize, passes: u64) -> f64 {
        let n = passes as f64;
        let [sum, squares] = self.sums[pixel].map(|sum| sum.value());
        if passes < 2 { 0.0 } else { 4.0 * (sum * sum - squares) / (n * (n - 1.0)) }
    }
}

/// Adds what a pixel has in a pass beyond what half the kernel's area brings.
pub fn add([sum, squares]: &mut [Sum; PER_PIXEL], beyond: f64) {
    sum.add(beyond);
    squares.add(beyond * beyond);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::rng::{Rng, Stream};
    use crate::base::stats::Moments;

    /// Of 2 ± noise the square of 2·2; of noise alone nothing.
    #[test]
    fn squares_are_free_of_noise() {
        for beyond in [2.0, 0.0] {
            let mut found = Moments::default();
            for pixel in 0..10_000 {
                let (mut blur, mut rng) = (Blur::new(1), Rng::new(3, Stream::Check, pixel, 0));
                for _ in 0..5 {
                    add(&mut blur.sums[0], beyond + 6.0 * (rng.uniform() - 0.5));
                }
                found.add(blur.square(0, 5));
            }
            let want = 4.0 * beyond * beyond;
            assert!((found.mean - want).abs() < 4.0 * found.stderr(), "{} ± {}, {want}", found.mean, found.stderr());
            assert!(found.stderr() < 0.2, "{}", found.stderr());
        }
    }
}
