//! The vertex step that all estimators share: advance to the next thing, and turn there.

use super::beam::Beam;
use super::ledger::Ledger;
use crate::base::path::{Event, Trail};
use crate::base::rng::Rng;
use crate::base::warp::Frame;
#[cfg(test)]
use crate::world::Planted;
use crate::world::World;
use crate::world::eye::Arrival;
use crate::world::fresnel::{reflect, refract};
use crate::world::geometry::{Hit, Ray};
use crate::world::interior::Interior;
use crate::world::lamp::Lamp;
use crate::world::scatter::Scatter;
use crate::world::surface::{FaceOptics, Films, Surface};
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
pub struct Walker<'w> {
    pub world: &'w World,
    pub travel: Travel,
    pub ray: Ray,
    pub beam: Beam,
    /// Weight at the start: roulette compares with it.
    start_weight: f64,
    pub trail: Trail,
    pub interior: Interior,
    pub rng: Rng,
    /// Vertices so far.
    pub events: u32,
    /// What the next interface does, if it is not left to chance.
    forced: Option<Branch>,
    /// What the interface ahead does with light, where it is already known.
    ahead: Option<Turn>,
    /// How often the path was split.
    splits: u8,
}

/// One of the two ways on from an interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Branch {
    Reflected,
    Refracted,
}

/// What an interface does with unpolarised light.
#[derive(Debug, Clone, Copy)]
struct Turn {
    reflected: f64,
    transmitted: f64,
    absorbed: f64,
    /// Where the transmitted light goes; none if there is none.
    refracted: Option<DVec3>,
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

/// What the face at a vertex asks for.
pub enum Meeting<'w> {
    /// The path ended here and is booked.
    Ended,
    /// The path went on, past a specular event or straight through.
    Went,
    /// A scatterer: the estimator decides what it does here before the path goes on with [`Walker::scatter`].
    Scatter(&'w Scatter, Frame),
}

impl<'w> Walker<'w> {
    /// Most splits of a path that may scatter.
    pub const MOST_SPLITS: u8 = 2;

    pub fn new(world: &'w World, travel: Travel, ray: Ray, weight: f64, interior: Interior, rng: Rng) -> Self {
        Walker {
            world,
            travel,
            ray,
            beam: Beam::new(weight),
            start_weight: weight,
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
        let hit = self.world.geometry.intersect(&self.ray, f64::INFINITY);
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
        let outside = dir.dot(hit.normal) < 0.0;
        let normal = if outside { hit.shading } else { -hit.shading };
        Met::Face(Vertex { outside, normal, hit })
    }

    /// Beer–Lambert over `length` metres of the medium that the ray runs in.
    fn attenuate(&mut self, length: f64, ledger: &mut Ledger) {
        if let Some((part, solid)) = self.world_top()
            && solid.absorption_per_m > 0.0
        {
            let before = self.beam.carried();
            self.beam.scale((-solid.absorption_per_m * length).exp());
            self.absorb(part, before - self.beam.carried(), ledger);
        }
    }

    fn world_top(&self) -> Option<(u32, &'w crate::world::interior::Solid)> {
        self.interior.top(&self.world.solids)
    }

    /// Refractive index where the path is now. Radiance over index squared is what a path from the eye carries, so the
    /// factor (n_eye/n_here)² is applied once, where light is picked up.
    pub fn index_here(&self) -> f64 {
        self.world.index_in(&self.interior)
    }

    pub fn optics(&self, vertex: &Vertex) -> &'w FaceOptics {
        &self.world.faces[vertex.hit.site.part as usize][vertex.hit.site.face as usize]
    }

    /// The lamp at `vertex` that shines along the path towards the eye.
    pub fn lamp_at(&self, vertex: &Vertex) -> Option<Shining<'w>> {
        let (site, world) = (vertex.hit.site, self.world);
        let index = world.lamps.of_face(site.part as usize, site.face as usize)?;
        let lamp = &world.lamps.all()[index];
        let cos = -self.ray.dir.dot(vertex.hit.normal);
        let luminance = lamp.luminance(cos);
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
        if self.heal(vertex, ledger) {
            // Inside a solid of higher priority a face is not there.
            let hidden = self.interior.top_without(part, &world.solids).is_some_and(|(other, above)| {
                world.solids[part as usize].as_ref().is_some_and(|own| {
                    above.priority > own.priority || (above.priority == own.priority && other < part)
                })
            });
            if hidden {
                self.pass_through(vertex);
                return Meeting::Went;
            }
        }
        match &self.optics(vertex).surface {
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
                let Some(s) = slide.s(vertex.hit.local) else {
                    self.absorb(part, before, ledger);
                    return Meeting::Ended;
                };
                self.beam.cross(slide, s);
                self.absorb(part, before - self.beam.carried(), ledger);
                self.trail = self.trail.then(Event::Specular);
                self.pass_through(vertex);
                self.roulette(ledger)
            }
            Surface::Mirror(mirror) => {
                let cos_i = -self.ray.dir.dot(vertex.normal);
                let power = mirror.power(self.index_here(), cos_i);
                ledger.check_vertex(power.reflectance(), power.transmittance(), power.absorptance());
                self.absorb(part, self.beam.carried() * power.absorptance(), ledger);
                self.beam.scale(power.reflectance());
                self.trail = self.trail.then(Event::Specular);
                self.go(vertex, reflect(self.ray.dir, vertex.normal), false, ledger)
            }
            Surface::Interface(films) => {
                let turn = ahead.unwrap_or_else(|| self.turn(vertex, films));
                let Turn { reflected: r, transmitted: t, absorbed: a, refracted } = turn;
                ledger.check_vertex(r, t, a);
                self.trail = self.trail.then(Event::Specular);
                let (weight, absorbed, branch) = match self.forced.take() {
                    // The absorbed share is booked by the refracted branch alone.
                    Some(Branch::Reflected) => (r, 0.0, Branch::Reflected),
                    Some(Branch::Refracted) => (t, a, Branch::Refracted),
                    None if self.rng.uniform() * (r + t) >= r => (r + t, a, Branch::Refracted),
                    None => (r + t, a, Branch::Reflected),
                };
                self.absorb(part, self.beam.carried() * absorbed, ledger);
                self.beam.scale(weight);
                match (branch, refracted) {
                    (Branch::Refracted, Some(dir)) => self.go(vertex, dir, true, ledger),
                    (Branch::Reflected, _) | (Branch::Refracted, None) => {
                        self.go(vertex, reflect(self.ray.dir, vertex.normal), false, ledger)
                    }
                }
            }
            Surface::Scatter(scatter) => Meeting::Scatter(scatter, Frame::about(vertex.normal)),
        }
    }

    /// Splits a path at an interface where both ways carry at least `least` of the power: the returned path has been
    /// reflected there with its share, this one will be refracted when it [meets](Walker::meet) the vertex. Through a
    /// combiner the eye sees two worlds, and what is faint in one of them (a lamp's glint) should not wait for a rare
    /// choice. At most `most` times on one path.
    pub fn split(&mut self, vertex: &Vertex, least: f64, most: u8, ledger: &mut Ledger) -> Option<Walker<'w>> {
        if self.splits >= most {
            return None;
        }
        let Surface::Interface(films) = &self.optics(vertex).surface else { return None };
        self.heal(vertex, ledger);
        if self.index_here() == self.index_beyond(vertex) {
            return None;
        }
        let turn = self.turn(vertex, films);
        self.ahead = Some(turn);
        if turn.reflected.min(turn.transmitted) < least {
            return None;
        }
        turn.refracted?;
        self.splits += 1;
        let mut reflected = self.clone();
        reflected.rng = self.rng.fork();
        reflected.forced = Some(Branch::Reflected);
        self.forced = Some(Branch::Refracted);
        match reflected.meet(vertex, ledger) {
            Meeting::Went => Some(reflected),
            Meeting::Ended | Meeting::Scatter(..) => None,
        }
    }

    /// What the interface at `vertex` does, in the solids that are around the ray now.
    fn turn(&self, vertex: &Vertex, films: &Films) -> Turn {
        let (n1, n2) = (self.index_here(), self.index_beyond(vertex));
        let cos_i = -self.ray.dir.dot(vertex.normal);
        let power = films.power(n1, n2, cos_i, vertex.outside, self.world.wavelength_nm);
        let (r, t) = (power.reflectance(), power.transmittance());
        let refracted = if t > 0.0 { refract(self.ray.dir, vertex.normal, n1 / n2) } else { None };
        // Rounding at the critical angle may leave power to a direction that does not exist.
        let (reflected, transmitted) = if refracted.is_some() { (r, t) } else { (r + t, 0.0) };
        #[cfg(test)]
        let (reflected, transmitted) = if self.world.planted == (Planted::Leak { part: vertex.hit.site.part }) {
            (0.99 * reflected, 0.99 * transmitted)
        } else {
            (reflected, transmitted)
        };
        Turn { reflected, transmitted, absorbed: power.absorptance(), refracted }
    }

    /// Makes the solids around the ray agree with what the hit proves, once per vertex however often it is asked for.
    /// Returns whether the face belongs to a solid.
    fn heal(&mut self, vertex: &Vertex, ledger: &mut Ledger) -> bool {
        let part = vertex.hit.site.part;
        let solid = self.world.solids[part as usize].is_some();
        if solid {
            if self.interior.contains(part) == vertex.outside {
                ledger.mismatches += 1;
            }
            self.interior.heal(part, !vertex.outside);
        }
        solid
    }

    /// Books what `part` takes.
    fn absorb(&self, part: u32, amount: f64, ledger: &mut Ledger) {
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

    /// Whether the path has been split before: it is past a combiner's first face.
    pub fn was_split(&self) -> bool {
        self.splits > 0
    }

    /// Goes on without chance: through what transmits, back from what only reflects. False (and the path stays) at
    /// what is not specular.
    pub fn go_straight_on(&mut self, vertex: &Vertex, ledger: &mut Ledger) -> bool {
        self.events += 1;
        match &self.optics(vertex).surface {
            Surface::Absorber | Surface::Scatter(_) => false,
            Surface::Absent => {
                self.pass_through(vertex);
                true
            }
            Surface::Slide(_) | Surface::Mirror(_) => matches!(self.meet(vertex, ledger), Meeting::Went),
            Surface::Interface(films) => {
                self.heal(vertex, ledger);
                let turn = self.turn(vertex, films);
                let turned = match turn.refracted {
                    Some(dir) => {
                        self.beam.scale(turn.transmitted);
                        self.go(vertex, dir, true, ledger)
                    }
                    None => self.go(vertex, reflect(self.ray.dir, vertex.normal), false, ledger),
                };
                matches!(turned, Meeting::Went)
            }
        }
    }

    /// Scatters at a vertex for which [`Walker::meet`] said `Scatter`. Returns the direction's density per steradian
    /// while the path goes on.
    pub fn scatter(&mut self, vertex: &Vertex, scatter: &Scatter, frame: &Frame, ledger: &mut Ledger) -> Option<f64> {
        let part = vertex.hit.site.part;
        let d_in = frame.to_local(self.ray.dir);
        let [reflected, transmitted] = scatter.albedo(-d_in.z);
        self.absorb(part, self.beam.carried() * (1.0 - reflected - transmitted), ledger);
        self.trail = self.trail.then(scatter.event());
        let u = [self.rng.uniform(), self.rng.uniform(), self.rng.uniform()];
        let sampled = scatter.sample(d_in, u)?;
        self.beam.scale(sampled.weight);
        let through = sampled.dir.z < 0.0;
        match self.go(vertex, frame.to_world(sampled.dir), through, ledger) {
            Meeting::Went => Some(sampled.pdf),
            Meeting::Ended | Meeting::Scatter(..) => None,
        }
    }

    /// Index of the medium on the side where light is picked up (`through` the face or not), and the medium's
    /// transmittance over `length` metres there.
    pub fn beyond(&self, vertex: &Vertex, through: bool, length: f64) -> (f64, f64) {
        let there = if through { self.interior_beyond(vertex) } else { self.interior.clone() };
        let top = there.top(&self.world.solids).map(|(_, solid)| *solid);
        top.map_or((1.0, 1.0), |solid| {
            let depth = if solid.absorption_per_m > 0.0 { solid.absorption_per_m * length } else { 0.0 };
            (solid.index, (-depth).exp())
        })
    }

    /// The index behind the face: what fills the space once the ray has gone through.
    fn index_beyond(&self, vertex: &Vertex) -> f64 {
        self.world.index_in(&self.interior_beyond(vertex))
    }

    /// The solids around the ray once it has gone through the face.
    fn interior_beyond(&self, vertex: &Vertex) -> Interior {
        let mut beyond = self.interior.clone();
        let part = vertex.hit.site.part;
        if self.world.solids[part as usize].is_some() {
            if vertex.outside { beyond.enter(part) } else { beyond.leave(part) }
        }
        beyond
    }

    /// Goes straight on behind the face.
    fn pass_through(&mut self, vertex: &Vertex) {
        self.interior = self.interior_beyond(vertex);
        self.ray = Ray { origin: vertex.hit.point, dir: self.ray.dir, from: Some(vertex.hit.site) };
    }

    /// Leaves a vertex in `dir`, through the face or back from it.
    fn go(&mut self, vertex: &Vertex, dir: DVec3, through: bool, ledger: &mut Ledger) -> Meeting<'w> {
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
        if self.beam.weight <= 0.0 {
            return Meeting::Ended;
        }
        if self.events <= FREE_EVENTS {
            return Meeting::Went;
        }
        // Light that total reflection traps loses nothing; only the event count can end it.
        let trapped: f64 = if self.events > TRAPPED_EVENTS { 0.999 } else { 1.0 };
        let survive = (self.beam.weight / self.start_weight * 4.0).clamp(0.05, 1.0) * trapped;
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
