//! Where in the picture luminance is read: patches that lie wholly inside of what is seen of it. One that hangs over the
//! rim, or over a lens that hides a part, would take the dark beside it for a dimmer picture.

use super::Line;
use eyebox_estimate::virtual_image::subject::on_grid;
use eyebox_scene::Eye;
use glam::DVec2;

/// The picture's grid as the eye has it on its film, in tangents to the right and up.
pub struct Places {
    columns: usize,
    rows: usize,
    /// Row by row; none where no direction ahead leads.
    films: Vec<Option<DVec2>>,
    seen: Vec<bool>,
}

impl Places {
    pub fn new(lines: &[Line], [columns, rows]: [usize; 2]) -> Places {
        let (mut films, mut seen) = (vec![None; columns * rows], vec![false; columns * rows]);
        for line in lines {
            let [column, row] = line.cell;
            let at = row * columns + column;
            // Beyond a right angle no film reaches.
            let ahead = line.direction_deg.filter(|angles| angles.iter().all(|angle| angle.abs() < 90.0));
            if let (Some(film), Some(sees)) = (films.get_mut(at), seen.get_mut(at)) {
                *film = ahead.map(|angles| DVec2::from_array(angles.map(|angle| angle.to_radians().tan())));
                *sees = line.seen && film.is_some();
            }
        }
        Places { columns, rows, films, seen }
    }

    fn visible(&self) -> impl Iterator<Item = DVec2> {
        self.films.iter().zip(&self.seen).filter(|(_, seen)| **seen).filter_map(|(film, _)| *film)
    }

    /// The box about what is seen, lower and upper corner; none where nothing is.
    pub fn bounds(&self) -> Option<[DVec2; 2]> {
        let first = self.visible().next()?;
        Some(self.visible().fold([first; 2], |[low, high], film| [low.min(film), high.max(film)]))
    }

    /// Share of the points that are seen but lie outside of a field of view, half of whose sides are these tangents.
    pub fn cut(&self, half: [f64; 2]) -> f64 {
        let half = DVec2::from_array(half);
        let outside = self.visible().filter(|film| film.abs().cmpgt(half).any()).count();
        outside as f64 / self.visible().count().max(1) as f64
    }

    /// The film's place of a place of the picture (0–1 from its upper left corner), between the four points about it.
    pub fn film(&self, [u, v]: [f64; 2]) -> Option<DVec2> {
        let (x, y) = (on_grid(u, self.columns), on_grid(v, self.rows));
        let cell = |at: f64, count: usize| (at.max(0.0) as usize).min(count.saturating_sub(2));
        let (column, row) = (cell(x, self.columns), cell(y, self.rows));
        let [a, b, c, d] = self.corners(column, row)?;
        let (s, t) = (x - column as f64, y - row as f64);
        Some(a.lerp(b, s).lerp(d.lerp(c, s), t))
    }

    /// Corners of a cell of the grid, around it, where all four are seen.
    fn corners(&self, column: usize, row: usize) -> Option<[DVec2; 4]> {
        let at = |column: usize, row: usize| {
            let index = row * self.columns + column;
            if *self.seen.get(index)? { *self.films.get(index)? } else { None }
        };
        Some([at(column, row)?, at(column + 1, row)?, at(column + 1, row + 1)?, at(column, row + 1)?])
    }

    /// Whether an upright box of the film lies wholly inside of what is seen: its corners are in cells whose corners are all
    /// seen, and it holds no point that is hidden.
    pub fn holds(&self, [low, high]: [DVec2; 2]) -> bool {
        let within = |film: &DVec2| film.cmpge(low).all() && film.cmple(high).all();
        let hidden = self.films.iter().zip(&self.seen).filter(|(_, seen)| !**seen).filter_map(|(film, _)| *film);
        if hidden.into_iter().any(|film| within(&film)) {
            return false;
        }
        let columns = self.columns.saturating_sub(1);
        let cells = || (0..columns * self.rows.saturating_sub(1)).map(|i| self.corners(i % columns, i / columns));
        let corners = [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)];
        corners.iter().all(|corner| cells().flatten().any(|cell| is_in(&cell, *corner)))
    }
}

/// Whether a point lies in a convex quadrilateral, its rim included, whichever way around that is given.
fn is_in(quad: &[DVec2; 4], point: DVec2) -> bool {
    let side = |i: usize| (quad[(i + 1) % 4] - quad[i]).perp_dot(point - quad[i]);
    let sides = [0, 1, 2, 3].map(side);
    sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0)
}

/// An eye that looks the same way with a field of view that holds a box of its film, a pixel to spare on each side, in
/// pictures of as many pixels.
pub fn looking_at(eye: &Eye, [low, high]: [DVec2; 2]) -> Eye {
    let most = low.abs().max(high.abs());
    let [width, height] = eye.resolution.map(|n| n as f64);
    let spare = |n: f64| if n > 2.0 { n / (n - 2.0) } else { 1.0 };
    let half = (most.x * spare(width)).max(most.y * spare(height) * width / height);
    let fov_deg = 2.0 * half.atan().to_degrees();
    // A picture without an extent, straight ahead, says nothing.
    let fov_deg = if fov_deg > 0.0 && fov_deg < 180.0 { fov_deg } else { eye.fov_deg };
    Eye { fov_deg, ..eye.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid of 5 × 3 points over 8° × 4°, moved to the right by 5°; `hidden` is the cell of a point that is not seen.
    fn grid(hidden: [usize; 2]) -> Vec<Line> {
        let at = |i: usize| [i % 5, i / 5];
        let line = |cell: [usize; 2]| Line {
            cell,
            seen: cell != hidden,
            direction_deg: Some([1.0 + 2.0 * cell[0] as f64, 2.0 - 2.0 * cell[1] as f64]),
            vergence: None,
            disparity: None,
        };
        (0..15).map(|i| line(at(i))).collect()
    }

    fn boxed(degrees: [f64; 2], side_deg: f64) -> [DVec2; 2] {
        [-0.5, 0.5].map(|part| DVec2::from_array(degrees.map(|at| (at + part * side_deg).to_radians().tan())))
    }

    #[test]
    fn patches_stay_inside_of_what_is_seen() {
        let all = Places::new(&grid([9, 9]), [5, 3]);
        assert!(all.holds(boxed([5.0, 0.0], 0.5)) && all.holds(boxed([1.3, 1.7], 0.5)));
        // Over the left rim, over a corner, and larger than the picture is high.
        assert!(!all.holds(boxed([1.2, 0.0], 0.5)) && !all.holds(boxed([8.9, -1.9], 0.5)));
        assert!(!all.holds(boxed([5.0, 0.0], 4.5)));
        let partly = Places::new(&grid([2, 1]), [5, 3]);
        assert!(!partly.holds(boxed([5.0, 0.0], 0.5)) && !partly.holds(boxed([4.0, 0.5], 0.5)));
        assert!(partly.holds(boxed([2.0, 0.0], 0.5)));
        assert!(partly.film([0.5, 0.5]).is_none() && all.film([0.5, 0.5]).is_some());
    }

    #[test]
    fn the_field_moves_with_the_picture() {
        let places = Places::new(&grid([9, 9]), [5, 3]);
        let eye = Eye {
            position: glam::DVec3::ZERO,
            look: -glam::DVec3::Z,
            up: glam::DVec3::Y,
            pupil_diameter_m: 0.0,
            adapts: false,
            limits: eyebox_scene::BinocularLimits::default(),
            focus_distance_m: 1.0,
            fov_deg: 12.0,
            resolution: [40, 20],
            age: 40.0,
        };
        // ±6°: the two columns at 7° and 9° are outside of it.
        assert_eq!(places.cut(eye.half_tangents()), 0.4);
        let bounds = places.bounds().unwrap();
        let wide = looking_at(&eye, bounds);
        let [half, _] = wide.half_tangents();
        // One of 20 pixels to each side is to spare.
        assert!((half * 19.0 / 20.0 - 9f64.to_radians().tan()).abs() < 1e-12, "{half}");
        assert_eq!(places.cut(wide.half_tangents()), 0.0);
        assert!((looking_at(&eye, [DVec2::ZERO; 2]).fov_deg - 12.0).abs() < 1e-12);
    }
}
