//! What tables say of pixels at the edge of a picture: for which points of the lamp they are asked, and at which place of the pixel
//! the solver is, so that what is left to chance is not the edge.

use super::film_table::{Branch, OverLamp, OverPixel};
use super::seeds::MOST_SHEETS;
use super::tuning::at_edges::{ANYWHERE, EDGE_POINTS, NEAREST, PLACES, POINTS};
use super::vision::Manifold;
use crate::ledger::{Ledger, cost};
use arrayvec::ArrayVec;
use eyebox_base::lattice::lattice;
use eyebox_film::accumulate::Light;
use eyebox_world::mode::{Mode, lanes};
use eyebox_world::optics::Optics;
use eyebox_world::slide::footprint;
use eyebox_world::slide::jump::{self, Jumps};
use glam::DVec2;

impl<M: Mode> Manifold<'_, M> {
    /// How many points of a lamp tables are asked about: the more the fewer are seen past outlines. The same in every pass: what is
    /// drawn has no say in how much is drawn.
    pub(super) fn points(&self, over_lamp: &OverLamp<M>, off: impl Fn([f64; 2]) -> DVec2) -> u64 {
        let seen = (0..POINTS).filter(|k| over_lamp.is_seen(off(lattice([0; 2], *k)))).count() as u64;
        POINTS * (POINTS / seen.max(1))
    }

    /// Takes a table's mean over points of the lamp from which an edge is seen in the pixel, instead of for the first of them alone:
    /// the edge moves with the point. `first`: from which that was drawn; `aimed`: how far from the lamp's middle the point is that
    /// is drawn from such numbers, m, and what it stands for.
    ///
    /// The others are moved on from the first by a lattice that closes, so each of them would be moved on to the same ones: the mean
    /// over all numbers is what it is, whichever points see an edge.
    pub(super) fn add_others(
        &self,
        (optics, over_lamp): (&Optics<M>, &OverLamp<M>),
        first: [f64; 2],
        aimed: impl Fn([f64; 2]) -> (DVec2, f64),
        mean: &mut M::Lanes<Light>,
        ledger: &mut Ledger,
    ) {
        let mut found = 1.0;
        for k in 1..EDGE_POINTS {
            let by = [k, 3 * k].map(|k| k as f64 / EDGE_POINTS as f64);
            let (off, weight) = aimed([0, 1].map(|axis| (first[axis] + by[axis]).fract()));
            let mut other = lanes::<M, _>(|_| Light::default());
            let pieces = self.add_mean(optics, &over_lamp.at(off), weight, &mut other);
            ledger.work += pieces * cost::CUT;
            if pieces > 1 {
                found += 1.0;
                (0..M::LANES).for_each(|lane| mean[lane].add(other[lane]));
            }
        }
        (0..M::LANES).for_each(|lane| mean[lane] = mean[lane].scaled(1.0 / found));
    }

    /// A place of the pixel, from its middle, where tables and solver may see other things, and what it stands for.
    pub(super) fn near_edges(&self, branches: &[Branch<M>], within: DVec2, choice: f64) -> (DVec2, f64) {
        let radius = self.world.eye.pupil_radius_m();
        let jumps = |Branch { over, .. }: &Branch<M>| {
            Jumps::new(self.world, over.edges.iter().copied().chain(over.to_rim_of_pupil(radius)), &over.footprints)
        };
        let jumps: ArrayVec<Jumps, MOST_SHEETS> = branches.iter().map(jumps).take(MOST_SHEETS).collect();
        jump::draw::<PLACES>(within, choice, |place| {
            let nearest = jumps.iter().map(|jumps| jumps.distance(place)).fold(f64::INFINITY, f64::min);
            ANYWHERE + 1.0 / (nearest + NEAREST)
        })
    }

    /// Adds what a table says of a pixel for a point of the lamp, `weight` times. Returns of how many pieces that is.
    pub(super) fn add_mean(
        &self,
        optics: &Optics<M>,
        over: &OverPixel<M>,
        weight: f64,
        out: &mut M::Lanes<Light>,
    ) -> u64 {
        if over.pupil.length() > self.world.eye.pupil_radius_m() {
            return 0;
        }
        let cut = (&over.edges[..], &over.footprints[..]);
        let Some((mean, pieces)) = footprint::mean((self.world, optics), &over.brightness, cut) else { return 0 };
        (0..M::LANES).for_each(|lane| out[lane].add(mean[lane].scaled(weight)));
        pieces
    }
}
