//! What evenness saves where all pixels of a pass share what it draws: passes of one part draw nearly the same, and only what they
//! differ by within it is left to chance. The variance of a mean over parts (post-stratification, e.g. W. G. Cochran, "Sampling
//! Techniques", 3rd ed., 1977, chapter 5A.9): what the passes differ by within their parts, and the parts that have more or fewer
//! passes than their due. Parts of a net's passes are even in themselves, too, so that it is more than it is.

use super::{RqmcVariance, SIGMAS};

/// Parts of the passes, a power of two.
pub(super) const PARTS: usize = 32;
/// So many pixels tell enough: they share most of what they tell.
pub(super) const MOST: usize = 1 << 14;
/// Passes that a part must have to tell how they differ.
const FEWEST: u64 = 2;

/// The part of a pass: that of its wavelengths, by the lowest bits of its number.
pub(super) fn part(pass: u64) -> usize {
    (pass % PARTS as u64) as usize
}

/// How many passes before this one are of a part.
pub(super) fn before(pass: u64, part: usize) -> i64 {
    (pass / PARTS as u64 + u64::from(pass % PARTS as u64 > part as u64)) as i64
}

impl RqmcVariance {
    /// See [`RqmcVariance::saved`]. Passes that the pixels share tell as little as one pixel's.
    pub(super) fn saved_by_parts(
        &self,
        (passes, made): (u64, &[i64]),
        own: impl Fn(usize) -> bool,
        of_pixel: impl Fn(usize) -> (f64, f64),
    ) -> f64 {
        let most = PARTS.min((passes / FEWEST) as usize);
        if most < 2 {
            return 1.0;
        }
        // As many as have passes enough: parts with the same lower bits are one.
        let parts = 1 << most.ilog2();
        let of = |part: usize| (part..PARTS).step_by(parts);
        let counts: Vec<f64> = (0..parts).map(|part| of(part).map(|k| made[k] as f64).sum()).collect();
        let all = passes as f64;
        if counts.iter().any(|count| *count < FEWEST as f64) || counts.iter().sum::<f64>() != all {
            return 1.0;
        }
        let freedom = all - parts as f64;
        let (mut by_passes, mut by_parts) = (0.0, 0.0);
        for (pixel, sums) in self.pixels(own) {
            let (mean, variance) = of_pixel(pixel);
            let (mut between, mut uneven) = (0.0, 0.0);
            for (part, count) in counts.iter().enumerate() {
                let off = of(part).map(|k| sums[k].value()).sum::<f64>() / count - mean;
                between += count * off * off;
                uneven += (count / all - 1.0 / parts as f64) * off;
            }
            let within = (variance * all * (all - 1.0) - between).max(0.0);
            by_passes += variance;
            by_parts += within / freedom / all + uneven * uneven;
        }
        let saved = by_parts / by_passes * (1.0 + SIGMAS * (2.0 / freedom).sqrt());
        if saved.is_nan() { 1.0 } else { saved.min(1.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Evenness;
    use super::*;
    use crate::base::rng::{Rng, Stream};

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
        const PIXELS: usize = 50;
        const RUNS: u64 = 400;
        for (passes, noise, least) in [(16, 0.0, 0.9), (32, 0.0, 0.6), (64, 0.0, 0.2), (100, 0.0, 0.3), (64, 1.0, 1.0)]
        {
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
                        // A roof a quarter wide, four times over: what four lanes see of a spectrum.
                        let bump = 4.0 * ((4.0 * shared).fract() - 0.5).abs();
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
                    (mean, (square / n - mean * mean) / (n - 1.0))
                };
                saved += turns.saved((passes, turns.surplus()), |_| true, of_pixel) / RUNS as f64;
                real += (0..PIXELS).map(|pixel| (of_pixel(pixel).0 - 1.0 - pixel as f64).powi(2)).sum::<f64>();
                stated += (0..PIXELS).map(|pixel| of_pixel(pixel).1).sum::<f64>();
            }
            println!("{passes} passes, noise {noise}: saved {saved}, really {}", real / stated);
            assert!(saved > real / stated, "{passes}: {saved}, really {}", real / stated);
            assert!(if noise > 0.0 { saved > 0.3 } else { saved < least }, "{passes}: {saved}");
        }
        // Two passes of a part are the fewest.
        let turns = RqmcVariance::new([1, 1], Evenness::OfPasses);
        assert_eq!(turns.saved((3, &Evenness::OfPasses.surplus_of(3)), |_| true, |_| (1.0, 1.0)), 1.0);
    }
}
