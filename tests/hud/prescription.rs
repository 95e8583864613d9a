//! The direct HUD as its prescription states it, traced from the pupil by twenty lines that share nothing with the crate:
//! coaxial surfaces along s, the distance from the eye in mm with the combiner unfolded. Data: the table "Scheme B" of the
//! prescription (`prescription.md`), indices there at 550 nm.

use std::f64::consts::{FRAC_PI_4, PI};

pub const N_BK7: f64 = 1.518_522_387_620_792_7;
/// Schott N-SK16 at 550 nm.
pub const N_SK16: f64 = 1.622_607_688_060_880_7;
const PMMA: f64 = 1.492_587_812_452_212_3;

/// What is varied.
#[derive(Debug, Clone, Copy)]
pub struct Direct {
    pub flux_lm: f64,
    pub pupil_mm: f64,
    pub collimator_index: f64,
    pub collimator_radius: f64,
}

pub const DIRECT: Direct =
    Direct { flux_lm: 0.45, pupil_mm: 4.0, collimator_index: N_BK7, collimator_radius: 103.704_477_524_158_55 };

/// Refraction at r² − 2Rσ + (1+k)σ² = 0, σ = vertex − s; R infinite is a plane.
fn refract(p: &mut [f64; 3], d: &mut [f64; 3], vertex: f64, radius: f64, conic: f64, [n1, n2]: [f64; 2]) {
    let curvature = 1.0 / radius;
    let q = 1.0 + conic;
    let at_vertex = (vertex - p[2]) / d[2];
    p.iter_mut().zip(&*d).for_each(|(p, d)| *p += at_vertex * d);
    // c(x² + y² + q σ²) − 2σ = 0 along p + t d, from the vertex plane (σ = 0, σ' = −d[2]).
    let a = curvature * (d[0] * d[0] + d[1] * d[1] + q * d[2] * d[2]);
    let b = curvature * (p[0] * d[0] + p[1] * d[1]) + d[2];
    let c = curvature * (p[0] * p[0] + p[1] * p[1]);
    let t = -c / (b + (b * b - a * c).sqrt());
    p.iter_mut().zip(&*d).for_each(|(p, d)| *p += t * d);
    let mut n = [curvature * p[0], curvature * p[1], 1.0 - q * curvature * (vertex - p[2])];
    let length = n.iter().map(|v| v * v).sum::<f64>().sqrt();
    n.iter_mut().for_each(|v| *v /= length);
    let cos = n.iter().zip(&*d).map(|(n, d)| n * d).sum::<f64>();
    let ratio = n1 / n2;
    let bend = (1.0 - ratio * ratio * (1.0 - cos * cos)).sqrt() - ratio * cos;
    d.iter_mut().zip(&n).for_each(|(d, n)| *d = ratio * *d + bend * n);
}

fn to_plane(p: &[f64; 3], d: &[f64; 3], s: f64) -> [f64; 2] {
    let t = (s - p[2]) / d[2];
    [p[0] + t * d[0], p[1] + t * d[1]]
}

impl Direct {
    /// Where the ray from a pupil point (mm) along the tangents `a` (right, up) meets the LCD and the plane of the LEDs,
    /// mm, right and up as seen.
    pub fn trace(&self, pupil: [f64; 2], a: [f64; 2]) -> ([f64; 2], [f64; 2]) {
        let mut p = [pupil[0], pupil[1], 0.0];
        let length = (1.0 + a[0] * a[0] + a[1] * a[1]).sqrt();
        let mut d = [a[0] / length, a[1] / length, 1.0 / length];
        let n = self.collimator_index;
        refract(&mut p, &mut d, 196.707, f64::INFINITY, 0.0, [1.0, n]);
        refract(&mut p, &mut d, 201.707, self.collimator_radius, 0.0, [n, 1.0]);
        let lcd = to_plane(&p, &d, 401.707);
        refract(&mut p, &mut d, 407.707, f64::INFINITY, 0.0, [1.0, PMMA]);
        refract(&mut p, &mut d, 415.707, 49.258_781_245_221_23, -2.227_818_377_880_880_4, [PMMA, 1.0]);
        (lcd, to_plane(&p, &d, 515.707))
    }

    /// Luminance of a white patch at the tangents `a` with the middle LED alone, cd/m²: the LED's, times what lenses
    /// and combiner let through, times the share of the pupil that the LED's image fills (∂LED/∂pupil at one direction).
    pub fn luminance(&self, a: [f64; 2]) -> f64 {
        let step = 0.02;
        let [plus_x, minus_x] = [step, -step].map(|h| self.trace([h, 0.0], a).1);
        let [plus_y, minus_y] = [step, -step].map(|h| self.trace([0.0, h], a).1);
        let slope = |plus: f64, minus: f64| (plus - minus) / (2.0 * step);
        let determinant = slope(plus_x[0], minus_x[0]) * slope(plus_y[1], minus_y[1])
            - slope(plus_x[1], minus_x[1]) * slope(plus_y[0], minus_y[0]);
        let led_area = 0.04;
        let led = self.flux_lm / (PI * led_area * 1e-6);
        let filled = led_area / determinant.abs() / (PI * self.pupil_mm * self.pupil_mm / 4.0);
        let lens = |n: f64| (1.0 - quarter_wave(1.0, 1.38 * 1.38, n)).powi(2);
        led * 0.9 * lens(PMMA) * lens(self.collimator_index) * combiner() * filled
    }
}

/// Reflectance of a quarter-wave film between admittances: ((η₀ηs − η₁²)/(η₀ηs + η₁²))².
fn quarter_wave(outside: f64, film_squared: f64, inside: f64) -> f64 {
    ((outside * inside - film_squared) / (outside * inside + film_squared)).powi(2)
}

/// The combiner's front at 45°: a quarter wave of n = 2.13 there, mean of s (η = n cos θ) and p (η = n / cos θ).
fn combiner() -> f64 {
    let cos = |n: f64| (1.0 - (FRAC_PI_4.sin() / n).powi(2)).sqrt();
    let s = |n: f64| n * cos(n);
    let p = |n: f64| n / cos(n);
    let mean = |eta: &dyn Fn(f64) -> f64| quarter_wave(eta(1.0), eta(2.13) * eta(2.13), eta(N_BK7));
    (mean(&s) + mean(&p)) / 2.0
}

/// The calculation itself, against the numbers of the prescription.
#[test]
fn the_independent_calculation_is_the_prescription() {
    let centre = DIRECT.luminance([0.0, 0.0]);
    assert!((centre / 9886.0 - 1.0).abs() < 1e-3, "{centre}");
    assert!((combiner() - 0.2546).abs() < 5e-5, "{}", combiner());
    // "4.625 deg at u = 16 mm": the tangent that leads there.
    let (mut low, mut high) = (0.0f64, 0.2f64);
    for _ in 0..60 {
        let middle = (low + high) / 2.0;
        if DIRECT.trace([0.0, 0.0], [middle, 0.0]).0[0].abs() < 16.0 { low = middle } else { high = middle }
    }
    let degrees = low.atan().to_degrees();
    eprintln!("u = 16 mm at {degrees:.4}°; centre {centre:.2}; combiner {:.5}", combiner());
    assert!((degrees - 4.625).abs() < 0.01, "{degrees}");
}
