//! Places of the picture where lamps are seen, as a plan keeps them: paths from the eye look closer there.

use glam::{DMat2, DVec2};
use std::f64::consts::PI;

/// A parallelogram about the image of a lamp, or of a part of it, for each place of the pupil, in tangents.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Glint {
    /// For the middle of the pupil.
    pub middle: [f64; 2],
    /// From the middle to two neighbouring sides.
    pub axes: [[f64; 2]; 2],
    /// How the middle moves with the place in the pupil, per radius to the right and up. A pinhole has none.
    #[serde(default, skip_serializing_if = "is_still")]
    pub by_pupil: [[f64; 2]; 2],
}

fn is_still(by_pupil: &[[f64; 2]; 2]) -> bool {
    *by_pupil == [[0.0; 2]; 2]
}

/// How a path that is to meet the image is drawn for a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Way {
    /// A place of the pupil, and then one of the image as it is seen from there: it may lie in another pixel.
    PupilFirst,
    /// A place of the pixel, and then one of the pupil from which the image is there: it may lie beside the pupil.
    PixelFirst,
}

impl Glint {
    /// Half its width and height, from wherever in the pupil it is seen.
    pub fn half(&self) -> [f64; 2] {
        let [a, b] = self.by_pupil;
        [0, 1].map(|k| self.axes[0][k].abs() + self.axes[1][k].abs() + a[k].hypot(b[k]))
    }

    /// Its middle from a place of the pupil, in radii.
    pub fn middle_from(&self, pupil: DVec2) -> DVec2 {
        DVec2::from_array(self.middle) + self.moves() * pupil
    }

    fn moves(&self) -> DMat2 {
        DMat2::from_cols_array_2d(&self.by_pupil)
    }

    /// Where a place is, from −1 to 1 along both axes for those that it holds.
    fn coordinates(&self, film: DVec2, pupil: DVec2) -> DVec2 {
        DMat2::from_cols_array_2d(&self.axes).inverse() * (film - self.middle_from(pupil))
    }

    /// How far from the middle to the nearest side a place lies: 1 there.
    pub fn reach_of(&self, film: DVec2, pupil: DVec2) -> f64 {
        self.coordinates(film, pupil).abs().max_element()
    }

    /// Whether the image is about a place of the picture, seen from one of the pupil, in radii.
    pub fn holds(&self, film: DVec2, pupil: DVec2) -> bool {
        self.reach_of(film, pupil) <= 1.0
    }

    /// In tangents squared.
    pub fn area(&self) -> f64 {
        4.0 * DMat2::from_cols_array_2d(&self.axes).determinant().abs()
    }

    /// Area, in tangents squared, over which its middle moves with the pupil.
    fn blur(&self) -> f64 {
        PI * self.moves().determinant().abs()
    }

    /// What may be in a file: finite, and of some area.
    pub fn is_valid(&self) -> bool {
        let all = [self.middle, self.axes[0], self.axes[1], self.by_pupil[0], self.by_pupil[1]];
        let inverse = DMat2::from_cols_array_2d(&self.axes).inverse();
        all.as_flattened().iter().all(|x| x.is_finite()) && inverse.is_finite() && self.area() > 0.0
    }

    fn way(&self, cell: f64) -> Way {
        if self.blur() > cell { Way::PixelFirst } else { Way::PupilFirst }
    }

    /// A path for a pixel of `cell` tangents squared: `in_pixel` and `in_pupil` (radii) are even over both, `u` over the unit
    /// square. None where it would miss the pupil; it may miss the pixel.
    pub fn draw(&self, cell: f64, (in_pixel, in_pupil): (DVec2, DVec2), u: [f64; 2]) -> Option<(DVec2, DVec2)> {
        let off = DMat2::from_cols_array_2d(&self.axes) * (2.0 * DVec2::from_array(u) - 1.0);
        match self.way(cell) {
            Way::PupilFirst => Some((self.middle_from(in_pupil) + off, in_pupil)),
            Way::PixelFirst => {
                let pupil = self.moves().inverse() * (in_pixel - off - DVec2::from_array(self.middle));
                (pupil.length_squared() <= 1.0).then_some((in_pixel, pupil))
            }
        }
    }

    /// Density of such paths in a pixel, over that of even ones.
    pub fn density(&self, cell: f64, (film, pupil): (DVec2, DVec2)) -> f64 {
        if !self.holds(film, pupil) {
            return 0.0;
        }
        match self.way(cell) {
            Way::PupilFirst => cell / self.area(),
            Way::PixelFirst => self.blur() / self.area(),
        }
    }

    /// Pieces along its longer side that are about `long` tangents long, none of them if it would take more than `most`.
    pub fn pieces(&self, long: f64, most: usize) -> Vec<Glint> {
        let [a, b] = self.axes.map(DVec2::from_array);
        let (along, across) = if a.length() >= b.length() { (a, b) } else { (b, a) };
        let count = (2.0 * along.length() / long).ceil().max(1.0);
        if count.is_nan() || count > most as f64 {
            return Vec::new();
        }
        let piece = |k: f64| {
            let middle = DVec2::from_array(self.middle) + along * ((2.0 * k + 1.0) / count - 1.0);
            Glint { middle: middle.to_array(), axes: [(along / count).to_array(), across.to_array()], ..*self }
        };
        (0..count as usize).map(|k| piece(k as f64)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyebox_base::rng::{Rng, Stream};
    use eyebox_base::warp::disk;

    /// Paths drawn either way are as dense as is said: the share of even paths that a glint holds, found by those about it.
    #[test]
    fn paths_are_as_dense_as_is_said() {
        for (number, by_pupil) in
            [[[0.0; 2]; 2], [[0.05, 0.01], [-0.02, 0.04]], [[0.9, -0.2], [0.3, 0.8]]].into_iter().enumerate()
        {
            let glint = Glint { middle: [0.1, -0.2], axes: [[0.2, 0.05], [-0.04, 0.1]], by_pupil };
            // A pixel from −½ to ½.
            let inside = |film: DVec2| film.abs().max_element() <= 0.5;
            let mut rng = Rng::new(3, Stream::Check, number as u64, 0);
            let (mut even, mut about) = (0.0, 0.0);
            const COUNT: u64 = 200_000;
            for _ in 0..COUNT {
                let pixel = DVec2::from_array(rng.pair()) - 0.5;
                let pupil = disk(rng.pair());
                even += f64::from(u8::from(glint.holds(pixel, pupil)));
                if let Some(drawn) = glint.draw(1.0, (pixel, pupil), rng.pair()).filter(|(film, _)| inside(*film)) {
                    about += 1.0 / glint.density(1.0, drawn);
                }
            }
            let [even, about] = [even, about].map(|sum| sum / COUNT as f64);
            assert!((even / about - 1.0).abs() < 0.02, "{by_pupil:?}: {even} {about}");
        }
    }

    /// Pieces are the whole, once.
    #[test]
    fn pieces_are_the_whole() {
        let glint =
            Glint { middle: [0.1, -0.2], axes: [[0.2, 0.05], [-4.0, 1.0]], by_pupil: [[0.3, 0.1], [0.2, -0.1]] };
        let pieces = glint.pieces(0.5, 64);
        assert_eq!(pieces.len(), 17);
        let area: f64 = pieces.iter().map(Glint::area).sum();
        assert!((area / glint.area() - 1.0).abs() < 1e-12);
        let mut rng = Rng::new(3, Stream::Check, 9, 0);
        for _ in 0..1000 {
            let pupil = disk(rng.pair());
            let (film, _) = glint.draw(1e9, (DVec2::ZERO, pupil), rng.pair()).unwrap();
            assert_eq!(pieces.iter().filter(|piece| piece.holds(film, pupil)).count(), 1);
        }
        assert!(glint.pieces(0.1, 64).is_empty());
    }
}
