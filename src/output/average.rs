//! Means over pixels with what their error can be.

use eyebox_film::frame::Frame;
use eyebox_film::plan::Estimator;

/// A luminance per pixel, cd/m², and its one-sigma errors if they are known.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    pub values: Vec<f64>,
    pub errors: Option<Vec<f64>>,
}

/// A number and its one-sigma error, if it is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Uncertain {
    pub value: f64,
    pub sigma: Option<f64>,
}

/// Only path tracing from the eye draws every pixel by itself; light tracing, photons and specular connection fill pixels
/// with paths and sample points that they share.
pub fn pixels_are_independent(frame: &Frame) -> bool {
    let used = |estimator: &Estimator| frame.meta.contains_key(&format!("passes.{}", estimator.name()));
    Estimator::ALL.iter().filter(|estimator| used(estimator)).all(|estimator| *estimator == Estimator::Backward)
        && used(&Estimator::Backward)
}

/// The weighted sum of pixels: the root of the sum of squares where they are independent, else the largest error that it
/// can have, Σ|w|σ. None of no pixels.
pub fn weighted(image: &Image, weights: &[(usize, f64)], independent: bool) -> Option<Uncertain> {
    if weights.is_empty() {
        return None;
    }
    let at = |data: &[f64], pixel: usize| data.get(pixel).copied().unwrap_or(0.0);
    let value = weights.iter().map(|(pixel, weight)| weight * at(&image.values, *pixel)).sum();
    let sigma = image.errors.as_ref().map(|errors| {
        let terms = weights.iter().map(|(pixel, weight)| (weight * at(errors, *pixel)).abs());
        if independent { terms.map(|term| term * term).sum::<f64>().sqrt() } else { terms.sum() }
    });
    // An error that the frame's passes do not tell is NaN.
    let sigma = sigma.filter(|sigma: &f64| !sigma.is_nan());
    Some(Uncertain { value, sigma })
}

/// The mean of pixels.
pub fn mean(image: &Image, pixels: &[usize], independent: bool) -> Option<Uncertain> {
    let weight = 1.0 / pixels.len().max(1) as f64;
    let weights: Vec<(usize, f64)> = pixels.iter().map(|pixel| (*pixel, weight)).collect();
    weighted(image, &weights, independent)
}

impl Uncertain {
    /// The quotient with the largest error that it can have, however both lean on each other. None over zero.
    pub fn over(self, other: Uncertain) -> Option<Uncertain> {
        let value = self.value / other.value;
        let relative = |of: Uncertain| of.sigma.map(|sigma| if sigma == 0.0 { 0.0 } else { sigma / of.value.abs() });
        let sigma = relative(self).zip(relative(other)).map(|(a, b)| value.abs() * (a + b));
        value.is_finite().then_some(Uncertain { value, sigma })
    }

    /// The sum with the largest error that it can have.
    pub fn plus(self, other: Uncertain) -> Uncertain {
        let sigma = self.sigma.zip(other.sigma).map(|(a, b)| a + b);
        Uncertain { value: self.value + other.value, sigma }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_and_their_errors() {
        let image = Image { values: vec![1.0, 3.0, 100.0], errors: Some(vec![0.3, 0.4, 9.0]) };
        let of = |independent| mean(&image, &[0, 1], independent).unwrap();
        assert_eq!(of(true).value, 2.0);
        assert!((of(true).sigma.unwrap() - 0.25).abs() < 1e-15, "√(0.09 + 0.16)/2");
        assert!((of(false).sigma.unwrap() - 0.35).abs() < 1e-15, "(0.3 + 0.4)/2");
        assert_eq!(mean(&image, &[], true), None);
        let quotient = of(false).over(Uncertain { value: 4.0, sigma: Some(0.4) }).unwrap();
        assert!((quotient.value - 0.5).abs() < 1e-15 && (quotient.sigma.unwrap() - 0.5 * 0.275).abs() < 1e-12);
        assert_eq!(of(true).over(Uncertain { value: 0.0, sigma: None }), None);
    }
}
