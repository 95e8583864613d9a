//! Two frames compared by their standard errors: what differs by more than noise. `docs/diff.md` says what is claimed.

mod blocks;
mod header;
mod names;
mod within;

use super::average::pixels_are_independent;
use super::luminance::Luminance;
use crate::base::stats::normal_tail;
use crate::base::students_t::{two_sided, welch};
use crate::film::frame::Frame;
use blocks::Trial;
use header::{freedom, incomparable, notes};
use names::{belongs, common, is_light};

pub(super) use names::is_data;

pub use within::{Deviation, Deviations, weighted_sum, within};

/// Layers without error may differ by this share of their range: f32 rounding after different orders of sums.
const ROUNDING: f64 = 1e-5;
/// Relative f32 rounding of one value, twice.
const VALUE_ROUNDING: f64 = 2.4e-7;
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
    let mut layers: Vec<Layered> = all.iter().map(|name| Layered { dark, ..Layered::of(a, b, name) }).collect();
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
    let differs = |layer: &LayerDifference| layer.verdict == Verdict::Different;
    found.different = !found.only_in.is_empty() || found.layers.iter().any(differs);
    found
}

/// One layer of both frames, ready to be judged.
struct Layered {
    name: String,
    pixels: usize,
    picture: bool,
    identical: bool,
    /// Per pixel: luminance for pictures, else every component in turn.
    values: [Vec<f64>; 2],
    /// One-sigma errors.
    errors: Option<[Vec<f64>; 2]>,
    /// Rounding of what is black, cd/m².
    dark: f64,
}

impl Layered {
    fn of(a: &Frame, b: &Frame, name: &str) -> Layered {
        let coloured = a.rgb(name).is_some() || b.rgb(name).is_some();
        let picture = is_light(name) || coloured && !is_data(name);
        let error_name =
            if name.is_empty() || name == "hybrid" { "stderr".to_owned() } else { format!("{name}_stderr") };
        let values = [a, b].map(|frame| values(frame, name, picture));
        let errors = [a, b].map(|frame| {
            let missing = || frame.rgb(name).is_none().then(|| vec![0.0; frame.width * frame.height]);
            let stored = frame.rgb(&error_name).map(|[error, ..]| error.iter().map(|e| f64::from(*e)).collect());
            stored.or_else(missing)
        });
        let bits = |frame: &Frame| -> Vec<u32> {
            frame
                .channels
                .iter()
                .filter(|c| belongs(c, name))
                .flat_map(|c| c.data.iter().map(|v| v.to_bits()))
                .collect()
        };
        let identical = bits(a) == bits(b);
        let [error_a, error_b] = errors;
        // Too few passes to tell errors: NaN.
        let known = |errors: &[f64], values: &[f64]| {
            !errors.iter().any(|e| e.is_nan()) && (errors.iter().any(|e| *e > 0.0) || values.iter().all(|v| *v == 0.0))
        };
        let errors = error_a.zip(error_b).map(|(a, b)| [a, b]);
        let errors = errors.filter(|[a, b]| picture && known(a, &values[0]) && known(b, &values[1]));
        Layered { name: name.to_owned(), pixels: a.width * a.height, picture, identical, values, errors, dark: 0.0 }
    }

    /// Every pixel or block, and the mean.
    fn tests(&self, width: usize, side: usize) -> usize {
        if self.identical || self.errors.is_none() { 0 } else { blocks::count(width, self.values[0].len(), side) + 1 }
    }

    fn judge(&self, trial: &Trial) -> LayerDifference {
        let [a, b] = &self.values;
        let count = a.len().max(1) as f64;
        let mean = [a, b].map(|values| values.iter().sum::<f64>() / count);
        let floor = (0.01 * mean[1]).powi(2);
        // Where both are black nothing differs.
        let relative = |square: f64, b: f64| if square > 0.0 { square / (b * b + floor) } else { 0.0 };
        let pairs = || a.iter().zip(b);
        let mut found = LayerDifference {
            layer: self.name.clone(),
            verdict: Verdict::Identical,
            because: "every bit is the same".to_owned(),
            judged_pixels: 0,
            largest: None,
            mean_z2: None,
            mean,
            difference: pairs().map(|(a, b)| b - a).sum::<f64>() / count,
            error_if_independent: None,
            error_at_most: None,
            relative_mse: pairs().map(|(a, b)| relative((a - b).powi(2), *b)).sum::<f64>() / count,
            relative_mse_of_noise: None,
        };
        if self.identical {
            return found;
        }
        if pairs().any(|(a, b)| !a.is_finite() || !b.is_finite()) {
            let alike = pairs().all(|(a, b)| a.is_finite() && b.is_finite() || a.to_bits() == b.to_bits());
            found.verdict = if alike { Verdict::Unjudged } else { Verdict::Different };
            found.because = "there are values that are not numbers".to_owned();
            return found;
        }
        match &self.errors {
            Some([error_a, error_b]) => {
                self.judge_by_errors(&mut found, trial, [error_a, error_b]);
            }
            None if self.picture => {
                found.verdict = Verdict::Unjudged;
                found.because =
                    "no standard error of it in both files: render two passes or more with --stderr layers".to_owned();
            }
            None => self.judge_by_range(&mut found, trial.width),
        }
        found
    }

    fn judge_by_errors(&self, found: &mut LayerDifference, trial: &Trial, [error_a, error_b]: [&[f64]; 2]) {
        let [a, b] = &self.values;
        let count = a.len().max(1) as f64;
        let floor = (0.01 * found.mean[1]).powi(2);
        let (mut squares, mut expected, mut variance, mut at_most, mut noise) = (0.0, 0.0, 0.0, 0.0, 0.0);
        let mut least = (1.0f64, None::<Pair>);
        for (pixel, (((a, b), error_a), error_b)) in a.iter().zip(b).zip(error_a).zip(error_b).enumerate() {
            let rounding = VALUE_ROUNDING * a.abs().max(b.abs()) + self.dark;
            let variances = [error_a * error_a, error_b * error_b];
            let sum = variances[0] + variances[1];
            let sigma = (sum + rounding * rounding).sqrt();
            let z = if a == b { 0.0 } else { (b - a) / sigma };
            let freedom = welch([variances[0], trial.freedoms[0]], [variances[1], trial.freedoms[1]]);
            let p = two_sided(z, freedom);
            if least.1.is_none() || p < least.0 {
                let (x, y) = (pixel % trial.width, pixel / trial.width);
                least = (p, Some(Pair { x, y, a: *a, b: *b, z, p: sidak(p, trial.tests) }));
            }
            if sum > 0.0 {
                found.judged_pixels += 1;
                squares += z * z;
                expected += if freedom > 2.0 { freedom / (freedom - 2.0) } else { f64::INFINITY };
                noise += sum / (b * b + floor).max(f64::MIN_POSITIVE);
            }
            variance += sum;
            at_most += sum.sqrt();
        }
        let judged = found.judged_pixels as f64;
        let rounded = |value: f64| VALUE_ROUNDING * value + self.dark;
        found.largest =
            if trial.side > 1 { blocks::largest([a, b], [error_a, error_b], rounded, trial) } else { least.1 };
        found.mean_z2 = (judged > 0.0 && expected.is_finite()).then_some([squares / judged, expected / judged]);
        let error = variance.sqrt() / count;
        found.error_if_independent = Some(error);
        found.error_at_most = Some(at_most / count);
        found.relative_mse_of_noise = Some(noise / count);
        let independent = trial.independent.iter().all(|independent| *independent);
        let error = if independent { error } else { at_most / count };
        let rounding = VALUE_ROUNDING * found.mean[0].abs().max(found.mean[1].abs()) + self.dark;
        let z_of_mean = found.difference / error.hypot(rounding);
        // The mean of many pixels has many degrees of freedom.
        let p_of_mean = sidak(two_sided(if z_of_mean.is_nan() { 0.0 } else { z_of_mean }, f64::INFINITY), trial.tests);
        let pixel = found.largest.filter(|pair| pair.p < trial.rate);
        (found.verdict, found.because) = match pixel {
            Some(pair) => {
                let what = if trial.side > 1 { "the block at" } else { "pixel" };
                (Verdict::Different, format!("{what} ({}, {}) is {:.2} standard errors off", pair.x, pair.y, pair.z))
            }
            None if p_of_mean < trial.rate => {
                let kind = if independent { "" } else { " at least" };
                (Verdict::Different, format!("the mean is{kind} {:.2} standard errors off", z_of_mean.abs()))
            }
            None => (Verdict::Same, "within the standard errors".to_owned()),
        };
    }

    fn judge_by_range(&self, found: &mut LayerDifference, width: usize) {
        let [a, b] = &self.values;
        // Depth is 1e10 m where nothing is hit: that is no range.
        let usual = |v: &&f64| v.abs() < 1e10;
        let range = a.iter().chain(b).filter(usual).fold(0.0f64, |range, v| range.max(v.abs()));
        let off = |(_, (a, b)): &(usize, (&f64, &f64))| (*a - *b).abs() > ROUNDING * range;
        let differing = a.iter().zip(b).enumerate().filter(off).count();
        let worst =
            a.iter().zip(b).enumerate().max_by(|(_, (a, b)), (_, (c, d))| (*a - *b).abs().total_cmp(&(*c - *d).abs()));
        found.largest = worst.map(|(index, (a, b))| {
            // Components stand one after the other.
            let pixel = index % self.pixels.max(1);
            let z = if differing > 0 { f64::INFINITY } else { 0.0 };
            let p = if differing > 0 { 0.0 } else { 1.0 };
            Pair { x: pixel % width, y: pixel / width, a: *a, b: *b, z, p }
        });
        (found.verdict, found.because) = if differing > 0 {
            (Verdict::Different, format!("{differing} values differ, and they have no noise"))
        } else {
            (Verdict::Same, "within rounding".to_owned())
        };
    }
}

fn values(frame: &Frame, name: &str, picture: bool) -> Vec<f64> {
    let pixels = frame.width * frame.height;
    match frame.rgb(name) {
        Some(channels) if picture => Luminance::in_frame(frame).image(channels),
        None if picture => vec![0.0; pixels],
        Some(_) | None => {
            let own = frame.channels.iter().filter(|channel| belongs(channel, name));
            own.flat_map(|channel| channel.data.iter().map(|value| f64::from(*value))).collect()
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
