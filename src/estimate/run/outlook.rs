//! Whether a run will come to the error that was asked for, and what holds it up.

use super::tuning::outlook::{LEAST, LEAST_WORK, MOST_WORK, SPAN};
use super::{Films, Noise, saved};
use eyebox_film::plan::Estimator;
use eyebox_film::totals::{ACROSS, DOWN, part_of};

/// The errors at the ends of rounds, by counted work: no clock is asked.
#[derive(Default)]
pub(super) struct Outlook(Vec<(f64, f64)>);

impl Outlook {
    /// Notes an error, and says whether `wanted` would take more work than is done unasked.
    pub fn is_too_far(&mut self, work: u64, error: Option<f64>, wanted: f64) -> bool {
        let (work, Some(error)) = (work as f64, error) else { return work as f64 >= MOST_WORK };
        let before = self.0.iter().rev().find(|(own, _)| SPAN * own <= work).copied();
        self.0.push((work, error));
        if work < LEAST_WORK {
            return false;
        }
        // Errors fall as a power of the work.
        let power = before.map_or(0.5, |(own, then)| (then / error).ln() / (work / own).ln()).max(LEAST);
        work * (error / wanted).powf(1.0 / power) >= MOST_WORK
    }
}

/// What most of a run's squared error is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum HoldUp {
    /// The noise of an estimator: its share of the squared error, and the part of the picture that has most of it, with the share there.
    Noise { estimator: Estimator, share: f64, part: usize, there: f64 },
    /// That photons are gathered within a radius.
    Blur { share: f64 },
    /// Light that rays from the eye have not met.
    Missed { share: f64 },
}

impl HoldUp {
    /// In words.
    pub fn text(&self, [width, height]: [usize; 2]) -> String {
        let percent = |share: f64| format!("{:.0} %", 100.0 * share);
        match self {
            HoldUp::Noise { estimator, share, part, there } => {
                let (column, row) = ((part - 1) % ACROSS, (part - 1) / ACROSS);
                let range = |k: usize, parts: usize, all: usize| {
                    format!("{} to {}", (k * all).div_ceil(parts), ((k + 1) * all).div_ceil(parts).max(1) - 1)
                };
                format!(
                    "{} of the squared error is noise of {}, {} of that in columns {}, rows {}",
                    percent(*share),
                    estimator.name(),
                    percent(*there),
                    range(column, ACROSS, width),
                    range(row, DOWN, height)
                )
            }
            HoldUp::Blur { share } => {
                format!(
                    "{} of the squared error is that photons are gathered within a radius, which shrinks slowly",
                    percent(*share)
                )
            }
            HoldUp::Missed { share } => format!(
                "{} of the squared error is what rays from the eye may have missed of small bright lamps",
                percent(*share)
            ),
        }
    }
}

impl Films {
    /// What holds a run up; none where no error is stated.
    pub fn hold_up(&self) -> Option<HoldUp> {
        let sums: Noise = self.noise()?;
        let (noise, signal) = super::likely_noise(&sums)?;
        let (blur, missed) = (self.blur2(), self.missed(&sums).powi(2) * signal);
        let all = noise + blur + missed;
        if blur > noise.max(missed) {
            return Some(HoldUp::Blur { share: blur / all });
        }
        if missed > noise {
            return Some(HoldUp::Missed { share: missed / all });
        }
        let of_film = |(estimator, film, _): &(Estimator, eyebox_film::accumulate::Film, crate::ledger::Ledger)| {
            let (saved, doubts) = (saved(*estimator, film), film.doubts());
            let mut parts = [0.0; 1 + ACROSS * DOWN];
            for pixel in 0..film.width * film.height {
                let variance = saved.of(film.passes_of(pixel)) * film.variance(pixel, film.planes.len());
                let variance = variance.max(doubts.as_ref().map_or(0.0, |doubts| doubts[pixel]));
                parts[0] += variance;
                parts[part_of([pixel % film.width, pixel / film.width], [film.width, film.height])] += variance;
            }
            (*estimator, parts)
        };
        let (estimator, parts) = self.films.iter().map(of_film).max_by(|a, b| a.1[0].total_cmp(&b.1[0]))?;
        let part = (1..parts.len()).max_by(|a, b| parts[*a].total_cmp(&parts[*b]))?;
        let share = parts[0] / sums.noise * noise / all;
        Some(HoldUp::Noise { estimator, share, part, there: parts[part] / parts[0] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Errors that fall as the root of the work, and such as hardly fall.
    #[test]
    fn what_is_too_far_is_seen() {
        let run = |power: f64, wanted: f64| {
            let mut outlook = Outlook::default();
            let mut work = 1e6;
            loop {
                work *= 1.5;
                let error = (work / 1e6f64).powf(-power);
                if error <= wanted {
                    return None;
                }
                if outlook.is_too_far(work as u64, Some(error), wanted) {
                    return Some(work);
                }
            }
        };
        assert_eq!(run(0.5, 0.02), None);
        assert!(run(0.5, 1e-3).is_some_and(|work| work < 1.5 * LEAST_WORK));
        assert!(run(1e-3, 0.5).is_some_and(|work| work < 1.5 * LEAST_WORK));
        let mut outlook = Outlook::default();
        assert!(!outlook.is_too_far(1000, None, 0.1) && outlook.is_too_far(u64::MAX, None, 0.1));
    }
}
