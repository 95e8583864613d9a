//! Closed forms that the stress suite compares with, written out on their own: nothing here is what the tracer uses.

/// Reflectance [s, p] of the bare interface from `n1` into `n2` under the sine `sin` in `n1`; `cos` is its cosine, given
/// apart so that neither loses digits.
pub fn reflectance(n1: f64, n2: f64, sin: f64, cos: f64) -> [f64; 2] {
    // n₂² − n₁² sin² = (n₂ − n₁)(n₂ + n₁) + n₁² cos².
    let under = (n2 - n1) * (n2 + n1) + n1 * n1 * cos * cos;
    if under <= 0.0 {
        return [1.0; 2];
    }
    let (a, b) = (n1 * cos, under.sqrt());
    // (a − b) by a² − b² = n₁² − n₂².
    let s = (n1 - n2) * (n1 + n2) / ((a + b) * (a + b));
    // r_p = r_s · (a b − n₁² sin²)/(a b + n₁² sin²), from tan(θ₁ − θ₂)/tan(θ₁ + θ₂).
    let t = (n1 * sin) * (n1 * sin);
    let p = s * (a * b - t) / (a * b + t);
    [s * s, p * p]
}

/// Share of unpolarised light that plane-parallel lossless plates let through, all inner reflections included, without
/// interference: the indices of all media in a row from the first to the last, under the angle whose sine in the first
/// is `sin`.
pub fn plates(indices: &[f64], sin: f64) -> f64 {
    0.5 * (pile(indices, sin, |r| r[0]) + pile(indices, sin, |r| r[1]))
}

/// The same if light forgot its polarisation at every face.
pub fn plates_unpolarised(indices: &[f64], sin: f64) -> f64 {
    pile(indices, sin, |r| 0.5 * (r[0] + r[1]))
}

fn pile(indices: &[f64], sin: f64, of: impl Fn([f64; 2]) -> f64) -> f64 {
    let invariant = indices.first().map_or(0.0, |n| n * sin);
    let sum: f64 = {
        // For lossless interfaces in a row R/T of the pile is the sum of their R/T.
        indices
            .windows(2)
            .map(|pair| {
                let sin = invariant / pair[0];
                let cos = ((1.0 - sin) * (1.0 + sin)).max(0.0).sqrt();
                let r = of(reflectance(pair[0], pair[1], sin, cos));
                r / (1.0 - r)
            })
            .sum()
    };
    1.0 / (1.0 + sum)
}

/// Reflectance and transmittance of one film of index n + ik between real media, normal incidence, thickness and
/// wavelength in nm: Airy's sum of all reflections.
pub fn film(n0: f64, film: [f64; 2], thickness_nm: f64, n2: f64, nm: f64) -> [f64; 2] {
    let sub = |a: [f64; 2], b: [f64; 2]| [a[0] - b[0], a[1] - b[1]];
    let add = |a: [f64; 2], b: [f64; 2]| [a[0] + b[0], a[1] + b[1]];
    let mul = |a: [f64; 2], b: [f64; 2]| [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]];
    let norm = |a: [f64; 2]| a[0] * a[0] + a[1] * a[1];
    let div = |a: [f64; 2], b: [f64; 2]| {
        let d = norm(b);
        [(a[0] * b[0] + a[1] * b[1]) / d, (a[1] * b[0] - a[0] * b[1]) / d]
    };
    let (first, last) = ([n0, 0.0], [n2, 0.0]);
    let r01 = div(sub(first, film), add(first, film));
    let r12 = div(sub(film, last), add(film, last));
    let t01 = div([2.0 * n0, 0.0], add(first, film));
    let t12 = div(mul([2.0, 0.0], film), add(film, last));
    // exp(2πi (n + ik) d/λ)
    let (phase, decay) = (
        std::f64::consts::TAU * film[0] * thickness_nm / nm,
        (-std::f64::consts::TAU * film[1] * thickness_nm / nm).exp(),
    );
    let one_way = [decay * phase.cos(), decay * phase.sin()];
    let there_and_back = mul(one_way, one_way);
    let all = add([1.0, 0.0], mul(mul(r01, r12), there_and_back));
    let r = div(add(r01, mul(r12, there_and_back)), all);
    let t = div(mul(mul(t01, t12), one_way), all);
    [norm(r), norm(t) * n2 / n0]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against values that are known otherwise: 4 % at glass, Brewster's angle, four plates there, a quarter wave.
    #[test]
    fn known_values() {
        assert!((reflectance(1.0, 1.5, 0.0, 1.0)[0] - 0.04).abs() < 1e-15);
        let brewster = 1.5f64.atan();
        assert!(reflectance(1.0, 1.5, brewster.sin(), brewster.cos())[1] < 1e-30);
        let four = plates(&[1.0, 1.5, 1.0, 1.5, 1.0, 1.5, 1.0, 1.5, 1.0], brewster.sin());
        assert!((four - 0.709).abs() < 5e-4, "{four}");
        let one = plates(&[1.0, 1.5168, 1.0], 60f64.to_radians().sin());
        assert!((one - 0.844).abs() < 5e-4, "{one}");
        let [r, t] = film(1.0, [1.5f64.sqrt(), 0.0], 550.0 / 4.0 / 1.5f64.sqrt(), 1.5, 550.0);
        assert!(r < 1e-30 && (t - 1.0).abs() < 1e-15, "{r} {t}");
        let [r, t] = film(1.0, [2.0, 0.5], 1e6, 1.5, 550.0);
        assert!((r - (1.0 + 0.25) / (9.0 + 0.25)).abs() < 1e-15 && t == 0.0, "{r} {t}");
    }
}
