//! What the eye sees of faces that are joined with lamps: paths from the eye over specular faces to the first scatterer, in
//! pairs whose points of the pupil and of the pixel lie opposite each other, so that what is linear in them is exact.
//! Where they land is read from [`EyeTable`](super::eye_table::EyeTable), whose errors a few paths make good. In pixels with an edge of a
//! slide's picture both stand for all of the pixel, for which the table says how the landing moves over it.

use super::eye_table::first_scatterer::to_scatterer;
use super::eye_table::{Counted, EyeTable, Glanced, Rest};
use super::pixel_span::Span;
use super::receiver::{Ask, Incoming, Receivers};
use super::tuning::eye_subpath::{AT_EDGES, BLOCK, MOST_PAIRS, OF_PAIR, PER_PIXEL};
use super::tuning::vision::INSIDE;
use super::vision::Manifold;
use crate::ledger::{Ledger, cost};
use crate::pixel::Pixel;
use crate::specular_event::Faint;
use crate::walk::{Travel, Vertex, Walker};
use eyebox_base::lpe::{Letter, Source};
use eyebox_base::parallel;
use eyebox_base::path::{Event, Trail};
use eyebox_base::rng::{Rng, Stream};
use eyebox_base::warp::{Frame, disk};
use eyebox_film::accumulate::Light;
use eyebox_world::World;
use eyebox_world::geometry::Ray;
use eyebox_world::interior::Interior;
use eyebox_world::mode::{LaneArray, Mode, lanes, plane_of};
use eyebox_world::optics::Optics;
use eyebox_world::scatter::Scatter;
use eyebox_world::surface::Surface;
use glam::{DVec2, DVec3};

/// By how many pairs of places of the pupil and of lamps tables tell in a pass what a pixel sees over all of them, where a slide's
/// picture has an edge in it for any of them; else 0. The more the farther the edge moves between them. Empty where no tables cross
/// slides.
pub(super) fn pairs_at_edges<M: Mode>(
    world: &World,
    seed: u64,
    screens: &Receivers<M>,
    glances: Option<&EyeTable<M>>,
) -> Vec<u8> {
    let Some(glances) = glances.filter(|_| screens.cross_slides()) else { return Vec::new() };
    let tracing = (world, &M::optics(world, seed, 0));
    let [width, height] = world.eye.size();
    let of = |vertex: &Vertex, span: Span, by_pupil: [DVec3; 2]| {
        let moves = screens.edge_moves(world, (vertex.hit.point, vertex.hit.site), &span, by_pupil);
        moves.map_or(0, |moves| ((PER_PIXEL * moves).ceil() as u64).clamp(1, MOST_PAIRS))
    };
    let most = |[x, y]: [usize; 2], side: usize| {
        let film = |[u, v]: [f64; 2]| world.eye.film_of(x, y, [u, v].map(|place| side as f64 * place));
        let corners = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|corner| film(corner.map(|k| INSIDE[k])));
        glances.most(tracing, (film([0.5; 2]), corners, side as f64), of)
    };
    // Most blocks are even.
    let across = width.div_ceil(BLOCK);
    let even = |k: usize| most([k % across * BLOCK, k / across * BLOCK], BLOCK) == Some(0);
    let even: Vec<bool> = parallel::map(across * height.div_ceil(BLOCK), &even);
    let pairs = |index: usize| {
        let [x, y] = [index % width, index / width];
        if even[y / BLOCK * across + x / BLOCK] { 0 } else { most([x, y], 1).unwrap_or(0) as u8 }
    };
    parallel::map(width * height, &pairs)
}

/// Where a path of a pair starts.
struct Place {
    /// In the picture, tangents, and in the pupil, m.
    film: DVec2,
    pupil: DVec2,
    /// In the pixel, from its middle.
    within: DVec2,
    /// On lamps.
    uv: [f64; 2],
    /// Where their turns begin if not all are asked.
    turn: f64,
}

/// A pair of places by a number of the pixel's lattice, that lie opposite each other.
fn pair<M: Mode>(
    manifold: &Manifold<'_, M>,
    pixel: Pixel,
    (stream, index): (Stream, u64),
    rng: &mut Rng,
) -> [Place; 2] {
    let eye = &manifold.world.eye;
    let [x, y, u, v, s, t] = pixel.start(manifold.seed, stream, index);
    let pupil = disk([u, v]) * eye.pupil_radius_m();
    // Lamps that are not asked by the one are by the other.
    let turn = rng.uniform();
    let place = |jitter: [f64; 2], pupil: DVec2, uv: [f64; 2], turn: f64| Place {
        film: eye.film_of(pixel.x, pixel.y, jitter),
        pupil,
        within: DVec2::from_array(jitter) - 0.5,
        uv,
        turn,
    };
    [place([x, y], pupil, [s, t], turn), place([1.0 - x, 1.0 - y], -pupil, [1.0 - s, 1.0 - t], (turn + 0.5).fract())]
}

/// Adds what one pass sees in a pixel.
pub(super) fn look<M: Mode>(
    manifold: &Manifold<'_, M>,
    (optics, screens): (&Optics<M>, &Receivers<M>),
    pixel: Pixel,
    out: &mut [Light],
    (ledger, scratch): (&mut Ledger, &mut Ledger),
) {
    let world = manifold.world;
    let mut rng = pixel.rng(manifold.seed, Stream::ConnectionLook);
    let pairs = manifold.pairs_at_edges(pixel.index);
    let (least, counted) = if pairs > 0 { (AT_EDGES, Counted::Differences) } else { (0.0, Counted::Both) };
    if pairs > 0 {
        look_over(manifold, (optics, screens), (pixel, pairs), out, scratch);
    }
    for Place { film, pupil, within, uv, turn } in pair(manifold, pixel, (Stream::ConnectionLook, pixel.pass), &mut rng)
    {
        let ask = Ask { uv, seen: 1.0, turn, span: None };
        let glances = manifold.glances.as_deref();
        let rest = glances.map_or(Some(Rest::ALL), |glances| {
            let asked = (OF_PAIR, Glanced::Lit, least);
            let within = Some(within).filter(|_| counted == Counted::Both && manifold.cuts_slides());
            glances.read(
                (world, optics),
                (film, pupil, within),
                asked,
                counted,
                &mut rng,
                |walker, vertex, whole, span| {
                    read(manifold, (walker, vertex), (screens, Ask { seen: 1.0 / whole, span, ..ask }), out, scratch);
                },
            )
        });
        let Some(rest) = rest else { continue };
        let whole = OF_PAIR / rest.share;
        let (origin, (_, dir), ..) = world.eye.ray_of(film, pupil);
        let ray = Ray { origin, dir, from: None };
        let walker = Walker::new((world, optics), Travel::FromEye, ray, whole, Interior::default(), rng.fork());
        let walker = if rest.asks() { walker.recording() } else { walker };
        let balance = ledger.imbalance();
        ledger.paths += 1;
        ledger.emitted += whole;
        let faint = Faint { whole, often: 1.0 / rest.share };
        let mut landed = 0;
        to_scatterer(walker, faint, ledger, &mut |walker, vertex, scatter, frame, ledger| {
            if !glances.is_some_and(|glances| glances.has_read(rest, walker, vertex)) {
                let place = (film, pupil, within);
                let span =
                    glances.and_then(|glances| glances.span_of(place, (world, rest, &mut landed), (walker, vertex)));
                let ask = Ask { seen: 1.0 / whole, span, ..ask };
                gather(manifold, (walker, vertex, scatter, frame), (screens, ask), out, scratch);
            }
            ledger.not_owned += walker.beam.carried();
        });
        ledger.close_path(balance);
        if let Some(glances) = glances {
            let open = (OF_PAIR, rest, landed);
            glances.take_off((world, optics), (film, pupil, within), open, &mut rng, |walker, vertex, whole, span| {
                read(manifold, (walker, vertex), (screens, Ask { seen: 1.0 / whole, span, ..ask }), out, scratch);
            });
        }
    }
}

/// Adds what lamps bring to where a table says that a path lands. `ask.seen`: per unit of the path's weight.
fn read<M: Mode>(
    manifold: &Manifold<'_, M>,
    (walker, vertex): (&mut Walker<'_, M>, &Vertex),
    (screens, ask): (&Receivers<M>, Ask),
    out: &mut [Light],
    scratch: &mut Ledger,
) {
    let Surface::Scatter(scatter) = &walker.face(vertex).surface else { return };
    // The nodes over picture and pupil, and one face to be met.
    scratch.work += cost::STEP;
    let landed = (walker, vertex, &**scatter, Frame::about(vertex.normal));
    gather(manifold, landed, (screens, ask), out, scratch);
}

/// Adds what tables say of all of a pixel with an edge in it, over so many pairs of places of the pupil and of lamps: an edge that blurs
/// over them is all of a pixel's noise, and tables cost little beside rays.
fn look_over<M: Mode>(
    manifold: &Manifold<'_, M>,
    (optics, screens): (&Optics<M>, &Receivers<M>),
    (pixel, pairs): (Pixel, u64),
    out: &mut [Light],
    scratch: &mut Ledger,
) {
    let (world, Some(glances)) = (manifold.world, manifold.glances.as_deref()) else { return };
    let mut rng = pixel.rng(manifold.seed, Stream::ConnectionMeans);
    let weight = OF_PAIR / pairs as f64;
    for k in 0..pairs {
        let index = pixel.pass.wrapping_mul(pairs).wrapping_add(k);
        for Place { film, pupil, within, uv, turn } in pair(manifold, pixel, (Stream::ConnectionMeans, index), &mut rng)
        {
            let place = (film, pupil, within);
            glances.read_over(
                (world, optics),
                place,
                (weight, Glanced::Lit),
                &mut rng,
                |walker, vertex, whole, span| {
                    let ask = Ask { uv, seen: 1.0 / whole, turn, span };
                    read(manifold, (walker, vertex), (screens, ask), out, scratch);
                },
            );
        }
    }
}

/// Adds what lamps bring to where a path has met a scatterer. `ask.seen`: per unit of the path's weight.
fn gather<M: Mode>(
    manifold: &Manifold<'_, M>,
    (walker, vertex, scatter, frame): (&mut Walker<'_, M>, &Vertex, &Scatter, Frame),
    (screens, ask): (&Receivers<M>, Ask),
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
    let ask = Ask { seen: ask.seen * walker.beam.weight(), ..ask };
    screens.gather(tracing, at, &interior, ask, &mut rng, scratch, |incoming: Incoming<'_, M>| {
        let Some(lamp) = manifold.world.lamps.get(incoming.lamp) else { return };
        let Some(share) = manifold.route.from_eye(lamp.group, trail) else { return };
        let d_out = frame.to_local(incoming.dir);
        let (values, alone) = sides.eval(scatter, d_in, d_out);
        let kept = vertex.is_left_by(incoming.dir, d_out.z < 0.0);
        if values.as_slice().iter().all(|value| *value == 0.0) || !kept {
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
        let mut beam = walker.beam;
        // Of a connection the power alone is known: receivers that would tell more of its light are not connected.
        if let Some(facets) = sides.facets(scatter, (d_in, d_out), &values) {
            beam.scatter(Some(&facets), [walker.ray.dir, incoming.dir], true);
        }
        beam.join(walker.optics, plane_of::<M>(out, plane), light, &factors);
    });
}
