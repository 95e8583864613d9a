//! One value for each parameter.

use super::parameter::{Law, Parameter};
use eyebox_base::murmur3::murmur3_32;
use eyebox_base::rng::{Rng, Stream};
use std::f64::consts::TAU;

/// The values of a draw, in the parameters' units and order.
pub fn draw(parameters: &[Parameter], seed: u64, draw: usize) -> Vec<f64> {
    parameters
        .iter()
        .map(|parameter| {
            let key = u64::from(murmur3_32(parameter.name.as_bytes()));
            let [a, b] = Rng::new(seed, Stream::Tolerance, draw as u64, key).pair();
            parameter.size
                * match parameter.law {
                    // Box and Muller, Annals of Mathematical Statistics 29 (1958), 610; a is below 1.
                    Law::Normal => (-2.0 * (-a).ln_1p()).sqrt() * (TAU * b).cos(),
                    Law::Uniform => 2.0 * a - 1.0,
                }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::parameter::Change;
    use super::*;
    use eyebox_base::Where;

    fn parameter(name: &str, law: Law) -> Parameter {
        let change = Change::Decenter { axis: 0 };
        Parameter { name: name.to_owned(), parts: vec![0], change, law, size: 2.0, at: Where::Nowhere }
    }

    #[test]
    fn draws_have_their_moments_and_hang_on_nothing_else() {
        let both = [parameter("a", Law::Normal), parameter("b", Law::Uniform)];
        let count = 20_000;
        let all: Vec<Vec<f64>> = (0..count).map(|i| draw(&both, 7, i)).collect();
        for (index, variance) in [(0, 4.0), (1, 4.0 / 3.0)] {
            let mean = all.iter().map(|v| v[index]).sum::<f64>() / count as f64;
            let second = all.iter().map(|v| v[index] * v[index]).sum::<f64>() / count as f64;
            assert!(mean.abs() < 4.0 * f64::sqrt(variance / count as f64), "{mean}");
            assert!((second / variance - 1.0).abs() < 4.0 * f64::sqrt(2.0 / count as f64), "{second}");
        }
        assert!(all.iter().all(|v| v[1].abs() <= 2.0));
        let product = all.iter().map(|v| v[0] * v[1]).sum::<f64>() / count as f64;
        assert!(product.abs() < 4.0 * f64::sqrt(4.0 * 4.0 / 3.0 / count as f64), "{product}");
        assert_eq!(draw(&both[1..], 7, 3)[0], all[3][1]);
        assert_ne!(draw(&both, 8, 3), all[3]);
    }
}
