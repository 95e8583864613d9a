//! Sums per scramble: a film of paths that start from even points knows its error from how far the independent scrambles
//! of these points lie apart, since the paths of one scramble are not independent of each other.
//!
//! Eight values tell a variance to about half of itself. How the variance of independent paths would differ from pixel to
//! pixel is known much better, from their squares: each pixel's variance leans on that, times what evenness saves over the
//! whole plane.

use super::accumulate::light::{Light, MixError};
use super::tiles::Tiles;
use eyebox_base::double_double::Sum;

/// Independent scrambles that the paths of every pass are dealt to in turn.
pub const REPLICATES: usize = 8;

/// Sums over paths of one pixel and plane, per scramble.
pub type PerScramble = [f64; REPLICATES];

/// How much a pixel's own scrambles count against the plane's.
const OWN: f64 = 0.25;

/// The sums of a film.
#[derive(Debug, Clone, PartialEq)]
pub struct Replicates {
    /// Share of the paths that each scramble has.
    shares: PerScramble,
    planes: usize,
    size: [usize; 2],
    /// `[pixel][plane]`: luminance.
    pub(super) value: Tiles,
    /// `[pixel][plane]`: squares of each path's luminance.
    pub(super) squares: Tiles,
    /// Per plane: variance by scrambles over squares; empty until it is [settled](Scrambles::settle).
    ratios: Vec<f64>,
    /// The same with the slide open, and at C = ∞; none if not asked for.
    pub(super) mixed: Option<[Tiles; 2]>,
}

/// Of the sums that are stored: all or none.
fn values(sums: &[Sum]) -> PerScramble {
    std::array::from_fn(|scramble| sums.get(scramble).map_or(0.0, |sum| sum.value()))
}

fn add(tiles: &mut Tiles, (pixel, plane): (usize, usize), scramble: usize, value: f64) {
    if value != 0.0 {
        tiles.grown(pixel, plane, REPLICATES)[scramble].add(value);
    }
}

impl Replicates {
    /// Of `paths` paths in a pass, path i belongs to scramble i mod [`REPLICATES`].
    pub fn new(size: [usize; 2], planes: usize, paths: u64) -> Self {
        let count = REPLICATES as u64;
        let own = |s: usize| (paths / count + u64::from((s as u64) < paths % count)) as f64;
        let shares = std::array::from_fn(|s| own(s) / paths.max(1) as f64);
        Replicates {
            shares,
            planes,
            size,
            value: Tiles::new(size, planes, REPLICATES),
            squares: Tiles::new(size, planes, 1),
            ratios: Vec::new(),
            mixed: None,
        }
    }

    /// Keeps what [`Replicates::mix_error`] needs.
    pub fn keep_mixed(&mut self) {
        self.mixed = Some([0, 1].map(|_| Tiles::new(self.size, self.planes, REPLICATES)));
    }

    /// Adds the light of one path to a pixel and plane.
    pub fn add(&mut self, at: (usize, usize), scramble: usize, light: Light) {
        add(&mut self.value, at, scramble, light.value);
        if light.value != 0.0 {
            self.squares.grown(at.0, at.1, 1)[0].add(light.value * light.value);
        }
        if let Some([open, content]) = &mut self.mixed {
            add(open, at, scramble, light.open());
            add(content, at, scramble, light.content());
        }
    }

    /// To be called when paths have been added, before variances are asked for.
    pub fn settle(&mut self) {
        let of_plane = |plane: usize| {
            let entries = || (0..self.size[0] * self.size[1]).map(|pixel| (pixel, plane));
            let variance: f64 = entries().map(|entry| self.own_variance(entry)).sum();
            let squares: f64 = entries().map(|(pixel, plane)| self.squares.sum(pixel, plane).value()).sum();
            if squares > 0.0 { variance / squares } else { 0.0 }
        };
        self.ratios = (0..self.planes).map(of_plane).collect();
    }

    /// Variance of the sum over all paths of one pixel in one plane, by its scrambles alone.
    fn own_variance(&self, (pixel, plane): (usize, usize)) -> f64 {
        let own = values(self.value.stored(pixel, plane));
        self.covariance(&own, &own)
    }

    /// Variance of the sum over all paths of the light of a pixel in these planes together.
    pub fn variance(&self, pixel: usize, planes: impl Iterator<Item = usize>) -> f64 {
        let mut sums = [0.0; REPLICATES];
        let mut of_plane = 0.0;
        for plane in planes {
            sums.iter_mut().zip(self.value.stored(pixel, plane)).for_each(|(sum, own)| *sum += own.value());
            of_plane += self.ratios.get(plane).map_or(0.0, |ratio| ratio * self.squares.sum(pixel, plane).value());
        }
        let own = self.covariance(&sums, &sums).max(0.0);
        if self.ratios.is_empty() { own } else { OWN * own + (1.0 - OWN) * of_plane }
    }

    /// Variances and covariance of the sums of `open` and `content` of a pixel in these planes together; none if they are
    /// not kept.
    pub fn mix_error(&self, pixel: usize, planes: impl Iterator<Item = usize>) -> Option<MixError> {
        let (mut open, mut content) = ([0.0; REPLICATES], [0.0; REPLICATES]);
        for plane in planes {
            let [own_open, own_content] = self.mixed.as_ref()?.each_ref().map(|own| values(own.stored(pixel, plane)));
            open.iter_mut().zip(own_open).for_each(|(sum, own)| *sum += own);
            content.iter_mut().zip(own_content).for_each(|(sum, own)| *sum += own);
        }
        Some(MixError {
            open: self.covariance(&open, &open).max(0.0),
            content: self.covariance(&content, &content).max(0.0),
            covariance: self.covariance(&open, &content),
        })
    }

    /// Variance of the sum of `content` − `open` of a pixel in a plane; none if they are not kept.
    pub fn change_variance(&self, pixel: usize, plane: usize) -> Option<f64> {
        let [open, content] = self.mixed.as_ref()?.each_ref().map(|own| values(own.stored(pixel, plane)));
        let change: PerScramble = std::array::from_fn(|scramble| content[scramble] - open[scramble]);
        Some(self.covariance(&change, &change).max(0.0))
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
        (0..REPLICATES).map(apart).sum::<f64>() * used / (used - 1.0)
    }
}
