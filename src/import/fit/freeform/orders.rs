//! Which order: by what each point is missed by when it's left out. A term that only follows the noise of the points
//! makes that worse.

use super::model::{FREEDOMS, Free, Model, Sample};

/// How well an order does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Score {
    pub order: usize,
    /// Root mean square of the residuals of points left out, in units of their rounding.
    pub left_out: f64,
}

/// The share of the points that the unknowns may be.
const MOST: f64 = 0.6;

/// The highest order, `most` at most, for which there are points enough.
pub(super) fn highest(model: &Model, samples: &[Sample], most: usize) -> usize {
    let count = samples.iter().filter(|sample| sample.trust > 0.0).count() as f64;
    (0..=most).take_while(|order| model.basis.terms(*order) as f64 <= MOST * count).last().unwrap_or(0)
}

/// All orders up to the model's, from one triangle: the bases are nested.
pub(super) fn scores(model: &Model, samples: &[Sample]) -> Option<Vec<Score>> {
    let still = [false; FREEDOMS];
    let triangle = model.triangle(samples, &still)?;
    let ends: Vec<usize> = (0..=model.order).map(|order| model.basis.terms(order)).collect();
    let mut sums = vec![0.0; ends.len()];
    let (mut row, mut terms, mut count) = (Vec::new(), Vec::new(), 0.0f64);
    for sample in samples.iter().filter(|sample| sample.trust > 0.0) {
        let right = model.row(sample, &still, &mut row, &mut terms)?;
        let (mut value, mut leverage, mut order) = (0.0, 0.0, 0);
        triangle.shares(&mut row, |column, share, qt| {
            value += share * qt;
            leverage += share * share;
            while ends.get(order).is_some_and(|end| *end == column + 1) {
                sums[order] += missed(right - value, leverage).powi(2);
                order += 1;
            }
        });
        count += 1.0;
    }
    let score = |(order, sum): (usize, f64)| Score { order, left_out: (sum / count).sqrt() };
    Some(sums.into_iter().enumerate().map(score).collect())
}

/// The residual of a point in the fit without it (R. Cook and S. Weisberg, Residuals and Influence in Regression, 1982,
/// chapter 2): r/(1 − leverage).
pub(super) fn missed(residual: f64, leverage: f64) -> f64 {
    if leverage < 1.0 - 1e-9 { residual / (1.0 - leverage) } else { f64::INFINITY }
}

/// The residual of each sample in the model, left out and in units of its standard error; those of samples that are not
/// trusted are measured against the fit by the others.
#[derive(Debug, Clone)]
pub(super) struct Residuals {
    pub left_out: f64,
    pub each: Vec<f64>,
}

pub(super) fn residuals(model: &Model, samples: &[Sample], free: &Free) -> Option<Residuals> {
    let triangle = model.triangle(samples, free)?;
    let (mut row, mut terms, mut count, mut sum) = (Vec::new(), Vec::new(), 0.0f64, 0.0);
    let mut each = Vec::with_capacity(samples.len());
    for sample in samples {
        let trusted = sample.trust > 0.0;
        let as_if = Sample { trust: if trusted { sample.trust } else { 1.0 }, ..*sample };
        let right = model.row(&as_if, free, &mut row, &mut terms)?;
        let value: f64 = row.iter().zip(&model.heights).map(|(x, h)| x * h).sum();
        let leverage = triangle.error(&mut row).powi(2);
        let residual = right - value;
        if trusted {
            sum += missed(residual, leverage).powi(2);
            count += 1.0;
        }
        let own = if trusted { (1.0 - leverage).max(1e-3) } else { 1.0 };
        each.push(residual / own.sqrt());
    }
    Some(Residuals { left_out: (sum / count.max(1.0)).sqrt(), each })
}

/// How much worse than the best a simpler order may be: one standard error of a root mean square of `count` residuals
/// (the rule of L. Breiman et al., Classification and Regression Trees, 1984, §3.4.3).
pub(super) fn slack(samples: &[Sample]) -> f64 {
    let count = samples.iter().filter(|sample| sample.trust > 0.0).count();
    1.0 + (2.0 * count.max(1) as f64).sqrt().recip()
}

/// The simplest order that does as well as the best.
pub(super) fn best(scores: &[Score], slack: f64) -> Option<Score> {
    let least = scores.iter().map(|score| score.left_out).filter(|x| x.is_finite()).min_by(f64::total_cmp)?;
    scores.iter().copied().find(|score| score.left_out <= least * slack)
}
