//! Sums per pixel that take memory only where there is light, and only as many of them as its light needs.
//!
//! A row is cut into tiles of 16 pixels. A tile holds no sums until a term other than zero comes, and then as many per pixel
//! as the largest need in it so far. A term of zero changes no bit of a [`Sum`], so it makes no difference which tiles there
//! are: what is read is what dense storage would hold.

use eyebox_base::double_double::Sum;

/// Pixels of a tile, along a row. The last of a row may stick out of the picture.
const TILE: usize = 16;

/// `[pixel of the tile][column]`; empty: zeros.
type Tile = Box<[Sum]>;

/// Sums of a film, `columns` for each of some entries (planes, shares …) of a pixel.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tiles {
    width: usize,
    entries: usize,
    columns: usize,
    first_stands_for_second: bool,
    /// `[row][tile of the row][entry]`
    tiles: Vec<Tile>,
}

/// One row of them.
pub(super) struct TilesRow<'f> {
    entries: usize,
    first_stands_for_second: bool,
    tiles: &'f mut [Tile],
}

impl Tiles {
    pub(super) fn new([width, height]: [usize; 2], entries: usize, columns: usize) -> Self {
        let tiles = vec![Tile::default(); width.div_ceil(TILE) * height * entries];
        Tiles { width, entries, columns, first_stands_for_second: false, tiles }
    }

    /// Where a tile has one column, it is meant twice.
    #[must_use]
    pub(super) fn with_first_for_second(self) -> Self {
        Tiles { first_stands_for_second: true, ..self }
    }

    /// Sums per pixel, those that are not stored because they are zero included.
    pub(super) fn stride(&self) -> usize {
        self.entries * self.columns
    }

    /// Memory, bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.tiles.as_slice()) + self.tiles.iter().map(|tile| size_of_val(&**tile)).sum::<usize>()
    }

    fn tile(&self, pixel: usize, entry: usize) -> (usize, usize) {
        let (x, y) = (pixel % self.width, pixel / self.width);
        ((y * self.width.div_ceil(TILE) + x / TILE) * self.entries + entry, x)
    }

    /// The columns of an entry that are stored.
    pub(super) fn stored(&self, pixel: usize, entry: usize) -> &[Sum] {
        let (index, x) = self.tile(pixel, entry);
        let tile = &self.tiles[index];
        let depth = tile.len() / TILE;
        &tile[x % TILE * depth..][..depth]
    }

    /// At least `depth` columns of an entry, to be added to.
    pub(super) fn grown(&mut self, pixel: usize, entry: usize, depth: usize) -> &mut [Sum] {
        let (index, x) = self.tile(pixel, entry);
        grown(&mut self.tiles[index], x, depth, self.first_stands_for_second)
    }

    /// The rows, top to bottom.
    pub(super) fn rows(&mut self) -> impl Iterator<Item = TilesRow<'_>> {
        let (entries, first_stands_for_second) = (self.entries, self.first_stands_for_second);
        self.tiles.chunks_mut((self.width.div_ceil(TILE) * entries).max(1)).map(move |tiles| TilesRow {
            entries,
            first_stands_for_second,
            tiles,
        })
    }

    /// One of the [`Tiles::stride`] sums of a pixel.
    pub(super) fn sum(&self, pixel: usize, at: usize) -> Sum {
        let stored = self.stored(pixel, at / self.columns);
        let column = match (at % self.columns, stored) {
            (1, [_]) if self.first_stands_for_second => 0,
            (column, _) => column,
        };
        stored.get(column).copied().unwrap_or(Sum::ZERO)
    }

    /// Sets all [`Tiles::stride`] sums of a pixel that had none.
    pub(super) fn put(&mut self, pixel: usize, sums: &[Sum]) {
        for (entry, sums) in sums.chunks_exact(self.columns.max(1)).enumerate() {
            let bits = |sum: &Sum| (sum.high.to_bits(), sum.low.to_bits());
            let depth = match sums {
                [first, second, rest @ ..]
                    if self.first_stands_for_second
                        && bits(first) == bits(second)
                        && rest.iter().all(|sum| *sum == Sum::ZERO) =>
                {
                    usize::from(*first != Sum::ZERO)
                }
                sums => self.depth(sums),
            };
            if depth > 0 {
                let own = self.grown(pixel, entry, depth);
                // Others of the tile may need more columns, and a second that is zero must not be taken for the first.
                own.iter_mut().zip(sums).for_each(|(own, sum)| *own = *sum);
            }
        }
    }

    /// How many columns have to be there for these sums of an entry.
    fn depth(&self, sums: &[Sum]) -> usize {
        let last = sums.iter().rposition(|sum| *sum != Sum::ZERO).map_or(0, |last| last + 1);
        match (last, self.first_stands_for_second) {
            (0, _) => 0,
            (last, true) => last.max(2),
            // All or none.
            (_, false) => self.columns,
        }
    }

    /// Adds the sums of others of the same shape.
    pub(super) fn merge(&mut self, other: &Tiles) {
        for (own, more) in self.tiles.iter_mut().zip(&other.tiles) {
            let depth = more.len() / TILE;
            if depth == 0 {
                continue;
            }
            for (x, more) in more.chunks_exact(depth).enumerate() {
                let own = grown(own, x, depth, self.first_stands_for_second);
                own.iter_mut().zip(more).for_each(|(sum, more)| sum.merge(*more));
                if let ([_, second, ..], [only]) = (own, more)
                    && self.first_stands_for_second
                {
                    second.merge(*only);
                }
            }
        }
    }

    /// The first pixel with a sum that is NaN or infinite.
    pub(super) fn first_invalid(&self) -> Option<usize> {
        if self.tiles.iter().flatten().all(|sum| sum.is_finite()) {
            return None;
        }
        let pixels = self.tiles.len() / self.width.div_ceil(TILE) / self.entries * self.width;
        let invalid = |pixel: usize, entry: usize| self.stored(pixel, entry).iter().any(|sum| !sum.is_finite());
        (0..pixels).find(|pixel| (0..self.entries).any(|entry| invalid(*pixel, entry)))
    }
}

impl TilesRow<'_> {
    /// At least `depth` columns of an entry of pixel `x`, to be added to.
    pub(super) fn grown(&mut self, x: usize, entry: usize, depth: usize) -> &mut [Sum] {
        grown(&mut self.tiles[x / TILE * self.entries + entry], x, depth, self.first_stands_for_second)
    }
}

fn grown(tile: &mut Tile, x: usize, depth: usize, first_stands_for_second: bool) -> &mut [Sum] {
    let own = tile.len() / TILE;
    if own < depth {
        deepen(tile, own, depth, first_stands_for_second);
    }
    let depth = own.max(depth);
    &mut tile[x % TILE * depth..][..depth]
}

#[cold]
fn deepen(tile: &mut Tile, own: usize, depth: usize, first_stands_for_second: bool) {
    let mut deeper = vec![Sum::ZERO; TILE * depth].into_boxed_slice();
    if own > 0 {
        for (new, old) in deeper.chunks_exact_mut(depth).zip(tile.chunks_exact(own)) {
            new[..own].copy_from_slice(old);
            if first_stands_for_second && own == 1 {
                new[1] = old[0];
            }
        }
    }
    *tile = deeper;
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(value: f64) -> Sum {
        Sum { high: value, low: value * 1e-20 }
    }

    /// What is put is read, whatever else is in the tile, and dark tiles take no sums.
    #[test]
    fn holds_what_dense_storage_would() {
        let zero = Sum::ZERO;
        let kinds = [
            [zero; 4],
            [of(3.0), of(3.0), zero, zero],
            [of(3.0), zero, zero, zero],
            [zero, of(1.0), zero, of(2.0)],
            [of(1.0), of(3.0), of(5.0), of(7.0)],
        ];
        for doubled in [false, true] {
            let new = || {
                let tiles = Tiles::new([37, 2], 2, 4);
                if doubled { tiles.with_first_for_second() } else { tiles }
            };
            let want = |pixel: usize| [kinds[pixel % 5], kinds[(pixel / 5 + 1) % 5]].concat();
            let mut tiles = new();
            (40..74).for_each(|pixel| tiles.put(pixel, &want(pixel)));
            assert_eq!(tiles.stride(), 8);
            let mut sum = new();
            sum.put(41, &[kinds[1], kinds[1]].concat());
            sum.merge(&tiles);
            for pixel in 0..74 {
                let dark = vec![zero; 8];
                let want = if pixel < 40 { dark } else { want(pixel) };
                let got: Vec<Sum> = (0..8).map(|at| tiles.sum(pixel, at)).collect();
                assert_eq!(got, want, "{pixel}");
                for (at, want) in want.into_iter().enumerate() {
                    let mut want = want;
                    if pixel == 41 {
                        want.merge(kinds[1][at % 4]);
                    }
                    assert_eq!(sum.sum(pixel, at), want, "{pixel} {at}");
                }
            }
            let (row, empty) = (3 * 2 * TILE * 4 * size_of::<Sum>(), new().bytes());
            assert!(tiles.bytes() <= row + empty && tiles.bytes() > empty, "{}", tiles.bytes());
            assert_eq!(tiles.first_invalid(), None);
            tiles.put(38, &[Sum { high: f64::NAN, low: 0.0 }; 8]);
            assert_eq!(tiles.first_invalid(), Some(38));
        }
    }

    /// Light that crosses no slide is stored once, also beside light that does.
    #[test]
    fn one_column_is_meant_twice() {
        let mut tiles = Tiles::new([16, 1], 1, 6).with_first_for_second();
        let empty = tiles.bytes();
        (0..16).for_each(|x| tiles.grown(x, 0, 1)[0].add(x as f64));
        assert_eq!(tiles.bytes() - empty, 16 * size_of::<Sum>());
        tiles.grown(3, 0, 3)[2].add(-0.5);
        for x in 0..16 {
            let sums: Vec<f64> = (0..6).map(|at| tiles.sum(x, at).value()).collect();
            let own = x as f64;
            assert_eq!(sums, [own, own, if x == 3 { -0.5 } else { 0.0 }, 0.0, 0.0, 0.0]);
        }
    }
}
