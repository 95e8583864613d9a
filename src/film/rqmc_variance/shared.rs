//! What evenness saves where all pixels of a pass share what it draws: passes of one part draw nearly the same, and only what they
//! differ by within it is left to chance. The variance of a mean over parts (post-stratification, e.g. W. G. Cochran, "Sampling
//! Techniques", 3rd ed., 1977, chapter 5A.9): what the passes differ by within their parts, and the parts that have more or fewer
//! passes than their due. Parts of a net's passes are even in themselves, too, so that it is more than it is.
//!
//! Few passes make few parts, and what a wide part differs by within it is much more than what the mean errs by. But some passes one
//! after the other are even in themselves as well: runs of these, as if independent of each other, are another way to tell. Where the
//! parts have many passes each, those of neighbouring parts make up such runs. Of all ways, each with what chance may hide, the one
//! that tells the least counts: what the passes are independent in is in all of them.

use super::{FREEDOM, PixelMean, RqmcVariance, SIGMAS};

/// Parts of the passes, a power of two.
pub(super) const PARTS: usize = 32;
/// So many pixels tell enough: they share most of what they tell.
pub(super) const MOST: usize = 1 << 14;
/// Passes that a part must have to tell how they differ.
const FEWEST: f64 = 2.0;
/// Passes of a run, and how many runs there have to be.
const RUNS_OF: [usize; 3] = [2, 4, 8];
const FEWEST_RUNS: usize = 4;

/// The part of a pass: that of its wavelengths, by the lowest bits of its number.
pub(super) fn part(pass: u64) -> usize {
    (pass % PARTS as u64) as usize
}

/// How many passes before this one are of a part.
pub(super) fn before(pass: u64, part: usize) -> i64 {
    (pass / PARTS as u64 + u64::from(pass % PARTS as u64 > part as u64)) as i64
}

/// The asked pixels of some number of passes.
struct Shared<'s, Own, OfPixel> {
    turns: &'s RqmcVariance,
    /// How many passes there are of each part.
    counts: Vec<f64>,
    own: Own,
    of_pixel: OfPixel,
}

impl<Own: Fn(usize) -> bool, OfPixel: Fn(usize) -> PixelMean> Shared<'_, Own, OfPixel> {
    fn passes(&self) -> f64 {
        self.counts.iter().sum()
    }

    /// Sums of `of` over the pixels, by what is stated of them otherwise. `group`: that of each part, of so many; `of`: for a
    /// pixel's spread, and how far the groups' means are from that.
    fn compared(
        &self,
        (groups, group): (usize, &dyn Fn(usize) -> usize),
        of: impl Fn(f64, &[f64], &[f64]) -> f64,
    ) -> f64 {
        let mut counts = vec![0.0; groups];
        (0..PARTS).for_each(|part| counts[group(part)] += self.counts[part]);
        let (mut by_passes, mut by_groups) = (0.0, 0.0);
        for (pixel, sums) in self.turns.pixels(&self.own) {
            let PixelMean { mean, spread, variance } = (self.of_pixel)(pixel);
            let mut off = vec![0.0; groups];
            (0..PARTS).for_each(|part| off[group(part)] += sums[part].value() - self.counts[part] * mean);
            let mean_off = off.iter().zip(&counts).map(|(off, count)| if *count > 0.0 { off / count } else { 0.0 });
            by_passes += variance;
            by_groups += of(spread, &mean_off.collect::<Vec<_>>(), &counts);
        }
        by_groups / by_passes
    }

    /// What is left of the variance by parts with the same lower bits, of which each has passes enough.
    fn by_parts(&self) -> Option<f64> {
        let all = self.passes();
        let most = PARTS.min((all / FEWEST) as usize);
        let parts = 1 << most.checked_ilog2()?;
        let of = |part: usize| (part..PARTS).step_by(parts).map(|k| self.counts[k]).sum::<f64>();
        if parts < 2 || (0..parts).any(|part| of(part) < FEWEST) {
            return None;
        }
        let freedom = all - parts as f64;
        let left = self.compared((parts, &|part| part % parts), |spread, off, counts| {
            let (mut between, mut uneven) = (0.0, 0.0);
            for (off, count) in off.iter().zip(counts) {
                between += count * off * off;
                uneven += (count / all - 1.0 / parts as f64) * off;
            }
            let within = (spread * all * (all - 1.0) - between).max(0.0);
            within / freedom / all + uneven * uneven
        });
        Some(left * (1.0 + SIGMAS * (2.0 / freedom).sqrt()))
    }

    /// The same by runs of so many passes one after the other, which are even in themselves: by how they differ.
    fn by_runs(&self, run: usize) -> Option<f64> {
        let filled =
            (0..PARTS / run).filter(|k| self.counts[k * run..][..run].iter().any(|count| *count > 0.0)).count();
        if filled < FEWEST_RUNS {
            return None;
        }
        let (all, freedom) = (self.passes(), filled as f64 - 1.0);
        let left = self.compared((PARTS / run, &|part| part / run), |_, off, counts| {
            off.iter().zip(counts).map(|(off, count)| count * off * off).sum::<f64>() / freedom / all
        });
        Some(left * (1.0 + SIGMAS * (2.0 / freedom).sqrt()))
    }
}

impl RqmcVariance {
    /// See [`RqmcVariance::saved`]. Passes that the pixels share tell as little as one pixel's.
    pub(super) fn saved_by_parts(
        &self,
        (passes, made): (u64, &[i64]),
        own: impl Fn(usize) -> bool,
        of_pixel: impl Fn(usize) -> PixelMean,
    ) -> f64 {
        let counts: Vec<f64> = made.iter().map(|count| *count as f64).collect();
        let shared = Shared { turns: self, counts, own, of_pixel };
        if shared.passes() != passes as f64 {
            return 1.0;
        }
        // What few pixels differ by may be small by chance, in one of several ways all the more.
        let spreads = self.pixels(&shared.own).map(|(pixel, _)| (shared.of_pixel)(pixel).spread);
        let (sum, squares) = spreads.fold((0.0, 0.0), |(sum, squares), own| (sum + own, squares + own * own));
        let several = sum * sum / squares;
        if several.is_nan() || several < FREEDOM {
            return 1.0;
        }
        let ways = RUNS_OF.iter().filter_map(|run| shared.by_runs(*run)).chain(shared.by_parts());
        ways.filter(|saved| !saved.is_nan()).fold(1.0, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Evenness;
    use super::*;
    use eyebox_base::rng::{Rng, Stream};

    #[test]
    fn passes_are_counted_by_their_parts() {
        for number in 0..PARTS {
            for pass in 0..100 {
                assert_eq!(before(pass, number), (0..pass).filter(|pass| part(*pass) == number).count() as i64);
            }
        }
    }

    /// Means over passes that share a number in van der Corput's order, of values that follow it all alike, and of some noise of
    /// their own: what is stated and what the mean of many runs really errs by.
    #[test]
    fn parts_tell_what_shared_numbers_save() {
        const PIXELS: usize = 200;
        const RUNS: u64 = 200;
        for (passes, noise, least) in [
            (8, 0.0, 0.9),
            (16, 0.0, 0.6),
            (18, 0.0, 0.9),
            (32, 0.0, 0.2),
            (64, 0.0, 0.1),
            (100, 0.0, 0.2),
            (64, 1.0, 1.0),
        ] {
            let (mut saved, mut real, mut stated) = (0.0, 0.0, 0.0);
            for run in 0..RUNS {
                let mut rng = Rng::new(5, Stream::Check, run, passes);
                let shift = rng.uniform();
                let mut turns = RqmcVariance::new([PIXELS, 1], Evenness::OfPasses);
                let mut sums = vec![[0.0; 2]; PIXELS];
                for pass in 0..passes {
                    let shared = (shift + (pass.reverse_bits() >> 11) as f64 / (1u64 << 53) as f64).fract();
                    let mut row = turns.rows().next().unwrap();
                    for (x, [sum, square]) in sums.iter_mut().enumerate() {
                        // A roof, steeper on one side: what is in doubt of four lanes of a spectrum.
                        let bump = 2.0 * (shared / 0.3).min((1.0 - shared) / 0.7);
                        let value = (1.0 + x as f64) * (bump + noise * 2.0 * (rng.uniform() - 0.5) * 3f64.sqrt());
                        row.add(x, pass, value);
                        (*sum, *square) = (*sum + value, *square + value * value);
                    }
                }
                turns.close(0, passes);
                let n = passes as f64;
                let of_pixel = |pixel: usize| {
                    let [sum, square] = sums[pixel];
                    let mean = sum / n;
                    PixelMean::of_spread(mean, (square / n - mean * mean) / (n - 1.0))
                };
                saved += turns.saved((passes, turns.surplus()), |_| true, of_pixel) / RUNS as f64;
                real += (0..PIXELS).map(|pixel| (of_pixel(pixel).mean - 1.0 - pixel as f64).powi(2)).sum::<f64>();
                stated += (0..PIXELS).map(|pixel| of_pixel(pixel).spread).sum::<f64>();
            }
            println!("{passes} passes, noise {noise}: saved {saved}, really {}", real / stated);
            assert!(saved > real / stated, "{passes}: {saved}, really {}", real / stated);
            assert!(if noise > 0.0 { saved > 0.3 } else { saved < least }, "{passes}: {saved}");
        }
        // Two passes of a part are the fewest.
        let turns = RqmcVariance::new([1, 1], Evenness::OfPasses);
        assert_eq!(
            turns.saved((3, &Evenness::OfPasses.surplus_of(3)), |_| true, |_| PixelMean::of_spread(1.0, 1.0)),
            1.0
        );
    }
}
