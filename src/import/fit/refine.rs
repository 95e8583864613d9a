//! Orthogonal least squares: Levenberg–Marquardt over the freedoms of a surface (Nocedal & Wright, Numerical
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

/// A surface with seven freedoms at most.
pub(super) trait Model: Copy {
    /// Signed orthogonal distance.
    fn distance(&self, p: DVec3) -> f64;
    /// Derivatives of the distance by the freedoms, then the distance.
    fn row(&self, p: DVec3) -> [f64; 8];
    /// The surface after a step in the freedoms.
    fn moved(&self, step: &[f64; 8]) -> Self;
    /// The whole plausible range of a freedom, for points scaled to size one.
    fn range(freedom: usize) -> f64;
}

impl Model for Conic {
    fn distance(&self, p: DVec3) -> f64 {
        Conic::distance(self, p)
    }
    fn row(&self, p: DVec3) -> [f64; 8] {
        Conic::row(self, p)
    }
    fn moved(&self, step: &[f64; 8]) -> Conic {
        Conic::moved(self, step)
    }
    fn range(freedom: usize) -> f64 {
        if freedom == SHAPE { 10.0 } else { 1.0 }
    }
}

/// A minimum: the surface, the sum of squared orthogonal distances, and the triangle of its Jacobian.
pub(super) struct Minimum<M = Conic> {
    pub surface: M,
    pub cost: f64,
    pub triangle: Triangle<8>,
}

fn cost(points: &[DVec3], surface: &impl Model) -> f64 {
    points.iter().map(|&p| surface.distance(p).powi(2)).sum()
}

fn triangle(points: &[DVec3], surface: &impl Model) -> Triangle<8> {
    let mut triangle = Triangle::new();
    for &p in points {
        let mut row = surface.row(p);
        row[7] = -row[7]; // the step that cancels the residual
        triangle.add(row);
    }
    triangle
}

/// Walks from `start` to the nearest minimum of Σ distance². Points are expected centred and scaled to size one. A
/// parameter whose whole plausible range changes the points by less than
/// what the present residual hides is held still, so that nothing wanders where the points say nothing. None if the
/// start has no cost.
pub(super) fn refine<M: Model>(points: &[DVec3], start: M, movable: &[bool; 8], most: usize) -> Option<Minimum<M>> {
    let (mut surface, mut least) = (start, cost(points, &start));
    if !least.is_finite() {
        return None;
    }
    let mut damping = 1e-4;
    let mut now = triangle(points, &surface);
    let mut calm = 0;
    for _ in 0..most {
        let rms = (least / points.len() as f64).sqrt();
        let free = std::array::from_fn(|j| j < 7 && movable[j] && now.norm(j) * M::range(j) > rms);
        let mut better = None;
        while better.is_none() && damping < 1e8 {
            let trial = surface.moved(&now.solve(damping, &free));
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
        (surface, least) = (trial, trial_cost);
        now = triangle(points, &surface);
        if calm >= 2 {
            break;
        }
    }
    Some(Minimum { surface, cost: least, triangle: now })
}
