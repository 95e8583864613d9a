//! What the eye sees of faces that are joined with lamps: paths from the eye over specular faces to the first scatterer, in
//! pairs whose points of the pupil and of the pixel lie opposite each other, so that what is linear in them is exact.
//! Where they land is read from [`Glances`](super::glances::Glances), whose errors a few paths make good.

use super::screens::{Incoming, Screens};
use super::vision::Manifold;
use crate::base::lpe::{Letter, Source};
use crate::base::path::{Event, Trail};
use crate::base::rng::Stream;
use crate::base::warp::{Frame, disk};
use crate::estimate::ledger::{Ledger, cost};
use crate::estimate::pixel::Pixel;
use crate::estimate::walk::{Meeting, Met, SPLIT_FIRST_EVENTS, Travel, Vertex, Walker};
use crate::film::accumulate::Light;
use crate::world::geometry::Ray;
use crate::world::interior::Interior;
use crate::world::mode::{LaneArray, Mode, lanes, plane_of};
use crate::world::optics::Optics;
use crate::world::scatter::Scatter;
use crate::world::surface::Surface;
use glam::DVec2;

/// What each path of a pair starts with.
const OF_PAIR: f64 = 0.5;

/// Adds what one pass sees in a pixel.
pub(super) fn look<M: Mode>(
    manifold: &Manifold<'_, M>,
    (optics, screens): (&Optics<M>, &Screens<M>),
    pixel: Pixel,
    out: &mut [Light],
    (ledger, scratch): (&mut Ledger, &mut Ledger),
) {
    let world = manifold.world;
    let [x, y, u, v, s, t] = pixel.start(manifold.seed, Stream::ConnectionLook, pixel.pass);
    let mut rng = pixel.rng(manifold.seed, Stream::ConnectionLook);
    let pupil = disk([u, v]) * world.eye.pupil_radius_m();
    for (jitter, pupil, lamp) in [([x, y], pupil, [s, t]), ([1.0 - x, 1.0 - y], -pupil, [1.0 - s, 1.0 - t])] {
        let film = world.eye.film_of(pixel.x, pixel.y, jitter);
        let pupil = DVec2::new(pupil.x, pupil.y);
        let known = manifold.glances.as_ref().and_then(|glances| Some((glances, glances.look(film, pupil)?)));
        let share = known.as_ref().map_or(1.0, |(_, look)| look.share());
        let followed = share >= 1.0 || rng.uniform() < share;
        if let Some((glances, look)) = known.filter(|_| share < 1.0) {
            // What the tables say, less what stands for it where the ray itself is followed.
            let control = if followed { 1.0 - 1.0 / share } else { 1.0 };
            glances.each((world, optics), &look, OF_PAIR * control, &mut rng, |mut walker, vertex| {
                let Surface::Scatter(scatter) = &walker.face(&vertex).surface else { return };
                // The nodes over picture and pupil, and one face to be met.
                scratch.work += cost::STEP;
                let landed = (&mut walker, &vertex, &**scatter, Frame::about(vertex.normal));
                gather(manifold, landed, (screens, lamp), out, scratch);
            });
        }
        if !followed {
            continue;
        }
        let whole = OF_PAIR / share;
        let (origin, (_, dir), ..) = world.eye.ray_of(film, pupil);
        let ray = Ray { origin, dir, from: None };
        let walker = Walker::new((world, optics), Travel::FromEye, ray, whole, Interior::default(), rng.fork());
        let balance = ledger.imbalance();
        ledger.paths += 1;
        ledger.emitted += whole;
        to_scatterer(walker, whole, ledger, &mut |walker, vertex, scatter, frame, ledger| {
            gather(manifold, (walker, vertex, scatter, frame), (screens, lamp), out, scratch);
            ledger.not_owned += walker.beam.carried();
        });
        ledger.close_path(balance);
    }
}

/// Follows a path and its branches to the first broad scatterers. `whole`: what the path started with.
pub(super) fn to_scatterer<'w, M: Mode>(
    mut walker: Walker<'w, M>,
    whole: f64,
    ledger: &mut Ledger,
    each: &mut impl FnMut(&mut Walker<'w, M>, &Vertex, &'w Scatter, Frame, &mut Ledger),
) {
    loop {
        let vertex = match walker.advance(ledger) {
            Met::Sky => return walker.escape(ledger),
            Met::Pupil(_) | Met::Ended => return,
            Met::Face(vertex) => vertex,
        };
        let other = if walker.events < SPLIT_FIRST_EVENTS {
            walker.split(&vertex, 0.0, Walker::<M>::MOST_SPLITS, ledger)
        } else {
            walker.spare(&vertex, whole, ledger)
        };
        if let Some(reflected) = other {
            to_scatterer(reflected, whole, ledger, each);
        }
        match walker.meet(&vertex, ledger) {
            Meeting::Ended => return,
            Meeting::Went => {}
            // Narrow lobes are left to rays from the eye.
            Meeting::Scatter(scatter, _) if scatter.is_narrow() => {
                ledger.not_owned += walker.beam.carried();
                return;
            }
            Meeting::Scatter(scatter, frame) => return each(&mut walker, &vertex, scatter, frame, ledger),
        }
    }
}

/// Adds what lamps bring to where a path has met a scatterer.
fn gather<M: Mode>(
    manifold: &Manifold<'_, M>,
    (walker, vertex, scatter, frame): (&mut Walker<'_, M>, &Vertex, &Scatter, Frame),
    (screens, lamp): (&Screens<M>, [f64; 2]),
    out: &mut [Light],
    scratch: &mut Ledger,
) {
    let d_in = frame.to_local(walker.ray.dir);
    let sides = walker.sides(vertex, scatter);
    let mut rng = walker.rng.fork();
    let walker = &*walker;
    let tracing = (manifold.world, walker.optics);
    let interior = |dir: glam::DVec3| walker.interior_at(vertex, frame.to_local(dir).z < 0.0);
    let trail = Trail::join(walker.trail, scatter.event(), Trail::START.then(Event::Specular));
    let at = (vertex.hit.point, vertex.hit.site);
    screens.gather(tracing, at, &interior, lamp, &mut rng, scratch, |incoming: Incoming<'_, M>| {
        let Some(lamp) = manifold.world.lamps.get(incoming.lamp) else { return };
        let Some(share) = manifold.route.from_eye(lamp.group, trail) else { return };
        let d_out = frame.to_local(incoming.dir);
        let (values, alone) = sides.eval(scatter, d_in, d_out);
        if values.as_slice().iter().all(|value| *value == 0.0) {
            return;
        }
        let plane = manifold.route.plane(share, |sieve| {
            let start = sieve.lamp(lamp.group.index(), Source::Face);
            let arrived = incoming.letters.iter().fold(start, |told, letter| sieve.before(told, *letter));
            let letter = Letter::of(scatter.event(), d_out.z < 0.0);
            sieve.takes(sieve.after(walker.told, letter), arrived)
        });
        let factors = lanes::<M, _>(|lane| values[lane] * d_out.z.abs());
        let light = (&incoming.light, incoming.alone || alone);
        walker.beam.join(walker.optics, plane_of::<M>(out, plane), light, &factors);
    });
}
