//! What draws say of a figure.

use super::figures::Figure;

/// Percentiles that are told.
pub const PERCENT: [f64; 5] = [1.0, 5.0, 50.0, 95.0, 99.0];

/// What one parameter makes by itself.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Share {
    pub name: String,
    /// Of the figure, in its unit squared; none where one of the designs in which it alone is off does not have the figure.
    pub variance: Option<f64>,
}

/// A figure over all draws.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Statistics {
    #[serde(flatten)]
    pub figure: Figure,
    pub nominal: f64,
    /// Draws that have the figure. The others' numbers are NaN if there is none.
    pub draws: usize,
    pub mean: f64,
    /// Standard deviation, and the standard error of that: from the fourth moment, so that it holds for any distribution.
    pub sigma: f64,
    pub sigma_error: f64,
    pub least: f64,
    pub most: f64,
    /// At 1, 5, 50, 95, 99 %.
    pub percentiles: [f64; 5],
    /// The parameters' own variances, largest first.
    pub shares: Vec<Share>,
}

/// None of a figure that the nominal design does not have, and no draw either.
pub fn of(figure: &Figure, nominal: f64, seen: &[f64], shares: Vec<Share>) -> Option<Statistics> {
    let mut sorted: Vec<f64> = seen.iter().copied().filter(|value| value.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    if sorted.is_empty() && !nominal.is_finite() {
        return None;
    }
    let end = |value: Option<&f64>| value.copied().unwrap_or(f64::NAN);
    let (least, most) = (end(sorted.first()), end(sorted.last()));
    let count = sorted.len() as f64;
    // About the nominal value: digits of a large figure are not lost.
    let from = if nominal.is_finite() { nominal } else { least };
    let mean = from + sorted.iter().map(|x| x - from).sum::<f64>() / count;
    let moment = |power: i32| sorted.iter().map(|x| (x - mean).powi(power)).sum::<f64>() / count;
    let variance = moment(2) * count / (count - 1.0).max(1.0);
    // Var s² = (μ₄ − σ⁴)/n to first order (Cramér, Mathematical Methods of Statistics, 27.4), and σ's error is half of it over σ.
    let sigma = variance.sqrt();
    let of_variance = ((moment(4) - moment(2).powi(2)).max(0.0) / count).sqrt();
    let sigma_error = if sigma > 0.0 { 0.5 * of_variance / sigma } else { 0.0 };
    let percentiles = PERCENT.map(|percent| {
        // Between the two draws about it (Hyndman and Fan, American Statistician 50 (1996), 361, definition 7).
        let at = percent / 100.0 * (count - 1.0);
        let below = at.floor() as usize;
        let value = |index: usize| sorted.get(index).copied().unwrap_or(most);
        value(below) + (at - at.floor()) * (value(below + 1) - value(below))
    });
    let (figure, draws) = (figure.clone(), sorted.len());
    let percentiles = percentiles.map(|value| if draws == 0 { f64::NAN } else { value });
    Some(Statistics { figure, nominal, draws, mean, sigma, sigma_error, least, most, percentiles, shares })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_one_to_a_hundred_and_one() {
        let figure = Figure { name: "x".into(), unit: "1" };
        let seen: Vec<f64> = (0..=100).rev().map(f64::from).chain([f64::NAN]).collect();
        let found = of(&figure, 40.0, &seen, Vec::new()).unwrap();
        assert_eq!((found.draws, found.least, found.most), (101, 0.0, 100.0));
        assert_eq!(found.percentiles, [1.0, 5.0, 50.0, 95.0, 99.0]);
        // (n² − 1)/12 over n, as a sample.
        assert!((found.mean - 50.0).abs() < 1e-12 && (found.sigma - f64::sqrt(858.5)).abs() < 1e-9, "{}", found.sigma);
        assert!(of(&figure, f64::NAN, &[f64::NAN], Vec::new()).is_none());
        // The design has it, and nothing that is made of it.
        let lost = of(&figure, 40.0, &[f64::NAN], Vec::new()).unwrap();
        assert!(lost.draws == 0 && lost.mean.is_nan() && lost.percentiles.iter().all(|value| value.is_nan()));
    }
}
