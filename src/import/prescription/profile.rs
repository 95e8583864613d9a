//! The shape of a surface of revolution and what is added to it.

use glam::DVec3;
use std::fmt::Write;

/// Heights along z over x and y.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    /// Of the base, signed; positive with its centre at +z.
    pub curvature: f64,
    pub conic: f64,
    pub form: Form,
}

/// What the base is, or what is added to it.
#[derive(Debug, Clone, PartialEq)]
pub enum Form {
    /// A conic of revolution and nothing more.
    Conic,
    /// Coefficients of r², r⁴, …
    Even(Vec<f64>),
    /// The circle of the curvature in the plane of y and z, turned about a line along y at this curvature of x and z.
    Toroid { across: f64 },
    /// Coefficients of 1, x, y, x², xy, y², …
    Polynomial(Vec<f64>),
    /// Coefficients in OSA order, over the norm radius.
    Zernike { norm_radius: f64, coeffs: Vec<f64> },
}

impl Profile {
    pub const PLANE: Profile = Profile { curvature: 0.0, conic: 0.0, form: Form::Conic };

    /// The height; none where the base does not reach.
    pub fn sag(&self, x: f64, y: f64) -> Option<f64> {
        let r2 = x * x + y * y;
        let base = |r2: f64, c: f64, k: f64| {
            let root = 1.0 - (1.0 + k) * c * c * r2;
            (root > 0.0).then(|| c * r2 / (1.0 + root.sqrt()))
        };
        let added = match &self.form {
            Form::Conic => 0.0,
            Form::Even(even) => even.iter().rev().fold(0.0, |sum, a| (sum + a) * r2),
            Form::Toroid { across } => {
                let tube = base(y * y, self.curvature, 0.0)?;
                // A circle about the line at 1/across whose radius there is 1/across less the tube's height.
                let reach = 1.0 - across * tube;
                let root = reach * reach - across * across * x * x;
                return (root > 0.0).then(|| tube + across * x * x / (reach + root.sqrt()));
            }
            Form::Polynomial(coeffs) => {
                let (mut sum, mut index) = (0.0, 0);
                for degree in 0.. {
                    for j in 0..=degree {
                        let Some(c) = coeffs.get(index) else {
                            return Some(base(r2, self.curvature, self.conic)? + sum);
                        };
                        sum += c * x.powi(degree - j) * y.powi(j);
                        index += 1;
                    }
                }
                sum
            }
            Form::Zernike { norm_radius, coeffs } => {
                let terms = coeffs.iter().enumerate().filter(|(_, c)| **c != 0.0);
                terms.map(|(j, c)| c * zernike(j, r2.sqrt() / norm_radius, y.atan2(x))).sum()
            }
        };
        Some(base(r2, self.curvature, self.conic)? + added)
    }

    /// Unit normal towards +z, by differences over a part of `scale`; +z where the surface ends.
    pub fn normal(&self, x: f64, y: f64, scale: f64) -> DVec3 {
        let step = 1e-4 * scale;
        let along = |dx: f64, dy: f64| Some((self.sag(x + dx, y + dy)? - self.sag(x - dx, y - dy)?) / (2.0 * step));
        match (along(step, 0.0), along(0.0, step)) {
            (Some(by_x), Some(by_y)) => DVec3::new(-by_x, -by_y, 1.0).normalize_or(DVec3::Z),
            (_, _) => DVec3::Z,
        }
    }

    /// The shape in the sidecar's words, its vertex and axes as given.
    pub(super) fn words(&self, vertex: DVec3, [x, y, axis]: [DVec3; 3]) -> String {
        let three = |v: DVec3| format!("[{}, {}, {}]", v.x, v.y, v.z);
        let list = |values: &[f64]| values.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
        let placed = format!("vertex = {}, axis = {}", three(vertex), three(axis));
        let radius = 1.0 / self.curvature;
        let curved = self.curvature != 0.0;
        // What is added to a plane needs a radius all the same: one that bends it by less than a number holds.
        let base = |out: &mut String| {
            let radius = if curved { radius } else { 1e300 };
            let _ = write!(out, ", radius = {radius:e}, conic = {}", self.conic);
        };
        match &self.form {
            Form::Conic if !curved => format!("{{ kind = \"plane\", {placed} }}"),
            Form::Conic if self.conic == 0.0 => format!("{{ kind = \"sphere\", {placed}, radius = {radius} }}"),
            Form::Conic => format!("{{ kind = \"conic\", {placed}, radius = {radius}, conic = {} }}", self.conic),
            Form::Even(even) => {
                let mut out = format!("{{ kind = \"asphere\", {placed}");
                base(&mut out);
                out + &format!(", even = [{}] }}", list(even))
            }
            Form::Toroid { across } => match (curved, *across != 0.0) {
                (false, false) => format!("{{ kind = \"plane\", {placed} }}"),
                (true, false) => format!("{{ kind = \"cylinder\", {placed}, x = {}, radius = {radius} }}", three(x)),
                (false, true) => {
                    format!("{{ kind = \"cylinder\", {placed}, x = {}, radius = {} }}", three(y), 1.0 / across)
                }
                (true, true) => {
                    let (x, tube) = (three(y), radius);
                    format!(
                        "{{ kind = \"toroid\", {placed}, x = {x}, radius = {}, tube_radius = {tube} }}",
                        1.0 / across
                    )
                }
            },
            Form::Polynomial(coeffs) => {
                let mut out = format!("{{ kind = \"xy_poly\", {placed}, x = {}", three(x));
                base(&mut out);
                out + &format!(", coeffs = [{}] }}", list(coeffs))
            }
            Form::Zernike { norm_radius, coeffs } => {
                let mut out = format!("{{ kind = \"zernike\", {placed}, x = {}", three(x));
                base(&mut out);
                out + &format!(", norm_radius = {norm_radius}, coeffs = [{}] }}", list(coeffs))
            }
        }
    }
}

/// n and m of OSA's number j.
pub(super) fn osa(j: usize) -> (i32, i32) {
    let n = (0..).find(|n| (n + 1) * (n + 2) / 2 > j).unwrap_or(0);
    (n as i32, 2 * (j as i32) - (n * (n + 2)) as i32)
}

fn zernike(j: usize, rho: f64, phi: f64) -> f64 {
    let (n, m) = osa(j);
    let factorial = |k: i32| (1..=k).map(f64::from).product::<f64>();
    let half = (n - m.abs()) / 2;
    let term = |k: i32| {
        let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
        let below = factorial(k) * factorial((n + m.abs()) / 2 - k) * factorial(half - k);
        sign * factorial(n - k) / below * rho.powi(n - 2 * k)
    };
    let radial: f64 = (0..=half).map(term).sum();
    let norm = (f64::from(2 * n + 2) / if m == 0 { 2.0 } else { 1.0 }).sqrt();
    let turned = f64::from(m.abs()) * phi;
    norm * radial * if m < 0 { turned.sin() } else { turned.cos() }
}
