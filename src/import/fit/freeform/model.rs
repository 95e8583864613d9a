//! A base conic of revolution and heights that are added to it, in the frame of its vertex, and how the distance of a
//! point from it answers to its unknowns. Points are centred and scaled to size one.

use super::basis::{Basis, Term};
use super::triangle::Triangle;
use glam::{DQuat, DVec3};

/// Axes at the vertex: unit, orthogonal, right-handed; heights are along `axis`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Frame {
    pub vertex: DVec3,
    pub x: DVec3,
    pub y: DVec3,
    pub axis: DVec3,
}

impl Frame {
    pub fn local(&self, p: DVec3) -> DVec3 {
        let q = p - self.vertex;
        DVec3::new(q.dot(self.x), q.dot(self.y), q.dot(self.axis))
    }
    pub fn back(&self, v: DVec3) -> DVec3 {
        v.x * self.x + v.y * self.y + v.z * self.axis
    }
}

/// A point, what rounding to f32 does to each of its coordinates (standard deviation), and how far it is trusted.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample {
    pub p: DVec3,
    pub rounding: DVec3,
    pub trust: f64,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Model {
    pub frame: Frame,
    /// Curvature and conic constant of the base.
    pub c: f64,
    pub k: f64,
    pub basis: Basis,
    pub order: usize,
    pub heights: Vec<f64>,
    /// A part of the noise that every point has, so that a coordinate near zero isn't trusted beyond all others.
    pub floor: f64,
}

/// Freedoms of the frame and the base: tilts about x and y, shifts of the vertex along x and y, curvature.
pub(super) const FREEDOMS: usize = 5;
pub(super) type Free = [bool; FREEDOMS];

impl Model {
    pub fn terms(&self) -> usize {
        self.basis.terms(self.order)
    }

    /// Height of the base; none where it has turned over.
    pub fn base(&self, x: f64, y: f64) -> Option<Term> {
        let (r2, open) = (x * x + y * y, 1.0 + self.k);
        let under = 1.0 - open * self.c * self.c * r2;
        let root = (under > 0.01).then(|| under.sqrt())?;
        Some(Term { value: self.c * r2 / (1.0 + root), slope: [self.c * x / root, self.c * y / root] })
    }

    pub fn surface(&self, x: f64, y: f64, terms: &mut Vec<Term>) -> Option<Term> {
        let mut all = self.base(x, y)?;
        if !self.heights.is_empty() {
            self.basis.at(x, y, self.order, terms);
            for (term, height) in terms.iter().zip(&self.heights) {
                all.value += height * term.value;
                all.slope[0] += height * term.slope[0];
                all.slope[1] += height * term.slope[1];
            }
        }
        Some(all)
    }

    /// Signed distance of a point to first order, along the axis.
    pub fn distance(&self, p: DVec3) -> Option<f64> {
        let q = self.frame.local(p);
        let z = self.surface(q.x, q.y, &mut Vec::new())?;
        Some((q.z - z.value) / steep(z.slope))
    }

    /// By how much the height of a point over the surface is known: trust over the standard deviation of the rounding.
    fn weight(&self, sample: &Sample, slope: [f64; 2]) -> f64 {
        sample.trust / (self.rounded(sample, slope) * steep(slope))
    }

    fn rounded(&self, sample: &Sample, slope: [f64; 2]) -> f64 {
        let normal = self.frame.back(DVec3::new(-slope[0], -slope[1], 1.0)) / steep(slope);
        ((normal * sample.rounding).length_squared() + self.floor * self.floor).sqrt()
    }

    /// Standard deviation of a sample's distance by rounding.
    pub fn noise(&self, sample: &Sample) -> f64 {
        let q = self.frame.local(sample.p);
        self.surface(q.x, q.y, &mut Vec::new()).map_or(0.0, |z| self.rounded(sample, z.slope))
    }

    /// The row of a sample, weighted: the terms, then what the freedoms do, and the height over the base.
    /// None where the base has no height.
    pub fn row(&self, sample: &Sample, free: &Free, row: &mut Vec<f64>, terms: &mut Vec<Term>) -> Option<f64> {
        let q = self.frame.local(sample.p);
        let surface = self.surface(q.x, q.y, terms)?;
        let base = self.base(q.x, q.y)?;
        let weight = self.weight(sample, surface.slope);
        self.bare(q, free, surface.slope, row, terms)?;
        row.iter_mut().for_each(|x| *x *= weight);
        Some(weight * (q.z - base.value))
    }

    /// The row at a place of the frame, not weighted.
    fn bare(&self, q: DVec3, free: &Free, slope: [f64; 2], row: &mut Vec<f64>, terms: &mut Vec<Term>) -> Option<()> {
        self.basis.at(q.x, q.y, self.order, terms);
        row.clear();
        row.extend(terms.iter().map(|term| term.value));
        let open = 1.0 + self.k;
        let base = self.base(q.x, q.y)?;
        // From c r² + c (1+k) z² = 2 z.
        let bend =
            (q.x * q.x + q.y * q.y + open * base.value * base.value) / (2.0 * (1.0 - self.c * open * base.value));
        // Minus the derivatives of (z − height) of a point by the freedoms.
        let by = [q.y + slope[1] * q.z, -q.x - slope[0] * q.z, -slope[0], -slope[1], bend];
        row.extend(by.into_iter().zip(free).filter(|(_, free)| **free).map(|(by, _)| by));
        Some(())
    }

    /// The model after steps of the freedoms.
    pub fn moved(&self, by: &[f64; FREEDOMS]) -> Model {
        let turn = DQuat::from_scaled_axis(by[0] * self.frame.x + by[1] * self.frame.y);
        let (axis, x) = ((turn * self.frame.axis).normalize_or(self.frame.axis), turn * self.frame.x);
        let x = (x - x.dot(axis) * axis).normalize_or(self.frame.x);
        let vertex = self.frame.vertex + by[2] * self.frame.x + by[3] * self.frame.y;
        let frame = Frame { vertex, x, y: axis.cross(x), axis };
        Model { frame, c: self.c + by[4], ..self.clone() }
    }

    /// The rows of all samples in a triangle. None where the base has no height at one of them.
    pub fn triangle(&self, samples: &[Sample], free: &Free) -> Option<Triangle> {
        let columns = self.terms() + free.iter().filter(|free| **free).count();
        let mut triangle = Triangle::new(columns);
        let (mut row, mut terms) = (Vec::new(), Vec::new());
        for sample in samples.iter().filter(|sample| sample.trust > 0.0) {
            let right = self.row(sample, free, &mut row, &mut terms)?;
            triangle.add(&mut row, right);
        }
        Some(triangle)
    }

    /// The same with the heights that suit the samples best.
    pub fn solved(&self, samples: &[Sample]) -> Option<Model> {
        let heights = self.triangle(samples, &[false; FREEDOMS])?.solve(self.terms());
        Some(Model { heights, ..self.clone() })
    }

    /// Mean square of the weighted distances of the trusted samples.
    pub fn cost(&self, samples: &[Sample]) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0f64);
        let mut terms = Vec::new();
        for sample in samples.iter().filter(|sample| sample.trust > 0.0) {
            let q = self.frame.local(sample.p);
            let Some(z) = self.surface(q.x, q.y, &mut terms) else { return f64::INFINITY };
            sum += (self.weight(sample, z.slope) * (q.z - z.value)).powi(2);
            count += 1.0;
        }
        sum / count.max(1.0)
    }

    /// The row of the surface's height, slope or curvature at a place, for what the points leave open of it: differences
    /// of rows at `by` times `step`, `second` of them of second order.
    pub fn probe(&self, at: [f64; 2], by: [f64; 2], second: bool, free: &Free) -> Option<Vec<f64>> {
        let mut terms = Vec::new();
        let mut row_at = |k: f64| {
            let (x, y) = (at[0] + k * by[0], at[1] + k * by[1]);
            let z = self.surface(x, y, &mut terms)?;
            let mut row = Vec::new();
            self.bare(DVec3::new(x, y, z.value), free, z.slope, &mut row, &mut terms)?;
            Some(row)
        };
        let (minus, here, plus) = (row_at(-1.0)?, row_at(0.0)?, row_at(1.0)?);
        let step2 = by[0] * by[0] + by[1] * by[1];
        if step2 == 0.0 {
            return Some(here);
        }
        let three = minus.into_iter().zip(here).zip(plus);
        Some(
            three
                .map(|((a, b), c)| if second { (a - 2.0 * b + c) / step2 } else { 0.5 * (c - a) / step2.sqrt() })
                .collect(),
        )
    }
}

/// √(1 + slope²).
pub(super) fn steep(slope: [f64; 2]) -> f64 {
    (1.0 + slope[0] * slope[0] + slope[1] * slope[1]).sqrt()
}
