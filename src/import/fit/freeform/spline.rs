//! The last resort: a height field of uniform cubic B-splines, its grid as fine as the points ask for. Where few points
//! lie, third differences of the coefficients are held small (P. Eilers and B. Marx, Statistical Science 11, 1996), by as
//! much as leaves the points that are left out best foretold.

use super::basis::{Basis, Knots};
use super::model::{Free, Model, Sample};
use super::orders::{missed, residuals};
use super::triangle::Triangle;
use super::walk::walk;
use super::{STILL, part};

/// Spans along the longer side, on the way to the grid.
const SPANS: [usize; 12] = [1, 2, 3, 4, 6, 8, 11, 16, 22, 32, 45, 64];
/// Weight of a third difference against a point that misses by its rounding, from holding nothing but what no point
/// says to holding all but parabolas.
const HOLDS: [f64; 6] = [1e-7, 1e-5, 1e-3, 1e-2, 1e-1, 1.0];
const LOOSE: f64 = 1e-5;
/// Grids of so many coefficients at most, that miss by so many times more at most, are tilted and moved.
const SEATED: usize = 200;
const NEAR: f64 = 30.0;
const PLACED: Free = [true, true, true, true, false];
/// Coefficients at most, and the share of the points that they may be.
const MOST: usize = 700;
const SHARE: f64 = 0.8;
/// So many points are left out at most, one at a time.
const LEFT_OUT: usize = 400;
/// A grid that misses by no more than this times the rounding of the points is the surface's own.
const ROUNDED: f64 = 1.2;

/// A grid solved for the samples, and how well it foretells them.
pub(super) struct Splined {
    pub model: Model,
    pub left_out: f64,
    pub free: Free,
    /// With what holds the coefficients, if anything does.
    pub held: Option<Triangle>,
}

/// Samples along the longer side, so that the rows' bands are short.
struct Search<'a> {
    start: &'a Model,
    half: [f64; 2],
    samples: Vec<Sample>,
}

/// The best of all grids over `half`; the simplest that does as well as the best within `slack`.
pub(super) fn best(start: &Model, half: [f64; 2], samples: &[Sample], slack: f64) -> Option<Splined> {
    let mut samples = samples.to_vec();
    samples.retain(|sample| sample.trust > 0.0);
    samples.sort_by(|a, b| start.frame.local(a.p).x.total_cmp(&start.frame.local(b.p).x));
    let search = Search { start, half, samples };
    let mut found = search.coarse(slack)?;
    // A grid that divides the face as the surface's own knots do stands out, if its neighbours don't.
    for axis in [0, 1, 0, 1] {
        // A fine grid has no neighbours that stand out.
        if found.left_out <= ROUNDED || found.model.terms() > 2 * SEATED {
            break;
        }
        let spans = search.spans(&found);
        let around = spans[axis].div_ceil(2)..=2 * spans[axis];
        let others = around.filter(|n| *n != spans[axis]).filter_map(|n| {
            let mut spans = spans;
            spans[axis] = n;
            search.solved(spans, &[LOOSE])
        });
        let other = others.min_by(|a, b| a.left_out.total_cmp(&b.left_out));
        if let Some(other) = other.filter(|other| other.left_out * slack < found.left_out) {
            found = other;
        }
    }
    // Every second or third of its knots may do as well.
    for axis in [0, 1] {
        let spans = search.spans(&found);
        let coarser = (1..spans[axis]).filter(|n| spans[axis].is_multiple_of(*n)).filter_map(|n| {
            let mut spans = spans;
            spans[axis] = n;
            search.solved(spans, &[LOOSE])
        });
        if let Some(coarser) = coarser.into_iter().find(|coarser| coarser.left_out <= found.left_out * slack) {
            found = coarser;
        }
    }
    if let Some(seated) = search.seated(&found, slack) {
        return Some(seated);
    }
    let spans = search.spans(&found);
    let finer = spans.map(|n| n + n.div_ceil(2));
    let held = [spans, finer].into_iter().filter_map(|spans| search.solved(spans, &HOLDS));
    let held = held.min_by(|a, b| a.left_out.total_cmp(&b.left_out));
    Some(held.filter(|held| held.left_out * slack < found.left_out).unwrap_or(found))
}

impl Search<'_> {
    /// The best of grids of about square spans.
    fn coarse(&self, slack: f64) -> Option<Splined> {
        let mut found: Vec<Splined> = Vec::new();
        let mut worse = 0;
        for long in SPANS {
            let short = (long as f64 * self.half[1] / self.half[0]).round().max(1.0) as usize;
            let Some(one) = self.solved([long, short], &[LOOSE]) else { break };
            let least = found.iter().map(|found| found.left_out).fold(f64::INFINITY, f64::min);
            // Finer grids only follow the noise.
            worse = if one.left_out * slack < least { 0 } else { worse + 1 };
            found.push(one);
            if worse >= 3 {
                break;
            }
        }
        let least = found.iter().map(|found| found.left_out).fold(f64::INFINITY, f64::min);
        found.into_iter().find(|found| found.left_out <= least * slack)
    }

    /// Knots that are the surface's own are so in its own frame only: the simplest of the grids of some of the knots, and
    /// of all, that with the best tilt and place foretells as well as all do in the face's frame; None where that wins
    /// nothing.
    fn seated(&self, found: &Splined, slack: f64) -> Option<Splined> {
        let spans = self.spans(found);
        let divisors = |n: usize| (1..=n).filter(move |k| n.is_multiple_of(*k));
        let pairs = divisors(spans[0]).flat_map(|a| divisors(spans[1]).map(move |b| [a, b]));
        let mut grids: Vec<[usize; 2]> = pairs.filter(|[a, b]| (a + 3) * (b + 3) <= SEATED).collect();
        grids.sort_by_key(|[a, b]| (a + 3) * (b + 3));
        let near = |grid: &[usize; 2]| self.solved(*grid, &[LOOSE]).filter(|one| one.left_out <= NEAR * found.left_out);
        grids.iter().filter_map(near).find_map(|start| {
            let model = walk(&self.samples, &start.model, &PLACED)?;
            let left_out = residuals(&model, &self.samples, &PLACED)?.left_out;
            let all = model.terms() == found.model.terms();
            let well = if all { left_out * slack < found.left_out } else { left_out <= found.left_out * slack };
            well.then_some(Splined { model, left_out, free: PLACED, held: None })
        })
    }

    fn spans(&self, found: &Splined) -> [usize; 2] {
        match found.model.basis {
            Basis::Spline(knots) => knots.spans,
            Basis::Poly { .. } | Basis::Even { .. } => [1, 1],
        }
    }

    /// The grid with the best of the holds; None for more coefficients than the points can say.
    fn solved(&self, spans: [usize; 2], holds: &[f64]) -> Option<Splined> {
        let knots = Knots { half: self.half, spans };
        if knots.terms() > MOST || knots.terms() as f64 > SHARE * self.samples.len() as f64 {
            return None;
        }
        let model = Model { basis: Basis::Spline(knots), order: 0, heights: Vec::new(), ..self.start.clone() };
        let mut triangle = Triangle::new(knots.terms());
        let (mut row, mut terms) = (Vec::new(), Vec::new());
        let mut mean = 0.0;
        for sample in &self.samples {
            let right = model.row(sample, &STILL, &mut row, &mut terms)?;
            mean += row.iter().map(|x| x * x).sum::<f64>();
            triangle.add(&mut row, right);
        }
        let mut best: Option<Splined> = None;
        for hold in holds {
            let mut triangle = triangle.clone();
            // As if each coefficient's share of the points held.
            held(&mut triangle, &knots, hold * (mean / knots.terms() as f64).sqrt());
            let heights = triangle.solve(knots.terms());
            let (mut sum, mut count) = (0.0, 0.0f64);
            let stride = self.samples.len().div_ceil(LEFT_OUT).max(1);
            for sample in part(&self.samples, stride) {
                let right = model.row(sample, &STILL, &mut row, &mut terms)?;
                let value: f64 = row.iter().zip(&heights).map(|(x, h)| x * h).sum();
                sum += missed(right - value, triangle.error(&mut row).powi(2)).powi(2);
                count += 1.0;
            }
            let left_out = (sum / count.max(1.0)).sqrt();
            if left_out.is_finite() && best.as_ref().is_none_or(|best| left_out < best.left_out) {
                best = Some(Splined {
                    model: Model { heights, ..model.clone() },
                    left_out,
                    free: STILL,
                    held: Some(triangle),
                });
            }
        }
        best
    }
}

/// Rows that pull the third differences of the coefficients to zero.
fn held(triangle: &mut Triangle, knots: &Knots, weight: f64) {
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
}
