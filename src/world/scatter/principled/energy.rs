//! How much of the light a layer of facets reflects: tables that what lies below it is scaled by, so that nothing is
//! gained and, where nothing absorbs, nothing is lost.
//!
//! Fresnel's reflectance of a dielectric is written F = f0 + (f90 − f0)·t with t = (R − R0)/(1 − R0), R by Fresnel's
//! equations. Then what facets reflect of light under a cosine is f0·(E − B) + f90·B, where E is that of perfect facets and
//! B that of facets which reflect t. A third column is of facets that reflect cos·(1 − cos)⁶: what the edge of a metal lacks.

use super::lobe::Lobe;
use crate::fresnel::fresnel;
use eyebox_base::Complex;
pub use eyebox_scene::LEAST_ALPHA;
use glam::DVec3;
use std::collections::HashMap;
use std::hash::Hash;
use std::sync::{Arc, LazyLock, Mutex};

/// Steps of √cos and of roughness.
const COSINES: usize = 64;
const ROUGHNESSES: usize = 32;
/// Visible normals per entry, turned about the normal and away from it.
const TURNS: usize = 16;
const TILTS: usize = 32;

/// α of a roughness of 0 to 1.
pub fn alpha(roughness: f64) -> f64 {
    (roughness * roughness).clamp(LEAST_ALPHA, 1.0)
}

/// Reflectance at normal incidence of a boundary of this index, at least 1; of an infinite one all.
pub fn normal_reflectance(ior: f64) -> f64 {
    if ior.is_infinite() {
        return 1.0;
    }
    let amplitude = (ior - 1.0) / (ior + 1.0);
    amplitude * amplitude
}

/// t at a cosine: 0 where light falls straight on, 1 where it grazes.
pub fn towards_grazing(ior: f64, cos: f64) -> f64 {
    let straight = normal_reflectance(ior);
    if ior.is_infinite() {
        // The index says nothing: Schlick's form.
        return (1.0 - cos).clamp(0.0, 1.0).powi(5);
    }
    if ior <= 1.0 {
        return 0.0;
    }
    let reflectance = fresnel(1.0, Complex::real(ior), cos).reflectance();
    ((reflectance - straight) / (1.0 - straight)).clamp(0.0, 1.0)
}

/// What facets reflect: E, B and the metal's column.
pub type Tally = [f64; 3];

/// Tables of an index.
#[derive(Debug)]
pub struct Energy {
    ior: f64,
    /// By roughness and √cos.
    rows: Vec<[Tally; COSINES]>,
    /// Averaged over a hemisphere by the cosine, by roughness.
    means: Vec<Tally>,
}

/// What the edge of a metal lacks of Schlick's form at a cosine, per unit (OpenPBR 1.1, "F82-tint").
pub fn edge(cos: f64) -> f64 {
    cos * (1.0 - cos).clamp(0.0, 1.0).powi(6)
}

impl Energy {
    /// The tables of an index, made once.
    pub fn of(ior: f64) -> Arc<Energy> {
        static KNOWN: Known<u64, Energy> = LazyLock::new(Mutex::default);
        once(&KNOWN, ior.to_bits(), || Energy::new(ior))
    }

    fn new(ior: f64) -> Energy {
        let rows: Vec<[Tally; COSINES]> = (0..ROUGHNESSES)
            .map(|r| {
                let facets = Lobe::new(alpha(r as f64 / (ROUGHNESSES - 1) as f64), None);
                std::array::from_fn(|c| reflected(&facets, ior, cosine(c, COSINES)))
            })
            .collect();
        let means = rows
            .iter()
            .map(|row| {
                // ∫ 2 f cos d(cos) with cos = x²: 4 f x³ dx, f linear between the entries.
                let step = 1.0 / (COSINES - 1) as f64;
                let piece = |c: usize, k: usize| {
                    let (x0, f0, f1) = (c as f64 * step, row[c][k], row[c + 1][k]);
                    // Simpson's rule is exact to the third power; two halves leave nothing to see of the fourth.
                    let f = |s: f64| (f0 + (f1 - f0) * s) * 4.0 * (x0 + s * step).powi(3);
                    step / 12.0 * (f(0.0) + 4.0 * f(0.25) + 2.0 * f(0.5) + 4.0 * f(0.75) + f(1.0))
                };
                [0, 1, 2].map(|k| (0..COSINES - 1).map(|c| piece(c, k)).sum::<f64>())
            })
            .collect();
        Energy { ior, rows, means }
    }

    pub fn ior(&self) -> f64 {
        self.ior
    }

    /// Under a cosine.
    pub fn at(&self, cos: f64, roughness: f64) -> Tally {
        let (r, s) = place(roughness, ROUGHNESSES);
        let (c, t) = place(cos.clamp(0.0, 1.0).sqrt(), COSINES);
        let row = |r: usize, k: usize| self.rows[r][c][k] + (self.rows[r][c + 1][k] - self.rows[r][c][k]) * t;
        [0, 1, 2].map(|k| row(r, k) + (row(r + 1, k) - row(r, k)) * s)
    }

    /// The same averaged over a hemisphere by the cosine.
    pub fn mean(&self, roughness: f64) -> Tally {
        let (r, s) = place(roughness, ROUGHNESSES);
        [0, 1, 2].map(|k| self.means[r][k] + (self.means[r + 1][k] - self.means[r][k]) * s)
    }
}

/// The cosine of a step of so many.
pub(super) fn cosine(step: usize, count: usize) -> f64 {
    // Nothing arrives along the face; the limit is taken close to it.
    const LEAST: f64 = 1e-4;
    let root = step as f64 / (count - 1) as f64;
    (root * root).max(LEAST)
}

/// Tables that were made, by what they are of.
pub(super) type Known<K, V> = LazyLock<Mutex<HashMap<K, Arc<V>>>>;

/// The tables of a key, made once. No lock is held meanwhile: many threads may make one.
pub(super) fn once<K: Eq + Hash, V>(known: &Known<K, V>, key: K, make: impl FnOnce() -> V) -> Arc<V> {
    let open = || known.lock().unwrap_or_else(|broken| broken.into_inner());
    let found = open().get(&key).cloned();
    found.unwrap_or_else(|| {
        let made = Arc::new(make());
        open().entry(key).or_insert(made).clone()
    })
}

/// Between two rows of a table.
pub(super) fn mix(a: [f64; 3], b: [f64; 3], t: f64) -> [f64; 3] {
    std::array::from_fn(|k| a[k] + (b[k] - a[k]) * t)
}

/// Cell of a table over 0–1 and the place in it.
pub(super) fn place(x: f64, count: usize) -> (usize, f64) {
    let scaled = x.clamp(0.0, 1.0) * (count - 1) as f64;
    let cell = (scaled as usize).min(count - 2);
    (cell, scaled - cell as f64)
}

/// What facets that are alike all round reflect for good of light under a cosine.
fn reflected(facets: &Lobe, ior: f64, cos: f64) -> Tally {
    let wi = DVec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
    // Half of the turns mirror the other half.
    tally(facets, ior, wi, (0..TURNS).map(|turn| 0.5 * (turn as f64 + 0.5) / TURNS as f64))
}

/// The same of any facets, from any direction.
pub(super) fn weigh(facets: &Lobe, ior: f64, wi: DVec3) -> Tally {
    tally(facets, ior, wi, (0..TURNS).map(|turn| (turn as f64 + 0.5) / TURNS as f64))
}

fn tally(facets: &Lobe, ior: f64, wi: DVec3, turns: impl ExactSizeIterator<Item = f64>) -> Tally {
    summed(facets, wi, turns, |cos| [1.0, towards_grazing(ior, cos), edge(cos)])
}

/// What facets that are alike all round reflect if each reflects so much at its cosine.
pub(super) fn weigh_by(facets: &Lobe, wi: DVec3, share: impl Fn(f64) -> [f64; 3]) -> [f64; 3] {
    summed(facets, wi, (0..TURNS).map(|turn| 0.5 * (turn as f64 + 0.5) / TURNS as f64), share)
}

fn summed(
    facets: &Lobe,
    wi: DVec3,
    turns: impl ExactSizeIterator<Item = f64>,
    share: impl Fn(f64) -> [f64; 3],
) -> [f64; 3] {
    let mut sums = [0.0; 3];
    let count = turns.len();
    for turn in turns {
        for tilt in 0..TILTS {
            // Smooth facets lose what the last thousandth of the normals would send back: those are looked at closely.
            let rest = 1.0 - (tilt as f64 + 0.5) / TILTS as f64;
            let weight = 3.0 * rest * rest;
            let h = facets.visible_normal(wi, [turn, 1.0 - rest.powi(3)]);
            let along = wi.dot(h);
            let wo = h * (2.0 * along) - wi;
            if wo.z > 0.0 {
                let seen = weight * facets.leaves(wi, wo);
                let reflected = share(along);
                for k in 0..3 {
                    sums[k] += seen * reflected[k];
                }
            }
        }
    }
    // The mean of the weights is 1 but for their squares' sum.
    let whole = 1.0 - 0.25 / (TILTS * TILTS) as f64;
    sums.map(|sum| sum / ((count * TILTS) as f64 * whole))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Smooth facets are a mirror: E = 1, and f0·(E − B) + f90·B is Fresnel's reflectance.
    #[test]
    fn smooth_facets_are_a_mirror() {
        let energy = Energy::of(1.5);
        for cos in [1.0, 0.7, 0.3, 0.1] {
            let [e, b, _] = energy.at(cos, 0.0);
            let want = fresnel(1.0, Complex::real(1.5), cos).reflectance();
            let got = 0.04 * (e - b) + b;
            assert!((e - 1.0).abs() < 1e-6 && (got - want).abs() < 2e-3, "{cos}: {e}, {got} for {want}");
        }
    }

    /// Kulla and Conty, "Revisiting Physically Based Shading at Imageworks", SIGGRAPH 2017 courses: at α = 1 somewhat more than half of the light
    /// leaves after one bounce. Checked here against the same sum over 400 times the normals.
    #[test]
    fn tables_are_what_they_interpolate() {
        let energy = Energy::of(1.5);
        for (cos, roughness) in [(0.93, 1.0), (0.52, 0.71), (0.21, 0.33), (0.08, 0.9), (0.6, 0.12)] {
            let facets = Lobe::new(alpha(roughness), None);
            let wi = DVec3::new((1.0f64 - cos * cos).sqrt(), 0.0, cos);
            let many = 320;
            let mut sum = 0.0;
            for turn in 0..many {
                for tilt in 0..many {
                    let h = facets.visible_normal(wi, [turn, tilt].map(|i| (i as f64 + 0.5) / many as f64));
                    let wo = h * (2.0 * wi.dot(h)) - wi;
                    if wo.z > 0.0 {
                        sum += facets.leaves(wi, wo);
                    }
                }
            }
            let want = sum / f64::from(many * many);
            let [got, ..] = energy.at(cos, roughness);
            assert!((got - want).abs() < 1e-3, "{cos} {roughness}: {got} for {want}");
        }
    }
}
