//! What the wavelengths of a pass alone make of light, in all pixels alike: known before anything is traced, and its mean over all
//! wavelengths is known too. What a pixel's passes differ by in step with that is no doubt of theirs. So their variance is what a
//! regression on it leaves, and the mean errs besides by what is known of it (regression with control variates, e.g. A. Owen, "Monte
//! Carlo theory, methods and examples", 2013, chapter 8.9). Means are not changed.

use super::tiles::{Tiles, TilesRow};
use eyebox_base::double_double::Sum;
use glam::{DMat3, DVec3};

/// A pass's luminance of the lamps' light through a red, a green and a blue film, in parts of white's, less the mean over all
/// wavelengths.
pub type Known = [f64; COUNT];
pub const COUNT: usize = 3;

/// A direction in which passes differ by less than this of what they do in others tells nothing.
const FLAT: f64 = 1e-9;

/// Sums of a film whose passes share wavelengths.
#[derive(Debug, Clone, PartialEq)]
pub struct ControlVariates {
    /// `[pixel]`: of the luminance of all planes times what is known of the pass.
    pub(super) products: Tiles,
    /// Passes by number.
    known: Vec<(u64, Known)>,
    /// `[n]`: sums of what is known over the first n, and of their products.
    first: Vec<(DVec3, DMat3)>,
}

/// One row of them.
pub(super) struct ControlVariatesRow<'f> {
    products: TilesRow<'f>,
    known: &'f [(u64, Known)],
}

fn outer(a: DVec3) -> DMat3 {
    DMat3::from_cols(a * a.x, a * a.y, a * a.z)
}

fn of_pass(known: &[(u64, Known)], pass: u64) -> Option<Known> {
    known.binary_search_by_key(&pass, |(own, _)| *own).ok().map(|at| known[at].1)
}

impl ControlVariates {
    pub fn new(size: [usize; 2]) -> Self {
        ControlVariates {
            products: Tiles::new(size, 1, COUNT),
            known: Vec::new(),
            first: vec![(DVec3::ZERO, DMat3::ZERO)],
        }
    }

    /// What is known of the passes so far.
    pub fn known(&self) -> &[(u64, Known)] {
        &self.known
    }

    /// Adds what is known of passes; of one that there is, it stays. False where it is no number.
    pub fn know(&mut self, passes: impl IntoIterator<Item = (u64, Known)>) -> bool {
        let before = self.known.len();
        self.known.extend(passes);
        let finite = self.known[before..].iter().flat_map(|(_, known)| known).all(|own| own.is_finite());
        let first = self.known[before..].iter().map(|(pass, _)| *pass).min();
        // Those that there are stand before others of their number, and stay.
        self.known.sort_by_key(|(pass, _)| *pass);
        self.known.dedup_by_key(|(pass, _)| *pass);
        let as_before = first.map_or(before, |first| self.known.partition_point(|(pass, _)| *pass < first));
        self.first.truncate(as_before + 1);
        for at in self.first.len() - 1..self.known.len() {
            let ((sum, products), own) = (self.first[at], DVec3::from_array(self.known[at].1));
            self.first.push((sum + own, products + outer(own)));
        }
        finite
    }

    /// The rows, top to bottom.
    pub(super) fn rows(&mut self) -> impl Iterator<Item = ControlVariatesRow<'_>> {
        let known = &self.known;
        self.products.rows().map(move |products| ControlVariatesRow { products, known })
    }

    /// How many of the first `passes` are spent on what is taken off, at most: at least as many are left to tell what is left.
    pub(super) fn spent(&self, passes: u64) -> u64 {
        match passes {
            _ if passes >= self.first.len() as u64 => 0,
            0..=3 => 0,
            4..=7 => 1,
            8.. => COUNT as u64,
        }
    }

    /// Variance of the mean of a pixel with the first `passes`, from their sum and that of the squares. None where there are too few
    /// to tell.
    pub(super) fn variance(&self, pixel: usize, passes: u64, sum: f64, squares: f64) -> Option<f64> {
        let (known, products) = self.first.get(usize::try_from(passes).ok()?)?;
        let count = passes as f64;
        let of = |column: usize| self.products.sum(pixel, column).value();
        let mean = *known / count;
        let both = DVec3::new(of(0), of(1), of(2)) - mean * sum;
        let spread = *products - outer(mean) * count;
        let whole = squares - sum * sum / count;
        let along: &[DVec3] = match self.spent(passes) {
            0 => return None,
            1 => &[DVec3::ONE],
            _ => &DVec3::AXES,
        };
        let (mut explained, mut off, mut spent) = (0.0, 0.0, 0.0);
        // By Gram and Schmidt: each less what those before it say.
        let mut before: Vec<(DVec3, f64)> = Vec::new();
        let most = along.iter().map(|own| own.dot(spread * *own)).fold(0.0, f64::max);
        for own in along {
            let less = |own: DVec3, (other, size): &(DVec3, f64)| own - *other * (other.dot(spread * own) / size);
            let own = before.iter().fold(*own, less);
            let size = own.dot(spread * own);
            if size.is_nan() || size <= FLAT * most {
                continue;
            }
            let slope = own.dot(both) / size;
            explained += slope * slope * size;
            off += slope * own.dot(mean);
            spent += 1.0;
            before.push((own, size));
        }
        let left = (whole - explained).max(0.0) / (count - 1.0 - spent);
        Some(left / count + off * off)
    }
}

impl ControlVariatesRow<'_> {
    /// Adds the luminance of pixel `x` in a pass.
    pub(super) fn add(&mut self, x: usize, pass: u64, luminance: f64) {
        let Some(known) = of_pass(self.known, pass).filter(|_| luminance != 0.0) else { return };
        let sums: &mut [Sum] = self.products.grown(x, 0, COUNT);
        sums.iter_mut().zip(known).for_each(|(sum, own)| sum.add(luminance * own));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyebox_base::rng::{Rng, Stream};

    /// Passes of pixels that follow what is known, each in its way, and some noise of their own: what is stated over many runs, against
    /// how far the means really are off. `even`: what is known has its mean, as with wavelengths that are spread evenly.
    #[test]
    fn what_is_known_is_no_doubt() {
        const RUNS: u64 = 4000;
        for (passes, coloured, noise, even) in [
            (2, 0.5, 0.1, false),
            (4, 0.0, 0.1, true),
            (4, 0.0, 0.1, false),
            (8, 0.5, 0.1, true),
            (8, 0.5, 0.1, false),
            (16, 0.5, 0.1, true),
            (16, 0.0, 1.0, true),
        ] {
            let (mut stated, mut real, mut plain) = (0.0, 0.0, 0.0);
            for run in 0..RUNS {
                let mut rng = Rng::new(7, Stream::Check, run, passes);
                let mut normal = || (0..12).map(|_| rng.uniform()).sum::<f64>() - 6.0;
                let mut known: Vec<DVec3> =
                    (0..passes).map(|_| DVec3::new(0.2 * normal(), 0.7 * normal(), 0.1 * normal())).collect();
                if even {
                    let mean = known.iter().sum::<DVec3>() / passes as f64;
                    known.iter_mut().for_each(|own| *own -= mean);
                }
                let mut control = ControlVariates::new([1, 1]);
                assert!(control.know((0..passes).zip(known.iter().map(|own| own.to_array()))));
                let (mut sum, mut squares) = (0.0, 0.0);
                let mut row = control.rows().next().unwrap();
                for (pass, known) in known.iter().enumerate() {
                    let light = known.dot(DVec3::new(1.0 - coloured, 1.0, 1.0 + coloured));
                    let value = 5.0 * (1.0 + light + noise * normal());
                    row.add(0, pass as u64, value);
                    (sum, squares) = (sum + value, squares + value * value);
                }
                let n = passes as f64;
                let spread = (squares - sum * sum / n) / (n - 1.0) / n;
                stated += control.variance(0, passes, sum, squares).unwrap_or(spread);
                plain += spread;
                real += (sum / n - 5.0).powi(2);
            }
            let [stated, plain, real] = [stated, plain, real].map(|sum| sum / RUNS as f64);
            println!("{passes} passes, even {even}: states {stated}, by the spread {plain}, really {real}");
            assert!((stated / real - 1.0).abs() < 0.1, "{passes}, {even}: {stated}, really {real}");
            assert!(!even || noise > 0.5 || stated < 0.1 * plain, "{passes}: {stated}, by the spread {plain}");
        }
    }

    #[test]
    fn pieces_are_added_up_and_numbers_that_are_none_are_told() {
        let known = |pass: u64| [1.0, 2.0, 3.0].map(|k| (k * (1.0 + pass as f64)).sin());
        let filled = |passes: std::ops::Range<u64>| {
            let mut control = ControlVariates::new([2, 1]);
            assert!(control.know(passes.clone().map(|pass| (pass, known(pass)))));
            let mut row = control.rows().next().unwrap();
            passes.for_each(|pass| row.add(1, pass, 1.0 / (3.0 + pass as f64)));
            control
        };
        let whole = filled(0..20);
        let mut pieces = filled(13..20);
        for more in [filled(5..13), filled(0..5)] {
            pieces.products.merge(&more.products);
            assert!(pieces.know(more.known().iter().copied()));
        }
        assert_eq!(pieces, whole);
        // Passes without a number that is one, or that nothing is known of, add nothing.
        let mut damaged = filled(0..2);
        assert!(!damaged.know([(2, [f64::NAN; COUNT])]));
        assert_eq!(damaged.variance(1, 90, 1.0, 1.0), None);
        assert_eq!(filled(0..3).variance(1, 3, 1.0, 1.0), None);
    }
}
