//! Guided sky as data: through which part of a scene's surroundings light of the sky gets in.
//!
//! Every ray that leaves the scene crosses a box around it in one point, as the box is convex. Where the crossings have a
//! density per area, directions from any point inside have one per solid angle: a window that is learned from some
//! points is aimed at from all.

use super::learn::{Even, Weighted, grow};
use super::tree::{AXES, Point, Tree};
use eyebox_base::warp::BELOW_ONE;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A density over the surface of a box around a scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Data", into = "Data")]
pub struct Portals {
    /// Corners, recentred world, m.
    low: DVec3,
    high: DVec3,
    /// Of the directions to the sky: so many are chosen by this density, and the rest by luminance.
    aimed: f64,
    /// Probability of each side: across x, y and z, first the lower one, then the upper one.
    shares: [f64; SIDES],
    /// The last two axes are a side's: those that come after the one across it, in the order x, y, z, x, y.
    trees: Vec<Tree>,
}

#[derive(Serialize, Deserialize)]
struct Data {
    low: [f64; 3],
    high: [f64; 3],
    aimed: f64,
    shares: [f64; SIDES],
    trees: Vec<Tree>,
}

/// Where light of the sky has got in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    /// A point inside the box that it was on the way to, recentred world, m.
    pub to: DVec3,
    /// Unit direction from there to where it came from.
    pub from: DVec3,
    /// What it brought, over the density of finding it; any unit.
    pub weight: f64,
}

/// Where a ray from inside crosses the box.
struct Crossing {
    side: usize,
    /// Place on the side, 0 to 1.
    at: [f64; 2],
    /// m to there, and the cosine against the side's normal.
    distance: f64,
    cos: f64,
}

const SIDES: usize = 6;
/// First axis of a side.
const SIDE: usize = 2;
/// By this part of its diagonal the box is larger on each side than the scene: surfaces are inside.
const MARGIN: f64 = 1.0 / 1024.0;
/// Fewest entries to learn from.
const FEWEST: usize = 48;
/// Most boxes of a side's tree.
const LEAVES: usize = 256;
/// Shares add up to 1 within this, by rounding.
const SUM: f64 = 1e-9;

impl Portals {
    /// Learns from what got in. `bounds`: corners of a box around all surfaces. `aimed`: the part of directions to the sky that
    /// are chosen so, below 1. None if there is too little to learn from.
    pub fn learn((low, high): (DVec3, DVec3), aimed: f64, entries: &[Entry]) -> Option<Portals> {
        let margin = DVec3::splat(MARGIN * (high - low).length());
        let uniform = vec![Tree::uniform(); SIDES];
        let shares = [1.0 / SIDES as f64; SIDES];
        let plain = Portals { low: low - margin, high: high + margin, aimed, shares, trees: uniform };
        let mut points: [Vec<Weighted>; SIDES] = Default::default();
        for entry in entries.iter().filter(|entry| entry.weight > 0.0 && entry.weight.is_finite()) {
            let Some(Crossing { side, at: [a, b], .. }) = plain.crossing(entry.to, entry.from) else { continue };
            points[side].push(Weighted { x: [0.5, 0.5, a, b], weight: entry.weight });
        }
        if points.iter().map(Vec::len).sum::<usize>() < FEWEST {
            return None;
        }
        let sums = points.each_ref().map(|of| of.iter().map(|point| point.weight).sum::<f64>());
        let total: f64 = sums.iter().sum();
        let mut trees = Vec::with_capacity(SIDES);
        for of in &mut points {
            trees.push(grow(of, SIDE..AXES, LEAVES, Even::FEW));
        }
        let learned = Data {
            low: plain.low.to_array(),
            high: plain.high.to_array(),
            aimed,
            shares: sums.map(|sum| sum / total),
            trees,
        };
        learned.try_into().ok()
    }

    /// The same with another part of the directions that are chosen so.
    #[must_use]
    pub fn aiming(self, aimed: f64) -> Portals {
        Portals { aimed, ..self }
    }

    /// The part of a point's directions to the sky that are chosen so: none where it is not inside the box.
    pub fn aimed_from(&self, point: DVec3) -> f64 {
        if self.contains(point) { self.aimed } else { 0.0 }
    }

    /// The unit direction that `u` in the unit square becomes at a point inside the box.
    pub fn direction(&self, point: DVec3, [u, v]: [f64; 2]) -> DVec3 {
        let (mut side, mut below) = (0, 0.0);
        // The last side that has any, should rounding lead beyond it.
        let (mut rest, mut share) = (u, 1.0);
        for (index, of) in self.shares.iter().enumerate().filter(|(_, of)| **of > 0.0) {
            (side, share) = (index, *of);
            rest = u - below;
            below += share;
            if u < below {
                break;
            }
        }
        let ([.., a, b], _) = self.trees[side].draw([0.5, 0.5, (rest / share).clamp(0.0, BELOW_ONE), v]);
        let [across, first, second] = axes(side);
        let mut on = if side.is_multiple_of(2) { self.low } else { self.high };
        on[first] = self.low[first] + a * (self.high[first] - self.low[first]);
        on[second] = self.low[second] + b * (self.high[second] - self.low[second]);
        debug_assert!(on[across] == self.low[across] || on[across] == self.high[across]);
        (on - point).normalize()
    }

    /// Density of [`Portals::direction`] in a unit direction, 1/sr; 0 from a point that is not inside the box.
    pub fn pdf(&self, point: DVec3, dir: DVec3) -> f64 {
        let Some(Crossing { side, at: [a, b], distance, cos }) = self.crossing(point, dir) else { return 0.0 };
        if self.shares[side] <= 0.0 {
            return 0.0;
        }
        let [_, first, second] = axes(side);
        let size = self.high - self.low;
        let place: Point = [0.5, 0.5, a, b];
        let per_area = self.shares[side] * self.trees[side].density(&place) / (size[first] * size[second]);
        per_area * distance * distance / cos
    }

    /// Density of a direction to the sky that is chosen so or, with density `by_sky`, by luminance, 1/sr.
    pub fn among(&self, point: DVec3, dir: DVec3, by_sky: f64) -> f64 {
        let aimed = self.aimed_from(point);
        let by_windows = if aimed > 0.0 { aimed * self.pdf(point, dir) } else { 0.0 };
        by_windows + (1.0 - aimed) * by_sky
    }

    fn contains(&self, point: DVec3) -> bool {
        self.low.cmplt(point).all() && point.cmplt(self.high).all()
    }

    fn crossing(&self, point: DVec3, dir: DVec3) -> Option<Crossing> {
        if !(self.contains(point) && dir.is_finite()) {
            return None;
        }
        let mut nearest: Option<(usize, f64)> = None;
        for axis in 0..3 {
            let side = 2 * axis + usize::from(dir[axis] > 0.0);
            let bound = if dir[axis] > 0.0 { self.high[axis] } else { self.low[axis] };
            let distance = (bound - point[axis]) / dir[axis];
            if dir[axis] != 0.0 && nearest.is_none_or(|(_, best)| distance < best) {
                nearest = Some((side, distance));
            }
        }
        let (side, distance) = nearest?;
        let [across, first, second] = axes(side);
        let on = point + distance * dir;
        let at = |axis: usize| ((on[axis] - self.low[axis]) / (self.high[axis] - self.low[axis])).clamp(0.0, BELOW_ONE);
        Some(Crossing { side, at: [at(first), at(second)], distance, cos: dir[across].abs() })
    }
}

/// The axis across a side, and the two along it.
fn axes(side: usize) -> [usize; 3] {
    let across = side / 2;
    [across, (across + 1) % 3, (across + 2) % 3]
}

impl From<Portals> for Data {
    fn from(windows: Portals) -> Data {
        let Portals { low, high, aimed, shares, trees } = windows;
        Data { low: low.to_array(), high: high.to_array(), aimed, shares, trees }
    }
}

impl TryFrom<Data> for Portals {
    type Error = String;

    /// Errors: a box without room or too large to square, a part of the directions or of a side that is no probability, no
    /// tree for each side, trees that are cut across other axes than a side's.
    fn try_from(data: Data) -> Result<Portals, String> {
        let (low, high) = (DVec3::from_array(data.low), DVec3::from_array(data.high));
        let size = high - low;
        // Normal numbers: nothing that is divided by them runs out of range.
        let areas = [size.x * size.y, size.y * size.z, size.z * size.x, size.length_squared()];
        if !(low.is_finite() && low.cmplt(high).all() && areas.iter().all(|area| area.is_normal())) {
            return Err(format!("a guide of the sky has a box from {low} to {high}"));
        }
        if !(data.aimed > 0.0 && data.aimed < 1.0) {
            return Err(format!("a guide of the sky is asked for {} of the directions", data.aimed));
        }
        let sound = data.shares.iter().all(|share| (0.0..=1.0 + SUM).contains(share));
        if !(sound && (data.shares.iter().sum::<f64>() - 1.0).abs() <= SUM) {
            return Err(format!("a guide of the sky has shares of {:?}", data.shares));
        }
        if data.trees.len() != SIDES {
            return Err(format!("a guide of the sky has {} trees for {SIDES} sides", data.trees.len()));
        }
        if data.trees.iter().any(|tree| tree.is_cut_before(SIDE)) {
            return Err("a guide of the sky has a tree that is cut across what is no side".to_owned());
        }
        Ok(Portals { low, high, aimed: data.aimed, shares: data.shares, trees: data.trees })
    }
}

#[cfg(test)]
#[path = "portals_tests.rs"]
mod tests;
