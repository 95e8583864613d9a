//! Spreads the light of a finished picture as the lit pupil does by diffraction (`docs/diffraction.md`).
//!
//! What pixel j gives to pixel i is the point spread integrated over both: the transfer function of the pupil times
//! sinc² of the pixel, folded at the pixel's sampling frequency. Both are exact for pixels that are even inside, and the
//! shares that a pixel gives add up to 1. Pictures are padded to twice their size, so that what leaves the picture on one
//! side does not come in on the other.

use super::accumulate::light::COLUMNS;
use super::accumulate::{Light, PlaneKey};
use super::layer::Layer;
use super::pupil::Pupil;
use super::sharpness::{Applied, Blurred, GroupPupil};
use eyebox_base::colour::ColourSpace;
use rayon::prelude::*;
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlannerScalar};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::sync::Arc;

/// Dominant wavelengths of the primaries of Rec.709 seen from D65, nm: where R, G and B of a colour picture are spread.
pub const PRIMARIES_NM: [f64; 3] = [611.4, 549.1, 464.2];
/// Most times that the transfer function is folded on either side: a point spread below an eighth of a pixel is left out.
const MOST_FOLDS: f64 = 8.0;

/// A pupil's spread for pictures of one size, ready to be applied.
pub struct Spread {
    size: [usize; 2],
    padded: [usize; 2],
    /// Transfer of each frequency, column by column; real, since what a pixel gives and takes are the same.
    transfer: Vec<f64>,
    plans: [[Arc<dyn Fft<f64>>; 2]; 2],
}

/// The smallest number with no other prime factors than 2, 3 and 5 that is not below `least`.
fn smooth(least: usize) -> usize {
    let good = |mut n: usize| {
        for prime in [2, 3, 5] {
            while n.is_multiple_of(prime) {
                n /= prime;
            }
        }
        n == 1
    };
    (least.max(1)..).find(|n| good(*n)).unwrap_or(least)
}

/// Per frequency of one axis: lags in the pupil, m, and their weights.
fn folds(padded: usize, lag_of_pixel_m: f64, reach_m: f64) -> Vec<Vec<(f64, f64)>> {
    let most = (reach_m / lag_of_pixel_m).ceil() as i64 + 1;
    (0..padded)
        .map(|p| {
            let signed = if 2 * p > padded { p as f64 - padded as f64 } else { p as f64 } / padded as f64;
            let fold = |k: i64| {
                // In cycles per pixel.
                let frequency = signed + k as f64;
                let phase = PI * frequency;
                let sinc = if phase == 0.0 { 1.0 } else { (PI * signed).sin() / phase };
                (frequency * lag_of_pixel_m, sinc * sinc)
            };
            (-most..=most).map(fold).filter(|(lag, weight)| lag.abs() < reach_m && *weight > 0.0).collect()
        })
        .collect()
}

impl Spread {
    /// `pixel`: width and height of a pixel in tangents. Errors: why there is nothing to apply.
    pub fn new(
        pupil: &Pupil,
        wavelength_nm: f64,
        size: [usize; 2],
        pixel: [f64; 2],
    ) -> std::result::Result<Spread, String> {
        if *pupil == Pupil::Point {
            return Err("the pupil is a point".to_owned());
        }
        // A frequency of one cycle per pixel is this lag in the pupil.
        let lag = pixel.map(|tangent| 1e-9 * wavelength_nm / tangent);
        let reach = pupil.reach_m();
        if !(0..2).all(|k| lag[k] > 0.0 && lag[k].is_finite() && (0.0..=MOST_FOLDS * lag[k]).contains(&reach[k])) {
            return Err("the diffraction limit is below an eighth of a pixel".to_owned());
        }
        let padded = size.map(|length| length.checked_mul(2).map(smooth));
        let [Some(width), Some(height)] = padded else { return Err("the picture is too large".to_owned()) };
        if width.checked_mul(height).is_none_or(|count| count > isize::MAX as usize / size_of::<Complex<f64>>()) {
            return Err("the picture is too large".to_owned());
        }
        let across = folds(width, lag[0], reach[0]);
        let down = folds(height, lag[1], reach[1]);
        let column = |p: usize| {
            // Rows count downwards, lags in the pupil upwards.
            let at = |q: usize| {
                let of = |(x, u): &(f64, f64)| {
                    down[q].iter().map(move |(y, v)| u * v * pupil.transfer([*x, -y])).sum::<f64>()
                };
                across[p].iter().map(of).sum::<f64>()
            };
            (0..height).map(at).collect::<Vec<f64>>()
        };
        let half: Vec<Vec<f64>> = (0..=width / 2).into_par_iter().map(column).collect();
        let mut transfer = Vec::with_capacity(width * height);
        for p in 0..width {
            if p <= width / 2 {
                transfer.extend_from_slice(&half[p]);
            } else {
                // The same at the opposite frequency.
                transfer.extend((0..height).map(|q| half[width - p][(height - q) % height]));
            }
        }
        // Scalar plans: the same bits on every processor.
        let mut planner = FftPlannerScalar::new();
        let plans = [width, height].map(|length| [planner.plan_fft_forward(length), planner.plan_fft_inverse(length)]);
        Ok(Spread { size, padded: [width, height], transfer, plans })
    }

    /// Spreads two pictures of row-major pixels at once; what leaves the picture is lost.
    pub fn apply(&self, first: &mut [f64], second: &mut [f64]) {
        let ([width, height], [wide, high]) = (self.size, self.padded);
        let mut field = vec![Complex::new(0.0, 0.0); wide * high];
        for y in 0..height {
            let pairs = first[y * width..(y + 1) * width].iter().zip(&second[y * width..(y + 1) * width]);
            for (to, (a, b)) in field[y * wide..].iter_mut().zip(pairs) {
                *to = Complex::new(*a, *b);
            }
        }
        let [[rows, rows_back], [columns, columns_back]] = &self.plans;
        let run = |plan: &Arc<dyn Fft<f64>>, field: &mut [Complex<f64>]| {
            field.par_chunks_mut(plan.len()).for_each(|line| plan.process(line));
        };
        // Rows below the picture are empty.
        run(rows, &mut field[..height * wide]);
        let mut turned = transposed(&field, wide, high);
        run(columns, &mut turned);
        let scale = 1.0 / (wide as f64 * high as f64);
        turned.par_iter_mut().zip(&self.transfer).for_each(|(value, transfer)| *value *= *transfer * scale);
        run(columns_back, &mut turned);
        let mut field = transposed(&turned, high, wide);
        run(rows_back, &mut field[..height * wide]);
        let ranges = [range(first), range(second)];
        for y in 0..height {
            for x in 0..width {
                // A mean of what was there: beyond its range is rounding.
                first[y * width + x] = field[y * wide + x].re.clamp(ranges[0][0], ranges[0][1]);
                second[y * width + x] = field[y * wide + x].im.clamp(ranges[1][0], ranges[1][1]);
            }
        }
    }
}

/// Smallest and largest value, 0 included.
fn range(values: &[f64]) -> [f64; 2] {
    values.iter().fold([0.0; 2], |[low, high], value| [value.min(low), value.max(high)])
}

fn transposed(field: &[Complex<f64>], width: usize, height: usize) -> Vec<Complex<f64>> {
    let mut out = vec![Complex::new(0.0, 0.0); field.len()];
    out.par_chunks_mut(height).enumerate().for_each(|(x, column)| {
        column.iter_mut().enumerate().for_each(|(y, to)| *to = field[y * width + x]);
    });
    out
}

/// What is needed to spread the planes of a picture.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Diffraction {
    /// Width and height of a pixel in tangents.
    pub pixel: [f64; 2],
    /// At which R, G and B are spread, nm.
    pub wavelengths_nm: [f64; 3],
    /// Per light group, for direct vision.
    pub pupils: Vec<GroupPupil>,
    /// The whole pupil, for light that was scattered.
    pub full: Pupil,
    /// `direct` holds nothing but vision: nothing scatters.
    pub only_vision: bool,
}

/// Spreads of one pupil for the three channels, or why there are none.
type Spreads = std::result::Result<[Arc<Spread>; 3], String>;

impl Diffraction {
    /// The pupil of a plane's light.
    fn pupil(&self, key: PlaneKey) -> &Pupil {
        let of_group = self.pupils.get(key.group.index()).map_or(&self.full, |of| &of.pupil);
        match key.layer {
            Layer::Forward => of_group,
            Layer::Direct if self.only_vision => of_group,
            Layer::Direct | Layer::Caustic | Layer::Secondary => &self.full,
        }
    }

    fn spreads(&self, pupil: &Pupil, size: [usize; 2]) -> Spreads {
        let one = |nm: f64| Spread::new(pupil, nm, size, self.pixel).map(Arc::new);
        let [r, g, b] = self.wavelengths_nm;
        let red = one(r)?;
        let green = if g == r { red.clone() } else { one(g)? };
        let blue = if b == r { red.clone() } else { one(b)? };
        Ok([red, green, blue])
    }

    /// Spreads planes of linear Rec.709, row-major, and says what was done.
    pub fn spread(&self, size: [usize; 2], planes: &mut BTreeMap<PlaneKey, Vec<[Light; 3]>>) -> Applied {
        let mut made: Vec<(&Pupil, Spreads)> = Vec::new();
        let mut layers = Vec::new();
        for (key, plane) in planes {
            let before = luminance(plane);
            if plane.iter().flatten().all(|light| *light == Light::default()) {
                continue;
            }
            let pupil = self.pupil(*key);
            let index = made.iter().position(|(of, _)| *of == pupil).unwrap_or_else(|| {
                made.push((pupil, self.spreads(pupil, size)));
                made.len() - 1
            });
            let (what, left) = match &made[index].1 {
                Ok(spreads) => {
                    self.spread_plane(spreads, plane);
                    let what = match pupil {
                        Pupil::Lit(_) => "the lit part of the pupil",
                        Pupil::Disc { .. } | Pupil::Point => "the whole pupil",
                    };
                    let after = luminance(plane);
                    (what.to_owned(), if before == 0.0 { 0.0 } else { 1.0 - after / before })
                }
                Err(because) => (format!("none, since {because}"), 0.0),
            };
            let group = self.pupils.get(key.group.index()).map(|of| of.group.clone()).unwrap_or_default();
            layers.push((before, Blurred { layer: key.layer.name().to_owned(), group, by: what, left }));
        }
        // Planes that only light path expressions tell apart are one layer's, spread alike.
        layers.dedup_by(|(more, part), (before, sum)| {
            let same = (&part.layer, &part.group) == (&sum.layer, &sum.group);
            if same && *before + *more != 0.0 {
                sum.left = (sum.left * *before + part.left * *more) / (*before + *more);
                *before += *more;
            }
            same
        });
        let layers = layers.into_iter().map(|(_, blurred)| blurred).collect();
        Applied {
            wavelengths_nm: self.wavelengths_nm,
            layers,
            stderr: "of the picture before it was spread, which makes the noise of near pixels alike".to_owned(),
        }
    }

    fn spread_plane(&self, spreads: &[Arc<Spread>; 3], plane: &mut [[Light; 3]]) {
        let same = |c: usize, plane: &[[Light; 3]]| {
            self.wavelengths_nm[c] == self.wavelengths_nm[0] && plane.iter().all(|light| light[c] == light[0])
        };
        let copies: [bool; 3] = std::array::from_fn(|c| c > 0 && same(c, plane));
        for c in 0..3 {
            if copies[c] {
                plane.iter_mut().for_each(|light| light[c] = light[0]);
                continue;
            }
            let lit: Vec<usize> =
                (0..COLUMNS).filter(|&index| plane.iter().any(|light| value(&light[c], index) != 0.0)).collect();
            for pair in lit.chunks(2) {
                let mut first: Vec<f64> = plane.iter().map(|light| value(&light[c], pair[0])).collect();
                let mut second = match pair {
                    [_, index] => plane.iter().map(|light| value(&light[c], *index)).collect(),
                    _ => vec![0.0; plane.len()],
                };
                spreads[c].apply(&mut first, &mut second);
                for (light, (a, b)) in plane.iter_mut().zip(first.into_iter().zip(second)) {
                    set(&mut light[c], pair[0], a);
                    if let [_, index] = pair {
                        set(&mut light[c], *index, b);
                    }
                }
            }
        }
    }
}

/// One of the numbers of a light.
fn value(light: &Light, index: usize) -> f64 {
    light.columns()[index]
}

fn set(light: &mut Light, index: usize, to: f64) {
    let mut columns = light.columns();
    columns[index] = to;
    *light = Light::of_columns(columns);
}

fn luminance(plane: &[[Light; 3]]) -> f64 {
    plane.iter().map(|light| ColourSpace::Rec709.luminance(light.map(|light| light.value))).sum()
}

#[cfg(test)]
#[path = "diffraction_tests.rs"]
mod tests;
