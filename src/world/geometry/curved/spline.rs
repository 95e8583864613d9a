//! Heights of uniform bicubic B-splines in any kind of [`Num`]: a polynomial in each cell of a grid, which continues two
//! derivatives across the cells' sides.

use super::number::{Num, Slope};

/// Σ c(i, j) B_i(u) B_j(v) with the knots at whole u and v; index i·(spans of v + 3) + j.
#[derive(Debug, Clone, PartialEq)]
pub struct Spline {
    /// Places → u, v: (place + half)·rate.
    half: [f64; 2],
    rate: [f64; 2],
    spans: [usize; 2],
    coeffs: Vec<f64>,
    /// Of each cell, the coefficients of s^a t^b at 4a + b; s and t are from its middle.
    cells: Vec<[f64; 16]>,
}

/// The four cubic B-splines of a span by powers of the way from its middle (C. de Boor, A Practical Guide to Splines,
/// chapter X, at t + ½).
const POWERS: [[f64; 4]; 4] = [
    [1.0 / 48.0, -1.0 / 8.0, 1.0 / 4.0, -1.0 / 6.0],
    [23.0 / 48.0, -5.0 / 8.0, -1.0 / 4.0, 1.0 / 2.0],
    [23.0 / 48.0, 5.0 / 8.0, -1.0 / 4.0, -1.0 / 2.0],
    [1.0 / 48.0, 1.0 / 8.0, 1.0 / 4.0, 1.0 / 6.0],
];

impl Spline {
    /// Over the rectangle from −half to half. None for no spans, a rectangle without sides, or another number of
    /// coefficients than (spans + 3) of x times (spans + 3) of y.
    pub fn new(half: [f64; 2], spans: [u32; 2], coeffs: &[f64]) -> Option<Spline> {
        let spans = spans.map(|n| n as usize);
        let width = spans[1].checked_add(3)?;
        let fits = spans[0] > 0 && spans[1] > 0 && spans[0].checked_add(3)?.checked_mul(width)? == coeffs.len();
        let rate = [0, 1].map(|k| spans[k] as f64 / (2.0 * half[k]));
        if !(fits && half.iter().chain(&rate).all(|x| *x > 0.0 && x.is_finite())) {
            return None;
        }
        let mut cells = Vec::with_capacity(spans[0] * spans[1]);
        for i in 0..spans[0] {
            for j in 0..spans[1] {
                let mut cell = [0.0; 16];
                for (k, p) in POWERS.iter().enumerate() {
                    for (l, q) in POWERS.iter().enumerate() {
                        let c = coeffs[(i + k) * width + j + l];
                        for (slot, x) in cell.iter_mut().enumerate() {
                            *x += c * p[slot / 4] * q[slot % 4];
                        }
                    }
                }
                cells.push(cell);
            }
        }
        Some(Spline { half, rate, spans, coeffs: coeffs.to_vec(), cells })
    }

    /// Height at a place. Beyond the rectangle its outermost polynomials go on.
    #[inline]
    pub fn at<T: Num>(&self, x: T, y: T) -> T {
        let u = x.plus(self.half[0]).times(self.rate[0]);
        let v = y.plus(self.half[1]).times(self.rate[1]);
        T::spline(u, v, self)
    }

    /// The cell of u or v.
    #[inline]
    fn cell(&self, axis: usize, at: f64) -> usize {
        (at.max(0.0) as usize).min(self.spans[axis] - 1)
    }

    /// The polynomial of a cell.
    #[inline]
    fn patch<T: Num>(&self, i: usize, j: usize, u: T, v: T) -> T {
        let cell = &self.cells[i * self.spans[1] + j];
        let (s, t) = (u.plus(-(i as f64) - 0.5), v.plus(-(j as f64) - 0.5));
        let mut sum = T::of(0.0);
        for row in cell.as_chunks::<4>().0.iter().rev() {
            let along = row.iter().rev().fold(T::of(0.0), |sum, c| sum * t + T::of(*c));
            sum = sum * s + along;
        }
        sum
    }

    /// All that the height may be where u and v may be; one polynomial for numbers that are one place.
    #[inline]
    pub fn hull<T: Num>(&self, u: T, v: T) -> T {
        let [(from, to), (first, last)] =
            [(u, 0), (v, 1)].map(|(x, axis)| (self.cell(axis, x.low()), self.cell(axis, x.high())));
        let clipped = |x: T, cell: usize, axis: usize| {
            let low = if cell == 0 { f64::NEG_INFINITY } else { cell as f64 };
            let high = if cell + 1 == self.spans[axis] { f64::INFINITY } else { cell as f64 + 1.0 };
            x.clip(low, high)
        };
        let mut all: Option<T> = None;
        for i in from..=to {
            for j in first..=last {
                let one = self.patch(i, j, clipped(u, i, 0), clipped(v, j, 1));
                all = Some(all.map_or(one, |all| all.join(one)));
            }
        }
        all.unwrap_or(T::of(f64::NAN))
    }

    /// What the polynomial of the cell `to` has more than that of `from`, a neighbour or itself, at a place of `from`:
    /// cubes of the ways from the knots between, of which nothing cancels.
    fn more(&self, [i, j]: [usize; 2], [k, l]: [usize; 2], u: f64, v: f64) -> f64 {
        let width = self.spans[1] + 3;
        // Fourth differences across the knot, summed along it with the splines of a span.
        let across = |first: usize, step: usize, along: usize, splines: [f64; 4]| -> f64 {
            let difference = |start: usize| {
                let c = |n: usize| self.coeffs[start + n * step];
                c(0) - 4.0 * c(1) + 6.0 * c(2) - 4.0 * c(3) + c(4)
            };
            splines.iter().enumerate().map(|(n, b)| b * difference(first + n * along)).sum::<f64>() / 6.0
        };
        let splines = |way: f64| POWERS.map(|p| p.iter().rev().fold(0.0, |sum, c| sum * way + c));
        let mut more = 0.0;
        if k != i {
            let (low, sign) = if k > i { (i, 1.0) } else { (k, -1.0) };
            let jump = across(low * width + j, width, 1, splines(v - j as f64 - 0.5));
            more += sign * jump * (u - (low + 1) as f64).powi(3);
        }
        if l != j {
            let (low, sign) = if l > j { (j, 1.0) } else { (l, -1.0) };
            let jump = across(k * width + low, 1, width, splines(u - k as f64 - 0.5));
            more += sign * jump * (v - (low + 1) as f64).powi(3);
        }
        more
    }

    /// Along a line: where it ends in another cell than it starts in, the difference of their polynomials over the way.
    #[inline]
    pub fn slope<T: Num>(&self, u: Slope<T>, v: Slope<T>) -> Slope<T> {
        let from = [self.cell(0, u.start), self.cell(1, v.start)];
        let to = [self.cell(0, u.at.low()), self.cell(1, v.at.low())];
        let patched = self.patch(to[0], to[1], u, v);
        if from == to {
            return patched;
        }
        let start = self.patch(from[0], from[1], u.start, v.start);
        // 1/t, from the coordinate in which the line has left its cell.
        let along = if from[0] != to[0] { u } else { v };
        let per = along.slope.over(along.at.plus(-along.start));
        let near = from.iter().zip(&to).all(|(a, b)| a.abs_diff(*b) <= 1);
        let slope = match near {
            true => patched.slope + per.times(self.more(from, to, u.start, v.start)),
            false => patched.at.plus(-start) * per,
        };
        Slope { start, at: patched.at, slope }
    }
}

#[cfg(test)]
mod tests {
    use super::super::number::{Interval, Series};
    use super::*;

    fn some() -> Spline {
        let coeffs: Vec<f64> = (0..8 * 6).map(|i| ((i * i + 3) as f64).sin()).collect();
        Spline::new([2.0, 1.5], [5, 3], &coeffs).expect("a spline")
    }

    /// The B-spline by the recurrence of Cox and de Boor over whole knots.
    fn basis(k: usize, i: i32, x: f64) -> f64 {
        if k == 0 {
            return if (f64::from(i)..f64::from(i + 1)).contains(&x) { 1.0 } else { 0.0 };
        }
        let n = k as f64;
        (x - f64::from(i)) / n * basis(k - 1, i, x) + (f64::from(i) + n + 1.0 - x) / n * basis(k - 1, i + 1, x)
    }

    #[test]
    fn heights_are_de_boors() {
        let spline = some();
        for (x, y) in [(-2.0, -1.5), (-1.3, 0.2), (0.0, 0.0), (1.99, 1.49), (0.4, -0.5)] {
            let (u, v) = ((x + 2.0) * 1.25, (y + 1.5) * 1.0);
            let mut want = 0.0;
            for i in 0..8 {
                for j in 0..6 {
                    want += spline.coeffs[i * 6 + j] * basis(3, i as i32 - 3, u) * basis(3, j as i32 - 3, v);
                }
            }
            assert!((spline.at(x, y) - want).abs() < 1e-14, "{x} {y}: {} {want}", spline.at(x, y));
        }
    }

    #[test]
    fn two_derivatives_go_on_across_the_sides() {
        let spline = some();
        let h = 1e-9;
        for (x, y) in [(-1.2, 0.3), (0.4, 0.5), (0.4, -0.5), (1.2, -0.1)] {
            for (dx, dy) in [(1.0, 0.0), (0.0, 1.0), (0.6, -0.8)] {
                let at = |s: f64| {
                    spline.at(Series::<f64, 3>::line(x + s * dx, dx), Series::<f64, 3>::line(y + s * dy, dy)).0
                };
                for (a, b) in at(-h).iter().zip(at(h)) {
                    assert!((a - b).abs() < 1e-7, "{x} {y}: {a} {b}");
                }
            }
        }
    }

    #[test]
    fn intervals_hold_what_is_over_them() {
        let spline = some();
        let (x, y) = (Interval { lo: -1.4, hi: 0.9 }, Interval { lo: -0.7, hi: 0.1 });
        let z = spline.at(Series::<Interval, 4>::line(x, Interval::of(1.0)), Series::line(y, Interval::of(0.0))).0;
        for i in 0..=40 {
            for j in 0..=40 {
                let at = |x: Interval, k: i32| x.lo + (x.hi - x.lo) * f64::from(k) / 40.0;
                let here = spline.at(Series::<f64, 4>::line(at(x, i), 1.0), Series::line(at(y, j), 0.0)).0;
                assert!(here.iter().zip(&z).all(|(a, b)| b.lo - 1e-12 <= *a && *a <= b.hi + 1e-12), "{here:?} {z:?}");
            }
        }
    }

    #[test]
    fn slopes_keep_their_digits_across_sides() {
        let spline = some();
        let (dx, dy) = (0.8, 0.6);
        for (x, y) in [(0.4 - 1e-12, 0.3), (0.4 - 1e-12, 0.5 - 1e-12), (-1.1, -1.3), (1.2 + 1e-13, 0.5 + 1e-13)] {
            for t in [1e-13, 1e-11, 1e-6, 1e-3, 0.1, 1.0, -1e-12, -1e-3, -0.4] {
                let line =
                    |start: f64, d: f64| Slope { start, at: Series([start + t * d, d]), slope: Series([d, 0.0]) };
                let found = spline.at(line(x, dx), line(y, dy)).slope.0;
                // The mean of the derivative over the way, by Gauss's rule between the knots; short ways by its start.
                let derivative =
                    |s: f64| spline.at(Series::<f64, 2>::line(x + s * dx, dx), Series::line(y + s * dy, dy)).0[1];
                let pieces = 4000;
                let mean = (0..pieces).map(|k| derivative(t * (f64::from(k) + 0.5) / f64::from(pieces))).sum::<f64>()
                    / f64::from(pieces);
                assert!((found[0] - mean).abs() < 2e-7 * t.abs().min(1.0) + 1e-13, "{x} {y} {t}: {} {mean}", found[0]);
            }
        }
    }
}
