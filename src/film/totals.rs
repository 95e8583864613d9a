//! Luminance of whole parts of the picture, pass by pass. What all pixels have of the same photons or wavelengths does not
//! show in each pixel's own variance; it shows in how far the passes' totals lie apart. And what each pass cost.

use super::accumulate::light::Light;
use eyebox_base::double_double::Sum;

/// The picture is cut into so many parts side by side, and one above the other.
pub const ACROSS: usize = 4;
pub const DOWN: usize = 3;
/// Those parts, after the whole picture.
pub const PARTS: usize = 1 + ACROSS * DOWN;

/// The part of a picture of `size` in which a pixel lies, from 1 on.
pub fn part_of([x, y]: [usize; 2], [width, height]: [usize; 2]) -> usize {
    1 + (y * DOWN / height.max(1)) * ACROSS + x * ACROSS / width.max(1)
}

/// Sums over the passes that were closed.
#[derive(Debug, Clone)]
pub struct Totals {
    size: [usize; 2],
    planes: usize,
    /// `[plane][part]`: a pass's total, and its square.
    sums: Vec<[Sum; 2]>,
    /// Per row of pixels, of passes that are not closed yet.
    strips: Vec<Strip>,
    /// Number and counted work of passes that nobody has asked for yet.
    works: Vec<(u64, u64)>,
}

impl PartialEq for Totals {
    fn eq(&self, other: &Totals) -> bool {
        (self.size, self.planes, &self.sums) == (other.size, other.planes, &other.sums)
    }
}

/// What a row of pixels has of each pass, in their order.
#[derive(Debug, Clone, Default)]
pub struct Strip(Vec<Entry>);

#[derive(Debug, Clone)]
struct Entry {
    pass: u64,
    work: u64,
    /// `[plane][part across]`
    light: Vec<f64>,
}

impl Strip {
    fn entry(&mut self, pass: u64, planes: usize) -> Option<&mut Entry> {
        if self.0.last().is_none_or(|last| last.pass != pass) {
            self.0.push(Entry { pass, work: 0, light: vec![0.0; planes * ACROSS] });
        }
        self.0.last_mut()
    }
}

/// One row of pixels, for the thread that owns it.
pub struct TotalsRow<'f> {
    width: usize,
    planes: usize,
    strip: &'f mut Strip,
}

impl TotalsRow<'_> {
    /// Adds the luminance of pixel `x` in a plane.
    pub fn add(&mut self, (x, plane): (usize, usize), pass: u64, light: Light) {
        let across = x * ACROSS / self.width.max(1);
        if light.value != 0.0
            && let Some(entry) = self.strip.entry(pass, self.planes)
        {
            entry.light[plane * ACROSS + across] += light.value;
        }
    }

    /// Adds what the row has cost in a pass.
    pub fn add_work(&mut self, pass: u64, work: u64) {
        if let Some(entry) = self.strip.entry(pass, self.planes) {
            entry.work += work;
        }
    }
}

impl Totals {
    pub fn new(size: [usize; 2], planes: usize) -> Totals {
        let strips = vec![Strip::default(); size[1]];
        Totals { size, planes, sums: vec![[Sum::ZERO; 2]; planes * PARTS], strips, works: Vec::new() }
    }

    /// The rows, top to bottom.
    pub fn rows(&mut self) -> impl Iterator<Item = TotalsRow<'_>> {
        let (width, planes) = (self.size[0], self.planes);
        self.strips.iter_mut().map(move |strip| TotalsRow { width, planes, strip })
    }

    /// Adds what a pass has cost beside its rows.
    pub fn add_work(&mut self, pass: u64, work: u64) {
        match self.works.iter_mut().rev().find(|(own, _)| *own == pass) {
            Some((_, sum)) => *sum += work,
            None => self.works.push((pass, work)),
        }
    }

    /// To be called when the rows have whole passes in them.
    pub fn close(&mut self) {
        let mut passes: Vec<u64> =
            self.strips.iter().flat_map(|strip| strip.0.iter().map(|entry| entry.pass)).collect();
        passes.sort_unstable();
        passes.dedup();
        let mut next = vec![0; self.strips.len()];
        for pass in passes {
            let (mut totals, mut work) = (vec![0.0; self.planes * PARTS], 0);
            for (y, (strip, next)) in self.strips.iter().zip(&mut next).enumerate() {
                let Some(entry) = strip.0.get(*next).filter(|entry| entry.pass == pass) else { continue };
                *next += 1;
                work += entry.work;
                for (at, value) in entry.light.iter().enumerate() {
                    let (plane, across) = (at / ACROSS, at % ACROSS);
                    let part = 1 + (y * DOWN / self.size[1].max(1)) * ACROSS + across;
                    totals[plane * PARTS] += value;
                    totals[plane * PARTS + part] += value;
                }
            }
            for ([sum, square], total) in self.sums.iter_mut().zip(&totals) {
                sum.add(*total);
                square.add(total * total);
            }
            self.add_work(pass, work);
        }
        self.strips.iter_mut().for_each(|strip| strip.0.clear());
    }

    /// Number and counted work of the passes since this was asked last.
    pub fn take_works(&mut self) -> Vec<(u64, u64)> {
        std::mem::take(&mut self.works)
    }

    /// Sum over passes of a plane's total in a part of the picture, cd/m², and of its square.
    pub fn of(&self, plane: usize, part: usize) -> [f64; 2] {
        self.sums[plane * PARTS + part].map(Sum::value)
    }

    /// Variance of the mean over `passes` of that total, (cd/m²)²: infinite before the second pass.
    pub fn variance(&self, plane: usize, part: usize, passes: u64) -> f64 {
        let ([sum, square], passes) = (self.of(plane, part), passes as f64);
        if passes < 2.0 {
            return if sum > 0.0 { f64::INFINITY } else { 0.0 };
        }
        ((square - sum * sum / passes) / (passes * (passes - 1.0))).max(0.0)
    }

    /// All sums, to be stored.
    pub fn sums(&self) -> &[[Sum; 2]] {
        &self.sums
    }

    /// Puts sums that were stored; false if they are of another kind.
    pub fn put(&mut self, sums: Vec<[Sum; 2]>) -> bool {
        let fits = sums.len() == self.sums.len() && sums.as_flattened().iter().all(|sum| sum.is_finite());
        if fits {
            self.sums = sums;
        }
        fits
    }

    pub fn merge(&mut self, other: &Totals) {
        let own = self.sums.as_flattened_mut().iter_mut();
        own.zip(other.sums.as_flattened()).for_each(|(sum, more)| sum.merge(*more));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn light(value: f64) -> Light {
        Light { value, ..Light::default() }
    }

    /// A 8 × 6 picture of two planes whose pixels all swing together from pass to pass.
    #[test]
    fn totals_of_parts_are_those_of_their_pixels() {
        let size = [8, 6];
        let value =
            |x: usize, y: usize, plane: usize, pass: u64| (1 + x + 10 * y + 100 * plane) as f64 * (pass + 1) as f64;
        let run = |blocks: &[[u64; 2]]| {
            let mut totals = Totals::new(size, 2);
            for block in blocks {
                for (y, mut row) in totals.rows().enumerate() {
                    for pass in block[0]..block[1] {
                        for (x, plane) in (0..8).flat_map(|x| [(x, 0), (x, 1)]) {
                            row.add((x, plane), pass, light(value(x, y, plane, pass)));
                        }
                        row.add_work(pass, 5);
                    }
                }
                totals.close();
            }
            totals
        };
        let mut whole = run(&[[0, 4]]);
        for plane in 0..2 {
            for part in 0..PARTS {
                let of_pass = |pass: u64| -> f64 {
                    let pixels = (0..6).flat_map(|y| (0..8).map(move |x| [x, y]));
                    pixels
                        .filter(|pixel| part == 0 || part_of(*pixel, size) == part)
                        .map(|[x, y]| value(x, y, plane, pass))
                        .sum()
                };
                let want: f64 = (0..4).map(|pass| of_pass(pass).powi(2)).sum();
                assert!((whole.of(plane, part)[1] - want).abs() < 1e-12 * want, "{plane} {part}");
            }
        }
        assert_eq!(whole, run(&[[0, 1], [1, 4]]));
        assert_eq!(whole.take_works(), [(0, 30), (1, 30), (2, 30), (3, 30)]);
        assert!(whole.take_works().is_empty());
        let mut merged = run(&[[2, 4]]);
        merged.merge(&run(&[[0, 2]]));
        assert_eq!(merged, whole);
    }
}
