//! Student's t: what a difference over its estimated standard error says when few samples gave that error.

use super::stats;

/// P(|T| > t) for Student's t with `freedom` degrees of freedom; the normal distribution's where they are infinite.
///
/// P = I_x(ν/2, ½) with x = ν/(ν + t²) (Abramowitz & Stegun 26.7.1); relative error below 1e-9 for ν up to 1e6.
pub fn two_sided(t: f64, freedom: f64) -> f64 {
    let t = t.abs();
    if t.is_nan() || freedom.is_nan() || freedom <= 0.0 {
        return f64::NAN;
    }
    if t == 0.0 {
        return 1.0;
    }
    if freedom > 1e6 {
        return 2.0 * stats::normal_tail(t.min(38.0));
    }
    if t.is_infinite() {
        return 0.0;
    }
    incomplete_beta(freedom / (freedom + t * t), t * t / (freedom + t * t), 0.5 * freedom, 0.5).clamp(0.0, 1.0)
}

/// The normal deviate that is as rare as `t`, with its sign; `t` itself where that is too rare to tell.
pub fn as_normal(t: f64, freedom: f64) -> f64 {
    let rare = two_sided(t, freedom);
    if rare.is_nan() || rare < 1e-300 || freedom.is_infinite() { t } else { stats::two_sided_z(rare).copysign(t) }
}

/// A mean's deviate `t` as it would be if what the mean is of were not skew: P. Hall's transformation (On the removal of
/// skewness by transformation, J. R. Stat. Soc. B 54, 1992). `skewness`: estimated, of the mean, the third cumulant over the
/// variance to 3/2. Where rare events are missing from a sample, its mean is too small, and so is what it states as its error.
/// Monotone in `t`, and never less than a quarter of it but for a sixth of the skewness.
pub fn unskewed(t: f64, skewness: f64) -> f64 {
    if skewness.is_finite() {
        t + skewness * (t * t / 3.0 + 1.0 / 6.0) + skewness * skewness * t.powi(3) / 27.0
    } else {
        t
    }
}

/// I_x(a, b); y = 1 − x is given too, since it may be too small to be told from x.
fn incomplete_beta(x: f64, y: f64, a: f64, b: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    if y <= 0.0 {
        return 1.0;
    }
    let front = a * x.ln() + b * y.ln() + ln_gamma(a + b) - ln_gamma(a) - ln_gamma(b);
    if x < (a + 1.0) / (a + b + 2.0) {
        front.exp() * fraction(x, a, b) / a
    } else {
        1.0 - front.exp() * fraction(y, b, a) / b
    }
}

/// The continued fraction of the incomplete beta function (Abramowitz & Stegun 26.5.8), by Lentz's method.
fn fraction(x: f64, a: f64, b: f64) -> f64 {
    const TINY: f64 = 1e-300;
    let guarded = |value: f64| if value.abs() < TINY { TINY } else { value };
    let (mut c, mut d) = (1.0, 1.0 / guarded(1.0 - (a + b) * x / (a + 1.0)));
    let mut h = d;
    // Needs about √max(a, b) terms.
    for m in 1..10_000 {
        let m = f64::from(m);
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        d = 1.0 / guarded(1.0 + even * d);
        c = guarded(1.0 + even / c);
        h *= d * c;
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        d = 1.0 / guarded(1.0 + odd * d);
        c = guarded(1.0 + odd / c);
        h *= d * c;
        if (d * c - 1.0).abs() < 1e-15 {
            break;
        }
    }
    h
}

/// ln Γ(x) for x > 0: Stirling's series (Abramowitz & Stegun 6.1.41) above 10, the recurrence below.
fn ln_gamma(x: f64) -> f64 {
    let (mut x, mut product) = (x, 1.0f64);
    while x < 10.0 {
        product *= x;
        x += 1.0;
    }
    let inverse = 1.0 / (x * x);
    let series = (1.0 / 12.0 - inverse * (1.0 / 360.0 - inverse * (1.0 / 1260.0 - inverse / 1680.0))) / x;
    (x - 0.5) * x.ln() - x + 0.5 * (2.0 * std::f64::consts::PI).ln() + series - product.ln()
}

/// Degrees of freedom of a difference whose two variances are each known from few samples (Welch 1947,
/// Satterthwaite 1946). Infinite where neither has a variance.
pub fn welch([variance_a, freedom_a]: [f64; 2], [variance_b, freedom_b]: [f64; 2]) -> f64 {
    let part = |variance: f64, freedom: f64| if variance > 0.0 { variance * variance / freedom } else { 0.0 };
    let sum = variance_a + variance_b;
    let parts = part(variance_a, freedom_a) + part(variance_b, freedom_b);
    if parts > 0.0 { sum * sum / parts } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The transformation keeps the order of deviates and a quarter of them, and makes less of a deviate to the side on which a
    /// mean that lacks rare light lies.
    #[test]
    fn skewness_keeps_the_order() {
        for skewness in [-2.0, -0.5, 0.0, 0.1, 1.0] {
            let all: Vec<f64> = (-400..=400).map(|k| unskewed(0.05 * f64::from(k), skewness)).collect();
            assert!(all.windows(2).all(|pair| pair[0] <= pair[1] + 1e-12), "{skewness}");
            for t in [-20.0f64, -5.0, 5.0, 20.0] {
                let kept = (unskewed(t, skewness) - skewness / 6.0) / t;
                assert!(kept >= 0.25 - 1e-12 && (skewness != 0.0 || kept == 1.0), "{t} {skewness} {kept}");
            }
        }
        assert!(unskewed(5.0, -0.3) < 3.5 && unskewed(-5.0, 0.3) > -3.5 && unskewed(5.0, 0.3) > 7.0);
        assert_eq!(unskewed(3.0, f64::NAN), 3.0);
    }

    /// ν = 1 is the Cauchy distribution, 1 − (2/π) atan t; ν = 2 gives 1 − t/√(2 + t²); tables of the others
    /// (Abramowitz & Stegun table 26.10: two-sided 1 % and 0.1 %).
    #[test]
    fn closed_forms_and_tables() {
        for t in [0.1, 1.0, 3.0, 40.0, 1e4] {
            let cauchy = 2.0 / std::f64::consts::PI * (1.0f64 / t).atan();
            assert!((two_sided(t, 1.0) / cauchy - 1.0).abs() < 1e-9, "{t}");
            let root = (2.0f64 + t * t).sqrt();
            let two = 2.0 / (root * (root + t));
            assert!((two_sided(-t, 2.0) / two - 1.0).abs() < 1e-8, "{t}: {} {two}", two_sided(t, 2.0));
        }
        for (t, freedom, want) in [(3.355, 8.0, 0.01), (5.041, 8.0, 0.001), (2.750, 30.0, 0.01), (3.373, 120.0, 0.001)]
        {
            assert!((two_sided(t, freedom) / want - 1.0).abs() < 2e-3, "{t} {freedom}: {}", two_sided(t, freedom));
        }
        for t in [0.5, 3.0, 6.0] {
            let (normal, many) = (two_sided(t, f64::INFINITY), two_sided(t, 9e5));
            assert!((many / normal - 1.0).abs() < 1e-3, "{t}: {many} {normal}");
        }
        assert!(two_sided(f64::NAN, 3.0).is_nan() && two_sided(1.0, 0.0).is_nan());
        assert_eq!((two_sided(f64::INFINITY, 3.0), two_sided(0.0, 3.0)), (0.0, 1.0));
    }

    #[test]
    fn as_rare_as_a_normal_deviate() {
        // Two-sided 1 %: 3.355 with 8 degrees of freedom, 2.576 normal.
        assert!((as_normal(-3.355, 8.0) + 2.576).abs() < 1e-3);
        assert!((as_normal(2.0, 1e7) - 2.0).abs() < 1e-6 && as_normal(0.0, 3.0).abs() < 1e-9);
        assert_eq!((as_normal(60.0, f64::INFINITY), as_normal(f64::INFINITY, 5.0)), (60.0, f64::INFINITY));
        assert!(as_normal(f64::NAN, 5.0).is_nan());
    }

    #[test]
    fn welch_of_alike_and_unlike() {
        assert_eq!(welch([2.0, 7.0], [2.0, 7.0]), 14.0);
        assert_eq!(welch([2.0, 7.0], [0.0, 7.0]), 7.0);
        assert_eq!(welch([0.0, 7.0], [0.0, 7.0]), f64::INFINITY);
    }
}
