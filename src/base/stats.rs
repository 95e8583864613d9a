//! Statistics for tests and error estimates: normal quantiles, Šidák's correction, running moments.

/// The value that a χ² of so many degrees of freedom over their number stays below as often as a normal deviate below `z`
/// (E. B. Wilson and M. M. Hilferty, PNAS 17, 1931; within 3 % from one degree on at the usual levels).
pub fn chi2_over_mean(freedom: f64, z: f64) -> f64 {
    let part = 2.0 / (9.0 * freedom);
    (1.0 - part + z * part.sqrt()).powi(3)
}

/// Upper tail probability of the standard normal distribution, P(Z > z).
///
/// Complementary error function by the continued fraction / series split of Abramowitz & Stegun 7.1.5 and 7.1.14;
/// relative error below 1e-12 for |z| < 37.
pub fn normal_tail(z: f64) -> f64 {
    if z < 0.0 {
        return 1.0 - normal_tail(-z);
    }
    let x = z / std::f64::consts::SQRT_2;
    if x < 2.0 {
        // erf by its Maclaurin series.
        let (mut term, mut sum, mut n) = (x, x, 0.0f64);
        while term.abs() > 1e-17 * sum.abs() {
            n += 1.0;
            term *= -x * x / n;
            sum += term / (2.0 * n + 1.0);
            if n > 200.0 {
                break;
            }
        }
        return 0.5 * (1.0 - 2.0 / std::f64::consts::PI.sqrt() * sum);
    }
    let mut fraction = 0.0;
    for k in (1..=120).rev() {
        fraction = k as f64 / 2.0 / (x + fraction);
    }
    0.5 * (-x * x).exp() / std::f64::consts::PI.sqrt() / (x + fraction)
}

/// The z that a two-sided test of `count` independent standard normals must not exceed for a family-wise error rate
/// of `alpha` (Šidák's correction).
pub fn sidak_z(alpha: f64, count: usize) -> f64 {
    let each = -f64::ln_1p(-alpha) / count.max(1) as f64; // 1 − (1 − α)^(1/n), to first order for tiny rates
    let each = if each < 1e-6 { each } else { 1.0 - (1.0 - alpha).powf(1.0 / count.max(1) as f64) };
    two_sided_z(each)
}

/// The z beyond which, on either side, a standard normal number is as often as `rate`; at most 38.
pub fn two_sided_z(rate: f64) -> f64 {
    let (mut low, mut high) = (0.0, 38.0);
    for _ in 0..200 {
        let mid = 0.5 * (low + high);
        if 2.0 * normal_tail(mid) > rate { low = mid } else { high = mid }
    }
    0.5 * (low + high)
}

/// Mean and variance of a stream of numbers (Welford).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Moments {
    pub count: f64,
    pub mean: f64,
    sum2: f64,
}

impl Moments {
    pub fn add(&mut self, x: f64) {
        self.count += 1.0;
        let delta = x - self.mean;
        self.mean += delta / self.count;
        self.sum2 += delta * (x - self.mean);
    }
    /// Unbiased variance of one number.
    pub fn variance(&self) -> f64 {
        if self.count < 2.0 { f64::NAN } else { self.sum2 / (self.count - 1.0) }
    }
    /// Standard error of the mean.
    pub fn stderr(&self) -> f64 {
        (self.variance() / self.count).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_tail_matches_tables() {
        // Abramowitz & Stegun table 26.1 and mpmath values.
        for (z, want) in [
            (0.0, 0.5),
            (1.0, 0.158_655_253_931_457_05),
            (2.5, 0.006_209_665_325_776_132),
            (3.0, 0.001_349_898_031_630_094_6),
            (6.0, 9.865_876_450_376_98e-10),
        ] {
            assert!((normal_tail(z) / want - 1.0).abs() < 1e-10, "{z}: {} {want}", normal_tail(z));
        }
        assert!((normal_tail(-1.0) - 0.841_344_746_068_542_9).abs() < 1e-14);
    }

    #[test]
    fn sidak() {
        assert!((sidak_z(0.05, 1) - 1.959_963_985).abs() < 1e-6);
        assert!(sidak_z(0.05, 100) > 3.4 && sidak_z(0.05, 100) < 3.6);
    }

    /// Abramowitz & Stegun, table 26.8: 95 % points.
    #[test]
    fn chi2_matches_tables() {
        for (freedom, want) in [(1.0, 3.841_46), (4.0, 9.487_73), (20.0, 31.4104), (100.0, 124.342)] {
            let got = freedom * chi2_over_mean(freedom, 1.644_853_627);
            assert!((got / want - 1.0).abs() < 0.03, "{freedom}: {got} {want}");
        }
        assert_eq!(chi2_over_mean(f64::INFINITY, 1.6), 1.0);
    }

    #[test]
    fn moments() {
        let mut m = Moments::default();
        [1.0, 2.0, 4.0].into_iter().for_each(|x| m.add(x));
        assert!((m.mean - 7.0 / 3.0).abs() < 1e-15 && (m.variance() - 7.0 / 3.0).abs() < 1e-14);
    }
}
