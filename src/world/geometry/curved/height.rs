//! Heights over the plane of the vertex (sag formulas of `design/formulas.md` section 4), in any kind of [`Num`].

use super::number::Num;
use super::spline::Spline;

/// z as a function of (x, y), lengths in mesh units, z(0, 0) the height at the vertex.
#[derive(Debug, Clone, PartialEq)]
pub enum Height {
    /// Conic + Σ even\[k\] r^(2k+2).
    Even { curvature: f64, conic: f64, even: Vec<f64> },
    /// A circle of curvature `tube` in the x–z plane, turned about the line along x through (0, 0, 1/curvature).
    Torus { curvature: f64, tube: f64 },
    /// Conic + Σ coeffs x^(d−j) y^j, the index d(d+1)/2 + j.
    Poly { curvature: f64, conic: f64, coeffs: Vec<f64> },
    /// Conic + Σ over orders m of r^m (cos(mφ), sin(mφ)) times radial polynomials.
    Zernike { curvature: f64, conic: f64, scale: f64, orders: Vec<Order> },
    /// Conic + bicubic B-splines.
    Spline { curvature: f64, conic: f64, spline: Spline },
}

/// The terms of one azimuthal order m; `[i]` belongs to n = m + 2i, normalisation included.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Order {
    cos: Vec<f64>,
    sin: Vec<f64>,
}

/// Sorts OSA/ANSI coefficients, index j = (n(n + 2) + m)/2, by azimuthal order and multiplies each by its norm
/// N = √(2(n+1)/(1 + δ_m0)) (L. Thibos et al., "Standards for reporting the optical aberrations of eyes", 2002).
pub fn orders(coeffs: &[f64]) -> Vec<Order> {
    let mut orders: Vec<Order> = Vec::new();
    let (mut n, mut m) = (0i32, 0i32);
    for c in coeffs {
        let order = m.unsigned_abs() as usize;
        if orders.len() <= order {
            orders.resize(order + 1, Order::default());
        }
        let norm = (f64::from(2 * (n + 1)) / if m == 0 { 2.0 } else { 1.0 }).sqrt();
        let i = (n as usize - order) / 2;
        let list = if m < 0 { &mut orders[order].sin } else { &mut orders[order].cos };
        list.resize(i, 0.0);
        list.push(norm * c);
        // −n, −n+2, …, n, then the next n.
        (n, m) = if m == n { (n + 1, -n - 1) } else { (n, m + 2) };
    }
    orders
}

/// Height of a conic of revolution at the squared distance r² from its axis.
#[inline]
fn conic_height<T: Num>(r2: T, curvature: f64, conic: f64) -> T {
    let under = T::of(1.0) - r2.times((1.0 + conic) * curvature * curvature);
    r2.times(curvature).over(under.sqrt().plus(1.0))
}

impl Height {
    #[inline]
    pub fn at<T: Num>(&self, x: T, y: T) -> T {
        match self {
            Height::Even { curvature, conic, even } => {
                let r2 = x.square() + y.square();
                let sum = even.iter().rev().fold(T::of(0.0), |sum, a| sum * r2 + T::of(*a));
                conic_height(r2, *curvature, *conic) + sum * r2
            }
            Height::Torus { curvature, tube } => {
                let g = conic_height(x.square(), *tube, 0.0);
                let c = *curvature;
                let lift = T::of(1.0) - g.times(c);
                let y2 = y.square();
                let root = (lift.square() - y2.times(c * c)).sqrt();
                (g * (lift.plus(1.0)) + y2.times(c)).over(root.plus(1.0))
            }
            Height::Poly { curvature, conic, coeffs } => {
                let r2 = x.square() + y.square();
                conic_height(r2, *curvature, *conic) + polynomial(coeffs, x, y)
            }
            Height::Zernike { curvature, conic, scale, orders } => {
                let r2 = x.square() + y.square();
                conic_height(r2, *curvature, *conic) + zernike(orders, x.times(*scale), y.times(*scale))
            }
            Height::Spline { curvature, conic, spline } => {
                let r2 = x.square() + y.square();
                conic_height(r2, *curvature, *conic) + spline.at(x, y)
            }
        }
    }

    /// 1 − (1+k) c² r²: the base conic has a height where this is positive.
    pub fn under_root(&self, r2: f64) -> f64 {
        match self {
            Height::Torus { .. } => 1.0,
            Height::Even { curvature, conic, .. }
            | Height::Poly { curvature, conic, .. }
            | Height::Zernike { curvature, conic, .. }
            | Height::Spline { curvature, conic, .. } => 1.0 - (1.0 + conic) * curvature * curvature * r2,
        }
    }

    /// How many terms a height has.
    pub fn terms(&self) -> usize {
        match self {
            Height::Torus { .. } => 1,
            Height::Even { even, .. } => even.len(),
            Height::Poly { coeffs, .. } => coeffs.len(),
            // A place meets sixteen of them.
            Height::Spline { .. } => 16,
            Height::Zernike { orders, .. } => orders.iter().map(|o| o.cos.len().max(o.sin.len())).sum(),
        }
    }
}

/// Horner in x over rows in y: the sum over i of x^i Σ_j c(i, j) y^j.
#[inline]
fn polynomial<T: Num>(coeffs: &[f64], x: T, y: T) -> T {
    let count = coeffs.len();
    // The highest degree d with d(d+1)/2 < count.
    let mut degree = 0;
    while (degree + 1) * (degree + 2) / 2 < count {
        degree += 1;
    }
    let coefficient = |i: usize, j: usize| coeffs.get((i + j) * (i + j + 1) / 2 + j).copied().unwrap_or(0.0);
    let mut sum = T::of(0.0);
    for i in (0..=degree).rev() {
        let mut row = T::of(0.0);
        for j in (0..=degree - i).rev() {
            row = row * y + T::of(coefficient(i, j));
        }
        sum = sum * x + row;
    }
    sum
}

/// R_n^m(ρ) = ρ^m P_i^(0,m)(2ρ² − 1), i = (n − m)/2, by the recurrence of Jacobi polynomials (Abramowitz and Stegun
/// 22.7.1 with α = 0, β = m); ρ^m cos(mφ) and ρ^m sin(mφ) by the powers of x + iy.
#[inline]
fn zernike<T: Num>(orders: &[Order], x: T, y: T) -> T {
    let s = (x.square() + y.square()).times(2.0).plus(-1.0);
    let (mut re, mut im) = (T::of(1.0), T::of(0.0));
    let mut sum = T::of(0.0);
    for (m, order) in orders.iter().enumerate() {
        let b = m as f64;
        let (mut last, mut now) = (T::of(0.0), T::of(1.0));
        let (mut cos, mut sin) = (T::of(0.0), T::of(0.0));
        for i in 0..order.cos.len().max(order.sin.len()) {
            let term = |list: &[f64]| list.get(i).copied().unwrap_or(0.0);
            cos = cos + now.times(term(&order.cos));
            sin = sin + now.times(term(&order.sin));
            let n = i as f64;
            let next = if i == 0 {
                s.times(0.5 * (b + 2.0)).plus(-0.5 * b)
            } else {
                let d = 2.0 * n + b;
                let lead = 2.0 * (n + 1.0) * (n + b + 1.0) * d;
                let linear = (d + 1.0) * (d + 2.0) * d / lead;
                let constant = -(d + 1.0) * b * b / lead;
                let back = 2.0 * n * (n + b) * (d + 2.0) / lead;
                (s.times(linear).plus(constant)) * now - last.times(back)
            };
            (last, now) = (now, next);
        }
        sum = sum + re * cos + im * sin;
        (re, im) = (re * x - im * y, re * y + im * x);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// R_n^m by its sum over factorials (Born and Wolf, section 9.2.1).
    fn radial(n: i32, m: i32, rho: f64) -> f64 {
        let f = |k: i32| (1..=k).map(f64::from).product::<f64>();
        (0..=(n - m) / 2)
            .map(|k| {
                let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
                sign * f(n - k) / (f(k) * f((n + m) / 2 - k) * f((n - m) / 2 - k)) * rho.powi(n - 2 * k)
            })
            .sum()
    }

    #[test]
    fn every_zernike_term_is_its_textbook_form() {
        let mut j = 0;
        for n in 0..13i32 {
            for m in (-n..=n).step_by(2) {
                assert_eq!(j, ((n * (n + 2) + m) / 2) as usize);
                let mut coeffs = vec![0.0; j + 1];
                coeffs[j] = 1.0;
                let height = Height::Zernike { curvature: 0.0, conic: 0.0, scale: 0.5, orders: orders(&coeffs) };
                for (rho, phi) in [(0.0, 0.3), (0.3, 1.0), (0.8, -2.0), (1.0, 2.5), (1.2, 0.1)] {
                    let norm = (f64::from(2 * n + 2) / if m == 0 { 2.0 } else { 1.0 }).sqrt();
                    let angle = f64::from(m.abs()) * phi;
                    let want = norm * radial(n, m.abs(), rho) * if m >= 0 { angle.cos() } else { angle.sin() };
                    let got = height.at(2.0 * rho * phi.cos(), 2.0 * rho * phi.sin());
                    assert!((got - want).abs() < 1e-10 * rho.powi(n).max(1.0), "{n} {m} at {rho}: {got} {want}");
                }
                j += 1;
            }
        }
    }

    #[test]
    fn polynomial_order_is_by_degree_then_by_power_of_y() {
        // 1, x, y, x², xy, y², x³, x²y, …
        let height = |coeffs: &[f64]| Height::Poly { curvature: 0.0, conic: 0.0, coeffs: coeffs.to_vec() }.at(3.0, 5.0);
        for (index, want) in [1.0, 3.0, 5.0, 9.0, 15.0, 25.0, 27.0, 45.0, 75.0, 125.0].into_iter().enumerate() {
            let mut coeffs = vec![0.0; index + 1];
            coeffs[index] = 1.0;
            assert_eq!(height(&coeffs), want, "{index}");
        }
        assert_eq!(height(&[1.0; 10]), 1.0 + 3.0 + 5.0 + 9.0 + 15.0 + 25.0 + 27.0 + 45.0 + 75.0 + 125.0);
    }

    #[test]
    fn a_torus_is_at_its_radii() {
        for (radius, tube) in [(20.0, 5.0), (20.0, -5.0), (-20.0, 5.0), (5.0, 20.0), (1e9, 3.0)] {
            let height = Height::Torus { curvature: 1.0 / radius, tube: 1.0 / tube };
            let (x, y) = (1.3, -2.1);
            let z = height.at(x, y);
            let from_axis = f64::hypot(y, radius - z) * f64::signum(radius);
            let circle = f64::hypot(x, from_axis - (radius - tube));
            assert!((circle - tube.abs()).abs() < 1e-15 * radius.abs() + 1e-14, "{radius} {tube}: {circle}");
        }
        let height = Height::Even { curvature: 0.01, conic: -1.0, even: vec![0.1, 0.01] };
        assert!((height.at(3.0, 4.0) - (25.0 * 0.005 + 2.5 + 6.25)).abs() < 1e-14);
    }
}
