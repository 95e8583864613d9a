//! Sums in two doubles, so that they come out the same in whatever pieces they are made.
//!
//! A plain f64 sum depends on the order of its terms in its last bits. Here what a step rounds off is carried on: the sum
//! is right to 2⁻¹⁰⁴ of the terms' sizes per term. Pieces that are made apart and merged then give the f64 of the whole,
//! unless the true sum lies that close to the middle of two doubles. Error-free transformations: T. J. Dekker, "A
//! floating-point technique for extending the available precision", Numer. Math. 18 (1971); D. E. Knuth, TAOCP 2, 4.2.2.

/// A sum: `high` is its value rounded to f64, `low` what is beyond that.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct Sum {
    pub high: f64,
    pub low: f64,
}

/// a + b and what its rounding leaves, for any a and b.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let of_b = sum - a;
    (sum, (a - (sum - of_b)) + (b - of_b))
}

/// The same for |a| ≥ |b|.
fn fast_two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    (sum, b - (sum - a))
}

impl Sum {
    pub const ZERO: Sum = Sum { high: 0.0, low: 0.0 };

    pub fn value(self) -> f64 {
        self.high
    }

    /// Adds one term.
    pub fn add(&mut self, term: f64) {
        let (sum, rest) = two_sum(self.high, term);
        (self.high, self.low) = fast_two_sum(sum, rest + self.low);
    }

    /// Adds a sum that was made apart.
    pub fn merge(&mut self, other: Sum) {
        let (high, rest) = two_sum(self.high, other.high);
        let (low, last) = two_sum(self.low, other.low);
        let (high, rest) = fast_two_sum(high, rest + low);
        (self.high, self.low) = fast_two_sum(high, rest + last);
    }

    pub fn is_finite(self) -> bool {
        (self.high + self.low).is_finite()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn sum(terms: &[f64]) -> Sum {
        let mut sum = Sum::ZERO;
        terms.iter().for_each(|term| sum.add(*term));
        sum
    }

    proptest! {
        /// Any cut into pieces merged in any order gives the same f64, where a plain sum does not.
        #[test]
        fn pieces_make_the_whole(
            terms in prop::collection::vec((-1.0f64..1.0, -40i32..40).prop_map(|(m, e)| m * 2f64.powi(e)), 1..200),
            at in 0usize..200,
        ) {
            let at = at % terms.len();
            let whole = sum(&terms);
            let (mut first, mut second) = (sum(&terms[at..]), sum(&terms[..at]));
            first.merge(second);
            second.merge(sum(&terms[at..]));
            prop_assert_eq!(first.value(), whole.value());
            prop_assert_eq!(second.value(), whole.value());
        }
    }

    /// Thousandths are no doubles: ten thousand of them are ten, and a plain sum is not.
    #[test]
    fn carries_what_is_rounded_off() {
        let terms = vec![0.001; 10_000];
        // 0.001 as f64 is 0.001 + 2.08e-20, so the exact sum is 10 + 2.08e-16, which rounds to 10.
        assert_eq!(sum(&terms).value(), 10.0);
        assert_ne!(terms.iter().sum::<f64>(), 10.0);
        let mut large = sum(&[1e16, 1.0, -1e16]);
        assert_eq!(large.value(), 1.0);
        large.add(f64::NAN);
        assert!(!large.is_finite());
    }
}
