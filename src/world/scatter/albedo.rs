//! How much of what arrives one bounce sends back and through: an integral over the microfacets, eight of them at a time.

use super::Sides;
use super::rough::Facets;
use std::f64::consts::PI;

/// Normals per cosine: rings of the cap that visible normals are drawn from, and sectors of half of it (the rest mirrors
/// it).
const RINGS: usize = 256;
const SECTORS: usize = 128;
const LANES: usize = 8;

/// What all normals of an integral share.
struct Bounces<'a> {
    alpha: f64,
    n: Sides<'a>,
    /// Of the direction that light comes from: across the face and out of it; and the same stretched by the roughness, to
    /// unit length.
    wi: [f64; 2],
    stretched: [f64; 2],
    /// 1 + Λ of it.
    seen: f64,
    cosines: [f64; SECTORS],
}

impl Facets {
    /// Shares of what arrives under `cos_in` > 0 that one bounce sends back and through, by the midpoint rule over the square
    /// that visible normals are drawn from, dense where normals are steep: there what a facet does changes at once, from
    /// refraction to total reflection or to light that leaves on the wrong side.
    pub fn albedo(self, cos_in: f64, n: Sides<'_>) -> [f64; 2] {
        let across = ((1.0 - cos_in) * (1.0 + cos_in)).max(0.0).sqrt();
        let length = (self.alpha * across).hypot(cos_in);
        let bounces = Bounces {
            alpha: self.alpha,
            n,
            wi: [across, cos_in],
            stretched: [self.alpha * across / length, cos_in / length],
            seen: 1.0 + self.lambda(glam::DVec3::new(across, 0.0, cos_in)),
            cosines: std::array::from_fn(|sector| (PI * (sector as f64 + 0.5) / SECTORS as f64).cos()),
        };
        let mut sums = [0.0; 2];
        for ring in 0..RINGS {
            let steep = (ring as f64 + 0.5) / RINGS as f64;
            let shares = bounces.ring(steep * steep);
            sums = [0, 1].map(|side| sums[side] + 2.0 * steep * shares[side]);
        }
        sums.map(|sum| sum / (RINGS * SECTORS) as f64)
    }
}

impl Bounces<'_> {
    /// The sums over a ring: `height` of its cap, 0 at its edge and 1 at its pole.
    fn ring(&self, height: f64) -> [f64; 2] {
        #[cfg(target_arch = "x86_64")]
        if std::is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has what the function needs.
            return unsafe { self.ring_in_lanes(height) };
        }
        self.ring_by(height)
    }

    /// With four lanes of f64. No product is fused: the numbers are the same everywhere.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn ring_in_lanes(&self, height: f64) -> [f64; 2] {
        self.ring_by(height)
    }

    #[inline(always)]
    fn ring_by(&self, height: f64) -> [f64; 2] {
        let mut sums = [[0.0; LANES]; 2];
        // The cap is uniform in z from −stretched z to 1; its sum with the stretched direction is the half vector.
        let up = height * (1.0 + self.stretched[1]);
        let z = up - self.stretched[1];
        let sin = positive((1.0 - z) * (1.0 + z)).sqrt();
        for cosines in self.cosines.as_chunks::<LANES>().0 {
            for lane in 0..LANES {
                let [back, through] = self.at(up, sin, cosines[lane]);
                sums[0][lane] += back;
                sums[1][lane] += through;
            }
        }
        sums.map(|lanes| lanes.iter().sum())
    }

    /// What a normal sends back and through, without branches. Along the face only its squared length across and its part
    /// along the light are asked for.
    #[inline(always)]
    fn at(&self, up: f64, sin: f64, cos_phi: f64) -> [f64; 2] {
        let [across, out] = self.wi;
        let along = sin * cos_phi + self.stretched[0];
        let level = sin * sin * (1.0 - cos_phi * cos_phi) + along * along;
        let unit = 1.0 / (self.alpha * self.alpha * level + up * up).sqrt();
        let (ci, hz) = (positive(across * self.alpha * along + out * up) * unit, up * unit);
        // Snell and Fresnel at the facet.
        let eta = self.n.here / self.n.beyond;
        // At equal indices the ray goes straight on to the last bit.
        let square = (1.0 - eta) * (1.0 + eta) + (eta * ci) * (eta * ci);
        let co = positive(square).sqrt();
        let [s, s_sum] = [eta * ci - co, eta * ci + co];
        let [p, p_sum] = [ci - eta * co, ci + eta * co];
        let parts = [s * p_sum, p * s_sum];
        let sums = s_sum * p_sum;
        let partial = 0.5 * (parts[0] * parts[0] + parts[1] * parts[1]) / (sums * sums);
        let f = if square > 0.0 { partial } else { 1.0 };
        let back = f * self.leaves(2.0 * ci * hz - out);
        let through = (1.0 - f) * self.leaves(eta * out - (eta * ci - co) * hz);
        [back, through]
    }

    /// Share of the light that leaves a facet under a cosine and is not masked: (1 + Λi)/(1 + Λi + Λo).
    #[inline(always)]
    fn leaves(&self, cos: f64) -> f64 {
        let cos_out = positive(cos);
        let square = cos_out * cos_out;
        // 2 Λo cos
        let masked = (square + self.alpha * self.alpha * positive(1.0 - square)).sqrt() - cos_out;
        self.seen * cos_out / (self.seen * cos_out + 0.5 * masked)
    }
}

/// One instruction to a lane; 0 for what is not a number.
#[inline(always)]
fn positive(x: f64) -> f64 {
    if x > 0.0 { x } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// Facet by facet, by the general formulas.
    #[test]
    fn lanes_add_what_facets_bounce() {
        for alpha in [1e-4, 0.03, 0.4, 1.0] {
            for (here, beyond) in [(1.0, 1.5), (1.5, 1.0), (1.0, 1.0), (1.3, 2.4)] {
                for cos in [1e-12, 1e-6, 0.02, 0.3, 0.8, 1.0f64] {
                    let (facets, n) = (Facets { alpha }, Sides::between(here, beyond));
                    let wi = DVec3::new(((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt(), 0.0, cos);
                    let mut sums = [0.0; 2];
                    for ring in 0..RINGS {
                        let steep = (ring as f64 + 0.5) / RINGS as f64;
                        for sector in 0..SECTORS {
                            let at = [0.5 * (sector as f64 + 0.5) / SECTORS as f64, 1.0 - steep * steep];
                            let shares = facets.bounce(wi, n, at);
                            sums = [0, 1].map(|side| sums[side] + 2.0 * steep * shares[side]);
                        }
                    }
                    let found = facets.albedo(cos, n);
                    for (sum, found) in sums.into_iter().zip(found) {
                        let want = sum / (RINGS * SECTORS) as f64;
                        assert!((found - want).abs() < 1e-9, "{alpha} {here} {beyond} {cos}: {found} for {want}");
                    }
                }
            }
        }
    }
}
