//! All roots of a function of one variable on an interval, in order, none missed and none twice: intervals are cut until
//! a bound on the second derivative says that there is no root or one, and that one is enclosed.

use std::ops::ControlFlow;

/// A function with a bound on how it bends.
pub trait Bent {
    /// Value and derivative.
    fn at(&self, t: f64) -> (f64, f64);
    /// Bound of |second derivative| on the interval that is searched.
    fn bend(&self) -> f64;
    /// What rounding may change a value by; where bending changes less, there is nothing left to tell.
    fn noise(&self) -> f64;
    /// Roots nearer to each other than this cannot be told apart at t.
    fn grain(&self, t: f64) -> f64;
}

#[derive(Clone, Copy)]
struct End {
    t: f64,
    value: f64,
    slope: f64,
}

/// A line that lies in the surface to rounding has no roots to find and could be cut for ever: after this many cuts the
/// signs at the ends of what is left decide. A tangent takes about 60, a bound a thousand times too
/// large some hundreds.
const CUTS: usize = 10_000;

/// Calls `visit` with the roots between `from` and `to`, ascending, until it breaks; whether a zero at an end itself
/// counts is not said. A double root counts as two or none.
pub fn roots(f: &impl Bent, from: f64, to: f64, visit: &mut impl FnMut(f64) -> ControlFlow<()>) -> ControlFlow<()> {
    let bend = f.bend();
    if !(from < to && from.is_finite() && to.is_finite() && bend.is_finite()) {
        return ControlFlow::Continue(());
    }
    let end = |t: f64| {
        let (value, slope) = f.at(t);
        End { t, value, slope }
    };
    let (mut a, b) = (end(from), end(to));
    if told(f, bend, a, b) {
        return if crosses(a, b) { visit(solve(f, bend, a, b)) } else { ControlFlow::Continue(()) };
    }
    // What is still to be searched, the next on top: the far ends of intervals that begin where the one before ends.
    let mut ahead = vec![b];
    let mut cuts = 0;
    while let Some(b) = ahead.last().copied() {
        let middle = a.t + 0.5 * (b.t - a.t);
        if told(f, bend, a, b) || !(a.t < middle && middle < b.t) || cuts >= CUTS {
            if crosses(a, b) {
                visit(solve(f, bend, a, b))?;
            }
            a = b;
            ahead.pop();
        } else {
            cuts += 1;
            ahead.push(end(middle));
        }
    }
    ControlFlow::Continue(())
}

/// Zero counts as positive, so that a root at a cut is in one of its intervals.
#[inline]
fn crosses(a: End, b: End) -> bool {
    (a.value >= 0.0) != (b.value >= 0.0) && !a.value.is_nan() && !b.value.is_nan()
}

/// Whether the ends and the bound tell that there is no root or one, or as much as rounding leaves to be told.
#[inline]
fn told(f: &impl Bent, bend: f64, a: End, b: End) -> bool {
    let width = b.t - a.t;
    let monotone = a.slope * b.slope > 0.0 && a.slope.abs() + b.slope.abs() > bend * width;
    let change = bend * width * width;
    let clear = !crosses(a, b) && a.value.abs().min(b.value.abs()) > 0.125 * change;
    clear || monotone || change <= f.noise()
}

/// Where the place as a cubic of the value, by both ends and their slopes, has the value zero: Hermite's interpolation of the
/// inverse function.
#[inline]
fn foretold(a: End, b: End) -> f64 {
    let rise = b.value - a.value;
    let s = -a.value / rise;
    let left = 1.0 - s;
    let (to_a, to_b) = (left * left * (1.0 + 2.0 * s), s * s * (3.0 - 2.0 * s));
    to_a * a.t + to_b * b.t + rise * s * left * (left / a.slope - s / b.slope)
}

/// The root between two ends of different sign: Newton's method, and halving wherever that leaves the enclosure or
/// shrinks it too slowly (Press et al., Numerical Recipes, section 9.4). Where the bound on the bending says that the next step
/// would be below the grain (L. V. Kantorovich's theorem: with h = bend·step/|slope| ≤ √2 − 1 what is left is at most h·step), it is not made.
fn solve(f: &impl Bent, bend: f64, a: End, b: End) -> f64 {
    let (mut low, mut high) = if a.value < 0.0 { (a.t, b.t) } else { (b.t, a.t) };
    let (first, chord) = (foretold(a, b), a.t + (b.t - a.t) * (a.value / (a.value - b.value)));
    let inside = |t: &f64| *t > a.t && *t < b.t;
    let mut t = [first, chord].into_iter().find(inside).unwrap_or(0.5 * (a.t + b.t));
    let mut before = (b.t - a.t).abs();
    let mut step = before;
    loop {
        let (value, slope) = f.at(t);
        if value == 0.0 {
            return t;
        }
        if value < 0.0 {
            low = t;
        } else {
            high = t;
        }
        let newton = t - value / slope;
        let inside = (newton - low) * (newton - high) < 0.0;
        let next = if inside && (newton - t).abs() <= 0.5 * before { newton } else { 0.5 * (low + high) };
        before = step;
        step = (next - t).abs();
        let grain = f.grain(next);
        let left = bend * step / slope.abs();
        let is_last = next == newton && left <= 0.4 && left * step <= grain;
        if is_last || step <= grain || next == low || next == high || next.is_nan() {
            return if next.is_nan() { t } else { next };
        }
        t = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Products of (t − root), their derivative and a bound of the second.
    struct Product(Vec<f64>, f64);

    impl Bent for Product {
        fn at(&self, t: f64) -> (f64, f64) {
            self.0.iter().fold((1.0, 0.0), |(v, d), r| (v * (t - r), d * (t - r) + v))
        }
        fn bend(&self) -> f64 {
            self.1
        }
        fn noise(&self) -> f64 {
            1e-17
        }
        fn grain(&self, t: f64) -> f64 {
            f64::EPSILON * t.abs()
        }
    }

    fn all(f: &Product, from: f64, to: f64) -> Vec<f64> {
        let mut found = Vec::new();
        let _ = roots(f, from, to, &mut |t| {
            found.push(t);
            ControlFlow::Continue(())
        });
        found
    }

    #[test]
    fn every_root_in_order() {
        for (list, bend) in [
            (vec![0.3], 0.0),
            (vec![0.1, 0.5], 2.0),
            (vec![0.5, 0.5 + 1e-6], 2.0),
            (vec![0.1, 0.100001, 0.7, 0.9], 100.0),
            (vec![0.2, 0.4, 0.6, 0.8], 1e4),
            (vec![0.125, 0.25, 0.5], 100.0),
        ] {
            let found = all(&Product(list.clone(), bend), 0.0, 1.0);
            assert_eq!(found.len(), list.len(), "{list:?} {found:?}");
            for (a, b) in found.iter().zip(&list) {
                assert!((a - b).abs() < 1e-11, "{list:?} {found:?}");
            }
        }
        assert!(all(&Product(vec![2.0], 0.0), 0.0, 1.0).is_empty());
        // A root between two searches is in one of them.
        assert_eq!(all(&Product(vec![0.5], 0.0), 0.0, 0.5).len() + all(&Product(vec![0.5], 0.0), 0.5, 1.0).len(), 1);
    }

    #[test]
    fn flat_and_invalid_functions_end() {
        struct Flat(f64, f64);
        impl Bent for Flat {
            fn at(&self, _: f64) -> (f64, f64) {
                (self.0, 0.0)
            }
            fn bend(&self) -> f64 {
                self.1
            }
            fn noise(&self) -> f64 {
                1e-16
            }
            fn grain(&self, _: f64) -> f64 {
                1e-16
            }
        }
        for flat in [Flat(0.0, 0.0), Flat(0.0, 1e3), Flat(1e-12, 1e9), Flat(f64::NAN, 1.0), Flat(1.0, f64::NAN)] {
            let mut count = 0;
            let _ = roots(&flat, 0.0, 1.0, &mut |_| {
                count += 1;
                ControlFlow::Continue(())
            });
            assert_eq!(count, 0);
        }
    }
}
