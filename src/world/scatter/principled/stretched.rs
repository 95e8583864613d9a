//! How much of the light facets of two widths reflect: [`super::energy`]'s tables with the direction besides.

use super::energy::{Known, LEAST_ALPHA, Tally, alpha, cosine, mix, once, place, weigh};
use super::lobe::{Lobe, Stretch};
use eyebox_scene::AnisotropyLaw;
use glam::DVec3;
use rayon::prelude::*;
use std::sync::{Arc, LazyLock, Mutex};

const COSINES: usize = 32;
const ROUGHNESSES: usize = 16;
/// Steps of the square of the sine between a direction and that of the facets.
const TURNS: usize = 7;
/// Strengths of a texture.
const STRENGTHS: usize = 6;

/// Tables of an index, a law and strengths of it.
#[derive(Debug)]
pub struct Stretched {
    /// The largest strength; the others lie evenly below.
    strongest: f64,
    /// By strength, roughness, turn and √cos.
    entries: Vec<[[Tally; COSINES]; TURNS]>,
    /// By strength and roughness, averaged over a hemisphere by the cosine.
    means: Vec<Tally>,
    strengths: usize,
}

impl Stretched {
    /// The tables for a strength, or for all up to it; made once.
    pub fn of(ior: f64, law: AnisotropyLaw, strongest: f64, varies: bool) -> Arc<Stretched> {
        static KNOWN: Known<(u64, AnisotropyLaw, u64, bool), Stretched> = LazyLock::new(Mutex::default);
        let key = (ior.to_bits(), law, strongest.to_bits(), varies);
        once(&KNOWN, key, || Stretched::new(ior, law, strongest, varies))
    }

    fn new(ior: f64, law: AnisotropyLaw, strongest: f64, varies: bool) -> Stretched {
        let strengths = if varies { STRENGTHS } else { 1 };
        let table = |index: usize| {
            let (s, r) = (index / ROUGHNESSES, index % ROUGHNESSES);
            let strength = if varies { strongest * s as f64 / (STRENGTHS - 1) as f64 } else { strongest };
            let alphas = law.alphas(alpha(r as f64 / (ROUGHNESSES - 1) as f64), strength);
            let lobe = Lobe::new(LEAST_ALPHA, Some(Stretch { turn: [1.0, 0.0], alphas, strength }));
            std::array::from_fn(|turn| {
                let sin = (turn as f64 / (TURNS - 1) as f64).sqrt();
                let along = (1.0 - sin * sin).max(0.0).sqrt();
                std::array::from_fn(|c| {
                    let cos = cosine(c, COSINES);
                    let flat = (1.0 - cos * cos).max(0.0).sqrt();
                    weigh(&lobe, ior, DVec3::new(flat * along, flat * sin, cos))
                })
            })
        };
        let entries: Vec<[[Tally; COSINES]; TURNS]> = (0..strengths * ROUGHNESSES).into_par_iter().map(table).collect();
        let mut out = Stretched { strongest, entries, means: Vec::new(), strengths };
        out.means = (0..strengths * ROUGHNESSES).map(|index| out.mean_of(index)).collect();
        out
    }

    /// ∫ f cos dω/π over what is linear between the entries.
    fn mean_of(&self, index: usize) -> Tally {
        const STEPS: usize = 16;
        const ANGLES: usize = 32;
        let mut sum = [0.0; 3];
        for angle in 0..ANGLES {
            let phi = std::f64::consts::FRAC_PI_2 * (angle as f64 + 0.5) / ANGLES as f64;
            let turn = place(phi.sin().powi(2), TURNS);
            let cells = (COSINES - 1) * STEPS;
            for cell in 0..cells {
                // cos = x², and 2 cos d cos = 4 x³ dx.
                let x = (cell as f64 + 0.5) / cells as f64;
                let (c, s) = place(x, COSINES);
                let found = between2(&self.entries[index], turn, (c, s));
                for k in 0..3 {
                    sum[k] += found[k] * 4.0 * x.powi(3) / cells as f64 / ANGLES as f64;
                }
            }
        }
        sum
    }

    /// The strengths about one, as a place in the tables.
    fn strength(&self, strength: f64) -> (usize, f64) {
        if self.strengths == 1 || self.strongest <= 0.0 {
            return (0, 0.0);
        }
        place(strength / self.strongest, self.strengths)
    }

    /// For a direction whose projection has this square of a sine to the direction of the facets.
    pub fn at(&self, cos: f64, across: f64, roughness: f64, strength: f64) -> Tally {
        let turn = place(across, TURNS);
        let c = place(cos.clamp(0.0, 1.0).sqrt(), COSINES);
        self.between(roughness, strength, |index| between2(&self.entries[index], turn, c))
    }

    /// Averaged over a hemisphere by the cosine.
    pub fn mean(&self, roughness: f64, strength: f64) -> Tally {
        self.between(roughness, strength, |index| self.means[index])
    }

    fn between(&self, roughness: f64, strength: f64, at: impl Fn(usize) -> Tally) -> Tally {
        let (s, t) = self.strength(strength);
        let (r, u) = place(roughness, ROUGHNESSES);
        let row = |s: usize| mix(at(s * ROUGHNESSES + r), at(s * ROUGHNESSES + r + 1), u);
        if t == 0.0 { row(s) } else { mix(row(s), row(s + 1), t) }
    }
}

fn between2(entry: &[[Tally; COSINES]; TURNS], (turn, t): (usize, f64), (c, s): (usize, f64)) -> Tally {
    let row = |turn: usize| mix(entry[turn][c], entry[turn][c + 1], s);
    mix(row(turn), row(turn + 1), t)
}
