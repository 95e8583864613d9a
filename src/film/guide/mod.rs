//! Guided emission as data: which lamps, and which of the places and directions they emit from, have led to light that
//! counts.
//!
//! Places and directions are points of the unit cube that a lamp samples them from, so a guide fits any lamp. A defensive
//! share keeps everything possible: the density is known, nothing is biased.

mod aperture;
mod learn;
mod portals;
#[cfg(test)]
mod tests;
mod tree;

pub use aperture::{ApertureGuide, Lit};
pub use learn::Even;
use learn::{Weighted, grow};
pub use portals::{Entry, Portals};
use serde::{Deserialize, Serialize};
pub use tree::{AXES, Point, Tree};

/// Guide for all lamps that an estimator traces.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Data", into = "Data")]
pub struct Guide {
    /// Probability of starting on each lamp.
    shares: Vec<f64>,
    /// Running sums of `shares`.
    steps: Vec<f64>,
    /// Per lamp: its tree.
    of_lamp: Vec<u32>,
    trees: Vec<Tree>,
}

/// A guide as it is stored.
#[derive(Serialize, Deserialize)]
struct Data {
    shares: Vec<f64>,
    of_lamp: Vec<u32>,
    trees: Vec<Tree>,
}

/// A start drawn from a guide.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drawn {
    /// Index in the list of lamps that the guide was made for.
    pub lamp: usize,
    /// Point of the lamp's unit cube: place, then direction.
    pub x: Point,
    /// Density of (lamp, x) over that of choosing lamps by flux and all else evenly.
    pub density: f64,
}

/// What a pilot's path has shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    pub lamp: usize,
    pub x: Point,
    /// Its part of the light that counts, with the density it was drawn with taken out; any unit, 0 or more.
    pub weight: f64,
}

impl Guide {
    /// Effective points from which a lamp has a tree of its own; others share one.
    const OWN: f64 = 24.0;
    /// What all lamps together have shown counts as this many points of each: the LEDs of an array light the same lens.
    const POOLED: f64 = 8.0;
    /// Points of the pool that go into a lamp's own tree at most.
    const FROM_POOL: usize = 512;
    /// Most boxes of a tree.
    const LEAVES: usize = 1024;

    /// What nothing was learned for: lamps by flux, all else evenly. `flux`: per lamp, lm.
    pub fn unguided(flux: &[f64]) -> Self {
        Guide::new(shares_of(flux), vec![0; flux.len()], vec![Tree::uniform()])
    }

    /// A first look: half of the paths by flux, half alike for all lamps, so that dim groups are found too.
    pub fn wide(flux: &[f64]) -> Self {
        let even = 1.0 / flux.len().max(1) as f64;
        let shares = shares_of(flux).iter().map(|share| 0.5 * share + 0.5 * even).collect();
        Guide::new(shares, vec![0; flux.len()], vec![Tree::uniform()])
    }

    fn new(shares: Vec<f64>, of_lamp: Vec<u32>, trees: Vec<Tree>) -> Self {
        let mut sum = 0.0;
        let steps = shares
            .iter()
            .map(|share| {
                sum += share;
                sum
            })
            .collect();
        Guide { shares, steps, of_lamp, trees }
    }

    /// Learns from samples that have counted, and leaves a part `even`.
    pub fn learn(flux: &[f64], samples: &[Sample], even: Even) -> Self {
        let lamps = flux.len();
        let most = samples.iter().map(|sample| sample.weight).fold(0.0, f64::max);
        let mut own = vec![Vec::new(); lamps];
        for sample in samples.iter().filter(|sample| sample.weight > 0.0) {
            own[sample.lamp].push(Weighted { x: sample.x, weight: sample.weight / most });
        }
        let sums: Vec<(f64, f64)> = own
            .iter()
            .map(|of| of.iter().fold((0.0, 0.0), |(sum, square), p| (sum + p.weight, square + p.weight * p.weight)))
            .collect();
        let effective = |(sum, square): (f64, f64)| if square > 0.0 { sum * sum / square } else { 0.0 };
        let total = sums.iter().fold((0.0, 0.0), |(a, b), (sum, square)| (a + sum, b + square));
        // Every lamp has the same say in the pool, whatever it adds to the picture.
        let mut pool: Vec<Weighted> = own
            .iter()
            .zip(&sums)
            .flat_map(|(of, (sum, _))| of.iter().map(move |p| Weighted { x: p.x, weight: p.weight / sum }))
            .collect();
        let prior = 0.5 * lamps as f64;
        let by_flux = shares_of(flux);
        let shares = sums
            .iter()
            .zip(&by_flux)
            .map(|((sum, _), by_flux)| {
                let by_gain = if total.0 > 0.0 { sum / total.0 } else { 0.0 };
                let learned = (effective(total) * by_gain + prior * by_flux) / (effective(total) + prior);
                (1.0 - even.of_lamps()) * learned + even.of_lamps() * by_flux
            })
            .collect();
        let stride = pool.len().div_ceil(Self::FROM_POOL).max(1);
        let thinned: Vec<Weighted> = pool.iter().step_by(stride).copied().collect();
        let thinned_sum: f64 = thinned.iter().map(|p| p.weight).sum();
        let mut trees = vec![grow(&mut pool, 0..AXES, Self::LEAVES, even)];
        let mut of_lamp = vec![0; lamps];
        for ((mut points, sums), tree) in own.into_iter().zip(sums).zip(&mut of_lamp) {
            let effective = effective(sums);
            if effective < Self::OWN || lamps == 1 {
                continue;
            }
            let pooled = Self::POOLED / effective * sums.0 / thinned_sum;
            points.extend(thinned.iter().map(|p| Weighted { x: p.x, weight: p.weight * pooled }));
            *tree = trees.len() as u32;
            trees.push(grow(&mut points, 0..AXES, Self::LEAVES, even));
        }
        Guide::new(shares, of_lamp, trees)
    }

    /// Lamps that the guide is for.
    pub fn lamps(&self) -> usize {
        self.shares.len()
    }

    /// Boxes of all trees.
    pub fn leaves(&self) -> usize {
        self.trees.iter().map(Tree::leaves).sum()
    }

    /// Draws a lamp by `choice` and a point from `u`, both uniform. `flux`: what the guide was made with.
    pub fn draw(&self, flux: &[f64], choice: f64, u: Point) -> Option<Drawn> {
        let total = *self.steps.last()?;
        let lamp = self.steps.partition_point(|step| *step <= choice * total).min(self.steps.len() - 1);
        let (x, density) = self.tree(lamp).draw(u);
        Some(Drawn { lamp, x, density: density * self.share(flux, lamp) })
    }

    /// The density of [`Guide::draw`] at a lamp's point, in the unit of [`Drawn::density`].
    pub fn density(&self, flux: &[f64], lamp: usize, x: &Point) -> f64 {
        self.tree(lamp).density(x) * self.share(flux, lamp)
    }

    fn tree(&self, lamp: usize) -> &Tree {
        &self.trees[self.of_lamp[lamp] as usize]
    }

    /// Probability of a lamp over that by flux.
    fn share(&self, flux: &[f64], lamp: usize) -> f64 {
        let total = self.steps.last().copied().unwrap_or(1.0);
        self.shares[lamp] / total * flux.iter().sum::<f64>() / flux[lamp]
    }

    /// A number that changes when the guide does.
    pub fn hash(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        self.shares.iter().for_each(|share| {
            hasher.update(&share.to_le_bytes());
        });
        self.of_lamp.iter().for_each(|tree| {
            hasher.update(&tree.to_le_bytes());
        });
        for tree in &self.trees {
            hasher.update(&tree.bytes().collect::<Vec<u8>>());
        }
        hasher.finalize().to_hex().to_string()
    }
}

fn shares_of(flux: &[f64]) -> Vec<f64> {
    let total: f64 = flux.iter().sum();
    flux.iter().map(|flux| flux / total).collect()
}

impl From<Guide> for Data {
    fn from(guide: Guide) -> Data {
        Data { shares: guide.shares, of_lamp: guide.of_lamp, trees: guide.trees }
    }
}

impl TryFrom<Data> for Guide {
    type Error = String;

    /// Errors: lamps without a tree or with a share that is no probability above 0.
    fn try_from(data: Data) -> Result<Guide, String> {
        if data.shares.len() != data.of_lamp.len() {
            return Err(format!("a guide has {} shares for {} lamps", data.shares.len(), data.of_lamp.len()));
        }
        if let Some(share) = data.shares.iter().find(|share| !(**share > 0.0 && **share <= 1.0 + 1e-9)) {
            return Err(format!("a guide starts on a lamp with probability {share}"));
        }
        if let Some(tree) = data.of_lamp.iter().find(|tree| **tree as usize >= data.trees.len()) {
            return Err(format!("a guide has no tree {tree}"));
        }
        Ok(Guide::new(data.shares, data.of_lamp, data.trees))
    }
}
