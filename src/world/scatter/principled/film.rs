//! A thin film on a dielectric or a metal: the colours of its interference, as tables.
//!
//! A film of index n and thickness d adds up what its two faces reflect, r₁ and r₂, with the phase 4π n d cos θ₂/λ between
//! them: R = (r₁² + r₂² + 2 r₁ r₂ cos φ)/(1 + r₁² r₂² + 2 r₁ r₂ cos φ) for each polarisation (Airy; Born and Wolf,
//! section 7.6). Of that all modes take its colour under daylight, as of any colour of a material. What is below the film is
//! known by what it would reflect straight on, as by the index (1 + √R)/(1 − √R) (KHR_materials_iridescence).

use super::energy::{Known, alpha, cosine, mix, once, place, weigh_by};
use super::lobe::Lobe;
use eyebox_base::colour::{XYZ_TO_REC709, apply, cmf, d65, lookup};
use eyebox_scene::{Film, Scalar};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::{Arc, LazyLock, Mutex};

const COSINES: usize = 48;
/// Of the square root of what the base would reflect straight on.
const BASES: usize = 17;
const ROUGHNESSES: usize = 12;
/// Most nanometres between two thicknesses: a tenth of the period of blue light in glass.
const STEP_NM: f64 = 15.0;
const MOST_THICKNESSES: usize = 128;

/// A film of an index, for all thicknesses that a surface has of it.
#[derive(Debug)]
pub struct Interference {
    least_nm: f64,
    most_nm: f64,
    thicknesses: usize,
    /// Reflectance in linear Rec.709 by thickness, base and √cos.
    reflectance: Vec<[[f64; 3]; COSINES]>,
    /// What facets reflect over the dielectric, by thickness, roughness and √cos.
    whole: Vec<[[f64; 3]; COSINES]>,
    /// The same averaged over a hemisphere by the cosine.
    means: Vec<[f64; 3]>,
}

/// A film at a place, in a lane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilmLook {
    pub weight: f64,
    pub thickness_nm: f64,
    /// Shares of red, green and blue in the lane.
    pub lane: [f64; 3],
}

impl Interference {
    /// The film of a surface, over a dielectric that reflects `straight` of what falls straight on; made once for all faces.
    pub fn of(film: &Film, straight: f64) -> Arc<Interference> {
        static KNOWN: Known<[u64; 4], Interference> = LazyLock::new(Mutex::default);
        let (least_nm, most_nm) = range(&film.thickness_nm);
        let key = [film.ior, straight, least_nm, most_nm].map(f64::to_bits);
        once(&KNOWN, key, || Interference::new(film.ior, straight, [least_nm, most_nm]))
    }

    fn new(ior: f64, straight: f64, [least_nm, most_nm]: [f64; 2]) -> Interference {
        let steps = ((most_nm - least_nm) / STEP_NM).ceil();
        let thicknesses = if steps > 0.0 { (steps as usize + 1).min(MOST_THICKNESSES) } else { 1 };
        let weights = weights();
        let nm = |k: usize| least_nm + (most_nm - least_nm) * k as f64 / (thicknesses.max(2) - 1) as f64;
        let reflectance = (0..thicknesses * BASES)
            .into_par_iter()
            .map(|index| {
                let root = (index % BASES) as f64 / (BASES - 1) as f64;
                let below = index_of(root * root);
                std::array::from_fn(|c| colour(&weights, [ior, below], nm(index / BASES), cosine(c, COSINES)))
            })
            .collect();
        let mut out =
            Interference { least_nm, most_nm, thicknesses, reflectance, whole: Vec::new(), means: Vec::new() };
        out.whole = (0..thicknesses * ROUGHNESSES)
            .into_par_iter()
            .map(|index| {
                let (k, r) = (index / ROUGHNESSES, index % ROUGHNESSES);
                let lobe = Lobe::new(alpha(r as f64 / (ROUGHNESSES - 1) as f64), None);
                std::array::from_fn(|c| {
                    let cos = cosine(c, COSINES);
                    let wi = DVec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
                    weigh_by(&lobe, wi, |cos| out.at_node(k, straight, cos))
                })
            })
            .collect();
        out.means = out.whole.iter().map(mean_of).collect();
        out
    }

    /// Reflectance in linear Rec.709 at a cosine, over a base that would reflect `straight` of what falls straight on.
    pub fn at(&self, thickness_nm: f64, straight: f64, cos: f64) -> [f64; 3] {
        self.between(thickness_nm, |k| self.at_node(k, straight, cos))
    }

    /// What facets of a roughness reflect of light under a cosine, over the dielectric.
    pub fn whole(&self, thickness_nm: f64, roughness: f64, cos: f64) -> [f64; 3] {
        let (r, u) = place(roughness, ROUGHNESSES);
        let (c, s) = place(cos.clamp(0.0, 1.0).sqrt(), COSINES);
        let row = |index: usize| mix(self.whole[index][c], self.whole[index][c + 1], s);
        self.between(thickness_nm, |k| mix(row(k * ROUGHNESSES + r), row(k * ROUGHNESSES + r + 1), u))
    }

    /// The same averaged over a hemisphere by the cosine.
    pub fn mean(&self, thickness_nm: f64, roughness: f64) -> [f64; 3] {
        let (r, u) = place(roughness, ROUGHNESSES);
        let means = |k: usize| mix(self.means[k * ROUGHNESSES + r], self.means[k * ROUGHNESSES + r + 1], u);
        self.between(thickness_nm, means)
    }

    fn at_node(&self, k: usize, straight: f64, cos: f64) -> [f64; 3] {
        let (base, t) = place(straight.clamp(0.0, 1.0).sqrt(), BASES);
        let (c, s) = place(cos.clamp(0.0, 1.0).sqrt(), COSINES);
        let row = |index: usize| mix(self.reflectance[index][c], self.reflectance[index][c + 1], s);
        mix(row(k * BASES + base), row(k * BASES + base + 1), t)
    }

    fn between(&self, thickness_nm: f64, at: impl Fn(usize) -> [f64; 3]) -> [f64; 3] {
        if self.thicknesses == 1 {
            return at(0);
        }
        let (k, t) = place((thickness_nm - self.least_nm) / (self.most_nm - self.least_nm), self.thicknesses);
        mix(at(k), at(k + 1), t)
    }
}

/// The thicknesses that a parameter can have.
fn range(thickness_nm: &Scalar) -> (f64, f64) {
    let ends = match &thickness_nm.texture {
        None => [1.0; 2],
        Some((input, channel)) => {
            let bias = channel.of(input.bias);
            [bias, bias + channel.of(input.scale)]
        }
    };
    let [a, b] = ends.map(|end| (thickness_nm.factor * end).max(0.0));
    (a.min(b), a.max(b))
}

/// ∫ f · 2 cos d cos over f that is linear in √cos between the entries.
fn mean_of(row: &[[f64; 3]; COSINES]) -> [f64; 3] {
    const STEPS: usize = 8;
    let cells = (COSINES - 1) * STEPS;
    let mut sum = [0.0; 3];
    for cell in 0..cells {
        let x = (cell as f64 + 0.5) / cells as f64;
        let (c, s) = place(x, COSINES);
        let found = mix(row[c], row[c + 1], s);
        for lane in 0..3 {
            sum[lane] += found[lane] * 4.0 * x.powi(3) / cells as f64;
        }
    }
    sum
}

/// The index of a base that reflects so much straight on; a mirror's is finite here.
fn index_of(straight: f64) -> f64 {
    let root = straight.min(0.9999).sqrt();
    (1.0 + root) / (1.0 - root)
}

/// What each wavelength adds to the colour of a reflectance under D65, nm and linear Rec.709: white adds up to 1.
fn weights() -> Vec<(f64, [f64; 3])> {
    const LAST_NM: usize = 780;
    let lines = (380..=LAST_NM).step_by(5).map(|nm| {
        let nm = nm as f64;
        (nm, cmf(nm).map(|bar| bar * lookup(d65(), nm)))
    });
    let lines: Vec<(f64, [f64; 3])> = lines.map(|(nm, xyz)| (nm, apply(&XYZ_TO_REC709, xyz))).collect();
    let whole: [f64; 3] = std::array::from_fn(|c| lines.iter().map(|(_, rgb)| rgb[c]).sum());
    lines.into_iter().map(|(nm, rgb)| (nm, std::array::from_fn(|c| rgb[c] / whole[c]))).collect()
}

/// Of light from air. What is out of the gamut is taken at its edge: no lane may gain or be owed light.
fn colour(weights: &[(f64, [f64; 3])], [film, below]: [f64; 2], thickness_nm: f64, cos: f64) -> [f64; 3] {
    let [sine, q] = [(1.0 - cos * cos).max(0.0), cos];
    let within = |n: f64| (n * n - sine).max(0.0).sqrt();
    let (q_film, q_below) = (within(film), within(below));
    // Amplitudes of s and p by q = n cos θ; a total reflection has its size, without its phase.
    let amplitude = |n1: f64, q1: f64, n2: f64, q2: f64| {
        let pair = [(q1, q2), (n2 * n2 * q1, n1 * n1 * q2)];
        pair.map(|(a, b)| if a + b > 0.0 { (a - b) / (a + b) } else { -1.0 })
    };
    let first = amplitude(1.0, q, film, q_film);
    let second = amplitude(film, q_film, below, q_below);
    let mut sum = [0.0; 3];
    for (nm, rgb) in weights {
        let phase = (4.0 * std::f64::consts::PI * q_film * thickness_nm / nm).cos();
        let one = |r: f64, s: f64| {
            let cross = 2.0 * r * s * phase;
            let below = 1.0 + r * r * s * s + cross;
            if below > 0.0 { (r * r + s * s + cross) / below } else { 1.0 }
        };
        let share = 0.5 * (one(first[0], second[0]) + one(first[1], second[1]));
        for lane in 0..3 {
            sum[lane] += rgb[lane] * share;
        }
    }
    sum.map(|lane| lane.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn film(ior: f64, nm: f64) -> Film {
        Film { weight: Scalar::new(1.0), ior, thickness_nm: Scalar::new(nm) }
    }

    /// A film of no thickness, or of the index of what is below, is not there.
    #[test]
    fn no_film_is_fresnels() {
        for (ior, nm) in [(1.4, 0.0), (1.5, 400.0)] {
            let table = Interference::of(&film(ior, nm), 0.04);
            for cos in [1.0, 0.7, 0.3] {
                let want = crate::fresnel::fresnel(1.0, eyebox_base::Complex::real(1.5), cos).reflectance();
                let got = table.at(nm, 0.04, cos);
                assert!(got.iter().all(|lane| (lane - want).abs() < 2e-3), "{ior} {nm} {cos}: {got:?} for {want}");
            }
        }
    }

    /// Born and Wolf, section 1.6.4: a quarter of a wave of √n on n reflects nothing of that wave, and the index of a film
    /// of half a wave says nothing. Green is near 550 nm, and the least of the three.
    #[test]
    fn a_quarter_wave_takes_green() {
        let table = Interference::of(&film(1.5f64.sqrt(), 550.0 / 4.0 / 1.5f64.sqrt()), 0.04);
        let [r, g, b] = table.at(550.0 / 4.0 / 1.5f64.sqrt(), 0.04, 1.0);
        assert!(g < 1e-3 && r > g && b > g, "{r} {g} {b}");
    }
}
