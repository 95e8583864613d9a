//! Two frames compared by their standard errors: what differs by more than noise. `docs/diff.md` says what is claimed.

mod blocks;
mod header;
mod layered;
mod names;
mod within;

use super::average::pixels_are_independent;
use blocks::Trial;
use eyebox_base::stats::normal_tail;
use eyebox_film::frame::Frame;
use header::{freedom, incomparable, notes};
use layered::Layered;
use names::{common, is_light};

pub(super) use names::is_data;

pub use within::{Deviation, Deviations, weighted_sum, within};

/// Share of the brightest pixel's light below which all is the rounding of f64 sums: pictures taken apart by the slide's
/// contrast are differences of large numbers.
const DARK: f64 = 1e-12;

/// What was found for one layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Every bit.
    Identical,
    /// Within the errors (or within rounding, for layers that have none).
    Same,
    Different,
    /// Not judged, see `because`.
    Unjudged,
}

/// A pixel of two frames, or the mean of a block of them, by its upper left one.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Pair {
    pub x: usize,
    pub y: usize,
    /// Values in A and B, cd/m² of luminance for pictures.
    pub a: f64,
    pub b: f64,
    /// Difference over its standard error; infinite where there is none.
    pub z: f64,
    /// Probability of one this large in any of the pixels that were judged (Šidák).
    pub p: f64,
}

/// The comparison of one layer.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct LayerDifference {
    /// Empty for the default image.
    pub layer: String,
    pub verdict: Verdict,
    pub because: String,
    /// Pixels with a standard error in either frame.
    pub judged_pixels: usize,
    pub largest: Option<Pair>,
    /// Mean of z² over the judged pixels, and what noise alone gives with so few samples (ν/(ν − 2)).
    pub mean_z2: Option<[f64; 2]>,
    /// Means of both, cd/m² of luminance for pictures.
    pub mean: [f64; 2],
    /// B − A.
    pub difference: f64,
    /// Standard error of the difference if pixels were independent: too small where they share paths.
    pub error_if_independent: Option<f64>,
    /// It cannot be larger than this, however pixels lean on each other.
    pub error_at_most: Option<f64>,
    /// Mean of (A − B)²/(B² + (0.01·mean B)²), and how much of that the stated noise accounts for.
    pub relative_mse: f64,
    pub relative_mse_of_noise: Option<f64>,
}

/// The comparison of two frames.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Comparison {
    /// Of the frames as wholes: `Unjudged` if light is in no layer that was judged, and nothing else is `Different`.
    pub verdict: Verdict,
    pub different: bool,
    /// Two-sided quantile of the normal distribution that all tests together must not exceed.
    pub sigma: f64,
    /// Pixels of the side of the blocks that were judged; 1 for single pixels.
    pub block: usize,
    /// Why the frames cannot be compared at all; then nothing below was compared.
    pub incomparable: Vec<String>,
    /// Layers that only one has, with whose it is.
    pub only_in: Vec<(String, char)>,
    /// What else differs in the headers: no verdict depends on it.
    pub notes: Vec<String>,
    pub layers: Vec<LayerDifference>,
}

/// Compares the layers of two frames. `sigma`: how rare a difference must be among all that are tested: 3 is a chance of
/// 0.27 % that frames of one scene with independent seeds are called different.
pub fn compare(a: &Frame, b: &Frame, sigma: f64) -> Comparison {
    compare_blocks(a, b, sigma, 1)
}

/// The same, with means of blocks of `side` × `side` pixels in place of single pixels.
pub fn compare_blocks(a: &Frame, b: &Frame, sigma: f64, side: usize) -> Comparison {
    let mut found = Comparison {
        verdict: Verdict::Different,
        different: false,
        sigma,
        block: side,
        incomparable: incomparable(a, b),
        only_in: Vec::new(),
        notes: notes(a, b),
        layers: Vec::new(),
    };
    if !found.incomparable.is_empty() {
        found.different = true;
        return found;
    }
    let (all, only_in) = common(a, b);
    found.only_in = only_in;
    let brightest = [a, b].into_iter().filter_map(|frame| super::luminance::layer_luminance(frame, ""));
    let dark = DARK * brightest.flatten().filter(|value| value.is_finite()).fold(0.0, f64::max);
    let mut layers: Vec<Layered> = all.iter().map(|name| Layered::of(a, b, name, dark)).collect();
    // The default image and `hybrid` are the same picture: one test.
    let hybrid = layers.iter().position(|layer| layer.name == "hybrid");
    let default = layers.iter().position(|layer| layer.name.is_empty());
    if let (Some(hybrid), Some(default)) = (hybrid, default)
        && layers[hybrid].values == layers[default].values
    {
        layers.remove(hybrid);
    }
    let trial = Trial {
        width: a.width,
        side,
        tests: layers.iter().map(|layer| layer.tests(a.width, side)).sum(),
        rate: 2.0 * normal_tail(sigma),
        freedoms: [freedom(a), freedom(b)],
        independent: [a, b].map(pixels_are_independent),
    };
    found.layers = layers.iter().map(|layer| layer.judge(&trial)).collect();
    found.verdict = found.whole();
    found.different = found.verdict == Verdict::Different;
    found
}

impl Comparison {
    fn whole(&self) -> Verdict {
        let of = |verdict: Verdict| self.layers.iter().filter(move |layer| layer.verdict == verdict);
        if !self.only_in.is_empty() || of(Verdict::Different).next().is_some() {
            return Verdict::Different;
        }
        // Shares add up to the picture: what was found for it holds for their sum.
        let is_picture = |layer: &LayerDifference| ["", "hybrid"].contains(&layer.layer.as_str());
        let sum_is_judged = self.layers.iter().any(|layer| is_picture(layer) && layer.verdict != Verdict::Unjudged);
        let open = |layer: &LayerDifference| !(sum_is_judged && is_light(&layer.layer));
        if of(Verdict::Unjudged).any(open) {
            Verdict::Unjudged
        } else if of(Verdict::Identical).count() == self.layers.len() {
            Verdict::Identical
        } else {
            Verdict::Same
        }
    }
}

/// Probability of one result of `p` or rarer among `tests` (Šidák; an upper bound for normal deviates however they lean
/// on each other).
fn sidak(p: f64, tests: usize) -> f64 {
    -(tests.max(1) as f64 * f64::ln_1p(-p.min(1.0 - f64::EPSILON))).exp_m1()
}

#[cfg(test)]
mod tests;
