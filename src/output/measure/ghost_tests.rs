//! Pictures with a planted ghost: of a known ratio, at a known shift.

use super::*;
use eyebox_base::rng::{Rng, Stream};

const SIZE: [usize; 2] = [160, 96];

/// An upright rectangle: left, top, width, height in pixels, and its luminance.
type Box = ([f64; 4], f64);

/// What pixels have of rectangles, each with its ghosts (ratio, shift).
fn drawn(boxes: &[Box], ghosts: &[(f64, DVec2)]) -> Vec<f64> {
    let mut out = vec![0.0; SIZE[0] * SIZE[1]];
    let all = [(1.0, DVec2::ZERO)];
    for (ratio, by) in all.iter().chain(ghosts) {
        for ([left, top, width, height], level) in boxes {
            let covered = |at: usize, from: f64, size: f64| (from + size).min(at as f64 + 1.0) - from.max(at as f64);
            for (pixel, to) in out.iter_mut().enumerate() {
                let across = covered(pixel % SIZE[0], left + by.x, *width).max(0.0);
                let down = covered(pixel / SIZE[0], top + by.y, *height).max(0.0);
                *to += ratio * level * across * down;
            }
        }
    }
    out
}

/// With noise of this share of each pixel, evenly spread.
fn noisy(values: &[f64], relative: f64, seed: u64) -> Vec<f64> {
    let mut rng = Rng::new(seed, Stream::Check, 0, 0);
    values.iter().map(|v| v * (1.0 + relative * 12f64.sqrt() * (rng.uniform() - 0.5))).collect()
}

/// Strokes of many lengths and levels at random places.
fn strokes(seed: u64) -> Vec<Box> {
    let mut rng = Rng::new(seed, Stream::Check, 1, 0);
    let mut between = |low: f64, high: f64| low + (high - low) * rng.uniform();
    (0..60)
        .map(|i| {
            let (long, thin) = (between(3.0, 14.0), between(1.0, 3.0));
            let size = if i % 2 == 0 { [long, thin] } else { [thin, long] };
            ([between(12.0, 130.0), between(14.0, 66.0), size[0], size[1]], between(20.0, 100.0))
        })
        .collect()
}

const SQUARE: [Box; 1] = [([60.3, 30.6, 34.0, 28.0], 100.0)];

/// Ghosts are found where they are, with the ratio that they have: to three standard errors, and those are no more than `most`
/// of it. `along`: how well the picture tells the shift along its edges, pixels.
fn found(boxes: &[Box], (ratio, shift): (f64, DVec2), noise: f64, (most, along): (f64, f64)) {
    let values = noisy(&drawn(boxes, &[(ratio, shift)]), noise, 5);
    let case = format!("{} boxes, {ratio} at {shift}, noise {noise}", boxes.len());
    let found = echo(&values, SIZE).unwrap_or_else(|missing| panic!("{case}: {missing:?}"));
    assert!((found.ratio - ratio).abs() < 3.0 * found.sigma, "{case}: {found:?}");
    assert!(found.sigma < most * ratio, "{case}: {found:?}");
    assert!((found.offset - shift).length() < along, "{case}: {found:?}");
}

/// The standard target of ghosts: an isolated square; the windshield's own ratio, below and beside it.
#[test]
fn an_isolated_square_with_a_ghost() {
    for shift in [DVec2::new(0.0, 6.4), DVec2::new(9.3, -5.25), DVec2::new(-7.5, -12.0), DVec2::new(13.0, 0.4)] {
        for ratio in [0.1, 0.3, 0.664, 0.85] {
            for noise in [0.0, 0.03] {
                found(&SQUARE, (ratio, shift), noise, (0.06, 1.0));
            }
        }
    }
}

#[test]
fn small_things_with_a_ghost() {
    for shift in [DVec2::new(9.3, -5.25), DVec2::new(-7.5, -12.0), DVec2::new(13.0, 0.4)] {
        for ratio in [0.3, 0.664, 0.85] {
            found(&[([70.0, 40.0, 6.0, 6.0], 80.0)], (ratio, shift), 0.03, (0.06, 0.5));
        }
    }
}

#[test]
fn a_busy_picture_with_a_ghost() {
    for seed in [0, 2] {
        for shift in [DVec2::new(9.3, -5.25), DVec2::new(-11.7, 2.5)] {
            for ratio in [0.3, 0.664, 0.85] {
                found(&strokes(seed), (ratio, shift), 0.03, (0.15, 1.0));
            }
        }
    }
}

#[test]
fn a_picture_without_a_ghost_has_none() {
    for seed in 0..4 {
        for (noise, boxes) in [(0.0, strokes(seed)), (0.03, strokes(seed)), (0.03, SQUARE.to_vec())] {
            assert_eq!(echo(&noisy(&drawn(&boxes, &[]), noise, seed), SIZE), Err(Missing::None), "{seed} {noise}");
        }
    }
    assert_eq!(echo(&drawn(&SQUARE, &[]), SIZE), Err(Missing::None));
    assert_eq!(echo(&vec![1.0; SIZE[0] * SIZE[1]], SIZE), Err(Missing::Empty));
    assert_eq!(echo(&[1.0; 4], [2, 2]), Err(Missing::Empty));
    assert_eq!(echo(&vec![f64::NAN; 400], [20, 20]), Err(Missing::Empty));
}

/// Lines at equal distances, with a ghost and without: an echo at the ghost's shift and at a whole number of distances more
/// or less explain them equally well.
#[test]
fn a_periodic_picture_tells_nothing() {
    let lines = |step: f64, across: bool| -> Vec<Box> {
        let count = ((if across { 120.0 } else { 70.0 }) / step) as usize;
        let at = |i: usize| 12.0 + step * i as f64;
        let line = |i| if across { ([at(i), 12.0, 2.0, 66.0], 90.0) } else { ([20.0, at(i), 110.0, 2.0], 90.0) };
        (0..count).map(line).collect()
    };
    let both = |step: f64| [lines(step, true), lines(step, false)].concat();
    for boxes in [lines(9.0, false), lines(12.5, true), both(14.0)] {
        for ghost in [vec![], vec![(0.664, DVec2::new(0.0, 6.1))], vec![(0.3, DVec2::new(5.0, 3.0))]] {
            let found = echo(&drawn(&boxes, &ghost), SIZE);
            assert!(matches!(found, Err(Missing::Repeats(_))), "{} {ghost:?} {found:?}", boxes.len());
        }
    }
}
