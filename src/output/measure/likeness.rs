//! How like itself a picture is when it is shifted: the autocorrelation of its edges, taken apart by the way they face. A shift
//! along an edge doesn't move it, so edges count only as far as a shift moves them across themselves.

use glam::DVec2;
use rustfft::num_complex::Complex;
use rustfft::{FftDirection, FftPlannerScalar};

/// Edges are smoothed by a Gaussian of this many pixels: noise is shared by all frequencies, edges are not.
const SMOOTH: f64 = 1.0;
/// Reach of that Gaussian, pixels.
const REACH: usize = 4;
/// Moved by less than this many pixels a smoothed edge is still itself (its autocorrelation is e^(−τ²/4)), and an echo could
/// not be taken away pixel by pixel: its source has to come before it, and the two pixels about that.
pub const NEAREST: f64 = 4.5;
/// Ways that edges face, over half a turn.
const WAYS: usize = 8;
/// Share of all edges below which those that a shift moves say nothing of it.
const FEW: f64 = 0.01;

/// Autocorrelations of the edges that face each way, and the edges.
pub struct Likeness {
    /// Shifts to the right and down, from −`reach` to `reach`, row by row.
    alike: [Vec<f32>; WAYS],
    whole: [f64; WAYS],
    reach: [i64; 2],
    edges: Vec<DVec2>,
    inner: [usize; 2],
}

/// The direction that the edges of a way face.
fn facing(way: usize) -> DVec2 {
    DVec2::from_angle(std::f64::consts::PI * way as f64 / WAYS as f64)
}

impl Likeness {
    /// None for a picture without edges.
    pub fn of(values: &[f64], size: [usize; 2]) -> Option<Likeness> {
        let [width, height] = size;
        let whole = values.len() == width.checked_mul(height)? && values.iter().all(|v| v.is_finite());
        if !whole || width < 8 || height < 8 {
            return None;
        }
        let inner = [width - 1, height - 1];
        let edges = derivative(&smooth(values, size), width, inner);
        let reach = [width / 2, height / 2].map(|n| n as i64);
        let mut like = Likeness { alike: Default::default(), whole: [0.0; WAYS], reach, edges, inner };
        for pair in 0..WAYS / 2 {
            like.correlate([2 * pair, 2 * pair + 1]);
        }
        let energy: f64 = like.whole.iter().sum();
        let largest = values.iter().fold(0.0f64, |most, value| most.max(value.abs()));
        // What is left of rounding is no edge.
        (energy > f64::EPSILON * largest * largest).then_some(like)
    }

    /// Autocorrelations of the edges that face two ways: two real pictures by one complex transform.
    fn correlate(&mut self, ways: [usize; 2]) {
        // Twice the size, so that nothing wraps around.
        let size = self.inner.map(|n| 2 * (n + 1));
        let mut field = vec![Complex::new(0.0, 0.0); size[0] * size[1]];
        for (i, edge) in self.edges.iter().enumerate() {
            let [re, im] = ways.map(|way| facing_part(*edge, way));
            field[i / self.inner[0] * size[0] + i % self.inner[0]] = Complex::new(re, im);
        }
        transform(&mut field, size, FftDirection::Forward);
        let mut powers = vec![Complex::new(0.0, 0.0); field.len()];
        for v in 0..size[1] {
            for u in 0..size[0] {
                let (here, mirrored) = (v * size[0] + u, (size[1] - v) % size[1] * size[0] + (size[0] - u) % size[0]);
                let (f, g) = (field[here], field[mirrored].conj());
                powers[here] = Complex::new((f + g).norm_sqr(), (f - g).norm_sqr()) * 0.25;
            }
        }
        drop(field);
        transform(&mut powers, size, FftDirection::Inverse);
        let scale = 1.0 / (size[0] * size[1]) as f64;
        let at = |x: i64, y: i64| {
            powers[y.rem_euclid(size[1] as i64) as usize * size[0] + x.rem_euclid(size[0] as i64) as usize] * scale
        };
        let [w, h] = self.reach;
        for y in -h..=h {
            for x in -w..=w {
                let value = at(x, y);
                self.alike[ways[0]].push(value.re as f32);
                self.alike[ways[1]].push(value.im as f32);
            }
        }
        let whole = at(0, 0);
        (self.whole[ways[0]], self.whole[ways[1]]) = (whole.re, whole.im);
    }

    /// How much the edges that face each way count for a shift: those that it moves, over the energy of all that count. None
    /// where there are few.
    fn weights(&self, shift: DVec2) -> Option<[f64; WAYS]> {
        let mut weights = [0.0; WAYS];
        for (way, weight) in weights.iter_mut().enumerate() {
            *weight = (facing(way).dot(shift).abs() - NEAREST + 0.5).clamp(0.0, 1.0);
        }
        let energy = |weights: &[f64; WAYS]| weights.iter().zip(self.whole).map(|(a, b)| a * b).sum::<f64>();
        let (counted, all) = (energy(&weights), energy(&[1.0; WAYS]));
        (counted > FEW * all).then(|| weights.map(|weight| weight / counted))
    }

    fn on_grid(&self, [x, y]: [i64; 2], weights: &[f64; WAYS]) -> f64 {
        let [w, h] = self.reach;
        if x.abs() > w || y.abs() > h {
            return 0.0;
        }
        if [x, y] == [0, 0] {
            return weights.iter().zip(self.whole).map(|(weight, whole)| weight * whole).sum();
        }
        let at = ((y + h) * (2 * w + 1) + x + w) as usize;
        weights
            .iter()
            .zip(&self.alike)
            .filter(|(weight, _)| **weight > 0.0)
            .map(|(weight, alike)| weight * f64::from(alike[at]))
            .sum()
    }

    /// The shifts (to the right, or straight down) at which the picture is more like itself than at those about them, at
    /// most so many, best first.
    pub fn peaks(&self, most: usize) -> Vec<DVec2> {
        let [w, h] = self.reach;
        let mut found: Vec<(f64, DVec2)> = Vec::new();
        for y in -h..=h {
            for x in 0..=w {
                let shift = DVec2::new(x as f64, y as f64);
                if shift.length() < NEAREST || x == 0 && y < 0 {
                    continue;
                }
                let Some(weights) = self.weights(shift) else { continue };
                let here = self.on_grid([x, y], &weights);
                let around = || (-1..=1).flat_map(|j| (-1..=1).map(move |i| [x + i, y + j])).filter(|at| *at != [x, y]);
                if here > 0.0 && around().all(|at| self.on_grid(at, &weights) <= here) {
                    found.push((here, shift));
                }
            }
        }
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        found.into_iter().take(most).map(|(_, shift)| shift).collect()
    }
}

/// Derivatives to the right and down at the corners between four pixels, both at the same places. What the frame cuts is no
/// edge.
fn derivative(values: &[f64], width: usize, inner: [usize; 2]) -> Vec<DVec2> {
    let edge = |i: usize| {
        let at = |x: usize, y: usize| values[(i / inner[0] + y) * width + i % inner[0] + x];
        let (a, b, c, d) = (at(0, 0), at(1, 0), at(0, 1), at(1, 1));
        0.5 * DVec2::new(b + d - a - c, c + d - a - b)
    };
    (0..inner[0] * inner[1]).map(edge).collect()
}

/// Smooths; beyond the frame the picture goes on as it is at its rim.
pub fn smooth(values: &[f64], [w, h]: [usize; 2]) -> Vec<f64> {
    let weight = |i: usize| (-0.5 * ((i as f64 - REACH as f64) / SMOOTH).powi(2)).exp();
    let kernel: Vec<f64> = (0..=2 * REACH).map(weight).collect();
    let sum: f64 = kernel.iter().sum();
    let pass = |values: &[f64], along: bool| -> Vec<f64> {
        let at = |i: usize| {
            let (x, y) = (i % w, i / w);
            let (place, size) = if along { (x, w) } else { (y, h) };
            let term = |(k, weight): (usize, &f64)| {
                let other = (place + k).saturating_sub(REACH).min(size - 1);
                weight / sum * values[if along { y * w + other } else { other * w + x }]
            };
            kernel.iter().enumerate().map(term).sum()
        };
        (0..w * h).map(at).collect()
    };
    pass(&pass(values, true), false)
}

/// What of an edge faces a way: between the two ways next to it by its angle, with the sign of the half turn.
fn facing_part(edge: DVec2, way: usize) -> f64 {
    let turn = edge.to_angle() / std::f64::consts::PI * WAYS as f64 - way as f64;
    // Half turns off: the edge faces the other way.
    let halves = (turn / WAYS as f64).round();
    let off = (turn - halves * WAYS as f64).abs();
    let sign = if halves as i64 % 2 == 0 { 1.0 } else { -1.0 };
    sign * (1.0 - off).max(0.0).sqrt() * edge.length()
}

fn transform(field: &mut Vec<Complex<f64>>, [width, height]: [usize; 2], direction: FftDirection) {
    let mut planner = FftPlannerScalar::new();
    planner.plan_fft(width, direction).process(field);
    let mut turned: Vec<Complex<f64>> = (0..width * height).map(|i| field[(i % height) * width + i / height]).collect();
    planner.plan_fft(height, direction).process(&mut turned);
    *field = (0..width * height).map(|i| turned[(i % width) * height + i / width]).collect();
}
