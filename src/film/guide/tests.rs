use super::*;
use eyebox_base::rng::{Rng, Stream};
use eyebox_base::sobol::Sobol;
use eyebox_base::stats::Moments;

const FLUX: [f64; 2] = [1.0, 3.0];

/// Only lamp 0 counts, in a small oblique spot of the four dimensions.
fn gain(lamp: usize, x: &Point) -> f64 {
    let direction = (x[2] - 0.3 - 0.1 * (x[0] - 0.5)).hypot(x[3] - 0.6);
    if lamp == 0 && direction < 0.05 { 1.0 } else { 0.0 }
}

fn run(guide: &Guide, count: u64, seed: u64, wrong: f64) -> (Moments, Vec<Sample>) {
    let (mut moments, mut seen) = (Moments::default(), Vec::new());
    for sample in 0..count {
        let mut rng = Rng::new(seed, Stream::Check, 0, sample);
        let u = std::array::from_fn(|_| rng.uniform());
        let drawn = guide.draw(&FLUX, rng.uniform(), u).expect("there are lamps");
        // A planted error: the density of one lamp's lower half.
        let density = if drawn.lamp == 0 && drawn.x[2] < 0.3 { drawn.density * wrong } else { drawn.density };
        let value = gain(drawn.lamp, &drawn.x) / density;
        moments.add(value);
        if value > 0.0 {
            seen.push(Sample { lamp: drawn.lamp, x: drawn.x, weight: value });
        }
    }
    (moments, seen)
}

fn learned() -> Guide {
    Guide::learn(&FLUX, &run(&Guide::unguided(&FLUX), 1_000_000, 1, 1.0).1, Even::MANY)
}

/// Integrals are the same, guided or not, and far less noisy where the guide points; a density that is 5 % off in half of
/// the spot is found.
#[test]
fn a_guide_is_unbiased_and_helps() {
    let want = std::f64::consts::PI * 0.05f64.powi(2) * 0.25;
    let (plain, seen) = run(&Guide::unguided(&FLUX), 1_000_000, 1, 1.0);
    assert!((plain.mean - want).abs() < 4.0 * plain.stderr());
    let guide = Guide::learn(&FLUX, &seen, Even::MANY);
    let (guided, hits) = run(&guide, 400_000, 2, 1.0);
    eprintln!("guided {} ± {}, want {want}, {} hits", guided.mean, guided.stderr(), hits.len());
    assert!((guided.mean - want).abs() < 4.0 * guided.stderr(), "{} {want}", guided.mean);
    assert!(plain.variance() > 20.0 * guided.variance(), "{} {}", plain.variance(), guided.variance());
    assert!(hits.len() > 220_000, "{} of 400000", hits.len());
    let (planted, _) = run(&guide, 400_000, 2, 0.95);
    assert!((planted.mean - want).abs() > 6.0 * planted.stderr(), "{} {want}", planted.mean);
}

/// chi² of where points fall against the density, over cells that are no boxes of the tree; with random and with even
/// points. Cells of each lamp: 3 × 3 × 8 × 8.
#[test]
fn points_fall_as_the_density_says() {
    let guide = learned();
    let sobol = Sobol::new(3, Stream::Check, 0);
    let count = 200_000u64;
    for even in [false, true] {
        let mut seen = vec![0.0; 2 * 576];
        let mut want = vec![[0.0f64; 2]; 2 * 576];
        let cell = |lamp: usize, x: &Point| {
            let index = |x: f64, n: usize| ((x * n as f64) as usize).min(n - 1);
            let fine = |x: f64, middle: f64| index(((x - middle) * 6.0 + 0.5).clamp(0.0, 0.999_999), 8);
            (index(x[0], 3) * 3 + index(x[1], 3)) * 64 + fine(x[2], 0.3) * 8 + fine(x[3], 0.6) + lamp * 576
        };
        for sample in 0..count {
            let mut rng = Rng::new(9, Stream::Check, 1, sample);
            let [a, b, c, d, e] = if even { sobol.point(sample) } else { std::array::from_fn(|_| rng.uniform()) };
            let drawn = guide.draw(&FLUX, e, [a, b, c, d]).expect("there are lamps");
            assert!(drawn.x.iter().all(|x| (0.0..1.0).contains(x)));
            let again = guide.density(&FLUX, drawn.lamp, &drawn.x);
            assert!((again / drawn.density - 1.0).abs() < 1e-12, "{again} {}", drawn.density);
            seen[cell(drawn.lamp, &drawn.x)] += 1.0;
        }
        // The integral of the density over each cell, and the variance of that.
        let plain = Guide::unguided(&FLUX);
        let grid = Sobol::new(4, Stream::Check, 1);
        let samples = 1u64 << 21;
        for sample in 0..samples {
            let [a, b, c, d, e, half]: [f64; 6] = grid.point(sample);
            // Half of the points about the spot, half anywhere: the balance heuristic weighs them.
            let near = half < 0.5;
            let x = if near { [a, b, 0.3 + (c - 0.5) / 6.0, 0.6 + (d - 0.5) / 6.0] } else { [a, b, c, d] };
            let inside = (x[2] - 0.3).abs() < 1.0 / 12.0 && (x[3] - 0.6).abs() < 1.0 / 12.0;
            let density = 0.5 + if inside { 0.5 * 36.0 } else { 0.0 };
            let drawn = plain.draw(&FLUX, e, x).expect("there are lamps");
            let part = guide.density(&FLUX, drawn.lamp, &x) / density * count as f64 / samples as f64;
            let [sum, squares] = &mut want[cell(drawn.lamp, &x)];
            *sum += part;
            *squares += part * part;
        }
        let total: f64 = want.iter().map(|[sum, _]| sum).sum();
        assert!((total / count as f64 - 1.0).abs() < 2e-3, "the density integrates to {}", total / count as f64);
        let (mut chi2, mut cells) = (0.0, 0.0f64);
        for (seen, [want, squares]) in seen.iter().zip(&want).filter(|(_, [want, _])| *want > 20.0) {
            chi2 += (seen - want).powi(2) / (want + squares);
            cells += 1.0;
        }
        // Mean and deviation of chi² with that many degrees of freedom.
        assert!(cells > 200.0);
        assert!(chi2 < cells + 4.0 * (2.0 * cells).sqrt(), "even {even}: chi² = {chi2} of {cells}");
    }
}

/// A guide survives being written and read, bit by bit; what is no guide is refused.
#[test]
fn a_guide_is_data() {
    let guide = learned();
    let text = serde_json::to_string(&guide).expect("it is plain data");
    let back: Guide = serde_json::from_str(&text).expect("it was written by us");
    assert_eq!(back, guide);
    assert_eq!(back.hash(), guide.hash());
    for (good, bad) in [
        ("\"axes\":[", "\"axes\":[4,"),
        ("\"axes\":[", "\"axes\":[0,0,0,"),
        ("\"cuts\":[", "\"cuts\":[[0.5,0.0],"),
        ("\"cuts\":[", "\"cuts\":[[7.0,0.5],"),
        ("\"of_lamp\":[", "\"of_lamp\":[99,"),
        ("\"shares\":[", "\"shares\":[0.0,"),
    ] {
        assert!(text.contains(good));
        let broken = text.replacen(good, bad, 1);
        assert!(serde_json::from_str::<Guide>(&broken).is_err(), "{bad}");
    }
}

/// Even points stay even: a smooth function's mean under the guide's density varies far less from scramble to scramble than
/// with random points.
#[test]
fn even_points_stay_even() {
    let guide = learned();
    let mean = |even: bool, scramble: u64| {
        let sobol = Sobol::new(2, Stream::Check, scramble);
        let count = 1024;
        let sum: f64 = (0..count)
            .map(|sample| {
                let mut rng = Rng::new(3, Stream::Check, scramble, sample);
                let [a, b, c, d, e] = if even { sobol.point(sample) } else { std::array::from_fn(|_| rng.uniform()) };
                let drawn = guide.draw(&FLUX, e, [c, d, a, b]).expect("there are lamps");
                drawn.x.iter().sum::<f64>()
            })
            .sum();
        sum / count as f64
    };
    let spread = |even: bool| {
        let mut moments = Moments::default();
        (0..100).for_each(|scramble| moments.add(mean(even, scramble)));
        moments.variance()
    };
    let (random, even) = (spread(false), spread(true));
    assert!(even < 0.05 * random, "{even} {random}");
}

/// A lamp's image that wanders through the pupil with the place in the picture is found with fewer points than if they were
/// spread evenly, and its area is right; a density that is 5 % off is found.
#[test]
fn a_guided_aperture_is_unbiased_and_helps() {
    let radius = 0.1;
    let middle = |field: [f64; 2]| [0.3 + 0.2 * field[0], 0.6 - 0.1 * field[1]];
    let crossing = |k: u64| {
        let mut rng = Rng::new(5, Stream::Check, 1, k);
        let (field, at) = (rng.pair(), eyebox_base::warp::disk(rng.pair()) * radius);
        let [u, v] = middle(field);
        Lit { field, pupil: [u + at.x, v + at.y], weight: 1.0 }
    };
    let crossings: Vec<Lit> = (0..6000).map(crossing).collect();
    let guide = ApertureGuide::learn(&crossings).expect("enough crossings");
    let want = std::f64::consts::PI * radius * radius;
    assert!(guide.gain(&crossings) > 0.3 / want, "{}", guide.gain(&crossings));
    let run = |wrong: f64| {
        let mut moments = Moments::default();
        for k in 0..200_000 {
            let mut rng = Rng::new(6, Stream::Check, 1, k);
            let field = rng.pair();
            let ([u, v], density) = guide.draw(field, rng.pair());
            let inside = (u - middle(field)[0]).hypot(v - middle(field)[1]) < radius;
            moments.add(if inside { 1.0 / (density * wrong) } else { 0.0 });
        }
        moments
    };
    let [right, planted] = [1.0, 0.95].map(run);
    assert!((right.mean - want).abs() < 4.0 * right.stderr(), "{} ± {}, want {want}", right.mean, right.stderr());
    assert!((planted.mean - want).abs() > 6.0 * planted.stderr(), "{} {want}", planted.mean);
    let even = want * (1.0 - want);
    assert!(even > 5.0 * right.variance(), "{even} {}", right.variance());
    assert!(ApertureGuide::learn(&crossings[..10]).is_none(), "ten crossings tell nothing");
}

/// A guided aperture comes back from a file as it was, and one that has no tree for each tile is refused.
#[test]
fn a_guided_aperture_is_read_with_care() {
    let lit = |k: usize| Lit { field: [0.5; 2], pupil: [0.4 + 1e-4 * k as f64, 0.5], weight: 1.0 };
    let guide = ApertureGuide::learn(&(0..200).map(lit).collect::<Vec<_>>()).expect("enough crossings");
    let mut value = serde_json::to_value(&guide).expect("plain data");
    assert_eq!(serde_json::from_value::<ApertureGuide>(value.clone()).expect("a guide"), guide);
    for tiles in [[7, 8], [0, 64], [usize::MAX, 2]] {
        value["tiles"] = serde_json::json!(tiles);
        let error =
            serde_json::from_value::<ApertureGuide>(value.clone()).expect_err("tiles without trees").to_string();
        assert!(error.contains("trees"), "{error}");
    }
}
