//! A second, weaker picture beside the first. What is sought is the shift d and the ratio r of p(x) + r·p(x − d), for a picture
//! p of which nothing is known but that it has no more edges than it needs.
//!
//! The echo is taken away by q(x) = i(x) − r·q(x − d), which gives p back where r and d are right. Anything else leaves edges
//! that p hasn't: the sum of |∇q| is least for p (the principle of total variation: Rudin, Osher and Fatemi 1992; sparse
//! deconvolution: Claerbout and Muir 1973). Only edges that d moves across themselves are counted: a line says nothing of a
//! shift along itself, and would be shortened by it. A shift by chance gains nothing, since more than half of the edges would
//! have to fall on others of their kind. Where that happens at several shifts the picture repeats itself, and no method can
//! tell a ghost from it.

use super::likeness::{Likeness, NEAREST, smooth};
use glam::DVec2;
use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, IntoParallelRefMutIterator, ParallelIterator};

/// An echo has to take away so many times what the best other shift takes away.
const CLEAR: f64 = 1.5;
/// A ghost as bright as this is no weaker picture: the picture is there twice.
const TWICE: f64 = 0.95;
/// Share of the edges that has to go: less may be sampling.
const LEAST: f64 = 0.01;
/// Standard errors that a ratio has to be above 0.
const SURE: f64 = 3.0;
/// Share of a ratio that it can be wrong by because edges are sampled by pixels, and moved between them.
const SAMPLING: f64 = 0.03;
/// Shifts that are looked at closely.
const CANDIDATES: usize = 16;
/// Blocks of the picture that are left out one after the other for the error.
const BLOCKS: [usize; 2] = [8, 4];

/// The ghost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Echo {
    /// Pixels to the right and down, from the picture to its ghost.
    pub offset: DVec2,
    /// Luminance of the ghost over that of the picture.
    pub ratio: f64,
    /// One standard error of the ratio, by leaving out parts of the picture, and by what pixels can tell.
    pub sigma: f64,
}

/// Why there is no echo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Missing {
    /// No shift makes the picture simpler.
    None,
    /// The picture is like itself at both of these shifts, pixels.
    Repeats([DVec2; 2]),
    /// No edges: nothing that a ghost could be seen of.
    Empty,
}

/// The ghost in a picture.
pub fn echo(values: &[f64], size: [usize; 2]) -> Result<Echo, Missing> {
    let Some(like) = Likeness::of(values, size) else { return Err(Missing::Empty) };
    let picture = Picture { values: smooth(values, size), size, edges: 1.0 };
    let edges = picture.edges_of(&picture.values, None).iter().sum::<f64>();
    let picture = Picture { edges, ..picture };
    let shifts: Vec<DVec2> = like.peaks(CANDIDATES).into_iter().flat_map(|shift| [shift, -shift]).collect();
    let mut found: Vec<Fit> = shifts.into_par_iter().map(|shift| picture.tried(shift)).collect();
    let by_gain = |found: &mut Vec<Fit>| found.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    by_gain(&mut found);
    found.par_iter_mut().take(4).for_each(|fit| *fit = picture.refined(*fit));
    by_gain(&mut found);
    let Some(best) = found.first().copied().filter(|fit| fit.gain > LEAST) else { return Err(Missing::None) };
    // What the picture gains by other shifts, by chance or by what it shows.
    let other =
        found.iter().find(|fit| (fit.shift - best.shift).length().min((fit.shift + best.shift).length()) > NEAREST);
    let rival = other.filter(|other| best.gain < CLEAR * other.gain).map(|other| other.shift);
    if rival.is_some() || best.ratio > TWICE {
        return Err(Missing::Repeats([best.shift, rival.unwrap_or(-best.shift)]));
    }
    let sigma = picture.error(best);
    if best.ratio < SURE * sigma {
        Err(Missing::None)
    } else {
        Ok(Echo { offset: best.shift, ratio: best.ratio, sigma })
    }
}

/// A shift, the ratio that leaves fewest edges, and the share of all edges that it takes away.
#[derive(Debug, Clone, Copy)]
struct Fit {
    shift: DVec2,
    ratio: f64,
    gain: f64,
}

struct Picture {
    values: Vec<f64>,
    size: [usize; 2],
    /// Sum of all |∇i|.
    edges: f64,
}

impl Picture {
    /// The picture without the echo. What came from beyond the frame isn't known, and stays.
    fn without(&self, shift: DVec2, ratio: f64) -> Vec<f64> {
        let [w, h] = self.size.map(|n| n as i64);
        let floor = shift.floor();
        let (across, down) = (cubic(shift.x - floor.x), cubic(shift.y - floor.y));
        let (right, below) = (floor.x as i64, floor.y as i64);
        let mut out = self.values.clone();
        // Along the longer side of the shift, against which nothing of a pixel's own source comes later.
        let by_rows = shift.y.abs() >= shift.x.abs();
        let (outer, inner) = if by_rows { (h, w) } else { (w, h) };
        let backwards = if by_rows { shift.y < 0.0 } else { shift.x < 0.0 };
        for step in 0..outer {
            let line = if backwards { outer - 1 - step } else { step };
            for place in 0..inner {
                let (x, y) = if by_rows { (place, line) } else { (line, place) };
                let mut sum = 0.0;
                for (j, b) in down.iter().enumerate() {
                    // x − d is between −floor − 1 and −floor.
                    let row = y - below + 1 - j as i64;
                    if row < 0 || row >= h || *b == 0.0 {
                        continue;
                    }
                    for (i, a) in across.iter().enumerate() {
                        let column = x - right + 1 - i as i64;
                        if column >= 0 && column < w && *a != 0.0 {
                            sum += a * b * out[(row * w + column) as usize];
                        }
                    }
                }
                out[(y * w + x) as usize] -= ratio * sum;
            }
        }
        out
    }

    /// The sum of |∇| by blocks of the picture, of the edges that a shift moves, or of all.
    fn edges_of(&self, values: &[f64], shift: Option<DVec2>) -> [f64; BLOCKS[0] * BLOCKS[1]] {
        let [w, h] = self.size;
        let mut sums = [0.0; BLOCKS[0] * BLOCKS[1]];
        for y in 0..h - 1 {
            for x in 0..w - 1 {
                let at = |i: usize, j: usize| values[(y + j) * w + x + i];
                let (a, b, c, d) = (at(0, 0), at(1, 0), at(0, 1), at(1, 1));
                let edge = 0.5 * DVec2::new(b + d - a - c, c + d - a - b);
                let length = edge.length();
                if length > 0.0 {
                    let moved =
                        shift.map_or(1.0, |shift| (edge.dot(shift).abs() / length - NEAREST + 0.5).clamp(0.0, 1.0));
                    sums[y * BLOCKS[1] / h * BLOCKS[0] + x * BLOCKS[0] / w] += moved * length;
                }
            }
        }
        sums
    }

    /// Share of the edges that are gone.
    fn gain(&self, shift: DVec2, ratio: f64) -> f64 {
        let sum = |values: &[f64]| self.edges_of(values, Some(shift)).iter().sum::<f64>();
        (sum(&self.values) - sum(&self.without(shift, ratio))) / self.edges
    }

    /// The best of some ratios.
    fn tried(&self, shift: DVec2) -> Fit {
        let all = [0.06, 0.15, 0.35, 0.6, 0.85].map(|ratio| Fit { shift, ratio, gain: self.gain(shift, ratio) });
        all.into_iter()
            .fold(Fit { shift, ratio: 0.0, gain: 0.0 }, |best, fit| if fit.gain > best.gain { fit } else { best })
    }

    /// The best ratio in a range, by thirds.
    fn between(&self, shift: DVec2, [mut low, mut high]: [f64; 2], within: f64) -> Fit {
        while high - low > within {
            let third = (high - low) / 3.0;
            if self.gain(shift, low + third) > self.gain(shift, high - third) { high -= third } else { low += third }
        }
        let ratio = 0.5 * (low + high);
        Fit { shift, ratio, gain: self.gain(shift, ratio) }
    }

    /// Moves a shift to where it gains most, to a fiftieth of a pixel, and the ratio. Both lean on each other: a shift that is
    /// a little off is best with too weak a ghost. So both in turn, as long as that gains.
    fn refined(&self, start: Fit) -> Fit {
        let mut best = start;
        loop {
            let before = best.gain;
            let fit = self.between(best.shift, [0.0, 0.98], 0.002);
            if fit.gain > best.gain {
                best = fit;
            }
            let mut step = 0.5;
            while step > 0.02 {
                let around = [DVec2::X, -DVec2::X, DVec2::Y, -DVec2::Y].map(|dir| {
                    let shift = best.shift + step * dir;
                    Fit { shift, gain: self.gain(shift, best.ratio), ..best }
                });
                match around.into_iter().max_by(|a, b| a.gain.total_cmp(&b.gain)) {
                    Some(next) if next.gain > best.gain && (next.shift - start.shift).length() < 3.0 => best = next,
                    Some(_) | None => step *= 0.5,
                }
            }
            if best.gain <= before + 1e-4 {
                return best;
            }
        }
    }

    /// The jackknife's error of the ratio (Tukey 1958): by how much it changes without each block that has edges.
    fn error(&self, best: Fit) -> f64 {
        const STEPS: i32 = 12;
        let ratio = |step: i32| (best.ratio + 0.01 * f64::from(step)).clamp(0.0, 0.98);
        let costs: Vec<_> = (-STEPS..=STEPS)
            .map(|step| self.edges_of(&self.without(best.shift, ratio(step)), Some(best.shift)))
            .collect();
        let least = |without: usize| {
            let sum = |costs: &[f64; BLOCKS[0] * BLOCKS[1]]| costs.iter().sum::<f64>() - costs[without];
            let all: Vec<f64> = costs.iter().map(sum).collect();
            let at = (0..all.len()).min_by(|a, b| all[*a].total_cmp(&all[*b])).unwrap_or(0);
            ratio(at as i32 - STEPS)
        };
        let own: Vec<f64> = (0..BLOCKS[0] * BLOCKS[1])
            .filter(|block| costs[STEPS as usize][*block] > 1e-3 * self.edges)
            .map(least)
            .collect();
        let count = own.len().max(1) as f64;
        let mean = own.iter().sum::<f64>() / count;
        let spread: f64 = own.iter().map(|ratio| (ratio - mean).powi(2)).sum();
        let sampling = SAMPLING * best.ratio;
        ((count - 1.0) / count * spread + sampling * sampling).sqrt()
    }
}

/// Weights of the four pixels about a place between the middle two (Catmull and Rom 1974).
fn cubic(t: f64) -> [f64; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [0.5 * (2.0 * t2 - t3 - t), 0.5 * (3.0 * t3 - 5.0 * t2 + 2.0), 0.5 * (4.0 * t2 - 3.0 * t3 + t), 0.5 * (t3 - t2)]
}

#[cfg(test)]
#[path = "ghost_tests.rs"]
mod tests;
