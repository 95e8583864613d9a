//! Light that lamps send to the eye, followed from the lamps: a second way of looking, for what rays from the eye trace themselves.
//!
//! Paths start on the lamps. From where they start, and from every scatterer that they meet, they are aimed at a place in the pupil, and
//! count if they get there, straight or through panes. What comes over mirrors and lenses is not found so; so it is a floor: a picture
//! with less than that has lost light, one with more has not.

use super::Witness;
use super::judge::{Judged, Off, as_normal, of_student, span};
use crate::accumulate::{Components, Film};
use crate::layer::Layer;
use crate::totals::{PARTS, part_of};
use eyebox_base::double_double::Sum;
use eyebox_base::ids::GroupId;
use eyebox_base::path::Class;

/// Fewer samples don't tell how far they scatter.
pub(super) const FEWEST: u64 = 16;

/// Light of a group in a layer that rays from the eye have traced.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Sent {
    pub layer: Layer,
    pub group: GroupId,
    pub classes: Vec<Class>,
    /// `[part][as the slides are, and open]`: of each sample's mean luminance there, cd/m², the sum and that of the squares.
    sums: Vec<[[Sum; 2]; 2]>,
    samples: u64,
    /// Samples that brought light.
    lit: u64,
}

impl Sent {
    pub fn new(layer: Layer, group: GroupId, classes: Vec<Class>) -> Sent {
        Sent { layer, group, classes, sums: vec![[[Sum::ZERO; 2]; 2]; PARTS], samples: 0, lit: 0 }
    }

    /// Adds what a sample of all lamps' light brought to each part: its mean luminance, cd/m².
    pub fn add(&mut self, means: &[[f64; 2]]) {
        self.samples += 1;
        self.lit += u64::from(means.first().is_some_and(|whole| whole[1] > 0.0));
        for (sums, values) in self.sums.iter_mut().zip(means) {
            for (own, value) in sums.iter_mut().zip(values).filter(|(_, value)| **value != 0.0) {
                own[0].add(*value);
                own[1].add(value * value);
            }
        }
    }

    pub(super) fn merge(&mut self, other: &Sent) {
        self.samples = self.samples.saturating_add(other.samples);
        self.lit = self.lit.saturating_add(other.lit);
        let own = self.sums.iter_mut().flatten().flatten();
        own.zip(other.sums.iter().flatten().flatten()).for_each(|(own, more)| own.merge(*more));
    }

    pub(super) fn is_like(&self, other: &Sent) -> bool {
        (self.layer, self.group, &self.classes) == (other.layer, other.group, &other.classes)
    }

    pub(super) fn is_sound(&self) -> bool {
        self.sums.len() == PARTS && self.sums.iter().flatten().flatten().all(|sum| sum.is_finite())
    }

    /// Mean luminance of a part and its variance.
    fn mean(&self, part: usize, kind: usize) -> Option<(f64, f64)> {
        let n = self.samples as f64;
        let [sum, squares] = self.sums.get(part)?[kind].map(Sum::value);
        let mean = sum / n;
        (self.samples >= FEWEST).then(|| (mean, ((squares / n - mean * mean) / (n - 1.0)).max(0.0)))
    }
}

/// What films have of a kind of light: per part the mean luminance as the slides are and open, and the variance of the first.
struct Shown {
    means: Vec<[f64; 2]>,
    variances: Vec<f64>,
}

fn shown(witness: &Witness, films: &[&Film], (layer, group): (Layer, GroupId)) -> Shown {
    let (mut sizes, mut means, mut variances) = (vec![0.0; PARTS], vec![[0.0; 2]; PARTS], vec![0.0; PARTS]);
    let [width, height] = witness.size;
    for pixel in 0..width * height {
        for part in [0, part_of([pixel % width, pixel / width], witness.size)] {
            sizes[part] += 1.0;
        }
    }
    for film in films {
        let planes: Vec<usize> = (0..film.planes.len())
            .filter(|plane| (film.planes[*plane].layer, film.planes[*plane].group) == (layer, group))
            .collect();
        for plane in planes {
            for pixel in 0..width * height {
                let (mean, variance) = (film.mean(pixel, plane), film.variance(pixel, plane));
                for part in [0, part_of([pixel % width, pixel / width], witness.size)] {
                    means[part][0] += mean.value;
                    means[part][1] += mean.open();
                    variances[part] += variance;
                }
            }
            if !film.has_blur() && film.components != Components::Rec709 {
                continue;
            }
            // What pixels share: wavelengths, photons.
            for (part, variance) in variances.iter_mut().enumerate() {
                let own =
                    film.totals().variance(plane, part, film.passes) * of_student(film.passes as f64 - 1.0).powi(2);
                *variance = if own.is_finite() { variance.max(own) } else { *variance };
            }
        }
    }
    for ((mean, variance), size) in means.iter_mut().zip(&mut variances).zip(&sizes) {
        let size = f64::max(*size, 1.0);
        *mean = mean.map(|light| light / size);
        *variance /= size * size;
    }
    Shown { means, variances }
}

/// Holds films against the light that was sent. `limits`: standard deviations for the whole picture and for a part.
pub(super) fn judge(witness: &Witness, films: &[&Film], limits: [f64; 2]) -> Vec<Judged> {
    let judged = |sent: &Sent| {
        let shown = shown(witness, films, (sent.layer, sent.group));
        let test = |part: usize, kind: usize| {
            let (floor, variance) = sent.mean(part, kind)?;
            let run = shown.means[part][kind];
            // With the slides open a picture's pixels differ from the others by what is between two of the slide's states.
            let scale = if kind == 1 && shown.means[part][0] > 0.0 { run / shown.means[part][0] } else { 1.0 };
            let error = (variance + shown.variances[part] * scale * scale).sqrt();
            let sigmas = match (run - floor) / error {
                sigmas if sigmas.is_nan() => 0.0,
                sigmas => as_normal(sigmas.abs(), sent.samples as f64 - 1.0).copysign(sigmas),
            };
            Some((run, floor, error, sigmas))
        };
        let offs = (0..PARTS).flat_map(|part| [(part, 0), (part, 1)]).filter_map(|(part, kind)| {
            let (run, witness_mean, error, sigmas) = test(part, kind)?;
            let [columns, rows] = span(part, witness.size);
            let off = Off { columns, rows, open: kind == 1, run, witness: witness_mean, error, sigmas };
            (sigmas < -limits[usize::from(part > 0)]).then_some(off)
        });
        let worst = |a: Off, b: Off| if b.sigmas < a.sigmas { b } else { a };
        let ratio = |kind: usize| {
            test(0, kind).filter(|(_, floor, ..)| *floor > 0.0).map(|(run, floor, error, _)| {
                let ratio = run / floor;
                [ratio, error / floor * ratio.max(1.0)]
            })
        };
        Judged {
            layer: sent.layer,
            group: sent.group,
            classes: sent.classes.clone(),
            from_lamps: true,
            looks: sent.samples,
            lit: sent.lit,
            ratio: ratio(0),
            open: ratio(1),
            off: offs.reduce(worst),
        }
    };
    witness.sent.iter().map(judged).collect()
}
