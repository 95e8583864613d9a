//! The solids around a path: the medium it runs in, what is behind a face, and agreement with what hits prove.

use super::ledger::Ledger;
use super::walk::{Vertex, Walker};
use eyebox_world::interior::{Interior, outranks};
use eyebox_world::mode::{Mode, lanes};

impl<'w, M: Mode> Walker<'w, M> {
    /// Refractive index where the path is now.
    pub(super) fn index_here(&self) -> M::Lanes<f64> {
        self.index_in(&self.interior)
    }

    pub(super) fn index_in(&self, interior: &Interior) -> M::Lanes<f64> {
        self.optics.index_in(interior.top(&self.world.solids).map(|(part, _)| part))
    }

    /// Makes the solids around the ray agree with what the hit proves, once per vertex however often it is asked for.
    /// Returns whether the face belongs to a solid.
    pub(super) fn heal(&mut self, vertex: &Vertex, ledger: &mut Ledger) -> bool {
        let part = vertex.hit.site.part;
        let solid = self.world.solids[part as usize].is_some();
        if solid {
            let other = vertex.touching.map(|other| (other.site.part, vertex.outside == other.flush));
            for (part, outside) in [Some((part, vertex.outside)), other].into_iter().flatten() {
                if self.interior.contains(part) == outside {
                    ledger.mismatches += 1;
                }
                self.interior.heal(part, !outside);
            }
        }
        solid
    }

    /// Whether the ray is inside a solid of higher priority than that of the face, where the face is not there.
    pub(super) fn is_outranked(&self, vertex: &Vertex) -> bool {
        let part = vertex.hit.site.part;
        let above = self.interior.top_without(part, &self.world.solids);
        above.is_some_and(|(other, _)| outranks(&self.world.solids, other, part))
    }

    /// Whether the ray has crossed the interface of two solids that touch already: at the face of one of them it went
    /// from the one into the other, and here is the other's.
    pub(super) fn is_behind(&self, vertex: &Vertex) -> bool {
        vertex.touching.is_some_and(|other| {
            let outside = self.interior.contains(vertex.hit.site.part) == vertex.outside;
            let other_outside = vertex.outside == other.flush;
            outside && self.interior.contains(other.site.part) == other_outside
        })
    }

    /// Index of the medium on the side where light is picked up (`through` the face or not), and the medium's
    /// transmittance over `length` metres there.
    pub fn beyond(&self, vertex: &Vertex, through: bool, length: f64) -> (M::Lanes<f64>, M::Lanes<f64>) {
        let there = if through { self.interior_beyond(vertex) } else { self.interior };
        let top = there.top(&self.world.solids).map(|(part, _)| part);
        let absorption = top.and_then(|part| self.optics.absorption_in(part));
        let transmittance = absorption.map_or_else(
            || lanes::<M, _>(|_| 1.0),
            |absorption| {
                lanes::<M, _>(|lane| if absorption[lane] > 0.0 { (-absorption[lane] * length).exp() } else { 1.0 })
            },
        );
        (self.optics.index_in(top), transmittance)
    }

    /// The solids around a ray that leaves the face, `through` it or not.
    pub fn interior_at(&self, vertex: &Vertex, through: bool) -> Interior {
        if through { self.interior_beyond(vertex) } else { self.interior }
    }

    /// The index behind the face: what fills the space once the ray has gone through.
    pub(super) fn index_beyond(&self, vertex: &Vertex) -> M::Lanes<f64> {
        self.index_in(&self.interior_beyond(vertex))
    }

    /// The solids around the ray once it has gone through the face.
    pub(super) fn interior_beyond(&self, vertex: &Vertex) -> Interior {
        let mut beyond = self.interior;
        let part = vertex.hit.site.part;
        if self.world.solids[part as usize].is_some() {
            let other = vertex.touching.map(|other| (other.site.part, vertex.outside == other.flush));
            // What is left comes first, for the list is short.
            let mut both = [Some((part, vertex.outside)), other];
            if vertex.outside {
                both.reverse();
            }
            for (part, outside) in both.into_iter().flatten() {
                if outside { beyond.enter(part) } else { beyond.leave(part) }
            }
        }
        beyond
    }
}
