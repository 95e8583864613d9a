//! Whether a picture has the references' light, block by block.

use super::cells::{Batches, CELLS, Grid, Worth};
use super::picture::Picture;

/// Standard error of the references over a block's light from which on the blocks are made larger. A picture that is as
/// rough as the references and took a sixteenth of their time then has some hundred of the rare bright hits in each block:
/// with a few its error would not be normal.
const KNOWN: f64 = 0.03;
/// The same for the picture as a whole, below which there is nothing to go to.
const KNOWN_WHOLE: f64 = 0.1;
/// Share of a block's light that sums of 10⁴ passes may round to one side. Where nothing is left to chance (the plain sky)
/// all else is less.
const ROUNDED: f64 = 1.0 / (1u64 << 40) as f64;

/// The light of a picture's cells, and what it is worth.
#[derive(Debug, Clone)]
struct Light {
    sums: Vec<f64>,
    /// Sums of what pixels state as their variance.
    stated: Vec<f64>,
    batches: Batches,
}

impl Light {
    fn of(picture: &Picture) -> Light {
        let sums = |values: &[f64]| picture.cells().sums(values.iter().copied());
        Light { sums: sums(&picture.values), stated: sums(&picture.variances), batches: picture.batches.clone() }
    }

    fn of_block(&self, block: &[usize]) -> f64 {
        block.iter().map(|&cell| self.sums[cell]).sum()
    }

    fn worth(&self, block: &[usize]) -> Worth {
        let stated = || Worth::stated(block.iter().map(|&cell| self.stated[cell]).sum());
        self.batches.worth(block).unwrap_or_else(stated)
    }
}

/// The light of two references, in blocks as small as they know it well enough.
#[derive(Debug, Clone)]
pub struct Blocks {
    grid: Grid,
    references: [Light; 2],
    /// Sum over each cell of (R₁ − R₂)²/4.
    differ: Vec<f64>,
    blocks: Vec<Vec<usize>>,
    /// Whether they know the light of the whole.
    known: bool,
    /// Whether no block had to be made larger.
    small: bool,
}

/// How a picture's light deviates.
#[derive(Debug, Clone, Copy)]
pub struct Deviation {
    /// Sum over all pixels of t − r, and its standard error.
    pub whole: [f64; 2],
    /// The block that deviates most: as a normal deviate.
    pub worst_sigma: f64,
}

impl Blocks {
    /// Of two pictures of the same size.
    pub fn new([first, second]: [&Picture; 2]) -> Blocks {
        let grid = first.cells();
        let pairs = first.values.iter().zip(&second.values);
        let differ = grid.sums(pairs.map(|(a, b)| 0.25 * (a - b).powi(2)));
        let references = [first, second].map(Light::of);
        let mut blocks = Blocks { grid, references, differ, blocks: grid.blocks(1), known: false, small: false };
        if let Some(side) = [CELLS, CELLS / 2, CELLS / 4, 1].into_iter().find(|side| blocks.know(*side)) {
            (blocks.blocks, blocks.known, blocks.small) = (grid.blocks(side), true, side == CELLS);
        }
        blocks
    }

    /// Whether the references know the light of each of `side` × `side` blocks well enough. A block in which a rare path
    /// was found once or never states a wrong error or none.
    fn know(&self, side: usize) -> bool {
        let limit = if side > 1 { KNOWN } else { KNOWN_WHOLE };
        self.grid.blocks(side).iter().all(|block| self.worth(block).variance.sqrt() <= limit * self.light(block))
    }

    /// The references' light of a block.
    fn light(&self, block: &[usize]) -> f64 {
        self.references.iter().map(|reference| 0.5 * reference.of_block(block)).sum()
    }

    /// What that is worth: by the references' batches. Files have none: then it is taken from how the two differ,
    /// (R₁ − R₂)²/4 having the mean of the variance of their mean. In a small block, where a few pixels have most of the
    /// variance, that is a rough guess.
    fn worth(&self, block: &[usize]) -> Worth {
        let [first, second] = &self.references;
        let known = first.worth(block).mean(second.worth(block));
        let differ = || Worth::stated(block.iter().map(|&cell| self.differ[cell]).sum());
        if known.variance > 0.0 { known } else { differ() }
    }

    /// Number of blocks; none if the references don't even know the light of the whole.
    pub fn known(&self) -> Option<usize> {
        self.known.then_some(self.blocks.len())
    }

    /// Number of blocks.
    pub fn count(&self) -> usize {
        self.blocks.len()
    }

    /// Whether there are as many blocks as there may be: the references know the light of each small one.
    pub fn know_all(&self) -> bool {
        self.known && self.small
    }

    /// The deviates of all blocks of a picture of the same size, row by row.
    pub fn deviates(&self, picture: &Picture) -> Vec<f64> {
        let light = Light::of(picture);
        let of = |block: &Vec<usize>| {
            let (sum, worth) = self.difference(&light, block);
            worth.sigmas(sum)
        };
        self.blocks.iter().map(of).collect()
    }

    /// The deviate of its light as a whole.
    pub fn whole(&self, picture: &Picture) -> f64 {
        let (sum, worth) = self.difference(&Light::of(picture), &self.blocks.concat());
        worth.sigmas(sum)
    }

    /// What is told of a picture of the same size.
    pub fn deviation(&self, picture: &Picture) -> Deviation {
        let light = Light::of(picture);
        let all = self.blocks.concat();
        let (sum, worth) = self.difference(&light, &all);
        let worse = |worst: f64, z: f64| if z.abs() > worst.abs() || z.is_nan() { z } else { worst };
        Deviation {
            whole: [sum, worth.variance.sqrt()],
            worst_sigma: self.deviates(picture).into_iter().fold(0.0, worse),
        }
    }

    /// Sum of t − r over a block, and what it is worth.
    fn difference(&self, light: &Light, block: &[usize]) -> (f64, Worth) {
        let reference = self.light(block);
        let rounding = Worth::stated((ROUNDED * reference).powi(2));
        let worth = light.worth(block).less(self.worth(block), 1.0).less(rounding, 1.0);
        (light.of_block(block) - reference, worth)
    }
}
