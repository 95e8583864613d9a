//! Statistics for tests and error estimates: normal quantiles, Šidák's correction, running moments.

/// The value that the quotient of two estimates of one variance stays below as often as a normal deviate below `z`; of `above`
/// degrees of freedom the one and of `below` the other (E. Paulson, Ann. Math. Stat. 13, 1942, from cube roots that are
/// nearly normal: E. B. Wilson and M. M. Hilferty, PNAS 17, 1931). At 95 % within 4 % from 4 degrees below on, with 3 some 7 % too
/// much; fewer are taken for 3, which is too little for them. `z`: at most 3, beyond which cube roots are far from normal.
pub fn variance_ratio(above: f64, below: f64, z: f64) -> f64 {
    let [above, below] = [above, below.max(3.0)].map(|freedom| 2.0 / (9.0 * freedom));
    // ((1 − below)·x − (1 − above))² = z²·(below·x² + above), x the root of the ratio.
    let [a, b] = [1.0 - above, 1.0 - below];
    let square = b * b - z * z * below;
    let root = z * (a * a * below + above * square).sqrt();
    ((a * b + root) / square).powi(3)
}

/// What there is beyond noise of the squares of a picture's pixels: their sum `seen` has that of the variances, `noise`, in it. None
/// where no more than rounding is left, as where no pixel was hit twice.
pub fn beyond_noise(noise: f64, seen: f64) -> Option<f64> {
    // Of frames, which have 24 bits.
    const ROUNDING: f64 = 1e-6;
    let signal = seen - noise;
    (signal > ROUNDING * seen).then_some(signal)
}

/// A sum of `freedom` squares of normal deviates as one normal deviate (E. B. Wilson and M. M. Hilferty, "The distribution of
/// chi-square", Proc. Natl. Acad. Sci. 17, 1931).
pub fn chi_square_z(sum: f64, freedom: f64) -> f64 {
    let spread = 2.0 / (9.0 * freedom);
    ((sum / freedom).cbrt() - (1.0 - spread)) / spread.sqrt()
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

    /// Abramowitz & Stegun, tables 26.8 and 26.9: 95 % points of χ² and F.
    #[test]
    fn variance_ratios_match_tables() {
        const Z: f64 = 1.644_853_627;
        for (freedom, want) in [(1.0, 3.841_46), (4.0, 9.487_73), (20.0, 31.4104), (100.0, 124.342)] {
            let got = freedom * variance_ratio(freedom, f64::INFINITY, Z);
            assert!((got / want - 1.0).abs() < 0.03, "{freedom}: {got} {want}");
        }
        for (above, below, want) in [
            (1.0, 5.0, 6.61),
            (1.0, 10.0, 4.96),
            (4.0, 4.0, 6.39),
            (4.0, 30.0, 2.69),
            (8.0, 3.0, 8.85),
            (20.0, 10.0, 2.77),
            (60.0, 60.0, 1.53),
        ] {
            let got = variance_ratio(above, below, Z);
            let near = if below < 4.0 { 0.07 } else { 0.04 };
            assert!((got / want - 1.0).abs() < near, "{above} {below}: {got} {want}");
        }
        assert_eq!(variance_ratio(f64::INFINITY, f64::INFINITY, 1.6), 1.0);
        assert!(variance_ratio(1.0, 0.0, 1.6).is_finite());
    }

    /// Means of pixels that one of a few passes hit have the variance of their own squares, but for rounding.
    #[test]
    fn single_hits_are_nothing_but_noise() {
        for passes in 2..9 {
            let n = f64::from(passes);
            let (mut noise, mut seen) = (0.0, 0.0);
            for pixel in 1..300 {
                let (hit, mean) = (0.1 * f64::from(pixel), 0.1 * f64::from(pixel) / n);
                noise += (hit * hit - hit * hit / n) / (n - 1.0) / n;
                seen += mean * mean;
            }
            assert_eq!(beyond_noise(noise, seen), None, "{passes}: {noise} {seen}");
            assert!(beyond_noise(0.5 * noise, seen).is_some_and(|signal| (signal / seen - 0.5).abs() < 1e-9));
        }
        assert_eq!(beyond_noise(0.0, 0.0), None);
    }

    #[test]
    fn moments() {
        let mut m = Moments::default();
        [1.0, 2.0, 4.0].into_iter().for_each(|x| m.add(x));
        assert!((m.mean - 7.0 / 3.0).abs() < 1e-15 && (m.variance() - 7.0 / 3.0).abs() < 1e-14);
    }

    /// Quantiles of χ² at 95 % and 99 % (Abramowitz and Stegun, table 26.8) are as rare as 1.6449 and 2.3263 of a normal deviate.
    #[test]
    fn chi_square_as_a_normal_deviate() {
        for (freedom, quantiles) in [(10.0, [18.3070, 23.2093]), (100.0, [124.342, 135.807])] {
            for (sum, z) in quantiles.into_iter().zip([1.6449, 2.3263]) {
                assert!((chi_square_z(sum, freedom) - z).abs() < 0.02, "{freedom} {sum}");
            }
        }
    }
}
