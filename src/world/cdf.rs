//! Choosing one of many by weight, and handing the unused part of the random number on.

use eyebox_base::warp::BELOW_ONE;

/// A discrete distribution over `0..n` with probabilities proportional to non-negative weights.
#[derive(Debug, Clone, PartialEq)]
pub struct Cdf {
    /// Running sums of the weights; the last is their total.
    cumulative: Vec<f64>,
    /// The last index with a positive weight: rounding must not choose a weightless one behind it.
    last: usize,
}

impl Cdf {
    /// None if a weight is negative or not finite, or if the total is zero or not finite.
    pub fn new(weights: impl IntoIterator<Item = f64>) -> Option<Self> {
        let (mut cumulative, mut sum, mut last) = (Vec::new(), 0.0f64, None);
        for weight in weights {
            if !(weight >= 0.0 && weight.is_finite()) {
                return None;
            }
            let before = sum;
            sum += weight;
            if sum > before {
                last = Some(cumulative.len());
            }
            cumulative.push(sum);
        }
        if !sum.is_finite() {
            return None;
        }
        Some(Cdf { cumulative, last: last? })
    }

    pub fn len(&self) -> usize {
        self.cumulative.len()
    }
    /// Never: there is at least one positive weight.
    pub fn is_empty(&self) -> bool {
        self.cumulative.is_empty()
    }
    /// Sum of the weights.
    pub fn total(&self) -> f64 {
        self.cumulative[self.cumulative.len() - 1]
    }
    /// Weight of `index` as the sampler sees it; 0 beyond the end.
    pub fn weight(&self, index: usize) -> f64 {
        let before = if index == 0 { 0.0 } else { self.cumulative.get(index - 1).copied().unwrap_or(0.0) };
        self.cumulative.get(index).map_or(0.0, |sum| sum - before)
    }
    /// Probability of `index`; 0 beyond the end.
    pub fn probability(&self, index: usize) -> f64 {
        self.weight(index) / self.total()
    }
    /// The index that `u` in [0, 1) chooses, and where in its interval `u` lies: again uniform in [0, 1), independent
    /// of the index.
    pub fn sample(&self, u: f64) -> (usize, f64) {
        let x = u * self.total();
        let index = self.cumulative.partition_point(|&sum| sum <= x).min(self.last);
        let weight = self.weight(index);
        let before = self.cumulative[index] - weight;
        (index, within(x - before, weight))
    }
}

/// `offset / width` kept inside [0, 1).
pub(super) fn within(offset: f64, width: f64) -> f64 {
    (offset / width).clamp(0.0, BELOW_ONE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frequencies_and_remainders() {
        let cdf = Cdf::new([0.0, 1.0, 0.0, 3.0, 0.0]).unwrap();
        let (mut seen, mut rest, count) = ([0.0; 5], 0.0, 1000);
        for k in 0..count {
            let (index, remainder) = cdf.sample((k as f64 + 0.5) / count as f64);
            assert!((0.0..1.0).contains(&remainder));
            seen[index] += 1.0 / count as f64;
            rest += remainder / count as f64;
        }
        for (index, share) in seen.into_iter().enumerate() {
            assert!((share - cdf.probability(index)).abs() < 1e-12, "{index}: {share}");
        }
        assert!((rest - 0.5).abs() < 1e-3);
        assert_eq!(cdf.sample(1.0).0, 3);
        assert_eq!(cdf.probability(9), 0.0);
    }

    #[test]
    fn what_cannot_be_sampled_is_refused() {
        for weights in [vec![], vec![0.0], vec![1.0, -1.0], vec![f64::NAN], vec![f64::MAX, f64::MAX]] {
            assert_eq!(Cdf::new(weights.clone()), None, "{weights:?}");
        }
    }
}
