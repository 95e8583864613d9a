//! The sky's picture over all of a small area at once: where what a square sees of it is a parallelogram in the picture, the picture's
//! pixels are cut out of that exactly, so that no border between them is left to chance.

use super::{SkyLight, along, down};
use crate::slide::footprint::{Lines, SLIVER, moments, square};
use glam::{DVec2, DVec3};

/// Where in the picture the points of the square from −½ to ½ are seen: `at` + x·by\[0\] + y·by\[1\], in columns and rows from its
/// upper left corner. Columns go on beyond the picture's sides, round and round.
#[derive(Debug, Clone, Copy)]
pub struct Footprint {
    pub at: DVec2,
    pub by: [DVec2; 2],
}

impl Footprint {
    /// The least and the largest column and row, with so much more to each side.
    pub fn extent(&self, more: DVec2) -> [DVec2; 2] {
        let reach = 0.5 * (self.by[0].abs() + self.by[1].abs()) + more;
        [self.at - reach, self.at + reach]
    }
}

impl SkyLight {
    /// Where in the picture a world direction is, in columns and rows.
    pub fn place(&self, dir: DVec3) -> DVec2 {
        let local = self.to_world.transpose() * dir;
        DVec2::new(along(local) * self.width as f64, down(local) * self.height as f64)
    }

    /// The same place as near to another as it is by going round.
    pub fn near(&self, place: DVec2, other: DVec2) -> DVec2 {
        let width = self.width as f64;
        DVec2::new(place.x + ((other.x - place.x) / width).round() * width, place.y)
    }

    /// The pixel of a place.
    pub fn pixel_at(&self, place: DVec2) -> usize {
        let width = self.width as f64;
        let column = (place.x - (place.x / width).floor() * width) as usize;
        (place.y.max(0.0) as usize).min(self.height - 1) * self.width + column.min(self.width - 1)
    }

    /// Whether all of the picture is alike.
    pub fn is_plain(&self) -> bool {
        let [width, height] = [self.width, self.height].map(|side| side as f64);
        self.is_alike([DVec2::ZERO, DVec2::new(width, height)])
    }

    /// Whether its pixels between these places are all alike. Not of what reaches over a pole.
    pub fn is_alike(&self, [low, high]: [DVec2; 2]) -> bool {
        let Some(([top, bottom], [left, columns])) = self.between([low, high]) else { return false };
        let first = top * self.width + left;
        let alike = |pixel: usize| {
            self.luminance[pixel] == self.luminance[first]
                && self.rgb.as_ref().is_none_or(|rgb| rgb[pixel] == rgb[first])
        };
        (top..=bottom).all(|row| (left..left + columns).all(|column| alike(row * self.width + column % self.width)))
    }

    /// Number of pixels between these places; none if they reach over a pole, or are not finite.
    pub fn count(&self, between: [DVec2; 2]) -> Option<usize> {
        self.between(between).map(|([top, bottom], [_, columns])| (bottom - top + 1).saturating_mul(columns))
    }

    /// First and last row, first column and number of columns.
    fn between(&self, [low, high]: [DVec2; 2]) -> Option<([usize; 2], [usize; 2])> {
        let inside = low.y >= 0.0 && high.y <= self.height as f64 && low.x.is_finite() && high.x.is_finite();
        if !inside {
            return None;
        }
        let [top, bottom] = [low.y, high.y].map(|y| (y as usize).min(self.height - 1));
        let columns = (high.x.floor() - low.x.floor() + 1.0).min(self.width as f64);
        Some(([top, bottom], [self.pixel_at(low) % self.width, columns as usize]))
    }

    /// Calls `each` with the pixels that the square sees, the area that each has of the square and the integral of the place in the
    /// square over that.
    pub fn pieces(&self, footprint: &Footprint, mut each: impl FnMut(usize, f64, DVec2)) {
        let [right, down] = footprint.by;
        let columns = Lines { first: footprint.at.x, by: DVec2::new(right.x, down.x) };
        let rows = Lines { first: footprint.at.y, by: DVec2::new(right.y, down.y) };
        let square = square();
        let [mut row, last] = rows.span(&square).map(f64::floor);
        while row <= last {
            let strip = rows.cut(&square, row, row + 1.0);
            let [mut column, last] = columns.span(&strip).map(f64::floor);
            while column <= last {
                let (area, moment) = moments(&columns.cut(&strip, column, column + 1.0));
                // What rounding leaves along a border is nothing.
                if area >= SLIVER {
                    each(self.pixel_at(DVec2::new(column + 0.5, row + 0.5)), area, moment);
                }
                column += 1.0;
            }
            row += 1.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyebox_base::ids::GroupId;
    use eyebox_scene::Sky;
    use glam::{DMat3, DQuat};
    use std::sync::Arc;

    fn sky(width: usize, height: usize) -> SkyLight {
        let luminance = (0..width * height).map(|k| ((k * 37 + 11) % 101) as f32).collect();
        let to_world = DMat3::from_quat(DQuat::from_rotation_y(0.7) * DQuat::from_rotation_z(0.4));
        let (group, luminance) = (GroupId(0), Arc::new(luminance));
        SkyLight::build(&Sky { group, width, height, luminance, rgb: None, to_world, file: "sky.exr".into() }).unwrap()
    }

    #[test]
    fn places_are_in_the_pixels_that_directions_see() {
        let sky = sky(40, 20);
        for k in 0..2000 {
            let dir = eyebox_base::warp::sphere([(f64::from(k) + 0.5) / 2000.0, (f64::from(k) * 0.618_034).fract()]);
            let place = sky.place(dir);
            assert_eq!(Some(sky.pixel_at(place)), sky.pixel(dir), "{dir}");
            // Round and round.
            let far = place + DVec2::new(40.0 * f64::from(k % 7 - 3), 0.0);
            assert!((sky.near(place, far) - far).length() < 1e-9);
            assert_eq!(sky.pixel_at(far), sky.pixel_at(place));
        }
    }

    /// Areas and moments by many points of the square, across the seam as well.
    #[test]
    fn pieces_are_what_points_of_the_square_see() {
        let sky = sky(40, 20);
        for (at, by) in [
            ((12.3, 9.8), [(1.7, 0.4), (-0.3, 2.1)]),
            ((39.8, 4.1), [(0.2, 0.6), (0.9, -0.1)]),
            ((-0.2, 15.0), [(-3.0, 0.5), (0.2, -4.0)]),
            ((7.5, 7.5), [(0.2, 0.0), (0.0, 0.2)]),
        ] {
            let vec = |(x, y): (f64, f64)| DVec2::new(x, y);
            let footprint = Footprint { at: vec(at), by: by.map(vec) };
            let side = 1000;
            let mut want = vec![(0.0, DVec2::ZERO); 800];
            for k in 0..side * side {
                let point = DVec2::new(f64::from(k % side) + 0.5, f64::from(k / side) + 0.5) / f64::from(side) - 0.5;
                let own = &mut want[sky.pixel_at(footprint.at + footprint.by[0] * point.x + footprint.by[1] * point.y)];
                own.0 += f64::from(side * side).recip();
                own.1 += point / f64::from(side * side);
            }
            let mut count = 0;
            sky.pieces(&footprint, |pixel, area, moment| {
                want[pixel].0 -= area;
                want[pixel].1 -= moment;
                count += 1;
            });
            assert!(want.iter().all(|(area, moment)| area.abs() < 2e-3 && moment.length() < 2e-3), "{footprint:?}");
            let extent = footprint.extent(DVec2::ZERO);
            assert!(sky.count(extent).unwrap() >= count);
            assert_eq!(sky.is_alike(extent), count == 1);
        }
        // Over a pole nothing is said.
        let over = Footprint { at: DVec2::new(3.0, 0.1), by: [DVec2::X, DVec2::Y] };
        assert!(sky.count(over.extent(DVec2::ZERO)).is_none() && !sky.is_alike(over.extent(DVec2::ZERO)));
        assert!(!sky.is_plain() && self::sky(1, 1).is_plain());
    }
}
