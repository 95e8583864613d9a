//! Which paths of a pass start, and the numbers that each starts with.

use super::tuning::shots::CHUNK;
use eyebox_base::rng::{Rng, Stream};
use eyebox_base::sobol::Sobol;
use eyebox_film::guide::Point;
use eyebox_film::replicates::REPLICATES;
use std::ops::Range;

/// What the numbers are that a path starts with: its lamp, its place there and its direction. All later ones are random.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Starts {
    /// Independent random numbers.
    Random,
    /// Even points: path i of each pass belongs to scramble i mod [`REPLICATES`], whose sequence goes on from pass to pass.
    Scrambles,
    /// Even points, with a scramble of its own for each pass.
    OfPass,
}

/// Which paths: their stream of random numbers, the pass, and how many share the lamps' flux.
#[derive(Debug, Clone, Copy)]
pub struct Shots {
    pub seed: u64,
    pub stream: Stream,
    pub pass: u64,
    pub paths: u64,
    pub starts: Starts,
}

/// The even points of a pass.
pub(super) struct Points {
    pub(super) shots: Shots,
    sobols: [Sobol; REPLICATES],
}

impl Points {
    pub(super) fn new(shots: Shots) -> Self {
        let first = match shots.starts {
            Starts::Random | Starts::Scrambles => 0,
            Starts::OfPass => shots.pass,
        };
        let sobol = |s: usize| Sobol::new(shots.seed, shots.stream, first.wrapping_add(s as u64));
        Points { shots, sobols: std::array::from_fn(sobol) }
    }

    /// What path `sample` starts with: the number that chooses the lamp, and the point of its cube.
    pub(super) fn of(&self, sample: u64, rng: &mut Rng) -> (f64, Point) {
        let count = REPLICATES as u64;
        let [u, v, a, b, lamp] = match self.shots.starts {
            Starts::Random => std::array::from_fn(|_| rng.uniform()),
            Starts::Scrambles => {
                let first = self.shots.pass.wrapping_mul(self.shots.paths.div_ceil(count));
                self.sobols[(sample % count) as usize].point(first.wrapping_add(sample / count))
            }
            Starts::OfPass => self.sobols[0].point(sample),
        };
        // The first two coordinates of a sequence are its best, and the picture depends most on the direction.
        (lamp, [a, b, u, v])
    }
}

impl Shots {
    /// Number of chunks of a pass of `paths` paths.
    pub fn chunks(paths: u64) -> u64 {
        paths.div_ceil(CHUNK)
    }

    pub(super) fn samples(&self, chunk: u64) -> Range<u64> {
        chunk * CHUNK..((chunk + 1) * CHUNK).min(self.paths)
    }
}
