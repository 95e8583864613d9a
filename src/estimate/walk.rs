//! The vertex step that all estimators share: advance to the next thing, and turn there.

use super::beam::Beam;
use super::ledger::Ledger;
use super::turn::{Branch, Turn};
use crate::base::path::{Event, Trail};
use crate::base::rng::Rng;
use crate::base::warp::Frame;
use crate::film::accumulate::Light;
#[cfg(test)]
use crate::world::Planted;
use crate::world::World;
use crate::world::contact::Touching;
use crate::world::eye::Arrival;
use crate::world::fresnel::reflect;
use crate::world::geometry::{Hit, Ray, Site};
use crate::world::interior::{Interior, outranks};
use crate::world::lamp::Lamp;
use crate::world::mode::{Mode, lanes};
use crate::world::optics::Optics;
use crate::world::scatter::{Scatter, Sides};
use crate::world::slide::SlideMap;
use crate::world::surface::{FaceOptics, Surface};
use glam::DVec3;

/// Paths from the eye are split at the first interfaces they meet: at both faces of a combiner, so that the image from
/// its front and the ghost from its back are always both there.
pub const SPLIT_FIRST_EVENTS: u32 = 2;

/// Which end a path is walked from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Travel {
    FromEye,
    FromLamp,
}

/// A path under way.
#[derive(Clone)]
pub struct Walker<'w, M: Mode> {
    pub world: &'w World,
    /// Of the pass that the path belongs to.
    pub optics: &'w Optics<M>,
    pub travel: Travel,
    pub ray: Ray,
    /// The other face that the ray starts on, where two solids touch.
    beside: Option<Site>,
    /// What the ray meets at once, where it went through the first of two faces that lie on each other.
    pending: Option<Hit>,
    pub beam: Beam<M>,
    /// Weight at the start: roulette compares with it.
    start_weight: f64,
    pub trail: Trail,
    pub interior: Interior,
    pub rng: Rng,
    /// Vertices so far.
    pub events: u32,
    /// What the next interface does, if it is not left to chance.
    pub(super) forced: Option<Branch>,
    /// What the interface ahead does with light, where it is already known.
    pub(super) ahead: Option<Turn<M>>,
    /// How often the path was split.
    pub(super) splits: u8,
}

/// What a ray met.
pub enum Met {
    /// Nothing: the ray leaves the scene.
    Sky,
    /// The pupil (rays from lamps).
    Pupil(Arrival),
    Face(Vertex),
    /// The path ended on the way (absorbed by the medium, stopped by the eye).
    Ended,
}

/// A hit with its side resolved.
#[derive(Clone)]
pub struct Vertex {
    pub hit: Hit,
    /// The face of another solid that touches here: both are one interface, and `hit` is on the one that holds.
    pub touching: Option<Touching>,
    /// What a ray that goes on through this face meets next, at no distance: a face and what lies on it.
    pub then: Option<Hit>,
    /// The other face here, of one of these kinds.
    pub beside: Option<Site>,
    /// The ray arrives at the outside of the part's face.
    pub outside: bool,
    /// Unit shading normal on the side where the ray arrives.
    pub normal: DVec3,
}

/// A lamp that a path from the eye has met.
pub struct Shining<'w> {
    pub lamp: &'w Lamp,
    /// Its number among the lamps.
    pub index: usize,
    /// Of the angle between the lamp's normal and the way to the eye.
    pub cos: f64,
    /// That way, cd/m²; above 0.
    pub luminance: f64,
}

/// Refractive indices on both sides of a face that scatters.
#[derive(Debug, Clone, Copy)]
pub struct FaceSides<M: Mode> {
    here: M::Lanes<f64>,
    beyond: M::Lanes<f64>,
    /// The face's scattering depends on them.
    matter: bool,
}

impl<M: Mode> FaceSides<M> {
    /// In a lane.
    pub fn of(&self, lane: usize) -> Sides {
        Sides { here: self.here[lane], beyond: self.beyond[lane] }
    }

    /// In the first lane, within the rounding that half vectors of refraction bear.
    fn are_equal(&self) -> bool {
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
}

/// What the face at a vertex asks for.
pub enum Meeting<'w> {
    /// The path ended here and is booked.
    Ended,
    /// The path went on, past a specular event or straight through.
    Went,
    /// A scatterer: the estimator decides what it does here before the path goes on with [`Walker::scatter`].
    Scatter(&'w Scatter, Frame),
}

impl<'w, M: Mode> Walker<'w, M> {
    /// Most splits of a path that may scatter.
    pub const MOST_SPLITS: u8 = 2;

    /// A path that starts with the same weight in all lanes.
    pub fn new(
        (world, optics): (&'w World, &'w Optics<M>),
        travel: Travel,
        ray: Ray,
        weight: f64,
        interior: Interior,
        rng: Rng,
    ) -> Self {
        Self::with_weights((world, optics), travel, ray, lanes::<M, _>(|_| weight), interior, rng)
    }

    /// A path that starts with these weights.
    pub fn with_weights(
        (world, optics): (&'w World, &'w Optics<M>),
        travel: Travel,
        ray: Ray,
        weights: M::Lanes<f64>,
        interior: Interior,
        rng: Rng,
    ) -> Self {
        let beam = Beam::new(weights, ray.dir);
        Walker {
            world,
            optics,
            travel,
            ray,
            beside: None,
            pending: None,
            start_weight: beam.weight(),
            beam,
            trail: Trail::START,
            interior,
            rng,
            events: 0,
            forced: None,
            ahead: None,
            splits: 0,
        }
    }

    /// Runs along the ray to the next thing.
    pub fn advance(&mut self, ledger: &mut Ledger) -> Met {
        let pending = self.pending.take().map(|hit| Hit { t: 0.0, ..hit });
        let at_once = pending.is_some();
        let hit = pending.or_else(|| self.world.geometry.intersect_beside(&self.ray, self.beside, f64::INFINITY));
        let t_hit = hit.as_ref().map_or(f64::INFINITY, |hit| hit.t);
        let (origin, dir) = (self.ray.origin, self.ray.dir);
        match self.travel {
            Travel::FromLamp => {
                if let Some(arrival) = self.world.eye.arrive(origin, dir, t_hit) {
                    self.attenuate(arrival.t, ledger);
                    return Met::Pupil(arrival);
                }
            }
            // The eye takes what falls into it, so light that would have to pass through the pupil does not come.
            Travel::FromEye if self.events > 0 => {
                if self.world.eye.blocks_reversed(origin, dir, t_hit) {
                    ledger.arrived += self.beam.carried();
                    return Met::Ended;
                }
            }
            Travel::FromEye => {}
        }
        let Some(hit) = hit else { return Met::Sky };
        self.attenuate(hit.t, ledger);
        let (geometry, contacts) = (&self.world.geometry, &self.world.contacts);
        let (mut touching, mut then, mut hit) = (None, None, hit);
        if at_once {
            // The other one of the two has been met.
        } else if let Some(joint) = contacts.joint(geometry, &self.world.solids, &hit) {
            (hit, touching) = (joint.hit, Some(joint.other));
        } else if let Some([first, second]) = contacts.covered(geometry, &hit, dir) {
            (hit, then) = (first, Some(second));
        }
        let other = touching.map(|other| other.site).or(then.map(|hit| hit.site));
        let beside = if at_once { self.ray.from } else { other };
        let outside = dir.dot(hit.normal) < 0.0;
        let normal = if outside { hit.shading } else { -hit.shading };
        Met::Face(Vertex { outside, normal, hit, touching, then, beside })
    }

    /// Beer–Lambert over `length` metres of the medium that the ray runs in.
    fn attenuate(&mut self, length: f64, ledger: &mut Ledger) {
        if let Some((part, _)) = self.interior.top(&self.world.solids)
            && let Some(absorption) = self.optics.absorption_in(part)
        {
            let before = self.beam.carried();
            self.beam.scale_lanes(&lanes::<M, _>(|lane| (-absorption[lane] * length).exp()));
            self.absorb(part, before - self.beam.carried(), ledger);
        }
    }

    /// Refractive index where the path is now.
    pub(super) fn index_here(&self) -> M::Lanes<f64> {
        self.index_in(&self.interior)
    }

    pub(super) fn index_in(&self, interior: &Interior) -> M::Lanes<f64> {
        self.optics.index_in(interior.top(&self.world.solids).map(|(part, _)| part))
    }

    /// Adds the light that a path from the eye picks up where it is: `amounts` per lane, luminance.
    ///
    /// Radiance over index squared is what such a path carries, so the factor (n_eye/n_here)² is applied here, once.
    pub fn pick_up(&self, out: &mut [Light], amounts: &M::Lanes<f64>) {
        self.pick_up_in(&self.index_here(), out, amounts);
    }

    /// Adds the light of a lamp that the path has met, `factor` times.
    pub fn see(&self, out: &mut [Light], seen: &Shining<'_>, factor: f64) {
        let tint = self.optics.lamp(seen.index);
        let index = self.index_here();
        let amounts = lanes::<M, _>(|lane| seen.luminance * factor * tint[lane] / (index[lane] * index[lane]));
        match seen.lamp.polarisation {
            None => self.beam.deposit(self.optics, out, &amounts),
            Some(light) => self.beam.polarised(light, self.ray.dir, true).deposit(self.optics, out, &amounts),
        }
    }

    /// [`Walker::pick_up`] in a medium of this index.
    pub fn pick_up_in(&self, index: &M::Lanes<f64>, out: &mut [Light], amounts: &M::Lanes<f64>) {
        self.beam.deposit(self.optics, out, &lanes::<M, _>(|lane| amounts[lane] / (index[lane] * index[lane])));
    }

    /// [`Walker::pick_up_in`], of the first lane alone, which stands for all.
    pub fn pick_up_alone(&self, index: &M::Lanes<f64>, out: &mut [Light], amounts: &M::Lanes<f64>) {
        let mut beam = self.beam;
        beam.part();
        beam.deposit(self.optics, out, &lanes::<M, _>(|lane| amounts[lane] / (index[lane] * index[lane])));
    }

    /// What the face at a vertex is.
    pub fn face(&self, vertex: &Vertex) -> &'w FaceOptics {
        &self.world.faces[vertex.hit.site.part as usize][vertex.hit.site.face as usize]
    }

    /// The lamp at `vertex` that shines along the path towards the eye.
    pub fn lamp_at(&self, vertex: &Vertex) -> Option<Shining<'w>> {
        let (site, world) = (vertex.hit.site, self.world);
        let index = world.lamps.of_face(site.part as usize, site.face as usize)?;
        let lamp = &world.lamps.all()[index];
        let cos = -self.ray.dir.dot(vertex.hit.normal);
        let luminance = lamp.luminance_along(vertex.hit.normal, -self.ray.dir);
        (luminance > 0.0).then_some(Shining { lamp, index, cos, luminance })
    }

    /// Does at `vertex` what the face asks for.
    pub fn meet(&mut self, vertex: &Vertex, ledger: &mut Ledger) -> Meeting<'w> {
        self.events += 1;
        let world = self.world;
        let part = vertex.hit.site.part;
        let ahead = self.ahead.take();
        if self.events >= Ledger::MOST_EVENTS {
            ledger.cut += self.beam.carried();
            return Meeting::Ended;
        }
        if self.is_behind(vertex) {
            self.pass_through(vertex);
            return Meeting::Went;
        }
        if self.heal(vertex, ledger) {
            // Inside a solid of higher priority a face is not there.
            let above = self.interior.top_without(part, &world.solids);
            if above.is_some_and(|(other, _)| outranks(&world.solids, other, part)) {
                self.pass_through(vertex);
                return Meeting::Went;
            }
        }
        match &self.face(vertex).surface {
            Surface::Absent => {
                self.pass_through(vertex);
                Meeting::Went
            }
            Surface::Absorber => {
                self.absorb(part, self.beam.carried(), ledger);
                Meeting::Ended
            }
            Surface::Slide(index) => {
                let slide = &world.slides[*index];
                let before = self.beam.carried();
                let Some(s) = self.optics.slide(slide, vertex.hit.local) else {
                    self.absorb(part, before, ledger);
                    return Meeting::Ended;
                };
                self.cross(vertex, slide, &s);
                self.absorb(part, before - self.beam.carried(), ledger);
                self.trail = self.trail.then(Event::Specular);
                self.pass_through(vertex);
                self.roulette(ledger)
            }
            Surface::Sheet(sheet) => {
                self.go_through(vertex, sheet, ledger);
                self.trail = self.trail.then(Event::Specular);
                self.pass_through(vertex);
                self.roulette(ledger)
            }
            Surface::Mirror(mirror) => {
                let turn = self.turn_at_mirror(vertex, *mirror);
                self.trail = self.trail.then(Event::Specular);
                self.take_branch(vertex, &turn, Some(Branch::Only), ledger)
            }
            Surface::Interface(coating) => {
                let turn = ahead.unwrap_or_else(|| self.turn(vertex, *coating));
                self.trail = self.trail.then(Event::Specular);
                let forced = self.forced.take();
                self.take_branch(vertex, &turn, forced, ledger)
            }
            Surface::Scatter(scatter) => {
                if scatter.refracts() && self.sides(vertex, scatter).are_equal() {
                    // Between equal media there is no interface.
                    self.pass_through(vertex);
                    return Meeting::Went;
                }
                let specular = scatter.specular();
                if specular > 0.0 && self.stays_specular(vertex, scatter, specular, ledger) {
                    return self.go(vertex, reflect(self.ray.dir, vertex.normal), false, ledger);
                }
                Meeting::Scatter(scatter, Frame::about(vertex.normal))
            }
        }
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

    /// Chooses between what a face reflects specularly and what it scatters, by what they carry with a floor for both.
    /// The beam then stands for the chosen one.
    fn stays_specular(&mut self, vertex: &Vertex, scatter: &Scatter, specular: f64, ledger: &mut Ledger) -> bool {
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

    /// Whether the ray has crossed the interface of two solids that touch already: at the face of one of them it went
    /// from the one into the other, and here is the other's.
    pub(super) fn is_behind(&self, vertex: &Vertex) -> bool {
        vertex.touching.is_some_and(|other| {
            let outside = self.interior.contains(vertex.hit.site.part) == vertex.outside;
            let other_outside = vertex.outside == other.flush;
            outside && self.interior.contains(other.site.part) == other_outside
        })
    }

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
    fn cross(&mut self, vertex: &Vertex, slide: &SlideMap, s: &M::Lanes<f64>) {
        let part = vertex.hit.site.part;
        let across =
            slide.polarisation_axis().map(|axis| self.world.geometry.part_to_world(part).transform_vector3(axis));
        self.beam.cross(slide, s, across, self.ray.dir, self.travel == Travel::FromEye);
    }

    /// Scatters at a vertex for which [`Walker::meet`] said `Scatter`. Returns the direction's density per steradian
    /// while the path goes on.
    pub fn scatter(&mut self, vertex: &Vertex, scatter: &Scatter, frame: &Frame, ledger: &mut Ledger) -> Option<f64> {
        let part = vertex.hit.site.part;
        let d_in = frame.to_local(self.ray.dir);
        let sides = self.sides(vertex, scatter);
        // What the face reflects specularly besides is not this path's.
        let absorbed = 1.0 - scatter.specular() - scatter.albedo(-d_in.z);
        self.absorb(part, self.beam.carried() * absorbed, ledger);
        self.trail = self.trail.then(scatter.event());
        let u = [self.rng.uniform(), self.rng.uniform(), self.rng.uniform()];
        let sampled = scatter.sample(d_in, sides.of(0), u)?;
        let through = sampled.dir.z < 0.0;
        if M::LANES == 1 || !scatter.refracts() {
            self.beam.scale(sampled.weight);
        } else {
            let (values, alone) = sides.eval(scatter, d_in, sampled.dir);
            let cos = sampled.dir.z.abs();
            self.beam.scale_lanes(&lanes::<M, _>(|lane| values[lane] * cos / sampled.pdf));
            if alone {
                self.beam.part();
            }
        }
        self.beam.depolarise(frame.to_world(sampled.dir));
        match self.go(vertex, frame.to_world(sampled.dir), through, ledger) {
            Meeting::Went => Some(sampled.pdf),
            Meeting::Ended | Meeting::Scatter(..) => None,
        }
    }

    /// Indices on both sides of the face at `vertex`, as far as `scatter` asks for them.
    pub fn sides(&self, vertex: &Vertex, scatter: &Scatter) -> FaceSides<M> {
        if scatter.refracts() {
            FaceSides { here: self.index_here(), beyond: self.index_beyond(vertex), matter: true }
        } else {
            let air = lanes::<M, _>(|_| 1.0);
            FaceSides { here: air, beyond: air, matter: false }
        }
    }

    /// Index of the medium on the side where light is picked up (`through` the face or not), and the medium's
    /// transmittance over `length` metres there.
    pub fn beyond(&self, vertex: &Vertex, through: bool, length: f64) -> (M::Lanes<f64>, M::Lanes<f64>) {
        let there = if through { self.interior_beyond(vertex) } else { self.interior.clone() };
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

    /// The index behind the face: what fills the space once the ray has gone through.
    pub(super) fn index_beyond(&self, vertex: &Vertex) -> M::Lanes<f64> {
        self.index_in(&self.interior_beyond(vertex))
    }

    /// The solids around the ray once it has gone through the face.
    fn interior_beyond(&self, vertex: &Vertex) -> Interior {
        let mut beyond = self.interior.clone();
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

    /// Goes straight on behind the face.
    fn pass_through(&mut self, vertex: &Vertex) {
        self.interior = self.interior_beyond(vertex);
        self.ray = Ray { origin: vertex.hit.point, dir: self.ray.dir, from: Some(vertex.hit.site) };
        (self.beside, self.pending) = (vertex.beside, vertex.then);
    }

    /// Leaves a vertex in `dir`, through the face or back from it.
    pub(super) fn go(&mut self, vertex: &Vertex, dir: DVec3, through: bool, ledger: &mut Ledger) -> Meeting<'w> {
        let leaves_outside = dir.dot(vertex.hit.normal) > 0.0;
        if leaves_outside != (vertex.outside != through) {
            // Only the interpolated normals of meshes can do this.
            ledger.wrong_side += self.beam.carried();
            return Meeting::Ended;
        }
        if through {
            self.interior = self.interior_beyond(vertex);
        }
        self.ray = Ray { origin: vertex.hit.point, dir, from: Some(vertex.hit.site) };
        (self.beside, self.pending) = (vertex.beside, vertex.then.filter(|_| through));
        self.roulette(ledger)
    }

    /// Unbiased roulette on the weight without slides: the picture at another contrast makes the same decisions.
    fn roulette(&mut self, ledger: &mut Ledger) -> Meeting<'w> {
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
        let trapped: f64 = if halves && self.events.trailing_zeros() % 2 == 0 { 0.5 } else { 1.0 };
        let survive = (weight / self.start_weight * 4.0).clamp(0.05, 1.0) * trapped;
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
