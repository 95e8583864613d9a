//! Guided emission as data: which lamps, and which of the directions they emit to, have led to light that counts.
//!
//! Directions are cells of the unit square that a lamp's directions are sampled from, so a guide fits any angular
//! distribution. A defensive share keeps every direction possible: the density is known, nothing is biased.

/// Guides for all lamps that an estimator traces.
#[derive(Debug, Clone, PartialEq)]
pub struct Guide {
    lamps: Vec<LampGuide>,
    /// Running sums of `share`.
    steps: Vec<f64>,
}

#[derive(Debug, Clone, PartialEq)]
struct LampGuide {
    /// Probability of starting on this lamp.
    share: f64,
    /// Running sums of the cells' probabilities, row-major, the last is 1.
    cells: Vec<f64>,
}

/// A direction drawn from a guide.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drawn {
    /// Index in the list of lamps that the guide was made for.
    pub lamp: usize,
    /// Point of the lamp's unit square of directions.
    pub uv: [f64; 2],
    /// Density of (lamp, uv) over that of choosing lamps by flux and directions by intensity.
    pub density: f64,
}

impl Guide {
    /// Cells per side of the square.
    pub const SIDE: usize = 48;
    /// Part of the samples that ignore what was learned.
    const DEFENSIVE: f64 = 0.15;
    /// Part of the learned directions that a lamp takes from all lamps together: the LEDs of an array light the same
    /// lens, and the faint paths of one are known from the bright ones of another.
    const POOLED: f64 = 0.4;

    /// What nothing was learned for: lamps by flux, directions by intensity. `flux`: per lamp, lm.
    pub fn unguided(flux: &[f64]) -> Self {
        Guide::learn(flux, &[])
    }

    /// Learns from samples (lamp, uv, contribution ≥ 0), each already divided by the density it was drawn with.
    pub fn learn(flux: &[f64], samples: &[(usize, [f64; 2], f64)]) -> Self {
        let cells = Self::SIDE * Self::SIDE;
        let total_flux: f64 = flux.iter().sum();
        let mut gain = vec![0.0; flux.len()];
        let mut maps = vec![vec![0.0f64; cells]; flux.len()];
        for (lamp, uv, contribution) in samples {
            gain[*lamp] += contribution;
            maps[*lamp][Self::cell(*uv)] += contribution;
        }
        let total_gain: f64 = gain.iter().sum();
        let mut pool = vec![0.0f64; cells];
        for (map, gain) in maps.iter().zip(&gain).filter(|(_, gain)| **gain > 0.0) {
            // Every lamp has the same say, whatever it adds to the picture.
            pool.iter_mut().zip(map).for_each(|(all, own)| *all += own / gain);
        }
        let pool_sum: f64 = pool.iter().sum();
        for (map, gain) in maps.iter_mut().zip(&gain) {
            let (own, pooled) = if *gain > 0.0 { ((1.0 - Self::POOLED) / gain, Self::POOLED) } else { (0.0, 1.0) };
            let pooled = if pool_sum > 0.0 { pooled / pool_sum } else { 0.0 };
            map.iter_mut().zip(&pool).for_each(|(m, all)| *m = *m * own + all * pooled);
        }
        // A few lucky samples must not be mistaken for a map: what was learned counts by its effective number.
        let squares: f64 = samples.iter().map(|sample| sample.2 * sample.2).sum();
        let effective = if squares > 0.0 { total_gain * total_gain / squares } else { 0.0 };
        let learned = (1.0 - Self::DEFENSIVE) * effective / (effective + cells as f64 / 4.0);
        let mut steps = Vec::with_capacity(flux.len());
        let mut sum = 0.0;
        let lamps = (0..flux.len())
            .map(|lamp| {
                let by_gain = if total_gain > 0.0 { gain[lamp] / total_gain } else { 0.0 };
                let share = learned * by_gain + (1.0 - learned) * flux[lamp] / total_flux;
                sum += share;
                steps.push(sum);
                LampGuide { share, cells: Self::cdf(&maps[lamp], learned) }
            })
            .collect();
        Guide { lamps, steps }
    }

    /// Running sums of the smoothed map, mixed with the uniform density.
    fn cdf(map: &[f64], learned: f64) -> Vec<f64> {
        let side = Self::SIDE;
        // A cell takes over a share of its neighbours' light: the pilot leaves holes.
        const CENTRE: f64 = 0.6;
        let smooth = |i: usize, j: usize| {
            let mut sum = CENTRE * map[j * side + i];
            for dj in -1i64..=1 {
                for di in -1i64..=1 {
                    let (x, y) = (i as i64 + di, j as i64 + dj);
                    if (di, dj) != (0, 0) && (0..side as i64).contains(&x) && (0..side as i64).contains(&y) {
                        sum += (1.0 - CENTRE) / 8.0 * map[y as usize * side + x as usize];
                    }
                }
            }
            sum
        };
        let values: Vec<f64> = (0..side * side).map(|cell| smooth(cell % side, cell / side)).collect();
        let total: f64 = values.iter().sum();
        let mut sum = 0.0;
        let mut cdf: Vec<f64> = values
            .iter()
            .map(|value| {
                let by_gain = if total > 0.0 { value / total } else { 0.0 };
                sum += learned * by_gain + (1.0 - learned) / (side * side) as f64;
                sum
            })
            .collect();
        cdf.iter_mut().for_each(|c| *c /= sum);
        cdf
    }

    fn cell([u, v]: [f64; 2]) -> usize {
        let at = |x: f64| ((x * Self::SIDE as f64) as usize).min(Self::SIDE - 1);
        at(v) * Self::SIDE + at(u)
    }

    /// Draws a lamp and a direction from four uniform numbers. `flux`: what the guide was made with.
    pub fn draw(&self, flux: &[f64], u: [f64; 4]) -> Option<Drawn> {
        let total = *self.steps.last()?;
        let lamp = self.steps.partition_point(|step| *step <= u[0] * total).min(self.steps.len() - 1);
        let guide = &self.lamps[lamp];
        let cell = guide.cells.partition_point(|step| *step <= u[1]).min(guide.cells.len() - 1);
        let before = if cell == 0 { 0.0 } else { guide.cells[cell - 1] };
        let side = Self::SIDE as f64;
        let uv = [((cell % Self::SIDE) as f64 + u[2]) / side, ((cell / Self::SIDE) as f64 + u[3]) / side];
        let cell_density = (guide.cells[cell] - before) * side * side;
        let by_flux = flux[lamp] / flux.iter().sum::<f64>();
        Some(Drawn { lamp, uv, density: guide.share / total / by_flux * cell_density })
    }

    /// A number that changes when the guide does.
    pub fn hash(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        for lamp in &self.lamps {
            hasher.update(&lamp.share.to_le_bytes());
            for cell in &lamp.cells {
                hasher.update(&cell.to_le_bytes());
            }
        }
        hasher.finalize().to_hex().to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::rng::{Rng, Stream};

    /// Integrals over lamps and directions are the same, guided or not, and far less noisy where the guide points.
    #[test]
    fn a_guide_is_unbiased_and_helps() {
        let flux = [1.0, 3.0];
        // Only lamp 0 counts, in a small spot.
        let gain = |lamp: usize, [u, v]: [f64; 2]| {
            if lamp == 0 && (u - 0.3).hypot(v - 0.6) < 0.05 { 1.0 } else { 0.0 }
        };
        let want = std::f64::consts::PI * 0.05f64.powi(2) * 0.25;
        let mut rng = Rng::new(2, Stream::Check, 0, 0);
        let mut run = |guide: &Guide, count: usize| {
            let mut moments = crate::base::stats::Moments::default();
            let mut seen = Vec::new();
            for _ in 0..count {
                let u = [rng.uniform(), rng.uniform(), rng.uniform(), rng.uniform()];
                let drawn = guide.draw(&flux, u).expect("there are lamps");
                let value = gain(drawn.lamp, drawn.uv) / drawn.density;
                moments.add(value);
                if value > 0.0 {
                    seen.push((drawn.lamp, drawn.uv, value));
                }
            }
            (moments, seen)
        };
        let (plain, seen) = run(&Guide::unguided(&flux), 1_000_000);
        assert!((plain.mean - want).abs() < 4.0 * plain.stderr());
        let (guided, _) = run(&Guide::learn(&flux, &seen), 100_000);
        assert!((guided.mean - want).abs() < 4.0 * guided.stderr(), "{} {want}", guided.mean);
        assert!(plain.variance() > 50.0 * guided.variance(), "{} {}", plain.variance(), guided.variance());
    }
}
