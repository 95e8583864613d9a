//! Paths from a sensor back to what lights it.
//!
//! The illuminance of a place is π times the mean of the luminances that it sees, over directions as likely as their
//! cosine. A path that starts so, at a place even over the face's area A, stands for the flux π A L of its share.

use super::tuning::backward::{CHUNK, MOST_EVENTS, OFF};
use super::{Caught, measured};
use crate::ledger::Ledger;
use crate::walk::{Meeting, Met, Travel, Walker};
use eyebox_base::ids::GroupId;
use eyebox_base::parallel;
use eyebox_base::rng::{Rng, Stream};
use eyebox_base::sobol::Sobol;
use eyebox_base::warp::{Frame, cosine_hemisphere};
use eyebox_film::accumulate::Light;
use eyebox_world::World;
use eyebox_world::geometry::Ray;
use eyebox_world::interior::Interior;
use eyebox_world::mode::{Mode, lanes};
use eyebox_world::optics::Optics;
use eyebox_world::sensor::{SensorFace, SensorPoint, Side};
use glam::DVec3;
use std::f64::consts::PI;
use std::marker::PhantomData;

/// The estimator, ready to run passes.
pub struct Backward<'w, M: Mode> {
    world: &'w World,
    mode: PhantomData<M>,
    sensor: &'w SensorFace,
    /// Per light group: its faces that emit and its discs are looked for, beside the sky.
    lamps: &'w [bool],
    /// Solids around the front and the back.
    interiors: [Interior; 2],
    watts_per_lumen: &'w [f64],
    paths: u64,
    seed: u64,
}

impl<'w, M: Mode> Backward<'w, M> {
    /// `lamps`: per light group, whether its faces that emit and its discs are looked for. `paths` in a pass, half of them from
    /// each side; `watts_per_lumen`: per light group of the scene.
    pub fn new(
        world: &'w World,
        (sensor, lamps): (&'w SensorFace, &'w [bool]),
        watts_per_lumen: &'w [f64],
        paths: u64,
        seed: u64,
    ) -> Self {
        let interiors = Side::BOTH.map(|side| interior(world, sensor, side));
        Backward { world, mode: PhantomData, sensor, lamps, interiors, watts_per_lumen, paths, seed }
    }

    /// What a pass brings, in the order of its paths.
    pub fn pass(&self, pass: u64) -> Vec<Caught> {
        let optics = M::optics(self.world, self.seed, pass);
        let points = [0, 1].map(|side| Sobol::new(self.seed, Stream::SensorSky, pass.wrapping_mul(2) + side));
        let of_chunk = |chunk: usize| {
            let chunk = chunk as u64;
            let mut caught = Vec::new();
            let mut ledger = Ledger::new(self.world.solids.len());
            for sample in chunk * CHUNK..((chunk + 1) * CHUNK).min(self.paths) {
                let rng = Rng::new(self.seed, Stream::SensorSky, pass, sample);
                let point = points[(sample % 2) as usize].point(sample / 2);
                self.path(&optics, (Side::BOTH[(sample % 2) as usize], point), rng, &mut caught, &mut ledger);
            }
            caught
        };
        parallel::map(self.paths.div_ceil(CHUNK) as usize, &of_chunk).concat()
    }

    fn looks_for(&self, group: GroupId) -> bool {
        self.lamps.get(group.index()).copied().unwrap_or(false)
    }

    /// Where rays from the sensor leave the scene, if they do: their last places on faces, or on the sensor, and their directions.
    /// `count` rays of pass 0, in their order.
    pub fn ways_out(&self, count: u64) -> Vec<(DVec3, DVec3)> {
        let optics = M::optics(self.world, self.seed, 0);
        let sobol = Sobol::new(self.seed, Stream::Pilot, 0);
        let way = |sample: u64| {
            let rng = Rng::new(self.seed, Stream::SensorSky, 0, sample);
            let side = Side::BOTH[(sample % 2) as usize];
            let (mut walker, _) = self.start(&optics, side, sobol.point(sample), rng);
            let mut ledger = Ledger::new(self.world.solids.len());
            while walker.events < MOST_EVENTS {
                let vertex = match walker.advance(&mut ledger) {
                    Met::Sky => return Some((walker.ray.origin, walker.ray.dir)),
                    Met::Pupil(_) | Met::Ended => return None,
                    Met::Face(vertex) => vertex,
                };
                match walker.meet(&vertex, &mut ledger) {
                    Meeting::Ended => return None,
                    Meeting::Went => {}
                    Meeting::Scatter(scatter, frame) => {
                        walker.scatter(&vertex, scatter, &frame, &mut ledger)?;
                    }
                }
            }
            None
        };
        parallel::filter_map(count, &way)
    }

    /// A path's start by four numbers (direction, place), and where it is on the sensor.
    fn start<'o>(
        &self,
        optics: &'o Optics<M>,
        side: Side,
        [u, v, a, b]: [f64; 4],
        rng: Rng,
    ) -> (Walker<'o, M>, SensorPoint)
    where
        'w: 'o,
    {
        let from = self.sensor.sample([a, b]);
        let (normal, interior) = match side {
            Side::Front => (from.normal, self.interiors[0]),
            Side::Back => (-from.normal, self.interiors[1]),
        };
        let dir = Frame::about(normal).to_world(cosine_hemisphere([u, v])).normalize();
        let ray = Ray { origin: from.position, dir, from: Some(from.site) };
        let flux = PI * self.sensor.area_m2() / self.paths.div_ceil(2) as f64;
        let walker = Walker::new((self.world, optics), Travel::FromEye, ray, flux, interior, rng);
        (walker.from_face(normal), from)
    }

    fn path(
        &self,
        optics: &Optics<M>,
        (side, point): (Side, [f64; 4]),
        rng: Rng,
        caught: &mut Vec<Caught>,
        ledger: &mut Ledger,
    ) {
        let (mut walker, from) = self.start(optics, side, point, rng);
        // What is carried back is luminance over the square of the index, which is told where the light is met.
        let here = walker.index_here();
        let pixel = self.sensor.pixel_of(from.position) as u32;
        let mut keep = |walker: &Walker<'_, M>, group: GroupId, (light, alone): (M::Lanes<Light>, bool)| {
            let light = lanes::<M, _>(|lane| light[lane].scaled(here[lane] * here[lane]));
            let per_lumen = self.watts_per_lumen.get(group.index()).copied().unwrap_or(0.0);
            let (lumens, watts) = measured::<M>(walker.optics, (light, alone), per_lumen);
            if lumens != 0.0 || watts != 0.0 {
                caught.push(Caught { pixel, side, group, lumens, watts });
            }
        };
        // Of light with this luminance per lane where the path is.
        let told = |walker: &Walker<'_, M>, luminance: M::Lanes<f64>| {
            let ((light, alone), there) = (walker.beam.stored(), walker.index_here());
            (lanes::<M, _>(|lane| light[lane].scaled(luminance[lane] / (there[lane] * there[lane]))), alone)
        };
        loop {
            let vertex = match walker.advance(ledger) {
                Met::Sky => {
                    if let Some(sky) = &self.world.sky {
                        keep(&walker, sky.group, told(&walker, walker.optics.sky(sky, walker.ray.dir)));
                    }
                    for (index, luminance, _) in self.world.lights.met(walker.ray.dir, None) {
                        let group = self.world.lights.all()[index].group();
                        if self.looks_for(group) {
                            let tint = walker.optics.light(index);
                            let luminance = lanes::<M, f64>(|lane| luminance * tint[lane]);
                            keep(&walker, group, told(&walker, luminance));
                        }
                    }
                    return;
                }
                Met::Pupil(_) | Met::Ended => return,
                Met::Face(vertex) => vertex,
            };
            if let Some(seen) = walker.lamp_at(&vertex).filter(|seen| self.looks_for(seen.lamp.group)) {
                keep(&walker, seen.lamp.group, walker.seen(&seen));
            }
            match walker.meet(&vertex, ledger) {
                Meeting::Ended => return,
                Meeting::Went => {}
                Meeting::Scatter(scatter, frame) => {
                    if walker.scatter(&vertex, scatter, &frame, ledger).is_none() {
                        return;
                    }
                }
            }
        }
    }
}

/// The solids in front of a face or behind it, at its middle.
fn interior(world: &World, sensor: &SensorFace, side: Side) -> Interior {
    let from = sensor.sample([0.5, 0.5]);
    let normal = match side {
        Side::Front => from.normal,
        Side::Back => -from.normal,
    };
    let off = normal * (OFF * sensor.area_m2().sqrt());
    let solid = world.solids.get(sensor.part as usize).copied().flatten().is_some();
    let own = (solid && side == Side::Back).then_some(sensor.part);
    // A face that lies on glass is outside of it, whatever rounding says.
    let under = world.contacts.under(&world.geometry, from.site, [from.position, normal, normal]);
    let not = [Some(sensor.part), under.map(|(glass, _)| glass.site.part)];
    let around = world.geometry.solids_containing(from.position + off);
    Interior::of(around.into_iter().filter(|part| !not.contains(&Some(*part))).chain(own))
}
