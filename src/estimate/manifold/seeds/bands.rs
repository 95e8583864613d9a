//! Connections for each pass: where passes have wavelengths of their own, glass bends each of them differently, so starts
//! that were solved for at one wavelength lead the solver astray at others.

use super::connections::{Connections, index_of};
use super::tuning::bands::BANDS;
use eyebox_base::colour::hero;
use eyebox_base::parallel;
use eyebox_film::specular_chain::Connection;
use eyebox_world::World;
use eyebox_world::mode::{Mode, wavelengths_change};
use eyebox_world::optics::Optics;
use std::sync::Arc;

/// The connections of a plan, by the wavelength that decides where paths go.
#[derive(Debug, Clone)]
pub struct Bands {
    /// Each with the wavelength in nm up to which it is used, rising.
    sets: Vec<(f64, Arc<Connections>)>,
}

impl Default for Bands {
    fn default() -> Self {
        Bands::from(Arc::default())
    }
}

/// The same for all wavelengths.
impl From<Arc<Connections>> for Bands {
    fn from(all: Arc<Connections>) -> Self {
        Bands { sets: vec![(f64::INFINITY, all)] }
    }
}

impl Bands {
    /// Solves for the starts of each band, or at the wavelengths of `optics` where all passes have those.
    pub fn new<M: Mode>(world: &World, optics: &Optics<M>, connections: &[Connection]) -> Bands {
        if !wavelengths_change::<M>() || connections.is_empty() {
            return Bands::from(Arc::new(Connections::new(world, &index_of(optics), connections)));
        }
        let at = |share: f64| hero(share, 0, 1).0;
        let set = |band: usize| {
            let indices = world.indices_at(at((band as f64 + 0.5) / BANDS as f64));
            let index = |part: Option<u32>| part.map_or(1.0, |part| indices[part as usize]);
            let last = band + 1 == BANDS;
            let up_to = if last { f64::INFINITY } else { at((band + 1) as f64 / BANDS as f64) };
            (up_to, Arc::new(Connections::new(world, &index, connections)))
        };
        Bands { sets: parallel::map(BANDS, &set) }
    }

    /// Those for the wavelengths of a pass.
    pub fn of<M: Mode>(&self, optics: &Optics<M>) -> &Connections {
        let at = self.sets.partition_point(|(up_to, _)| *up_to <= optics.nm(0)).min(self.sets.len() - 1);
        &self.sets[at].1
    }

    /// Those in the middle: for what has to be the same in all passes.
    pub fn middle(&self) -> &Connections {
        &self.sets[self.sets.len() / 2].1
    }

    pub fn is_empty(&self) -> bool {
        self.sets.iter().all(|(_, connections)| connections.is_empty())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each wavelength has one set, and passes come to all of them alike.
    #[test]
    fn bands_part_the_range_evenly() {
        let at = |share: f64| hero(share, 0, 1).0;
        let edges: Vec<f64> = (1..BANDS).map(|band| at(band as f64 / BANDS as f64)).collect();
        assert!(edges.windows(2).all(|pair| pair[0] < pair[1]), "{edges:?}");
        let mut counts = [0u32; BANDS];
        for pass in 0..12_000 {
            let nm = at((f64::from(pass) + 0.5) / 12_000.0);
            counts[edges.partition_point(|edge| *edge <= nm)] += 1;
        }
        assert!(counts.iter().all(|count| count.abs_diff(1000) <= 2), "{counts:?}");
    }
}
