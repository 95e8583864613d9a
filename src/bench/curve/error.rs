//! How far a picture is from two independent references.
//!
//! The square of an error against a noisy reference holds the reference's noise too: (t − R)² has the mean
//! (t − r)² + var R. The product (t − R₁)(t − R₂) has the mean (t − r)² exactly, as the noise of the two is independent.

use super::bias::{Blocks, Deviation};
use super::picture::Picture;
use eyebox_base::stats::sidak_z;

/// Share of the pixels that the trimmed error leaves out: those with the largest terms, of either sign.
pub const TRIMMED: f64 = 1e-3;
/// Share of the mean luminance that counts as full error where the picture is black.
pub const FLOOR: f64 = 0.01;
/// A pixel is flat if its eight neighbours in the reference are within this share of it.
pub const FLAT: f64 = 0.1;

/// Two pictures of the same scene that share no randomness, with what is needed of them again and again.
#[derive(Debug, Clone)]
pub struct References {
    first: Picture,
    second: Picture,
    /// r² + (0.01 mean r)², per pixel.
    scale: Vec<f64>,
    flat: Vec<bool>,
    mean: f64,
    /// What is a bias: by these references, or by others.
    blocks: Blocks,
    /// The mean of those that say so, cd/m².
    unbiased: f64,
}

/// A picture's distance from the references.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Error {
    /// Mean of (t − R₁)(t − R₂)/(r² + (0.01 r̄)²) over all pixels.
    pub relmse: f64,
    /// The same without the 0.1 % largest terms.
    pub trimmed: f64,
    /// The same as `relmse` over flat pixels; none if fewer than one in a hundred is flat.
    pub flat: Option<f64>,
    /// The same over all others, where the picture has edges; none if fewer than one in a hundred is such.
    pub edges: Option<f64>,
    /// Mean luminance over the references'.
    pub energy: f64,
    /// Its standard error.
    pub energy_sigma: f64,
    /// Largest deviation of a block's light in standard errors, with its sign.
    pub worst_sigma: f64,
}

impl References {
    /// `first` and `second` have the same size, which is not nothing.
    pub fn new(first: Picture, second: Picture) -> Self {
        let of_both = first.values.iter().zip(&second.values);
        let mean: Vec<f64> = of_both.map(|(a, b)| 0.5 * (a + b)).collect();
        let whole = mean.iter().sum::<f64>() / mean.len().max(1) as f64;
        let black = (FLOOR * whole).powi(2);
        let flat = flat(&mean, first.width, FLOOR * whole);
        let scale = mean.iter().map(|r| r * r + black).collect();
        let blocks = Blocks::new([&first, &second]);
        References { scale, flat, mean: whole, first, second, blocks, unbiased: whole }
    }

    /// The same, but energy and blocks are held against `others` of the same size: those that share no fault with what is
    /// judged may be too rough to tell its error.
    #[must_use]
    pub fn with_bias_by(self, others: References) -> Self {
        References { blocks: others.blocks, unbiased: others.mean, ..self }
    }

    /// Number of blocks in which a bias is looked for; none if the references don't even know the light of the whole.
    pub fn known_blocks(&self) -> Option<usize> {
        self.blocks.known()
    }

    /// Whether there are as many blocks as there may be: the references know the light of each small one.
    pub fn know_all(&self) -> bool {
        self.blocks.know_all()
    }

    /// Number of pixels that are flat, and of all.
    pub fn flat_pixels(&self) -> [usize; 2] {
        [self.flat.iter().filter(|flat| **flat).count(), self.flat.len()]
    }

    /// Mean luminance, cd/m².
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// The smallest relMSE that these references can tell from none: two standard errors and the bias.
    ///
    /// The product of two independent errors of variance v has a deviation of v; (R₁ − R₂)⁴ has the mean 12v². The mean
    /// of the references stands in the denominator too, and e₁e₂/(1 + ½(e₁ + e₂)/r)² has the mean 1.5 v²/r² to second
    /// order.
    pub fn resolution(&self) -> f64 {
        let pairs = self.first.values.iter().zip(&self.second.values).zip(&self.scale);
        let sum: f64 = pairs.map(|((a, b), scale)| per((a - b).powi(2), *scale).powi(2) / 12.0).sum();
        let pixels = self.scale.len().max(1) as f64;
        2.0 * sum.sqrt() / pixels + 1.5 * sum / pixels
    }

    /// relMSE of one reference as the other sees it, shared evenly: their own noise.
    pub fn noise(&self) -> f64 {
        let pairs = self.first.values.iter().zip(&self.second.values).zip(&self.scale);
        let sum: f64 = pairs.map(|((a, b), scale)| 0.5 * per((a - b).powi(2), *scale)).sum();
        sum / self.scale.len().max(1) as f64
    }

    /// The limit of [`Error::worst_sigma`] that one sound picture in twenty passes.
    pub fn most_sigma(&self) -> f64 {
        self.most_sigma_at(0.05)
    }

    /// The same for this rate of false alarms.
    pub fn most_sigma_at(&self, rate: f64) -> f64 {
        sidak_z(rate, self.blocks.count())
    }

    /// Root of the sum of squared errors over the sum of squares, both by products of the two references: what
    /// [`eyebox_estimate::run::Films::relative_error`] states. 0 if the references' noise covers the error.
    pub fn relative_error(&self, picture: &Picture) -> f64 {
        let (mut noise, mut signal) = (0.0, 0.0);
        for ((t, a), b) in picture.values.iter().zip(&self.first.values).zip(&self.second.values) {
            noise += (t - a) * (t - b);
            signal += a * b;
        }
        per(noise, signal).max(0.0).sqrt()
    }

    /// The smallest that [`References::relative_error`] can tell from none: the root of two standard errors of what the
    /// references' own noise adds to its square, as in [`References::resolution`].
    pub fn least_relative_error(&self) -> f64 {
        let pairs = || self.first.values.iter().zip(&self.second.values);
        let square: f64 = pairs().map(|(a, b)| (a - b).powi(4) / 12.0).sum();
        let signal: f64 = pairs().map(|(a, b)| a * b).sum();
        per(2.0 * square.sqrt(), signal).max(0.0).sqrt()
    }

    /// Measures a picture of the same size.
    pub fn measure(&self, picture: &Picture) -> Error {
        let pairs = self.first.values.iter().zip(&self.second.values);
        let terms: Vec<f64> = picture
            .values
            .iter()
            .zip(pairs)
            .zip(&self.scale)
            .map(|((t, (a, b)), scale)| per((t - a) * (t - b), *scale))
            .collect();
        let pixels = terms.len().max(1) as f64;
        let [flat, all] = self.flat_pixels();
        let over = |wanted: bool, count: usize| {
            let own = terms.iter().zip(&self.flat).filter(|(_, flat)| **flat == wanted);
            (count > 0 && count * 100 >= all).then(|| own.map(|(term, _)| term).sum::<f64>() / count as f64)
        };
        let Deviation { whole: [excess, sigma], worst_sigma } = self.blocks.deviation(picture);
        let light = self.unbiased * pixels;
        Error {
            relmse: terms.iter().sum::<f64>() / pixels,
            flat: over(true, flat),
            edges: over(false, all - flat),
            trimmed: trimmed(terms),
            energy: per(excess + light, light),
            energy_sigma: per(sigma, light),
            worst_sigma,
        }
    }
}

/// `a`/`b`; 0 where there is nothing to compare with and nothing to compare.
fn per(a: f64, b: f64) -> f64 {
    if a == 0.0 { 0.0 } else { a / b }
}

/// Mean without the largest terms of either sign: to leave out only positive ones would shift the mean of pure noise.
fn trimmed(mut terms: Vec<f64>) -> f64 {
    let out = (TRIMMED * terms.len() as f64).floor() as usize;
    terms.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
    terms.truncate(terms.len() - out.min(terms.len()));
    terms.iter().sum::<f64>() / terms.len().max(1) as f64
}

/// Which pixels have all their neighbours within [`FLAT`] of them; `black` is the luminance below which only the
/// difference counts.
fn flat(values: &[f64], width: usize, black: f64) -> Vec<bool> {
    let height = values.len() / width.max(1);
    let is_flat = |pixel: usize| {
        let (x, y) = (pixel % width, pixel / width);
        let own = values[pixel];
        (y.saturating_sub(1)..(y + 2).min(height)).all(|j| {
            (x.saturating_sub(1)..(x + 2).min(width))
                .all(|i| (values[j * width + i] - own).abs() <= FLAT * own.abs().max(black))
        })
    };
    (0..values.len()).map(is_flat).collect()
}

#[cfg(test)]
#[path = "error_tests.rs"]
mod tests;
