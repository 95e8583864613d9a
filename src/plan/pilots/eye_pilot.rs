//! What rays from the eye see over specular faces. Of lamps: a small mirror that a lamp hardly ever hits may be in plain
//! sight, and a pilot from the lamps alone would not know its light.

use super::chains::{Arrived, SEED};
use super::tuning::eye_pilot::{LEAST, MOST_MET, RAYS};
use eyebox_base::parallel;
use eyebox_base::rng::{Rng, Stream};
use eyebox_base::warp::disk;
use eyebox_estimate::ShouldStop;
use eyebox_estimate::ledger::Ledger;
use eyebox_estimate::walk::{Meeting, Met, Travel, Vertex, Walker};
use eyebox_world::World;
use eyebox_world::geometry::{Ray, Site};
use eyebox_world::interior::Interior;
use eyebox_world::mode::Mono;
use eyebox_world::optics::Optics;
use glam::DVec2;
use std::collections::BTreeSet;

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
pub(crate) fn look(tracing: (&World, &Optics<Mono>), stop: &ShouldStop<'_>) -> Vec<Arrived> {
    each_met(tracing, stop, |walker, vertex, from| {
        let (seen, chain) = (walker.lamp_at(vertex)?, walker.chain()?);
        // With the slides open: a dark place of the picture has the same trains.
        let ([light], _) = walker.seen(&seen);
        Some(Arrived {
            group: seen.lamp.group,
            chain: chain.reversed(),
            lamp: seen.index,
            film: from.film,
            pupil: from.pupil,
            on_lamp: [vertex.hit.point, vertex.hit.normal],
            luminance: light.open() * from.pixels,
        })
    })
}

/// The faces (part, face) that rays from the eye meet first, or after specular ones. Once `stop` says true the rest is left
/// out.
pub(crate) fn faces(tracing: (&World, &Optics<Mono>), stop: &ShouldStop<'_>) -> BTreeSet<(u32, u32)> {
    each_met(tracing, stop, |_, vertex, _| Some(sides_of(vertex))).into_iter().flatten().flatten().collect()
}

/// The face that a path has met, and the one that touches it there.
pub(crate) fn sides_of(vertex: &Vertex) -> [Option<(u32, u32)>; 2] {
    let face = |site: Site| (site.part, site.face);
    [Some(face(vertex.hit.site)), vertex.touching.map(|other| face(other.site))]
}

/// What `take` makes of the faces that rays from the eye and their branches meet over specular ones.
fn each_met<T: Send>(
    (world, optics): (&World, &Optics<Mono>),
    stop: &ShouldStop<'_>,
    take: impl Fn(&Walker<'_, Mono>, &Vertex, From) -> Option<T> + Sync,
) -> Vec<T> {
    let [width, height] = world.eye.size().map(|n| n as f64);
    let ray = |k: u64, found: &mut Vec<T>| {
        if stop() {
            return;
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
        follow(walker, &mut 0, &mut Ledger::new(world.solids.len()), &mut |walker, vertex| {
            found.extend(take(walker, vertex, from));
        });
    };
    parallel::flat_map(RAYS, &ray)
}

fn follow(
    mut walker: Walker<'_, Mono>,
    met: &mut u32,
    ledger: &mut Ledger,
    each: &mut impl FnMut(&Walker<'_, Mono>, &Vertex),
) {
    loop {
        let Met::Face(vertex) = walker.advance(ledger) else { return };
        *met += 1;
        if *met > MOST_MET {
            return;
        }
        each(&walker, &vertex);
        let share = walker.share();
        if share > LEAST
            && let Some(reflected) = walker.split(&vertex, LEAST / share, u8::MAX, ledger)
        {
            follow(reflected, met, ledger, each);
        }
        match walker.meet(&vertex, ledger) {
            Meeting::Went => {}
            Meeting::Ended | Meeting::Scatter(..) => return,
        }
    }
}
