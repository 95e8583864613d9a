//! How a path leaves a vertex: through it, back from it, straight on, out of the scene, or not at all.

use super::ledger::Ledger;
use super::specular_event::Branch;
use super::walk::{Meeting, Travel, Vertex, Walker};
use eyebox_base::chain::Step;
#[cfg(test)]
use eyebox_world::Planted;
use eyebox_world::geometry::Ray;
use eyebox_world::mode::Mode;
use eyebox_world::surface::Surface;
use glam::DVec3;

impl<'w, M: Mode> Walker<'w, M> {
    /// Books what `part` takes.
    pub(super) fn absorb(&self, part: u32, amount: f64, ledger: &mut Ledger) {
        #[cfg(test)]
        if self.world.planted == (Planted::Unbooked { part }) {
            return;
        }
        ledger.absorb(part, amount);
    }

    /// Books a path that leaves the scene.
    pub fn escape(&self, ledger: &mut Ledger) {
        #[cfg(test)]
        if self.world.planted == Planted::UnbookedEscape {
            return;
        }
        ledger.escaped += self.beam.carried();
    }

    /// Goes on without chance: through what transmits, back from what only reflects. False (and the path stays) at
    /// what is not specular.
    pub fn go_straight_on(&mut self, vertex: &Vertex, ledger: &mut Ledger) -> bool {
        self.events += 1;
        match &self.face(vertex).surface {
            Surface::Absorber | Surface::Scatter(_) => false,
            Surface::Absent => {
                self.pass_through(vertex);
                true
            }
            Surface::Slide(_) | Surface::Sheet(_) | Surface::Mirror(_) => {
                matches!(self.meet(vertex, ledger), Meeting::Went)
            }
            Surface::Grating(_) => {
                self.order = Some((Step::Through, 0));
                let went = matches!(self.meet(vertex, ledger), Meeting::Went);
                self.order = None;
                went
            }
            Surface::Splitter(sheet) => {
                let turn = self.turn_at_splitter(vertex, sheet);
                let branch = if turn.refracts() { Branch::Refracted } else { Branch::Reflected };
                matches!(self.take_branch(vertex, &turn, Some(branch), ledger), Meeting::Went)
            }
            Surface::Interface(_) if self.is_behind(vertex) => {
                self.pass_through(vertex);
                true
            }
            Surface::Interface(coating) => {
                self.heal(vertex, ledger);
                let turn = self.turn(vertex, *coating);
                let branch = if turn.refracts() { Branch::Refracted } else { Branch::Reflected };
                matches!(self.take_branch(vertex, &turn, Some(branch), ledger), Meeting::Went)
            }
        }
    }

    /// Crosses a slide.
    pub(super) fn cross(&mut self, vertex: &Vertex, index: usize, s: &M::Lanes<f64>) {
        let (slide, rank) = (&self.world.slides[index], self.world.rank(index));
        let part = vertex.hit.site.part;
        let across =
            slide.polarisation_axis().map(|axis| self.world.geometry.part_to_world(part).transform_vector3(axis));
        self.beam.cross((slide, rank), s, across, self.ray.dir, self.travel == Travel::FromEye);
    }

    /// Goes straight on behind the face.
    pub(crate) fn pass_through(&mut self, vertex: &Vertex) {
        self.interior = self.interior_beyond(vertex);
        self.ray = Ray { origin: vertex.hit.point, dir: self.ray.dir, from: Some(vertex.hit.site) };
        (self.beside, self.pending) = (vertex.beside, vertex.then);
    }

    /// Leaves a vertex in `dir`, through the face or back from it.
    pub(super) fn go(&mut self, vertex: &Vertex, dir: DVec3, through: bool, ledger: &mut Ledger) -> Meeting<'w> {
        if !vertex.is_left_by(dir, through) {
            ledger.wrong_side += self.beam.carried();
            return Meeting::Ended;
        }
        if through {
            self.interior = self.interior_beyond(vertex);
        }
        self.ray = Ray { origin: vertex.hit.point, dir, from: Some(vertex.hit.site) };
        (self.beside, self.pending) = (vertex.beside, vertex.at_once(through).copied());
        self.roulette(ledger)
    }

    /// Unbiased roulette on the weight without slides: the picture at another contrast makes the same decisions.
    pub(super) fn roulette(&mut self, ledger: &mut Ledger) -> Meeting<'w> {
        const FREE_EVENTS: u32 = 16;
        const TRAPPED_EVENTS: u32 = 1024;
        let carried = self.beam.carried();
        if !carried.is_finite() {
            ledger.invalid_paths += 1;
            return Meeting::Ended;
        }
        let weight = self.beam.weight();
        if weight <= 0.0 {
            return Meeting::Ended;
        }
        if self.events <= FREE_EVENTS {
            return Meeting::Went;
        }
        // Light that total reflection traps loses nothing. Half of it goes on at 4ᵏ events: a path that is trapped for good
        // takes some 10⁴ events, and one that comes out of a long light guide after 10⁵ weighs 16.
        let halves = self.events >= TRAPPED_EVENTS && self.events.is_power_of_two();
        let trapped: f64 = if halves && self.events.trailing_zeros().is_multiple_of(2) { 0.5 } else { 1.0 };
        let survive = (weight / self.start_weight() / self.worth).clamp(0.05, 1.0) * trapped;
        if survive >= 1.0 {
            return Meeting::Went;
        }
        if self.rng.uniform() < survive {
            self.beam.scale(1.0 / survive);
            ledger.roulette_gained += self.beam.carried() - carried;
            Meeting::Went
        } else {
            ledger.roulette_lost += carried;
            Meeting::Ended
        }
    }
}
