//! Path tracing from the eye: next-event estimation with multiple importance sampling, unbiased roulette.

mod glow;
mod next_event;
mod over_sky;
mod probe;
mod sky_sampling;
mod trial;
mod tuning;

use super::ShouldStop;
use super::emitter_hit::EmitterHit;
use super::ledger::{Ledger, cost};
use super::ownership::{Ownership, Reach};
use super::pixel::Pixel;
use super::rqmc::Rqmc;
use super::specular_event::Faint;
use super::vision::{Hints, Vision};
use super::walk::{Meeting, Met, SPLIT_FIRST_EVENTS, Travel, Vertex, Walker};
use super::window_visibility::Scattered;
use crate::manifold::seeds::bands::Bands;
use eyebox_base::lpe::Source;
use eyebox_base::parallel;
use eyebox_base::path::Class;
use eyebox_base::rng::Stream;
use eyebox_base::warp::Frame;
use eyebox_film::accumulate::{Film, Light, Row};
use eyebox_film::unseen::{Doubts, Unseen};
use eyebox_world::World;
use eyebox_world::geometry::Ray;
use eyebox_world::interior::Interior;
use eyebox_world::lamp::Lamp;
use eyebox_world::mode::{Mode, OPTICS_AT_A_TIME, Turns, lanes, plane_of, turns, turns_of};
use eyebox_world::optics::Optics;
use eyebox_world::scatter::Scatter;
use eyebox_world::surface::{FaceOptics, Surface};
use eyebox_world::wavelengths::SharedLight;
use glow::About;
pub use glow::Glow;
use next_event::Here;
use over_sky::OverSky;
pub use probe::Daylight;
use sky_sampling::SkySampling;
use std::marker::PhantomData;
use std::sync::Arc;
pub use trial::Trial;

/// The backward estimator, ready to run passes.
pub struct Backward<'w, M: Mode> {
    world: &'w World,
    mode: PhantomData<M>,
    route: Ownership,
    reach: Reach,
    /// Sees what lamps show through specular faces alone; the paths here leave that out.
    vision: Option<Vision<'w, M>>,
    /// Borders in the sky's picture that are seen through specular faces alone, if they are cut.
    over_sky: Option<OverSky<M>>,
    skyward: SkySampling,
    /// Kinds of lamps that a scatterer asks for.
    asked: u64,
    /// The scene has faces that transmit.
    panes: bool,
    /// Share of its light down to which a path's branches are followed.
    faintest: f64,
    /// Wavelengths that lead in turn in a pass.
    turns: u64,
    /// What the wavelengths of passes make of light.
    shared: Option<SharedLight<'w>>,
    /// Per pixel that a turn of a pass looks at.
    paths: u32,
    /// Share of the pixels that a pass looks at.
    share: f64,
    /// What rays may miss.
    doubts: Doubts,
    /// Where light that lands on scatterers came from, if paths are to know.
    glow: Option<Glow>,
    seed: u64,
}

impl<'w, M: Mode> Backward<'w, M> {
    /// `paths`: per pixel that a pass looks at, but for those to lamps over specular faces alone. `share`: of the pixels, chosen by chance; what is seen there counts
    /// 1/share. `hints`: where lamps are seen over specular faces, and the sky through windows.
    pub fn new(world: &'w World, route: Ownership, (paths, share): (u32, f64), hints: Hints<'_>, seed: u64) -> Self {
        let skyward = SkySampling::new(hints.windows);
        let (reach, vision) = (Reach::from_eye(&route), Vision::new(world, &route, hints, seed));
        let asked = [world.lamps.all().is_empty(), world.sky.is_none(), world.lights.all().is_empty()];
        let asked = asked.iter().filter(|none| !**none).count() as u64;
        let turns = turns::<M>(world);
        let transmits = |face: &FaceOptics| match &face.surface {
            Surface::Interface(_)
            | Surface::Slide(_)
            | Surface::Sheet(_)
            | Surface::Splitter(_)
            | Surface::Grating(_)
            | Surface::Absent => true,
            Surface::Scatter(scatter) => scatter.principled().is_some_and(|p| p.surface.lets_through()),
            Surface::Absorber | Surface::Mirror(_) => false,
        };
        let panes = world.faces.iter().flatten().any(transmits);
        Backward {
            world,
            mode: PhantomData,
            reach,
            vision,
            over_sky: None,
            skyward,
            route,
            asked,
            panes,
            faintest: 1.0,
            turns,
            shared: SharedLight::new::<M>(world),
            paths: u64::from(paths).div_ceil(turns) as u32,
            share,
            doubts: hints.doubts,
            glow: None,
            seed,
        }
    }

    /// Looks for what these connections leave to rays from the eye, too, at this share of the pixels in a pass.
    #[must_use]
    pub fn beside(mut self, connections: Arc<Bands>, share: f64) -> Self {
        // Of the pixels that are looked at anyway.
        let share = (share / self.share).min(1.0);
        self.vision.iter_mut().for_each(|vision| vision.beside(connections.clone(), share));
        self
    }

    /// Cuts the pictures of slides and displays, lamps' emission textures and the sky's picture by the footprints of the pixels that see
    /// edges in them. Not for witnesses, who are to know nothing.
    #[must_use]
    pub fn cutting_pictures(mut self) -> Self {
        self.vision.iter_mut().for_each(|vision| vision.cut_pictures(&self.route));
        self.over_sky = (self.paths > 0).then(|| OverSky::find(self.world, &self.route, self.seed, None)).flatten();
        self
    }

    /// The same with paths whose branches are followed down to this share of their light ([`Plan::faintest_branch`](eyebox_film::plan::Plan)).
    #[must_use]
    pub fn branching(self, faintest: f64) -> Self {
        Backward { faintest, ..self }
    }

    /// The same with paths that scatter mostly towards where light came from.
    #[must_use]
    pub fn towards(self, glow: Option<Glow>) -> Self {
        Backward { glow, ..self }
    }

    /// Looks at `count` pixels spread over the picture and tells whether any of them has light of ours. Once `stop` says
    /// true the rest is left out, and the result is worthless.
    pub fn finds_light(&self, count: u64, stop: &ShouldStop<'_>) -> bool {
        let [width, height] = self.world.eye.size();
        let pixels = (width * height) as u64;
        let optics = M::optics(self.world, self.seed, 0);
        parallel::any(count, &|k| {
            let mut ledgers = [Ledger::new(self.world.solids.len()), Ledger::new(self.world.solids.len())];
            let mut light = vec![Light::default(); self.route.planes.len() * M::COMPONENTS];
            let pixel = (k.wrapping_mul(pixels) / count.max(1)) as usize;
            if stop() {
                return false;
            }
            let pixel = Pixel::new((pixel % width, pixel / width), width, k);
            self.pixel(&optics, pixel, &mut light, &mut ledgers);
            light.iter().any(|light| light.value != 0.0 || light.open() != 0.0)
        })
    }

    /// What rays may not have met of lamps over specular faces, straight from the eye or behind a scatterer, where chance alone leads to
    /// them; none where others own all of that.
    pub fn unseen(&self) -> Option<Unseen> {
        let seen = self.vision.as_ref().and_then(|vision| vision.brightest(&self.route, self.doubts.brightest));
        // What comes by narrow lobes, too, is in nobody else's reach: their own choice of a direction leads there.
        let owns = |lamp: &&Lamp| self.route.share(lamp.group, Class::Caustic, true).is_some();
        let caustic = self.world.lamps.all().iter().filter(owns).map(Lamp::brightest).reduce(f64::max);
        let caustic = caustic.map(|brightest| brightest * self.doubts.of_caustics);
        let caustic = caustic
            .filter(|_| self.paths > 0)
            .map(|brightest| (brightest, (u64::from(self.paths) * self.turns) as f64));
        // Who is the more likely to miss the most.
        let (brightest, looks) = seen.into_iter().chain(caustic).max_by(|a, b| (a.0 / a.1).total_cmp(&(b.0 / b.1)))?;
        let [width, height] = self.world.eye.size();
        let over_sky = |pixel: u64| self.over_sky.as_ref().is_some_and(|over| over.knows(pixel));
        let in_vision = |pixel: u64| self.vision.as_ref().is_some_and(|vision| vision.knows(pixel));
        let known: Vec<bool> = (0..(width * height) as u64).map(|k| in_vision(k) || over_sky(k)).collect();
        let aimed = self.vision.as_ref().map_or_else(Vec::new, Vision::aimed);
        let hidden = self.vision.as_ref().and(self.doubts.hidden);
        let before = looks * self.doubts.glances as f64 / (width * height) as f64;
        Some(Unseen::new(brightest, looks * self.share, &known, aimed).beside(hidden).after(before))
    }

    /// Adds passes `first .. first + count` to the film, one eye path per pixel and pass, row by row in parallel.
    pub fn run(&self, film: &mut Film, first: u64, count: u64) -> Ledger {
        let width = film.width;
        let parts = self.world.solids.len();
        let mut total = Ledger::new(parts);
        // A row adds its passes in order whatever their number.
        let mut next = first;
        let end = first.saturating_add(count);
        if let Some(shared) = &self.shared {
            film.know((first..end).map(|pass| (pass, shared.of_pass(self.turns, self.seed, pass))));
        }
        while next < end {
            let passes = next..next.saturating_add(OPTICS_AT_A_TIME).min(end);
            next = passes.end;
            let optics: Vec<(u64, Turns<M>)> =
                passes.map(|pass| (pass, turns_of(self.world, self.turns, self.seed, pass))).collect();
            let mut rows: Vec<_> = film.rows().collect();
            let of_row = |(y, row): &mut (usize, Row<'_>)| {
                let mut total = Ledger::new(parts);
                let mut light = vec![Light::default(); self.route.planes.len() * M::COMPONENTS];
                for (pass, turns) in &optics {
                    let mut ledgers = [Ledger::new(parts), Ledger::new(parts)];
                    for x in 0..width {
                        light.fill(Light::default());
                        if row.wants(x, *pass) && self.world.eye.wants([x, *y]) {
                            for (number, optics) in turns {
                                let pixel = Pixel::new((x, *y), width, *number);
                                if self.looks(pixel) {
                                    self.pixel(optics, pixel, &mut light, &mut ledgers);
                                }
                            }
                        }
                        // A pixel without light adds nothing but zeros; where few are looked at, that is most of them.
                        if light.iter().all(|light| *light == Light::default()) {
                            continue;
                        }
                        let looks = self.share * self.turns as f64;
                        if looks != 1.0 {
                            light.iter_mut().for_each(|light| *light = light.scaled(1.0 / looks));
                        }
                        ledgers[0].work += cost::KEPT;
                        row.add_pass(x, *pass, &light);
                    }
                    let [mut ledger, scratch] = ledgers;
                    ledger.work += scratch.work;
                    row.add_work(*pass, ledger.work);
                    total.merge(&ledger);
                }
                total
            };
            let ledgers: Vec<Ledger> = parallel::map_mut(&mut rows, &of_row);
            ledgers.iter().for_each(|ledger| total.merge(ledger));
        }
        film.close(first, count);
        total
    }

    /// Whether a pass looks at a pixel.
    fn looks(&self, pixel: Pixel) -> bool {
        self.share >= 1.0 || pixel.rng(self.seed, Stream::Looks).uniform() < self.share
    }

    /// What paths of one pass see in a pixel, by plane: for a witness, which looks at a few. The ledgers as for `Backward::pixel`.
    pub fn look(&self, optics: &Optics<M>, pixel: Pixel, out: &mut [Light], ledgers: &mut [Ledger; 2]) {
        self.pixel(optics, pixel, out, ledgers);
    }

    /// What is seen in a pixel. Into the second ledger goes what is tried beside the paths; of that only the work counts.
    fn pixel(&self, optics: &Optics<M>, pixel: Pixel, out: &mut [Light], ledgers: &mut [Ledger; 2]) {
        self.paths_of(optics, pixel, out, ledgers);
        if let Some(vision) = &self.vision {
            vision.look(&self.route, optics, pixel, out, &mut ledgers[0]);
        }
    }

    /// What is seen in a pixel but for lamps over specular faces alone.
    fn paths_of(&self, optics: &Optics<M>, pixel: Pixel, out: &mut [Light], ledgers: &mut [Ledger; 2]) {
        let mut rng = pixel.rng(self.seed, Stream::Backward);
        let (paths, first) = (u64::from(self.paths), pixel.pass.wrapping_mul(u64::from(self.paths)));
        for path in 0..paths {
            let [x, y, u, v] = pixel.start(self.seed, Stream::Backward, first.wrapping_add(path));
            let (origin, dir) = self.world.eye.ray(pixel.x, pixel.y, [x, y], [u, v]);
            let ray = Ray { origin, dir, from: None };
            let weight = 1.0 / paths as f64;
            let walker =
                Walker::new((self.world, optics), Travel::FromEye, ray, weight, Interior::default(), rng.fork());
            let index = first.wrapping_add(path);
            // What is most even together is for the place on the lamp.
            let [s, t, which] = pixel.start(self.seed, Stream::LampPoint, index);
            let points = [which, s, t];
            let even = Rqmc::new(self.seed, Stream::Backward, pixel, index);
            self.path(walker, weight, (points, &even), out, ledgers);
            if let Some(over) = &self.over_sky {
                over.take_off(optics, (pixel, [x, y], [u, v]), weight, out);
            }
        }
        if let Some(over) = &self.over_sky {
            over.add_mean(optics, pixel, out, &mut ledgers[0]);
        }
    }

    fn path(
        &self,
        mut walker: Walker<'w, M>,
        weight: f64,
        even: ([f64; 3], &Rqmc),
        out: &mut [Light],
        [ledger, scratch]: &mut [Ledger; 2],
    ) {
        let balance = ledger.imbalance();
        ledger.paths += 1;
        ledger.emitted += weight;
        self.follow(&mut walker, (even, 0), out, (ledger, scratch));
        ledger.close_path(balance);
    }

    /// `points`: the numbers by which the first scatterer on the way chooses a lamp and a place on it. They are even over
    /// the pixel's paths as their starts are, so the borders of soft shadows converge as edges do. `even`: those by which
    /// it is left, and a lamp chosen at the next. `scattered`: how many scatterers the path has met so far.
    fn follow(
        &self,
        walker: &mut Walker<'w, M>,
        ((points, even), mut scattered): (([f64; 3], &Rqmc), u32),
        out: &mut [Light],
        (ledger, scratch): (&mut Ledger, &mut Ledger),
    ) {
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
            if let Some(mut reflected) = self.branch(walker, &vertex, ledger) {
                self.follow(&mut reflected, ((points, even), scattered), out, (ledger, scratch));
            }
            walker.last = None;
            match walker.meet(&vertex, ledger) {
                Meeting::Ended => return,
                Meeting::Went => last = last.and_then(|last| last.past(walker)),
                Meeting::Scatter(scatter, frame) => {
                    ledger.work += cost::SHADOW * self.asked;
                    let points = if scattered == 0 { points } else { even.take(scattered, &mut walker.rng) };
                    let here = Here { walker: &*walker, vertex: &vertex, scatter, frame: &frame };
                    self.sample_lamps(&here, points, out);
                    self.sample_sky(&here, points, out, scratch);
                    self.sample_lights(&here, points, out, scratch);
                    let u = if scattered == 0 { even.take(0, &mut walker.rng) } else { walker.rng.triple() };
                    scattered += 1;
                    let glow = self.glow.as_ref().and_then(|glow| glow.at(vertex.hit.point));
                    let pdf = match glow {
                        None => walker.scatter_by(u, &vertex, (scatter, &frame), ledger),
                        Some(about) => scatter_towards(walker, &about, u, (&vertex, scatter, &frame), ledger),
                    };
                    let Some(pdf) = pdf else { return };
                    last = Some(Scattered::new(walker, vertex.hit.point, pdf));
                }
            }
            if !self.reach.allows(walker.trail) {
                ledger.not_owned += walker.beam.carried();
                return;
            }
        }
    }

    /// A path that goes the other way on from a specular face; none if it is not followed.
    fn branch(&self, walker: &mut Walker<'w, M>, vertex: &Vertex, ledger: &mut Ledger) -> Option<Walker<'w, M>> {
        if walker.events < SPLIT_FIRST_EVENTS {
            walker.split(vertex, 0.0, Walker::<M>::MOST_SPLITS, ledger)
        } else if self.faintest < 1.0 && !walker.trail.has_scatter() {
            walker.spare(vertex, Faint::down_to(self.faintest, walker), ledger)
        } else {
            None
        }
    }

    fn see_lamp(&self, walker: &Walker<'_, M>, vertex: &Vertex, last: Option<&Scattered>, out: &mut [Light]) {
        if !walker.trail.has_scatter() {
            return;
        }
        let Some(seen) = walker.lamp_at(vertex) else { return };
        let EmitterHit { lamp, index, cos, .. } = seen;
        let Some(share) = self.route.from_eye(lamp.group, walker.trail) else { return };
        let plane = self.route.plane_from_eye(share, walker.told, lamp.group, Source::Face);
        let weight = match last.filter(|from| from.in_sight()) {
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
        let density = |from: &Scattered| self.skyward.pdf(sky, from.point, from.dir);
        let weight = last.map_or(1.0, |from| from.pdf / (from.pdf + density(from)));
        let luminance = walker.optics.sky(sky, walker.ray.dir);
        walker.pick_up(plane_of::<M>(out, plane), &lanes::<M, _>(|lane| luminance[lane] * weight));
    }

    /// Distant lamps that have a disc.
    fn see_discs(&self, walker: &Walker<'_, M>, last: Option<&Scattered>, out: &mut [Light]) {
        for (index, luminance, density) in
            self.world.lights.met(walker.ray.dir, last.map(|from| (from.point, from.dir)))
        {
            let group = self.world.lights.all()[index].group();
            let Some(share) = self.route.from_eye(group, walker.trail) else { continue };
            let plane = self.route.plane_from_eye(share, walker.told, group, Source::Light);
            let weight = last.map_or(1.0, |from| from.pdf / (from.pdf + density));
            let tint = walker.optics.light(index);
            walker.pick_up(plane_of::<M>(out, plane), &lanes::<M, _>(|lane| luminance * weight * tint[lane]));
        }
    }
}

/// Scatters as photons or the scatterer itself choose. Returns the direction's density by both while the path goes on.
fn scatter_towards<M: Mode>(
    walker: &mut Walker<'_, M>,
    about: &About<'_>,
    u: [f64; 3],
    (vertex, scatter, frame): (&Vertex, &Scatter, &Frame),
    ledger: &mut Ledger,
) -> Option<f64> {
    walker.unlink();
    let d_in = frame.to_local(walker.ray.dir);
    let sides = walker.sides(vertex, scatter);
    let dir = if about.chooses(walker.rng.uniform()) {
        about.draw(u)
    } else {
        frame.to_world(scatter.sample(d_in, sides.of(0), u)?.dir)
    };
    let density = about.density(dir, scatter.pdf(d_in, frame.to_local(dir), sides.of(0)));
    walker.scatter_to((vertex, scatter, frame), (dir, density), ledger).then_some(density)
}
