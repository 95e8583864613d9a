//! What evenness over the passes saves. Where passes go from point to point of a sequence that fills its space evenly, the
//! mean of many errs by less than their spread says. How far runs of passes lie apart tells by how much: two runs of 64
//! that are each even in themselves differ less than 64 independent passes and 64 others would.
//!
//! For each pixel, sums in which runs of 2ᵏ passes count by turns for and against: the pass's number decides, so pieces of
//! a render add up to the whole, and the square of such a sum is the variance of the sum of all passes if the runs are
//! independent of each other. Nets are even against each other, too, so for them that is more than it is. A lattice may
//! swing in step with runs of some length, and then they tell too little: so two lengths are asked, and the larger counts. One
//! sum tells little, those of many pixels much.
//!
//! Where all pixels of a pass share its wavelengths those of many pixels tell no more than one. But there it is known what a pass
//! draws: van der Corput's sequence, so that passes of the same lowest bits of their number have wavelengths of the same small
//! part of all. So passes are parted by these, and what they differ by within a part is left (`shared.rs`).

mod shared;

use eyebox_base::double_double::Sum;

/// Passes of a run, powers of two.
const RUNS: [u32; COUNT] = [2, 3, 5, 7];
const COUNT: usize = 4;
/// Runs that there have to be for them to be believed.
const FEWEST: u64 = 8;
/// Independent pixels that there have to be, and by how many of their standard errors what is found is taken for more.
const FREEDOM: f64 = 64.0;
const SIGMAS: f64 = 2.0;

/// So many pixels tell enough. Of a larger picture as many are asked, spread over all of it.
const MOST: usize = 1 << 16;

/// Which pixels are asked: in every row one of `step` in line, each row a golden section of `step` further along than the
/// one above, so that no pattern of the picture falls in with them.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Asked {
    width: usize,
    step: usize,
}

impl Asked {
    fn per_row(self) -> usize {
        self.width.div_ceil(self.step).max(1)
    }

    /// Where the first of a row is.
    fn first(self, y: usize) -> usize {
        const GOLDEN: u64 = 0x9e37_79b9;
        let turned = (y as u64).wrapping_mul(GOLDEN) & 0xffff_ffff;
        (turned.wrapping_mul(self.step as u64) >> 32) as usize
    }

    /// The pixel whose sums are kept at this place; a row's last place may have none.
    fn pixel(self, slot: usize) -> Option<usize> {
        let (y, nth) = (slot / self.per_row(), slot % self.per_row());
        let x = self.first(y) + nth * self.step;
        (x < self.width).then_some(y * self.width + x)
    }
}

/// What sums are kept of a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Evenness {
    /// Of passes for, less passes against: pixels have points of their own.
    OfPixels,
    /// Of parts of the passes: they share wavelengths, in van der Corput's order.
    OfPasses,
}

impl Evenness {
    /// How many sums a pixel has.
    pub fn per_pixel(self) -> usize {
        match self {
            Evenness::OfPixels => COUNT,
            Evenness::OfPasses => shared::PARTS,
        }
    }

    /// How many pixels tell enough.
    fn most(self) -> usize {
        match self {
            Evenness::OfPixels => MOST,
            Evenness::OfPasses => shared::MOST,
        }
    }

    /// What passes before this one count in the sum of this number.
    fn before(self, pass: u64, number: usize) -> i64 {
        match self {
            Evenness::OfPixels => surplus_before(pass, number),
            Evenness::OfPasses => shared::before(pass, number),
        }
    }

    /// What the first `passes` count in each sum.
    pub fn surplus_of(self, passes: u64) -> Vec<i64> {
        (0..self.per_pixel()).map(|number| self.before(passes, number)).collect()
    }
}

/// The mean luminance of a pixel over its passes.
#[derive(Debug, Clone, Copy)]
pub struct PixelMean {
    pub mean: f64,
    /// Its variance by the spread of the passes,
    pub spread: f64,
    /// and what is stated of it: less, where [more is known](super::control_variates) of the passes.
    pub variance: f64,
}

impl PixelMean {
    /// Of which no more is known.
    pub fn of_spread(mean: f64, spread: f64) -> PixelMean {
        PixelMean { mean, spread, variance: spread }
    }
}

/// The sums of a film.
#[derive(Debug, Clone, PartialEq)]
pub struct RqmcVariance {
    asked: Asked,
    evenness: Evenness,
    /// `[asked pixel][number]`: luminance of all planes.
    sums: Vec<Sum>,
    /// What the passes so far count in each.
    pub(super) surplus: Vec<i64>,
}

/// One row of them.
pub struct RqmcVarianceRow<'f> {
    first: usize,
    step: usize,
    evenness: Evenness,
    sums: &'f mut [Sum],
}

fn is_against(pass: u64, run: usize) -> bool {
    pass >> RUNS[run] & 1 == 1
}

/// Passes for, less passes against, of those before `pass`.
fn surplus_before(pass: u64, run: usize) -> i64 {
    let length = 1u64 << RUNS[run];
    let rest = pass % (2 * length);
    rest.min(length) as i64 - rest.saturating_sub(length) as i64
}

impl RqmcVariance {
    pub fn new([width, height]: [usize; 2], evenness: Evenness) -> Self {
        let asked = Asked { width, step: (width * height).div_ceil(evenness.most()).max(1) };
        let count = evenness.per_pixel();
        let sums = vec![Sum::ZERO; asked.per_row() * height * count];
        RqmcVariance { asked, evenness, sums, surplus: vec![0; count] }
    }

    /// Of the film's passes.
    pub fn evenness(&self) -> Evenness {
        self.evenness
    }

    /// The rows, top to bottom.
    pub fn rows(&mut self) -> impl Iterator<Item = RqmcVarianceRow<'_>> {
        let (asked, evenness) = (self.asked, self.evenness);
        let rows = self.sums.chunks_mut(asked.per_row() * evenness.per_pixel()).enumerate();
        rows.map(move |(y, sums)| RqmcVarianceRow { first: asked.first(y), step: asked.step, evenness, sums })
    }

    /// Memory, bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.sums.as_slice())
    }

    /// Where the sums of a pixel are kept, if it is asked.
    fn slot(&self, pixel: usize) -> Option<usize> {
        let (x, y) = (pixel % self.asked.width, pixel / self.asked.width);
        let along = x.checked_sub(self.asked.first(y)).filter(|along| along % self.asked.step == 0)?;
        Some(y * self.asked.per_row() + along / self.asked.step)
    }

    /// The sums that are kept at this place.
    fn at(&self, slot: usize) -> &[Sum] {
        let count = self.evenness.per_pixel();
        &self.sums[slot * count..(slot + 1) * count]
    }

    /// A sum of a pixel: zero if it is not asked.
    pub(super) fn sum(&self, pixel: usize, number: usize) -> Sum {
        self.slot(pixel).map_or(Sum::ZERO, |slot| self.at(slot)[number])
    }

    /// Sets the sums of a pixel. False if it is not asked, and they are not zero.
    pub(super) fn put(&mut self, pixel: usize, sums: &[Sum]) -> bool {
        let count = self.evenness.per_pixel();
        match self.slot(pixel) {
            Some(slot) => self.sums[slot * count..][..count].iter_mut().zip(sums).for_each(|(own, sum)| *own = *sum),
            None => return sums.iter().all(|sum| *sum == Sum::ZERO),
        }
        true
    }

    /// Adds the sums of other passes of the same picture.
    pub(super) fn merge(&mut self, other: &RqmcVariance) {
        self.sums.iter_mut().zip(&other.sums).for_each(|(sum, more)| sum.merge(*more));
        self.surplus.iter_mut().zip(&other.surplus).for_each(|(own, more)| *own = own.saturating_add(*more));
    }

    /// The first pixel with a sum that is NaN or infinite.
    pub(super) fn first_invalid(&self) -> Option<usize> {
        let invalid = self.sums.iter().position(|sum| !sum.is_finite())?;
        self.asked.pixel(invalid / self.evenness.per_pixel())
    }

    /// To be called when these passes have been added.
    pub fn close(&mut self, first: u64, count: u64) {
        let evenness = self.evenness;
        for (number, surplus) in self.surplus.iter_mut().enumerate() {
            let more = evenness.before(first.wrapping_add(count), number) - evenness.before(first, number);
            *surplus = surplus.saturating_add(more);
        }
    }

    /// What the passes so far count in each sum.
    pub fn surplus(&self) -> &[i64] {
        &self.surplus
    }

    /// How many times smaller the variance of the mean over `passes` is than [`PixelMean::variance`] says, as far as
    /// that can be told: at most 1. `own`: the pixels that have so many passes, which count `surplus` in each sum.
    /// `of_pixel`: of the luminance of a pixel.
    pub fn saved(
        &self,
        (passes, surplus): (u64, &[i64]),
        own: impl Fn(usize) -> bool,
        of_pixel: impl Fn(usize) -> PixelMean,
    ) -> f64 {
        match self.evenness {
            Evenness::OfPixels => {}
            Evenness::OfPasses => return self.saved_by_parts((passes, surplus), own, of_pixel),
        }
        let enough = (0..COUNT).filter(|run| passes >= FEWEST << RUNS[*run]).count();
        let Some(shorter) = enough.checked_sub(2) else { return 1.0 };
        let by = |run: usize| self.saved_by((run, surplus[run] as f64), passes as f64, &own, &of_pixel);
        [shorter, shorter + 1].map(by).into_iter().fold(0.0, f64::max)
    }

    /// The asked ones of some pixels, and their sums.
    fn pixels(&self, own: impl Fn(usize) -> bool) -> impl Iterator<Item = (usize, &[Sum])> {
        let slots = self.sums.len() / self.evenness.per_pixel();
        (0..slots).filter_map(move |slot| Some((self.asked.pixel(slot).filter(|pixel| own(*pixel))?, self.at(slot))))
    }

    /// By runs of one length.
    fn saved_by(
        &self,
        (run, surplus): (usize, f64),
        passes: f64,
        own: &impl Fn(usize) -> bool,
        of_pixel: &impl Fn(usize) -> PixelMean,
    ) -> f64 {
        // Passes that there are more of on one side do not swing.
        let swinging = 1.0 - (surplus / passes).powi(2);
        if swinging < 0.5 {
            return 1.0;
        }
        let (mut by_passes, mut by_runs, mut squares) = (0.0, 0.0, 0.0);
        for (pixel, sums) in self.pixels(own) {
            let PixelMean { mean, variance, .. } = of_pixel(pixel);
            let swing = (sums[run].value() - surplus * mean) / passes;
            let of_runs = swing * swing / swinging;
            by_passes += variance;
            by_runs += of_runs;
            squares += of_runs * of_runs;
        }
        // A normal number's fourth moment is three times the square of its second.
        let freedom = 3.0 * by_runs * by_runs / squares;
        if freedom.is_nan() || freedom < FREEDOM {
            return 1.0;
        }
        (by_runs / by_passes * (1.0 + SIGMAS * (2.0 / freedom).sqrt())).min(1.0)
    }
}

impl RqmcVarianceRow<'_> {
    /// Adds the luminance of pixel `x` in a pass, if it is asked.
    pub fn add(&mut self, x: usize, pass: u64, luminance: f64) {
        let Some(along) = x.checked_sub(self.first).filter(|along| along % self.step == 0) else { return };
        let count = self.evenness.per_pixel();
        let sums = &mut self.sums[along / self.step * count..][..count];
        match self.evenness {
            Evenness::OfPixels => {
                for (run, sum) in sums.iter_mut().enumerate() {
                    sum.add(if is_against(pass, run) { -luminance } else { luminance });
                }
            }
            Evenness::OfPasses => sums[shared::part(pass)].add(luminance),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyebox_base::lattice::lattice;
    use eyebox_base::rng::{Rng, Stream};

    #[test]
    fn the_surplus_is_counted() {
        for run in 0..COUNT {
            let mut sum = 0;
            for pass in 0..3000 {
                assert_eq!(surplus_before(pass, run), sum);
                sum += if is_against(pass, run) { -1 } else { 1 };
            }
        }
    }

    /// Means of 3000 values per pixel, independent or from a lattice: what runs say against the truth.
    #[test]
    fn runs_tell_what_evenness_saves() {
        const PIXELS: usize = 2000;
        let of = |passes: std::ops::Range<u64>, value: &dyn Fn(usize, u64) -> f64| {
            let mut turns = RqmcVariance::new([PIXELS, 1], Evenness::OfPixels);
            let mut sums = vec![[0.0; 2]; PIXELS];
            for pass in passes.clone() {
                let mut row = turns.rows().next().unwrap();
                for (x, [sum, square]) in sums.iter_mut().enumerate() {
                    let value = value(x, pass);
                    row.add(x, pass, value);
                    (*sum, *square) = (*sum + value, *square + value * value);
                }
            }
            let count = passes.end - passes.start;
            turns.close(passes.start, count);
            let count_f = count as f64;
            let of_pixel = |pixel: usize| {
                let [sum, square] = sums[pixel];
                let mean = sum / count_f;
                PixelMean::of_spread(mean, (square / count_f - mean * mean) / (count_f - 1.0))
            };
            let saved = turns.saved((count, &turns.surplus), |_| true, of_pixel);
            let real: f64 = (0..PIXELS).map(|pixel| (of_pixel(pixel).mean - 0.5).powi(2)).sum();
            let stated: f64 = (0..PIXELS).map(|pixel| of_pixel(pixel).spread).sum();
            (saved, real / stated)
        };
        let by_chance = |pixel: usize, pass: u64| Rng::new(1, Stream::Check, pass, pixel as u64).uniform();
        let evenly = |pixel: usize, pass: u64| {
            let [x] = lattice([Rng::new(1, Stream::Check, 0, pixel as u64).next_u64()], pass);
            x
        };
        // Wherever a piece of a render begins and ends.
        for passes in [0..3000, 100..3111, 7..50] {
            let (saved, _) = of(passes.clone(), &by_chance);
            assert!(saved > 0.9, "{passes:?}: {saved}");
            let (saved, real) = of(passes.clone(), &evenly);
            // Runs of four are not even.
            let most = if passes.end > 1000 { 0.2 } else { 1.0 };
            assert!(saved > real && saved <= most, "{passes:?}: {saved} {real}");
        }
        let (saved, _) = of(0..63, &evenly);
        assert_eq!(saved, 1.0);
    }

    /// Of a large picture some 2¹⁶ pixels, alike over rows and columns, each with a place of its own.
    #[test]
    fn some_of_many_pixels_are_asked() {
        for size in [[640, 480], [3840, 2160], [70_000, 3], [3, 70_000], [1, 1]] {
            let pixels: usize = size.iter().product();
            let turns = RqmcVariance::new(size, Evenness::OfPixels);
            let slots: Vec<usize> = (0..pixels).filter_map(|pixel| turns.slot(pixel)).collect();
            assert!(slots.windows(2).all(|pair| pair[0] < pair[1]) && slots.len() <= MOST * 5 / 4);
            assert!(slots.len() >= (MOST / 2).min(pixels), "{size:?} {}", slots.len());
            let asked = (0..turns.sums.len() / COUNT).filter_map(|slot| turns.asked.pixel(slot));
            assert!(asked.eq((0..pixels).filter(|pixel| turns.slot(*pixel).is_some())));
            let [width, height] = size;
            if width.min(height) > 3 {
                let mut parts = [0usize; 16];
                for pixel in (0..pixels).filter(|pixel| turns.slot(*pixel).is_some()) {
                    parts[pixel % width * 4 / width + pixel / width * 4 / height * 4] += 1;
                }
                let mean = slots.len() as f64 / 16.0;
                assert!(parts.iter().all(|part| (*part as f64 - mean).abs() < 0.03 * mean), "{parts:?}");
            }
        }
    }

    /// Where few pixels have what is left, nothing is told.
    #[test]
    fn a_few_pixels_tell_nothing() {
        let mut turns = RqmcVariance::new([1000, 1], Evenness::OfPixels);
        let mut rng = Rng::new(3, Stream::Check, 0, 0);
        for pass in 0..256 {
            let mut row = turns.rows().next().unwrap();
            (0..10).for_each(|x| row.add(x, pass, rng.uniform()));
        }
        turns.close(0, 256);
        assert_eq!(
            turns.saved(
                (256, &turns.surplus),
                |_| true,
                |pixel| match pixel {
                    0..10 => PixelMean::of_spread(0.5, 1.0 / 12.0 / 256.0),
                    _ => PixelMean::of_spread(0.0, 1.0),
                }
            ),
            1.0
        );
    }
}
