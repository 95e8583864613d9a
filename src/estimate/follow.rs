//! Paths along a known chain of faces, and the record of the chain of any path.

use super::emitter_hit::EmitterHit;
use super::ledger::Ledger;
use super::specular_event::Branch;
use super::walk::{Meeting, Met, Vertex, Walker};
use eyebox_base::chain::{Chain, Link, Step};
use eyebox_world::eye::Arrival;
use eyebox_world::mode::Mode;
use eyebox_world::surface::Surface;

impl<'w, M: Mode> Walker<'w, M> {
    /// Keeps the specular faces that the path meets from now on.
    #[must_use]
    pub fn recording(mut self) -> Self {
        self.chain = Some(Box::default());
        self
    }

    /// The specular faces so far, since the start or the last scatterer; none if nobody asked.
    pub fn chain(&self) -> Option<&Chain> {
        self.chain.as_deref()
    }

    pub(super) fn link(&mut self, vertex: &Vertex, step: Step) {
        self.link_order(vertex, step, 0);
    }

    /// The same of an order of diffraction.
    pub(super) fn link_order(&mut self, vertex: &Vertex, step: Step, order: i32) {
        let site = vertex.hit.site;
        let link = Link { part: site.part, face: site.face, step, order };
        self.last = Some(link);
        if let Some(chain) = &mut self.chain {
            chain.0.push(link);
        }
    }

    /// A scatterer ends one chain and starts another.
    pub(super) fn unlink(&mut self) {
        if let Some(chain) = &mut self.chain {
            chain.0.clear();
        }
    }

    /// The part that fills the space around the ray; none: air.
    pub fn part_around(&self) -> Option<u32> {
        self.interior.top(&self.world.solids).map(|(part, _)| part)
    }

    /// Follows the faces of a chain and leaves nothing to chance; `each` sees the part around the ray before and behind
    /// a face, and where it was met. False where the ray meets another face, or cannot do what the chain says.
    pub fn follow(
        &mut self,
        links: impl Iterator<Item = Link>,
        ledger: &mut Ledger,
        mut each: impl FnMut(Option<u32>, &Vertex, Option<u32>),
    ) -> bool {
        for link in links {
            loop {
                let Met::Face(vertex) = self.advance(ledger) else { return false };
                let before = self.part_around();
                let site = vertex.hit.site;
                self.last = None;
                let own = (site.part, site.face) == (link.part, link.face);
                self.order = (own && matches!(self.face(&vertex).surface, Surface::Grating(_)))
                    .then_some((link.step, link.order));
                if own && matches!(self.face(&vertex).surface, Surface::Interface(_) | Surface::Splitter(_)) {
                    self.forced = Some(match link.step {
                        Step::Through => Branch::Refracted,
                        Step::Back => Branch::Reflected,
                    });
                }
                if !matches!(self.meet(&vertex, ledger), Meeting::Went) {
                    return false;
                }
                match self.last {
                    // A face that is not there.
                    None => (self.forced, self.order) = (None, None),
                    Some(met) if met == link => {
                        each(before, &vertex, self.part_around());
                        break;
                    }
                    Some(_) => return false,
                }
            }
        }
        true
    }

    /// Follows the faces of a chain and what lies between them and a lamp; none where there is something else.
    pub fn follow_to(
        &mut self,
        links: impl Iterator<Item = Link>,
        lamp: usize,
        ledger: &mut Ledger,
        each: impl FnMut(Option<u32>, &Vertex, Option<u32>),
    ) -> Option<EmitterHit<'w>> {
        let whole = self.follow(links, ledger, each);
        whole.then(|| self.reach_lamp(ledger)).flatten().filter(|seen| seen.index == lamp)
    }

    /// Follows the faces of a chain and what lies between them and the pupil; none where there is something else.
    pub fn follow_to_pupil(&mut self, links: impl Iterator<Item = Link>, ledger: &mut Ledger) -> Option<Arrival> {
        let mut here = self.follow(links, ledger, |_, _, _| {});
        while here {
            let vertex = match self.advance(ledger) {
                Met::Pupil(arrival) => return Some(arrival),
                Met::Sky | Met::Ended => return None,
                Met::Face(vertex) => vertex,
            };
            self.last = None;
            here = matches!(self.meet(&vertex, ledger), Meeting::Went) && self.last.is_none();
        }
        None
    }

    /// Goes on to a face of a part; none if something else is on the way.
    pub fn reach_face(&mut self, face: (u32, u32), ledger: &mut Ledger) -> Option<Vertex> {
        self.reach(ledger, |_, vertex| {
            let site = vertex.hit.site;
            ((site.part, site.face) == face).then(|| vertex.clone())
        })
    }

    /// Goes on to what shines next on the way; none if something else is there.
    pub fn reach_lamp(&mut self, ledger: &mut Ledger) -> Option<EmitterHit<'w>> {
        self.reach(ledger, |walker, vertex| walker.lamp_at(vertex))
    }

    /// Goes on, past faces that do nothing, to the first that is `wanted`.
    fn reach<T>(&mut self, ledger: &mut Ledger, wanted: impl Fn(&Self, &Vertex) -> Option<T>) -> Option<T> {
        loop {
            let Met::Face(vertex) = self.advance(ledger) else { return None };
            if let Some(found) = wanted(self, &vertex) {
                return Some(found);
            }
            self.last = None;
            if !matches!(self.meet(&vertex, ledger), Meeting::Went) || self.last.is_some() {
                return None;
            }
        }
    }
}
