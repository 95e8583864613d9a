//! Growing a tree from weighted points: each box is cut where the two sides differ most, as a density estimation tree (P.
//! Ram and A. G. Gray, "Density estimation trees", KDD 2011, with likelihood as the measure), and the probabilities of the
//! sides are smoothed as in a Pólya tree.

use super::tree::{AXES, Grower, MOST_DEPTH, Point, Tree};
use std::ops::Range;

/// A point of the cube and what it is worth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weighted {
    pub x: Point,
    pub weight: f64,
}

/// Samples that are spread evenly whatever was learned, as parts of all.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Even {
    /// Of the lamps, which get them by flux.
    lamps: f64,
    /// Of each lamp's cube.
    cube: f64,
    /// The same where nothing was learned, beside that; half of it with `SURE` effective points.
    unsure: f64,
}

impl Even {
    /// For a look, and for light that is not what was learned from: what counts may be anywhere.
    pub const MANY: Even = Even { lamps: 0.15, cube: 0.15, unsure: 0.3 };
    /// For light that was learned from.
    pub const FEW: Even = Even { lamps: 0.02, cube: 0.03, unsure: 0.1 };
    const SURE: f64 = 100.0;

    /// Of the lamps.
    pub fn of_lamps(self) -> f64 {
        self.lamps
    }

    /// Of a cube that so many effective points tell of.
    fn of_cube(self, effective: f64) -> f64 {
        self.cube + self.unsure * Self::SURE / (Self::SURE + effective)
    }
}

/// Gain in log-likelihood that pays for a cut: the best of some hundred random cuts gains about 5.
const GAIN: f64 = 6.0;
/// Points that are taken to lie on each side of a cut before any was seen.
const PRIOR: f64 = 0.5;
/// Effective points below which a box is left whole.
const FEWEST: f64 = 6.0;
/// Effective points on either side of a cut between points. With fewer a side is left whole, and if it is large they are
/// lost in it: such cuts hid some 4 % of the direct HUD's light, at a hundredth of its density, from all later looks.
const EITHER_SIDE: f64 = 20.0;
/// Intervals of a box that may be cut between.
const BINS: usize = 32;
/// An empty side of a cut begins beyond the last point by `BEYOND` times the distance of the last `EDGE` points, which
/// is as large as the density fades slowly there: what is cut away and yet counts comes back as rare bright paths. Far
/// from the points there is a first cut `SHELL` times as far, so that just beyond the last point is not as rare as far away.
const BEYOND: f64 = 2.0;
const EDGE: usize = 5;
const SHELL: f64 = 4.0;
/// Narrowest side of a cut, in widths of its box.
const NARROWEST: f64 = 1.0 / 256.0;

#[derive(Clone, Copy)]
struct Cut {
    axis: usize,
    at: f32,
    gain: f64,
}

/// Weights of points: their sum and that of their squares.
#[derive(Clone, Copy, Default)]
struct Weights {
    sum: f64,
    squares: f64,
}

impl Weights {
    fn of(points: &[Weighted]) -> Self {
        let mut weights = Weights::default();
        points.iter().for_each(|p| weights.add(Weights { sum: p.weight, squares: p.weight * p.weight }));
        weights
    }

    fn add(&mut self, other: Weights) {
        self.sum += other.sum;
        self.squares += other.squares;
    }

    /// Number of equally heavy points that would tell as much.
    fn effective(self) -> f64 {
        if self.squares > 0.0 { self.sum * self.sum / self.squares } else { 0.0 }
    }
}

/// A tree for `points`, cut across `axes`, with at most about `leaves` boxes.
pub fn grow(points: &mut [Weighted], axes: Range<usize>, leaves: usize, even: Even) -> Tree {
    let [first, end] = [axes.start, axes.end];
    let whole =
        Region { low: [0.0; AXES], high: [1.0; AXES], axes: [first, end], volume: 1.0, probability: 1.0, depth: 0 };
    let mut structure = Vec::new();
    let mut left = leaves;
    let defensive = even.of_cube(Weights::of(points).effective());
    split(points, whole, defensive, &mut left, &mut structure);
    // Second walk: each box's probability is mixed with the even one, which only leaves can say exactly.
    let mut grower = Grower::default();
    let mut at = 0;
    emit(&structure, &mut at, &mut grower);
    grower.tree()
}

#[derive(Clone, Copy)]
struct Region {
    low: Point,
    high: Point,
    /// First and end of those that are cut across.
    axes: [usize; 2],
    volume: f64,
    probability: f64,
    depth: usize,
}

/// Pre-order: the mixed probability of a box, and its cut.
struct Grown {
    probability: f64,
    cut: Option<(usize, f32, usize)>,
}

fn split(points: &mut [Weighted], region: Region, defensive: f64, left: &mut usize, out: &mut Vec<Grown>) {
    let index = out.len();
    out.push(Grown { probability: defensive * region.volume + (1.0 - defensive) * region.probability, cut: None });
    let weights = Weights::of(points);
    let (mass, effective) = (weights.sum, weights.effective());
    if effective < FEWEST || region.depth >= MOST_DEPTH || *left == 0 {
        return;
    }
    let Some(cut) = best_cut(points, &region, weights) else { return };
    *left -= 1;
    let at = f64::from(cut.at);
    let middle = partition(points, |p| p.x[cut.axis] < at);
    let (below, above) = points.split_at_mut(middle);
    let share = (at - region.low[cut.axis]) / (region.high[cut.axis] - region.low[cut.axis]);
    let mass_below: f64 = below.iter().map(|p| p.weight).sum();
    let q = (effective * (mass_below / mass).clamp(0.0, 1.0) + PRIOR) / (effective + 2.0 * PRIOR);
    let depth = region.depth + 1;
    let mut side = Region { depth, volume: region.volume * share, probability: region.probability * q, ..region };
    side.high[cut.axis] = at;
    split(below, side, defensive, left, out);
    let second = out.len();
    out[index].cut = Some((cut.axis, cut.at, second));
    let volume = region.volume * (1.0 - share);
    let mut side = Region { depth, volume, probability: region.probability * (1.0 - q), ..region };
    side.low[cut.axis] = at;
    split(above, side, defensive, left, out);
}

fn emit(structure: &[Grown], at: &mut usize, grower: &mut Grower) {
    let node = &structure[*at];
    let below = *at + 1;
    *at = below;
    match node.cut {
        None => grower.leaf(),
        Some((axis, cut, _)) => {
            let index = grower.cut(axis, cut, structure[below].probability / node.probability);
            emit(structure, at, grower);
            grower.above(index);
            emit(structure, at, grower);
        }
    }
}

/// Moves the points that satisfy `is` to the front, in a fixed order; returns their number.
fn partition(points: &mut [Weighted], is: impl Fn(&Weighted) -> bool) -> usize {
    let mut count = 0;
    for index in 0..points.len() {
        if is(&points[index]) {
            points.swap(index, count);
            count += 1;
        }
    }
    count
}

/// Keeps the extreme numbers in order.
fn insert(extremes: &mut [f64; EDGE], x: f64, before: impl Fn(f64, f64) -> bool) {
    let at = extremes.iter().position(|other| before(x, *other)).unwrap_or(EDGE);
    if at < EDGE {
        extremes[at..].rotate_right(1);
        extremes[at] = x;
    }
}

/// The cut that gains most, if any gains enough.
fn best_cut(points: &[Weighted], region: &Region, all: Weights) -> Option<Cut> {
    let (mass, effective) = (all.sum, all.effective());
    let mut best: Option<Cut> = None;
    for axis in region.axes[0]..region.axes[1] {
        let (low, high) = (region.low[axis], region.high[axis]);
        let width = high - low;
        let mut bins = [Weights::default(); BINS];
        let (mut first, mut last) = ([high; EDGE], [low; EDGE]);
        for p in points {
            let x = p.x[axis];
            let bin = ((x - low) / width * BINS as f64).clamp(0.0, (BINS - 1) as f64) as usize;
            bins[bin].add(Weights { sum: p.weight, squares: p.weight * p.weight });
            insert(&mut first, x, |a, b| a < b);
            insert(&mut last, x, |a, b| a > b);
        }
        let mut consider = |at: f64, mass_below: f64| {
            // The cut that is stored decides.
            let at = at as f32;
            let share = (f64::from(at) - low) / width;
            let wide_enough = (NARROWEST..=1.0 - NARROWEST).contains(&share);
            if !(wide_enough && low < f64::from(at) && f64::from(at) < high) {
                return;
            }
            let q = (mass_below / mass).clamp(0.0, 1.0);
            let part = |q: f64, share: f64| if q > 0.0 { q * (q / share).ln() } else { 0.0 };
            let gain = effective * (part(q, share) + part(1.0 - q, 1.0 - share));
            if gain > best.map_or(GAIN, |best| best.gain) {
                best = Some(Cut { axis, at, gain });
            }
        };
        let mut below = Weights::default();
        for (bin, in_bin) in bins.iter().enumerate().take(BINS - 1) {
            below.add(*in_bin);
            let above = Weights { sum: mass - below.sum, squares: all.squares - below.squares };
            let at = low + width * (bin + 1) as f64 / BINS as f64;
            // Where a side is empty, the edge of the points decides.
            if first[0] < at && at < last[0] && below.effective().min(above.effective()) >= EITHER_SIDE {
                consider(at, below.sum);
            }
        }
        let beyond = |[edge, inner]: [f64; 2], bound: f64| {
            let margin = BEYOND * (edge - inner);
            let far = edge + SHELL * margin;
            if (bound - far).abs() > (far - edge).abs() && (bound - edge) * (bound - far) > 0.0 {
                far
            } else {
                edge + margin
            }
        };
        consider(beyond([first[0], first[EDGE - 1]], low), 0.0);
        consider(beyond([last[0], last[EDGE - 1]], high), mass);
    }
    best
}
