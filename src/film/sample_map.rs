//! How many passes each pixel of a film has, where work goes to where the error is: some pixels have had more passes than
//! others. A pixel's passes are always those from the first on without a gap, so what it holds is what a run of so many passes
//! of all pixels would have given it.

use std::ops::Range;

/// A first pass that begins with some pixels begins with the first of each block of so many by so many, a power of two.
pub const COARSE: usize = 8;

/// Passes per pixel, `[y][x]`.
#[derive(Debug, Clone, PartialEq)]
pub struct SampleMap {
    width: usize,
    made: Vec<u32>,
    /// Not less than those made.
    wanted: Vec<u32>,
}

/// One row of pixels of it.
#[derive(Debug, Clone, Copy)]
pub struct SampleMapRow<'f> {
    made: &'f [u32],
    wanted: &'f [u32],
}

impl SampleMapRow<'_> {
    /// Whether pixel `x` is still to get the pass of this number.
    pub fn wants(&self, x: usize, pass: u64) -> bool {
        u64::from(self.made[x]) <= pass && pass < u64::from(self.wanted[x])
    }
}

impl SampleMap {
    /// All pixels have had `made` passes, and are to get no more.
    pub fn new([width, height]: [usize; 2], made: u64) -> Self {
        let made = vec![u32::try_from(made).unwrap_or(u32::MAX); width * height];
        SampleMap { width, wanted: made.clone(), made }
    }

    /// How many pixels there are.
    pub fn pixels(&self) -> usize {
        self.made.len()
    }

    /// Passes that a pixel has.
    pub fn made(&self, pixel: usize) -> u64 {
        u64::from(self.made[pixel])
    }

    /// Passes that a pixel is to have.
    pub fn wanted(&self, pixel: usize) -> u64 {
        u64::from(self.wanted[pixel])
    }

    /// Has a pixel get passes until it has so many.
    pub fn want(&mut self, pixel: usize, passes: u64) {
        let passes = u32::try_from(passes).unwrap_or(u32::MAX);
        self.wanted[pixel] = passes.max(self.made[pixel]);
    }

    /// Puts what was stored; false if it is no such map.
    pub fn put(&mut self, pixel: usize, made: u64, wanted: u64) -> bool {
        let (Ok(made), Ok(wanted)) = (u32::try_from(made), u32::try_from(wanted)) else { return false };
        (self.made[pixel], self.wanted[pixel]) = (made, wanted);
        made <= wanted
    }

    /// The passes that some pixel is still to get: from the lowest to behind the highest number.
    pub fn missing(&self) -> Option<Range<u64>> {
        let open = || self.made.iter().zip(&self.wanted).filter(|(made, wanted)| made < wanted);
        let first = open().map(|(made, _)| *made).min()?;
        let end = open().map(|(_, wanted)| *wanted).max()?;
        Some(u64::from(first)..u64::from(end))
    }

    /// A pixel that has been traced, as near as there is one: itself, or the first of its block of 2 × 2, 4 × 4 or [`COARSE`]² pixels.
    pub fn shown(&self, pixel: usize) -> usize {
        let (x, y) = (pixel % self.width, pixel / self.width);
        let first = |side: usize| (y & !(side - 1)) * self.width + (x & !(side - 1));
        let traced = |side: &usize| self.made[first(*side)] > 0;
        [1, 2, 4].into_iter().find(traced).map_or_else(|| first(COARSE), first)
    }

    /// The rows, top to bottom.
    pub fn rows(&self) -> impl Iterator<Item = SampleMapRow<'_>> {
        let (made, wanted) = (self.made.chunks(self.width.max(1)), self.wanted.chunks(self.width.max(1)));
        made.zip(wanted).map(|(made, wanted)| SampleMapRow { made, wanted })
    }

    /// To be called when these passes have been made of all pixels that were to get them.
    pub fn close(&mut self, passes: Range<u64>) {
        let (first, end) = (passes.start, u32::try_from(passes.end).unwrap_or(u32::MAX));
        for (made, wanted) in self.made.iter_mut().zip(&self.wanted) {
            if u64::from(*made) >= first {
                *made = (*made).max(end.min(*wanted));
            }
        }
    }

    /// What a pixel has on average.
    pub fn mean(&self) -> f64 {
        self.made.iter().map(|made| u64::from(*made)).sum::<u64>() as f64 / self.made.len().max(1) as f64
    }

    /// The least and the most that a pixel has.
    pub fn range(&self) -> [u64; 2] {
        let made = || self.made.iter().copied();
        [made().min(), made().max()].map(|of| u64::from(of.unwrap_or(0)))
    }

    /// The numbers of passes that pixels have, each once, ascending.
    pub fn counts(&self) -> Vec<u64> {
        let mut counts: Vec<u32> = self.made.clone();
        counts.sort_unstable();
        counts.dedup();
        counts.into_iter().map(u64::from).collect()
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.made.as_slice()) + size_of_val(self.wanted.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whatever the blocks, each pixel gets the passes that it wants once, in their order.
    #[test]
    fn pixels_get_what_they_want_once() {
        for block in [1, 3, 100] {
            let mut map = SampleMap::new([3, 2], 4);
            assert_eq!(map.missing(), None);
            map.want(1, 8);
            map.close(0..0);
            let mut got: Vec<Vec<u64>> = vec![(0..4).collect(); 6];
            for wanted in [vec![(1, 8)], vec![(1, 16), (4, 8)], vec![(0, 32), (1, 32), (5, 9)]] {
                wanted.iter().for_each(|(pixel, passes)| map.want(*pixel, *passes));
                while let Some(missing) = map.missing() {
                    let passes = missing.start..missing.end.min(missing.start + block);
                    for pass in passes.clone() {
                        for (y, row) in map.rows().enumerate() {
                            (0..3).filter(|x| row.wants(*x, pass)).for_each(|x| got[3 * y + x].push(pass));
                        }
                    }
                    map.close(passes);
                }
            }
            for (pixel, passes) in got.iter().enumerate() {
                assert_eq!(map.made(pixel), [32, 32, 4, 4, 8, 9][pixel], "{block}");
                assert!(passes.iter().copied().eq(0..map.made(pixel)), "{block} {pixel} {passes:?}");
            }
            assert_eq!((map.mean(), map.range(), map.counts()), (89.0 / 6.0, [4, 32], vec![4, 8, 9, 32]));
        }
    }
}
