//! The ABg (Harvey–Shack) law of smooth-surface scatter: A/(B + |β − β₀|^g) per steradian, β and β₀ being the directions
//! of the scattered and of the specular ray projected on the face (see e.g. Stover, "Optical Scattering", ch. 4, and
//! Harvey, "Light-scattering characteristics of optical surfaces", 1976).

use std::f64::consts::PI;

/// The law; A ≥ 0, B > 0, g ≥ 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AbgLaw {
    pub a: f64,
    pub b: f64,
    pub g: f64,
}

impl AbgLaw {
    /// None unless it is finite and positive where it should be.
    pub fn new([a, b, g]: [f64; 3]) -> Option<Self> {
        let law = AbgLaw { a, b, g };
        let sound = a >= 0.0 && b > 0.0 && g >= 0.0 && [a, b, g, a / b].iter().all(|x| x.is_finite());
        sound.then_some(law)
    }

    /// 1/sr at the distance `r` of the projected directions.
    pub fn value(&self, r: f64) -> f64 {
        self.a / (self.b + r.powf(self.g))
    }

    /// Where the denominator has doubled.
    pub fn knee(&self) -> f64 {
        if self.g > 0.0 { self.b.powf(1.0 / self.g) } else { f64::INFINITY }
    }

    /// Radii from 0 to 2 (directions differ by no more), between which the law hardly changes.
    pub fn radii(&self) -> Vec<f64> {
        const MOST: usize = 480;
        const LEAST: f64 = 1e-12;
        let knee = self.knee().clamp(LEAST, 2.0);
        // Inside a tenth of the knee it is flat if g is 1 or more; for a smaller g it never is quite, and rises slowly.
        let first = (0.02 * knee).max(LEAST);
        let steps = ((2.0 / first).ln() / 0.06).ceil().clamp(1.0, MOST as f64) as usize;
        let step = (2.0 / first).ln() / steps as f64;
        std::iter::once(0.0).chain((0..=steps).map(|k| (first.ln() + step * k as f64).exp().min(2.0))).collect()
    }

    /// Share of light at β₀ (0 straight on, 1 along the face) that is scattered: ∫ value over the unit disk of β, since
    /// cos θ dω = d²β; by rings about β₀, of which the part inside is an arc cosine.
    pub fn total(&self, beta0: f64) -> f64 {
        let edges = self.radii();
        let mut cuts = vec![1.0 - beta0, 1.0 + beta0];
        cuts.extend(edges.iter().copied().filter(|r| *r <= 1.0 + beta0));
        cuts.sort_by(f64::total_cmp);
        let ring = |r: f64| {
            let inside = if r + beta0 <= 1.0 {
                PI
            } else {
                ((beta0 * beta0 + r * r - 1.0) / (2.0 * beta0 * r)).clamp(-1.0, 1.0).acos()
            };
            2.0 * r * inside * self.value(r)
        };
        cuts.windows(2).map(|pair| between(pair[0], pair[1], ring)).sum()
    }
}

/// ∫ f by twice five points of Gauss and Legendre, spread towards both ends where an arc cosine may start with a square root.
fn between(from: f64, to: f64, f: impl Fn(f64) -> f64) -> f64 {
    const POINTS: [(f64, f64); 5] = [
        (0.046_910_077_030_668, 0.118_463_442_528_094_54),
        (0.230_765_344_947_158_45, 0.239_314_335_249_683_23),
        (0.5, 0.284_444_444_444_444_44),
        (0.769_234_655_052_841_5, 0.239_314_335_249_683_23),
        (0.953_089_922_969_332, 0.118_463_442_528_094_54),
    ];
    let mut sum = 0.0;
    for half in [0.0, 0.5] {
        for (x, w) in POINTS {
            let x = half + 0.5 * x;
            let (smooth, slope) = (0.5 * (1.0 - (PI * x).cos()), 0.5 * PI * (PI * x).sin());
            sum += f(from + (to - from) * smooth) * 0.5 * w * slope * (to - from);
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Straight on, g = 2: πA ln((1 + B)/B). Anywhere, g = 0: a Lambertian πA/(B + 1).
    #[test]
    fn totals_in_closed_form() {
        for b in [1e-8, 1e-4, 0.1, 3.0] {
            let law = AbgLaw::new([0.01, b, 2.0]).unwrap();
            let want = PI * 0.01 * f64::ln_1p(1.0 / b);
            assert!((law.total(0.0) / want - 1.0).abs() < 1e-7, "{b}: {} {want}", law.total(0.0));
            let flat = AbgLaw::new([0.1, b, 0.0]).unwrap();
            for beta0 in [0.0, 0.5, 0.99, 1.0] {
                assert!((flat.total(beta0) * (b + 1.0) / (0.1 * PI) - 1.0).abs() < 1e-6, "{b} {beta0}");
            }
            assert!((1..20).all(|k| law.total(f64::from(k) / 19.0) <= law.total(0.0) * (1.0 + 1e-9)));
        }
        for bad in [[-1.0, 1.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, f64::NAN], [1e300, 1e-300, 1.0]] {
            assert_eq!(AbgLaw::new(bad), None);
        }
    }
}
