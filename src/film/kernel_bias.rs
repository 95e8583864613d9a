//! How far gathering within a radius blurs a picture. A kernel that reaches as far as the radius r errs by some c·r²; one
//! of a quarter of its area, with the same photons, by a quarter of that. So 4/3 of what the whole brings beyond the quarter
//! is what it errs by, as long as light changes little within the radius. Where crowded photons' kernels follow their density
//! the error goes as r⁴ at best, and this is up to 5/4 of it. At a sharp edge it is too little: 0.82 to 0.9 of the root of
//! the squared blur in pixels of half the radius and more, 0.73 in those of a quarter.
//!
//! Each pass shows that difference d with noise, N passes their sum D and the sum Q of squares. As far as passes are
//! independent (photons are; what is even over the passes makes it less by some 1/N), (D² − Q)/(N(N − 1)) has the mean of the
//! squared difference: negative by chance where there is no more than noise. The sum over a picture has that chance, too,
//! where few photons make it.

use super::tiles::{Tiles, TilesRow};

/// The sums of a film.
#[derive(Debug, Clone, PartialEq)]
pub struct KernelBias {
    /// `[pixel]`: d and d², of the luminance of all planes.
    pub(super) sums: Tiles,
}

/// What the whole kernel errs by over what it brings beyond a quarter of its area.
const ERRS: f64 = 4.0 / 3.0;

/// How many sums a pixel has.
pub const PER_PIXEL: usize = 2;

impl KernelBias {
    pub fn new(size: [usize; 2]) -> Self {
        KernelBias { sums: Tiles::new(size, 1, PER_PIXEL) }
    }

    pub(super) fn rows(&mut self) -> impl Iterator<Item = TilesRow<'_>> {
        self.sums.rows()
    }

    /// The square of what the mean over `passes` errs by in a pixel, (cd/m²)², by chance less than 0; 0 before the second.
    pub fn square(&self, pixel: usize, passes: u64) -> f64 {
        let n = passes as f64;
        let [sum, squares] = [0, 1].map(|at| self.sums.sum(pixel, at).value());
        if passes < 2 { 0.0 } else { ERRS * ERRS * (sum * sum - squares) / (n * (n - 1.0)) }
    }
}

/// Adds what a pixel has in a pass beyond what a quarter of the kernel's area brings.
pub(super) fn add(row: &mut TilesRow, x: usize, beyond: f64) {
    if beyond == 0.0 {
        return;
    }
    if let [sum, squares] = row.grown(x, 0, PER_PIXEL) {
        sum.add(beyond);
        squares.add(beyond * beyond);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyebox_base::rng::{Rng, Stream};
    use eyebox_base::stats::Moments;

    /// Of 2 ± noise the square of 4/3 · 2; of noise alone nothing.
    #[test]
    fn squares_are_free_of_noise() {
        for beyond in [2.0, 0.0] {
            let mut found = Moments::default();
            for pixel in 0..10_000 {
                let (mut blur, mut rng) = (KernelBias::new([1, 1]), Rng::new(3, Stream::Check, pixel, 0));
                for _ in 0..5 {
                    let mut row = blur.rows().next().expect("a row");
                    add(&mut row, 0, beyond + 6.0 * (rng.uniform() - 0.5));
                }
                found.add(blur.square(0, 5));
            }
            let want = 16.0 / 9.0 * beyond * beyond;
            assert!((found.mean - want).abs() < 4.0 * found.stderr(), "{} ± {}, {want}", found.mean, found.stderr());
            assert!(found.stderr() < 0.2, "{}", found.stderr());
        }
    }
}
