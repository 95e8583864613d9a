//! Where paths from the lamps have to start so that the table finds faint ways as well as bright ones.

use super::chain_sampling::All;
use super::lamp_paths::{Arrivals, Caught, Source, Split, Way};
use crate::pilots::{self, Look};
use eyebox_base::ids::GroupId;
use eyebox_base::rng::Stream;
use eyebox_estimate::ShouldStop;
use eyebox_estimate::emission::{Emission, Shots, Starts};
use eyebox_film::guide::{Point, Sample};
use eyebox_world::World;
use eyebox_world::mode::{Mode, Mono};
use std::collections::BTreeMap;

/// The table's own paths as a pilot sees them. A path counts by the roots of the shares of the ways that it found: a ghost
/// of 10⁻⁴ of the light gets 10⁻² of the paths.
pub struct Looks<'w> {
    pub world: &'w World,
    pub emission: Emission,
    /// The lamps of the emission, in its order.
    pub sources: &'w [Source],
    pub paths: u64,
    pub split: Split,
}

/// A path that found something: lamp, point of its cube, density, and what.
type Start = (usize, Point, f64, Vec<Caught>);

impl Looks<'_> {
    /// Least share that pilots follow both ways: they are many, and what is fainter is left to chance.
    pub const LEAST: f64 = 1e-5;

    /// The weight of each path: what it brought, less by how bright the ways are by which it came.
    fn weigh(&self, starts: &[Start]) -> Vec<Sample> {
        let mut flux: BTreeMap<(GroupId, &Way), f64> = BTreeMap::new();
        for caught in starts.iter().flat_map(|(.., caught)| caught) {
            *flux.entry((caught.group, &caught.way)).or_default() += caught.lumens;
        }
        let all: f64 = flux.values().sum();
        let each = |caught: &Caught| {
            let way = flux.get(&(caught.group, &caught.way)).copied().unwrap_or(all);
            caught.lumens * (all / way.max(Self::LEAST * all)).sqrt()
        };
        let sample = |(lamp, x, density, caught): &Start| {
            let weight = caught.iter().map(each).sum::<f64>() * density * self.paths as f64;
            (weight > 0.0 && weight.is_finite()).then_some(Sample { lamp: *lamp, x: *x, weight })
        };
        starts.iter().filter_map(sample).collect()
    }
}

impl Look for Looks<'_> {
    fn probe(&self, pass: u64, stop: &ShouldStop<'_>) -> Vec<Sample> {
        let optics = Mono::<f64>::optics(self.world, pilots::SEED, pass);
        let shots =
            Shots { seed: pilots::SEED, stream: Stream::Pilot, pass, paths: self.paths, starts: Starts::OfPass };
        let visitor = || Arrivals::new(self.split);
        let take = |lamp: usize, x: Point, density: f64, arrivals: Arrivals| {
            let caught = arrivals.caught(*self.sources.get(lamp)?, self.world, &All::default());
            (!caught.is_empty()).then_some((lamp, x, density, caught))
        };
        self.weigh(&self.emission.survey((self.world, &optics), shots, stop, visitor, take))
    }
    fn density(&self, lamp: usize, x: &Point) -> f64 {
        self.emission.density(lamp, x)
    }
    fn flux(&self) -> &[f64] {
        self.emission.flux()
    }
    fn group_of(&self, lamp: usize) -> GroupId {
        self.emission.group_of(self.world, lamp)
    }
}
