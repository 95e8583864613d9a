//! The frame and base in which an order does best: Gauss–Newton over tilt, shift and curvature, the heights following
//! (variable projection: G. Golub and V. Pereyra, SIAM J. Numer. Anal. 10, 1973), damped as Levenberg–Marquardt.

use super::model::{FREEDOMS, Free, Model, Sample};
use super::triangle::Triangle;

/// Steps at most, and the fall of the cost below which there is nothing more to win.
const STEPS: usize = 40;
const NOTHING: f64 = 1e-6;
/// The plausible range of each freedom, for points scaled to size one: a freedom that the points don't tell to a tenth of
/// its range is held.
const RANGE: [f64; FREEDOMS] = [0.5, 0.5, 1.0, 1.0, 1.0];
const TOLD: f64 = 0.1;

/// The model at the nearest minimum, its heights solved; None where the start has no cost.
pub(super) fn walk(samples: &[Sample], start: &Model, free: &Free) -> Option<Model> {
    let mut now = start.solved(samples)?;
    let mut cost = now.cost(samples);
    if !cost.is_finite() {
        return None;
    }
    let mut damping = 1e-3;
    for _ in 0..STEPS {
        let corner = now.triangle(samples, free)?.corner(now.terms());
        let mut better = None;
        while better.is_none() && damping < 1e6 {
            let step = step(&corner, free, damping, cost.max(1.0).sqrt());
            let trial = now.moved(&step).solved(samples);
            let trial = trial.map(|trial| (trial.cost(samples), trial)).filter(|(trial, _)| *trial < cost);
            damping = if trial.is_some() { damping * 0.1 } else { damping * 10.0 };
            better = trial;
        }
        let Some((fallen, model)) = better else { break };
        let done = fallen > cost * (1.0 - NOTHING);
        (now, cost) = (model, fallen);
        if done {
            break;
        }
    }
    Some(now)
}

/// The step that the corner asks for, columns brought to unit length and pulled to zero by `damping`; `noise` is what a
/// column must outweigh over the range of its freedom.
fn step(corner: &[(Vec<f64>, f64)], free: &Free, damping: f64, noise: f64) -> [f64; FREEDOMS] {
    let moving: Vec<usize> = (0..FREEDOMS).filter(|k| free[*k]).collect();
    let length = |j: usize| corner.iter().map(|(row, _)| row[j] * row[j]).sum::<f64>().sqrt();
    let lengths: Vec<f64> = (0..moving.len()).map(length).collect();
    let told = |j: usize| lengths[j] * RANGE[moving[j]] * TOLD > noise;
    let mut triangle = Triangle::new(moving.len());
    let scaled = |row: &[f64]| -> Vec<f64> {
        row.iter().enumerate().map(|(j, x)| if told(j) { x / lengths[j] } else { 0.0 }).collect()
    };
    for (row, right) in corner {
        triangle.add(&mut scaled(row), *right);
    }
    for j in (0..moving.len()).filter(|j| told(*j)) {
        let mut pull = vec![0.0; moving.len()];
        pull[j] = damping.sqrt();
        triangle.add(&mut pull, 0.0);
    }
    let mut out = [0.0; FREEDOMS];
    for (j, x) in triangle.solve(moving.len()).into_iter().enumerate().filter(|(j, _)| told(*j)) {
        out[moving[j]] = (x / lengths[j]).clamp(-0.3 * RANGE[moving[j]], 0.3 * RANGE[moving[j]]);
    }
    out
}
