//! Skies by formula, as panoramas about +y with the sun at +z: overcast, and clear with a sun.

mod preetham;
mod sunlight;

pub use sunlight::{DISC_DEG, Sunlight};

use super::image::Picture;
use eyebox_base::colour::{XYZ_TO_REC709, Xyz, apply};
use preetham::ClearSky;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Rows of a sky that differs by height alone, half of them above the horizon: one row is 0.18°.
const ROWS: usize = 1024;

/// The overcast sky of Moon and Spencer (CIE S 011/E:2003, 16): L = Lz (1 + 2 sin γ)/3 at the elevation γ. On a horizontal plane
/// it brings 7π/9 Lz, as a uniform sky of luminance `level` does; the grey ground below it is lit by it.
pub fn overcast(level: f64, ground_reflectance: f64) -> Picture {
    let zenith = level * 9.0 / 7.0;
    let luminance = |row: usize| {
        let elevation = FRAC_PI_2 - PI * (row as f64 + 0.5) / ROWS as f64;
        let above = zenith * (1.0 + 2.0 * elevation.sin()) / 3.0;
        if elevation > 0.0 { above } else { ground_reflectance * level }
    };
    Picture::grey(1, ROWS, (0..ROWS).map(|row| luminance(row) as f32).collect())
}

/// A clear sky over grey ground, and its sun.
pub struct ClearDay {
    pub picture: Picture,
    pub sunlight: Sunlight,
    /// What the sky alone brings to a horizontal plane, lx.
    pub sky_lx: f64,
}

/// `elevation`: of the sun, rad, from 0 to π/2. The disc of the sun is not in the picture.
pub fn clear(turbidity: f64, elevation: f64, ground_reflectance: f64) -> ClearDay {
    const WIDTH: usize = 2 * ROWS;
    let sun_zenith = FRAC_PI_2 - elevation;
    let sky = ClearSky::new(turbidity, sun_zenith);
    let sunlight = Sunlight::new(turbidity, sun_zenith);
    let mut rgb = vec![[0f32; 3]; WIDTH * ROWS];
    let mut onto: Xyz = [0.0; 3];
    let (above, below) = rgb.split_at_mut(WIDTH * ROWS / 2);
    for (y, row) in above.chunks_exact_mut(WIDTH).enumerate() {
        let edge = |y: usize| (PI * y as f64 / ROWS as f64).sin().powi(2);
        // ∫ cos θ dω of a pixel.
        let projected = (edge(y + 1) - edge(y)) / 2.0 * TAU / WIDTH as f64;
        let (sin, cos) = (PI * (y as f64 + 0.5) / ROWS as f64).sin_cos();
        // The halves left and right of the sun are mirror images.
        for x in 0..WIDTH / 2 {
            let longitude = PI - TAU * (x as f64 + 0.5) / WIDTH as f64;
            let to_sun = sin * sun_zenith.sin() * longitude.cos() + cos * sun_zenith.cos();
            let xyz = sky.xyz(cos, to_sun.clamp(-1.0, 1.0).acos());
            for (sum, c) in onto.iter_mut().zip(xyz) {
                *sum += 2.0 * projected * c;
            }
            let pixel = apply(&XYZ_TO_REC709, xyz).map(|c| c as f32);
            (row[x], row[WIDTH - 1 - x]) = (pixel, pixel);
        }
    }
    let lit: Xyz = std::array::from_fn(|c| onto[c] + sunlight.xyz[c] * elevation.sin());
    below.fill(apply(&XYZ_TO_REC709, lit.map(|c| ground_reflectance / PI * c)).map(|c| c as f32));
    ClearDay { picture: Picture::coloured(WIDTH, ROWS, rgb), sunlight, sky_lx: onto[1] }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Illuminance of a horizontal plane from above and from below by what the picture has, lx.
    fn illuminances(picture: &Picture) -> [f64; 2] {
        let mut sums = [0.0; 2];
        for (i, pixel) in picture.pixels.iter().enumerate() {
            let y = i / picture.width;
            let edge = |y: usize| (PI * y as f64 / picture.height as f64).sin().powi(2);
            let projected = (edge(y + 1) - edge(y)).abs() / 2.0 * TAU / picture.width as f64;
            sums[usize::from(2 * y >= picture.height)] += projected * f64::from(*pixel);
        }
        sums
    }

    #[test]
    fn overcast_brings_seven_ninths_of_its_zenith() {
        let picture = overcast(1000.0, 0.25);
        let [sky, ground] = illuminances(&picture);
        let zenith = f64::from(picture.pixels[0]);
        assert!((zenith / (9000.0 / 7.0) - 1.0).abs() < 1e-5, "{zenith}");
        assert!((sky / (7.0 * PI / 9.0 * 9000.0 / 7.0) - 1.0).abs() < 1e-5, "{sky}");
        assert!((ground / (250.0 * PI) - 1.0).abs() < 1e-6, "{ground}");
        // Just above the horizon it has a third of that.
        assert!((f64::from(picture.pixels[ROWS / 2 - 1]) / zenith * 3.0 - 1.0).abs() < 0.004);
    }

    #[test]
    fn a_clear_day_lights_its_ground_and_noon_is_a_hundred_thousand_lux() {
        for (elevation, least, most) in [(60.0, 100e3, 112e3), (30.0, 50e3, 65e3), (5.0, 8e3, 20e3)] {
            let elevation = f64::to_radians(elevation);
            for turbidity in [2.0, 3.0, 4.0] {
                let day = clear(turbidity, elevation, 0.2);
                let [sky, ground] = illuminances(&day.picture);
                assert!((sky / day.sky_lx - 1.0).abs() < 1e-4, "{sky} {}", day.sky_lx);
                let all = sky + day.sunlight.illuminance_lx() * elevation.sin();
                assert!((ground / (0.2 * all) - 1.0).abs() < 1e-4, "{ground} {all}");
                // IES RP-21: 127.5 klx exp(−0.21 m) sin h + 0.8 klx + 15.5 klx √sin h is 102 klx at 60°, 54 klx at 30°.
                assert!((least..most).contains(&all), "T {turbidity}, {elevation}: {all} lx");
            }
        }
    }

    #[test]
    fn the_brightest_is_at_the_sun_and_left_is_as_right() {
        let day = clear(3.0, 40f64.to_radians(), 0.2);
        let (width, pixels) = (day.picture.width, &day.picture.pixels);
        let brightest = (0..pixels.len()).max_by(|a, b| pixels[*a].total_cmp(&pixels[*b])).unwrap_or(0);
        let (x, y) = (brightest % width, brightest / width);
        // The middle of the picture is +z; 40° up are 50° from the top.
        assert!(x.abs_diff(width / 2) <= 1, "{x}");
        assert!((y as f64 / ROWS as f64 * 180.0 - 50.0).abs() < 2.0, "{y}");
        assert_eq!(pixels[100 * width + 3], pixels[100 * width + width - 4]);
        // Blue away from the sun.
        let rgb = day.picture.rgb.as_ref().map_or([0.0; 3], |rgb| rgb[ROWS / 8 * width]);
        assert!(rgb[2] > 1.5 * rgb[0], "{rgb:?}");
    }
}
