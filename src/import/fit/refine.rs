//! Orthogonal least squares: Levenberg–Marquardt over the freedoms of a conic (Nocedal & Wright, Numerical
//! Optimization, §10.3).

use super::conic::{CURVE, Conic, RISE, SHAPE, SLIDE_U, TURN_U};
use super::linalg::Triangle;
use glam::DVec3;

/// Which of the seven parameters move; the eighth column is the residual.
pub(super) const SPHERE: [bool; 8] = free(&[TURN_U, TURN_U + 1, RISE, CURVE]);
/// A conic whose axis stays amid the face.
pub(super) const STILL: [bool; 8] = free(&[TURN_U, TURN_U + 1, RISE, CURVE, SHAPE]);
pub(super) const CONIC: [bool; 8] = free(&[TURN_U, TURN_U + 1, RISE, CURVE, SHAPE, SLIDE_U, SLIDE_U + 1]);

const fn free(columns: &[usize]) -> [bool; 8] {
    let mut out = [false; 8];
    let mut i = 0;
    while i < columns.len() {
        out[columns[i]] = true;
        i += 1;
    }
    out
}

/// A minimum: the surface, the sum of squared orthogonal distances, and the triangle of its Jacobian.
pub(super) struct Minimum {
    pub conic: Conic,
    pub cost: f64,
    pub triangle: Triangle<8>,
}

fn cost(points: &[DVec3], conic: &Conic) -> f64 {
    points.iter().map(|&p| conic.distance(p).powi(2)).sum()
}

fn triangle(points: &[DVec3], conic: &Conic) -> Triangle<8> {
    let mut triangle = Triangle::new();
    for &p in points {
        let mut row = conic.row(p);
        row[7] = -row[7]; // the step that cancels the residual
        triangle.add(row);
    }
    triangle
}

/// Walks from `start` to the nearest minimum of Σ distance². Points are expected centred and scaled to size one. A
/// parameter whose whole plausible range (1 in these units, 10 for the conic constant) changes the points by less than
/// what the present residual hides is held still, so that nothing wanders where the points say nothing. None if the
/// start has no cost.
pub(super) fn refine(points: &[DVec3], start: Conic, movable: &[bool; 8], most: usize) -> Option<Minimum> {
    let (mut conic, mut least) = (start, cost(points, &start));
    if !least.is_finite() {
        return None;
    }
    let mut damping = 1e-4;
    let mut now = triangle(points, &conic);
    let mut calm = 0;
    for _ in 0..most {
        let rms = (least / points.len() as f64).sqrt();
        let free = std::array::from_fn(|j| {
            let range = if j == SHAPE { 10.0 } else { 1.0 };
            j < 7 && movable[j] && now.norm(j) * range > rms
        });
        let mut better = None;
        while better.is_none() && damping < 1e8 {
            let trial = conic.moved(&now.solve(damping, &free));
            let trial_cost = cost(points, &trial);
            if trial_cost < least {
                better = Some((trial, trial_cost));
                damping = if damping < 1e-12 { 0.0 } else { damping * 0.1 };
            } else {
                damping = (damping * 10.0).max(1e-6);
            }
        }
        let Some((trial, trial_cost)) = better else { break };
        calm = if least - trial_cost < 1e-9 * least { calm + 1 } else { 0 };
        (conic, least) = (trial, trial_cost);
        now = triangle(points, &conic);
        if calm >= 2 {
            break;
        }
    }
    Some(Minimum { conic, cost: least, triangle: now })
}
