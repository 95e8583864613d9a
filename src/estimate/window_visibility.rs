//! Through panes: a direction that was chosen at a scatterer is followed through whatever transmits, out of the scene.
//!
//! A plane pane leaves the direction as it is, and a windscreen nearly, so light of the sky that is chosen by its luminance is
//! found behind them, too.

use super::ledger::Ledger;
use super::specular_event::Branch;
use super::tuning::window_visibility::MOST_FACES;
use super::walk::{Meeting, Met, Vertex, Walker};
use eyebox_base::chain::Step;
use eyebox_base::lpe::Letter;
use eyebox_base::warp::Frame;
use eyebox_world::mode::{LaneArray, Mode, lanes};
use eyebox_world::scatter::Scatter;
use eyebox_world::surface::Surface;
use glam::DVec3;

/// The last scattering vertex: what the chance of having sampled a lamp from there was.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scattered {
    pub point: DVec3,
    /// Unit direction that was taken there.
    pub dir: DVec3,
    /// Its density per steradian.
    pub pdf: f64,
    /// Faces passed since.
    crossed: u32,
}

impl Scattered {
    /// The path has just scattered at a point with this density.
    pub fn new<M: Mode>(walker: &Walker<'_, M>, point: DVec3, pdf: f64) -> Self {
        Scattered { point, dir: walker.ray.dir, pdf, crossed: 0 }
    }

    /// After the path has passed a face: none where a chosen direction would not have come along.
    pub fn past<M: Mode>(self, walker: &Walker<'_, M>) -> Option<Self> {
        let crossed = self.crossed + 1;
        (crossed <= MOST_FACES && walker.has_passed()).then_some(Scattered { crossed, ..self })
    }

    /// With no face passed since.
    pub fn in_sight(&self) -> bool {
        self.crossed == 0
    }
}

impl<M: Mode> Walker<'_, M> {
    /// The face met last has let the path through.
    fn has_passed(&self) -> bool {
        self.last.is_none_or(|link| link.step == Step::Through)
    }

    /// Goes on from a scatterer in a unit direction that was chosen with this density per steradian; false if nothing goes
    /// there.
    pub(super) fn scatter_to(
        &mut self,
        (vertex, scatter, frame): (&Vertex, &Scatter, &Frame),
        (dir, pdf): (DVec3, f64),
        ledger: &mut Ledger,
    ) -> bool {
        let (d_in, d_out) = (frame.to_local(self.ray.dir), frame.to_local(dir));
        let sides = self.sides(vertex, scatter);
        let (values, alone) = sides.eval(scatter, d_in, d_out);
        if values.as_slice().iter().all(|value| *value <= 0.0) {
            return false;
        }
        let through = d_out.z < 0.0;
        self.trail = self.trail.then(scatter.event());
        self.tell(Letter::of(scatter.event(), through));
        self.beam.scale_lanes(&lanes::<M, _>(|lane| values[lane] * d_out.z.abs() / pdf));
        if alone {
            self.beam.part();
        }
        let facets = sides.facets(scatter, (d_in, d_out), &values);
        self.beam.scatter(facets.as_ref(), [self.ray.dir, dir], self.is_from_eye());
        matches!(self.go(vertex, dir, through, ledger), Meeting::Went)
    }

    /// Goes on through faces that transmit until the scene ends; false where anything else is in the way.
    pub(super) fn leave(&mut self, ledger: &mut Ledger) -> bool {
        for crossed in 0..=MOST_FACES {
            match self.advance(ledger) {
                Met::Sky => return true,
                Met::Face(vertex) if crossed < MOST_FACES => {
                    if !self.pass(&vertex, ledger) {
                        return false;
                    }
                }
                Met::Face(_) | Met::Pupil(_) | Met::Ended => return false,
            }
        }
        false
    }

    /// Goes straight on for `rest` metres, or out of the scene where that is infinite, through what is cut out of ordinary
    /// materials and what they let through unbent; false where anything else is in the way.
    pub(super) fn go_straight(&mut self, mut rest: f64, ledger: &mut Ledger) -> bool {
        // As many leaves as a tree may have one behind the other.
        const MOST_LEAVES: usize = 256;
        for _ in 0..MOST_LEAVES {
            let blocked =
                self.pending.is_some() || self.world.geometry.intersect_beside(&self.ray, self.beside, rest).is_some();
            if !blocked && rest.is_finite() {
                self.attenuate(rest, ledger);
                return true;
            }
            match self.advance(ledger) {
                Met::Sky => return true,
                Met::Pupil(_) | Met::Ended => return false,
                Met::Face(vertex) => {
                    rest -= vertex.hit.t;
                    if !self.thins(&vertex) {
                        return false;
                    }
                    self.pass_through(&vertex);
                }
            }
        }
        false
    }

    /// Takes away what a face keeps of light that goes straight on; false if that is all.
    fn thins(&mut self, vertex: &Vertex) -> bool {
        let site = vertex.hit.site;
        match &self.world.faces[site.part as usize][site.face as usize].surface {
            Surface::Absent => true,
            Surface::Scatter(scatter) => {
                let Some(principled) = scatter.principled().filter(|p| p.surface.lets_through()) else { return false };
                let share = self.share_through(vertex, principled);
                self.beam.scale_lanes(&share);
                share.as_slice().iter().any(|share| *share > 0.0)
            }
            Surface::Absorber
            | Surface::Slide(_)
            | Surface::Sheet(_)
            | Surface::Splitter(_)
            | Surface::Grating(_)
            | Surface::Mirror(_)
            | Surface::Interface(_) => false,
        }
    }

    /// Goes on through the face at `vertex`; false if that lets nothing through.
    fn pass(&mut self, vertex: &Vertex, ledger: &mut Ledger) -> bool {
        match self.look_ahead(vertex, ledger) {
            Some(turn) if !turn.refracts() => return false,
            Some(_) => self.forced = Some(Branch::Refracted),
            // Of a grating the way straight on.
            None => self.order = matches!(self.face(vertex).surface, Surface::Grating(_)).then_some((Step::Through, 0)),
        }
        self.last = None;
        let went = matches!(self.meet(vertex, ledger), Meeting::Went);
        if self.last.is_none() {
            // A face that is not there.
            (self.forced, self.order) = (None, None);
        }
        went && self.has_passed()
    }
}
