//! What photons leave at scatterers on their way, and where they part.

use crate::emission::{Origin, Visitor};
use crate::manifold::receiver::{Claim, Receivers};
use crate::manifold::solver::newton::Target;
use crate::photon_map::Photon;
use crate::splitting::Splitting;
use crate::walk::{Vertex, Walker};
use eyebox_world::eye::Arrival;
use eyebox_world::mode::Mode;
use eyebox_world::scatter::Scatter;

/// Photons of which only a little is left by connection part at every interface: a lens's ghost has some 1e-4 of the light,
/// and out of ten thousand photons that choose one way thirty would make a way through two reflections. Those that part
/// bring all ghosts each.
mod parting {
    /// Share of what a photon started with that both ways on must have: two reflections by coated lenses have 1e-4, three
    /// 1e-6.
    pub const LEAST: f64 = 1e-5;
    /// Interfaces at which a photon and all its branches may part.
    pub const MOST: u32 = 1024;
    /// Paths by which a whole one goes on from the first scatterer.
    pub const COPIES: f64 = 8.0;
}

/// What paths leave at broad scatterers.
pub(super) struct PhotonRecord<'s, M: Mode> {
    pub(super) photons: Vec<Photon<M>>,
    screens: &'s Receivers<M>,
    /// How far from where they land photons may be gathered whose path may be connected.
    reach_m: f64,
    /// Where photons part, if they do.
    parts: Option<Splitting>,
    /// Counted work of asking what is connected.
    pub(super) work: u64,
}

impl<'s, M: Mode> PhotonRecord<'s, M> {
    pub(super) fn new(screens: &'s Receivers<M>, reach_m: f64, part: bool) -> Self {
        let parts = part.then(|| Splitting::new(parting::LEAST, parting::MOST));
        PhotonRecord { photons: Vec::new(), screens, reach_m, parts, work: 0 }
    }

    /// Whose the path up to here is.
    fn claim(&mut self, walker: &Walker<'_, M>, from: Origin, vertex: &Vertex) -> Claim {
        let (Some(chain), Some((lamp, point, normal))) = (walker.chain(), from.face) else { return Claim::Free };
        if walker.trail.has_scatter() || walker.trail.is_empty() {
            return Claim::Free;
        }
        let target = Target::new(point, normal);
        let arrives = (vertex.hit.point, vertex.hit.site, walker.ray.dir);
        self.screens.claim((walker.world, walker.optics), chain, (lamp, &target), arrives, self.reach_m, &mut self.work)
    }
}

impl<M: Mode> Visitor<M> for PhotonRecord<'_, M> {
    fn records(&self) -> bool {
        !self.screens.is_empty()
    }

    /// What connection leaves comes by faint reflections: photons of that kind should be many and faint, not few and bright.
    fn least_chance(&self) -> f64 {
        const OF_THE_REST: f64 = 0.1;
        if self.screens.is_empty() || self.parts.is_some() { 0.0 } else { OF_THE_REST }
    }

    fn split_from(&self, walker: &Walker<'_, M>) -> Option<f64> {
        self.parts.as_ref()?.from(walker)
    }

    fn most_splits(&self) -> u8 {
        if self.parts.is_some() { u8::MAX } else { Walker::<M>::MOST_SPLITS }
    }

    /// A branch has its share for good.
    fn worth(&self) -> f64 {
        if self.parts.is_some() { parting::LEAST } else { Walker::<M>::WORTH }
    }

    fn copies(&self, walker: &Walker<'_, M>) -> f64 {
        if self.parts.is_some() && !walker.trail.has_scatter() { parting::COPIES * walker.share() } else { 1.0 }
    }

    fn end(&mut self, _: u64) {
        if let Some(parts) = &self.parts {
            parts.next();
        }
    }

    fn pupil(&mut self, _: &Walker<'_, M>, _: Origin, _: &Arrival) {}

    fn scatterer(&mut self, walker: &Walker<'_, M>, from: Origin, vertex: &Vertex, scatter: &Scatter) {
        if !scatter.is_narrow() {
            let claim = self.claim(walker, from, vertex);
            self.photons.push(Photon::new(walker, vertex, from.group, claim));
        }
    }
}
