//! Which points of a lamp to join with a place of the picture, where only some of them are seen through the pupil: at the
//! rim of a lamp's picture most others would be solved for in vain, and the few that are not would be bright and rare.

use super::tuning::lamp_visibility::{ALL, BOXES, ELSEWHERE, ENDS, MARGIN, SPENT_ELSEWHERE};
use super::{Node, Seeds};
use eyebox_base::warp::BELOW_ONE;
use eyebox_world::eye::EyeLens;
use eyebox_world::lamp::{Lamp, LampPoint};
use glam::{DVec2, DVec3};
use std::f64::consts::FRAC_1_SQRT_2;

/// A box's points of a lamp, on its plane from the middle, m.
#[derive(Debug, Clone, Copy)]
pub(super) struct Part {
    middle: DVec2,
    radius: f64,
}

impl Part {
    /// All of a lamp. `local`: of a point, its place on the lamp's plane.
    pub(super) fn of(lamp: &Lamp, local: impl Fn(DVec3) -> DVec2) -> Vec<Part> {
        // A box's corners belong to it, though its neighbour may be elsewhere on the lamp.
        const INSIDE: f64 = 1e-6;
        let (low, high) = (INSIDE, 1.0 - INSIDE);
        let part = |index: usize| {
            let first = [index / BOXES[1], index % BOXES[1]];
            let number = |k: usize, s: f64| (first[k] as f64 + s) / BOXES[k] as f64;
            let at = |[s, t]: [f64; 2]| local(lamp.sample_point([number(0, s), number(1, t)]).position);
            let middle = at([0.5; 2]);
            let farthest = |far: f64, corner: DVec2| far.max(corner.distance(middle));
            let radius = match lamp.corners_of([low, high].map(|s| number(0, s))) {
                (1, _) => [[low, low], [high, low], [low, high], [high, high]].map(at).into_iter().fold(0.0, farthest),
                // Triangles that follow each other may lie anywhere.
                (_, corners) => corners.map(&local).fold(0.0, farthest),
            };
            Part { middle, radius }
        };
        (0..ALL).map(part).collect()
    }
}

impl Seeds {
    /// About which share of the rays between places about one in the picture, as far as `half` along both axes, and points of
    /// the lamp go through the pupil, or reach all of it; and what share of that the lamp's picture fills, or more than all.
    /// Of the branch that shows most; none where no branch is known. Both are rough.
    pub fn shown(&self, film: DVec2, half: DVec2, eye: &EyeLens) -> Option<(f64, f64)> {
        let cell = self.grid.cell(film);
        let off = film - self.grid.middle(cell);
        let area = 2.0 * self.size.powi(2) / eye.pupil_area_m2();
        let of = |node: &Node| {
            let shown = node.share_shown(off, half, self.size, eye.pupil_radius_m());
            (shown, area * node.by_lamp_at(off).determinant().abs())
        };
        self.useful(cell)
            .map(of)
            .filter(|(shown, fills)| shown.is_finite() && fills.is_finite())
            .max_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// A point of the lamp to be joined with a place of the picture, and its density over that of all points alike; of a train
    /// with little light any point. A function of the arguments alone. `radius`: of the pupil, m.
    pub fn aim(&self, lamp: &Lamp, film: DVec2, radius: f64, [u, v]: [f64; 2]) -> (LampPoint, f64) {
        let anywhere = || (lamp.sample_point([u, v]), 1.0);
        if self.parts.is_empty() {
            return anywhere();
        }
        let cell = self.grid.cell(film);
        let off = film - self.grid.middle(cell);
        let mut seen = [false; ALL];
        for node in self.useful(cell) {
            let middle = node.predict(off, DVec2::ZERO);
            let by_lamp = node.by_lamp_at(off);
            let wide = (1.0 + MARGIN) * (by_lamp.x_axis.length_squared() + by_lamp.y_axis.length_squared()).sqrt();
            let (far, size) = (middle.length(), wide * self.size);
            // All of the lamp is seen through the pupil, or none.
            if far + size <= radius {
                return anywhere();
            }
            let about = (1.0 + MARGIN) * radius + node.unsure;
            if far - size > about {
                continue;
            }
            for (part, seen) in self.parts.iter().zip(&mut seen) {
                let reach = about + wide * part.radius;
                *seen |= (middle + by_lamp * part.middle).length_squared() <= reach * reach;
            }
        }
        let shown = seen.iter().filter(|seen| **seen).count() as f64;
        let others = ALL as f64 - shown;
        // Nothing is chosen where none is shown, or all.
        if others == 0.0 || shown == 0.0 {
            return anywhere();
        }
        let elsewhere = ELSEWHERE.min(SPENT_ELSEWHERE * shown / others);
        let density = |seen: bool| if seen { 1.0 } else { elsewhere };
        // By rows and within the row, so that points that are even stay so.
        let rows = seen.chunks_exact(BOXES[1]);
        let (row, s) = choose(rows.clone().map(|row| row.iter().map(|seen| density(*seen)).sum()), u);
        let Some(of_row) = rows.clone().nth(row) else { return anywhere() };
        let (column, t) = choose(of_row.iter().map(|seen| density(*seen)), v);
        let uv = [(row as f64 + s) / BOXES[0] as f64, (column as f64 + t) / BOXES[1] as f64];
        let whole = shown + elsewhere * others;
        (lamp.sample_point(uv), density(of_row[column]) * ALL as f64 / whole)
    }
}

/// Which of some weights `u` falls to, and where in it. Their sum is positive.
fn choose(weights: impl Iterator<Item = f64> + Clone, u: f64) -> (usize, f64) {
    let mut left = u * weights.clone().sum::<f64>();
    let mut chosen = (0, 0.0);
    for (index, weight) in weights.enumerate() {
        chosen = (index, (left / weight).min(BELOW_ONE));
        if left < weight {
            break;
        }
        left -= weight;
    }
    chosen
}

impl Node {
    /// About which share of the rays between places about one in the picture and points of a lamp go through the pupil.
    fn share_shown(&self, off: DVec2, half: DVec2, size: f64, radius: f64) -> f64 {
        let middle = self.predict(off, DVec2::ZERO);
        let outwards = middle.normalize_or_zero();
        let (by_lamp, by_film) = (self.by_lamp_at(off), self.by_film);
        let along = |column: DVec2, half: f64| (column.dot(outwards) * half).powi(2) / 3.0;
        // A square of that radius has sides of √2 of it.
        let side = size * FRAC_1_SQRT_2;
        let of_lamp = along(by_lamp.x_axis, side) + along(by_lamp.y_axis, side);
        let of_film = along(by_film.x_axis, half.x) + along(by_film.y_axis, half.y);
        // The smaller of the lamp's picture and the pupil ends within the larger.
        let spread = ENDS * (of_lamp.min(0.25 * radius * radius) + of_film).sqrt();
        let inside = (0.5 + 0.5 * (radius.max((3.0 * of_lamp).sqrt()) - middle.length()) / spread).clamp(0.0, 1.0);
        inside.powi(3) * (10.0 + inside * (6.0 * inside - 15.0))
    }
}
