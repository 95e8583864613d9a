//! The terms that are added to a base sphere: heights over a plane, with their slopes. Places are in units of the face's
//! half size, where the terms are of order one and nearly orthogonal.

/// What the heights are made of.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Basis {
    /// Products of Legendre polynomials, by degree: order d has (d+1)(d+2)/2 terms.
    Poly { half: [f64; 2] },
    /// 1 and s² P_k(2s − 1), s = (r/reach)², Legendre P: order d has d terms in r⁴, r⁶, …, and the 1.
    Even { reach: f64 },
    /// Products of uniform cubic B-splines.
    Spline(Knots),
}

/// A grid of `spans` equal spans over a rectangle from −half to half.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Knots {
    pub half: [f64; 2],
    pub spans: [usize; 2],
}

impl Knots {
    pub fn terms(&self) -> usize {
        (self.spans[0] + 3) * (self.spans[1] + 3)
    }
}

/// Height or term with its derivatives along x and y.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Term {
    pub value: f64,
    pub slope: [f64; 2],
}

impl Basis {
    /// Number of terms up to an order. A spline's grid is its order.
    pub fn terms(&self, order: usize) -> usize {
        match self {
            Basis::Poly { .. } => (order + 1) * (order + 2) / 2,
            Basis::Even { .. } => order + 1,
            Basis::Spline(knots) => knots.terms(),
        }
    }

    /// What counts as a length: half the shorter side, or a spline's half span along it.
    pub fn reach(&self) -> f64 {
        match self {
            Basis::Poly { half } => half[0].min(half[1]),
            Basis::Even { reach } => *reach,
            Basis::Spline(Knots { half, spans }) => (half[0] / spans[0] as f64).min(half[1] / spans[1] as f64),
        }
    }

    /// The terms up to an order at a place.
    pub fn at(&self, x: f64, y: f64, order: usize, out: &mut Vec<Term>) {
        out.clear();
        match self {
            Basis::Poly { half: [a, b] } => {
                let (p, q) = (legendre(x / a, order), legendre(y / b, order));
                for degree in 0..=order {
                    for j in 0..=degree {
                        let ((p, dp), (q, dq)) = (p[degree - j], q[j]);
                        out.push(Term { value: p * q, slope: [dp * q / a, p * dq / b] });
                    }
                }
            }
            Basis::Even { reach } => {
                let s = (x * x + y * y) / (reach * reach);
                let along = [2.0 * x / (reach * reach), 2.0 * y / (reach * reach)];
                out.push(Term { value: 1.0, slope: [0.0; 2] });
                for (p, dp) in legendre(2.0 * s - 1.0, order).into_iter().take(order) {
                    let slope = 2.0 * s * p + 2.0 * s * s * dp;
                    out.push(Term { value: s * s * p, slope: along.map(|along| slope * along) });
                }
            }
            Basis::Spline(knots) => {
                let width = knots.spans[1] + 3;
                out.resize(knots.terms(), Term::default());
                let (i, p) = cubic(x, knots.half[0], knots.spans[0]);
                let (j, q) = cubic(y, knots.half[1], knots.spans[1]);
                for (k, (p, dp)) in p.into_iter().enumerate() {
                    for (l, (q, dq)) in q.into_iter().enumerate() {
                        if let Some(slot) = out.get_mut((i + k) * width + j + l) {
                            *slot = Term { value: p * q, slope: [dp * q, p * dq] };
                        }
                    }
                }
            }
        }
    }
}

/// P_0 to P_n and their derivatives (Abramowitz and Stegun 8.5.3, and P'_{k+1} = P'_{k−1} + (2k + 1) P_k).
fn legendre(x: f64, n: usize) -> Vec<(f64, f64)> {
    let mut all = vec![(1.0, 0.0), (x, 1.0)];
    for k in 1..n {
        let ((before, slope), (now, _)) = (all[k - 1], all[k]);
        let f = k as f64;
        let next = ((2.0 * f + 1.0) * x * now - f * before) / (f + 1.0);
        all.push((next, slope + (2.0 * f + 1.0) * now));
    }
    all.truncate(n + 1);
    all
}

/// The coefficients of P_0 to P_n by powers.
pub(super) fn legendre_powers(n: usize) -> Vec<Vec<f64>> {
    let mut all: Vec<Vec<f64>> = vec![vec![1.0], vec![0.0, 1.0]];
    for k in 1..n {
        let f = k as f64;
        let mut next = vec![0.0; k + 2];
        for (i, c) in all[k].iter().enumerate() {
            next[i + 1] += (2.0 * f + 1.0) / (f + 1.0) * c;
        }
        for (i, c) in all[k - 1].iter().enumerate() {
            next[i] -= f / (f + 1.0) * c;
        }
        all.push(next);
    }
    all.truncate(n + 1);
    all
}

/// The span of a place and the four uniform cubic B-splines there with their derivatives (C. de Boor, A Practical Guide
/// to Splines, chapter X). Places beyond the ends continue the last span.
fn cubic(x: f64, half: f64, spans: usize) -> (usize, [(f64, f64); 4]) {
    let step = 2.0 * half / spans as f64;
    let at = (x + half) / step;
    let span = at.floor().clamp(0.0, (spans - 1) as f64);
    let t = at - span;
    let s = 1.0 - t;
    let values = [
        (s * s * s / 6.0, -0.5 * s * s),
        (((0.5 * t - 1.0) * t * t) + 2.0 / 3.0, (1.5 * t - 2.0) * t),
        (((0.5 * s - 1.0) * s * s) + 2.0 / 3.0, -(1.5 * s - 2.0) * s),
        (t * t * t / 6.0, 0.5 * t * t),
    ];
    (span as usize, values.map(|(value, slope)| (value, slope / step)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_are_differences_and_splines_sum_to_one() {
        let knots = Knots { half: [1.1, 0.7], spans: [5, 3] };
        for (basis, order) in
            [(Basis::Poly { half: [1.1, 0.7] }, 7), (Basis::Even { reach: 1.2 }, 5), (Basis::Spline(knots), 0)]
        {
            let at = |x: f64, y: f64| {
                let mut out = Vec::new();
                basis.at(x, y, order, &mut out);
                out
            };
            for (x, y) in [(0.3, -0.2), (-1.05, 0.69), (0.0, 0.0)] {
                let here = at(x, y);
                assert_eq!(here.len(), basis.terms(order));
                let h = 1e-6;
                let pairs = [at(x + h, y), at(x, y + h)].into_iter().zip([at(x - h, y), at(x, y - h)]);
                for (axis, (plus, minus)) in pairs.enumerate() {
                    for (k, term) in here.iter().enumerate() {
                        let want = (plus[k].value - minus[k].value) / (2.0 * h);
                        assert!((term.slope[axis] - want).abs() < 1e-8, "{basis:?} {k}: {term:?} {want}");
                    }
                }
                if let Basis::Spline(_) = basis {
                    assert!((here.iter().map(|term| term.value).sum::<f64>() - 1.0).abs() < 1e-14);
                }
            }
        }
    }

    #[test]
    fn powers_are_legendre() {
        let powers = legendre_powers(9);
        for (k, (value, _)) in legendre(0.37, 9).into_iter().enumerate() {
            let sum: f64 = powers[k].iter().rev().fold(0.0, |sum, c| sum * 0.37 + c);
            assert!((sum - value).abs() < 1e-13, "{k}");
        }
    }
}
