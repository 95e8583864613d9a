//! Path tracing from the eye: next-event estimation with multiple importance sampling, unbiased roulette.

use super::ShouldStop;
use super::ledger::{Ledger, cost};
use super::pick_up::Shining;
use super::pixel::Pixel;
use super::route::{Reach, Route};
use super::vision::Vision;
use super::walk::{Meeting, Met, SPLIT_FIRST_EVENTS, Travel, Vertex, Walker};
use crate::base::ids::GroupId;
use crate::base::lpe::{Letter, Source};
use crate::base::rng::Stream;
use crate::base::warp::Frame;
use crate::film::accumulate::{Film, Light};
use crate::film::train::Glint;
use crate::world::World;
use crate::world::geometry::{Ray, Site};
use crate::world::interior::Interior;
use crate::world::light::Strength;
use crate::world::mode::{LaneArray, Mode, lanes, plane_of};
use crate::world::optics::Optics;
use crate::world::scatter::Scatter;
use glam::DVec3;
use rayon::prelude::*;
use std::marker::PhantomData;

/// The backward estimator, ready to run passes.
pub struct Backward<'w, M: Mode> {
    world: &'w World,
    mode: PhantomData<M>,
    route: Route,
    reach: Reach,
    /// Sees what lamps show through specular faces alone; the paths here leave that out.
    vision: Option<Vision<'w>>,
    /// Kinds of lamps that a scatterer asks for.
    asked: u64,
    /// Per pixel that a pass looks at.
    paths: u32,
    /// Share of the pixels that a pass looks at.
    share: f64,
    seed: u64,
}

/// The last scattering vertex: what the chance of having sampled a lamp from there was.
struct Scattered {
    point: DVec3,
    /// Density per steradian of the direction taken.
    pdf: f64,
}

/// Light that a lamp sends to a scatterer.
struct Sent<M: Mode> {
    /// Unit direction to the lamp.
    dir: DVec3,
    distance: f64,
    target: Option<Site>,
    /// Per lane: cd/m², or lx across the direction for a lamp that has no luminance.
    luminance: M::Lanes<f64>,
    /// Density of the direction per steradian, or the probability of a lamp without luminance.
    pdf: f64,
    /// A scattered ray could have found the lamp too.
    by_chance: bool,
    from: Whose,
}

/// Whose light it is, and the share of the picture that it belongs to.
#[derive(Clone, Copy)]
struct Whose {
    group: GroupId,
    source: Source,
    share: usize,
}

impl<'w, M: Mode> Backward<'w, M> {
    /// `paths`: per pixel that a pass looks at. `share`: of the pixels, chosen by chance; what is seen there counts
    /// 1/share. `glints`: where a pinhole sees lamps over specular faces.
    pub fn new(world: &'w World, route: Route, (paths, share): (u32, f64), glints: &[Glint], seed: u64) -> Self {
        let (reach, vision) = (Reach::from_eye(&route), Vision::new(world, &route, glints, seed));
        let asked = [world.lamps.all().is_empty(), world.sky.is_none(), world.lights.all().is_empty()];
        let asked = asked.iter().filter(|none| !**none).count() as u64;
        Backward { world, mode: PhantomData, reach, vision, route, asked, paths, share, seed }
    }

    /// Looks at `count` pixels spread over the picture and tells whether any of them has light of ours. Once `stop` says
    /// true the rest is left out, and the result is worthless.
    pub fn finds_light(&self, count: u64, stop: &ShouldStop<'_>) -> bool {
        let [width, height] = self.world.eye.size();
        let pixels = (width * height) as u64;
        let optics = M::optics(self.world, self.seed, 0);
        (0..count).into_par_iter().any(|k| {
            let mut ledger = Ledger::new(self.world.solids.len());
            let mut light = vec![Light::default(); self.route.planes.len() * M::COMPONENTS];
            let pixel = (k.wrapping_mul(pixels) / count.max(1)) as usize;
            if stop() {
                return false;
            }
            let pixel = Pixel::new((pixel % width, pixel / width), width, k);
            self.pixel(&optics, pixel, &mut light, &mut ledger);
            light.iter().any(|light| light.value != 0.0 || light.open() != 0.0)
        })
    }

    /// Adds passes `first .. first + count` to the film, one eye path per pixel and pass, row by row in parallel.
    pub fn run(&self, film: &mut Film, first: u64, count: u64) -> Ledger {
        let width = film.width;
        let parts = self.world.solids.len();
        let mut total = Ledger::new(parts);
        // Optical constants of a few passes at a time; a row adds its passes in order whatever their number.
        const BATCH: u64 = 16;
        let mut next = first;
        while next < first + count {
            let passes = next..(next + BATCH).min(first + count);
            next = passes.end;
            let optics: Vec<(u64, Optics<M>)> =
                passes.map(|pass| (pass, M::optics(self.world, self.seed, pass))).collect();
            let mut rows: Vec<_> = film.rows().collect();
            let ledgers: Vec<Ledger> = rows
                .par_iter_mut()
                .map(|(y, row)| {
                    let mut total = Ledger::new(parts);
                    let mut light = vec![Light::default(); self.route.planes.len() * M::COMPONENTS];
                    for (pass, optics) in &optics {
                        let mut ledger = Ledger::new(parts);
                        for x in 0..width {
                            light.fill(Light::default());
                            let pixel = Pixel::new((x, *y), width, *pass);
                            if self.looks(pixel) {
                                self.pixel(optics, pixel, &mut light, &mut ledger);
                            }
                            if self.share < 1.0 {
                                light.iter_mut().for_each(|light| *light = light.scaled(1.0 / self.share));
                            }
                            ledger.work += cost::KEPT;
                            row.add_pass(x, &light);
                        }
                        total.merge(&ledger);
                    }
                    total
                })
                .collect();
            ledgers.iter().for_each(|ledger| total.merge(ledger));
        }
        film.passes += count;
        total
    }

    /// Whether a pass looks at a pixel.
    fn looks(&self, pixel: Pixel) -> bool {
        self.share >= 1.0 || pixel.rng(self.seed, Stream::Looks).uniform() < self.share
    }

    /// What is seen in a pixel.
    fn pixel(&self, optics: &Optics<M>, pixel: Pixel, out: &mut [Light], ledger: &mut Ledger) {
        let mut rng = pixel.rng(self.seed, Stream::Backward);
        let (paths, first) = (u64::from(self.paths), pixel.pass.wrapping_mul(u64::from(self.paths)));
        for path in 0..paths {
            let [x, y, u, v] = pixel.start(self.seed, Stream::Backward, first.wrapping_add(path));
            let (origin, dir) = self.world.eye.ray(pixel.x, pixel.y, [x, y], [u, v]);
            let ray = Ray { origin, dir, from: None };
            let weight = 1.0 / paths as f64;
            let walker =
                Walker::new((self.world, optics), Travel::FromEye, ray, weight, Interior::default(), rng.fork());
            let points = pixel.start(self.seed, Stream::LampPoint, first.wrapping_add(path));
            self.path(walker, weight, points, out, ledger);
        }
        if let Some(vision) = &self.vision {
            vision.look(&self.route, optics, pixel, out, ledger);
        }
    }

    fn path(&self, mut walker: Walker<'_, M>, weight: f64, points: [f64; 3], out: &mut [Light], ledger: &mut Ledger) {
        let balance = ledger.imbalance();
        ledger.paths += 1;
        ledger.emitted += weight;
        self.follow(&mut walker, points, out, ledger);
        ledger.close_path(balance);
    }

    /// `points`: the numbers by which the first scatterer on the way chooses a lamp and a place on it. They are even over
    /// the pixel's paths as their starts are, so the borders of soft shadows converge as edges do.
    fn follow(&self, walker: &mut Walker<'_, M>, points: [f64; 3], out: &mut [Light], ledger: &mut Ledger) {
        let mut last: Option<Scattered> = None;
        loop {
            let vertex = match walker.advance(ledger) {
                Met::Sky => {
                    self.see_sky(walker, last.as_ref(), out);
                    self.see_discs(walker, last.as_ref(), out);
                    walker.escape(ledger);
                    return;
                }
                Met::Pupil(_) | Met::Ended => return,
                Met::Face(vertex) => vertex,
            };
            self.see_lamp(walker, &vertex, last.as_ref(), out);
            if walker.events < SPLIT_FIRST_EVENTS
                && let Some(mut reflected) = walker.split(&vertex, 0.0, Walker::<M>::MOST_SPLITS, ledger)
            {
                self.follow(&mut reflected, points, out, ledger);
            }
            match walker.meet(&vertex, ledger) {
                Meeting::Ended => return,
                Meeting::Went => {
                    // A straight pass through an absent face is no event: the lamp beyond could not be sampled, so
                    // only what the trail says about specular events decides.
                    last = None;
                }
                Meeting::Scatter(scatter, frame) => {
                    ledger.work += cost::SHADOW * self.asked;
                    let first = !walker.trail.has_scatter();
                    let points = if first { points } else { std::array::from_fn(|_| walker.rng.uniform()) };
                    self.sample_lamps(walker, &vertex, scatter, &frame, points, out);
                    self.sample_sky(walker, &vertex, scatter, &frame, points, out);
                    self.sample_lights(walker, &vertex, scatter, &frame, points, out);
                    let Some(pdf) = walker.scatter(&vertex, scatter, &frame, ledger) else { return };
                    last = Some(Scattered { point: vertex.hit.point, pdf });
                }
            }
            if !self.reach.allows(walker.trail) {
                ledger.not_owned += walker.beam.carried();
                return;
            }
        }
    }

    fn see_lamp(&self, walker: &Walker<'_, M>, vertex: &Vertex, last: Option<&Scattered>, out: &mut [Light]) {
        if !walker.trail.has_scatter() {
            return;
        }
        let Some(seen) = walker.lamp_at(vertex) else { return };
        let Shining { lamp, index, cos, .. } = seen;
        let Some(share) = self.route.from_eye(lamp.group, walker.trail) else { return };
        let plane = self.route.plane_from_eye(share, walker.told, lamp.group, Source::Face);
        let weight = match last {
            None => 1.0,
            Some(from) => {
                let pdf_area = self.world.lamps.pick_pdf(from.point, index) / lamp.area_m2;
                let pdf_nee = pdf_area * (vertex.hit.point - from.point).length_squared() / cos;
                from.pdf / (from.pdf + pdf_nee)
            }
        };
        walker.see(plane_of::<M>(out, plane), &seen, weight);
    }

    fn see_sky(&self, walker: &Walker<'_, M>, last: Option<&Scattered>, out: &mut [Light]) {
        let Some(sky) = &self.world.sky else { return };
        let Some(share) = self.route.from_eye(sky.group, walker.trail) else { return };
        let plane = self.route.plane_from_eye(share, walker.told, sky.group, Source::Sky);
        let weight = last.map_or(1.0, |from| from.pdf / (from.pdf + sky.pdf(walker.ray.dir)));
        let luminance = walker.optics.sky(sky, walker.ray.dir);
        walker.pick_up(plane_of::<M>(out, plane), &lanes::<M, _>(|lane| luminance[lane] * weight));
    }

    /// Distant lamps that have a disc.
    fn see_discs(&self, walker: &Walker<'_, M>, last: Option<&Scattered>, out: &mut [Light]) {
        for (index, luminance, density) in self.world.lights.met(walker.ray.dir, last.map(|from| from.point)) {
            let group = self.world.lights.all()[index].group();
            let Some(share) = self.route.from_eye(group, walker.trail) else { continue };
            let plane = self.route.plane_from_eye(share, walker.told, group, Source::Light);
            let weight = last.map_or(1.0, |from| from.pdf / (from.pdf + density));
            let tint = walker.optics.light(index);
            walker.pick_up(plane_of::<M>(out, plane), &lanes::<M, _>(|lane| luminance * weight * tint[lane]));
        }
    }

    fn sample_lamps(
        &self,
        walker: &Walker<'_, M>,
        vertex: &Vertex,
        scatter: &Scatter,
        frame: &Frame,
        [pick, u, v]: [f64; 3],
        out: &mut [Light],
    ) {
        let from = vertex.hit.point;
        let Some((index, probability)) = self.world.lamps.pick_for_point(from, pick) else { return };
        let lamp = &self.world.lamps.all()[index];
        let Some(share) = self.route.from_eye(lamp.group, walker.trail.then(scatter.event())) else { return };
        let target = lamp.sample_point([u, v]);
        let offset = target.position - from;
        let distance = offset.length();
        let dir = offset / distance;
        let cos = -dir.dot(target.normal);
        let luminance = lamp.luminance_along(target.normal, -dir);
        if luminance <= 0.0 || !dir.is_finite() {
            return;
        }
        let pdf = probability / lamp.area_m2 * distance * distance / cos;
        let site = Site { part: lamp.part as u32, face: lamp.face as u32, triangle: target.triangle };
        let tint = walker.optics.lamp(index);
        let luminance = lanes::<M, _>(|lane| luminance * tint[lane]);
        let from = Whose { group: lamp.group, source: Source::Face, share };
        let sent = Sent { dir, distance, target: Some(site), luminance, pdf, by_chance: true, from };
        self.connect(walker, vertex, scatter, frame, &sent, out);
    }

    fn sample_sky(
        &self,
        walker: &Walker<'_, M>,
        vertex: &Vertex,
        scatter: &Scatter,
        frame: &Frame,
        [_, u, v]: [f64; 3],
        out: &mut [Light],
    ) {
        let Some(sky) = &self.world.sky else { return };
        let Some(share) = self.route.from_eye(sky.group, walker.trail.then(scatter.event())) else { return };
        let (dir, pdf) = sky.sample([u, v]);
        if pdf > 0.0 {
            let luminance = walker.optics.sky(sky, dir);
            let from = Whose { group: sky.group, source: Source::Sky, share };
            let sent = Sent { dir, distance: f64::INFINITY, target: None, luminance, pdf, by_chance: true, from };
            self.connect(walker, vertex, scatter, frame, &sent, out);
        }
    }

    fn sample_lights(
        &self,
        walker: &Walker<'_, M>,
        vertex: &Vertex,
        scatter: &Scatter,
        frame: &Frame,
        [pick, u, v]: [f64; 3],
        out: &mut [Light],
    ) {
        if self.world.lights.all().is_empty() {
            return;
        }
        let Some((index, probability, toward)) = self.world.lights.sample(vertex.hit.point, pick, [u, v]) else {
            return;
        };
        let group = self.world.lights.all()[index].group();
        let Some(share) = self.route.from_eye(group, walker.trail.then(scatter.event())) else { return };
        let (luminance, pdf, by_chance) = match toward.light {
            Strength::Delta(illuminance) => (illuminance, probability, false),
            Strength::Area(luminance, density) => (luminance, probability * density, true),
        };
        let tint = walker.optics.light(index);
        let luminance = lanes::<M, _>(|lane| luminance * tint[lane]);
        let from = Whose { group, source: Source::Light, share };
        let sent = Sent { dir: toward.dir, distance: toward.distance, target: None, luminance, pdf, by_chance, from };
        self.connect(walker, vertex, scatter, frame, &sent, out);
    }

    /// Adds the light that comes from a lamp, if nothing is in between.
    fn connect(
        &self,
        walker: &Walker<'_, M>,
        vertex: &Vertex,
        scatter: &Scatter,
        frame: &Frame,
        sent: &Sent<M>,
        out: &mut [Light],
    ) {
        let Sent { dir, distance, target, luminance, pdf, by_chance, from } = *sent;
        let (d_in, d_out) = (frame.to_local(walker.ray.dir), frame.to_local(dir));
        let sides = walker.sides(vertex, scatter);
        let (values, alone) = sides.eval(scatter, d_in, d_out);
        if values.as_slice().iter().all(|value| *value <= 0.0) {
            return;
        }
        let ray = Ray { origin: vertex.hit.point, dir, from: Some(vertex.hit.site) };
        if self.world.geometry.occluded_beside(&ray, vertex.beside, distance, target)
            || self.world.eye.blocks_reversed(ray.origin, ray.dir, distance)
        {
            return;
        }
        let through = d_out.z < 0.0;
        let plane = self.route.plane(from.share, |sieve| {
            let told = sieve.after(walker.told, Letter::of(scatter.event(), through));
            sieve.takes(told, sieve.lamp(from.group.index(), from.source))
        });
        let out = plane_of::<M>(out, plane);
        let (index, transmittance) = walker.beyond(vertex, through, distance);
        let weight = if by_chance { pdf / (pdf + scatter.pdf(d_in, d_out, sides.of(0))) } else { 1.0 };
        let factor = d_out.z.abs() / pdf * weight;
        let arriving = lanes::<M, _>(|lane| luminance[lane] * (values[lane] * factor) * transmittance[lane]);
        if alone {
            walker.pick_up_alone(&index, out, &arriving);
        } else {
            walker.pick_up_in(&index, out, &arriving);
        }
    }
}
