//! A complex number in f64, as small as wave optics needs: refractive indices n + ik, field amplitudes, admittances.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// `re + i im`. For a refractive index: `re` = n, `im` = k ≥ 0 absorbs (time factor exp(−iωt)).
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct Complex {
    pub re: f64,
    pub im: f64,
}

impl Complex {
    pub const ZERO: Complex = Complex { re: 0.0, im: 0.0 };
    pub const ONE: Complex = Complex { re: 1.0, im: 0.0 };

    pub const fn new(re: f64, im: f64) -> Self {
        Complex { re, im }
    }
    pub const fn real(re: f64) -> Self {
        Complex { re, im: 0.0 }
    }
    /// |z|²
    pub fn norm_sq(self) -> f64 {
        self.re * self.re + self.im * self.im
    }
    pub fn conj(self) -> Self {
        Complex::new(self.re, -self.im)
    }
    /// |z|, whatever its size.
    pub fn norm(self) -> f64 {
        // Between these the squares neither vanish nor overflow; `hypot` takes ten times as long.
        const PLAIN: std::ops::Range<f64> = 1e-280..1e280;
        let square = self.norm_sq();
        if PLAIN.contains(&square) { square.sqrt() } else { self.re.hypot(self.im) }
    }
    /// z/|z|; 0 for 0.
    pub fn phase(self) -> Self {
        let size = self.norm();
        if size > 0.0 { Complex::new(self.re / size, self.im / size) } else { Complex::ZERO }
    }
    /// z²; the factored real part keeps its digits where |re| ≈ |im|.
    pub fn square(self) -> Self {
        Complex::new((self.re - self.im) * (self.re + self.im), 2.0 * self.re * self.im)
    }
    /// The square root with Im ≥ 0: the wave that decays, not the one that grows. Real and positive for a positive real.
    pub fn sqrt(self) -> Self {
        if self.im == 0.0 {
            return if self.re >= 0.0 { Self::real(self.re.sqrt()) } else { Self::new(0.0, (-self.re).sqrt()) };
        }
        // The larger part from a sum without cancellation, the other from 2 re im = im(z).
        let large = ((self.re.abs() + self.norm()) / 2.0).sqrt();
        let small = self.im / (2.0 * large);
        let root = if self.re >= 0.0 { Self::new(large, small) } else { Self::new(small, large) };
        if root.im < 0.0 { -root } else { root }
    }
}

impl From<f64> for Complex {
    fn from(re: f64) -> Self {
        Complex::real(re)
    }
}

impl Add for Complex {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self::new(self.re + o.re, self.im + o.im)
    }
}
impl Sub for Complex {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Self::new(self.re - o.re, self.im - o.im)
    }
}
impl Mul for Complex {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        Self::new(self.re * o.re - self.im * o.im, self.re * o.im + self.im * o.re)
    }
}
impl Mul<f64> for Complex {
    type Output = Self;
    fn mul(self, o: f64) -> Self {
        Self::new(self.re * o, self.im * o)
    }
}
impl Div for Complex {
    type Output = Self;
    /// Divides by scaling with the larger part of the divisor, so |o|² never overflows (Smith 1962, Algorithm 116).
    fn div(self, o: Self) -> Self {
        if o.re.abs() >= o.im.abs() {
            let r = o.im / o.re;
            let d = o.re + o.im * r;
            Self::new((self.re + self.im * r) / d, (self.im - self.re * r) / d)
        } else {
            let r = o.re / o.im;
            let d = o.re * r + o.im;
            Self::new((self.re * r + self.im) / d, (self.im * r - self.re) / d)
        }
    }
}
impl Neg for Complex {
    type Output = Self;
    fn neg(self) -> Self {
        Self::new(-self.re, -self.im)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn close(a: Complex, b: Complex) -> bool {
        (a - b).norm_sq().sqrt() <= 4.0 * f64::EPSILON * b.norm_sq().sqrt()
    }

    #[test]
    fn the_root_of_a_real_is_the_decaying_one() {
        assert_eq!(Complex::real(4.0).sqrt(), Complex::real(2.0));
        assert_eq!(Complex::real(-4.0).sqrt(), Complex::new(0.0, 2.0));
        assert_eq!(Complex::new(-4.0, -0.0).sqrt(), Complex::new(0.0, 2.0));
        assert_eq!(Complex::ZERO.sqrt(), Complex::ZERO);
        assert_eq!(Complex::new(-3.0, 4.0).sqrt(), Complex::new(1.0, 2.0));
        assert_eq!(Complex::new(-3.0, -4.0).sqrt(), Complex::new(-1.0, 2.0));
        assert_eq!(Complex::new(3.0, -4.0).sqrt(), Complex::new(-2.0, 1.0));
    }

    #[test]
    fn the_norm_of_the_largest_and_the_smallest() {
        for size in [1e-310, 1e-200, 1e-140, 1.0, 1e140, 1e200, 1e307] {
            let got = Complex::new(3.0 * size, -4.0 * size).norm() / size;
            assert!((got - 5.0).abs() < 1e-12, "{size}: {got}");
        }
        assert_eq!(Complex::ZERO.norm(), 0.0);
        assert!(Complex::new(f64::NAN, 0.0).norm().is_nan());
    }

    proptest! {
        #[test]
        fn root_squared_and_quotient_times_divisor(
            a in -1e3..1e3f64, b in -1e3..1e3f64, c in -1e3..1e3f64, d in -1e3..1e3f64, scale in -100..100i32
        ) {
            let scale = 2f64.powi(scale);
            let (z, w) = (Complex::new(a, b), Complex::new(c, d) * scale);
            prop_assert!(close(z.sqrt() * z.sqrt(), z));
            prop_assert!(z.sqrt().im >= 0.0);
            prop_assert!(close(z / w * w, z));
            prop_assert!(close(z.square(), z * z));
        }
    }
}
