//! One layer of two frames: its values, what is known of their errors, and the verdict.

use super::blocks::{self, Trial};
use super::names::{belongs, is_data, is_light};
use super::{LayerDifference, Pair, Verdict, sidak};
use crate::luminance::Luminance;
use eyebox_base::students_t::{two_sided, welch};
use eyebox_film::frame::Frame;

/// Layers without error may differ by this share of their range: f32 rounding after different orders of sums.
const ROUNDING: f64 = 1e-5;
/// Relative f32 rounding of one value, twice.
const VALUE_ROUNDING: f64 = 2.4e-7;

/// One layer of both frames, ready to be judged.
pub struct Layered {
    pub name: String,
    pixels: usize,
    picture: bool,
    identical: bool,
    /// Values that are no numbers, the same ones in both frames: left out.
    no_numbers: usize,
    /// Per pixel: luminance for pictures, else every component in turn.
    pub values: [Vec<f64>; 2],
    /// One-sigma errors.
    errors: Option<[Vec<f64>; 2]>,
    /// Rounding of what is black, cd/m².
    dark: f64,
}

impl Layered {
    pub fn of(a: &Frame, b: &Frame, name: &str, dark: f64) -> Layered {
        let coloured = a.rgb(name).is_some() || b.rgb(name).is_some();
        let picture = is_light(name) || coloured && !is_data(name);
        let error_name =
            if name.is_empty() || name == "hybrid" { "stderr".to_owned() } else { format!("{name}_stderr") };
        let mut values = [a, b].map(|frame| values(frame, name, picture));
        let mut errors = [a, b].map(|frame| {
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
        let no_numbers = without_common_gaps(&mut values, &mut errors);
        let [error_a, error_b] = errors;
        // Too few passes to tell errors: NaN.
        let known = |errors: &[f64], values: &[f64]| {
            !errors.iter().any(|e| e.is_nan()) && (errors.iter().any(|e| *e > 0.0) || values.iter().all(|v| *v == 0.0))
        };
        let errors = error_a.zip(error_b).map(|(a, b)| [a, b]);
        let errors = errors.filter(|[a, b]| picture && known(a, &values[0]) && known(b, &values[1]));
        let (name, pixels) = (name.to_owned(), a.width * a.height);
        Layered { name, pixels, picture, identical, no_numbers, values, errors, dark }
    }

    /// Every pixel or block, and the mean.
    pub fn tests(&self, width: usize, side: usize) -> usize {
        if self.identical || self.errors.is_none() { 0 } else { blocks::count(width, self.values[0].len(), side) + 1 }
    }

    pub fn judge(&self, trial: &Trial) -> LayerDifference {
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
            found.verdict = Verdict::Different;
            found.because = "values that are not numbers stand in one where the other has numbers".to_owned();
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
        if self.no_numbers > 0 {
            found.because += &format!(", less {} values that are no numbers in both", self.no_numbers);
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

/// Values that are no numbers and the same in both frames say nothing: 0 ± 0 stands for them. How many they are.
fn without_common_gaps(values: &mut [Vec<f64>; 2], errors: &mut [Option<Vec<f64>>; 2]) -> usize {
    let [a, b] = values;
    let mut found = 0;
    for (at, (a, b)) in a.iter_mut().zip(b).enumerate() {
        let alike = a.is_nan() && b.is_nan() || a.is_infinite() && *a == *b;
        if alike {
            found += 1;
            (*a, *b) = (0.0, 0.0);
            errors.iter_mut().flatten().filter_map(|errors| errors.get_mut(at)).for_each(|error| *error = 0.0);
        }
    }
    found
}
