//! The product estimator against errors that are known.

use super::*;
use crate::curve::cells::Batches;
use eyebox_base::rng::{Rng, Stream};

const SIDE: usize = 64;

fn picture(values: Vec<f64>, variance: f64) -> Picture {
    Picture { width: SIDE, height: SIDE, variances: vec![variance; values.len()], values, batches: Batches::default() }
}

/// A bright half and a dark half.
fn truth() -> Vec<f64> {
    (0..SIDE * SIDE).map(|pixel| if pixel % SIDE < SIDE / 2 { 100.0 } else { 50.0 }).collect()
}

/// `values` · `gain` with uniform noise of this standard deviation.
fn noisy(values: &[f64], gain: f64, sigma: f64, seed: u64) -> Picture {
    let half = sigma * 3f64.sqrt();
    let mut rng = Rng::new(seed, Stream::Backward, 0, 0);
    let values = values.iter().map(|v| v * gain + half * (2.0 * rng.pair()[0] - 1.0)).collect();
    picture(values, sigma * sigma)
}

/// The references' own variance is 9 times the picture's, and yet the mean is the picture's own error.
#[test]
fn noise_of_the_references_does_not_count() {
    let truth = truth();
    let mut moments = eyebox_base::stats::Moments::default();
    for seed in 0..160 {
        let references = References::new(noisy(&truth, 1.0, 3.0, 1000 + seed), noisy(&truth, 1.0, 3.0, 2000 + seed));
        moments.add(references.measure(&noisy(&truth, 1.0, 1.0, 3000 + seed)).relmse);
    }
    let mean_over_pixels = |of: &dyn Fn(f64) -> f64| truth.iter().map(|r| of(*r)).sum::<f64>() / truth.len() as f64;
    let black = (0.01 * mean_over_pixels(&|r| r)).powi(2);
    let want = mean_over_pixels(&|r| 1.0 / (r * r + black));
    // The mean of the references in the denominator, whose variance is 4.5: 3·4.5/r² of the error and 1.5 v²/r⁴ of
    // their own.
    let bias = mean_over_pixels(&|r| 13.5 / r.powi(4) + 1.5 * 81.0 / r.powi(4));
    let miss = moments.mean - want - bias;
    assert!(miss.abs() < 4.0 * moments.stderr() + 0.005 * want, "{miss} {moments:?} {want} {bias}");
    assert!(moments.stderr() < 0.02 * want && bias < 0.06 * want, "{moments:?} {want} {bias}");
}

/// Without an error the estimate is 0 within what the references claim to resolve, and an error above that is seen.
#[test]
fn resolution_is_what_can_be_told() {
    let truth = truth();
    let mut beyond = 0;
    for seed in 0..40 {
        let references = References::new(noisy(&truth, 1.0, 3.0, 1000 + seed), noisy(&truth, 1.0, 3.0, 2000 + seed));
        let none = references.measure(&picture(truth.clone(), 0.0));
        beyond += usize::from(none.relmse.abs() > references.resolution());
        assert!(none.relmse.abs() < 3.0 * references.resolution(), "{none:?}");
        let some = references.measure(&noisy(&truth, 1.0, 3.0, 4000 + seed));
        assert!(some.relmse > 5.0 * references.resolution(), "{some:?} {}", references.resolution());
    }
    // Two standard errors are passed by one normal number in 22.
    assert!(beyond <= 6, "{beyond} of 40");
}

/// A sound picture passes the test of its blocks, one that is 2 % too bright does not, nor one whose one block is.
#[test]
fn a_bias_of_two_per_cent_shows() {
    let truth = truth();
    let references = References::new(noisy(&truth, 1.0, 1.0, 1), noisy(&truth, 1.0, 1.0, 2));
    let limit = references.most_sigma();
    let sound = references.measure(&noisy(&truth, 1.0, 1.0, 3));
    assert!(
        sound.worst_sigma.abs() < limit + 1.0 && (sound.energy - 1.0).abs() < 4.0 * sound.energy_sigma,
        "{sound:?}"
    );
    let bright = references.measure(&noisy(&truth, 1.02, 1.0, 3));
    assert!(bright.worst_sigma > 1.5 * limit, "{bright:?} {limit}");
    assert!((bright.energy - 1.02).abs() < 4.0 * bright.energy_sigma && bright.energy_sigma < 1e-3, "{bright:?}");
    let mut spotted = noisy(&truth, 1.0, 1.0, 3);
    (0..8).for_each(|y| (0..8).for_each(|x| spotted.values[y * SIDE + x] *= 0.98));
    let spotted = references.measure(&spotted);
    assert!(spotted.worst_sigma < -1.5 * limit, "{spotted:?}");
}

/// What rounds without chance is no bias: 10⁴ sums of a number that has no short binary fraction.
#[test]
fn rounding_is_no_bias() {
    let plain = |passes: i32| {
        let sum = (0..passes).fold(0.0, |sum, _| sum + 104.330_9);
        picture(vec![sum / f64::from(passes); SIDE * SIDE], 0.0)
    };
    let references = References::new(plain(7001), plain(6999));
    let error = references.measure(&plain(900));
    assert!(error.worst_sigma != 0.0 && error.worst_sigma.abs() < 1.0, "{error:?}");
}

/// One pixel in a thousand may be anything for the trimmed error, two may not.
#[test]
fn trimming_leaves_out_one_in_a_thousand() {
    let truth = truth();
    let references = References::new(picture(truth.clone(), 0.0), picture(truth.clone(), 0.0));
    let with_fireflies = |count: usize| {
        let mut values: Vec<f64> = truth.iter().map(|v| v * 1.01).collect();
        (0..count).for_each(|i| values[i * 37 % (SIDE * SIDE)] *= 1000.0);
        references.measure(&picture(values, 0.0))
    };
    let clean = with_fireflies(0);
    assert!((clean.relmse / 1e-4 - 1.0).abs() < 0.01 && (clean.trimmed / 1e-4 - 1.0).abs() < 0.01, "{clean:?}");
    // 4096 pixels: four are left out.
    let four = with_fireflies(4);
    assert!(four.relmse > 100.0 && (four.trimmed / 1e-4 - 1.0).abs() < 0.01, "{four:?}");
    assert!(with_fireflies(5).trimmed > 100.0);
}

/// The edge between the halves is not flat, the rest is; an error at the edge does not count for flat pixels.
#[test]
fn flat_pixels_are_those_away_from_edges() {
    let truth = truth();
    let references = References::new(picture(truth.clone(), 0.0), picture(truth.clone(), 0.0));
    assert_eq!(references.flat_pixels(), [SIDE * (SIDE - 2), SIDE * SIDE]);
    let mut values = truth.clone();
    (0..SIDE).for_each(|y| values[y * SIDE + SIDE / 2] *= 2.0);
    let error = references.measure(&picture(values, 0.0));
    assert!(error.relmse > 1e-3 && error.flat == Some(0.0), "{error:?}");
    let all = error.edges.expect("a column of edges") * 2.0 / SIDE as f64;
    assert!((all / error.relmse - 1.0).abs() < 1e-12, "{error:?}");
}

/// Black pictures compare as equal, not as no number.
#[test]
fn black_is_no_fault() {
    let black = || picture(vec![0.0; SIDE * SIDE], 0.0);
    let error = References::new(black(), black()).measure(&black());
    assert_eq!((error.relmse, error.trimmed, error.energy, error.worst_sigma), (0.0, 0.0, 0.0, 0.0));
}

/// One pixel in three hundred holds all light of the left half in the references: the blocks grow, and a picture with
/// that light everywhere agrees, one without it does not.
#[test]
fn rare_light_is_compared_over_large_blocks() {
    let truth = truth();
    let rare = |seed: u64| {
        let mut rng = Rng::new(seed, Stream::Backward, 0, 0);
        let hit =
            |value: &f64| if *value > 60.0 { 300.0 * value * f64::from(rng.uniform() < 1.0 / 300.0) } else { *value };
        picture(truth.iter().map(hit).collect(), 0.0)
    };
    let mut found = 0;
    for seed in 0..10 {
        let whole = |offset: u64| {
            // The mean of 100 such pictures.
            let pictures: Vec<Picture> = (0..100).map(|i| rare(1000 * seed + offset + i)).collect();
            let mean = |p: usize| pictures.iter().map(|picture| picture.values[p]).sum::<f64>() / 100.0;
            picture((0..truth.len()).map(mean).collect(), 0.0)
        };
        let references = References::new(whole(0), whole(100));
        let most_sigma = references.most_sigma_at(1e-3);
        let sound = references.measure(&picture(truth.clone(), 0.0));
        assert!(sound.worst_sigma.abs() < most_sigma, "{sound:?} {most_sigma}");
        assert!(references.known_blocks().is_some_and(|blocks| blocks < 64));
        let dark = truth.iter().map(|v| if *v > 60.0 { 0.5 * v } else { *v }).collect();
        found += usize::from(references.measure(&picture(dark, 0.0)).worst_sigma < -most_sigma);
    }
    assert!(found >= 9, "{found}");
    let exact = References::new(picture(truth.clone(), 0.0), picture(truth, 0.0));
    assert_eq!(exact.known_blocks(), Some(64));
}
