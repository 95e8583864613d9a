//! Fibres that stand on a surface: the sheen of A. Conty Estevez and C. Kulla, "Production Friendly Microfacet Sheen BRDF"
//! (SIGGRAPH 2017 courses), as KHR_materials_sheen has it: their distribution, and what fibres hide of each other by
//! their fit. The simpler visibility that the extension allows where time is short reflects half more at a roughness of 0.3, and
//! a third less at 1. Where light grazes, the law sends out more than has come in; it is then brought down to that, by the larger
//! of what both directions ask for, so that the lobe stays reciprocal.

use super::energy;
use glam::DVec3;
use std::f64::consts::PI;
use std::sync::LazyLock;

/// Of √cos, from the least cosine on.
const COSINES: usize = 48;
const LEAST: f64 = 1e-4;
const ROUGHNESSES: usize = 16;

/// The fit of Λ for α = 0 and α = 1: a, b, c, d, e of a/(1 + b xᶜ) + d x + e (section 3 of the course notes).
const FIT: [[f64; 5]; 2] =
    [[25.3245, 3.32435, 0.16801, -1.27393, -4.85967], [21.5473, 3.82987, 0.19823, -1.97760, -4.32054]];

/// The bidirectional distribution of white fibres, 1/sr, without the cosine.
pub fn sheen(wi: DVec3, wo: DVec3, alpha: f64) -> f64 {
    let most = law_reflects(wi.z, alpha).max(law_reflects(wo.z, alpha)).max(1.0);
    law(wi, wo, alpha) / most
}

/// The same as the law has it.
fn law(wi: DVec3, wo: DVec3, alpha: f64) -> f64 {
    let h = (wi + wo).normalize_or_zero();
    let sin = (1.0 - h.z * h.z).max(0.0).sqrt();
    let distribution = (2.0 + 1.0 / alpha) * sin.powf(1.0 / alpha) / (2.0 * PI);
    let hidden = 1.0 + lambda(wi.z, alpha) + lambda(wo.z, alpha);
    let value = distribution / (4.0 * hidden * wi.z * wo.z);
    if value.is_finite() { value } else { 0.0 }
}

/// How much fibres hide of each other under a cosine: Smith's Λ, mirrored about 60° in its logarithm.
fn lambda(cos: f64, alpha: f64) -> f64 {
    let cos = cos.clamp(0.0, 1.0);
    let share = (1.0 - alpha).clamp(0.0, 1.0).powi(2);
    let [a, b, c, d, e] = std::array::from_fn(|i| FIT[1][i] + (FIT[0][i] - FIT[1][i]) * share);
    let fit = |x: f64| a / (1.0 + b * x.powf(c)) + d * x + e;
    if cos < 0.5 { fit(cos).exp() } else { (2.0 * fit(0.5) - fit(1.0 - cos)).exp() }
}

/// What the law reflects, by √α and √cos.
static SHEEN: LazyLock<Vec<[f64; COSINES]>> = LazyLock::new(|| {
    const STEPS: usize = 48;
    let reflected = |alpha: f64, cos: f64| -> f64 {
        let wi = DVec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
        let one = |turn: usize, tilt: usize| {
            // Uniform in the square of the cosine: what counts is near the horizon as well.
            let phi = PI * (turn as f64 + 0.5) / STEPS as f64;
            let z = (tilt as f64 + 0.5) / STEPS as f64;
            let sin = (1.0 - z * z).sqrt();
            law(wi, DVec3::new(sin * phi.cos(), sin * phi.sin(), z), alpha) * z
        };
        let sum: f64 = (0..STEPS * STEPS).map(|i| one(i / STEPS, i % STEPS)).sum();
        2.0 * PI * sum / (STEPS * STEPS) as f64
    };
    (0..ROUGHNESSES)
        .map(|r| {
            let alpha = sheen_alpha(r as f64 / (ROUGHNESSES - 1) as f64);
            std::array::from_fn(|c| reflected(alpha, (c as f64 / (COSINES - 1) as f64).powi(2).max(LEAST)))
        })
        .collect()
});

/// α of a sheen's roughness: below it fibres are hardly more than a rim of light.
pub fn sheen_alpha(roughness: f64) -> f64 {
    (roughness * roughness).clamp(0.01, 1.0)
}

/// Share of light under a cosine that a white sheen reflects; at most all of it.
pub fn sheen_reflects(cos: f64, alpha: f64) -> f64 {
    law_reflects(cos, alpha).min(1.0)
}

fn law_reflects(cos: f64, alpha: f64) -> f64 {
    let cos = cos.abs();
    let ((r, s), (c, t)) = (energy::place(alpha.sqrt(), ROUGHNESSES), energy::place(cos.sqrt(), COSINES));
    let row = |r: usize| SHEEN[r][c] + (SHEEN[r][c + 1] - SHEEN[r][c]) * t;
    // Fibres that nearly lie in the light send out as its inverse cosine.
    let beyond = if cos < LEAST { LEAST / cos } else { 1.0 };
    (row(r) + (row(r + 1) - row(r)) * s) * beyond
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Λ and the albedo by a second program (Python, 400 × 400 points of the hemisphere): they were not made by this one.
    #[test]
    fn as_the_extension_has_it() {
        for (alpha, cos, albedo) in [
            (0.09, 0.1, 0.54086),
            (0.09, 0.5, 0.08704),
            (0.36, 0.1, 0.60533),
            (0.36, 0.5, 0.23475),
            (0.36, 1.0, 0.05407),
        ] {
            let found = sheen_reflects(cos, alpha);
            assert!((found - albedo).abs() < 0.02 * albedo + 0.002, "α {alpha}, cosine {cos}: {found}, not {albedo}");
        }
    }
}
