//! Means of square blocks of pixels, where single pixels are too noisy to tell anything.

use super::{Pair, sidak};
use eyebox_base::students_t::{two_sided, welch};

/// How a layer is tested.
#[derive(Debug, Clone, Copy)]
pub struct Trial {
    /// Pixels of a row of the picture.
    pub width: usize,
    /// Pixels of a block's side; 1 for single pixels.
    pub side: usize,
    /// Tests of all layers together.
    pub tests: usize,
    /// Chance of a false alarm that all of them together may have.
    pub rate: f64,
    /// Degrees of freedom of a pixel's error, in A and in B.
    pub freedoms: [f64; 2],
    /// Whether the pixels of A and of B err independently.
    pub independent: [bool; 2],
}

/// Blocks of a picture of `pixels` pixels, those that the rim cuts included.
pub fn count(width: usize, pixels: usize, side: usize) -> usize {
    let (width, side) = (width.max(1), side.max(1));
    width.div_ceil(side).saturating_mul((pixels / width).div_ceil(side))
}

/// What one frame says of one block.
#[derive(Debug, Clone, Copy, Default)]
struct Pool {
    pixels: f64,
    sum: f64,
    /// Sums of σ, σ² and σ⁴.
    powers: [f64; 3],
}

impl Pool {
    fn add(&mut self, value: f64, sigma: f64) {
        self.pixels += 1.0;
        self.sum += value;
        let square = sigma * sigma;
        for (sum, term) in self.powers.iter_mut().zip([sigma, square, square * square]) {
            *sum += term;
        }
    }

    fn mean(&self) -> f64 {
        self.sum / self.pixels
    }

    /// Variance of the mean: Σσ²/n² where pixels err independently, else the most that it can be, (Σσ/n)².
    fn variance(&self, independent: bool) -> f64 {
        let [first, second, _] = self.powers;
        (if independent { second } else { first * first }) / (self.pixels * self.pixels)
    }

    /// How well that is known, as degrees of freedom. (Σσ²)²/Σσ⁴ is the number of pixels that make the variance: all of
    /// them if they are alike, those that met any light where it is rare. Each counts as one sample, which is never too
    /// many: a variance that k rare events make has a relative error of 1/√k, as that of χ² with 2k degrees of freedom.
    fn freedom(&self, of_pixel: f64, independent: bool) -> f64 {
        let [_, second, fourth] = self.powers;
        if independent && fourth > 0.0 { of_pixel.max(second * second / fourth) } else { of_pixel }
    }
}

/// The block that differs most in view of its errors. `values` and `errors` of A and B, row by row.
pub fn largest(values: [&[f64]; 2], errors: [&[f64]; 2], rounding: impl Fn(f64) -> f64, of: &Trial) -> Option<Pair> {
    let (width, side) = (of.width.max(1), of.side.max(1));
    let columns = width.div_ceil(side);
    let mut pools = vec![[Pool::default(); 2]; count(width, values[0].len(), side)];
    for which in [0, 1] {
        for (pixel, (value, error)) in values[which].iter().zip(errors[which]).enumerate() {
            let block = pixel / width / side * columns + pixel % width / side;
            if let Some(pool) = pools.get_mut(block) {
                pool[which].add(*value, *error);
            }
        }
    }
    let judged = pools.iter().enumerate().map(|(block, pool)| {
        let means = [0, 1].map(|which| pool[which].mean());
        let variances = [0, 1].map(|which| pool[which].variance(of.independent[which]));
        let freedoms = [0, 1].map(|which| pool[which].freedom(of.freedoms[which], of.independent[which]));
        let sigma = (variances[0] + variances[1] + rounding(means[0].abs().max(means[1].abs())).powi(2)).sqrt();
        let z = if means[0] == means[1] { 0.0 } else { (means[1] - means[0]) / sigma };
        let p = two_sided(z, welch([variances[0], freedoms[0]], [variances[1], freedoms[1]]));
        let (x, y) = (block % columns * side, block / columns * side);
        Pair { x, y, a: means[0], b: means[1], z, p: sidak(p, of.tests) }
    });
    judged.min_by(|a, b| a.p.total_cmp(&b.p))
}
