//! The light that microfacets lose after one bounce, handed back: tables of how much there is, and a lobe that brings it.
//!
//! After Kulla and Conty, "Revisiting Physically Based Shading at Imageworks", SIGGRAPH 2017, with both sides of the face:
//! with m the share that one bounce under a cosine loses and M its mean over 2μ dμ, per side,
//! reflected a₁ m₁(μi) m₁(μo)/(π M₁), through (1 − a₁) m₁(μi) m₂(μo)/(π M₂). Each integrates to its part of m₁(μi), so that
//! nothing is lost; reciprocity, value(1→2)/n₂² = value(2→1)/n₁², asks that (1 − a₁) M₁ n₁² = (1 − a₂) M₂ n₂². That product
//! is taken as the smaller side's M n² times the part of one bounce that goes through there.

use super::Sides;
use super::rough::Facets;
use crate::cdf::Cdf;
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// What a roughness loses, for the ratios of indices that a scene has.
#[derive(Debug, Clone, PartialEq)]
pub struct Lost {
    facets: Facets,
    /// Rising ln(beyond/here), with the rows of both directions.
    rows: Vec<(f64, [Row; 2])>,
    /// ln(1 + 1/α): cosines are α(exp(x²·scale) − 1), x from 0 to 1, dense where m changes.
    scale: f64,
    /// μ² at each point.
    squares: Vec<f64>,
}

/// One ratio of indices, at evenly spaced x.
#[derive(Debug, Clone, PartialEq)]
struct Row {
    /// m.
    lost: Vec<f64>,
    /// M.
    mean: f64,
    /// Mean share of one bounce that goes through.
    through: f64,
    /// How much of M lies between two points: directions are drawn by it, evenly in μ² within a step.
    steps: Option<Cdf>,
}

/// What holds at the indices of a ray.
pub(super) struct Split {
    /// Place between two rows.
    row: usize,
    part: f64,
    /// Index into each row's pair: the side of the ray.
    side: usize,
    means: [f64; 2],
    /// a₁
    reflected: f64,
}

impl Lost {
    const STEPS: usize = 128;

    /// For ratios (beyond/here, either way up) between the bounds of `ratios`. `alpha` from 1e-4 to 1.
    pub fn new(alpha: f64, ratios: &[[f64; 2]]) -> Lost {
        let facets = Facets { alpha };
        let scale = f64::ln_1p(1.0 / alpha);
        let mut lost = Lost { facets, rows: Vec::new(), scale, squares: Vec::new() };
        lost.squares =
            (0..=Self::STEPS).map(|step| lost.cosine(step as f64 / Self::STEPS as f64).min(1.0).powi(2)).collect();
        let rows = nodes(ratios).into_par_iter().map(|ln| (ln, [lost.row(ln), lost.row(-ln)])).collect();
        Lost { rows, ..lost }
    }

    pub(super) fn facets(&self) -> Facets {
        self.facets
    }

    fn cosine(&self, x: f64) -> f64 {
        self.facets.alpha * f64::exp_m1(x * x * self.scale)
    }

    /// Between which μ² a step lies.
    fn within(&self, step: usize) -> [f64; 2] {
        [step, step + 1].map(|step| self.squares.get(step).copied().unwrap_or(1.0))
    }

    fn row(&self, ln_ratio: f64) -> Row {
        let n = Sides::between(1.0, ln_ratio.exp());
        let at = |step: usize| {
            // Light along the face is the limit of light that nearly is.
            let x = (step as f64).max(1e-3) / Self::STEPS as f64;
            self.facets.albedo(self.cosine(x).min(1.0), n)
        };
        let shares: Vec<[f64; 2]> = (0..=Self::STEPS).into_par_iter().map(at).collect();
        let lost: Vec<f64> = shares.iter().map(|[r, t]| (1.0 - r - t).max(0.0)).collect();
        let through: Vec<f64> = shares.iter().map(|[r, t]| t / (r + t)).collect();
        let widths = self.squares.windows(2).map(|ends| ends[1] - ends[0]);
        let weights = lost.windows(2).zip(widths).map(|(m, width)| 0.5 * (m[0] + m[1]) * width);
        let steps = Cdf::new(weights.collect::<Vec<_>>());
        Row { mean: self.mean(&lost), through: self.mean(&through), steps, lost }
    }

    /// ∫ y 2μ dμ of a line through the table's points: by Simpson's rule, which μ is smooth enough for within a step.
    fn mean(&self, table: &[f64]) -> f64 {
        const FINE: usize = 8;
        let count = Self::STEPS * FINE;
        let at = |k: usize| {
            let x = k as f64 / count as f64;
            let mu = self.cosine(x);
            interpolate(table, x) * 2.0 * mu * 2.0 * x * self.scale * (mu + self.facets.alpha)
        };
        let sum: f64 = (0..=count)
            .map(|k| at(k) * if k == 0 || k == count { 1.0 } else { if k.is_multiple_of(2) { 2.0 } else { 4.0 } })
            .sum();
        sum / (3 * count) as f64
    }

    pub(super) fn split(&self, n: Sides<'_>) -> Split {
        let ln = (n.beyond / n.here).ln();
        let (ln, side) = if ln < 0.0 { (-ln, 1) } else { (ln, 0) };
        let above = self.rows.partition_point(|(x, _)| *x < ln).clamp(1, self.rows.len().max(2) - 1);
        let row = above - 1;
        let part = match (self.rows.get(row), self.rows.get(above)) {
            (Some((a, _)), Some((b, _))) if a < b => ((ln - a) / (b - a)).clamp(0.0, 1.0),
            (Some(_) | None, _) => 0.0,
        };
        let of = |value: &dyn Fn(&Row) -> f64, side: usize| -> f64 {
            let at = |row: usize| self.rows.get(row).map_or(0.0, |(_, pair)| value(&pair[side]));
            if part == 0.0 { at(row) } else { at(row) + part * (at(above) - at(row)) }
        };
        let means = [of(&|row| row.mean, side), of(&|row| row.mean, 1 - side)];
        let through = [of(&|row| row.through, side), of(&|row| row.through, 1 - side)];
        let [here, beyond] = [means[0] * n.here * n.here, means[1] * n.beyond * n.beyond];
        let product = (through[0] * here).min(through[1] * beyond);
        let reflected = if here > 0.0 { 1.0 - product / here } else { 1.0 };
        Split { row, part, side, means, reflected }
    }

    /// m of one side at a cosine: the share that one bounce loses.
    pub(super) fn at(&self, split: &Split, behind: bool, cos: f64) -> f64 {
        let x = (f64::ln_1p(cos.abs() / self.facets.alpha) / self.scale).sqrt().min(1.0);
        let side = if behind { 1 - split.side } else { split.side };
        let of = |row: usize| self.rows.get(row).map_or(0.0, |(_, pair)| interpolate(&pair[side].lost, x));
        let low = of(split.row);
        if split.part == 0.0 { low } else { low + split.part * (of(split.row + 1) - low) }
    }

    /// The value of the lobe, 1/sr, where one bounce loses the share `arriving`; `cos_out` > 0 reflected, < 0 transmitted.
    pub(super) fn eval(&self, split: &Split, arriving: f64, cos_out: f64) -> f64 {
        let behind = cos_out < 0.0;
        let mean = split.means[usize::from(behind)];
        if mean.is_nan() || mean <= 0.0 {
            return 0.0;
        }
        split.share(behind) * arriving * self.at(split, behind, cos_out) / (PI * mean)
    }

    /// What directions are drawn by on a side: the nearer of two rows.
    fn steps(&self, split: &Split, behind: bool) -> Option<&Cdf> {
        let row = if split.part > 0.5 { split.row + 1 } else { split.row };
        let side = if behind { 1 - split.side } else { split.side };
        self.rows.get(row).and_then(|(_, pair)| pair[side].steps.as_ref())
    }

    /// Density with which [`Lost::sample`] chooses a direction with this cosine, 1/sr.
    pub(super) fn pdf(&self, split: &Split, cos_out: f64) -> f64 {
        let behind = cos_out < 0.0;
        let Some(steps) = self.steps(split, behind) else { return 0.0 };
        let mu = cos_out.abs();
        let x = (f64::ln_1p(mu / self.facets.alpha) / self.scale).sqrt().min(1.0);
        let step = ((x * Self::STEPS as f64) as usize).min(Self::STEPS - 1);
        let [low, high] = self.within(step);
        split.share(behind) * steps.probability(step) / (high - low) * mu / PI
    }

    /// A direction of the lobe; reflected for `side` below the part that is.
    pub(super) fn sample(&self, split: &Split, side: f64, [a, b]: [f64; 2]) -> Option<DVec3> {
        let through = side >= split.reflected;
        let (step, rest) = self.steps(split, through)?.sample(a);
        let [low, high] = self.within(step);
        let square = low + rest * (high - low);
        let (sin, cos) = (TAU * b).sin_cos();
        let radius = (1.0 - square).max(0.0).sqrt();
        let up = square.sqrt();
        Some(DVec3::new(radius * cos, radius * sin, if through { -up } else { up }))
    }
}

impl Split {
    /// What is reflected of the lobe, or goes through.
    fn share(&self, behind: bool) -> f64 {
        if behind { 1.0 - self.reflected } else { self.reflected }
    }
}

fn interpolate(table: &[f64], x: f64) -> f64 {
    let place = x * (table.len() - 1) as f64;
    let below = (place as usize).min(table.len() - 2);
    let part = place - below as f64;
    table[below] + part * (table[below + 1] - table[below])
}

/// Where tables are made: at the ends of the ranges and so densely within them that a line between two is good to 1e-5;
/// as logarithms, of ratios above 1.
fn nodes(ratios: &[[f64; 2]]) -> Vec<f64> {
    const STEP: f64 = 0.02;
    const MOST: usize = 48;
    let usable = |range: &&[f64; 2]| range.iter().all(|ratio| *ratio > 0.0 && ratio.is_finite());
    let mut all: Vec<f64> = Vec::new();
    let (mut least, mut most) = (f64::INFINITY, 0f64);
    for range in ratios.iter().filter(usable) {
        let [a, b] = range.map(|ratio| ratio.ln());
        let high = a.abs().max(b.abs());
        let low = if a * b <= 0.0 { 0.0 } else { a.abs().min(b.abs()) };
        (least, most) = (least.min(low), most.max(high));
        let steps = ((high - low) / STEP).ceil().min(2.0 * MOST as f64) as usize;
        all.extend((0..=steps).map(|k| low + (high - low) * (k as f64 / steps.max(1) as f64)));
    }
    all.sort_by(f64::total_cmp);
    all.dedup();
    if all.len() > MOST {
        return (0..=MOST).map(|k| least + (most - least) * (k as f64 / MOST as f64)).collect();
    }
    if all.is_empty() { vec![0.0] } else { all }
}
