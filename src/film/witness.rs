//! What a witness saw of a picture: looks at some of its pixels by the most naive way of tracing that can see the light,
//! kept apart from the films that become the picture. What it tells of them: [`judge`].

mod judge;
mod sent;
mod words;

use super::layer::Layer;
use eyebox_base::double_double::Sum;
use eyebox_base::ids::GroupId;
use eyebox_base::lattice::lattice;
use eyebox_base::path::Class;
use eyebox_base::rng::{Rng, Stream};
pub use judge::{Judged, Judgement, Off, judge};
pub use sent::Sent;
use std::collections::{BTreeMap, HashSet};

/// Pixels that a witness looks at, again and again: what a pixel shows then counts against what it shows itself, and not
/// against a picture that differs from place to place.
pub const MOST_PIXELS: usize = 4096;

/// Light that a witness looks for: that of a light group in a layer which somebody else than naive paths has traced.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Watched {
    pub layer: Layer,
    pub group: GroupId,
    pub classes: Vec<Class>,
    /// No look can be brighter, cd/m²; infinite if that is not known.
    #[serde(with = "unbounded")]
    pub brightest: f64,
    /// Looks go to where light was seen to come from, so that many of them tell how bright they get: the brightest kind is not
    /// one that was never met.
    pub aimed: bool,
    /// The share of the light that may come from where no look is aimed: looks hardly ever meet it, and then it is bright.
    pub missed: f64,
}

/// Light that nobody looks for, and why.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Unwatched {
    pub group: GroupId,
    pub class: Class,
    pub because: String,
}

/// What single looks brought.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct Tally {
    /// (cd/m²)²
    pub squares: Sum,
    /// Looks that brought light.
    pub lit: u64,
    /// cd/m²
    pub greatest: f64,
    /// How many were between 2ᵏ and 2ᵏ⁺¹ cd/m².
    octaves: BTreeMap<i32, u64>,
}

impl Tally {
    fn add(&mut self, value: f64) {
        self.squares.add(value * value);
        self.lit += 1;
        self.greatest = self.greatest.max(value);
        *self.octaves.entry(value.abs().log2().floor() as i32).or_default() += 1;
    }

    fn merge(&mut self, other: &Tally) {
        self.squares.merge(other.squares);
        self.lit = self.lit.saturating_add(other.lit);
        self.greatest = self.greatest.max(other.greatest);
        for (octave, count) in &other.octaves {
            let own = self.octaves.entry(*octave).or_default();
            *own = own.saturating_add(*count);
        }
    }

    /// Looks that are among the brightest: within the last three octaves.
    pub fn among_the_brightest(&self) -> u64 {
        self.octaves
            .iter()
            .next_back()
            .map_or(0, |(last, _)| self.octaves.range(last - 2..).map(|(_, count)| count).sum())
    }
}

/// Sums over looks. Each holds two values: as the slides are, and with all of them open.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Witness {
    pub size: [usize; 2],
    pub seed: u64,
    pub watched: Vec<Watched>,
    /// What rays from the eye trace, looked for from the lamps.
    #[serde(default)]
    pub sent: Vec<Sent>,
    pub unwatched: Vec<Unwatched>,
    /// Looks at each of [`pixels`].
    counts: Vec<u64>,
    /// `[pixel][watched]`: luminance, cd/m².
    sums: Vec<[Sum; 2]>,
    /// `[watched]`
    tallies: Vec<[Tally; 2]>,
    /// Counted work of the looks, and of the passes that they stand beside.
    pub work: u64,
    pub beside: u64,
}

/// The pixels that are looked at in a picture of this size, in turn.
pub fn pixels([width, height]: [usize; 2], seed: u64) -> Vec<u32> {
    let all = width * height;
    if all <= MOST_PIXELS {
        return (0..all as u32).collect();
    }
    let mut rng = Rng::new(seed, Stream::Witness, 0, 0);
    let shift = [rng.next_u64(), rng.next_u64()];
    let mut seen = HashSet::new();
    let place = |index: u64| {
        let [u, v] = lattice(shift, index);
        let along = |u: f64, count: usize| ((u * count as f64) as usize).min(count - 1);
        (along(v, height) * width + along(u, width)) as u32
    };
    (0..MOST_PIXELS as u64).map(place).filter(|pixel| seen.insert(*pixel)).collect()
}

impl Witness {
    pub fn new(
        size: [usize; 2],
        seed: u64,
        (watched, sent): (Vec<Watched>, Vec<Sent>),
        unwatched: Vec<Unwatched>,
    ) -> Witness {
        let (slots, rows) = (pixels(size, seed).len(), watched.len());
        Witness {
            size,
            seed,
            watched,
            sent,
            unwatched,
            counts: vec![0; slots],
            sums: vec![[Sum::ZERO; 2]; slots * rows],
            tallies: vec![Default::default(); rows],
            work: 0,
            beside: 0,
        }
    }

    /// Adds a look at pixel number `slot`: per kind of light what it brought, cd/m².
    pub fn add(&mut self, slot: usize, light: &[[f64; 2]]) {
        let rows = self.watched.len();
        self.counts[slot] += 1;
        for (row, values) in light.iter().enumerate() {
            let own = self.sums[slot * rows + row].iter_mut().zip(&mut self.tallies[row]);
            for ((sum, tally), value) in own.zip(values).filter(|(_, value)| **value != 0.0) {
                sum.add(*value);
                tally.add(*value);
            }
        }
    }

    /// Looks at a pixel by number.
    pub fn looks_at(&self, slot: usize) -> u64 {
        self.counts[slot]
    }

    /// Looks at all of them.
    pub fn looks(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// What the looks at a pixel brought of a kind of light.
    pub fn sum(&self, slot: usize, row: usize) -> [f64; 2] {
        self.sums[slot * self.watched.len() + row].map(Sum::value)
    }

    pub fn tally(&self, row: usize) -> &[Tally; 2] {
        &self.tallies[row]
    }

    /// Adds what another witness saw of the same picture; false if it is of another one.
    #[must_use]
    pub fn merge(&mut self, other: &Witness) -> bool {
        let alike = (self.size, self.seed, &self.watched) == (other.size, other.seed, &other.watched);
        let alike = alike
            && self.sent.len() == other.sent.len()
            && self.sent.iter().zip(&other.sent).all(|(own, more)| own.is_like(more));
        if !alike || !self.is_sound() || !other.is_sound() {
            return false;
        }
        self.counts.iter_mut().zip(&other.counts).for_each(|(own, more)| *own = own.saturating_add(*more));
        let sums = self.sums.as_flattened_mut().iter_mut();
        sums.zip(other.sums.as_flattened()).for_each(|(own, more)| own.merge(*more));
        for (own, more) in self.tallies.as_flattened_mut().iter_mut().zip(other.tallies.as_flattened()) {
            own.merge(more);
        }
        self.sent.iter_mut().zip(&other.sent).for_each(|(own, more)| own.merge(more));
        self.work = self.work.saturating_add(other.work);
        self.beside = self.beside.saturating_add(other.beside);
        true
    }

    /// Whether its tables fit each other: a file may hold anything.
    pub fn is_sound(&self) -> bool {
        let (slots, rows) = (self.counts.len(), self.watched.len());
        let [width, height] = self.size;
        let pixels_fit = width.checked_mul(height).is_some_and(|all| u32::try_from(all).is_ok() && all > 0);
        let sums = self.sums.as_flattened().iter().chain(self.tallies.as_flattened().iter().map(|t| &t.squares));
        pixels_fit
            && slots == pixels(self.size, self.seed).len()
            && slots.checked_mul(rows) == Some(self.sums.len())
            && rows == self.tallies.len()
            && self.sent.iter().all(Sent::is_sound)
            && sums.into_iter().all(|sum| sum.is_finite())
    }
}

/// JSON has no infinity: null stands for it.
mod unbounded {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    #[allow(clippy::trivially_copy_pass_by_ref)] // as serde wants it
    pub fn serialize<S: Serializer>(value: &f64, to: S) -> Result<S::Ok, S::Error> {
        value.is_finite().then_some(*value).serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
        Ok(Option::<f64>::deserialize(from)?.unwrap_or(f64::INFINITY))
    }
}
