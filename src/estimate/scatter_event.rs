//! The vertex step at faces that scatter: a path goes on in a sampled direction.

use super::ledger::Ledger;
use super::walk::{Meeting, Vertex, Walker};
use eyebox_base::lpe::Letter;
use eyebox_base::path::Event;
use eyebox_base::warp::Frame;
use eyebox_world::mode::{LaneArray, Mode, lanes};
use eyebox_world::scatter::{Look, Point, Principled, Scatter, Sides};
use eyebox_world::stokes::{Amount, Facets};
use glam::DVec3;

/// Refractive indices on both sides of a face that scatters, or what an ordinary material is there.
#[derive(Debug, Clone)]
pub struct FaceSides<M: Mode> {
    here: M::Lanes<f64>,
    beyond: M::Lanes<f64>,
    /// The face's scattering depends on the lane.
    matter: bool,
    looks: Option<Box<M::Lanes<Look>>>,
}

impl<M: Mode> FaceSides<M> {
    /// In a lane.
    pub fn of(&self, lane: usize) -> Sides<'_> {
        Sides { here: self.here[lane], beyond: self.beyond[lane], look: self.looks.as_ref().map(|looks| &looks[lane]) }
    }

    /// In the first lane, within the rounding that half vectors of refraction bear.
    pub(super) fn are_equal(&self) -> bool {
        const NEXT_TO_EQUAL: f64 = 1e-9;
        (self.here[0] - self.beyond[0]).abs() <= NEXT_TO_EQUAL * self.here[0]
    }

    /// The distribution per lane; whether the first lane alone counts, since what goes through is dispersed. As at a
    /// smooth face the first lane then stands for all: what another wavelength sends the same way would come in at a
    /// density that the first does not sample.
    pub fn eval(&self, scatter: &Scatter, d_in: DVec3, d_out: DVec3) -> (M::Lanes<f64>, bool) {
        if !self.matter {
            let value = scatter.eval(d_in, d_out, self.of(0));
            return (lanes::<M, _>(|_| value), false);
        }
        let alone = d_out.z < 0.0
            && (1..M::LANES).any(|lane| self.here[lane] * self.beyond[0] != self.here[0] * self.beyond[lane]);
        let used = if alone { 1 } else { M::LANES };
        let values = lanes::<M, _>(|lane| if lane < used { scatter.eval(d_in, d_out, self.of(lane)) } else { 0.0 });
        (values, alone)
    }

    /// What facets do to the polarisation of these values; none where the face depolarises or nothing is polarised.
    pub fn facets(
        &self,
        scatter: &Scatter,
        (d_in, d_out): (DVec3, DVec3),
        values: &M::Lanes<f64>,
    ) -> Option<M::Lanes<Facets>> {
        if !M::Amount::POLARISED {
            return None;
        }
        let (principled, looks) = (scatter.principled()?, self.looks.as_ref()?);
        Some(lanes::<M, _>(|lane| {
            let facets = principled.polarises(d_in, d_out, &looks[lane]);
            if values[lane] > 0.0 { facets.scaled(1.0 / values[lane]) } else { Facets::NONE }
        }))
    }
}

impl<'w, M: Mode> Walker<'w, M> {
    /// On average so many paths that stand for this one together, each with choices of its own from here on.
    pub fn copied(mut self, on_average: f64, ledger: &mut Ledger) -> impl Iterator<Item = Walker<'w, M>> + use<'w, M> {
        let count = (on_average + self.rng.uniform()).floor();
        let carried = self.beam.carried();
        self.beam.scale(1.0 / on_average);
        ledger.by_chance(count * self.beam.carried() - carried);
        (0..count as usize).map(move |_| {
            let mut copy = self.clone();
            copy.rng = self.rng.fork();
            copy
        })
    }

    /// Chooses between what a face reflects specularly and what it scatters, by what they carry with a floor for both.
    /// The beam then stands for the chosen one.
    pub(super) fn stays_specular(
        &mut self,
        vertex: &Vertex,
        scatter: &Scatter,
        specular: f64,
        ledger: &mut Ledger,
    ) -> bool {
        const LEAST: f64 = 0.1;
        let scattered = scatter.albedo(-self.ray.dir.dot(vertex.normal));
        let chance = (specular / (specular + scattered)).clamp(LEAST, 1.0 - LEAST);
        let before = self.beam.carried();
        if self.rng.uniform() < chance {
            // What is neither reflected nor scattered is absorbed, and booked where the rest scatters.
            self.beam.scale(specular / chance);
            self.trail = self.trail.then(Event::Specular);
            ledger.by_chance(self.beam.carried() - before);
            return true;
        }
        self.beam.scale(1.0 / (1.0 - chance));
        // The specular share of it stands for nothing.
        ledger.by_chance(self.beam.carried() * (1.0 - specular) - before);
        false
    }

    /// Scatters at a vertex for which [`Walker::meet`] said `Scatter`. Returns the direction's density per steradian
    /// while the path goes on.
    pub fn scatter(&mut self, vertex: &Vertex, scatter: &Scatter, frame: &Frame, ledger: &mut Ledger) -> Option<f64> {
        let u = self.rng.triple();
        self.scatter_by(u, vertex, (scatter, frame), ledger)
    }

    /// As [`Walker::scatter`], by these numbers in [0, 1).
    pub fn scatter_by(
        &mut self,
        u: [f64; 3],
        vertex: &Vertex,
        (scatter, frame): (&Scatter, &Frame),
        ledger: &mut Ledger,
    ) -> Option<f64> {
        let part = vertex.hit.site.part;
        let d_in = frame.to_local(self.ray.dir);
        let sides = self.sides(vertex, scatter);
        if scatter.principled().is_none() {
            // What the face reflects specularly besides is not this path's.
            let absorbed = 1.0 - scatter.specular() - scatter.albedo(-d_in.z);
            self.absorb(part, self.beam.carried() * absorbed, ledger);
        }
        self.trail = self.trail.then(scatter.event());
        self.unlink();
        let before = self.beam.carried();
        let Some(sampled) = scatter.sample(d_in, sides.of(0), u) else {
            if scatter.principled().is_some() {
                self.absorb(part, before, ledger);
            }
            return None;
        };
        let through = sampled.dir.z < 0.0;
        self.tell(Letter::of(scatter.event(), through));
        let mut facets = None;
        if !sides.matter || M::LANES == 1 && !M::Amount::POLARISED {
            self.beam.scale(sampled.weight);
        } else {
            let (values, alone) = sides.eval(scatter, d_in, sampled.dir);
            let cos = sampled.dir.z.abs();
            self.beam.scale_lanes(&lanes::<M, _>(|lane| values[lane] * cos / sampled.pdf));
            if alone {
                self.beam.part();
            }
            facets = sides.facets(scatter, (d_in, sampled.dir), &values);
        }
        let dir = frame.to_world(sampled.dir);
        self.beam.scatter(facets.as_ref(), [self.ray.dir, dir], self.is_from_eye());
        if scatter.principled().is_some() {
            // What it takes is known by what is left, on average.
            self.absorb(part, before - self.beam.carried(), ledger);
        }
        match self.go(vertex, dir, through, ledger) {
            Meeting::Went => Some(sampled.pdf),
            Meeting::Ended | Meeting::Scatter(..) => None,
        }
    }

    /// Scatters in a given direction, into a small solid angle (sr) about it. False where no light goes there.
    pub fn scatter_towards(
        &mut self,
        vertex: &Vertex,
        (scatter, frame): (&Scatter, &Frame),
        (dir, solid_angle): (DVec3, f64),
        ledger: &mut Ledger,
    ) -> bool {
        let (d_in, d_out) = (frame.to_local(self.ray.dir), frame.to_local(dir));
        let (values, alone) = {
            let sides = self.sides(vertex, scatter);
            let (values, alone) = sides.eval(scatter, d_in, d_out);
            let facets = sides.facets(scatter, (d_in, d_out), &values);
            self.beam.scale_lanes(&lanes::<M, _>(|lane| values[lane] * d_out.z.abs() * solid_angle));
            self.beam.scatter(facets.as_ref(), [self.ray.dir, dir], self.is_from_eye());
            (values, alone)
        };
        if values.as_slice().iter().all(|value| *value <= 0.0) {
            return false;
        }
        if alone {
            self.beam.part();
        }
        self.trail = self.trail.then(scatter.event());
        self.unlink();
        self.tell(Letter::of(scatter.event(), d_out.z < 0.0));
        // The weight is that of few paths, and no reason to end one.
        self.start_weight = self.start_weight.min(self.beam.weight());
        matches!(self.go(vertex, dir, d_out.z < 0.0, ledger), Meeting::Went)
    }

    /// What `scatter` depends on at `vertex`: indices on both sides of the face, or what the material is there.
    pub fn sides(&self, vertex: &Vertex, scatter: &Scatter) -> FaceSides<M> {
        if scatter.refracts() {
            return FaceSides { here: self.index_here(), beyond: self.index_beyond(vertex), matter: true, looks: None };
        }
        let air = lanes::<M, _>(|_| 1.0);
        let looks = scatter.principled().map(|principled| Box::new(self.looks(self.point_at(vertex, principled))));
        FaceSides { here: air, beyond: air, matter: looks.is_some(), looks }
    }

    /// What the ordinary material of a face is where it was met.
    fn point_at<'v>(&self, vertex: &'v Vertex, principled: &Principled) -> &'v Point {
        vertex.point_of(principled, self.world)
    }

    /// A surface at a place, in every lane.
    fn looks(&self, point: &Point) -> M::Lanes<Look> {
        lanes::<M, _>(|lane| point.look(Some(self.optics.reflectance(lane))))
    }

    /// Goes straight on through an ordinary material by chance, as much as it lets through: what is cut out of it, and a sheet
    /// that transmits. False where the path is to scatter; it then stands for that share alone.
    pub(super) fn slips_through(&mut self, vertex: &Vertex, principled: &Principled, ledger: &mut Ledger) -> bool {
        if !principled.surface.lets_through() {
            return false;
        }
        let looks = self.looks(self.point_at(vertex, principled));
        let wi = Frame::about(vertex.normal).to_local(-self.ray.dir);
        let share = Self::passing(principled, wi, &looks);
        // By the mean of the primaries, so that no lane decides.
        let chance = principled.passes(wi, &Look { tint: looks[0].mean, ..looks[0] }).clamp(0.0, 1.0);
        let before = self.beam.carried();
        if self.rng.uniform() < chance {
            self.beam.scale_lanes(&lanes::<M, _>(|lane| share[lane] / chance));
            ledger.by_chance(self.beam.carried() - before);
            return true;
        }
        let stays = 1.0 - chance;
        let through = self.beam.carried_with(&lanes::<M, _>(|lane| share[lane] * self.beam.amount(lane).power()));
        self.beam.scale(looks[0].opacity / stays);
        ledger.by_chance((before - through) / stays - before);
        // What is not cut out and neither goes straight through has to be booked as the material's.
        self.absorb(vertex.hit.site.part, (before - through) / stays - self.beam.carried(), ledger);
        false
    }

    /// What an ordinary material lets through unbent, per lane.
    pub(super) fn share_through(&self, vertex: &Vertex, principled: &Principled) -> M::Lanes<f64> {
        let looks = self.looks(self.point_at(vertex, principled));
        let wi = Frame::about(vertex.normal).to_local(-self.ray.dir);
        Self::passing(principled, wi, &looks)
    }

    fn passing(principled: &Principled, wi: DVec3, looks: &M::Lanes<Look>) -> M::Lanes<f64> {
        lanes::<M, _>(|lane| principled.passes(wi, &looks[lane]))
    }
}
