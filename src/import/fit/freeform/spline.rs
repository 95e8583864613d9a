//! The last resort: a height field of uniform cubic B-splines, its grid as fine as the points ask for. Where few points
//! lie, third differences of the coefficients are held small (P. Eilers and B. Marx, Statistical Science 11, 1996), by as
//! much as leaves the points that are left out best foretold.

use super::basis::{Basis, Knots};
use super::model::{FREEDOMS, Model, Sample};
use super::orders::missed;
use super::triangle::Triangle;

/// Spans along the longer side.
const SPANS: [usize; 12] = [1, 2, 3, 4, 6, 8, 11, 16, 22, 32, 45, 64];
/// Weight of a third difference against a point that misses by its rounding, from holding nothing but what no point
/// says to holding all but parabolas.
const HOLDS: [f64; 6] = [1e-7, 1e-5, 1e-3, 1e-2, 1e-1, 1.0];
/// Coefficients at most, and the share of the points that they may be.
const MOST: usize = 1024;
const SHARE: f64 = 0.8;

/// A grid solved for the samples, and how well it foretells them.
pub(super) struct Splined {
    pub model: Model,
    pub left_out: f64,
    pub triangle: Triangle,
}

/// The best of all grids over `half`; the simplest that does as well as the best within `slack`.
pub(super) fn best(start: &Model, half: [f64; 2], samples: &[Sample], slack: f64) -> Option<Splined> {
    // Along the longer side, so that the rows' bands are short.
    let mut sorted = samples.to_vec();
    sorted.sort_by(|a, b| start.frame.local(a.p).x.total_cmp(&start.frame.local(b.p).x));
    let trusted = sorted.iter().filter(|sample| sample.trust > 0.0).count() as f64;
    let mut found: Vec<Splined> = Vec::new();
    let mut worse = 0;
    for long in SPANS {
        let short = (long as f64 * half[1] / half[0]).round().max(1.0) as usize;
        let knots = Knots { half, spans: [long, short] };
        if knots.terms() > MOST || knots.terms() as f64 > SHARE * trusted {
            break;
        }
        let tries = HOLDS.into_iter().filter_map(|hold| solved(start, knots, &sorted, hold));
        let Some(one) = tries.min_by(|a, b| a.left_out.total_cmp(&b.left_out)) else { continue };
        let least = found.iter().map(|found| found.left_out).fold(f64::INFINITY, f64::min);
        // Finer grids only follow the noise.
        worse = if one.left_out < least / slack { 0 } else { worse + 1 };
        found.push(one);
        if worse >= 3 {
            break;
        }
    }
    let least = found.iter().map(|found| found.left_out).fold(f64::INFINITY, f64::min);
    found.into_iter().find(|found| found.left_out <= least * slack)
}

fn solved(start: &Model, knots: Knots, samples: &[Sample], hold: f64) -> Option<Splined> {
    let still = [false; FREEDOMS];
    let model = Model { basis: Basis::Spline(knots), order: 0, heights: Vec::new(), ..start.clone() };
    let mut triangle = Triangle::new(knots.terms());
    let (mut row, mut terms) = (Vec::new(), Vec::new());
    let mut mean = 0.0;
    for sample in samples.iter().filter(|sample| sample.trust > 0.0) {
        let right = model.row(sample, &still, &mut row, &mut terms)?;
        mean += row.iter().map(|x| x * x).sum::<f64>();
        triangle.add(&mut row, right);
    }
    // As if each coefficient's share of the points held.
    let weight = hold * (mean / knots.terms() as f64).sqrt();
    let [along, across] = knots.spans.map(|spans| spans + 3);
    for i in 0..along {
        for j in 0..across {
            for (step, fits) in [(across, i + 3 < along), (1, j + 3 < across)] {
                if fits {
                    let first = i * across + j;
                    let mut row = vec![0.0; knots.terms()];
                    for (k, d) in [-1.0, 3.0, -3.0, 1.0].into_iter().enumerate() {
                        row[first + k * step] = weight * d;
                    }
                    triangle.add(&mut row, 0.0);
                }
            }
        }
    }
    let heights = triangle.solve(knots.terms());
    let (mut sum, mut count) = (0.0, 0.0f64);
    for sample in samples.iter().filter(|sample| sample.trust > 0.0) {
        let right = model.row(sample, &still, &mut row, &mut terms)?;
        let value: f64 = row.iter().zip(&heights).map(|(x, h)| x * h).sum();
        sum += missed(right - value, triangle.error(&mut row).powi(2)).powi(2);
        count += 1.0;
    }
    let left_out = (sum / count.max(1.0)).sqrt();
    left_out.is_finite().then_some(Splined { model: Model { heights, ..model }, left_out, triangle })
}
