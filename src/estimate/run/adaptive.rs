//! Where the next passes go: to the pixels, and to the estimators, whose error they lessen most for their work.
//!
//! A round doubles the passes of some pixels. Which ones is a function of counted work and of sums, never of time. What a
//! pixel gets is decided by what its *neighbours* have shown, never by its own light: if a pixel stopped where its own
//! passes happen to agree, those that have missed a bright spot would stop and stay dark, and the picture with them. As it
//! is, a pixel's mean and its stated variance are those of so many passes, however many they are.
//!
//! Neighbours know where a picture has edges, for edges go on from pixel to pixel. What they know nothing of, light in few
//! single pixels, is spread over blocks of pixels, and what even these don't foresee gets passes of pixels at random.

use super::Films;
use super::tuning::adaptive::{AIM, AIMED, ALONE, BLOCK, FLOOR, FLOOR_OF_WORK, FORESEEN, LEAST_DRAWN, SHARE_OF_WORK};
use eyebox_base::parallel;
use eyebox_base::rng::{Rng, Stream};
use eyebox_film::accumulate::{Film, Sampling};
use eyebox_film::plan::Estimator;
use rayon::slice::ParallelSliceMut as _;

/// Something whose passes may be doubled.
struct Candidate {
    film: usize,
    /// None: all pixels of the film, which share what a pass is made of.
    pixel: Option<usize>,
    /// What doubling takes off the squared error, (cd/m²)², and what it costs, counted work.
    gain: f64,
    work: f64,
}

/// What is known of a film whose pixels have sequences of their own.
struct Variances {
    /// `[pixel]`: variance of one pass as others foresee it, (cd/m²)².
    foreseen: Vec<f64>,
    /// Share of the film's squared error that nobody foresees.
    unforeseen: f64,
}

/// Wants passes for another round. `traced`: whether a pixel is looked at at all; `error`: the relative one that is to be reached;
/// none: as much as the round's work can do. Where no error is known, all get as many again.
pub fn aim(films: &mut Films, traced: &(dyn Fn(usize) -> bool + Sync), error: Option<f64>, seed: u64) {
    deal(films, traced, error.and_then(|error| films.goal(error)), seed);
    raise(films, traced, error, seed);
}

/// Passes for where they lessen the error. `goal`: the squared error, (cd/m²)², that is to be reached.
fn deal(films: &mut Films, traced: &(dyn Fn(usize) -> bool + Sync), goal: Option<f64>, seed: u64) {
    let round = films.dealt.rounds;
    let work: Vec<f64> = films.films.iter().map(|(_, _, ledger)| ledger.work.max(1) as f64).collect();
    let budget = SHARE_OF_WORK * work.iter().sum::<f64>();
    let (mut candidates, mut at_random) = (Vec::new(), Vec::new());
    let mut noise = 0.0;
    for (film, work) in (0..films.films.len()).zip(&work) {
        let (estimator, own, _) = &films.films[film];
        let pixels = 0..own.width * own.height;
        let saved = super::saved(*estimator, own);
        let all = own.planes.len();
        let doubts = own.doubts();
        let doubt = |pixel: usize| doubts.as_ref().map_or(0.0, |doubts| doubts[pixel]);
        let variance = |pixel: usize| (saved.of(own.passes_of(pixel)) * own.variance(pixel, all)).max(doubt(pixel));
        let error = pixels.clone().filter(|pixel| traced(*pixel)).map(variance).sum::<f64>();
        noise += error;
        if !has_own_sequences(*estimator, own) {
            candidates.push(Candidate { film, pixel: None, gain: error / 2.0, work: *work });
            continue;
        }
        let passes: f64 = pixels.clone().filter(|pixel| traced(*pixel)).map(|pixel| own.passes_of(pixel) as f64).sum();
        let per_pass = work / passes.max(1.0);
        let Variances { foreseen, unforeseen } = variances(own, doubts.as_deref(), traced);
        candidates.extend(pixels.filter(|pixel| traced(*pixel)).map(|pixel| {
            let made = own.passes_of(pixel) as f64;
            let gain = saved.of(own.passes_of(pixel)) * foreseen[pixel] / (2.0 * made);
            Candidate { film, pixel: Some(pixel), gain, work: made * per_pass }
        }));
        if unforeseen > 0.0 {
            at_random.push((film, unforeseen * error, per_pass, foreseen));
        }
    }
    let unforeseen = if noise > 0.0 { at_random.iter().map(|(_, error, ..)| error).sum::<f64>() / noise } else { 0.0 };
    let enough = goal.map_or(f64::INFINITY, |goal| noise - AIM * goal);
    choose(films, candidates, enough * (1.0 - unforeseen), budget * (1.0 - unforeseen));
    for (film, error, per_pass, foreseen) in at_random {
        // Its share of what nobody foresees is the share of the round's work that goes there.
        let passes = budget * (error / noise) / per_pass;
        draw(&mut films.films[film].1, (traced, &foreseen), passes, (seed, round, film));
    }
    if films.films.iter().all(|(_, film, _)| film.missing().is_none()) {
        for (estimator, film, _) in &mut films.films {
            if has_own_sequences(*estimator, film) {
                draw(film, (traced, &[]), f64::INFINITY, (seed, round, 0));
            } else {
                film.wanted = film.passes.saturating_mul(2);
            }
        }
    }
}

/// Whatever passes have shown, no pixel is left behind for ever, nor an estimator: what they may not have met is not known to them.
/// This is a function of numbers of passes and of work, and where light that no ray has met may be more than the error that is asked for
/// leaves room for (or than half of what is stated), all pixels get more.
fn raise(films: &mut Films, traced: &(dyn Fn(usize) -> bool + Sync), error: Option<f64>, seed: u64) {
    let round = films.dealt.rounds;
    let works: Vec<u64> = films.films.iter().map(|(_, _, ledger)| ledger.work).collect();
    let least_work = FLOOR_OF_WORK * works.iter().sum::<u64>() as f64;
    let asked: Vec<u64> = films.films.iter().map(|(_, film, _)| films.passes_to_miss_less(film, error)).collect();
    for (number, (estimator, film, _)) in films.films.iter_mut().enumerate() {
        let starves = (works[number] as f64) < least_work;
        if !has_own_sequences(*estimator, film) {
            if starves && film.missing().is_none() {
                film.wanted = film.passes.saturating_mul(2);
            }
            continue;
        }
        if starves && film.missing().is_none() {
            draw(film, (traced, &[]), f64::INFINITY, (seed, round, 8 + number));
        }
        let made = || (0..film.width * film.height).filter(|pixel| traced(*pixel)).map(|pixel| film.passes_of(pixel));
        let (fewest, all, count) = made().fold((u64::MAX, 0u64, 0u64), |(fewest, all, count), own| {
            (fewest.min(own), all.saturating_add(own), count + 1)
        });
        if count == 0 {
            continue;
        }
        // Powers of two: pixels of many different numbers of passes tell little of what evenness saves.
        let share = (FLOOR * all as f64 / count as f64) as u64;
        let share = share.checked_ilog2().map_or(0, |bits| 1 << bits);
        let asked = asked[number].checked_next_power_of_two().unwrap_or(u64::MAX).min(fewest.saturating_mul(2));
        let floor = share.max(asked);
        if floor <= fewest {
            continue;
        }
        let map = film.sample_map_mut();
        for pixel in 0..map.pixels() {
            // Those that nobody looks at cost nothing, and are not to be taken for the fewest.
            map.want(pixel, map.wanted(pixel).max(floor));
        }
    }
}

/// Whether each pixel has a sequence of its own, so that some may have more passes than others.
pub fn has_own_sequences(estimator: Estimator, film: &Film) -> bool {
    match (estimator, film.sampling) {
        (Estimator::Backward | Estimator::Manifold, Sampling::PerPass) => true,
        (Estimator::Backward | Estimator::Manifold, Sampling::PerScramble { .. }) => false,
        (Estimator::Forward | Estimator::Photon, _) => false,
    }
}

/// Which part of a picture a pixel belongs to, of `side`² parts from coarse to fine: each is spread evenly over the picture, and
/// so are those up to any power of four.
pub fn part_of([x, y]: [usize; 2], side: usize) -> usize {
    let (mut part, mut bit, mut weight) = (0, side / 2, 1);
    while bit > 0 {
        // The second of four parts lies across from the first, the others beside it.
        let [right, down] = [x, y].map(|at| usize::from(at & bit != 0));
        part += weight * (2 * (right ^ down) + down);
        (bit, weight) = (bit / 2, weight * 4);
    }
    part
}

/// Doubles the passes of the best candidates, until that is likely to take `enough` off the squared error or as much work as
/// `budget`; of one at least.
fn choose(films: &mut Films, mut candidates: Vec<Candidate>, enough: f64, budget: f64) {
    candidates.retain(|candidate| candidate.gain > 0.0);
    let worth = |candidate: &Candidate| candidate.gain / candidate.work;
    let order = |candidate: &Candidate| (candidate.film, candidate.pixel);
    candidates.par_sort_unstable_by(|a, b| worth(b).total_cmp(&worth(a)).then(order(a).cmp(&order(b))));
    let (mut gain, mut work) = (0.0, 0.0);
    for candidate in &candidates {
        if work > 0.0 && (gain >= enough || work + candidate.work > budget) {
            break;
        }
        gain += candidate.gain;
        work += candidate.work;
        let film = &mut films.films[candidate.film].1;
        match candidate.pixel {
            None => film.wanted = film.passes.saturating_mul(2),
            Some(pixel) => {
                let map = film.sample_map_mut();
                map.want(pixel, map.made(pixel).saturating_mul(2));
            }
        }
    }
}

/// Doubles the passes of pixels that are drawn by chance, for `passes` passes of single pixels: the more likely the more others
/// foresee of theirs, for light in single pixels is seldom far from other edges, the fewer passes they have, and where the plan has rays aimed
/// at lamps. None is left out.
fn draw(
    film: &mut Film,
    (traced, foreseen): (&dyn Fn(usize) -> bool, &[f64]),
    passes: f64,
    (seed, round, number): (u64, u64, usize),
) {
    let least = LEAST_DRAWN * foreseen.iter().sum::<f64>() / foreseen.len().max(1) as f64;
    let unseen = film.unseen().filter(|_| passes.is_finite());
    let weight = |pixel: usize| {
        let of = foreseen.get(pixel).map_or(1.0, |own| own + least);
        let aimed = unseen.is_some_and(|unseen| unseen.is_aimed(pixel));
        (if of > 0.0 { of.sqrt() } else { 1.0 }) * if aimed { AIMED } else { 1.0 }
    };
    let mut order: Vec<(f64, usize)> = (0..film.width * film.height)
        .filter(|pixel| traced(*pixel))
        .map(|pixel| {
            let round = round.wrapping_mul(16).wrapping_add(number as u64);
            let u = Rng::new(seed, Stream::Adaptive, round, pixel as u64).uniform();
            // P. S. Efraimidis and P. G. Spirakis, "Weighted random sampling with a reservoir", Inf. Process. Lett. 97, 2006.
            (-(1.0 - u).ln() * film.passes_of(pixel) as f64 / weight(pixel), pixel)
        })
        .collect();
    order.par_sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let map = film.sample_map_mut();
    let mut left = passes;
    for (_, pixel) in order {
        let made = map.made(pixel);
        left -= made as f64;
        if left < 0.0 {
            return;
        }
        map.want(pixel, made.saturating_mul(2));
    }
}

/// What the others of a film's pixels say of each.
fn variances(film: &Film, doubts: Option<&[f64]>, traced: &(dyn Fn(usize) -> bool + Sync)) -> Variances {
    let (width, height) = (film.width, film.height);
    let all = film.planes.len();
    let of_pass = |pixel: usize| {
        let variance = film.variance(pixel, all).max(doubts.map_or(0.0, |doubts| doubts[pixel]));
        if traced(pixel) { variance * film.passes_of(pixel) as f64 } else { 0.0 }
    };
    let own: Vec<f64> = parallel::map(width * height, &of_pass);
    let near: Vec<f64> = parallel::map(width * height, &|pixel| of_neighbours(&own, pixel, [width, height]));
    // What the neighbours of a pixel do not lead one to expect.
    let beyond: Vec<f64> = own.iter().zip(&near).map(|(own, near)| (own - FORESEEN * near).max(0.0)).collect();
    let blocks = Blocks::new(&beyond, [width, height]);
    let of_block: Vec<[f64; 2]> = parallel::map(width * height, &|pixel| blocks.around(&beyond, pixel));
    let foreseen = near.iter().zip(&of_block).map(|(near, [mean, _])| near + mean).collect();
    let (mut error, mut alone) = (0.0, 0.0);
    for pixel in 0..width * height {
        let per_pass = 1.0 / film.passes_of(pixel).max(1) as f64;
        error += own[pixel] * per_pass;
        if of_block[pixel][1] < ALONE {
            alone += beyond[pixel] * per_pass;
        }
    }
    Variances { foreseen, unforeseen: if error > 0.0 { (alone / error).min(1.0) } else { 0.0 } }
}

/// Mean over the up to eight neighbours of a pixel.
fn of_neighbours(values: &[f64], pixel: usize, [width, height]: [usize; 2]) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for other in around(pixel, [width, height]).filter(|other| *other != pixel) {
        sum += values[other];
        count += 1.0;
    }
    if count > 0.0 { sum / count } else { 0.0 }
}

/// A pixel and its up to eight neighbours.
fn around(pixel: usize, [width, height]: [usize; 2]) -> impl Iterator<Item = usize> {
    let (x, y) = (pixel % width, pixel / width);
    let rows = y.saturating_sub(1)..(y + 2).min(height);
    rows.flat_map(move |y| (x.saturating_sub(1)..(x + 2).min(width)).map(move |x| y * width + x))
}

/// Sums over blocks of pixels.
struct Blocks {
    size: [usize; 2],
    /// Sum, number of pixels, and of those that are above 0.
    sums: Vec<[f64; 3]>,
}

impl Blocks {
    fn new(values: &[f64], size: [usize; 2]) -> Self {
        let mut sums = vec![[0.0; 3]; size[0].div_ceil(BLOCK) * size[1].div_ceil(BLOCK)];
        let blocks = Blocks { size, sums: Vec::new() };
        for (pixel, value) in values.iter().enumerate() {
            let sum = &mut sums[blocks.of(pixel)];
            *sum = [sum[0] + value, sum[1] + 1.0, sum[2] + if *value > 0.0 { 1.0 } else { 0.0 }];
        }
        Blocks { sums, ..blocks }
    }

    fn of(&self, pixel: usize) -> usize {
        let [width, _] = self.size;
        pixel / width / BLOCK * width.div_ceil(BLOCK) + pixel % width / BLOCK
    }

    /// The mean over a pixel's block, and how many there are above 0, without the pixel and its neighbours, for whose values
    /// the pixel counts.
    fn around(&self, values: &[f64], pixel: usize) -> [f64; 2] {
        let [mut sum, mut count, mut lit] = self.sums[self.of(pixel)];
        for other in around(pixel, self.size).filter(|other| self.of(*other) == self.of(pixel)) {
            sum -= values[other];
            count -= 1.0;
            lit -= if values[other] > 0.0 { 1.0 } else { 0.0 };
        }
        // What rounding leaves of a sum of which all was taken is nothing.
        [if count > 0.0 && lit > 0.0 { (sum / count).max(0.0) } else { 0.0 }, lit]
    }
}

#[cfg(test)]
#[path = "adaptive_tests.rs"]
mod tests;
