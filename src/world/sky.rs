//! The sky: a lat-long panorama at infinity, each pixel a patch of uniform luminance.

pub mod footprint;

use super::cdf::{Cdf, within};
use eyebox_base::error::Result;
use eyebox_base::ids::GroupId;
use eyebox_base::{Error, Where};
use eyebox_scene::Sky;
use glam::{DMat3, DVec3};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// Pixels whose sum is stored together: a sample scans one such block, and the sums stay small beside the picture.
const BLOCK: usize = 64;

/// The sky as a light: luminance by direction, and directions sampled in proportion to it.
///
/// Pixel (x, y) covers the longitudes from π − 2πx/W down to π − 2π(x+1)/W and the polar angles from πy/H to π(y+1)/H;
/// the direction is (sin lon · cos lat, sin lat, cos lon · cos lat), as in OpenEXR's latitude-longitude maps.
#[derive(Debug, Clone)]
pub struct SkyLight {
    pub group: GroupId,
    width: usize,
    height: usize,
    luminance: Arc<Vec<f32>>,
    rgb: Option<Arc<Vec<[f32; 3]>>>,
    to_world: DMat3,
    /// Rows by luminance × solid angle; none if the sky is black.
    rows: Option<Cdf>,
    /// Sums of luminance over each row's blocks, cumulated along the row.
    blocks: Vec<f64>,
}

impl SkyLight {
    /// Errors: a picture without pixels or of another size than stated; luminance that is negative or not finite.
    pub fn build(sky: &Sky) -> Result<SkyLight> {
        let at = || Where::File(sky.file.clone().into());
        let (width, height) = (sky.width, sky.height);
        if width == 0 || width.checked_mul(height) != Some(sky.luminance.len()) || height == 0 {
            let what = format!("the panorama has {} values for {width} × {height} pixels", sky.luminance.len());
            return Err(Error::new(at(), what).expected("one value per pixel"));
        }
        if let Some(index) = sky.luminance.iter().position(|l| !(*l >= 0.0 && l.is_finite())) {
            let (x, y) = (index % width, index / width);
            let what = format!("the panorama's luminance is {} at pixel ({x}, {y})", sky.luminance[index]);
            return Err(Error::new(at(), what).expected("0 or more, and finite"));
        }
        let rotation = sky.to_world * sky.to_world.transpose();
        let orthonormal = (rotation - DMat3::IDENTITY).to_cols_array().iter().all(|x| x.abs() < 1e-6);
        if !orthonormal || sky.to_world.determinant() < 0.0 {
            return Err(Error::new(at(), "the panorama's orientation is not a rotation").expected("a rotation"));
        }
        if let Some(rgb) = &sky.rgb {
            let sound = |rgb: &[f32; 3]| rgb.iter().all(|c| *c >= 0.0 && c.is_finite());
            if rgb.len() != sky.luminance.len() || !rgb.iter().all(sound) {
                return Err(Error::new(at(), "the panorama's colours do not go with its luminance")
                    .expected("three values of 0 or more per pixel"));
            }
        }
        let mut blocks = Vec::new();
        let mut weights = Vec::with_capacity(height);
        for (y, row) in sky.luminance.chunks_exact(width).enumerate() {
            let mut sum = 0.0;
            for block in row.chunks(BLOCK) {
                sum += block_sum(block);
                blocks.push(sum);
            }
            let (top, bottom) = row_cosines(y, height);
            weights.push(sum * (top - bottom) * TAU / width as f64);
        }
        let (luminance, to_world) = (sky.luminance.clone(), sky.to_world);
        let rgb = sky.rgb.clone();
        Ok(SkyLight { group: sky.group, width, height, luminance, rgb, to_world, rows: Cdf::new(weights), blocks })
    }

    /// ∫ L dω over the sphere, cd/m²·sr.
    pub fn integral(&self) -> f64 {
        self.rows.as_ref().map_or(0.0, Cdf::total)
    }

    /// The pixel seen in a world direction; none in no direction (NaN).
    pub fn pixel(&self, dir: DVec3) -> Option<usize> {
        let local = self.to_world.transpose() * dir;
        if local.is_nan() {
            return None;
        }
        // A sky that is alike all round, or everywhere, asks for no angles that tell nothing.
        let part = |share: f64, count: usize| ((share * count as f64) as usize).min(count - 1);
        let y = if self.height == 1 { 0 } else { part(down(local), self.height) };
        let x = if self.width == 1 { 0 } else { part(along(local), self.width) };
        Some(y * self.width + x)
    }

    /// Luminance of a pixel, cd/m².
    pub fn luminance_of(&self, pixel: usize) -> f64 {
        self.luminance.get(pixel).map_or(0.0, |l| f64::from(*l))
    }

    /// Linear Rec.709 of a pixel, cd/m².
    pub fn rgb_of(&self, pixel: usize) -> [f64; 3] {
        match &self.rgb {
            Some(rgb) => rgb.get(pixel).map_or([0.0; 3], |rgb| rgb.map(f64::from)),
            None => [self.luminance_of(pixel); 3],
        }
    }

    /// Luminance seen in a world direction, cd/m².
    pub fn luminance(&self, dir: DVec3) -> f64 {
        self.pixel(dir).map_or(0.0, |pixel| self.luminance_of(pixel))
    }

    /// Whether any of it is coloured.
    pub fn is_coloured(&self) -> bool {
        self.rgb.is_some()
    }

    /// Density of [`SkyLight::sample`] in a world direction, 1/sr: luminance over its integral.
    pub fn pdf(&self, dir: DVec3) -> f64 {
        self.rows.as_ref().map_or(0.0, |rows| self.luminance(dir) / rows.total())
    }

    /// A world direction towards the sky with density ∝ luminance, and that density in 1/sr, which is 0 only if
    /// the sky is black.
    pub fn sample(&self, [a, b]: [f64; 2]) -> (DVec3, f64) {
        let Some(rows) = &self.rows else { return (self.to_world.y_axis, 0.0) };
        let (y, down) = rows.sample(a);
        let (x, right) = self.sample_row(y, b);
        let luminance = f64::from(self.luminance[y * self.width + x]);
        let (top, bottom) = row_cosines(y, self.height);
        let cos = top + (bottom - top) * down;
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let longitude = PI - TAU * (x as f64 + right) / self.width as f64;
        let local = DVec3::new(sin * longitude.sin(), cos, sin * longitude.cos());
        (self.to_world * local, luminance / rows.total())
    }

    /// A column of a row that is not black, and the position within it.
    fn sample_row(&self, y: usize, u: f64) -> (usize, f64) {
        let per_row = self.width.div_ceil(BLOCK);
        let sums = &self.blocks[y * per_row..(y + 1) * per_row];
        let target = u * sums[per_row - 1];
        // The last block that has any light, should rounding lead beyond it.
        let last = sums.partition_point(|&sum| sum < sums[per_row - 1]);
        let block = sums.partition_point(|&sum| sum <= target).min(last);
        let mut rest = target - if block == 0 { 0.0 } else { sums[block - 1] };
        let start = block * BLOCK;
        let row = &self.luminance[y * self.width..(y + 1) * self.width];
        let mut chosen = (start, 0.0);
        for (offset, &l) in row[start..].iter().take(BLOCK).enumerate() {
            let l = f64::from(l);
            if l > 0.0 {
                chosen = (start + offset, within(rest, l));
                if rest < l {
                    break;
                }
                rest -= l;
            }
        }
        chosen
    }
}

/// Share of the picture's height at which a direction in its axes is.
fn down(local: DVec3) -> f64 {
    local.x.hypot(local.z).atan2(local.y) / PI
}

/// Share of its width.
fn along(local: DVec3) -> f64 {
    0.5 - local.x.atan2(local.z) / TAU
}

fn block_sum(block: &[f32]) -> f64 {
    block.iter().map(|&l| f64::from(l)).sum()
}

/// Cosines of the polar angles at the top and the bottom edge of a row.
fn row_cosines(y: usize, height: usize) -> (f64, f64) {
    let edge = |y: usize| (PI * y as f64 / height as f64).cos();
    (edge(y), edge(y + 1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyebox_base::rng::{Rng, Stream};
    use eyebox_base::stats::Moments;
    use eyebox_base::warp;
    use glam::DQuat;

    fn sky(width: usize, height: usize, to_world: DMat3, luminance: impl Fn(usize, usize) -> f32) -> SkyLight {
        let pixels = (0..width * height).map(|i| luminance(i % width, i / width)).collect();
        let luminance = Arc::new(pixels);
        SkyLight::build(&Sky {
            group: GroupId(0),
            width,
            height,
            luminance,
            rgb: None,
            to_world,
            file: "sky.exr".into(),
        })
        .unwrap()
    }

    /// One pixel, or one per row or column, is met from wherever it reaches.
    #[test]
    fn skies_that_are_alike_all_round() {
        let turned = DMat3::from_quat(DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.0));
        let [one, rows, columns] =
            [(1, 1), (1, 8), (8, 1)].map(|(w, h)| sky(w, h, turned, |x, y| (1 + x + 10 * y) as f32));
        for i in 0..200 {
            let local = warp::sphere([(f64::from(i) + 0.5) / 200.0, (f64::from(i) * 0.618_034).fract()]);
            let dir = turned * local;
            assert_eq!(one.luminance(dir), 1.0);
            let row = (local.y.acos() / PI * 8.0).floor();
            assert_eq!(rows.luminance(dir), 1.0 + 10.0 * row, "{local}");
            let column = ((0.5 - local.x.atan2(local.z) / TAU) * 8.0).floor();
            assert_eq!(columns.luminance(dir), 1.0 + column, "{local}");
        }
        for none in [&one, &rows, &columns] {
            assert_eq!(none.luminance(DVec3::NAN), 0.0);
        }
    }

    #[test]
    fn centre_is_plus_z_and_plus_x_is_left_of_it() {
        let sky = sky(200, 100, DMat3::IDENTITY, |x, y| (y * 200 + x) as f32);
        let at = |dir: DVec3| (sky.luminance(dir) as usize % 200, sky.luminance(dir) as usize / 200);
        assert_eq!(at(DVec3::new(1e-6, 1e-6, 1.0)), (99, 49));
        assert_eq!(at(DVec3::new(-1e-6, -1e-6, 1.0)), (100, 50));
        assert_eq!(at(DVec3::new(1.0, 1e-6, 1e-6)), (50, 49));
        assert_eq!(at(DVec3::new(-1.0, 1e-6, 1e-6)), (149, 49));
        assert_eq!(at(DVec3::Y).1, 0);
        assert_eq!(at(DVec3::NEG_Y).1, 99);
        // The seam: behind, to the +x side, is the left edge.
        assert_eq!(at(DVec3::new(1e-6, 1e-6, -1.0)).0, 0);
        assert_eq!(at(DVec3::new(-1e-6, 1e-6, -1.0)).0, 199);
        assert_eq!(sky.luminance(DVec3::NAN), 0.0);
    }

    #[test]
    fn rotation_turns_the_picture_with_it() {
        let to_world = DMat3::from_rotation_x(-std::f64::consts::FRAC_PI_2); // +z → +y, +y → −z
        let sky = sky(64, 32, to_world, |x, y| if (28..36).contains(&x) && (14..18).contains(&y) { 5.0 } else { 0.0 });
        assert_eq!((sky.luminance(DVec3::Y), sky.luminance(DVec3::Z)), (5.0, 0.0));
        let (dir, pdf) = sky.sample([0.3, 0.8]);
        assert!(dir.y > 0.9 && (pdf / sky.pdf(dir) - 1.0).abs() < 1e-12);
    }

    /// A picture wider than a block with black rows, black pixels and a sun.
    fn varied(to_world: DMat3) -> SkyLight {
        sky(150, 12, to_world, |x, y| match (x, y) {
            (_, 0 | 7) => 0.0,
            (101, 3) => 500.0,
            (140.., _) => 0.0,
            (x, y) if x % 3 == 0 => (1 + x % 7 + y) as f32,
            _ => 0.25,
        })
    }

    #[test]
    fn integral_by_sampling_the_sphere() {
        let sky = varied(DMat3::from_quat(DQuat::from_rotation_y(0.7) * DQuat::from_rotation_z(0.4)));
        let (mut rng, mut mean, mut density) =
            (Rng::new(5, Stream::Check, 0, 0), Moments::default(), Moments::default());
        for _ in 0..400_000 {
            let dir = warp::sphere(rng.pair());
            mean.add(sky.luminance(dir) * 4.0 * PI);
            density.add(sky.pdf(dir) * 4.0 * PI);
        }
        assert!((mean.mean - sky.integral()).abs() < 4.0 * mean.stderr(), "{} {}", mean.mean, sky.integral());
        assert!((density.mean - 1.0).abs() < 4.0 * density.stderr());
        let uniform = self::sky(150, 75, DMat3::IDENTITY, |_, _| 3.0);
        assert!((uniform.integral() / (12.0 * PI) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn samples_follow_luminance_and_fill_their_pixels_evenly() {
        let to_world = DMat3::from_quat(DQuat::from_rotation_y(0.7) * DQuat::from_rotation_z(0.4));
        let sky = varied(to_world);
        let (mut rng, count) = (Rng::new(6, Stream::Check, 0, 0), 1_000_000);
        let mut seen = vec![0.0; 150 * 12];
        let mut inside = [Moments::default(); 2];
        for _ in 0..count {
            let (dir, pdf) = sky.sample(rng.pair());
            assert!(pdf > 0.0);
            let index = sky.pixel(dir).unwrap();
            if (sky.pdf(dir) / pdf - 1.0).abs() < 1e-9 {
                seen[index] += 1.0;
            } else {
                panic!("density {pdf} is not {} at {dir}", sky.pdf(dir));
            }
            let local = to_world.transpose() * dir;
            let (top, bottom) = row_cosines(index / 150, 12);
            inside[0].add((top - local.y) / (top - bottom));
            inside[1].add(((0.5 - local.x.atan2(local.z) / TAU) * 150.0).fract());
        }
        let (mut chi2, mut cells) = (0.0, 0.0);
        for (index, n) in seen.iter().enumerate() {
            let (top, bottom) = row_cosines(index / 150, 12);
            let share = f64::from(sky.luminance[index]) * (top - bottom) * TAU / 150.0 / sky.integral();
            let want = share * count as f64;
            if want == 0.0 {
                assert_eq!(*n, 0.0);
            } else {
                chi2 += (n - want) * (n - want) / want;
                cells += 1.0;
            }
        }
        let k: f64 = cells - 1.0;
        let z = ((chi2 / k).cbrt() - (1.0 - 2.0 / (9.0 * k))) / (2.0 / (9.0 * k)).sqrt();
        assert!(z.abs() < 4.0, "chi² {chi2} of {k}: z {z}");
        for moments in inside {
            assert!((moments.mean - 0.5).abs() < 4.0 * moments.stderr(), "{}", moments.mean);
        }
    }

    #[test]
    fn black_and_broken_skies() {
        let black = sky(4, 2, DMat3::IDENTITY, |_, _| 0.0);
        assert_eq!((black.sample([0.5; 2]).1, black.pdf(DVec3::Z), black.integral()), (0.0, 0.0, 0.0));
        let raw = |width, height, pixels: Vec<f32>, to_world| {
            let luminance = Arc::new(pixels);
            SkyLight::build(&Sky {
                group: GroupId(0),
                width,
                height,
                luminance,
                rgb: None,
                to_world,
                file: "sky.exr".into(),
            })
            .unwrap_err()
            .to_string()
        };
        assert!(raw(2, 1, vec![1.0, -1.0], DMat3::IDENTITY).starts_with("sky.exr: the panorama's luminance is -1 at"));
        assert!(raw(2, 1, vec![f32::INFINITY, 1.0], DMat3::IDENTITY).contains("pixel (0, 0)"));
        assert!(raw(2, 2, vec![1.0; 3], DMat3::IDENTITY).contains("3 values for 2 × 2"));
        assert!(raw(0, usize::MAX, vec![], DMat3::IDENTITY).contains("0 values"));
        assert!(raw(1, 1, vec![1.0], DMat3::from_diagonal(DVec3::splat(2.0))).contains("not a rotation"));
        assert!(raw(1, 1, vec![1.0], DMat3::from_diagonal(-DVec3::ONE)).contains("not a rotation"));
        assert!(raw(1, 1, vec![1.0], DMat3::from_cols_array(&[f64::NAN; 9])).contains("not a rotation"));
    }
}
