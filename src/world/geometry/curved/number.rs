//! Numbers that a height can be computed in: plain ones, intervals (bounds), truncated power series (derivatives along a line),
//! values with both derivatives in the plane, and slopes along a line (a root divided out). One formula per surface then gives all five.

use super::spline::Spline;
use glam::DVec2;
use std::ops::{Add, Mul, Sub};

/// What the formulas of surfaces need.
pub trait Num: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    fn of(x: f64) -> Self;
    fn times(self, by: f64) -> Self;
    fn sqrt(self) -> Self;
    fn over(self, by: Self) -> Self;
    fn square(self) -> Self;
    fn plus(self, x: f64) -> Self {
        self + Self::of(x)
    }
    /// Least and greatest value.
    fn low(self) -> f64;
    fn high(self) -> f64;
    /// The part of the values that is between `low` and `high`, where there are several.
    fn clip(self, low: f64, high: f64) -> Self;
    /// All values of both, where there are several.
    fn join(self, other: Self) -> Self;
    /// The height of a spline at u and v.
    #[inline]
    fn spline(u: Self, v: Self, spline: &Spline) -> Self {
        spline.hull(u, v)
    }
}

impl Num for f64 {
    #[inline]
    fn of(x: f64) -> f64 {
        x
    }
    #[inline]
    fn times(self, by: f64) -> f64 {
        self * by
    }
    #[inline]
    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }
    #[inline]
    fn over(self, by: f64) -> f64 {
        self / by
    }
    #[inline]
    fn square(self) -> f64 {
        self * self
    }
    #[inline]
    fn low(self) -> f64 {
        self
    }
    #[inline]
    fn high(self) -> f64 {
        self
    }
    #[inline]
    fn clip(self, _: f64, _: f64) -> Self {
        self
    }
    #[inline]
    fn join(self, _: Self) -> Self {
        self
    }
}

/// All numbers from `lo` to `hi`; NaN where an operation is not defined on all of it. Not rounded outwards: bounds made
/// of it are widened once by far more than rounding.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    pub lo: f64,
    pub hi: f64,
}

impl Interval {
    pub const NONE: Interval = Interval { lo: f64::NAN, hi: f64::NAN };

    pub fn magnitude(self) -> f64 {
        // NaN stays NaN.
        let (a, b) = (self.lo.abs(), self.hi.abs());
        if a >= b || a.is_nan() { a } else { b }
    }
    pub fn is_finite(self) -> bool {
        self.lo.is_finite() && self.hi.is_finite()
    }
}

impl Add for Interval {
    type Output = Interval;
    fn add(self, other: Interval) -> Interval {
        Interval { lo: self.lo + other.lo, hi: self.hi + other.hi }
    }
}
impl Sub for Interval {
    type Output = Interval;
    fn sub(self, other: Interval) -> Interval {
        Interval { lo: self.lo - other.hi, hi: self.hi - other.lo }
    }
}
impl Mul for Interval {
    type Output = Interval;
    fn mul(self, other: Interval) -> Interval {
        let all = [self.lo * other.lo, self.lo * other.hi, self.hi * other.lo, self.hi * other.hi];
        if all.iter().any(|x| x.is_nan()) {
            return Interval::NONE;
        }
        let fold = |pick: fn(f64, f64) -> f64| all[1..].iter().fold(all[0], |a, b| pick(a, *b));
        Interval { lo: fold(f64::min), hi: fold(f64::max) }
    }
}

impl Num for Interval {
    fn of(x: f64) -> Interval {
        Interval { lo: x, hi: x }
    }
    fn times(self, by: f64) -> Interval {
        if by >= 0.0 {
            Interval { lo: self.lo * by, hi: self.hi * by }
        } else {
            Interval { lo: self.hi * by, hi: self.lo * by }
        }
    }
    fn sqrt(self) -> Interval {
        // The root of a negative number is NaN, and then there is no bound.
        Interval { lo: self.lo.sqrt(), hi: self.hi.sqrt() }
    }
    fn over(self, by: Interval) -> Interval {
        if by.lo > 0.0 || by.hi < 0.0 { self * Interval { lo: 1.0 / by.hi, hi: 1.0 / by.lo } } else { Interval::NONE }
    }
    fn square(self) -> Interval {
        let (a, b) = (self.lo * self.lo, self.hi * self.hi);
        if self.lo <= 0.0 && self.hi >= 0.0 {
            Interval { lo: 0.0, hi: a.max(b) }
        } else {
            Interval { lo: a.min(b), hi: a.max(b) }
        }
    }
    #[inline]
    fn low(self) -> f64 {
        self.lo
    }
    #[inline]
    fn high(self) -> f64 {
        self.hi
    }
    #[inline]
    fn clip(self, low: f64, high: f64) -> Self {
        Interval { lo: self.lo.max(low), hi: self.hi.min(high) }
    }
    #[inline]
    fn join(self, other: Self) -> Self {
        Interval { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }
}

/// The first N coefficients of a power series: `0[k]` is the k-th derivative over k!.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Series<T, const N: usize>(pub [T; N]);

impl<T: Num, const N: usize> Series<T, N> {
    /// value + slope·t.
    pub fn line(value: T, slope: T) -> Self {
        let mut all = [T::of(0.0); N];
        all[0] = value;
        all[1] = slope;
        Series(all)
    }
}

impl<T: Num, const N: usize> Add for Series<T, N> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Series(std::array::from_fn(|k| self.0[k] + other.0[k]))
    }
}
impl<T: Num, const N: usize> Sub for Series<T, N> {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Series(std::array::from_fn(|k| self.0[k] - other.0[k]))
    }
}
impl<T: Num, const N: usize> Mul for Series<T, N> {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        Series(std::array::from_fn(|k| (1..=k).fold(self.0[0] * other.0[k], |sum, i| sum + self.0[i] * other.0[k - i])))
    }
}

impl<T: Num, const N: usize> Num for Series<T, N> {
    #[inline]
    fn of(x: f64) -> Self {
        let mut all = [T::of(0.0); N];
        all[0] = T::of(x);
        Series(all)
    }
    #[inline]
    fn times(self, by: f64) -> Self {
        Series(self.0.map(|x| x.times(by)))
    }
    /// s² = a: 2 s₀ s_k = a_k − Σ_{0<i<k} s_i s_{k−i}.
    #[inline]
    fn sqrt(self) -> Self {
        let mut all = [T::of(0.0); N];
        all[0] = self.0[0].sqrt();
        let per_twice = T::of(0.5).over(all[0]);
        for k in 1..N {
            let rest = (1..k).fold(self.0[k], |sum, i| sum - all[i] * all[k - i]);
            all[k] = rest * per_twice;
        }
        Series(all)
    }
    /// q b = a: b₀ q_k = a_k − Σ_{i<k} q_i b_{k−i}. The value itself is divided, so it is as right as numbers are; the others
    /// need not wait for that.
    #[inline]
    fn over(self, by: Self) -> Self {
        let mut all = [T::of(0.0); N];
        all[0] = self.0[0].over(by.0[0]);
        let per = T::of(1.0).over(by.0[0]);
        for k in 1..N {
            let rest = (0..k).fold(self.0[k], |sum, i| sum - all[i] * by.0[k - i]);
            all[k] = rest * per;
        }
        Series(all)
    }
    #[inline]
    fn square(self) -> Self {
        let mut out = self * self;
        // An interval times itself is wider than its square.
        out.0[0] = self.0[0].square();
        out
    }
    #[inline]
    fn low(self) -> f64 {
        self.0[0].low()
    }
    #[inline]
    fn high(self) -> f64 {
        self.0[0].high()
    }
    #[inline]
    fn clip(self, low: f64, high: f64) -> Self {
        let mut out = self;
        out.0[0] = self.0[0].clip(low, high);
        out
    }
    #[inline]
    fn join(self, other: Self) -> Self {
        Series(std::array::from_fn(|k| self.0[k].join(other.0[k])))
    }
}

/// A value and its derivatives along x and y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InPlane {
    pub value: f64,
    pub by: DVec2,
}

impl Add for InPlane {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        InPlane { value: self.value + other.value, by: self.by + other.by }
    }
}
impl Sub for InPlane {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        InPlane { value: self.value - other.value, by: self.by - other.by }
    }
}
impl Mul for InPlane {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        InPlane { value: self.value * other.value, by: self.value * other.by + other.value * self.by }
    }
}

impl Num for InPlane {
    #[inline]
    fn of(x: f64) -> Self {
        InPlane { value: x, by: DVec2::ZERO }
    }
    #[inline]
    fn times(self, by: f64) -> Self {
        InPlane { value: self.value * by, by: self.by * by }
    }
    #[inline]
    fn sqrt(self) -> Self {
        let value = self.value.sqrt();
        InPlane { value, by: self.by * (0.5 / value) }
    }
    #[inline]
    fn over(self, by: Self) -> Self {
        let value = self.value / by.value;
        InPlane { value, by: (self.by - value * by.by) * (1.0 / by.value) }
    }
    #[inline]
    fn square(self) -> Self {
        self * self
    }
    #[inline]
    fn low(self) -> f64 {
        self.value
    }
    #[inline]
    fn high(self) -> f64 {
        self.value
    }
    #[inline]
    fn clip(self, _: f64, _: f64) -> Self {
        self
    }
    #[inline]
    fn join(self, _: Self) -> Self {
        self
    }
}

/// A quantity along a line: what it is at the start, what it is at t, and their difference over t without cancellation
/// (the slope arithmetic of R. Krawczyk and A. Neumaier, SIAM J. Numer. Anal. 22, 1985).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slope<T> {
    pub start: f64,
    pub at: T,
    pub slope: T,
}

impl<T: Num> Add for Slope<T> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Slope { start: self.start + other.start, at: self.at + other.at, slope: self.slope + other.slope }
    }
}
impl<T: Num> Sub for Slope<T> {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Slope { start: self.start - other.start, at: self.at - other.at, slope: self.slope - other.slope }
    }
}
impl<T: Num> Mul for Slope<T> {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        let slope = other.slope.times(self.start) + self.slope * other.at;
        Slope { start: self.start * other.start, at: self.at * other.at, slope }
    }
}

impl<T: Num> Num for Slope<T> {
    #[inline]
    fn of(x: f64) -> Self {
        Slope { start: x, at: T::of(x), slope: T::of(0.0) }
    }
    #[inline]
    fn times(self, by: f64) -> Self {
        Slope { start: self.start * by, at: self.at.times(by), slope: self.slope.times(by) }
    }
    #[inline]
    fn sqrt(self) -> Self {
        let (start, at) = (self.start.sqrt(), self.at.sqrt());
        Slope { start, at, slope: self.slope.over(at.plus(start)) }
    }
    #[inline]
    fn over(self, by: Self) -> Self {
        let start = self.start / by.start;
        Slope { start, at: self.at.over(by.at), slope: (self.slope - by.slope.times(start)).over(by.at) }
    }
    #[inline]
    fn square(self) -> Self {
        self * self
    }
    #[inline]
    fn low(self) -> f64 {
        self.at.low()
    }
    #[inline]
    fn high(self) -> f64 {
        self.at.high()
    }
    #[inline]
    fn clip(self, _: f64, _: f64) -> Self {
        self
    }
    #[inline]
    fn join(self, _: Self) -> Self {
        self
    }
    #[inline]
    fn spline(u: Self, v: Self, spline: &Spline) -> Self {
        spline.slope(u, v)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn formula<T: Num>(x: T) -> T {
        (x.square().plus(2.0)).sqrt().over(x * x * x.times(0.5) + T::of(3.0)) - x
    }

    #[test]
    fn series_are_derivatives() {
        let at = formula(Series::<f64, 4>::line(0.7, 1.0));
        assert_eq!(at.0[0], formula(0.7));
        let h = 1e-3;
        let f = |k: f64| formula(0.7 + k * h);
        let first = (f(-2.0) - 8.0 * f(-1.0) + 8.0 * f(1.0) - f(2.0)) / (12.0 * h);
        let second = (f(1.0) - 2.0 * f(0.0) + f(-1.0)) / (h * h);
        let third = (f(2.0) - 2.0 * f(1.0) + 2.0 * f(-1.0) - f(-2.0)) / (2.0 * h.powi(3));
        assert!((at.0[1] - first).abs() < 1e-10, "{} {first}", at.0[1]);
        assert!((2.0 * at.0[2] - second).abs() < 1e-5, "{} {second}", at.0[2]);
        assert!((6.0 * at.0[3] - third).abs() < 1e-4, "{} {third}", at.0[3]);
    }

    #[test]
    fn both_derivatives_are_those_along_lines() {
        fn of_two<T: Num>(x: T, y: T) -> T {
            (x.square() + y.times(3.0)).sqrt().over(y.square().plus(2.0)) - x * y
        }
        let (x, y) = (0.7, 0.4);
        let both = of_two(InPlane { value: x, by: DVec2::X }, InPlane { value: y, by: DVec2::Y });
        let along = |dx: f64, dy: f64| of_two(Series::<f64, 2>([x, dx]), Series([y, dy])).0;
        assert_eq!(both.value, of_two(x, y));
        for (found, [_, want]) in [(both.by.x, along(1.0, 0.0)), (both.by.y, along(0.0, 1.0))] {
            assert!((found - want).abs() < 1e-15, "{found} {want}");
        }
    }

    #[test]
    fn intervals_contain_and_shrink() {
        let wide = formula(Interval { lo: 0.5, hi: 0.9 });
        for i in 0..=20 {
            let y = formula(0.5 + 0.02 * f64::from(i));
            assert!(wide.lo <= y && y <= wide.hi, "{y} {wide:?}");
        }
        let narrow = formula(Interval { lo: 0.7, hi: 0.7 + 1e-9 });
        assert!(narrow.hi - narrow.lo < 1e-8);
        assert!(Interval { lo: -1.0, hi: 1.0 }.sqrt().lo.is_nan());
        assert!(!Interval::of(1.0).over(Interval { lo: -1.0, hi: 1.0 }).is_finite());
        assert!(Interval::NONE.magnitude().is_nan());
    }

    #[test]
    fn slopes_keep_their_digits_however_near() {
        // To second order the slope between x and x + t is f'(x) + t f''(x)/2.
        let series = formula(Series::<f64, 4>::line(0.7, 1.0));
        for t in [1e-14, 1e-9, 1e-5] {
            let line = Slope { start: 0.7, at: 0.7 + t, slope: 1.0 };
            let want = series.0[1] + t * series.0[2] + t * t * series.0[3];
            assert!((formula(line).slope - want).abs() < 1e-14, "{t}: {} {want}", formula(line).slope);
        }
        let line = Slope { start: 0.7, at: 0.9, slope: 1.0 };
        let plain = (formula(0.9) - formula(0.7)) / 0.2;
        assert!((formula(line).slope - plain).abs() < 1e-14);
    }
}
