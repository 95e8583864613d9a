use super::*;
use crate::ledger::Ledger;
use crate::run::Dealt;
use eyebox_base::ids::GroupId;
use eyebox_base::stats::Moments;
use eyebox_film::accumulate::{Components, Light, PlaneKey};
use eyebox_film::layer::Layer;
use eyebox_film::unseen::Unseen;

const SIZE: [usize; 2] = [24, 20];

/// A picture of which pixel after pixel is made by chance.
struct Made {
    films: Films,
    seed: u64,
    value: fn(usize, f64) -> f64,
}

impl Made {
    fn new(seed: u64, value: fn(usize, f64) -> f64) -> Made {
        let plane = PlaneKey { layer: Layer::Direct, group: GroupId(0), takes: 0 };
        let film = Film::new(SIZE[0], SIZE[1], vec![plane], Components::Luminance, Sampling::PerPass);
        let films = vec![(Estimator::Backward, film, Ledger::new(0))];
        let films = Films { films, first: 0, passes: 0, dealt: Dealt::default(), witness: None };
        let mut made = Made { films, seed, value };
        made.pass(0, 2);
        made
    }

    fn pass(&mut self, first: u64, count: u64) {
        let (seed, value) = (self.seed, self.value);
        let (_, film, ledger) = &mut self.films.films[0];
        for (y, mut row) in film.rows() {
            for (x, pass) in (0..SIZE[0]).flat_map(|x| (first..first + count).map(move |pass| (x, pass))) {
                let pixel = y * SIZE[0] + x;
                if row.wants(x, pass) {
                    let u = Rng::new(seed, Stream::Check, pass, pixel as u64).uniform();
                    row.add_pass(x, pass, &[Light::ONE.scaled(value(pixel, u))]);
                    ledger.work += 1;
                }
            }
        }
        film.close(first, count);
    }

    fn fill(&mut self) {
        while let Some(missing) = self.films.films[0].1.missing() {
            self.pass(missing.start, missing.end - missing.start);
        }
        self.films.dealt.rounds += 1;
    }

    fn rounds(&mut self, rounds: u64) {
        for _ in 0..rounds {
            aim(&mut self.films, &|_| true, None, self.seed);
            self.fill();
        }
    }

    fn film(&self) -> &Film {
        &self.films.films[0].1
    }

    fn sum(&self) -> f64 {
        (0..SIZE[0] * SIZE[1]).map(|pixel| self.film().mean(pixel, 0).value).sum()
    }
}

/// Light that one pass in ten meets, in every seventh pixel: passes that have missed it say that there is none.
fn rare(pixel: usize, u: f64) -> f64 {
    if pixel.is_multiple_of(7) && u < 0.1 { 10.0 } else { 1.0 }
}

/// An upright edge.
fn edge(pixel: usize, u: f64) -> f64 {
    match (pixel % SIZE[0]).cmp(&9) {
        std::cmp::Ordering::Less => 0.0,
        std::cmp::Ordering::Equal => 2.0 * u,
        std::cmp::Ordering::Greater => 1.0,
    }
}

/// What pixels hold does not depend on what they have shown, so that the picture has the mean that it should have. If each
/// pixel decided by its own passes, it would be too dark by far.
#[test]
fn dealing_passes_out_brings_no_bias() {
    let pixels = SIZE[0] * SIZE[1];
    let truth: f64 = (0..pixels).map(|pixel| if pixel % 7 == 0 { 1.9 } else { 1.0 }).sum();
    let (mut ours, mut own) = (Moments::default(), Moments::default());
    for seed in 0..400 {
        let mut made = Made::new(seed, rare);
        made.rounds(6);
        ours.add(made.sum());
        let mut made = Made::new(seed, rare);
        for _ in 0..6 {
            for pixel in 0..pixels {
                let varies = made.film().variance(pixel, 0) > 0.0;
                let map = made.films.films[0].1.sample_map_mut();
                let passes = if varies { 2 * map.made(pixel) } else { 0 };
                map.want(pixel, passes);
            }
            made.fill();
        }
        own.add(made.sum());
    }
    assert!((ours.mean - truth).abs() < 4.0 * ours.stderr(), "{} ± {}, {truth}", ours.mean, ours.stderr());
    assert!((own.mean - truth).abs() > 8.0 * own.stderr(), "{} ± {}, {truth}", own.mean, own.stderr());
}

/// An edge gets passes, what is even does not, and the goal is reached for less work.
#[test]
fn passes_go_to_edges() {
    let mut made = Made::new(3, edge);
    made.rounds(12);
    let map = made.film().sample_map().expect("pixels have passes of their own");
    for pixel in 0..SIZE[0] * SIZE[1] {
        let near = (pixel % SIZE[0]).abs_diff(9) <= 1;
        assert_eq!(map.made(pixel) > 16, near, "{pixel}: {}", map.made(pixel));
    }
    let error: f64 = (0..SIZE[0] * SIZE[1]).map(|pixel| made.film().variance(pixel, 0)).sum();
    let even = 20.0 / 3.0 / map.mean();
    assert!(error < 0.3 * even, "{error} {even}");
}

/// Goals are met by no more than they need.
#[test]
fn goals_end_a_round() {
    let noise = |made: &Made| (0..SIZE[0] * SIZE[1]).map(|pixel| made.film().variance(pixel, 0)).sum::<f64>();
    let mut made = Made::new(5, edge);
    made.rounds(5);
    let (before, mean) = (noise(&made), made.film().mean_passes());
    deal(&mut made.films, &|_| true, Some(0.97 * before), 5);
    made.fill();
    assert!(noise(&made) < before && made.film().mean_passes() < 1.1 * mean);
}

/// What nobody foresees gets passes at random, so that a single pixel is not left behind for ever.
#[test]
fn single_pixels_get_theirs_in_time() {
    let mut made = Made::new(2, |pixel, u| if pixel == 230 { u } else { 1.0 });
    made.rounds(12);
    assert!(made.film().passes_of(230) >= 64, "{}", made.film().passes_of(230));
}

/// Whatever they have shown, pixels have a share of what the others had before the last round, and estimators one of the work.
#[test]
fn nobody_is_left_behind() {
    let mut made = Made::new(3, edge);
    let mut still = Film::new(SIZE[0], SIZE[1], made.film().planes.clone(), Components::Luminance, Sampling::PerPass);
    still.passes = 2;
    let mut ledger = Ledger::new(0);
    ledger.work = 2;
    made.films.films.push((Estimator::Photon, still, ledger));
    for _ in 0..14 {
        aim(&mut made.films, &|_| true, None, 3);
        let (_, film, ledger) = &mut made.films.films[1];
        ledger.work += film.wanted.saturating_sub(film.passes) * 10;
        film.passes = film.wanted.max(film.passes);
        made.fill();
    }
    let map = made.film().sample_map().expect("pixels have passes of their own");
    assert!(map.mean() > 40.0 && map.range()[0] as f64 >= map.mean() / 32.0, "{:?} {}", map.range(), map.mean());
    let [ours, still] = [0, 1].map(|film| made.films.films[film].2.work as f64);
    assert!(still > (ours + still) / 40.0, "{ours} {still}");
}

/// Where rays may have missed more than what is asked for allows, all pixels get passes until that is no longer so.
#[test]
fn what_may_be_missed_asks_for_passes() {
    let mut made = Made::new(3, |_, _| 1.0);
    let (_, film, ledger) = made.films.films.remove(0);
    let unseen = Unseen::new(480.0, 1.0, &[false; SIZE[0] * SIZE[1]], Vec::new());
    made.films.films.push((Estimator::Backward, film.with_unseen(Some(unseen)), ledger));
    made.films.passes = 2;
    let stated = |made: &Made| made.films.relative_error().unwrap();
    // 2 · 480 / (480 · passes)
    assert!((stated(&made) - 1.0).abs() < 1e-9, "{}", stated(&made));
    for _ in 0..8 {
        aim(&mut made.films, &|_| true, Some(0.1), 3);
        made.fill();
    }
    // Half of the error may be that.
    let least = made.film().sample_map().map_or(made.film().passes, |map| map.range()[0]);
    assert!(least == 64 || stated(&made) <= 0.05, "{least} {}", stated(&made));
}

/// Films without any error get passes, too: a run that waits for another limit goes on.
#[test]
fn even_pictures_go_on() {
    let mut made = Made::new(2, |_, _| 1.0);
    made.rounds(3);
    assert_eq!(made.film().sample_map().map(|map| map.range()), Some([16, 16]));
}

/// The parts of a first pass are all of the picture, and those up to a power of four a coarser grid of it.
#[test]
fn parts_go_from_coarse_to_fine() {
    for side in [2usize, 8] {
        let mut seen = vec![0; side * side];
        for (x, y) in (0..side).flat_map(|x| (0..side).map(move |y| (x, y))) {
            seen[part_of([x + side, y + 3 * side], side)] += 1;
            for k in 0..=side.trailing_zeros() {
                let step = side >> k;
                let on_grid = x.is_multiple_of(step) && y.is_multiple_of(step);
                assert_eq!(part_of([x, y], side) < 1 << (2 * k), on_grid, "{x} {y} {k}");
            }
        }
        assert!(seen.iter().all(|count| *count == 1));
    }
}
