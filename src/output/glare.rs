//! Light scattered in the eye: a picture as it falls on the retina, spread by the whole point-spread function of
//! CIE 135/1:1999 (`base::vision`), normalised to pass all light.
//!
//! The function is taken to be the same everywhere in the picture, as it is around its middle. Light from beyond the
//! picture's edge is not known and not added; what is scattered beyond it is lost.

use super::field::Field;
use eyebox_base::vision::glare_spread;
use rustfft::num_complex::Complex;
use rustfft::{FftDirection, FftPlannerScalar};
use std::f64::consts::PI;

/// Pigment of the iris where nobody says: brown eyes (CIE 135/1).
pub const PIGMENT: f64 = 0.5;
/// Pixels this near are sampled more finely than once, along each axis.
const NEAR: i64 = 4;
const FINE: usize = 16;

/// Spreads three channels of `width × height` pixels; values that are not finite count as 0 and stay what they are.
/// The age is the eye's in the header.
pub fn spread(channels: [&[f32]; 3], [width, height]: [usize; 2], field: &Field, pigment: f64) -> [Vec<f64>; 3] {
    let padded = [2 * width, 2 * height];
    let mut transfer = kernel(padded, field, pigment);
    transform(&mut transfer, padded, FftDirection::Forward);
    let scale = 1.0 / (padded[0] * padded[1]) as f64;
    channels.map(|channel| {
        let mut plane = vec![Complex::new(0.0, 0.0); padded[0] * padded[1]];
        for (index, value) in channel.iter().enumerate().filter(|(_, value)| value.is_finite()) {
            plane[(index / width) * padded[0] + index % width] = Complex::new(f64::from(*value), 0.0);
        }
        transform(&mut plane, padded, FftDirection::Forward);
        plane.iter_mut().zip(&transfer).for_each(|(value, transfer)| *value *= transfer * scale);
        transform(&mut plane, padded, FftDirection::Inverse);
        let at = |(index, value): (usize, &f32)| {
            let spread = plane[(index / width) * padded[0] + index % width].re;
            if value.is_finite() { spread } else { f64::from(*value) }
        };
        channel.iter().enumerate().map(at).collect()
    })
}

/// The share of a pixel's light that falls on the pixel at each offset, around the first entry.
fn kernel([wide, high]: [usize; 2], field: &Field, pigment: f64) -> Vec<Complex<f64>> {
    let pixel = field.pixel_tangent();
    let all = encircled(180.0, field.age, pigment);
    let density = |x: f64, y: f64| {
        let tangent = (x * pixel[0]).hypot(y * pixel[1]);
        // The veil is the source's illuminance times the function; the source's solid angle is that of the middle.
        glare_spread(tangent.atan().to_degrees(), field.age, pigment) / all * pixel[0] * pixel[1]
    };
    // The pixel itself: the disc of its area.
    let own = encircled((pixel[0] * pixel[1] / PI).sqrt().atan().to_degrees(), field.age, pigment) / all;
    let centred = |place: usize, size: usize| {
        let (place, size) = (place as i64, size as i64);
        if 2 * place >= size { place - size } else { place }
    };
    let share = |index: usize| {
        let (x, y) = (centred(index % wide, wide), centred(index / wide, high));
        if (x, y) == (0, 0) {
            own
        } else if x.abs().max(y.abs()) <= NEAR {
            let fine = |i: usize| (i as f64 + 0.5) / FINE as f64 - 0.5;
            let points = (0..FINE * FINE).map(|i| density(x as f64 + fine(i % FINE), y as f64 + fine(i / FINE)));
            points.sum::<f64>() / (FINE * FINE) as f64
        } else {
            density(x as f64, y as f64)
        }
    };
    (0..wide * high).map(|index| Complex::new(share(index), 0.0)).collect()
}

/// Light of a point within an angle of it: 2π∫ PSF sin θ dθ, in equal steps of log θ.
fn encircled(theta_deg: f64, age: f64, pigment: f64) -> f64 {
    const STEPS: usize = 4000;
    /// Within this the function is constant.
    const FLAT_DEG: f64 = 1e-5;
    let disc = |theta: f64| PI * theta.to_radians().powi(2) * glare_spread(0.0, age, pigment);
    if theta_deg <= FLAT_DEG {
        return disc(theta_deg);
    }
    let step = (theta_deg / FLAT_DEG).ln() / STEPS as f64;
    let at = |i: usize| {
        let theta = FLAT_DEG * ((i as f64 + 0.5) * step).exp();
        2.0 * PI * glare_spread(theta, age, pigment) * theta.to_radians().sin() * theta.to_radians() * step
    };
    disc(FLAT_DEG) + (0..STEPS).map(at).sum::<f64>()
}

fn transform(field: &mut Vec<Complex<f64>>, [wide, high]: [usize; 2], direction: FftDirection) {
    let mut planner = FftPlannerScalar::new();
    planner.plan_fft(wide, direction).process(field);
    let mut turned: Vec<Complex<f64>> = (0..wide * high).map(|i| field[(i % high) * wide + i / high]).collect();
    planner.plan_fft(high, direction).process(&mut turned);
    *field = (0..wide * high).map(|i| turned[(i % wide) * high + i / wide]).collect();
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyebox_film::frame::{Frame, Meta};

    /// Integrals over the sphere in tests/data/eye_glare_scenes.json.
    #[test]
    fn the_whole_function_holds_what_the_table_says() {
        for (age, pigment, want) in
            [(20.0, 0.0, 1.009_733_8), (25.0, 0.5, 1.046_645_2), (70.0, 0.5, 1.092_155_5), (70.0, 1.2, 1.188_912_2)]
        {
            let got = encircled(180.0, age, pigment);
            assert!((got / want - 1.0).abs() < 1e-4, "{age} {pigment}: {got} {want}");
        }
    }

    /// A point source of illuminance E gives a veil of E·PSF(θ): the closed form, and near the simpler CIE 146 law.
    #[test]
    fn a_point_veils_as_the_formula_says() {
        let (width, height) = (121usize, 61usize);
        let mut frame = Frame::new(width, height);
        frame.meta.insert("eye".into(), Meta::Text("{\"fov_deg\":24.0,\"age\":45.0}".into()));
        let field = Field::of(&frame).unwrap();
        let mut picture = vec![0.0f32; width * height];
        let source = 30 * width + 60;
        picture[source] = 1e6;
        let [out, ..] = spread([&picture; 3], [width, height], &field, PIGMENT);
        // The line of sight is the source's, so its illuminance has no cosine.
        let illuminance = 1e6 * field.solid_angle([60.5, 30.5]);
        for away in [10, 25, 50] {
            let theta = field.angle_deg([60.5, 30.5], [60.5 + away as f64, 30.5]);
            let want = illuminance * glare_spread(theta, 45.0, PIGMENT) / encircled(180.0, 45.0, PIGMENT);
            assert!((out[source + away] / want - 1.0).abs() < 1e-3, "{theta}°: {} {want}", out[source + away]);
            let law = illuminance * eyebox_base::vision::glare_general(theta, 45.0, PIGMENT);
            assert!((out[source + away] / law - 1.0).abs() < 0.2, "{theta}°: {} {law}", out[source + away]);
        }
        // Most of the light is still in the picture, none was made.
        let sum: f64 = out.iter().sum();
        assert!(sum < 1e6 && sum > 0.9e6, "{sum}");
        picture[3] = f32::NAN;
        let [out, ..] = spread([&picture; 3], [width, height], &field, PIGMENT);
        assert!(out[3].is_nan() && out[4].is_finite());
    }
}
