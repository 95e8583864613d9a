//! From the terms of a model to the numbers that name its surface.

use super::basis::{Basis, legendre_powers};
use super::model::Model;
use crate::fit::task::Scale;
use crate::fit::{Fitted, Kind};

/// A base flatter than this, of a face scaled to size one, is told as this flat: a radius is a finite number.
pub(super) const FLATTEST: f64 = 1e-9;

/// The surface in mesh units. `kind` chooses between the names of a polynomial.
pub(super) fn fitted(kind: Kind, model: &Model, scale: Scale) -> Fitted {
    let Scale { mean, size } = scale;
    let (frame, conic) = (model.frame, model.k);
    let (vertex, axis, x) = (mean + size * frame.vertex, frame.axis, frame.x);
    let c = if model.c.abs() < FLATTEST { FLATTEST.copysign(model.c) } else { model.c };
    let radius = size / c;
    match &model.basis {
        Basis::Even { reach } => {
            let (constant, powers) = even(&model.heights, *reach);
            let vertex = vertex + size * constant * axis;
            let even = powers.iter().enumerate().map(|(m, a)| a * size.powi(-2 * m as i32 - 1)).collect();
            Fitted::Asphere { vertex, axis, radius, conic, even }
        }
        Basis::Poly { half } => {
            let mut powers = polynomial(&model.heights, *half, model.order);
            if kind == Kind::Zernike {
                let reach = half[0].hypot(half[1]);
                let coeffs = zernike(&powers, model.order, reach).into_iter().map(|c| c * size).collect();
                return Fitted::Zernike { vertex, axis, x, radius, conic, norm_radius: size * reach, coeffs };
            }
            let constant = powers.first_mut().map_or(0.0, std::mem::take);
            let degrees = (0..=model.order).flat_map(|d| std::iter::repeat_n(d as i32, d + 1));
            let coeffs = powers.iter().zip(degrees).map(|(c, d)| c * size.powi(1 - d)).collect();
            Fitted::XyPoly { vertex: vertex + size * constant * axis, axis, x, radius, conic, coeffs }
        }
        Basis::Spline(knots) => Fitted::Bspline {
            vertex,
            axis,
            x,
            radius,
            conic,
            half: knots.half.map(|h| h * size),
            spans: knots.spans.map(|n| n as u32),
            coeffs: model.heights.iter().map(|c| c * size).collect(),
        },
    }
}

/// The height of the middle and the coefficients of r², r⁴, ….
fn even(heights: &[f64], reach: f64) -> (f64, Vec<f64>) {
    let Some((constant, heights)) = heights.split_first() else { return (0.0, vec![0.0]) };
    let mut in_s = vec![0.0; heights.len() + 2];
    for (height, powers) in heights.iter().zip(legendre_powers(heights.len())) {
        // P_k(2s − 1) by Horner on coefficients, times s².
        let mut shifted = vec![0.0];
        for c in powers.iter().rev() {
            let mut next = vec![0.0; shifted.len() + 1];
            for (i, x) in shifted.iter().enumerate() {
                next[i + 1] += 2.0 * x;
                next[i] -= x;
            }
            next[0] += c;
            shifted = next;
        }
        for (i, x) in shifted.iter().enumerate() {
            if let Some(slot) = in_s.get_mut(i + 2) {
                *slot += height * x;
            }
        }
    }
    let per = |m: usize| reach.powi(-2 * m as i32);
    (*constant, in_s.iter().enumerate().skip(1).map(|(m, a)| a * per(m)).collect())
}

/// The coefficients of x^(d−j) y^j at d(d+1)/2 + j.
fn polynomial(heights: &[f64], half: [f64; 2], order: usize) -> Vec<f64> {
    let powers = legendre_powers(order);
    let mut out = vec![0.0; heights.len()];
    let mut terms = heights.iter();
    for degree in 0..=order {
        for j in 0..=degree {
            let Some(height) = terms.next() else { return out };
            for (a, p) in powers[degree - j].iter().enumerate() {
                for (b, q) in powers[j].iter().enumerate() {
                    let d = a + b;
                    if let Some(slot) = out.get_mut(d * (d + 1) / 2 + b) {
                        *slot += height * p * q * half[0].powi(-(a as i32)) * half[1].powi(-(b as i32));
                    }
                }
            }
        }
    }
    out
}

/// The same polynomial by Zernike terms, OSA/ANSI order and norm: they are orthonormal over the disc of `reach`, where
/// their products with a polynomial are summed exactly by Gauss's rule in r² and equal steps in φ.
fn zernike(powers: &[f64], order: usize, reach: f64) -> Vec<f64> {
    let rings = gauss(order + 1);
    let spokes = 2 * order + 2;
    let mut out = vec![0.0; (order + 1) * (order + 2) / 2];
    for (s, weight) in rings {
        let rho = s.sqrt();
        for k in 0..spokes {
            let phi = std::f64::consts::TAU * k as f64 / spokes as f64;
            let (x, y) = (reach * rho * phi.cos(), reach * rho * phi.sin());
            let mut height = 0.0;
            for d in 0..=order {
                for j in 0..=d {
                    height += powers[d * (d + 1) / 2 + j] * x.powi((d - j) as i32) * y.powi(j as i32);
                }
            }
            for n in 0..=order {
                for i in 0..=n {
                    let m = 2 * i as i32 - n as i32;
                    let norm = ((2 * n + 2) as f64 / if m == 0 { 2.0 } else { 1.0 }).sqrt();
                    let angle = f64::from(m.abs()) * phi;
                    let turn = if m < 0 { angle.sin() } else { angle.cos() };
                    let slot = n * (n + 1) / 2 + i;
                    out[slot] +=
                        height * norm * radial(n, m.unsigned_abs() as usize, rho) * turn * weight / spokes as f64;
                }
            }
        }
    }
    out
}

/// R_n^m by its sum over factorials (Born and Wolf, section 9.2.1).
fn radial(n: usize, m: usize, rho: f64) -> f64 {
    let f = |k: usize| (1..=k).map(|k| k as f64).product::<f64>();
    let term = |k: usize| {
        let sign = if k.is_multiple_of(2) { 1.0 } else { -1.0 };
        sign * f(n - k) / (f(k) * f((n + m) / 2 - k) * f((n - m) / 2 - k)) * rho.powi((n - 2 * k) as i32)
    };
    (0..=(n - m) / 2).map(term).sum()
}

/// Gauss's n places and weights on 0…1: the zeros of P_n by Newton's method (Press et al., Numerical Recipes, §4.6).
fn gauss(n: usize) -> Vec<(f64, f64)> {
    let place = |i: usize| {
        let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..20 {
            let (mut before, mut now) = (1.0, x);
            for k in 1..n {
                let f = k as f64;
                (before, now) = (now, ((2.0 * f + 1.0) * x * now - f * before) / (f + 1.0));
            }
            slope = n as f64 * (x * now - before) / (x * x - 1.0);
            x -= now / slope;
        }
        (0.5 + 0.5 * x, 1.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..n).map(place).collect()
}
