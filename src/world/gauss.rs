//! The Gaussian lobe of a diffuser, and the cosᵐ lobe beside it: normalisation, sampling, albedo
//! (`design/formulas.md` section 10), and what becomes of the light that would be lost beyond the horizon.

use super::cdf::Cdf;
use eyebox_base::warp::{Frame, cos_n_hemisphere};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// `C exp(−t²/2σ²)` about an axis, t the angle to the axis in radians, normalised to 1 over the whole sphere
/// (for small σ, C = 1/(2πσ²(1 − σ²/3))); or `C cosᵐ t` up to 90°, C = (m + 2)/2π, so that all of what falls straight on
/// leaves.
#[derive(Debug, Clone, PartialEq)]
pub struct GaussLobe {
    /// rad; of cosᵐ that of the Gaussian with its curvature, 1/√m.
    sigma: f64,
    /// m, if it is cosᵐ.
    exponent: Option<f64>,
    /// C, 1/sr.
    norm: f64,
    /// The same factor of the sampled lobe, which is Gaussian in the chord 2 sin(t/2).
    sampling_norm: f64,
    /// Angle of incidence in [0, π/2] against the share of the lobe that leaves, for piecewise linear interpolation.
    albedo: Vec<(f64, f64)>,
    rest: Rest,
}

/// What the lobe with its falloff does not send on, 1 − albedo = m(μ), spread so that nothing is lost and light may run either way: the
/// distribution m(μi) m(μo)/(π M), M the mean of m over 2μ dμ (C. Kulla, A. Conty, "Revisiting Physically Based Shading at Imageworks",
/// SIGGRAPH 2017).
#[derive(Debug, Clone, PartialEq, Default)]
struct Rest {
    /// M.
    mean: f64,
    /// How much of M lies between the angles of the table; within a step directions are drawn evenly in μ². None: nothing is lost.
    steps: Option<Cdf>,
}

impl GaussLobe {
    /// None unless `sigma_rad` is positive and C is finite.
    pub fn new(sigma_rad: f64) -> Option<Self> {
        if !(sigma_rad > 0.0 && sigma_rad.is_finite()) {
            return None;
        }
        let mass = integrate(7.0 * sigma_rad, sigma_rad, &[], |t| gaussian(t, sigma_rad) * t.sin());
        let norm = 1.0 / (TAU * mass);
        let sampling_norm = 1.0 / (TAU * sigma_rad * sigma_rad * -f64::exp_m1(-2.0 / (sigma_rad * sigma_rad)));
        if !(norm.is_finite() && sampling_norm.is_finite()) {
            return None;
        }
        let mut lobe = GaussLobe {
            sigma: sigma_rad,
            exponent: None,
            norm,
            sampling_norm,
            albedo: Vec::new(),
            rest: Rest::default(),
        };
        lobe.albedo = lobe.tabulate();
        lobe.rest = Rest::of(&lobe.albedo);
        Some(lobe)
    }

    /// cosᵐ; none unless m is from 0 to 1e8.
    pub fn cosine(m: f64) -> Option<Self> {
        if !(0.0..=1e8).contains(&m) {
            return None;
        }
        let (norm, sampling_norm) = ((m + 2.0) / TAU, (m + 1.0) / TAU);
        let sigma = 1.0 / m.max(1.0).sqrt();
        let mut lobe =
            GaussLobe { sigma, exponent: Some(m), norm, sampling_norm, albedo: Vec::new(), rest: Rest::default() };
        lobe.albedo = lobe.tabulate();
        lobe.rest = Rest::of(&lobe.albedo);
        Some(lobe)
    }

    /// The lobe without its factor, at the angle t.
    fn shape(&self, t: f64) -> f64 {
        match self.exponent {
            None => gaussian(t, self.sigma),
            Some(m) => cosine(t, m),
        }
    }

    pub fn sigma_rad(&self) -> f64 {
        self.sigma
    }
    /// C, 1/sr.
    pub fn norm(&self) -> f64 {
        self.norm
    }

    /// The lobe at a unit direction, 1/sr.
    pub fn value(&self, axis: DVec3, dir: DVec3) -> f64 {
        match self.exponent {
            None => self.norm * (-0.5 * squared_angle(axis, dir) / (self.sigma * self.sigma)).exp(),
            Some(m) => self.norm * cosine(angle(axis, dir), m),
        }
    }
    /// Density with which [`GaussLobe::sample`] chooses a unit direction, 1/sr.
    pub fn pdf(&self, axis: DVec3, dir: DVec3) -> f64 {
        match self.exponent {
            None => self.sampling_norm * gaussian((dir - axis).length(), self.sigma),
            Some(m) => self.sampling_norm * cosine(angle(axis, dir), m),
        }
    }
    /// A direction near the axis, by [`GaussLobe::pdf`].
    ///
    /// The chord c = 2 sin(t/2) has dω = c dc dφ, so a lobe Gaussian in c inverts in closed form over the whole sphere
    /// (R. Fisher's spherical distribution of 1953, sampled as by G. Ulrich 1984); its ratio to the lobe Gaussian in t
    /// is bounded (1.19 at 60°), and no random number is thrown away.
    pub fn sample(&self, axis: DVec3, [a, b]: [f64; 2]) -> DVec3 {
        if let Some(m) = self.exponent {
            let local = cos_n_hemisphere([a, b], m);
            return Frame::about(axis).to_world(local).normalize();
        }
        let s2 = self.sigma * self.sigma;
        let chord2 = (-2.0 * s2 * f64::ln_1p(a * f64::exp_m1(-2.0 / s2))).clamp(0.0, 4.0);
        let sin = (chord2 * (1.0 - chord2 / 4.0)).max(0.0).sqrt();
        let phi = TAU * b;
        let local = DVec3::new(sin * phi.cos(), sin * phi.sin(), 1.0 - chord2 / 2.0);
        Frame::about(axis).to_world(local).normalize()
    }

    /// The share of a unit lobe that leaves in its own half space at incidence `cos_in`, with the lobe's falloff
    /// cos_o/max(cos_i, cos_o). Interpolated to about 2e-5.
    pub fn albedo(&self, cos_in: f64) -> f64 {
        let theta = cos_in.clamp(0.0, 1.0).acos();
        let [(x0, y0), (x1, y1)] = self.around(theta).1;
        y0 + (y1 - y0) * ((theta - x0) / (x1 - x0)).clamp(0.0, 1.0)
    }

    /// The step of the table that an angle lies in, and its ends.
    fn around(&self, theta: f64) -> (usize, [(f64, f64); 2]) {
        let above = self.albedo.partition_point(|&(x, _)| x <= theta).clamp(1, self.albedo.len() - 1);
        (above - 1, [self.albedo[above - 1], self.albedo[above]])
    }

    /// m: the share that the lobe does not send on at this cosine of incidence; `rest_*` send it.
    pub fn lost(&self, cos: f64) -> f64 {
        (1.0 - self.albedo(cos.abs())).max(0.0)
    }

    /// The rest of the light at these shares that the lobe loses, 1/sr.
    pub fn rest(&self, [lost_in, lost_out]: [f64; 2]) -> f64 {
        if self.rest.mean > 0.0 { lost_in * lost_out / (PI * self.rest.mean) } else { 0.0 }
    }

    /// Density with which [`GaussLobe::sample_rest`] chooses a direction under this cosine on its side, 1/sr.
    pub fn rest_pdf(&self, cos: f64) -> f64 {
        let Some(steps) = &self.rest.steps else { return 0.0 };
        let mu = cos.abs().min(1.0);
        let (step, [(near, _), (far, _)]) = self.around(mu.acos());
        let width = near.cos().powi(2) - far.cos().powi(2);
        if width > 0.0 { steps.probability(step) / width * mu / PI } else { 0.0 }
    }

    /// A direction of the rest, z > 0. None if there is none.
    pub fn sample_rest(&self, [a, b]: [f64; 2]) -> Option<DVec3> {
        let (step, part) = self.rest.steps.as_ref()?.sample(a);
        let [near, far] = [self.albedo[step], self.albedo[step + 1]].map(|(theta, _)| theta.cos().powi(2));
        let square = far + part * (near - far);
        let (sin, cos) = (TAU * b).sin_cos();
        let radius = (1.0 - square).max(0.0).sqrt();
        Some(DVec3::new(radius * cos, radius * sin, square.sqrt()))
    }
}

impl Rest {
    /// Of a table of albedos against angles.
    fn of(albedo: &[(f64, f64)]) -> Rest {
        // ∫ (p + qθ) sin 2θ dθ, m a line within a step.
        let steps = albedo.windows(2).map(|ends| {
            let [(x0, y0), (x1, y1)] = [ends[0], ends[1]].map(|(theta, albedo)| (theta, (1.0 - albedo).max(0.0)));
            if x1 <= x0 {
                return 0.0;
            }
            let q = (y1 - y0) / (x1 - x0);
            let primitive = |x: f64, y: f64| 0.25 * q * (2.0 * x).sin() - 0.5 * y * (2.0 * x).cos();
            (primitive(x1, y1) - primitive(x0, y0)).max(0.0)
        });
        match Cdf::new(steps.collect::<Vec<_>>()) {
            Some(steps) => Rest { mean: steps.total(), steps: Some(steps) },
            None => Rest::default(),
        }
    }
}

/// cosᵐ t, 0 beyond 90°; by way of sin² t, whose digits are all there where t is small and m large.
fn cosine(t: f64, m: f64) -> f64 {
    if t >= FRAC_PI_2 {
        return 0.0;
    }
    let sin = t.sin();
    (0.5 * m * f64::ln_1p(-sin * sin)).exp()
}

fn gaussian(t: f64, sigma: f64) -> f64 {
    let q = t / sigma;
    (-0.5 * q * q).exp()
}

/// Angle between unit vectors, exact for small angles where a dot product has no digits left.
fn angle(a: DVec3, b: DVec3) -> f64 {
    chord_to_angle((a - b).length())
}

/// Its square. Near the axis, where a lobe has nearly all of its light, by the series of the arc sine's square,
/// t² = Σ 2 c²ⁿ/(n² C(2n, n)), c the chord, without a root.
fn squared_angle(a: DVec3, b: DVec3) -> f64 {
    /// c² below which the terms left out are less than the rounding.
    const NEAR: f64 = 0.08;
    const TERMS: [f64; 8] = [1.0, 12.0, 90.0, 560.0, 3150.0, 16632.0, 84084.0, 411_840.0];
    let chord2 = (a - b).length_squared();
    if chord2 < NEAR {
        return chord2 * TERMS.iter().rev().fold(0.0, |sum, of| sum * chord2 + 1.0 / of);
    }
    let t = chord_to_angle(chord2.sqrt());
    t * t
}

fn chord_to_angle(chord: f64) -> f64 {
    2.0 * (0.5 * chord).min(1.0).asin()
}

/// Share of a unit lobe that leaves, by quadrature over t; the azimuth φ about the axis is done in closed form:
/// cos_o = a + b cos φ with a = cos θ cos t, b = sin θ sin t, and the integrand is min(1, cos_o/cos θ) where cos_o > 0.
fn albedo_by_quadrature(lobe: &GaussLobe, theta: f64) -> f64 {
    let (sin, mu) = theta.sin_cos();
    let ring = |t: f64| {
        let (a, b) = (mu * t.cos(), sin * t.sin());
        let azimuth = |x: f64| if b > 0.0 { (x / b).clamp(-1.0, 1.0).acos() } else { if x > 0.0 { 0.0 } else { PI } };
        let horizon = azimuth(-a);
        // At grazing incidence cos_o exceeds cos θ wherever it is positive.
        if mu < 1e-9 {
            return horizon / PI;
        }
        let full = azimuth(mu - a).min(horizon);
        (full + (a * (horizon - full) + b * (horizon.sin() - full.sin())) / mu) / PI
    };
    // Where the rings begin and cease to cut the horizon and the cone cos_o = cos θ.
    let breaks = [FRAC_PI_2 - theta, FRAC_PI_2 + theta, 2.0 * theta];
    let end = if lobe.exponent.is_some() { FRAC_PI_2.min(10.0 * lobe.sigma) } else { 7.0 * lobe.sigma };
    TAU * lobe.norm * integrate(end, lobe.sigma, &breaks, |t| lobe.shape(t) * t.sin() * ring(t))
}

/// ∫ f over t from 0 to `end` (7σ, where a Gaussian is 2e-11) or π. Panels end at `breaks`, where f may have the square-root
/// kinks of an arc cosine: x ↦ (1 − cos πx)/2 smooths them before Gauss–Legendre's rule.
fn integrate(end: f64, sigma: f64, breaks: &[f64], f: impl Fn(f64) -> f64) -> f64 {
    let end = end.min(PI);
    let mut edges: Vec<f64> = breaks.iter().copied().filter(|t| *t > 0.0 && *t < end).chain([0.0, end]).collect();
    edges.sort_by(f64::total_cmp);
    let mut sum = 0.0;
    for pair in edges.windows(2) {
        let pieces = ((pair[1] - pair[0]) / sigma).ceil().clamp(1.0, 10.0);
        let width = (pair[1] - pair[0]) / pieces;
        for piece in 0..pieces as usize {
            let start = pair[0] + width * piece as f64;
            for (x, weight) in LEGENDRE.iter().flat_map(|&(x, w)| [(0.5 - 0.5 * x, w), (0.5 + 0.5 * x, w)]) {
                let t = start + width * 0.5 * (1.0 - (PI * x).cos());
                sum += f(t) * 0.5 * weight * width * FRAC_PI_2 * (PI * x).sin();
            }
        }
    }
    sum
}

/// Positive nodes and weights of the 12-point Gauss–Legendre rule on [−1, 1] (Abramowitz & Stegun, table 25.4).
const LEGENDRE: [(f64, f64); 6] = [
    (0.125_233_408_511_468_9, 0.249_147_045_813_402_8),
    (0.367_831_498_998_180_2, 0.233_492_536_538_354_8),
    (0.587_317_954_286_617_4, 0.203_167_426_723_065_92),
    (0.769_902_674_194_304_7, 0.160_078_328_543_346_23),
    (0.904_117_256_370_474_9, 0.106_939_325_995_318_43),
    (0.981_560_634_246_719_3, 0.047_175_336_386_511_83),
];

impl GaussLobe {
    /// Albedo against the angle of incidence: intervals are halved until the middle lies on the chord to 1e-5.
    fn tabulate(&self) -> Vec<(f64, f64)> {
        let sigma = self.sigma;
        let at = |theta: f64| (theta, albedo_by_quadrature(self, theta));
        // The albedo varies on the scale of σ at both ends; start fine enough there to see it.
        let mut start = vec![0.0, FRAC_PI_2 / 2.0, FRAC_PI_2];
        let mut step = FRAC_PI_2 / 4.0;
        while step > sigma / 4.0 && start.len() < 80 {
            start.extend([step, FRAC_PI_2 - step]);
            step *= 0.5;
        }
        start.sort_by(f64::total_cmp);
        let mut table = vec![at(0.0)];
        let mut todo: Vec<(f64, f64)> = start.into_iter().skip(1).rev().map(at).collect();
        let mut depth_left = 100_000; // a bound on work, far above the few hundred intervals that are needed
        while let (Some(&(x0, y0)), Some(&(x1, y1))) = (table.last(), todo.last()) {
            let middle = at(0.5 * (x0 + x1));
            let bent = (middle.1 - 0.5 * (y0 + y1)).abs() > 1e-5 * middle.1;
            if bent && depth_left > 0 && middle.0 > x0 && middle.0 < x1 {
                depth_left -= 1;
                todo.push(middle);
            } else {
                table.push(middle);
                table.push((x1, y1));
                todo.pop();
            }
        }
        table
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn norm_is_the_series_for_small_sigma_and_exact_for_large() {
        for sigma in [1e-6, 1e-3, 0.02] {
            let series = 1.0 / (TAU * sigma * sigma * (1.0 - sigma * sigma / 3.0));
            let lobe = GaussLobe::new(sigma).unwrap();
            // The next term of the series is σ⁴/15.
            assert!(
                (lobe.norm() / series - 1.0).abs() < sigma.powi(4) / 10.0 + 1e-10,
                "{sigma}: {}",
                lobe.norm() / series - 1.0
            );
        }
        for sigma in [0.3, 1.0, 3.0] {
            let n = 200_000;
            let sum: f64 = (0..n).map(|k| PI * (k as f64 + 0.5) / n as f64).map(|t| gaussian(t, sigma) * t.sin()).sum();
            let want = 1.0 / (TAU * sum * PI / n as f64);
            assert!((GaussLobe::new(sigma).unwrap().norm() / want - 1.0).abs() < 1e-9, "{sigma}");
        }
        for sigma in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-200] {
            assert_eq!(GaussLobe::new(sigma), None, "{sigma}");
        }
    }

    /// By a plain sum over the hemisphere of leaving directions, which shares nothing with the table's integrals.
    #[test]
    fn albedo_table_matches_a_plain_sum() {
        for sigma in [0.1f64, 0.35, 1.0] {
            let lobe = GaussLobe::new(sigma).unwrap();
            for theta_deg in [0.0f64, 3.0, 20.0, 45.0, 70.0, 85.0, 89.0] {
                let (sin, mu) = theta_deg.to_radians().sin_cos();
                let axis = DVec3::new(sin, 0.0, mu);
                let (rings, sectors, mut sum, mut rest) = (1500, 800, 0.0, 0.0);
                let lost = lobe.lost(mu);
                for ring in 0..rings {
                    let (radius, cos) = (FRAC_PI_2 * (ring as f64 + 0.5) / rings as f64).sin_cos();
                    rest += lobe.rest([lost, lobe.lost(cos)]) * cos * radius * sectors as f64;
                    for sector in 0..sectors {
                        let phi = PI * (sector as f64 + 0.5) / sectors as f64;
                        let dir = DVec3::new(radius * phi.cos(), radius * phi.sin(), cos);
                        sum += lobe.value(axis, dir) * cos / cos.max(mu) * radius;
                    }
                }
                let want = sum * FRAC_PI_2 * TAU / (rings * sectors) as f64;
                let got = lobe.albedo(mu);
                assert!((got / want - 1.0).abs() < 1e-4, "σ {sigma} θ {theta_deg}: {got} {want}");
                // A white furnace: nothing is lost.
                let all = (sum + rest) * FRAC_PI_2 * TAU / (rings * sectors) as f64;
                assert!((all - 1.0).abs() < 2e-4, "σ {sigma} θ {theta_deg}: {all} with the rest");
            }
            assert!((lobe.albedo(0.0) - 0.5).abs() < 1e-6, "at grazing incidence half of the lobe leaves");
        }
    }

    #[test]
    fn interpolation_and_size_of_the_table() {
        for sigma_deg in [1e-3f64, 0.1, 1.0, 6.0, 20.0, 60.0, 500.0] {
            let sigma = sigma_deg.to_radians();
            let lobe = GaussLobe::new(sigma).unwrap();
            for k in 0..=500 {
                let x = k as f64 / 500.0;
                for theta in [FRAC_PI_2 * x, (FRAC_PI_2 - sigma * 5.0 * x).max(0.0), (sigma * 5.0 * x).min(FRAC_PI_2)] {
                    let want = albedo_by_quadrature(&lobe, theta);
                    let got = lobe.albedo(theta.cos());
                    assert!((got / want - 1.0).abs() < 5e-5, "σ {sigma_deg}° θ {theta}: {got} {want}");
                }
            }
            assert!(lobe.albedo.len() < 3000, "σ {sigma_deg}°: {} entries", lobe.albedo.len());
        }
    }
}
