//! A second, weaker picture beside the first, found by the cepstrum: of p(x) + r·p(x − d) the logarithm of the power
//! spectrum is that of p plus 2·Σₖ (−1)ᵏ⁺¹ rᵏ cos(k·ω·d)/k, so its inverse transform has a peak of height r at d whatever
//! p is. Bogert, Healy and Tukey, "The quefrency alanysis of time series for echoes", 1963.

use rustfft::num_complex::Complex;
use rustfft::{FftDirection, FftPlanner};

/// Echoes nearer than this many pixels are the sharpness of the picture itself.
const NEAREST: f64 = 2.5;
/// How far above the other values (their median distance from 0) a peak must stand.
const SIGNIFICANCE: f64 = 12.0;
/// Share of the largest spectral power below which it is rounding.
const FLOOR: f64 = 1e-12;

/// The strongest echo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Echo {
    /// Pixels to the right and down; the sign is chosen so that the ghost is to the right, or straight below.
    pub offset: [i64; 2],
    /// Luminance of the ghost over that of the picture.
    pub ratio: f64,
    /// Peaks below this cannot be told from the picture's own structure.
    pub noise: f64,
}

/// The strongest echo in a picture, or the ratio that one would have needed to be found.
pub fn echo(values: &[f64], width: usize, height: usize) -> Result<Echo, f64> {
    if values.len() != width * height || width < 8 || height < 8 {
        return Err(1.0);
    }
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let mut field: Vec<Complex<f64>> = values.iter().map(|value| Complex::new(value - mean, 0.0)).collect();
    transform(&mut field, width, height, FftDirection::Forward);
    let peak = field.iter().fold(0.0f64, |peak, value| peak.max(value.norm_sqr()));
    if !(peak > 0.0 && peak.is_finite()) {
        return Err(1.0);
    }
    for value in &mut field {
        *value = Complex::new(value.norm_sqr().max(FLOOR * peak).ln(), 0.0);
    }
    transform(&mut field, width, height, FftDirection::Inverse);
    let scale = 1.0 / (width * height) as f64;
    // An echo can be told from its mirror image at the other side only by its sign, which both share.
    let (mut best, mut all) = ((0.0f64, [0i64; 2]), Vec::new());
    for (index, value) in field.iter().enumerate() {
        let centred = |place: usize, size: usize| {
            let (place, size) = (place as i64, size as i64);
            if 2 * place > size { place - size } else { place }
        };
        let offset = [centred(index % width, width), centred(index / width, height)];
        let far = (offset[0] as f64).hypot(offset[1] as f64) > NEAREST;
        // The rows and columns through 0 hold the picture's own edges.
        let upper = offset[0] > 0 || offset[0] == 0 && offset[1] > 0;
        if !far || !upper {
            continue;
        }
        let height = value.re * scale;
        all.push(height.abs());
        if height > best.0 {
            best = (height, offset);
        }
    }
    all.sort_by(f64::total_cmp);
    let noise = SIGNIFICANCE * all.get(all.len() / 2).copied().unwrap_or(1.0);
    if best.0 > noise { Ok(Echo { offset: best.1, ratio: best.0, noise }) } else { Err(noise) }
}

fn transform(field: &mut Vec<Complex<f64>>, width: usize, height: usize, direction: FftDirection) {
    let mut planner = FftPlanner::new();
    planner.plan_fft(width, direction).process(field);
    let mut turned: Vec<Complex<f64>> = (0..width * height).map(|i| field[(i % height) * width + i / height]).collect();
    planner.plan_fft(height, direction).process(&mut turned);
    *field = (0..width * height).map(|i| turned[(i % width) * height + i / width]).collect();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::rng::{Rng, Stream};

    /// Random dots with a ghost of a quarter, shifted by (9, −5). Their own cepstrum is noise of √(π²/6/N) = 0.016.
    #[test]
    fn a_planted_ghost_is_found() {
        let (width, height) = (96usize, 64usize);
        let mut rng = Rng::new(3, Stream::Check, 0, 0);
        let mut picture = vec![0.0; width * height];
        for (pixel, to) in picture.iter_mut().enumerate() {
            let (x, y) = (pixel % width, pixel / width);
            if (8..80).contains(&x) && (8..56).contains(&y) && rng.uniform() < 0.3 {
                *to = 100.0 * rng.uniform();
            }
        }
        let ghosted = |ratio: f64| -> Vec<f64> {
            let shifted = |i: usize| {
                let (x, y) = ((i % width) as i64 - 9, (i / width) as i64 + 5);
                if x >= 0 && y < height as i64 { picture[y as usize * width + x as usize] } else { 0.0 }
            };
            (0..width * height).map(|i| picture[i] + ratio * shifted(i)).collect()
        };
        let found = echo(&ghosted(0.25), width, height).unwrap();
        assert_eq!(found.offset, [9, -5]);
        assert!((found.ratio - 0.25).abs() < 0.05, "{found:?}");
        let limit = echo(&ghosted(0.0), width, height);
        assert!(limit.is_err_and(|limit| limit < 0.25), "{limit:?}");
        assert!(echo(&vec![1.0; 4096], 64, 64).is_err());
        assert!(echo(&[1.0; 4], 2, 2).is_err());
    }
}
