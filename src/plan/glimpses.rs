//! What rays from the eye see of lamps over specular faces: a small mirror that a lamp hardly ever hits may be in plain
//! sight, and a pilot from the lamps alone would not know its light.

use super::chains::{Arrived, SEED};
use crate::base::rng::{Rng, Stream};
use crate::base::warp::disk;
use crate::estimate::ShouldStop;
use crate::estimate::ledger::Ledger;
use crate::estimate::walk::{Meeting, Met, Travel, Walker};
use crate::world::World;
use crate::world::geometry::Ray;
use crate::world::interior::Interior;
use crate::world::mode::Mono;
use crate::world::optics::Optics;
use glam::DVec2;
use rayon::prelude::*;

/// Rays, spread evenly over the picture.
const RAYS: u64 = 1 << 10;
/// A ray is followed both ways where each carries this share of what it started with.
const LEAST: f64 = 1e-3;
/// Faces that one ray and all its branches may meet.
const MOST_MET: u32 = 256;
/// What the fractional parts of multiples of the golden ratio are spread by.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Where a ray started.
#[derive(Clone, Copy)]
struct From {
    film: DVec2,
    pupil: DVec2,
    /// Pixels that it stands for.
    pixels: f64,
}

/// Lamps seen over chains of specular faces, as if their light had arrived. Once `stop` says true the rest is left out.
pub(super) fn look((world, optics): (&World, &Optics<Mono>), stop: &ShouldStop<'_>) -> Vec<Arrived> {
    let [width, height] = world.eye.size().map(|n| n as f64);
    let ray = |k: u64| {
        let mut found = Vec::new();
        if stop() {
            return found;
        }
        let mut rng = Rng::new(SEED, Stream::Pilot, 2, k);
        let place = [(k as f64 + 0.5) / RAYS as f64 * width, (k as f64 * GOLDEN).fract() * height];
        let film = world.eye.film_of(0, 0, place);
        let pupil = disk(rng.pair()) * world.eye.pupil_radius_m();
        let pupil = DVec2::new(pupil.x, pupil.y);
        let (origin, (_, dir), ..) = world.eye.ray_of(film, pupil);
        let ray = Ray { origin, dir, from: None };
        let walker = Walker::new((world, optics), Travel::FromEye, ray, 1.0, Interior::default(), rng).recording();
        let from = From { film, pupil, pixels: width * height / RAYS as f64 };
        follow(walker, from, &mut 0, &mut Ledger::new(world.solids.len()), &mut found);
        found
    };
    (0..RAYS).into_par_iter().flat_map_iter(ray).collect()
}

fn follow(mut walker: Walker<'_, Mono>, from: From, met: &mut u32, ledger: &mut Ledger, found: &mut Vec<Arrived>) {
    loop {
        let Met::Face(vertex) = walker.advance(ledger) else { return };
        *met += 1;
        if *met > MOST_MET {
            return;
        }
        if let (Some(seen), Some(chain)) = (walker.lamp_at(&vertex), walker.chain()) {
            // With the slides open: a dark place of the picture has the same trains.
            let ([light], _) = walker.seen(&seen);
            found.push(Arrived {
                group: seen.lamp.group,
                chain: chain.reversed(),
                lamp: seen.index,
                film: from.film,
                pupil: from.pupil,
                luminance: light.open() * from.pixels,
            });
        }
        let share = walker.share();
        if share > LEAST
            && let Some(reflected) = walker.split(&vertex, LEAST / share, u8::MAX, ledger)
        {
            follow(reflected, from, met, ledger, found);
        }
        match walker.meet(&vertex, ledger) {
            Meeting::Went => {}
            Meeting::Ended | Meeting::Scatter(..) => return,
        }
    }
}
