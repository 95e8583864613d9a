//! Sums per scramble: a film of paths that start from even points knows its error from how far the independent scrambles
//! of these points lie apart, since the paths of one scramble are not independent of each other.

use super::accumulate::{Light, MixError};

/// Independent scrambles that the paths of every pass are dealt to in turn.
pub const SCRAMBLES: usize = 8;

/// Sums over paths of one pixel and plane, per scramble.
pub type PerScramble = [f64; SCRAMBLES];

/// The sums of a film.
#[derive(Debug, Clone, PartialEq)]
pub struct Scrambles {
    /// Share of the paths that each scramble has.
    shares: PerScramble,
    /// `[pixel][plane]`: luminance.
    value: Vec<PerScramble>,
    /// The same with the slide open, and at C = ∞; empty if not asked for.
    open: Vec<PerScramble>,
    content: Vec<PerScramble>,
}

impl Scrambles {
    /// `entries`: pixels times planes. Of `paths` paths in a pass, path i belongs to scramble i mod [`SCRAMBLES`].
    pub fn new(entries: usize, paths: u64) -> Self {
        let count = SCRAMBLES as u64;
        let own = |s: usize| (paths / count + u64::from((s as u64) < paths % count)) as f64;
        let shares = std::array::from_fn(|s| own(s) / paths.max(1) as f64);
        Scrambles { shares, value: vec![[0.0; SCRAMBLES]; entries], open: Vec::new(), content: Vec::new() }
    }

    /// Keeps what [`Scrambles::mix_error`] needs.
    pub fn keep_mixed(&mut self) {
        self.open = vec![[0.0; SCRAMBLES]; self.value.len()];
        self.content = self.open.clone();
    }

    /// Adds the light of one path.
    pub fn add(&mut self, entry: usize, scramble: usize, light: Light) {
        self.value[entry][scramble] += light.value;
        if let (Some(open), Some(content)) = (self.open.get_mut(entry), self.content.get_mut(entry)) {
            open[scramble] += light.open();
            content[scramble] += light.content();
        }
    }

    /// Variance of the sum over all paths of the light in these entries together.
    pub fn variance(&self, entries: impl Iterator<Item = usize>) -> f64 {
        let mut sums = [0.0; SCRAMBLES];
        for entry in entries {
            sums.iter_mut().zip(&self.value[entry]).for_each(|(sum, own)| *sum += own);
        }
        self.covariance(&sums, &sums).max(0.0)
    }

    /// Variances and covariance of the sums of `open` and `content`; none if they are not kept.
    pub fn mix_error(&self, entry: usize) -> Option<MixError> {
        let (open, content) = (self.open.get(entry)?, self.content.get(entry)?);
        Some(MixError {
            open: self.covariance(open, open).max(0.0),
            content: self.covariance(content, content).max(0.0),
            covariance: self.covariance(open, content),
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
