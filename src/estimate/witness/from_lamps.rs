//! A witness for what rays from the eye trace themselves: light followed from the lamps. From its lamp, and from each scatterer on
//! its way, a path is aimed at a place in the pupil and counts if it gets there; how it is seen by a pupil that it is not aimed at, over
//! mirrors and lenses, it leaves to others; it ends where a face is not the same to light that runs the other way. So what it finds is the
//! least that there is.

use crate::emission::{Emission, Origin, Shots, Starts, Visitor, leave_face};
use crate::ledger::Ledger;
use crate::ownership::Ownership;
use crate::tuning::witness::{MOST_FACES, PATHS};
use crate::walk::{Meeting, Met, Vertex, Walker};
use eyebox_base::ids::GroupId;
use eyebox_base::path::Class;
use eyebox_base::rng::{Rng, Stream};
use eyebox_base::warp;
use eyebox_base::warp::Frame;
use eyebox_film::accumulate::{Light, PlaneKey};
use eyebox_film::plan::{Estimator, Plan, Verdict};
use eyebox_film::totals::{PARTS, part_of};
use eyebox_film::witness::{Sent, Unwatched};
use eyebox_world::World;
use eyebox_world::eye::{Arrival, EyeLens};
use eyebox_world::mode::{Mode, components, lanes};
use eyebox_world::optics::Optics;
use eyebox_world::scatter::Scatter;
use glam::{DVec2, DVec3};

/// Follows the light of lamps to the eye.
pub struct FromLamps<'w> {
    world: &'w World,
    route: Ownership,
    emission: Emission,
    seed: u64,
    /// Pixels of each part of the picture that are traced.
    pixels: Vec<f64>,
    size: [usize; 2],
}

/// Mean luminance of each part of the picture: `[kind of light][part][as the slides are, and open]`.
pub type Parts = Vec<Vec<[f64; 2]>>;

impl<'w> FromLamps<'w> {
    /// What rays from the eye have to trace by this plan and paths from lamps can look for; and what they cannot.
    pub fn new(
        world: &'w World,
        plan: &Plan,
        groups: usize,
        size: [usize; 2],
        seed: u64,
    ) -> (Option<(Self, Vec<Sent>)>, Vec<Unwatched>) {
        let mut unwatched = Vec::new();
        let mut ours = Vec::new();
        for row in &plan.rows {
            if !matches!(row.verdict, Verdict::Own { owner: Estimator::Backward, .. }) {
                continue;
            }
            let lamps = world.lamps.all().iter().any(|lamp| lamp.group == row.group)
                || world.lights.all().iter().any(|light| light.group() == row.group);
            let because = if world.eye.pupil_area_m2() <= 0.0 {
                "no light meets a pupil without extent"
            } else if !lamps {
                "no path starts on the sky"
            } else {
                ours.push((row.group, row.class));
                continue;
            };
            unwatched.push(Unwatched { group: row.group, class: row.class, because: because.to_owned() });
        }
        if ours.is_empty() {
            return (None, unwatched);
        }
        let key = |group: GroupId, class: Class, has_broad: bool| {
            let layer = plan.layer(Estimator::Backward, group, class, has_broad);
            ours.contains(&(group, class)).then_some(PlaneKey { layer, group, takes: 0 })
        };
        let route = Ownership::by(groups, &key);
        let classes = |plane: &PlaneKey| {
            let own = |(group, class): &&(GroupId, Class)| {
                let in_layer = |broad| plan.layer(Estimator::Backward, *group, *class, broad) == plane.layer;
                *group == plane.group && (in_layer(false) || in_layer(true))
            };
            ours.iter().filter(own).map(|(_, class)| *class).collect()
        };
        let sent = route.planes.iter().map(|plane| Sent::new(plane.layer, plane.group, classes(plane))).collect();
        let emission = Emission::new(world, &route, groups, None);
        let mut pixels = vec![0.0; PARTS];
        for pixel in (0..size[0] * size[1]).filter(|pixel| world.eye.wants_index(*pixel)) {
            pixels[0] += 1.0;
            pixels[part_of([pixel % size[0], pixel / size[0]], size)] += 1.0;
        }
        (Some((FromLamps { world, route, emission, seed, pixels, size }, sent)), unwatched)
    }

    /// The number `sample` of samples, each of so many paths; and its counted work.
    pub fn sample<M: Mode>(&self, sample: u64) -> (Parts, u64) {
        let optics = M::optics(self.world, self.seed, sample);
        let mut aimed = Aimed {
            own: self,
            optics: &optics,
            rng: Rng::new(self.seed, Stream::Witness, 5, sample).fork(),
            ledger: Ledger::new(self.world.solids.len()),
            parts: vec![vec![[0.0; 2]; PARTS]; self.route.planes.len()],
            one_way: false,
        };
        let starts = Starts::OfPass;
        let shots = Shots { seed: self.seed, stream: Stream::Witness, pass: sample, paths: PATHS, starts };
        let mut work = 0;
        for chunk in 0..Shots::chunks(PATHS) {
            work += self.emission.chunk((self.world, &optics), shots, chunk, &mut aimed).work;
        }
        for _ in 0..PATHS {
            aimed.straight();
        }
        for parts in &mut aimed.parts {
            for (light, pixels) in parts.iter_mut().zip(&self.pixels) {
                *light = light.map(|sum| if *pixels > 0.0 { sum / pixels } else { 0.0 });
            }
        }
        (aimed.parts, work + aimed.ledger.work)
    }
}

/// Paths on their way to the pupil.
struct Aimed<'a, 'w, M: Mode> {
    own: &'a FromLamps<'w>,
    optics: &'a Optics<M>,
    rng: Rng,
    ledger: Ledger,
    parts: Parts,
    /// The path has met what light that runs the other way sees differently.
    one_way: bool,
}

/// Whether light of lamps and rays from the eye may see a face differently: its normal for optics is not its own (interpolated, from a
/// normal map), or it scatters as a table says that was measured one way.
fn is_one_way(vertex: &Vertex, scatter: Option<&Scatter>) -> bool {
    const ALIKE: f64 = 1.0 - 1e-9;
    vertex.normal.dot(vertex.hit.normal).abs() < ALIKE || matches!(scatter, Some(Scatter::Measured(_)))
}

impl<M: Mode> Aimed<'_, '_, M> {
    /// A place in the pupil as it is seen from a point: the unit direction to it, and the solid angle (sr) that the whole pupil would
    /// fill if all of it were there. None from behind.
    fn towards_pupil(&mut self, from: DVec3) -> Option<(DVec3, f64)> {
        let eye: &EyeLens = &self.own.world.eye;
        let place: DVec2 = eye.pupil_radius_m() * warp::disk([self.rng.uniform(), self.rng.uniform()]);
        let way = eye.ray_of(DVec2::ZERO, place).0 - from;
        let distance2 = way.length_squared();
        let dir = way.try_normalize()?;
        let cos = -dir.dot(eye.look());
        (cos > 0.0).then(|| (dir, eye.pupil_area_m2() * cos / distance2))
    }

    /// Light of a lamp that is seen itself.
    fn straight(&mut self) {
        let world = self.own.world;
        let picked = world.lamps.pick_for_point(world.eye.position(), self.rng.uniform());
        let Some((index, chance)) = picked else { return };
        let Some(lamp) = world.lamps.get(index) else { return };
        let point = lamp.sample_point([self.rng.uniform(), self.rng.uniform()]);
        let Some((dir, solid_angle)) = self.towards_pupil(point.position) else { return };
        let luminance = lamp.luminance_along(point.normal, dir);
        let lumens = luminance * dir.dot(point.normal) * solid_angle * lamp.area_m2 / (chance * PATHS as f64);
        if lumens.is_nan() || lumens <= 0.0 {
            return;
        }
        let rng = self.rng.fork();
        if let Some((walker, origin)) = leave_face((world, self.optics), index, (&point, dir), lumens, rng) {
            self.arrive(walker, origin.group);
        }
    }

    /// Goes on over faces that do not scatter, and counts if the pupil comes next.
    fn arrive(&mut self, mut walker: Walker<'_, M>, group: GroupId) {
        for _ in 0..MOST_FACES {
            match walker.advance(&mut self.ledger) {
                Met::Pupil(arrival) => return self.count(&walker, group, &arrival),
                Met::Sky | Met::Ended => return,
                Met::Face(vertex) if is_one_way(&vertex, None) => return,
                Met::Face(vertex) => match walker.meet(&vertex, &mut self.ledger) {
                    Meeting::Went => {}
                    Meeting::Ended | Meeting::Scatter(..) => return,
                },
            }
        }
    }

    fn count(&mut self, walker: &Walker<'_, M>, group: GroupId, arrival: &Arrival) {
        let eye = &self.own.world.eye;
        let Some(pixel) = arrival.pixel.filter(|pixel| eye.wants_index(*pixel)) else { return };
        let Some(share) = self.own.route.from_lamp(group, walker.trail) else { return };
        let mut light = [Light::default(); 3];
        let each = lanes::<M, _>(|_| arrival.luminance_per_lumen);
        walker.beam.deposit(self.optics, &mut light[..M::COMPONENTS], &each);
        let light = components::<M>().luminance(&light[..M::COMPONENTS]);
        let size = self.own.size;
        for part in [0, part_of([pixel % size[0], pixel / size[0]], size)] {
            let own = &mut self.parts[share][part];
            *own = [own[0] + light.value, own[1] + light.open()];
        }
    }
}

impl<M: Mode> Visitor<M> for Aimed<'_, '_, M> {
    fn split_from(&self, _: &Walker<'_, M>) -> Option<f64> {
        None
    }

    /// Paths that get there by themselves are those that are aimed.
    fn pupil(&mut self, _: &Walker<'_, M>, _: Origin, _: &Arrival) {}

    fn scatterer(&mut self, walker: &Walker<'_, M>, from: Origin, vertex: &Vertex, scatter: &Scatter) {
        self.one_way |= is_one_way(vertex, Some(scatter));
        if self.one_way {
            return;
        }
        let Some(to_pupil) = self.towards_pupil(vertex.hit.point) else { return };
        let mut walker = walker.clone();
        let frame = Frame::about(vertex.normal);
        if walker.scatter_towards(vertex, (scatter, &frame), to_pupil, &mut self.ledger) {
            self.arrive(walker, from.group);
        }
    }

    fn went(&mut self, _: &Walker<'_, M>, vertex: &Vertex) {
        self.one_way |= is_one_way(vertex, None);
    }

    fn end(&mut self, _: u64) {
        self.one_way = false;
    }
}
