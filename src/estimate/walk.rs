//! The vertex step that all estimators share: advance to the next thing, and turn there.

use super::ledger::{Ledger, cost};
use super::specular_event::{Branch, SpecularEvent};
use super::throughput::Throughput;
pub use super::tuning::walk::SPLIT_FIRST_EVENTS;
use eyebox_base::chain::{Chain, Link, Step};
use eyebox_base::lpe::{Letter, LpeState};
use eyebox_base::path::{Event, Trail};
use eyebox_base::rng::Rng;
use eyebox_base::warp::Frame;
use eyebox_world::World;
use eyebox_world::contact::Touching;
use eyebox_world::eye::Arrival;
use eyebox_world::fresnel::reflect;
use eyebox_world::geometry::{Hit, Ray, Site};
use eyebox_world::interior::Interior;
use eyebox_world::mode::{Mode, lanes};
use eyebox_world::optics::Optics;
use eyebox_world::pile::Pile;
use eyebox_world::scatter::{Point, Principled, Scatter};
use eyebox_world::surface::{FaceOptics, Surface};
use glam::DVec3;
use std::sync::OnceLock;

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
    pub(super) beside: Option<Site>,
    /// What the ray meets at once, where it went through the first of two faces that lie on each other.
    pub(super) pending: Option<Hit>,
    pub beam: Throughput<M>,
    /// Weight at the start: roulette compares with it.
    pub(super) start_weight: f64,
    pub trail: Trail,
    /// What light path expressions know of it, where the world has any.
    pub told: LpeState,
    pub interior: Interior,
    pub rng: Rng,
    /// Vertices so far.
    pub events: u32,
    /// What the next interface does, if it is not left to chance.
    pub(super) forced: Option<Branch>,
    /// Which order the next grating is left in, if that is not left to chance.
    pub(super) order: Option<(Step, i32)>,
    /// What the interface ahead does with light, where it is already known.
    pub(super) ahead: Option<SpecularEvent<M>>,
    /// Least probability of either way on from an interface: above 0, faint ways are taken more often than their share, and
    /// count less.
    pub least_chance: f64,
    /// Share of what it started with below which roulette asks whether a long path is worth going on with.
    pub worth: f64,
    /// How often the path was split.
    pub(super) splits: u8,
    /// The specular faces so far, if somebody asked.
    pub(super) chain: Option<Box<Chain>>,
    /// The specular face that was met last.
    pub(super) last: Option<Link>,
}

/// What a ray met.
#[allow(clippy::large_enum_variant)] // it lives for one step, on the stack
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
    /// What one that goes back from this face meets next, at no distance: the other of the two, where it came through that.
    pub back: Option<Hit>,
    /// The other face here, of one of these kinds.
    pub beside: Option<Site>,
    /// The ray arrives at the outside of the part's face.
    pub outside: bool,
    /// Unit shading normal on the side where the ray arrives.
    pub normal: DVec3,
    /// What an ordinary material is here, once somebody has asked.
    pub(super) point: OnceLock<Box<Point>>,
}

impl Vertex {
    /// What the ordinary material of this face is here: its textures are read once.
    pub fn point_of(&self, principled: &Principled, world: &World) -> &Point {
        let read = || {
            let to_world = world.geometry.part_to_world(self.hit.site.part);
            Box::new(principled.at(&self.hit, &to_world).seen_about(self.normal))
        };
        self.point.get_or_init(read)
    }

    /// Whether a direction that the normal for optics says to lead `through` the face, or back from it, does so by the face
    /// itself. Interpolated and mapped normals can tell it otherwise: no light goes that way.
    pub fn is_left_by(&self, dir: DVec3, through: bool) -> bool {
        (dir.dot(self.hit.normal) > 0.0) == (self.outside != through)
    }

    /// What a ray that leaves here, `through` the face or back from it, meets at no distance.
    pub fn at_once(&self, through: bool) -> Option<&Hit> {
        if through { self.then.as_ref() } else { self.back.as_ref() }
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
    /// [`Walker::worth`] of a path that is one of many.
    pub const WORTH: f64 = 0.25;

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

    /// Whether it carries importance, and not light.
    pub fn is_from_eye(&self) -> bool {
        self.travel == Travel::FromEye
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
        let beam = Throughput::new(weights, ray.dir);
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
            told: LpeState::default(),
            interior,
            rng,
            events: 0,
            forced: None,
            order: None,
            ahead: None,
            least_chance: 0.0,
            worth: Self::WORTH,
            splits: 0,
            chain: None,
            last: None,
        }
    }

    /// The same from a place on a lamp with this normal: where that lies on glass, light which goes there meets it at once.
    #[must_use]
    pub fn from_face(mut self, normal: DVec3) -> Self {
        let (world, dir) = (self.world, self.ray.dir);
        let glass =
            self.ray.from.and_then(|site| world.contacts.under(&world.geometry, site, [self.ray.origin, normal, dir]));
        self.beside = glass.map(|(glass, _)| glass.site);
        self.pending = glass.map(|(glass, _)| glass).filter(|glass| dir.dot(glass.normal) < 0.0);
        self
    }

    /// Tells light path expressions of an event.
    pub(super) fn tell(&mut self, letter: Letter) {
        if let Some(sieve) = &self.world.sieve {
            self.told = match self.travel {
                Travel::FromEye => sieve.after(self.told, letter),
                Travel::FromLamp => sieve.before(self.told, letter),
            };
        }
    }

    /// Weight that the path started with.
    pub(super) fn start_weight(&self) -> f64 {
        self.start_weight
    }

    /// Weight without slides over what the path started with.
    pub fn share(&self) -> f64 {
        self.beam.weight() / self.start_weight
    }

    /// Runs along the ray to the next thing.
    pub fn advance(&mut self, ledger: &mut Ledger) -> Met {
        ledger.work += cost::STEP;
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
        let (mut touching, mut then, mut back, mut hit) = (None, None, None, hit);
        let beside = if geometry.has_no_films() {
            if at_once {
                // The other one of the two has been met.
                back = contacts.covered(geometry, &hit, dir).map(|[first, _]| first);
                self.ray.from
            } else if let Some(joint) = contacts.joint(geometry, &self.world.solids, &hit) {
                (hit, touching) = (joint.hit, Some(joint.other));
                Some(joint.other.site)
            } else {
                let covered = contacts.covered(geometry, &hit, dir);
                if let Some([first, second]) = covered {
                    (hit, then) = (first, Some(second));
                }
                covered.map(|[_, second]| second.site)
            }
        } else {
            let pile = Pile::at(self.world, &hit, dir);
            let place = if at_once { pile.place_of(hit.site) } else { 0 };
            (hit, touching) = (Hit { t: hit.t, ..pile.hits[place] }, pile.touching_at(place));
            (then, back) = (pile.hits.get(place + 1).copied(), place.checked_sub(1).map(|before| pile.hits[before]));
            pile.beside(geometry, place)
        };
        let outside = dir.dot(hit.normal) < 0.0;
        let shading = self.world.shading(&hit, dir);
        let normal = if outside { shading } else { -shading };
        Met::Face(Vertex { outside, normal, hit, touching, then, back, beside, point: OnceLock::new() })
    }

    /// Beer–Lambert over `length` metres of the medium that the ray runs in.
    pub(super) fn attenuate(&mut self, length: f64, ledger: &mut Ledger) {
        if let Some((part, _)) = self.interior.top(&self.world.solids)
            && let Some(absorption) = self.optics.absorption_in(part)
        {
            let before = self.beam.carried();
            self.beam.scale_lanes(&lanes::<M, _>(|lane| (-absorption[lane] * length).exp()));
            self.absorb(part, before - self.beam.carried(), ledger);
        }
    }

    /// What the face at a vertex is.
    pub fn face(&self, vertex: &Vertex) -> &'w FaceOptics {
        &self.world.faces[vertex.hit.site.part as usize][vertex.hit.site.face as usize]
    }

    /// Whether a face is as if it were not there: behind another that it touches, or in a medium that outranks its own.
    pub(super) fn is_passed(&mut self, vertex: &Vertex, ledger: &mut Ledger) -> bool {
        self.is_behind(vertex) || self.heal(vertex, ledger) && self.is_outranked(vertex)
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
        if self.is_passed(vertex, ledger) {
            self.pass_through(vertex);
            return Meeting::Went;
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
                self.cross(vertex, *index, &s);
                self.absorb(part, before - self.beam.carried(), ledger);
                self.trail = self.trail.then(Event::Specular);
                self.tell(world.slide_letter(*index));
                self.link(vertex, Step::Through);
                self.pass_through(vertex);
                self.roulette(ledger)
            }
            Surface::Sheet(sheet) => {
                self.go_through(vertex, sheet, ledger);
                self.trail = self.trail.then(Event::Specular);
                self.tell(Letter::TransmitStraight);
                self.link(vertex, Step::Through);
                self.pass_through(vertex);
                self.roulette(ledger)
            }
            Surface::Mirror(mirror) => {
                let turn = self.turn_at_mirror(vertex, *mirror);
                self.trail = self.trail.then(Event::Specular);
                self.take_branch(vertex, &turn, Some(Branch::Only), ledger)
            }
            Surface::Splitter(sheet) => {
                let turn = ahead.unwrap_or_else(|| self.turn_at_splitter(vertex, sheet));
                self.trail = self.trail.then(Event::Specular);
                let forced = self.forced.take();
                self.take_branch(vertex, &turn, forced, ledger)
            }
            Surface::Grating(grating) => {
                self.trail = self.trail.then(Event::Specular);
                self.diffract(vertex, grating, ledger)
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
                if let Some(principled) = scatter.principled()
                    && self.slips_through(vertex, principled, ledger)
                {
                    self.pass_through(vertex);
                    return self.roulette(ledger);
                }
                let specular = scatter.specular();
                if specular > 0.0 && self.stays_specular(vertex, scatter, specular, ledger) {
                    self.tell(Letter::ReflectSpecular);
                    self.link(vertex, Step::Back);
                    return self.go(vertex, reflect(self.ray.dir, vertex.normal), false, ledger);
                }
                Meeting::Scatter(scatter, Frame::about(vertex.normal))
            }
        }
    }
}
