//! Sums per scramble: a film of paths that start from even points knows its error from how far the independent scrambles
//! of these points lie apart, since the paths of one scramble are not independent of each other.
//!
//! Eight values tell a variance to about half of itself. How the variance of independent paths would differ from pixel to
//! pixel is known much better, from their squares: each pixel's variance leans on that, times what evenness saves over the
//! whole plane.

use super::accumulate::{Light, MixError};
use crate::base::twofold::Sum;

/// Independent scrambles that the paths of every pass are dealt to in turn.
pub const SCRAMBLES: usize = 8;

/// Sums over paths of one pixel and plane, per scramble.
pub type PerScramble = [f64; SCRAMBLES];

/// How much a pixel's own scrambles count against the plane's.
const OWN: f64 = 0.25;

/// The sums of a film.
#[derive(Debug, Clone, PartialEq)]
pub struct Scrambles {
    /// Share of the paths that each scramble has.
    shares: PerScramble,
    planes: usize,
    /// `[pixel][plane]`: luminance.
    pub(super) value: Vec<[Sum; SCRAMBLES]>,
    /// `[pixel][plane]`: squares of each path's luminance.
    pub(super) squares: Vec<Sum>,
    /// Per plane: variance by scrambles over squares; empty until it is [settled](Scrambles::settle).
    ratios: Vec<f64>,
    /// The same with the slide open, and at C = ∞; empty if not asked for.
    pub(super) open: Vec<[Sum; SCRAMBLES]>,
    pub(super) content: Vec<[Sum; SCRAMBLES]>,
}

fn values(sums: &[Sum; SCRAMBLES]) -> PerScramble {
    sums.map(Sum::value)
}

impl Scrambles {
    /// Of `paths` paths in a pass, path i belongs to scramble i mod [`SCRAMBLES`].
    pub fn new(pixels: usize, planes: usize, paths: u64) -> Self {
        let count = SCRAMBLES as u64;
        let own = |s: usize| (paths / count + u64::from((s as u64) < paths % count)) as f64;
        let shares = std::array::from_fn(|s| own(s) / paths.max(1) as f64);
        let entries = pixels * planes;
        Scrambles {
            shares,
            planes,
            value: vec![[Sum::ZERO; SCRAMBLES]; entries],
            squares: vec![Sum::ZERO; entries],
            ratios: Vec::new(),
            open: Vec::new(),
            content: Vec::new(),
        }
    }

    /// Keeps what [`Scrambles::mix_error`] needs.
    pub fn keep_mixed(&mut self) {
        self.open = vec![[Sum::ZERO; SCRAMBLES]; self.value.len()];
        self.content = self.open.clone();
    }

    /// Adds the light of one path.
    pub fn add(&mut self, entry: usize, scramble: usize, light: Light) {
        self.value[entry][scramble].add(light.value);
        self.squares[entry].add(light.value * light.value);
        if let (Some(open), Some(content)) = (self.open.get_mut(entry), self.content.get_mut(entry)) {
            open[scramble].add(light.open());
            content[scramble].add(light.content());
        }
    }

    /// To be called when paths have been added, before variances are asked for.
    pub fn settle(&mut self) {
        let of_plane = |plane: usize| {
            let entries = || (plane..self.value.len()).step_by(self.planes);
            let variance: f64 = entries().map(|entry| self.own_variance(entry)).sum();
            let squares: f64 = entries().map(|entry| self.squares[entry].value()).sum();
            if squares > 0.0 { variance / squares } else { 0.0 }
        };
        self.ratios = (0..self.planes).map(of_plane).collect();
    }

    /// Variance of the sum over all paths of one pixel in one plane, by its scrambles alone.
    fn own_variance(&self, entry: usize) -> f64 {
        let own = values(&self.value[entry]);
        self.covariance(&own, &own)
    }

    /// Variance of the sum over all paths of the light of a pixel in these planes together.
    pub fn variance(&self, pixel: usize, planes: impl Iterator<Item = usize>) -> f64 {
        let mut sums = [0.0; SCRAMBLES];
        let mut of_plane = 0.0;
        for plane in planes {
            let entry = pixel * self.planes + plane;
            sums.iter_mut().zip(&self.value[entry]).for_each(|(sum, own)| *sum += own.value());
            of_plane += self.ratios.get(plane).map_or(0.0, |ratio| ratio * self.squares[entry].value());
        }
        let own = self.covariance(&sums, &sums).max(0.0);
        if self.ratios.is_empty() { own } else { OWN * own + (1.0 - OWN) * of_plane }
    }

    /// Variances and covariance of the sums of `open` and `content` of a pixel in these planes together; none if they are
    /// not kept.
    pub fn mix_error(&self, pixel: usize, planes: impl Iterator<Item = usize>) -> Option<MixError> {
        let (mut open, mut content) = ([0.0; SCRAMBLES], [0.0; SCRAMBLES]);
        for plane in planes {
            let entry = pixel * self.planes + plane;
            let (own_open, own_content) = (values(self.open.get(entry)?), values(self.content.get(entry)?));
            open.iter_mut().zip(own_open).for_each(|(sum, own)| *sum += own);
            content.iter_mut().zip(own_content).for_each(|(sum, own)| *sum += own);
        }
        Some(MixError {
            open: self.covariance(&open, &open).max(0.0),
            content: self.covariance(&content, &content).max(0.0),
            covariance: self.covariance(&open, &content),
        })
    }

    /// Covariance of Σ aₛ and Σ bₛ from how far each scramble lies from its share: exact where all shares are alike. Zero
    /// with fewer than two scrambles.
    fn covariance(&self, a: &PerScramble, b: &PerScramble) -> f64 {
        let used = self.shares.iter().filter(|share| **share > 0.0).count() as f64;
        if used < 2.0 {
            return 0.0;
        }
        let (sum_a, sum_b): (f64, f64) = (a.iter().sum(), b.iter().sum());
        let apart = |s: usize| (a[s] - self.shares[s] * sum_a) * (b[s] - self.shares[s] * sum_b);
        (0..SCRAMBLES).map(apart).sum::<f64>() * used / (used - 1.0)
    }
}
