//! The light of a picture's cells, batch by batch of passes: what a sum over pixels that share photons is worth.
//!
//! The film knows the variance of a pixel. That of a sum over pixels is more where they share a photon, and less where
//! places in a pixel are chosen evenly; the sums of a few dozen batches know both.

use eyebox_base::students_t::{as_normal, unskewed, welch};

/// Cells per side, at most.
pub const CELLS: usize = 8;
/// A cell has at least so many pixels per side.
const PIXELS: usize = 4;
/// Batches are made twice as long when there would be more.
const MOST: usize = 64;

/// Batches from which on their skewness says something.
const SKEW: usize = 16;

/// A picture's pixels in cells, row by row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Grid {
    size: [usize; 2],
}

impl Grid {
    /// Of a picture of this width and height.
    pub fn new(size: [usize; 2]) -> Grid {
        Grid { size }
    }

    fn cells(self) -> [usize; 2] {
        self.size.map(|pixels| (pixels / PIXELS).clamp(1, CELLS))
    }

    fn cell(self, pixel: usize) -> usize {
        let ([width, height], [columns, rows]) = (self.size, self.cells());
        let (x, y) = (pixel % width.max(1), pixel / width.max(1));
        y * rows / height.max(1) * columns + x * columns / width.max(1)
    }

    /// Sums of the pixels' values over each cell.
    pub fn sums(self, values: impl Iterator<Item = f64>) -> Vec<f64> {
        let mut sums = vec![0.0; self.cells().iter().product()];
        values.enumerate().for_each(|(pixel, value)| sums[self.cell(pixel)] += value);
        sums
    }

    /// The cells in blocks, at most `side` × `side`.
    pub fn blocks(self, side: usize) -> Vec<Vec<usize>> {
        let [columns, rows] = self.cells();
        let [across, down] = [columns, rows].map(|cells| cells.min(side.max(1)));
        let mut blocks = vec![Vec::new(); across * down];
        for cell in 0..columns * rows {
            blocks[cell / columns * down / rows * across + cell % columns * across / columns].push(cell);
        }
        blocks
    }
}

/// What is known of how sure a light is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Worth {
    pub variance: f64,
    /// Degrees of freedom of that.
    pub freedom: f64,
    /// Third cumulant: of light that comes seldom and bright it is more than 0.
    pub third: f64,
}

impl Worth {
    /// What variances state that are known for sure.
    pub fn stated(variance: f64) -> Worth {
        Worth { variance, freedom: f64::INFINITY, third: 0.0 }
    }

    /// Of the difference of two lights, of which the other counts so much.
    #[must_use]
    pub fn less(self, other: Worth, share: f64) -> Worth {
        let other = Worth { variance: other.variance * share * share, ..other };
        Worth {
            variance: self.variance + other.variance,
            freedom: welch([self.variance, self.freedom], [other.variance, other.freedom]),
            third: self.third - other.third * share.powi(3),
        }
    }

    /// Of half the sum of two lights.
    #[must_use]
    pub fn mean(self, other: Worth) -> Worth {
        Worth::stated(0.0).less(self, -0.5).less(other, -0.5)
    }

    /// A deviation as a normal deviate.
    pub fn sigmas(self, off: f64) -> f64 {
        if off == 0.0 {
            return 0.0;
        }
        let deviation = self.variance.sqrt();
        as_normal(unskewed(off / deviation, self.third / deviation.powi(3)), self.freedom)
    }
}

/// The light of each cell after so many passes, 2 × `width` passes, … and at the end.
#[derive(Debug, Clone, PartialEq)]
pub struct Batches {
    width: u64,
    /// Sum over the passes up to the end of each batch.
    sums: Vec<Vec<f64>>,
    passes: u64,
}

impl Default for Batches {
    fn default() -> Self {
        Batches { width: 1, sums: Vec::new(), passes: 0 }
    }
}

impl Batches {
    /// After how many passes in all the next batch ends.
    pub fn next(&self) -> u64 {
        (self.sums.len() as u64 + 1).saturating_mul(self.width)
    }

    /// After `passes` passes, no more than [`Batches::next`], the mean of a pass is `cells`.
    pub fn add(&mut self, passes: u64, cells: &[f64]) {
        self.passes = passes;
        if passes < self.next() {
            return;
        }
        self.sums.push(cells.iter().map(|mean| mean * passes as f64).collect());
        if self.sums.len() == MOST {
            // Every second end is an end of a batch twice as long.
            let mut ends = [false, true].into_iter().cycle();
            self.sums.retain(|_| ends.next() == Some(true));
            self.width *= 2;
        }
    }

    /// What is known of the mean pass's light in a block of cells; none before the second batch.
    pub fn worth(&self, block: &[usize]) -> Option<Worth> {
        let count = self.sums.len();
        if count < 2 {
            return None;
        }
        let light = |sums: &Vec<f64>| block.iter().map(|&cell| sums[cell]).sum::<f64>();
        let ends: Vec<f64> = std::iter::once(0.0).chain(self.sums.iter().map(light)).collect();
        let mean = ends[count] / count as f64;
        let powers = |power: i32| -> f64 { ends.windows(2).map(|ends| (ends[1] - ends[0] - mean).powi(power)).sum() };
        let (width, passes, freedom) = (self.width as f64, self.passes as f64, (count - 1) as f64);
        // Of a batch; of a pass so much less; of the mean of all passes less again.
        let variance = powers(2) / freedom / width / passes;
        let third = if count < SKEW { 0.0 } else { powers(3) * count as f64 / (freedom * (freedom - 1.0)) };
        Some(Worth { variance, freedom, third: third / width / passes.powi(2) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyebox_base::rng::{Rng, Stream};
    use eyebox_base::stats::Moments;

    /// What passes of a light bring is worth.
    fn worth(seed: u64, light: impl Fn(&mut Rng) -> f64) -> (f64, Worth) {
        const PASSES: u64 = 1024;
        let mut rng = Rng::new(seed, Stream::Check, 1, 0);
        let (mut batches, mut sum) = (Batches::default(), 0.0);
        for pass in 1..=PASSES {
            sum += light(&mut rng);
            if pass == batches.next() || pass == PASSES {
                batches.add(pass, &[sum / pass as f64]);
            }
        }
        (sum / PASSES as f64, batches.worth(&[0]).unwrap())
    }

    /// A picture that is right is compared with references in which bright light came eight times, or less: by their variance
    /// alone six times as many as there should be are told to be wrong. A picture that is wrong is found as before.
    #[test]
    fn rare_light_that_is_missing_is_no_bias() {
        const SEEDS: u64 = 4000;
        let rare = |rng: &mut Rng| if rng.uniform() < 1.0 / 128.0 { 128.0 } else { 0.0 };
        let exact = Worth::stated(0.0);
        let (mut plain, mut told, mut third) = (0u64, 0u64, Moments::default());
        for seed in 0..SEEDS {
            let (mean, worth) = worth(seed, rare);
            third.add(worth.third);
            let off = 1.0 - mean;
            plain += u64::from(Worth { third: 0.0, ..exact.less(worth, 1.0) }.sigmas(off).abs() > 3.0);
            told += u64::from(exact.less(worth, 1.0).sigmas(off).abs() > 3.0);
        }
        let want = 0.0027 * SEEDS as f64;
        // Of a pass 128² − 3·128 + 2.
        let want_third = (128.0f64.powi(2) - 3.0 * 128.0 + 2.0) / 1024f64.powi(2);
        let off = (third.mean - want_third).abs();
        assert!(off < 4.0 * third.stderr() && third.stderr() < 0.1 * want_third, "{third:?} {want_third}");
        assert!(plain as f64 > 3.0 * want && (told as f64) < 1.5 * want, "{plain} {told} of {want}");
        let mut kept = Moments::default();
        for seed in 0..100 {
            let (mean, worth) = worth(seed, Rng::uniform);
            let off = 0.5 - mean + 8.0 * worth.variance.sqrt();
            let sigmas = exact.less(worth, 1.0).sigmas(off);
            kept.add(sigmas / Worth { third: 0.0, ..exact.less(worth, 1.0) }.sigmas(off));
            assert!(sigmas > 3.0, "{seed}: {sigmas}");
        }
        assert!((kept.mean - 1.0).abs() < 0.05, "{kept:?}");
    }

    #[test]
    fn cells_and_blocks_hold_each_pixel_once() {
        for size in [[32, 24], [1, 1], [7, 300], [360, 180], [33, 9]] {
            let grid = Grid::new(size);
            let sums = grid.sums((0..size[0] * size[1]).map(|_| 1.0));
            assert_eq!(sums.iter().sum::<f64>(), (size[0] * size[1]) as f64);
            assert!(sums.iter().all(|sum| *sum > 0.0), "{size:?} {sums:?}");
            for side in [8, 4, 2, 1] {
                let mut cells: Vec<usize> = grid.blocks(side).concat();
                assert!(grid.blocks(side).iter().all(|block| !block.is_empty()));
                cells.sort_unstable();
                assert_eq!(cells, (0..sums.len()).collect::<Vec<_>>());
            }
        }
        assert_eq!([8, 4, 2, 1].map(|side| Grid::new([32, 24]).blocks(side).len()), [48, 16, 4, 1]);
        assert_eq!(Grid::new([0, 0]).sums(std::iter::empty()), [0.0]);
    }

    /// Two cells whose light comes and goes together, as of one photon: the variance of their sum is four times, not twice,
    /// that of one, and what batches say of it is right in the mean, however many passes there are.
    #[test]
    fn shared_light_is_counted_as_such() {
        for passes in [2u64, 3, 64, 65, 1000] {
            let mut stated = Moments::default();
            for seed in 0..400 {
                let mut rng = Rng::new(seed, Stream::Check, passes, 0);
                let (mut batches, mut sum) = (Batches::default(), 0.0);
                for pass in 1..=passes {
                    sum += rng.uniform();
                    let mean = sum / pass as f64;
                    if pass == batches.next() || pass == passes {
                        batches.add(pass, &[mean, mean, 1.0]);
                    }
                }
                let Worth { variance, freedom, .. } = batches.worth(&[0, 1]).unwrap();
                assert!(batches.worth(&[2]).unwrap().variance < 1e-20 && (1.0..64.0).contains(&freedom));
                stated.add(variance);
            }
            let want = 4.0 / 12.0 / passes as f64;
            let off = stated.mean - want;
            assert!(off.abs() < 4.0 * stated.stderr() && stated.stderr() < 0.1 * want, "{passes}: {stated:?} {want}");
        }
        let mut one = Batches::default();
        one.add(1, &[1.0]);
        assert_eq!(one.worth(&[0]), None);
    }
}
