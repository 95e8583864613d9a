//! What the eye sees of lamps through specular faces alone (`E S* L`), apart from the paths that scatter: such paths
//! cost little and know their way, so they get points of their own in every pixel and follow both ways on at an
//! interface. A mirrored lamp smaller than a pixel would otherwise be the noise of the whole picture; where the plan knows
//! of one in a pinhole's picture, some of the points are chosen about it. Through a pupil that is no point, a lamp is seen
//! in a small part of it: where the plan knows which, most of the rays go there. Where specular connection has what it can,
//! some pixels of a pass look for what comes over trains of faces that it does not know, or has no start for there, and for
//! what the solver leaves of trains that paths from the lamps were not seen to arrive by. Where a slide's picture or a lamp's
//! emission texture has an edge in a pixel, it is cut by the pixel's footprint (`vision/over_pixel.rs`).

mod glints;
mod over_pixel;

use super::emitter_hit::EmitterHit;
use super::ledger::Ledger;
use super::ownership::Ownership;
use super::pixel::Pixel;
use super::tuning::over_pixel::PASSES_LOOKED_AT;
use super::tuning::vision::{FEWEST_OF_A_GLINT, PATHS, PATHS_OF_A_GLINT, SPLIT_FROM, WORTH};
use super::walk::{Meeting, Met as Ahead, Travel, Vertex, Walker};
use crate::manifold::seeds::bands::Bands;
use crate::manifold::solver::newton::Target;
use arrayvec::ArrayVec;
use eyebox_base::lpe::Source;
use eyebox_base::path::{Event, Trail};
use eyebox_base::rng::{Rng, Stream};
use eyebox_base::warp::{disk, disk_inverse};
use eyebox_film::accumulate::Light;
use eyebox_film::glint::Glint;
use eyebox_film::guide::{ApertureGuide, Portals};
use eyebox_film::plan::Plan;
use eyebox_film::unseen::Doubts;
use eyebox_world::World;
use eyebox_world::geometry::Ray;
use eyebox_world::interior::Interior;
use eyebox_world::lamp::Lamp;
use eyebox_world::mode::{Mode, plane_of, turns, wavelengths_change};
use eyebox_world::optics::Optics;
use eyebox_world::slide::footprint::MOST as MOST_SLIDES;
use eyebox_world::surface::Surface;
use glam::{DVec2, DVec3};
pub use glints::is_looked_about;
use over_pixel::PixelFootprints;
use std::collections::HashMap;
use std::sync::Arc;

/// What a plan knows of where lamps are seen, and the sky.
#[derive(Debug, Clone, Copy)]
pub struct Hints<'p> {
    /// Small images of them.
    pub glints: &'p [Glint],
    /// What rays may miss.
    pub doubts: Doubts,
    /// Through a pupil that is no point.
    pub pupil: Option<&'p ApertureGuide>,
    /// Through which windows scatterers see the sky.
    pub windows: Option<&'p Portals>,
    /// Of the pixels that a pass looks at for lamps.
    pub share: f64,
}

impl<'p> Hints<'p> {
    /// For paths that scatter alone.
    pub fn of_sky(windows: Option<&'p Portals>) -> Hints<'p> {
        Hints { glints: &[], doubts: Doubts::default(), pupil: None, windows, share: 1.0 }
    }

    pub fn of(plan: &'p Plan) -> Hints<'p> {
        let (pupil, windows) = (plan.pupil_guide.as_ref(), plan.sky_guide.as_ref());
        // Of the pixels that are looked at anyway.
        let share = (plan.vision_share / plan.backward_share).min(1.0);
        Hints { glints: &plan.glints, doubts: plan.doubts, pupil, windows, share }
    }
}

/// Follows paths from the eye to lamps, over specular events only.
pub struct Vision<'w, M: Mode> {
    world: &'w World,
    /// Some group is ours whose lamps are not connected.
    whole: bool,
    /// Of the pixels that a pass looks at for those.
    share: f64,
    unknown: Option<Unknown>,
    /// By pixel: the places in it or near it that show lamps.
    glints: HashMap<u64, Vec<Glint>>,
    pupil: Option<ApertureGuide>,
    /// Footprints of the pixels that have edges of pictures in them, if these are cut.
    footprints: Option<PixelFootprints<M>>,
    /// Paths of a pixel in a turn of a pass, and those about each glint.
    paths: [u64; 2],
    seed: u64,
}

/// What there is to know of a path that a pixel's footprint is made of.
#[derive(Clone, Default)]
struct Met {
    /// Where it crossed slides, in their mesh units.
    slides: ArrayVec<(usize, DVec3), MOST_SLIDES>,
    /// It crossed more of them than can be cut.
    many: bool,
    /// Where it met the faces of its chain, (part, face), recentred world.
    faces: Vec<((u32, u32), DVec3)>,
}

impl Met {
    /// To be called for a path that has gone on from a specular face.
    fn pass<M: Mode>(&mut self, walker: &Walker<'_, M>, vertex: &Vertex) {
        let site = vertex.hit.site;
        self.faces.push(((site.part, site.face), vertex.hit.point));
        if let Surface::Slide(slide) = walker.face(vertex).surface {
            self.many |= self.slides.try_push((slide, vertex.hit.local)).is_err();
        }
    }
}

/// What specular connection leaves to rays from the eye.
struct Unknown {
    /// What it does not leave.
    connections: Arc<Bands>,
    /// Of the pixels that a pass looks at for that.
    share: f64,
}

/// Whether rays from the eye own direct vision of a lamp, straight or over specular faces.
fn is_seen(route: &Ownership, lamp: &Lamp) -> bool {
    let trails = [Trail::START, Trail::START.then(Event::Specular)];
    trails.iter().any(|trail| route.from_eye(lamp.group, *trail).is_some())
}

impl<'w, M: Mode> Vision<'w, M> {
    /// None if the route leaves direct vision of all lamps to others.
    pub fn new(world: &'w World, route: &Ownership, hints: Hints<'_>, seed: u64) -> Option<Self> {
        let mut ours = world.lamps.all().iter().filter(|lamp| is_seen(route, lamp)).peekable();
        ours.peek()?;
        let glints = glints::by_pixel(&world.eye, hints.glints);
        let [width, height] = world.eye.size();
        // Together they have as many paths as the pixels have, or a few each.
        let fair = PATHS * (width * height) as u64 / glints.values().map(Vec::len).sum::<usize>().max(1) as u64;
        let of_a_glint = fair.clamp(FEWEST_OF_A_GLINT, PATHS_OF_A_GLINT);
        Some(Vision {
            world,
            whole: ours.any(|lamp| !route.is_connected(lamp.group)),
            share: hints.share,
            unknown: None,
            glints,
            pupil: hints.pupil.cloned(),
            footprints: None,
            paths: [PATHS, of_a_glint].map(|paths| paths.div_ceil(turns::<M>(world))),
            seed,
        })
    }

    /// Cuts the slides' pictures, and the emission textures of lamps, by the footprints of pixels where they have edges, from now on.
    pub fn cut_pictures(&mut self, route: &Ownership) {
        let has_texture =
            |lamp: &Lamp| lamp.texture().is_some() && is_seen(route, lamp) && !route.is_connected(lamp.group);
        let any = || !self.world.slides.is_empty() || self.world.lamps.all().iter().any(has_texture);
        if self.whole && !self.world.plain && any() {
            let passes = if wavelengths_change::<M>() { PASSES_LOOKED_AT } else { 1 };
            let optics: Vec<Optics<M>> = (0..passes).map(|pass| M::optics(self.world, self.seed, pass)).collect();
            self.footprints = Some(PixelFootprints::find(self, route, &optics));
        }
    }

    /// Luminance of the brightest lamp that these rays may miss, of those that connection leaves to them, cd/m², and how many rays look for it
    /// in a pixel and pass. `known`: by a search. None if there is none. Where pilots have found no way to a lamp, so that few pixels are looked at, it is 0.
    pub fn brightest(&self, route: &Ownership, known: Option<f64>) -> Option<(f64, f64)> {
        let ours = |lamp: &&Lamp| is_seen(route, lamp) && !route.is_connected(lamp.group);
        let lamps = self.world.lamps.all().iter().filter(ours);
        let brightest = lamps.map(Lamp::brightest).reduce(f64::max)?;
        let brightest = known.map_or(brightest, |known| known.min(brightest));
        let looks = self.share * (self.paths[0] * turns::<M>(self.world)) as f64;
        Some((if self.share < 1.0 { 0.0 } else { brightest }, looks))
    }

    /// Numbers of the pixels with points about small images of lamps.
    pub fn aimed(&self) -> Vec<u32> {
        self.glints.keys().filter_map(|pixel| u32::try_from(*pixel).ok()).collect()
    }

    /// Whether more is known of a pixel by number than its rays tell: images of lamps are looked for, or edges are cut.
    pub fn knows(&self, pixel: u64) -> bool {
        let cut = self.footprints.as_ref().is_some_and(|footprints| !footprints.of(pixel).is_empty());
        cut || self.glints.contains_key(&pixel)
    }

    /// Looks for what these connections don't know, too, at this share of the pixels in a pass.
    pub fn beside(&mut self, connections: Arc<Bands>, share: f64) {
        self.unknown = (!connections.is_empty()).then_some(Unknown { connections, share });
    }

    /// Adds what one pass sees in a pixel to `out`, by plane.
    pub fn look(&self, route: &Ownership, optics: &Optics<M>, pixel: Pixel, out: &mut [Light], ledger: &mut Ledger) {
        let share = match &self.unknown {
            _ if self.whole => self.share,
            Some(unknown) => unknown.share,
            None => return,
        };
        let mut rng = pixel.rng(self.seed, Stream::Vision);
        let glints = self.glints.get(&pixel.index).map_or(&[][..], Vec::as_slice);
        // Where lamps are known to be seen, nothing is left to chance.
        let share = if glints.is_empty() { share } else { 1.0 };
        if share < 1.0 && rng.uniform() >= share {
            return;
        }
        let footprints = self.footprints.as_ref().filter(|_| glints.is_empty());
        let known = footprints.map_or(&[][..], |footprints| footprints.of(pixel.index));
        let at_these_wavelengths;
        let over = if wavelengths_change::<M>() && !known.is_empty() {
            at_these_wavelengths = self.footprints_at((route, optics), pixel, &mut ledger.work);
            &at_these_wavelengths[..]
        } else {
            known
        };
        self.add_mean((optics, over), (pixel, share), out, ledger);
        let eye = &self.world.eye;
        let cell = eye.pixel().iter().product::<f64>();
        let corner = eye.film_of(pixel.x, pixel.y, [0.0; 2]);
        // All points of the pixel count by the density of all ways to choose them (the balance heuristic of E. Veach, 1997).
        let [paths, of_a_glint] = self.paths;
        // Those share what it takes to find footprints.
        let paths = if known.is_empty() { paths } else { PATHS };
        let density = |(film, pupil): (DVec2, DVec2), of_lens: f64| {
            let about = glints.iter().map(|glint| glint.density(cell, (film, pupil))).sum::<f64>();
            paths as f64 * of_lens + of_a_glint as f64 * about
        };
        let about = of_a_glint * glints.len() as u64;
        for path in 0..paths + about {
            let index = |path: u64, of: u64| pixel.pass.wrapping_mul(of).wrapping_add(path);
            // Without a guide the points are most even in the picture, where a small image is hard to find, and the pupil has to do
            // with what goes with these. With one little else is left to find.
            let (jitter, pupil, of_lens) = match (path.checked_sub(paths), &self.pupil) {
                (None, None) => {
                    let [_, _, u, v] = pixel.start(self.seed, Stream::Vision, index(path, paths));
                    (pixel.start(self.seed, Stream::Vision, index(path, paths)), disk([u, v]), 1.0)
                }
                (None, Some(_)) => {
                    let [x, y, u, v] = pixel.start(self.seed, Stream::Vision, index(path, paths));
                    let (lens, density) = self.lens(pixel, [u, v]);
                    ([x, y], disk(lens), density)
                }
                (Some(path), _) => {
                    let glint = &glints[(path / of_a_glint) as usize];
                    let [x, y, u, v] = pixel.start(self.seed, Stream::Glint, index(path, about));
                    let even = (eye.film_of(pixel.x, pixel.y, [u, v]), self.in_pupil([u, v]));
                    let Some((film, pupil)) = glint.draw(cell, even, [x, y]) else { continue };
                    let [width, height] = eye.pixel();
                    let jitter = [(film.x - corner.x) / width, (corner.y - film.y) / height];
                    (jitter, pupil, self.density_of_lens(pixel, pupil))
                }
            };
            // A glint may reach into other pixels, which have points of their own for it.
            if !jitter.iter().all(|x| (0.0..1.0).contains(x)) {
                continue;
            }
            let weight = 1.0 / (share * density((eye.film_of(pixel.x, pixel.y, jitter), pupil), of_lens));
            self.look_along((route, optics), (pixel, jitter, pupil), (weight, rng.fork()), out, ledger);
            self.take_off((optics, over), (jitter, pupil), weight, out);
        }
    }

    /// A place in the pupil for two numbers from 0 to 1, as [`ray`](eyebox_world::eye::EyeLens::ray) takes it, and its density relative to chance.
    fn lens(&self, pixel: Pixel, uv: [f64; 2]) -> ([f64; 2], f64) {
        let Some(guide) = &self.pupil else { return (uv, 1.0) };
        let [width, height] = self.world.eye.size();
        guide.draw([(pixel.x as f64 + 0.5) / width as f64, (pixel.y as f64 + 0.5) / height as f64], uv)
    }

    /// A place in the pupil, in radii; of a pinhole its middle.
    fn in_pupil(&self, uv: [f64; 2]) -> DVec2 {
        if self.world.eye.pupil_radius_m() > 0.0 { disk(uv) } else { DVec2::ZERO }
    }

    /// The density that [`Vision::lens`] draws a place of the pupil (radii) with, relative to chance.
    fn density_of_lens(&self, pixel: Pixel, pupil: DVec2) -> f64 {
        let Some(guide) = &self.pupil else { return 1.0 };
        let [width, height] = self.world.eye.size();
        guide.density(
            [(pixel.x as f64 + 0.5) / width as f64, (pixel.y as f64 + 0.5) / height as f64],
            disk_inverse(pupil),
        )
    }

    /// Follows a path from a place of a pixel (right and down from its corner) and of the pupil (in radii).
    fn look_along(
        &self,
        (route, optics): (&Ownership, &Optics<M>),
        (pixel, jitter, pupil): (Pixel, [f64; 2], DVec2),
        (weight, rng): (f64, Rng),
        out: &mut [Light],
        ledger: &mut Ledger,
    ) {
        let (mut walker, places) = self.walker(optics, (pixel, jitter, pupil), (weight, rng));
        if self.unknown.is_some() {
            walker = walker.recording();
        }
        let balance = ledger.imbalance();
        ledger.paths += 1;
        ledger.emitted += weight;
        let mut each = |walker: &Walker<'_, M>, seen: &EmitterHit<'_>, plane: usize, _: Option<&Met>| {
            walker.see(plane_of::<M>(out, plane), seen, 1.0);
        };
        self.follow(route, &mut walker, (places, weight * SPLIT_FROM, None), ledger, &mut each);
        ledger.close_path(balance);
    }

    /// A path from there, and where in the picture and the pupil that is.
    fn walker<'o>(
        &self,
        optics: &'o Optics<M>,
        (pixel, jitter, pupil): (Pixel, [f64; 2], DVec2),
        (weight, rng): (f64, Rng),
    ) -> (Walker<'o, M>, (DVec2, DVec2))
    where
        'w: 'o,
    {
        let eye = &self.world.eye;
        let (film, pupil) = (eye.film_of(pixel.x, pixel.y, jitter), eye.pupil_radius_m() * pupil);
        let (origin, (_, dir), ..) = eye.ray_of(film, pupil);
        let ray = Ray { origin, dir, from: None };
        let mut walker = Walker::new((self.world, optics), Travel::FromEye, ray, weight, Interior::default(), rng);
        // What a long train of faces shows, as through a light guide, is not left to chance while it is much of the light.
        walker.worth = WORTH;
        (walker, (film, pupil))
    }

    /// Whether a path to a connected lamp is one that connection leaves to rays from the eye. `places`: in the picture and the
    /// pupil, where it started. Adds to the counted work.
    fn is_left(
        &self,
        walker: &Walker<'_, M>,
        (lamp, vertex): (usize, &Vertex),
        places: (DVec2, DVec2),
        work: &mut u64,
    ) -> bool {
        let Some((unknown, chain)) = self.unknown.as_ref().zip(walker.chain()) else { return false };
        let target = Target::new(vertex.hit.point, vertex.hit.normal);
        let tracing = (self.world, walker.optics);
        unknown.connections.of(walker.optics).leaves_to_eye(tracing, &chain.reversed(), (lamp, &target), places, work)
    }

    /// Calls `each` with the lamps of ours that a path and its branches meet, their planes, and where it crossed slides. `places`:
    /// where it started in the picture and the pupil. `least`: below this chance decides between the ways on.
    fn follow(
        &self,
        route: &Ownership,
        walker: &mut Walker<'_, M>,
        (places, least, mut met): ((DVec2, DVec2), f64, Option<Met>),
        ledger: &mut Ledger,
        each: &mut impl FnMut(&Walker<'_, M>, &EmitterHit<'_>, usize, Option<&Met>),
    ) {
        loop {
            let vertex = match walker.advance(ledger) {
                Ahead::Sky => {
                    walker.escape(ledger);
                    return;
                }
                Ahead::Pupil(_) | Ahead::Ended => return,
                Ahead::Face(vertex) => vertex,
            };
            if let Some(seen) = walker.lamp_at(&vertex)
                && let Some(share) = route.from_eye(seen.lamp.group, walker.trail)
                && (!route.is_connected(seen.lamp.group)
                    || self.is_left(walker, (seen.index, &vertex), places, &mut ledger.work))
            {
                let plane = route.plane_from_eye(share, walker.told, seen.lamp.group, Source::Face);
                each(walker, &seen, plane, met.as_ref());
            }
            // Without the slides' factors, so that pictures at two contrasts share every path.
            let share = walker.beam.weight();
            if share > least {
                let mut branch_off = |mut branch: Walker<'_, M>, ledger: &mut Ledger| {
                    let mut met = met.clone();
                    if let Some(met) = &mut met {
                        met.pass(&branch, &vertex);
                    }
                    self.follow(route, &mut branch, (places, least, met), ledger, each);
                };
                if let Some(orders) = walker.split_orders(&vertex, least / share, ledger) {
                    let mut orders = orders.into_iter();
                    let Some(brightest) = orders.next() else { return };
                    orders.for_each(|branch| branch_off(branch, ledger));
                    *walker = brightest;
                    if let Some(met) = &mut met {
                        met.pass(walker, &vertex);
                    }
                    continue;
                }
                if let Some(reflected) = walker.split(&vertex, least / share, u8::MAX, ledger) {
                    branch_off(reflected, ledger);
                }
            }
            walker.last = None;
            match walker.meet(&vertex, ledger) {
                Meeting::Ended => return,
                Meeting::Went => {}
                Meeting::Scatter(..) => {
                    ledger.not_owned += walker.beam.carried();
                    return;
                }
            }
            if let Some(met) = &mut met
                && walker.last.is_some()
            {
                met.pass(walker, &vertex);
            }
        }
    }
}
