//! One bare interface: where the light goes (reflect, refract) and how much of it (Fresnel), dielectric or metal.
//!
//! Everything is written in q = n cos θ, and differences of squares are factored, so that no digit is lost at grazing
//! incidence, between nearly equal indices or just below the critical angle (formula sheet, section 1).

use super::stokes::Turning;
use eyebox_base::Complex;
use glam::DVec3;

/// Shares of the incident power per polarisation, each 0..1. The three are computed apart, none as what the others
/// leave, so that their sum can be checked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PowerSp {
    pub r_s: f64,
    pub r_p: f64,
    pub t_s: f64,
    pub t_p: f64,
    /// Absorbed between the two media.
    pub a_s: f64,
    pub a_p: f64,
}

impl PowerSp {
    /// Everything comes back: total internal reflection, or light along the face.
    pub const TOTAL: PowerSp = PowerSp { r_s: 1.0, r_p: 1.0, t_s: 0.0, t_p: 0.0, a_s: 0.0, a_p: 0.0 };

    /// Reflected share of unpolarised light.
    pub fn reflectance(&self) -> f64 {
        (self.r_s + self.r_p) / 2.0
    }
    /// Share of unpolarised light that crosses into the far medium (for a metal: that is absorbed in it).
    pub fn transmittance(&self) -> f64 {
        (self.t_s + self.t_p) / 2.0
    }
    /// Share of unpolarised light that stays between the two media; 0 for a bare interface.
    pub fn absorptance(&self) -> f64 {
        (self.a_s + self.a_p) / 2.0
    }
}

/// Power reflected and transmitted by the interface from a lossless medium `n1` into `n2` (n + ik, k ≥ 0).
///
/// `cos_i` 0..1 is the cosine of incidence on the `n1` side (clamped). Transmitted power is what crosses the interface:
/// reflected + transmitted = 1. Total internal reflection gives exactly 1 and 0, as does `cos_i` = 0.
/// Indices must be finite and not zero; anything else yields NaN, never a panic.
pub fn fresnel(n1: f64, n2: Complex, cos_i: f64) -> PowerSp {
    let c = cos_i.clamp(0.0, 1.0);
    if n2.im == 0.0 { dielectric(n1, n2.re, c) } else { absorbing(n1, n2, c) }
}

impl Turning {
    /// Light along the face: all of it comes back, r_s = r_p = −1 (the limit of Fresnel's equations).
    pub const GRAZING: Turning = Turning { power: PowerSp::TOTAL, reflected: Complex::ONE, transmitted: Complex::ZERO };
}

/// [`fresnel`] with the phases between s and p. What crosses into an absorbing medium is not followed; its phase is left
/// at that of a clear one.
pub fn fresnel_turning(n1: f64, n2: Complex, cos_i: f64) -> Turning {
    let c = cos_i.clamp(0.0, 1.0);
    let q1 = n1 * c;
    if q1 == 0.0 {
        return Turning::GRAZING;
    }
    // r_s = −Δ/(q₁ + q₂)² and r_p = n₁² Δ (n₂² cos² θ₁ − s²)/(n₂² q₁ + n₁² q₂)², Δ = n₂² − n₁² (see above).
    let real = Complex::real;
    let q2 = normal_sq_complex(n1, n2, q1).sqrt();
    let (n1_sq, n2_sq) = (n1 * n1, n2.square());
    let s_sq = n1_sq * ((1.0 - c) * (1.0 + c));
    let difference = (n2 - real(n1)) * (n2 + real(n1));
    let (sum_s, sum_p) = ((real(q1) + q2).phase(), (n2_sq * q1 + q2 * n1_sq).phase());
    let r_s = -(difference * (sum_s * sum_s).conj());
    let r_p = difference * (n2_sq * (c * c) - real(s_sq)) * (sum_p * sum_p).conj();
    let reflected = (r_s.phase() * r_p.phase().conj()).phase();
    Turning { power: fresnel(n1, n2, cos_i), reflected, transmitted: Complex::ONE }
}

/// q₂² = n₂² − n₁² sin² θ₁ without cancellation: n₂² − n₁² factored, plus q₁².
pub(super) fn normal_sq(n1: f64, n2: f64, q1: f64) -> f64 {
    (n2 - n1) * (n2 + n1) + q1 * q1
}

/// [`normal_sq`] for an absorbing medium.
pub(super) fn normal_sq_complex(n1: f64, n2: Complex, q1: f64) -> Complex {
    let n1 = Complex::real(n1);
    (n2 - n1) * (n2 + n1) + Complex::real(q1 * q1)
}

// Reflected : crossing power is |a − b|² : 4 Re(a b*) of |a + b|², with a, b = q₁, q₂ (s) or n₂² q₁, n₁² q₂ (p). The
// difference comes from a − b = (a² − b²)/(a + b): with Δ = n₂² − n₁² it is q₁ − q₂ = −Δ/(q₁ + q₂), and expanding in the
// same way n₂² q₁ − n₁² q₂ = n₁² Δ (n₂² cos² θ₁ − s²)/(n₂² q₁ + n₁² q₂), s = n₁ sin θ₁.

/// The two shares from the two powers. Their sum stands in for |a + b|², so that no rounding makes or loses light.
fn shares(reflected: f64, crossing: f64) -> (f64, f64) {
    let whole = reflected + crossing;
    (reflected / whole, crossing / whole)
}

fn dielectric(n1: f64, n2: f64, c: f64) -> PowerSp {
    let q1 = n1 * c;
    let q2_sq = normal_sq(n1, n2, q1);
    if q1 == 0.0 || q2_sq <= 0.0 {
        return PowerSp::TOTAL;
    }
    let q2 = q2_sq.sqrt();
    let (n1_sq, n2_sq) = (n1 * n1, n2 * n2);
    let s_sq = n1_sq * ((1.0 - c) * (1.0 + c));
    let difference = (n2 - n1) * (n2 + n1);
    let d_s = difference / (q1 + q2);
    let d_p = n1_sq * difference * (n2_sq * (c * c) - s_sq) / (n2_sq * q1 + n1_sq * q2);
    let four_q = 4.0 * q1 * q2;
    let (r_s, t_s) = shares(d_s * d_s, four_q);
    let (r_p, t_p) = shares(d_p * d_p, n1_sq * n2_sq * four_q);
    PowerSp { r_s, r_p, t_s, t_p, a_s: 0.0, a_p: 0.0 }
}

fn absorbing(n1: f64, n2: Complex, c: f64) -> PowerSp {
    let real = Complex::real;
    let q1 = n1 * c;
    if q1 == 0.0 {
        return PowerSp::TOTAL;
    }
    let q2 = normal_sq_complex(n1, n2, q1).sqrt();
    let (n1_sq, n2_sq) = (n1 * n1, n2.square());
    let s_sq = n1_sq * ((1.0 - c) * (1.0 + c));
    let difference = (n2 - real(n1)) * (n2 + real(n1));
    let d_s = difference / (real(q1) + q2);
    let d_p = difference * n1_sq * (n2_sq * (c * c) - real(s_sq)) / (n2_sq * q1 + q2 * n1_sq);
    // Re(n₂² q₂*) = Re q₂ (|q₂|² + s²), which rounding cannot turn negative.
    let four_q = 4.0 * q1 * q2.re;
    let (r_s, t_s) = shares(d_s.norm_sq(), four_q);
    let (r_p, t_p) = shares(d_p.norm_sq(), n1_sq * four_q * (q2.norm_sq() + s_sq));
    PowerSp { r_s, r_p, t_s, t_p, a_s: 0.0, a_p: 0.0 }
}

/// The direction of `d` (unit, direction of travel) after reflection at a face with unit normal `n`, as a unit vector.
pub fn reflect(d: DVec3, n: DVec3) -> DVec3 {
    (d - n * (2.0 * d.dot(n))).normalize()
}

/// The direction of `d` (unit, direction of travel) after refraction, as a unit vector; `None` in total internal
/// reflection.
///
/// `n` is the unit normal on the side the light comes from (d·n ≤ 0; a positive rounding error counts as grazing) and
/// `eta` = n₁/n₂. Close to the critical angle this and [`fresnel`] may round to different sides: a caller that has
/// chosen to transmit must treat `None` as reflection.
pub fn refract(d: DVec3, n: DVec3, eta: f64) -> Option<DVec3> {
    let c1 = (-d.dot(n)).max(0.0);
    let difference = (1.0 - eta) * (1.0 + eta);
    let c2_sq = difference + (eta * c1) * (eta * c1);
    // Written so that a NaN from a hostile index is refused too.
    if c2_sq.is_nan() || c2_sq < 0.0 {
        return None;
    }
    // d' = η d + (η c₁ − c₂) n; the bracket by its conjugate, since both terms agree when η is near 1.
    let sum = eta * c1 + c2_sq.sqrt();
    if sum == 0.0 {
        return Some(d); // along the face between equal media
    }
    (d * eta - n * (difference / sum)).try_normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn unit() -> impl Strategy<Value = DVec3> {
        (-1.0..1.0f64, 0.0..std::f64::consts::TAU).prop_map(|(z, phi)| {
            let r = (1.0 - z * z).sqrt();
            DVec3::new(r * phi.cos(), r * phi.sin(), z)
        })
    }

    proptest! {
        /// Snell's law as equality of the tangential momentum n d × n̂, and the way back.
        #[test]
        fn refraction_keeps_the_tangential_momentum(d in unit(), normal in unit(), n1 in 1.0..2.5f64, n2 in 1.0..2.5f64) {
            let n = if d.dot(normal) > 0.0 { -normal } else { normal };
            let c1 = -d.dot(n);
            match refract(d, n, n1 / n2) {
                Some(t) => {
                    prop_assert!((t.length() - 1.0).abs() < 4.0 * f64::EPSILON);
                    prop_assert!(t.dot(n) <= 0.0);
                    prop_assert!(((d * n1).cross(n) - (t * n2).cross(n)).length() < 4e-15);
                    // Not along the face on either side: there the cosine of one way or the other has lost its digits.
                    if t.dot(n) < -1e-2 && c1 > 1e-2 {
                        let back = refract(-t, -n, n2 / n1);
                        prop_assert!(back.is_some_and(|b| (b + d).length() < 1e-12));
                    }
                }
                None => prop_assert!(n1 * (1.0 - c1 * c1).sqrt() > n2 * (1.0 - 1e-12)),
            }
            let r = reflect(d, n);
            prop_assert!((r.dot(n) + d.dot(n)).abs() < 1e-15 && (r.cross(n) - d.cross(n)).length() < 2e-15);
            prop_assert!((r.length() - 1.0).abs() < 4.0 * f64::EPSILON);
        }

        /// Stokes: the same power from either side at conjugate angles; and a little absorption changes little.
        #[test]
        fn reciprocal_and_continuous_in_k(n1 in 1.0..2.5f64, n2 in 1.0..2.5f64, sin_max in 0.0..0.999f64) {
            let s = sin_max * n1.min(n2);
            let (c1, c2) = ((1.0 - (s / n1) * (s / n1)).sqrt(), (1.0 - (s / n2) * (s / n2)).sqrt());
            let there = fresnel(n1, Complex::real(n2), c1);
            let back = fresnel(n2, Complex::real(n1), c2);
            let lossy = fresnel(n1, Complex::new(n2, 1e-15), c1);
            for other in [back, lossy] {
                prop_assert!((there.r_s - other.r_s).abs() < 2e-13 && (there.r_p - other.r_p).abs() < 2e-13);
                prop_assert!((there.t_s - other.t_s).abs() < 2e-13 && (there.t_p - other.t_p).abs() < 2e-13);
            }
        }

        /// Nothing is made or lost, in glass and in metal, at any ratio of the indices.
        #[test]
        fn an_interface_does_not_absorb(n1 in 1.0..2.5f64, n in 0.05..4.0f64, k in 0.0..8.0f64, c in 0.0..1.0f64) {
            let exact = 2.0 * f64::EPSILON;
            for n2 in [Complex::new(n, k), Complex::new(n, k * 1e-12), Complex::real(n)] {
                let f = fresnel(n1, n2, c);
                prop_assert!((f.r_s + f.t_s - 1.0).abs() <= exact && (f.r_p + f.t_p - 1.0).abs() <= exact, "{f:?}");
                prop_assert!(f.t_s >= 0.0 && f.t_p >= 0.0 && f.absorptance() <= exact);
            }
        }

        /// Against the amplitudes as the textbook has them (no factoring), where those do not cancel.
        #[test]
        fn textbook_amplitudes(n1 in 1.0..2.5f64, n in 0.05..4.0f64, k in 0.0..8.0f64, c in 0.0..1.0f64) {
            let (n2, q1) = (Complex::new(n, k), Complex::real(n1 * c));
            let n2_sq = n2 * n2;
            let q2 = (n2_sq - Complex::real(n1 * n1 * (1.0 - c * c))).sqrt();
            let r_s = (q1 - q2) / (q1 + q2);
            let r_p = (n2_sq * q1 - q2 * (n1 * n1)) / (n2_sq * q1 + q2 * (n1 * n1));
            let f = fresnel(n1, n2, c);
            prop_assume!(q2.norm_sq() > 1e-2);
            prop_assert!((f.r_s - r_s.norm_sq()).abs() < 1e-12 && (f.r_p - r_p.norm_sq()).abs() < 1e-12);
        }
    }

    #[test]
    fn closed_forms() {
        // Normal incidence ((n−1)/(n+1))², Brewster's angle, and the deviation of a prism face by hand.
        let glass = fresnel(1.0, Complex::real(1.5), 1.0);
        assert!((glass.reflectance() - 0.04).abs() < 1e-16 && (glass.transmittance() - 0.96).abs() < 1e-15);
        let brewster = fresnel(1.0, Complex::real(1.5), 1.0 / (1.0 + 1.5f64 * 1.5).sqrt());
        assert!(brewster.r_p < 1e-30 && brewster.t_p == 1.0);
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let t = refract(DVec3::new(half, 0.0, -half), DVec3::Z, 1.0 / 1.5).unwrap();
        assert!((t.x - half / 1.5).abs() < 1e-16 && (t.z + (1.0f64 - 0.5 / 2.25).sqrt()).abs() < 2e-16);
    }

    #[test]
    fn edges_do_not_lose_digits_or_panic() {
        // Along the face, between equal media, and with nearly equal indices: the shift is Δη tan θ to first order.
        assert_eq!(fresnel(1.5, Complex::real(1.5), 0.0), PowerSp::TOTAL);
        assert_eq!(fresnel(1.5, Complex::real(1.0), 0.5), PowerSp::TOTAL);
        assert_eq!(refract(DVec3::X, DVec3::Z, 1.0), Some(DVec3::X));
        assert_eq!(refract(DVec3::X, DVec3::Z, 1.5), None);
        let d = DVec3::new(0.6, 0.0, -0.8);
        let t = refract(d, DVec3::Z, 1.0 + 1e-12).unwrap();
        let shift = d.x * t.z - d.z * t.x; // sine of the angle turned
        let eta = (1.0f64 + 1e-12) - 1.0;
        assert!((shift / (eta * 0.75) - 1.0).abs() < 2e-4, "{shift:e}");
        // Grazing between nearly equal indices, at the angle where q₂² = 2 q₁²: R_s = ((√2 − 1)/(√2 + 1))² = (√2 − 1)⁴.
        let n2 = 1.0 + 1e-12;
        let e = n2 - 1.0; // exact
        let near = fresnel(1.0, Complex::real(n2), (e * (2.0 + e)).sqrt());
        assert!(
            (near.r_s - (2f64.sqrt() - 1.0).powi(4)).abs() < 1e-15 && (near.r_p - near.r_s).abs() < 1e-11,
            "{near:?}"
        );
        for bad in [f64::NAN, f64::INFINITY, 0.0, -1.0] {
            let _ = (
                fresnel(bad, Complex::new(1.5, bad), bad),
                refract(d, DVec3::Z, bad),
                refract(DVec3::NAN, DVec3::Z, bad),
            );
        }
    }
}
