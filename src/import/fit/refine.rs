//! Orthogonal least squares: Levenberg–Marquardt over the freedoms of a surface (Nocedal & Wright, Numerical
//! Optimization, §10.3).

use super::conic::{CURVE, Conic, RISE, SHAPE, SLIDE_U, TURN_U};
use super::linalg::{Rows, Triangle};
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

/// The rows at a surface, and the sum of squared distances that they hold.
fn triangle(points: &[DVec3], surface: &impl Model) -> (Triangle<8>, f64) {
    let (mut rows, mut cost) = (Rows::new(), 0.0);
    for &p in points {
        let mut row = surface.row(p);
        cost += row[7] * row[7];
        row[7] = -row[7]; // the step that cancels the residual
        rows.add(row);
    }
    (rows.triangle(), cost)
}

/// How a walk begins and when it is given up.
#[derive(Debug, Clone, Copy)]
pub(super) struct Walk {
    damping: f64,
    /// The root mean square that the walk must reach: given up where the pace at which it falls cannot.
    goal: f64,
}

impl Walk {
    /// From a start that may be far, to the minimum wherever it is.
    pub const FAR: Walk = Walk { damping: 1e-4, goal: f64::INFINITY };
    /// From the minimum of a part of the points: Gauss–Newton.
    pub const NEAR: Walk = Walk { damping: 0.0, goal: f64::INFINITY };

    pub fn towards(goal: f64) -> Walk {
        Walk { goal, ..Walk::FAR }
    }
}

/// Steps at most.
const MOST: usize = 100;
/// A step of which the linear model promises less than this share of the cost is not taken: with n points it is a
/// change of √(n·10⁻¹²) standard errors.
const NOTHING: f64 = 1e-12;

/// Walks from `start` to the nearest minimum of Σ distance². Points are expected centred and scaled to size one. A
/// parameter whose whole plausible range changes the points by less than what the present residual hides is held still, so that nothing wanders where the
/// points say nothing. None if the start has no cost.
pub(super) fn refine<M: Model>(points: &[DVec3], start: M, movable: &[bool; 8], walk: Walk) -> Option<Minimum<M>> {
    let mut surface = start;
    let (mut now, mut least) = triangle(points, &surface);
    if !least.is_finite() {
        return None;
    }
    let count = points.len() as f64;
    let mut damping = walk.damping;
    let mut calm = 0;
    for step in 1..=MOST {
        let rms = (least / count).sqrt();
        let free = std::array::from_fn(|j| j < 7 && movable[j] && now.norm(j) * M::range(j) > rms);
        let mut better = None;
        while better.is_none() && damping < 1e8 {
            let by = now.solve(damping, &free);
            let promised = (least - now.left(&by)) / least;
            // Where the step is hardly damped, what it promises is all there is.
            if damping <= 1e-9 && promised <= NOTHING {
                return Some(Minimum { surface, cost: least, triangle: now });
            }
            let trial = surface.moved(&by);
            let trial_cost = cost(points, &trial);
            if trial_cost < least {
                better = Some((trial, trial_cost));
                let kept = (least - trial_cost) / (least * promised) > 0.9;
                damping = if damping < 1e-12 { 0.0 } else { damping * if kept { 0.01 } else { 0.1 } };
            } else {
                damping = (damping * 10.0).max(1e-6);
            }
        }
        let Some((trial, trial_cost)) = better else { break };
        let fall = trial_cost / least;
        calm = if 1.0 - fall < 1e-9 { calm + 1 } else { 0 };
        surface = trial;
        (now, least) = triangle(points, &surface);
        let hopeless = step >= 5 && least * fall.powi((MOST - step) as i32) > count * walk.goal * walk.goal;
        if calm >= 2 || hopeless {
            break;
        }
    }
    Some(Minimum { surface, cost: least, triangle: now })
}
