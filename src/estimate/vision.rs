//! What the eye sees of lamps through specular faces alone (`E S* L`), apart from the paths that scatter: such paths
//! cost little and know their way, so they get points of their own in every pixel and follow both ways on at an
//! interface. A mirrored lamp smaller than a pixel would otherwise be the noise of the whole picture; where the plan knows
//! of one in a pinhole's picture, some of the points are chosen about it. Through a pupil that is no point, a lamp is seen
//! in a small part of it: where the plan knows which, most of the rays go there. Where specular connection has what it can,
//! some pixels of a pass look for what comes over trains of faces that it does not know, or has no start for there, and for
//! what the solver leaves of trains that paths from the lamps were not seen to arrive by.

use super::ledger::Ledger;
use super::ownership::Ownership;
use super::pixel::Pixel;
use super::tuning::vision::{LARGE, MOST_GLINTS, MOST_PIXELS, PATHS, PATHS_OF_A_GLINT, SPLIT_FROM};
use super::walk::{Meeting, Met, Travel, Vertex, Walker};
use crate::base::lpe::Source;
use crate::base::path::{Event, Trail};
use crate::base::rng::Stream;
use crate::base::warp::disk;
use crate::estimate::manifold::seeds::bands::Bands;
use crate::estimate::manifold::solver::newton::Target;
use crate::film::accumulate::Light;
use crate::film::guide::{ApertureGuide, Portals};
use crate::film::plan::Plan;
use crate::film::specular_chain::Glint;
use crate::world::World;
use crate::world::eye::EyeLens;
use crate::world::geometry::Ray;
use crate::world::interior::Interior;
use crate::world::lamp::Lamp;
use crate::world::mode::{Mode, plane_of};
use crate::world::optics::Optics;
use glam::DVec2;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

/// What a plan knows of where lamps are seen, and the sky.
#[derive(Debug, Clone, Copy)]
pub struct Hints<'p> {
    /// In a pinhole's picture.
    pub glints: &'p [Glint],
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
        Hints { glints: &[], pupil: None, windows, share: 1.0 }
    }

    pub fn of(plan: &'p Plan) -> Hints<'p> {
        let (pupil, windows) = (plan.pupil_guide.as_ref(), plan.sky_guide.as_ref());
        // Of the pixels that are looked at anyway.
        let share = (plan.vision_share / plan.backward_share).min(1.0);
        Hints { glints: &plan.glints, pupil, windows, share }
    }
}

/// Follows paths from the eye to lamps, over specular events only.
pub struct Vision<'w> {
    world: &'w World,
    /// Some group is ours whose lamps are not connected.
    whole: bool,
    /// Of the pixels that a pass looks at for those.
    share: f64,
    unknown: Option<Unknown>,
    /// By pixel: the places in it or near it that show lamps.
    glints: HashMap<u64, Vec<Glint>>,
    pupil: Option<ApertureGuide>,
    seed: u64,
}

/// What specular connection leaves to rays from the eye.
struct Unknown {
    /// What it does not leave.
    connections: Arc<Bands>,
    /// Of the pixels that a pass looks at for that.
    share: f64,
}

/// Columns and rows of the pixels that a glint reaches into; none if it is left to the paths of each.
fn reach(eye: &EyeLens, glint: &Glint) -> Option<[Range<usize>; 2]> {
    let (half, [w, h], [width, height]) = (eye.half(), eye.pixel(), eye.size());
    if glint.area() > LARGE * w * h {
        return None;
    }
    let range = |lo: f64, hi: f64, count: usize| {
        let clamped = |x: f64| x.floor().clamp(0.0, count as f64) as usize;
        clamped(lo)..clamped(hi + 1.0)
    };
    let ([x, y], [wide, high]) = (glint.middle, glint.half());
    let columns = range((half.x + x - wide) / w, (half.x + x + wide) / w, width);
    let rows = range((half.y - y - high) / h, (half.y - y + high) / h, height);
    (columns.len() * rows.len() <= MOST_PIXELS).then_some([columns, rows])
}

/// Whether pixels have points of their own for a glint.
pub fn is_looked_about(eye: &EyeLens, glint: &Glint) -> bool {
    reach(eye, glint).is_some()
}

/// The glints that reach into each pixel: of many the first.
fn by_pixel(eye: &EyeLens, glints: &[Glint]) -> HashMap<u64, Vec<Glint>> {
    let [width, _] = eye.size();
    let mut all: HashMap<u64, Vec<Glint>> = HashMap::new();
    for (glint, [columns, rows]) in glints.iter().filter_map(|glint| Some((glint, reach(eye, glint)?))) {
        for (px, py) in rows.flat_map(|py| columns.clone().map(move |px| (px, py))) {
            let here = all.entry((py * width + px) as u64).or_default();
            if here.len() < MOST_GLINTS {
                here.push(*glint);
            }
        }
    }
    all
}

impl<'w> Vision<'w> {
    /// None if the route leaves direct vision of all lamps to others.
    pub fn new(world: &'w World, route: &Ownership, hints: Hints<'_>, seed: u64) -> Option<Self> {
        let trails = [Trail::START, Trail::START.then(Event::Specular)];
        let ours = |lamp: &&Lamp| trails.iter().any(|trail| route.from_eye(lamp.group, *trail).is_some());
        let mut ours = world.lamps.all().iter().filter(ours).peekable();
        ours.peek()?;
        Some(Vision {
            world,
            whole: ours.any(|lamp| !route.is_connected(lamp.group)),
            share: hints.share,
            unknown: None,
            glints: by_pixel(&world.eye, hints.glints),
            pupil: hints.pupil.cloned(),
            seed,
        })
    }

    /// Looks for what these connections don't know, too, at this share of the pixels in a pass.
    pub fn beside(&mut self, connections: Arc<Bands>, share: f64) {
        self.unknown = (!connections.is_empty()).then_some(Unknown { connections, share });
    }

    /// Adds what one pass sees in a pixel to `out`, by plane.
    pub fn look<M: Mode>(
        &self,
        route: &Ownership,
        optics: &Optics<M>,
        pixel: Pixel,
        out: &mut [Light],
        ledger: &mut Ledger,
    ) {
        let share = match &self.unknown {
            _ if self.whole => self.share,
            Some(unknown) => unknown.share,
            None => return,
        };
        let mut rng = pixel.rng(self.seed, Stream::Vision);
        if share < 1.0 && rng.uniform() >= share {
            return;
        }
        let glints = self.glints.get(&pixel.index).map_or(&[][..], Vec::as_slice);
        let eye = &self.world.eye;
        let cell = eye.pixel().iter().product::<f64>();
        let [width, height] = eye.size();
        let field = [(pixel.x as f64 + 0.5) / width as f64, (pixel.y as f64 + 0.5) / height as f64];
        let corner = eye.film_of(pixel.x, pixel.y, [0.0; 2]);
        // All points of the pixel count by the density of all ways to choose them (the balance heuristic of E. Veach, 1997).
        let density = |film: [f64; 2]| {
            let about = glints.iter().filter(|glint| glint.holds(film)).map(|glint| cell / glint.area()).sum::<f64>();
            PATHS as f64 + PATHS_OF_A_GLINT as f64 * about
        };
        let about = PATHS_OF_A_GLINT * glints.len() as u64;
        for path in 0..PATHS + about {
            let index = |path: u64, of: u64| pixel.pass.wrapping_mul(of).wrapping_add(path);
            // Without a guide the pupil is left to chance: all points are spent on the picture, where a small image is hard
            // to find. With one little else is left to find.
            let (jitter, lens, of_lens) = match (path.checked_sub(PATHS), &self.pupil) {
                (None, None) => (pixel.start(self.seed, Stream::Vision, index(path, PATHS)), rng.pair(), 1.0),
                (None, Some(guide)) => {
                    let [x, y, u, v] = pixel.start(self.seed, Stream::Vision, index(path, PATHS));
                    let (lens, density) = guide.draw(field, [u, v]);
                    ([x, y], lens, density)
                }
                (Some(path), _) => {
                    let glint = &glints[(path / PATHS_OF_A_GLINT) as usize];
                    let place: [f64; 2] = pixel.start(self.seed, Stream::Glint, index(path, about));
                    let [x, y] = glint.place(place.map(|u| 2.0 * u - 1.0));
                    let [width, height] = eye.pixel();
                    ([(x - corner.x) / width, (corner.y - y) / height], rng.pair(), 1.0)
                }
            };
            // A glint may reach into other pixels, which have points of their own for it.
            if !jitter.iter().all(|x| (0.0..1.0).contains(x)) {
                continue;
            }
            let film = eye.film_of(pixel.x, pixel.y, jitter);
            let weight = 1.0 / (share * of_lens * density(film.to_array()));
            let (origin, dir) = eye.ray(pixel.x, pixel.y, jitter, lens);
            let ray = Ray { origin, dir, from: None };
            let mut walker =
                Walker::new((self.world, optics), Travel::FromEye, ray, weight, Interior::default(), rng.fork());
            if self.unknown.is_some() {
                walker = walker.recording();
            }
            let pupil = eye.pupil_radius_m() * disk(lens);
            let balance = ledger.imbalance();
            ledger.paths += 1;
            ledger.emitted += weight;
            self.follow(route, &mut walker, ((film, pupil), weight * SPLIT_FROM), out, ledger);
            ledger.close_path(balance);
        }
    }

    /// Whether a path to a connected lamp is one that connection leaves to rays from the eye. `places`: in the picture and the
    /// pupil, where it started. Adds to the counted work.
    fn is_left<M: Mode>(
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

    /// `places`: where the path started in the picture and the pupil. `least`: below this chance decides between the ways on.
    fn follow<M: Mode>(
        &self,
        route: &Ownership,
        walker: &mut Walker<'_, M>,
        (places, least): ((DVec2, DVec2), f64),
        out: &mut [Light],
        ledger: &mut Ledger,
    ) {
        loop {
            let vertex = match walker.advance(ledger) {
                Met::Sky => {
                    walker.escape(ledger);
                    return;
                }
                Met::Pupil(_) | Met::Ended => return,
                Met::Face(vertex) => vertex,
            };
            if let Some(seen) = walker.lamp_at(&vertex)
                && let Some(share) = route.from_eye(seen.lamp.group, walker.trail)
                && (!route.is_connected(seen.lamp.group)
                    || self.is_left(walker, (seen.index, &vertex), places, &mut ledger.work))
            {
                let plane = route.plane_from_eye(share, walker.told, seen.lamp.group, Source::Face);
                walker.see(plane_of::<M>(out, plane), &seen, 1.0);
            }
            // Without the slides' factors, so that pictures at two contrasts share every path.
            let share = walker.beam.weight();
            if share > least
                && let Some(mut reflected) = walker.split(&vertex, least / share, u8::MAX, ledger)
            {
                self.follow(route, &mut reflected, (places, least), out, ledger);
            }
            match walker.meet(&vertex, ledger) {
                Meeting::Ended => return,
                Meeting::Went => {}
                Meeting::Scatter(..) => {
                    ledger.not_owned += walker.beam.carried();
                    return;
                }
            }
        }
    }
}
