//! Coherent thin-film stacks: the admittance (transfer-matrix) method, per polarisation, per ray.
//!
//! With q_j = √(n_j² − s²), s = n₀ sin θ₀ and δ_j = q_j k₀ d_j, a layer maps the fields (B, C) of the side away from
//! the light to the side of the light (Abelès; formula sheet, section 2):
//! B' = cos δ B − i (sin δ/η) C and C' = cos δ C − i η sin δ B, with η = q (s) or n²/q (p).
//! Both entries are built from S = (sin δ)/q, which stays finite where a film is at its own critical angle (q = 0), and
//! everything is kept with the factor exp(Im δ) taken out, so that a thick absorber can underflow but not overflow.

use super::fresnel::{PowerSp, fresnel, fresnel_turning, normal_sq, normal_sq_complex};
use super::stokes::Turning;
use eyebox_base::Complex;

/// One layer: index n + ik (k ≥ 0, not zero) at the wavelength in use, thickness in nm (≥ 0).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Film {
    pub n: Complex,
    pub thickness_nm: f64,
}

/// Power reflected and transmitted by `films` between `n_in` (lossless) and `n_out`.
///
/// `films` are in the order in which the light meets them. `cos_i` 0..1 is the cosine of incidence in `n_in`, the
/// wavelength that in vacuum. Transmitted is the power that crosses into `n_out`; absorbed by the films is the rest.
/// Lossless films before a lossless `n_out` beyond its critical angle reflect all and transmit exactly 0. No films, or
/// only films of zero thickness, are the bare interface. Allocates nothing; a non-finite input gives NaN, never a panic.
pub fn stack(n_in: f64, films: &[Film], n_out: Complex, cos_i: f64, wavelength_nm: f64) -> PowerSp {
    if films.iter().all(|film| film.thickness_nm == 0.0) {
        return fresnel(n_in, n_out, cos_i);
    }
    solve::<false>(n_in, films, n_out, cos_i, wavelength_nm).power
}

/// [`stack`] with the phases between s and p.
pub fn stack_turning(n_in: f64, films: &[Film], n_out: Complex, cos_i: f64, wavelength_nm: f64) -> Turning {
    if films.iter().all(|film| film.thickness_nm == 0.0) {
        return fresnel_turning(n_in, n_out, cos_i);
    }
    solve::<true>(n_in, films, n_out, cos_i, wavelength_nm)
}

fn solve<const PHASES: bool>(n_in: f64, films: &[Film], n_out: Complex, cos_i: f64, wavelength_nm: f64) -> Turning {
    let c = cos_i.clamp(0.0, 1.0);
    let q_in = n_in * c;
    if q_in == 0.0 {
        return Turning::GRAZING;
    }
    let q_out = normal_sq_complex(n_in, n_out, q_in).sqrt();
    let k0 = std::f64::consts::TAU / wavelength_nm;
    // The p fields carry a factor q_out, so that n²/q needs no division where q_out = 0.
    let mut s = Fields { b: Complex::ONE, c: q_out, absorbed: 0.0, log_scale: 0.0 };
    let mut p = Fields { b: q_out, c: n_out.square(), absorbed: 0.0, log_scale: 0.0 };
    for film in films.iter().rev() {
        let k0_d = k0 * film.thickness_nm;
        if film.n.im == 0.0 {
            let (n_sq, q_sq) = (film.n.re * film.n.re, normal_sq(n_in, film.n.re, q_in));
            let (cos, sinc, log) = clear_layer(q_sq, k0_d);
            s.cross_clear(cos, sinc, q_sq * sinc, log);
            p.cross_clear(cos, q_sq * sinc / n_sq, n_sq * sinc, log);
        } else {
            let (n_sq, q_sq) = (film.n.square(), normal_sq_complex(n_in, film.n, q_in));
            let (cos, sinc, log) = absorbing_layer(q_sq, k0_d);
            s.cross(cos, sinc, q_sq * sinc, log);
            p.cross(cos, q_sq * sinc / n_sq, n_sq * sinc, log);
        }
    }
    // η of the near side: q (s), n²/q (p, multiplied through by q). Flux into n_out: Re q (s), Re(n² q*) =
    // Re q (|q|² + s²) (p, with the factor |q|² of the fields).
    let n_in_sq = n_in * n_in;
    let sin_sq = n_in_sq * ((1.0 - c) * (1.0 + c));
    let (r_s, t_s, a_s) = s.power(q_in, 1.0, q_out.re);
    let (r_p, t_p, a_p) = p.power(n_in_sq, q_in, q_out.re * (q_out.norm_sq() + sin_sq));
    let power = PowerSp { r_s, r_p, t_s, t_p, a_s, a_p };
    if !PHASES {
        return Turning { power, reflected: Complex::ZERO, transmitted: Complex::ZERO };
    }
    // The field that runs back has the opposite sign of E in p, by the convention of the bare interface: its axis turns
    // with the ray.
    let (back_s, whole_s) = s.amplitudes(q_in, 1.0);
    let (back_p, whole_p) = p.amplitudes(n_in_sq, q_in);
    Turning {
        power,
        reflected: (-(back_s * whole_s.conj()) * (back_p * whole_p.conj()).conj()).phase(),
        transmitted: (whole_s.conj() * whole_p * q_out.conj()).phase(),
    }
}

/// cos δ, sin δ/q and the power of e taken out of both, for real n² (so real q², of either sign).
fn clear_layer(q_sq: f64, k0_d: f64) -> (f64, f64, f64) {
    if q_sq > 0.0 {
        let q = q_sq.sqrt();
        let (sin, cos) = (q * k0_d).sin_cos();
        (cos, sin / q, 0.0)
    } else if q_sq < 0.0 {
        let kappa = (-q_sq).sqrt();
        let growth = kappa * k0_d;
        let half = -(-2.0 * growth).exp_m1() / 2.0; // e^-x sinh x, with all digits for thin gaps
        (1.0 - half, half / kappa, growth)
    } else {
        (1.0, k0_d, 0.0)
    }
}

/// The same for an absorbing film. δ = a + ib: e^-b cos δ = h cos a − i l sin a, e^-b sin δ = h sin a + i l cos a with
/// h, l = (1 ± e^-2b)/2.
fn absorbing_layer(q_sq: Complex, k0_d: f64) -> (Complex, Complex, f64) {
    let q = q_sq.sqrt();
    let delta = q * k0_d;
    let (sin, cos) = delta.re.sin_cos();
    let low = -(-2.0 * delta.im).exp_m1() / 2.0;
    let high = 1.0 - low;
    (Complex::new(high * cos, -low * sin), Complex::new(high * sin, low * cos) / q, delta.im)
}

/// The tangential fields of one polarisation; the true ones are these times exp(`log_scale`).
struct Fields {
    b: Complex,
    c: Complex,
    /// Flux that the absorbing films crossed so far have taken, film by film: what runs into each less what leaves it.
    /// Lossless films add nothing here, so that R + T + A = 1 checks their matrices. Times exp(2 `log_scale`).
    absorbed: f64,
    log_scale: f64,
}

impl Fields {
    fn cross(&mut self, cos: Complex, down: Complex, up: Complex, log: f64) {
        let minus_i = |z: Complex| Complex::new(z.im, -z.re);
        let (b, c) = (self.b, self.c);
        let leaving = flux(b, c) * (-2.0 * log).exp();
        self.b = cos * b + minus_i(down * c);
        self.c = cos * c + minus_i(up * b);
        self.rescale(log, |entering| entering - leaving);
    }

    /// [`Fields::cross`] for a lossless film, whose matrix is real on the diagonal and imaginary off it. Real B with
    /// imaginary C stays so exactly, which is why total reflection comes out as exactly 1.
    fn cross_clear(&mut self, cos: f64, down: f64, up: f64, log: f64) {
        let (b, c) = (self.b, self.c);
        self.b = Complex::new(cos * b.re + down * c.im, cos * b.im - down * c.re);
        self.c = Complex::new(cos * c.re + up * b.im, cos * c.im - up * b.re);
        self.rescale(log, |_| 0.0);
    }

    /// Hundreds of mirror pairs multiply the fields by thousands of decades: fold a power of two into the exponent.
    fn rescale(&mut self, log: f64, taken: impl Fn(f64) -> f64) {
        self.log_scale += log;
        if log != 0.0 {
            self.absorbed *= (-2.0 * log).exp();
        }
        self.absorbed += taken(flux(self.b, self.c));
        if self.b.norm_sq() + self.c.norm_sq() > 1e120 {
            let down = 2f64.powi(-200);
            (self.b, self.c) = (self.b * down, self.c * down);
            self.absorbed *= down * down;
            self.log_scale += 200.0 * std::f64::consts::LN_2;
        }
    }

    /// Reflected, transmitted and absorbed share for a near-side admittance `num/den` and a flux `out` carried by the start fields.
    fn power(&self, num: f64, den: f64, out: f64) -> (f64, f64, f64) {
        let (a, b) = (self.b * num, self.c * den);
        let whole = (a + b).norm_sq();
        // Most films take nothing out.
        let scale = if self.log_scale == 0.0 { 1.0 } else { (-2.0 * self.log_scale).exp() };
        let transmitted = 4.0 * num * den * out / whole * scale;
        ((a - b).norm_sq() / whole, transmitted, 4.0 * num * den * self.absorbed / whole)
    }

    /// Phases of the light that runs back and of the light that arrives, as unit numbers.
    fn amplitudes(&self, num: f64, den: f64) -> (Complex, Complex) {
        let (a, b) = (self.b * num, self.c * den);
        ((a - b).phase(), (a + b).phase())
    }
}

/// Re(B C*): the power that runs through a plane where the tangential fields are B and C.
fn flux(b: Complex, c: Complex) -> f64 {
    b.re * c.re + b.im * c.im
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const GLASS: Complex = Complex::real(1.52);

    fn film(n: f64, k: f64, thickness_nm: f64) -> Film {
        Film { n: Complex::new(n, k), thickness_nm }
    }

    fn near(a: PowerSp, b: PowerSp, tolerance: f64) -> bool {
        [a.r_s - b.r_s, a.r_p - b.r_p, a.t_s - b.t_s, a.t_p - b.t_p].iter().all(|d| d.abs() <= tolerance)
    }

    #[test]
    fn no_film_is_the_bare_interface() {
        for c in [1.0, 0.7, 0.01, 0.0] {
            let bare = fresnel(1.0, GLASS, c);
            assert_eq!(stack(1.0, &[], GLASS, c, 550.0), bare);
            assert_eq!(stack(1.0, &[film(2.0, 0.0, 0.0), film(0.1, 3.0, 0.0)], GLASS, c, 550.0), bare);
            // Films that are there but cannot be seen: index of either neighbour, or vanishing thickness.
            assert!(near(stack(1.0, &[film(1.52, 0.0, 137.0)], GLASS, c, 550.0), bare, 1e-14));
            assert!(near(stack(1.0, &[film(1.0, 0.0, 137.0)], GLASS, c, 550.0), bare, 1e-14));
            assert!(near(stack(1.0, &[film(2.0, 0.3, 1e-14)], GLASS, c, 550.0), bare, 1e-14));
        }
    }

    #[test]
    fn closed_forms() {
        // A quarter wave turns the substrate n_m into n²/n_m: R = ((n₀ n_m − n²)/(n₀ n_m + n²))²; n² = n₀ n_m kills it.
        let quarter = |n: f64| stack(1.0, &[film(n, 0.0, 550.0 / 4.0 / n)], GLASS, 1.0, 550.0).reflectance();
        assert!((quarter(1.38) - ((1.52 - 1.38f64 * 1.38) / (1.52 + 1.38f64 * 1.38)).powi(2)).abs() < 1e-15);
        assert!(quarter(1.52f64.sqrt()) < 1e-30);
        // A half wave is absent.
        let half = stack(1.0, &[film(2.35, 0.0, 550.0 / 2.0 / 2.35)], GLASS, 1.0, 550.0);
        assert!(near(half, fresnel(1.0, GLASS, 1.0), 1e-15));
    }

    #[test]
    fn total_reflection_is_exact_and_a_gap_leaks() {
        let c = 0.5; // 60 deg in glass
        for films in
            [vec![film(2.1, 0.0, 80.0)], vec![film(1.0, 0.0, 1e6)], vec![film(2.1, 0.0, 60.0), film(1.38, 0.0, 99.0)]]
        {
            let all = stack(1.52, &films, Complex::ONE, c, 550.0);
            assert_eq!((all.r_s, all.r_p, all.t_s, all.t_p), (1.0, 1.0, 0.0, 0.0));
        }
        let gap = stack(1.52, &[film(1.0, 0.0, 150.0)], GLASS, c, 550.0);
        assert!(gap.t_s > 0.01 && gap.r_s < 0.99);
        // A film exactly at its own critical angle: q = 0, the limit of its neighbours. n = n_in sin 60 deg, built
        // so that (n − n_in)(n + n_in) + q² is exactly zero: 5-12-13.
        let critical = |n: f64| stack(1.625, &[film(n, 0.0, 200.0)], Complex::real(1.625), 0.625 / 1.625, 550.0);
        assert!(near(critical(1.5), critical(1.5 * (1.0 + 1e-9)), 1e-7) && critical(1.5).t_s > 0.1);
    }

    #[test]
    fn extremes_stay_finite() {
        // 1 mm of absorber (e^2000), a 4000-layer mirror, both from either side.
        let thick = stack(1.0, &[film(1.5, 0.1, 1e6)], GLASS, 0.8, 550.0);
        assert!(near(thick, PowerSp { t_s: 0.0, t_p: 0.0, ..fresnel(1.0, Complex::new(1.5, 0.1), 0.8) }, 1e-15));
        assert!((thick.r_s + thick.a_s - 1.0).abs() < 1e-14 && (thick.r_p + thick.a_p - 1.0).abs() < 1e-14);
        let pair = [film(2.35, 0.0, 550.0 / 4.0 / 2.35), film(1.38, 0.0, 550.0 / 4.0 / 1.38)];
        let mirror: Vec<Film> = pair.iter().cycle().take(4000).copied().collect();
        let r = stack(1.0, &mirror, GLASS, 1.0, 550.0);
        assert!((r.r_s - 1.0).abs() < 1e-12 && r.t_s >= 0.0 && r.t_s < 1e-300, "{r:?}");
        for bad in [f64::NAN, f64::INFINITY, 0.0, -1.0] {
            let _ = stack(bad, &[film(bad, bad, bad), film(1.5, 0.0, bad)], Complex::real(bad), bad, bad);
        }
    }

    /// Films between 1.3 and 2.5, metals and absorbers between; thickness up to one wave.
    fn films(lossy: bool) -> impl Strategy<Value = Vec<Film>> {
        let clear = (1.3..2.5f64, 0.0..300.0f64).prop_map(|(n, d)| film(n, 0.0, d));
        let weak = (1.3..2.5f64, 1e-6..0.5f64, 0.0..300.0f64).prop_map(|(n, k, d)| film(n, k, d));
        let metal = (0.05..3.0f64, 1.0..7.0f64, 0.0..60.0f64).prop_map(|(n, k, d)| film(n, k, d));
        let any = if lossy { prop_oneof![clear, weak, metal].boxed() } else { clear.boxed() };
        prop::collection::vec(any, 0..12)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn lossless_stacks_keep_all_power(
            films in films(false), n_in in 1.0..1.6f64, n_out in 1.0..1.9f64, c in 0.0..1.0f64, wavelength in 380.0..780.0f64
        ) {
            let f = stack(n_in, &films, Complex::real(n_out), c, wavelength);
            prop_assert!((f.r_s + f.t_s - 1.0).abs() < 1e-12 && (f.r_p + f.t_p - 1.0).abs() < 1e-12, "{f:?}");
            prop_assert!(f.absorptance() < 1e-12 && f.t_s >= 0.0 && f.t_p >= 0.0);
        }

        /// T does not depend on the side, whatever the films absorb; R + T never exceeds 1.
        #[test]
        fn transmission_is_the_same_from_both_sides(
            films in films(true), n_in in 1.0..1.6f64, n_out in 1.0..1.9f64, sine in 0.0..0.99f64, wavelength in 380.0..780.0f64
        ) {
            let s = sine * n_in.min(n_out);
            let cosine = |n: f64| ((1.0 - s / n) * (1.0 + s / n)).sqrt();
            let reversed: Vec<Film> = films.iter().rev().copied().collect();
            let front = stack(n_in, &films, Complex::real(n_out), cosine(n_in), wavelength);
            let back = stack(n_out, &reversed, Complex::real(n_in), cosine(n_out), wavelength);
            prop_assert!((front.t_s - back.t_s).abs() < 1e-12 && (front.t_p - back.t_p).abs() < 1e-12);
            for f in [front, back] {
                prop_assert!(f.r_s + f.t_s < 1.0 + 1e-12 && f.r_p + f.t_p < 1.0 + 1e-12);
                prop_assert!((f.reflectance() + f.transmittance() + f.absorptance() - 1.0).abs() < 1e-12);
            }
        }

        /// Another method: the recursion of reflection amplitudes (Rouard 1937), from the substrate up; and the lossless
        /// path agrees with the absorbing one as k goes to zero.
        #[test]
        fn reflection_agrees_with_the_recursion(
            films in films(true), n_in in 1.0..1.6f64, n_out in 1.0..1.9f64, c in 0.05..1.0f64, wavelength in 380.0..780.0f64
        ) {
            let s_sq = (n_in * n_in) * (1.0 - c * c);
            let q = |n: Complex| (n * n - Complex::real(s_sq)).sqrt();
            let mut media = vec![(Complex::real(n_in), 0.0)];
            media.extend(films.iter().map(|f| (f.n, f.thickness_nm)));
            media.push((Complex::real(n_out), 0.0));
            let recursion = |p: bool| {
                let eta = |n: Complex| if p { n * n / q(n) } else { q(n) };
                let mut r = Complex::ZERO;
                for pair in media.windows(2).rev() {
                    let ((n1, _), (n2, d2)) = (pair[0], pair[1]);
                    let rho = (eta(n1) - eta(n2)) / (eta(n1) + eta(n2));
                    let phase = q(n2) * (2.0 * std::f64::consts::TAU * d2 / wavelength);
                    let z = Complex::new(phase.re.cos(), phase.re.sin()) * (-phase.im).exp();
                    r = (rho + r * z) / (Complex::ONE + rho * r * z);
                }
                r.norm_sq()
            };
            let f = stack(n_in, &films, Complex::real(n_out), c, wavelength);
            prop_assert!((f.r_s - recursion(false)).abs() < 1e-11, "s {} {}", f.r_s, recursion(false));
            prop_assert!((f.r_p - recursion(true)).abs() < 1e-11, "p {} {}", f.r_p, recursion(true));
            let tinted: Vec<Film> = films.iter().map(|f| Film { n: f.n + Complex::new(0.0, 1e-16), ..*f }).collect();
            prop_assert!(near(f, stack(n_in, &tinted, Complex::real(n_out), c, wavelength), 1e-11));
        }
    }
}
