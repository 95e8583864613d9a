//! The patches of which luminances are means: of exactly the piece of the eye's film that they say, wherever it lies on the pixels.

use super::tuning::patch::{FEWEST_PIXELS, MOST_OF_SIDE, MOST_PIXELS, SIDE_DEG};
use eyebox_film::crop::Crop;
use eyebox_scene::Eye;
use glam::DVec2;

/// Patches of one rendering: squares of the eye's film.
pub struct Patches {
    /// Looks as wide as it takes for a patch to be whole pixels wide, in pixels of which the picture fills as many as were asked for.
    pub eye: Eye,
    /// What is rendered of that: the picture's part.
    pub crop: Crop,
    pub pixels: usize,
}

impl Patches {
    /// Of half a degree, where the picture has room for it. `eye` looks over what is seen, between two corners of its film; `blur`: radius of
    /// the spot that the pupil makes of a point, tangents.
    pub fn over(eye: &Eye, [low, high]: [DVec2; 2], blur: f64) -> Patches {
        let eye = fine(eye, high - low);
        let pixel = pixel(&eye);
        let room = MOST_OF_SIDE * (high - low).min_element() - 2.0 * blur;
        // Half a degree in whole pixels that are no smaller than those of the eye. Pixels on the rim of a patch are read whole.
        let wanted = (2.0 * (0.5 * SIDE_DEG).to_radians().tan()).max(FEWEST_PIXELS * pixel);
        let count = (wanted / pixel * (1.0 + 1e-9)).floor();
        let (pixels, side) = if wanted * (1.0 + 2.0 / count) <= room {
            (count, wanted)
        } else {
            let most = (room / pixel - 2.0).floor().max(1.0).min(count);
            (most, most * pixel)
        };
        let half = 0.5 * side / pixels * eye.resolution[0] as f64;
        let fov_deg = 2.0 * half.atan().to_degrees();
        let eye = if fov_deg > 0.0 && fov_deg < 180.0 { Eye { fov_deg, ..eye } } else { eye };
        Patches { crop: part(&eye, [low, high]), eye, pixels: pixels as usize }
    }

    /// Side of a patch straight ahead, degrees.
    pub fn side_deg(&self) -> f64 {
        2.0 * (0.5 * self.pixels as f64 * pixel(&self.eye)).atan().to_degrees()
    }
}

/// Side of a pixel, tangents.
fn pixel(eye: &Eye) -> f64 {
    2.0 * eye.half_tangents()[0] / eye.resolution[0].max(1) as f64
}

/// The same eye with more pixels, where a box of this size, tangents, fills a part of its film only: as many over the box as it has now.
fn fine(eye: &Eye, size: DVec2) -> Eye {
    let [width, height] = eye.resolution.map(|n| n as f64);
    let spare = |n: f64| if n > 2.0 { n - 2.0 } else { n };
    let times = pixel(eye) * (spare(width) / size.x).min(spare(height) / size.y);
    let most = MOST_PIXELS as f64 / width.max(height);
    // A box without an extent says nothing.
    let times = if times.is_finite() { times.min(most).max(1.0) } else { 1.0 };
    let columns = (width * times).floor();
    let rows = (height * columns / width).ceil();
    Eye { resolution: [columns as usize, rows as usize], ..eye.clone() }
}

/// The pixels of an eye about a box of its film, one more on each side.
fn part(eye: &Eye, [low, high]: [DVec2; 2]) -> Crop {
    let [width, height] = eye.resolution;
    let middle = 0.5 * DVec2::new(width as f64, height as f64);
    let (left, right) = (middle.x + low.x / pixel(eye), middle.x + high.x / pixel(eye));
    let (top, bottom) = (middle.y - high.y / pixel(eye), middle.y - low.y / pixel(eye));
    let along = |from: f64, to: f64, count: usize| {
        // What is beyond the film is cut off.
        let first = ((from.floor() - 1.0).max(0.0) as usize).min(count.saturating_sub(1));
        let end = ((to.ceil() + 1.0).max(0.0) as usize).clamp(first + 1, count.max(first + 1));
        (first, end - first)
    };
    let ((x, wide), (y, high)) = (along(left, right, width), along(top, bottom, height));
    Crop { corner: [x, y], size: [wide, high] }
}

/// The pixels of a square of so many pixels' width about a place (from the upper left corner of the frame), each with its share of it: a mean
/// over whole pixels beside it would be of another place. None that the frame cuts.
///
/// As a pixel that it holds in part on one side has its other part on the other side, even a slope is read as it is in the square.
pub fn weights(place: DVec2, side: usize, size: [usize; 2]) -> Option<Vec<(usize, f64)>> {
    let along = |at: f64, size: usize| {
        let low = at - 0.5 * side as f64;
        let first = low.floor();
        if !(first >= 0.0 && low + side as f64 <= size as f64) {
            return None;
        }
        let past = low - first;
        let all = (0..=side).map(move |k| {
            let held = if k == 0 {
                1.0 - past
            } else if k == side {
                past
            } else {
                1.0
            };
            (first as usize + k, held / side as f64)
        });
        Some(all.filter(|(_, held)| *held > 0.0).collect::<Vec<_>>())
    };
    let (columns, rows) = (along(place.x, size[0])?, along(place.y, size[1])?);
    let cell = |(y, down): &(usize, f64)| {
        let (y, down) = (*y, *down);
        columns.iter().map(move |(x, across)| (y * size[0] + x, across * down)).collect::<Vec<_>>()
    };
    Some(rows.iter().flat_map(cell).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_patch_is_whole_or_not_at_all() {
        let at = |x: f64, y: f64, side: usize| weights(DVec2::new(x, y), side, [8, 6]);
        assert_eq!(at(3.5, 5.5, 1), Some(vec![(5 * 8 + 3, 1.0)]));
        assert_eq!(at(6.5, 4.5, 3).map(|all| all.len()), Some(9));
        assert_eq!((at(6.6, 4.5, 3), at(0.5, 3.0, 3), at(4.0, 5.5, 3), at(f64::NAN, 3.0, 1)), (None, None, None, None));
    }

    /// Of a slope the value in its middle, whatever the place: of 1 + 0.3 x − 0.2 y.
    #[test]
    fn a_slope_is_read_where_the_patch_is() {
        for (x, y, side) in [(3.5, 2.5, 3), (3.21, 2.77, 2), (4.9, 3.0, 1), (3.999, 2.001, 4)] {
            let all = weights(DVec2::new(x, y), side, [8, 6]).unwrap();
            let sum: f64 = all.iter().map(|(_, share)| share).sum();
            let middle = |index: usize| ((index % 8) as f64 + 0.5, (index / 8) as f64 + 0.5);
            let value = |(index, share): &(usize, f64)| {
                let (x, y) = middle(*index);
                share * (1.0 + 0.3 * x - 0.2 * y)
            };
            let mean: f64 = all.iter().map(value).sum();
            assert!((sum - 1.0).abs() < 1e-14 && (mean - (1.0 + 0.3 * x - 0.2 * y)).abs() < 1e-14, "{x} {y}: {mean}");
        }
    }

    #[test]
    fn patches_are_half_a_degree_or_say_what_they_are() {
        let eye = |fov_deg: f64| Eye {
            position: glam::DVec3::ZERO,
            look: -glam::DVec3::Z,
            up: glam::DVec3::Y,
            pupil_diameter_m: 0.0,
            adapts: false,
            limits: eyebox_scene::BinocularLimits::default(),
            focus_distance_m: 1.0,
            fov_deg,
            resolution: [120, 80],
            age: 40.0,
        };
        let over = |fov_deg: f64, sides: [f64; 2]| {
            let half = DVec2::from_array(sides.map(|side| (0.5 * side).to_radians().tan()));
            Patches::over(&eye(fov_deg), [-half, half], 0.0)
        };
        // 12° on 120 pixels: nearly five of them, and as four of them the view is a quarter wider.
        let usual = over(12.0, [11.8, 7.8]);
        assert!((usual.side_deg() - 0.5).abs() < 1e-12 && usual.pixels == 4, "{} {}", usual.side_deg(), usual.pixels);
        assert!(usual.eye.fov_deg >= 12.0 && usual.eye.fov_deg < 15.0);
        // Three pixels of 50°; less than a third of a picture of 0.6°, less a pixel on each side.
        let wide = over(50.0, [49.2, 32.8]);
        assert!(wide.pixels == 3 && (wide.eye.fov_deg - 50.0).abs() < 1e-9, "{} {}", wide.pixels, wide.eye.fov_deg);
        let small = over(1.0, [0.98, 0.6]);
        assert!(small.pixels == 20 && (small.side_deg() - 20.0 / 120.0).abs() < 1e-5, "{}", small.side_deg());
        // A picture aside has pixels as fine as one straight ahead, and no more of them are rendered.
        let [low, high] = [DVec2::new(0.11, -0.02), DVec2::new(0.17, 0.02)];
        let aside = Patches::over(&eye(20.0), [low, high], 0.0);
        let [width, height] = aside.crop.size;
        assert!(pixel(&aside.eye) < 1.1 * 0.06 / 118.0 && width <= 123 && height <= 84, "{width} × {height}");
        assert!(width > 100 && aside.crop.fits(aside.eye.resolution), "{:?}", aside.crop);
    }
}
