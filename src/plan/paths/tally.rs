//! Sums over the paths of one row of the table: flux with its error, and where in the picture the light arrives.

use super::lamp_paths::Source;
use eyebox_world::eye::EyeLens;
use std::collections::{BTreeMap, BTreeSet};

/// What was found of one row.
#[derive(Debug, Clone, Default)]
pub struct Tally {
    /// Paths that arrived.
    pub count: u64,
    /// Sums over paths, each path one number: lm (luminance where the pupil is a point), and its square.
    amount: f64,
    squares: f64,
    /// What paths with even points brought.
    even: f64,
    /// The same over passes; the pass under way.
    passes: f64,
    pass: (u64, f64),
    /// Sum over pixels of their luminance, cd/m².
    pub luminance: f64,
    /// Per pixel: arrivals, luminance.
    pixels: BTreeMap<u32, (u32, f64)>,
    pub sources: BTreeSet<Source>,
}

/// Where a row's light arrives.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct Footprint {
    /// Share of the picture's pixels that are reached.
    pub share: f64,
    /// The rectangle around what was found, degrees right of and above the middle of the picture: left, right, bottom,
    /// top.
    pub degrees: [f64; 4],
}

impl Tally {
    /// Adds what one path brought to one pixel.
    pub fn arrive(&mut self, pixel: u32, luminance: f64) {
        self.luminance += luminance;
        let at = self.pixels.entry(pixel).or_default();
        *at = (at.0.saturating_add(1), at.1 + luminance);
    }

    /// Adds a path by all that it brought.
    /// `even`: of paths with even points, whose errors are less than those of independent ones.
    pub fn path(&mut self, pass: u64, amount: f64, even: bool) {
        self.count += 1;
        self.close(pass);
        self.amount += amount;
        self.even += if even { amount } else { 0.0 };
        self.squares += amount * amount;
        self.pass.1 += amount;
    }

    fn close(&mut self, pass: u64) {
        if self.pass.0 != pass {
            self.passes += self.pass.1 * self.pass.1;
            self.pass = (pass, 0.0);
        }
    }

    /// What arrived, of which `passes` passes bring an estimate each.
    pub fn mean(&self, passes: u64) -> f64 {
        self.amount / passes as f64
    }

    /// Most of the light is that of paths with even points.
    pub fn is_even(&self) -> bool {
        self.even > 0.5 * self.amount
    }

    /// One-sigma error of [`Tally::mean`]: from the passes where most paths had even points; else from the paths, `paths` per
    /// pass, unless passes scatter more.
    pub fn stderr(&self, passes: u64, paths: u64) -> f64 {
        let (n, total) = (passes as f64, passes as f64 * paths as f64);
        let of_paths = self.squares - self.amount * self.amount / total;
        let squares = self.passes + self.pass.1 * self.pass.1;
        let of_passes = if passes > 1 { (squares - self.amount * self.amount / n) * n / (n - 1.0) } else { 0.0 };
        let of_paths = if self.is_even() { 0.0 } else { of_paths };
        of_paths.max(of_passes).max(0.0).sqrt() / n
    }

    /// Pixels that the light reaches, hit by a path or not: S + f₁²/2f₂ with S pixels hit, f₁ of them once and f₂ twice
    /// (A. Chao, "Nonparametric estimation of the number of classes in a population", 1984; the form without f₂ = 0).
    fn reached(&self, most: f64) -> f64 {
        let times = |k: u32| self.pixels.values().filter(|(count, _)| *count == k).count() as f64;
        let (once, twice) = (times(1), times(2));
        (self.pixels.len() as f64 + 0.5 * once * (once - 1.0).max(0.0) / (twice + 1.0)).min(most)
    }

    /// Where the light arrives, and its mean and peak luminance there, cd/m². The peak is that of the brightest block of
    /// pixels, where blocks are as small as [`Tally::PER_BLOCK`] arrivals each allow.
    /// `looked`: paths from the eye, which are spread evenly over the picture, if it was they that found the light.
    pub fn footprint(&self, eye: &EyeLens, passes: u64, looked: Option<u64>) -> (Footprint, f64, f64) {
        let [width, height] = eye.size();
        let most = (width * height) as f64;
        let reached = match looked {
            Some(paths) => most * self.count as f64 / paths as f64,
            None => self.reached(most).max(1.0),
        };
        let mean = self.luminance / passes as f64 / reached;
        let peak = self.peak([width, height], reached) / passes as f64;
        let place = |pixel: u32, jitter: [f64; 2]| {
            let (x, y) = (pixel as usize % width.max(1), pixel as usize / width.max(1));
            eye.film_of(x, y, jitter).to_array().map(|tangent| tangent.atan().to_degrees())
        };
        let mut degrees = [f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY];
        for &pixel in self.pixels.keys() {
            let ([left, top], [right, bottom]) = (place(pixel, [0.0, 0.0]), place(pixel, [1.0, 1.0]));
            degrees = [degrees[0].min(left), degrees[1].max(right), degrees[2].min(bottom), degrees[3].max(top)];
        }
        (Footprint { share: reached / most, degrees }, mean, peak.max(mean))
    }

    const PER_BLOCK: usize = 64;

    fn peak(&self, [width, height]: [usize; 2], reached: f64) -> f64 {
        let count: u64 = self.pixels.values().map(|(count, _)| u64::from(*count)).sum();
        let mut side = 1;
        loop {
            let mut blocks: BTreeMap<(usize, usize), f64> = BTreeMap::new();
            for (pixel, (_, luminance)) in &self.pixels {
                let at = (*pixel as usize % width.max(1) / side, *pixel as usize / width.max(1) / side);
                *blocks.entry(at).or_default() += luminance;
            }
            if count as usize / blocks.len().max(1) >= Self::PER_BLOCK {
                let area = |(x, y): (usize, usize)| (width - x * side).min(side) * (height - y * side).min(side);
                return blocks.iter().map(|(at, sum)| sum / area(*at).max(1) as f64).fold(0.0, f64::max);
            }
            if side >= width.max(height) {
                return self.luminance / reached;
            }
            side *= 2;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyebox_base::rng::{Rng, Stream};

    /// Half of the pixels, hit evenly by fewer paths than there are pixels: the share is found without seeing them all.
    #[test]
    fn the_reach_is_more_than_what_was_hit() {
        let mut tally = Tally::default();
        let mut rng = Rng::new(4, Stream::Check, 0, 0);
        for _ in 0..4000 {
            let pixel = (rng.uniform() * 8000.0) as u32;
            tally.arrive(pixel, 1.0);
        }
        let hit = tally.pixels.len() as f64;
        let reached = tally.reached(16_000.0);
        assert!(hit < 3300.0 && (reached / 8000.0 - 1.0).abs() < 0.1, "{hit} {reached}");
    }

    /// The error of a mean of independent paths; a common factor per pass is seen as well.
    #[test]
    fn errors_come_from_paths_or_passes() {
        let mut rng = Rng::new(5, Stream::Check, 0, 0);
        let mut means = [eyebox_base::stats::Moments::default(); 2];
        let mut stated = [0.0; 2];
        for _ in 0..200 {
            let mut tallies = [Tally::default(), Tally::default()];
            for pass in 0..16 {
                let common = 0.5 + rng.uniform();
                for _ in 0..50 {
                    let own = rng.uniform();
                    tallies[0].path(pass, own / 50.0, false);
                    tallies[1].path(pass, own * common / 50.0, false);
                }
            }
            for k in 0..2 {
                means[k].add(tallies[k].mean(16));
                stated[k] += tallies[k].stderr(16, 50) / 200.0;
            }
        }
        for k in 0..2 {
            let ratio = stated[k] / means[k].variance().sqrt();
            assert!((0.85..1.35).contains(&ratio), "{k}: {ratio}");
        }
    }
}
