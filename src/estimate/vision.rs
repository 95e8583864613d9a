//! What the eye sees of lamps through specular faces alone (`E S* L`), apart from the paths that scatter: such paths
//! cost little and know their way, so they get points of their own in every pixel and follow both ways on at an
//! interface. A mirrored lamp smaller than a pixel would otherwise be the noise of the whole picture.

use super::ledger::Ledger;
use super::pixel::Pixel;
use super::route::Route;
use super::walk::{Meeting, Met, Travel, Walker};
use crate::base::lpe::Source;
use crate::base::path::{Event, Trail};
use crate::base::rng::Stream;
use crate::film::accumulate::Light;
use crate::world::World;
use crate::world::geometry::Ray;
use crate::world::interior::Interior;
use crate::world::mode::{Mode, plane_of};
use crate::world::optics::Optics;

/// Paths per pixel and pass: more where the pupil is a point, since then nobody else finds the image of a small lamp.
const PATHS: u64 = 4;
const PATHS_OF_A_PINHOLE: u64 = 16;
/// A path is split where both ways on carry at least this share of what it started with; else chance decides.
const SPLIT_FROM: f64 = 1.0 / 256.0;

/// Follows paths from the eye to lamps, over specular events only.
pub struct Vision<'w> {
    world: &'w World,
    paths: u64,
    seed: u64,
}

impl<'w> Vision<'w> {
    /// None if the route leaves direct vision of all lamps to others.
    pub fn new(world: &'w World, route: &Route, seed: u64) -> Option<Self> {
        let owned = |trail: Trail| world.lamps.all().iter().any(|lamp| route.from_eye(lamp.group, trail).is_some());
        let paths = if world.eye.pupil_radius_m() > 0.0 { PATHS } else { PATHS_OF_A_PINHOLE };
        (owned(Trail::START) || owned(Trail::START.then(Event::Specular))).then_some(Vision { world, paths, seed })
    }

    /// Adds what one pass sees in a pixel to `out`, by plane.
    pub fn look<M: Mode>(
        &self,
        route: &Route,
        optics: &Optics<M>,
        pixel: Pixel,
        out: &mut [Light],
        ledger: &mut Ledger,
    ) {
        let mut rng = pixel.rng(self.seed, Stream::Vision);
        for path in 0..self.paths {
            // The pupil is left to chance: all points are spent on the picture, where a small image is hard to find.
            let jitter = pixel.start(self.seed, Stream::Vision, pixel.pass.wrapping_mul(self.paths).wrapping_add(path));
            let (origin, dir) = self.world.eye.ray(pixel.x, pixel.y, jitter, rng.pair());
            let ray = Ray { origin, dir, from: None };
            let weight = 1.0 / self.paths as f64;
            let mut walker =
                Walker::new((self.world, optics), Travel::FromEye, ray, weight, Interior::default(), rng.fork());
            let balance = ledger.imbalance();
            ledger.paths += 1;
            ledger.emitted += weight;
            self.follow(route, &mut walker, weight * SPLIT_FROM, out, ledger);
            ledger.close_path(balance);
        }
    }

    fn follow<M: Mode>(
        &self,
        route: &Route,
        walker: &mut Walker<'_, M>,
        least: f64,
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
            {
                let plane = route.plane_from_eye(share, walker.told, seen.lamp.group, Source::Face);
                walker.see(plane_of::<M>(out, plane), &seen, 1.0);
            }
            // Without the slides' factors, so that pictures at two contrasts share every path.
            let share = walker.beam.weight();
            if share > least
                && let Some(mut reflected) = walker.split(&vertex, least / share, u8::MAX, ledger)
            {
                self.follow(route, &mut reflected, least, out, ledger);
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
