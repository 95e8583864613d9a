//! Gathering: at the first broad scatterer that the eye sees through specular faces, what photons bring to it; and at the
//! second, where the first asks for [final gathering](super::final_gather).

use super::gather_samples::{GatherSamples, MOST_RAYS};
use super::tuning::gather::STRIDE;
use super::{PhotonMapper, final_gather};
use crate::ledger::{Ledger, cost};
use crate::manifold::eye_table::{Counted, Glanced, Rest};
use crate::manifold::pixel_span::Span;
use crate::manifold::receiver::{Claim, Receivers};
use crate::photon_map::{Photon, PhotonMap, adaptive_kernel};
use crate::pixel::Pixel;
use crate::rqmc::Rqmc;
use crate::specular_event::Faint;
use crate::walk::{Meeting, Met, SPLIT_FIRST_EVENTS, Travel, Vertex, Walker};
use eyebox_base::lpe::Letter;
use eyebox_base::parallel;
use eyebox_base::path::{Event, Trail};
use eyebox_base::rng::Stream;
use eyebox_base::warp::{Frame, disk};
use eyebox_film::accumulate::{Components, Film, Light, Row};
use eyebox_film::plan::Radii;
use eyebox_world::World;
use eyebox_world::geometry::{Hit, Ray};
use eyebox_world::interior::Interior;
use eyebox_world::mode::{LaneArray, Mode, lanes, plane_of};
use eyebox_world::optics::Optics;
use eyebox_world::scatter::Scatter;
use eyebox_world::surface::Surface;
use glam::DVec3;
use std::sync::Arc;

const _: () = assert!(STRIDE >= MOST_RAYS);

/// The photons of a pass, and what of them is connected.
pub(super) struct Maps<M: Mode> {
    screens: Arc<Receivers<M>>,
    caustic: PhotonMap<M>,
    secondary: PhotonMap<M>,
    /// All of them, for what the eye sees by another scatterer, which is soft; none where nothing asks for it.
    second: Option<PhotonMap<M>>,
}

impl<M: Mode> Maps<M> {
    /// `enough`, `shift`: of photons straight from specular faces, see [`PhotonMap::crowded`].
    pub(super) fn new(
        (photons, screens): (Vec<Photon<M>>, Arc<Receivers<M>>),
        radii: Radii,
        (enough, shift): (f64, DVec3),
        final_gather: bool,
    ) -> Self {
        let soft = |photons| PhotonMap::new(photons, radii.secondary);
        let second = final_gather.then(|| soft(photons.clone()));
        let (secondary, caustic) = photons.into_iter().partition(|photon| photon.trail.has_scatter());
        let caustic = PhotonMap::crowded(caustic, radii.caustic, enough, shift);
        Maps { screens, caustic, secondary: soft(secondary), second }
    }

    /// Calls `visit` with each photon near a vertex that a path from the eye came to by `eye`, and the density there of the
    /// kernel and of the one of a quarter of its area, 1/m².
    fn each(&self, world: &World, eye: Trail, vertex: &Vertex, mut visit: impl FnMut(&Photon<M>, [f64; 2])) {
        let Hit { point, site, normal, .. } = vertex.hit;
        let maps = match &self.second {
            Some(second) if eye.has_broad() => [Some(second), None],
            Some(_) | None => [Some(&self.caustic), Some(&self.secondary)],
        };
        for map in maps.into_iter().flatten() {
            // What of the kernel lies beside the face, or behind what stands on it, is made up for by the rest.
            let around = world.rims.around(site, point, normal, map.radius());
            // By steps of the radius. Where the largest kernel is whole smaller ones are, too.
            let mut shares = (around.share < 1.0).then(|| {
                let mut shares = [None; adaptive_kernel::MOST + adaptive_kernel::STEPS + 1];
                shares[0] = Some(around.share);
                shares
            });
            let mut share = |steps: usize| {
                let of = || world.rims.around(site, point, normal, adaptive_kernel::radius(map.radius(), steps)).share;
                shares.as_mut().map_or(1.0, |shares| *shares[steps].get_or_insert_with(of))
            };
            map.gather(point, site, |photon, steps, [density, part]| {
                if around.counts(photon.position) {
                    let part = if part > 0.0 { part / share(steps + adaptive_kernel::STEPS) } else { 0.0 };
                    visit(photon, [density / share(steps), part]);
                }
            });
        }
    }
}

/// What a pixel gathers in a pass.
struct Gathered {
    /// The entries of each plane in turn.
    light: Vec<Light>,
    components: Components,
    /// Luminance beyond what kernels of a quarter of the area bring.
    beyond: f64,
}

impl Gathered {
    fn clear(&mut self) {
        self.light.fill(Light::default());
        self.beyond = 0.0;
    }

    fn scale(&mut self, factor: f64) {
        self.light.iter_mut().for_each(|light| *light = light.scaled(factor));
        self.beyond *= factor;
    }
}

/// Where a photon came from, local to the point that gathers it, on the side of the face at which it arrived. On a
/// curved face the two normals differ: what grazes the face at the photon may be below the horizon here, and without it
/// a concave wall of radius R loses the share r²/12R² of its light.
pub fn on_side(dir: DVec3, through: bool) -> DVec3 {
    DVec3::new(dir.x, dir.y, if through { -dir.z.abs() } else { dir.z.abs() })
}

impl<M: Mode> PhotonMapper<'_, M> {
    /// Returns the counted work.
    pub(super) fn gather(&self, film: &mut Film, (pass, optics): (u64, &Optics<M>), maps: &Maps<M>) -> u64 {
        let (width, components) = (film.width, film.components);
        let size = [width, film.height];
        let middles =
            maps.caustic.is_crowded().then(|| self.middles.get_or_init(|| GatherSamples::new(self.world, size)));
        let mut rows: Vec<_> = film.rows().collect();
        let of_row = |(y, row): &mut (usize, Row<'_>)| {
            let light = vec![Light::default(); self.route.planes.len() * M::COMPONENTS];
            let mut gathered = Gathered { light, beyond: 0.0, components };
            let mut ledger = Ledger::new(self.world.solids.len());
            for x in (0..width).filter(|x| self.world.eye.wants([*x, *y])) {
                gathered.clear();
                let mut shoot = |stream: Stream, number: u64| {
                    let pixel = Pixel::new((x, *y), width, number);
                    self.pixel((pixel, stream), optics, maps, &mut gathered, &mut ledger);
                };
                match middles.map_or(1, |middles| middles.rays(*y * width + x, &maps.caustic)) {
                    1 => shoot(Stream::PhotonGather, pass),
                    rays => {
                        (0..rays).for_each(|k| shoot(Stream::PhotonCrowd, pass.wrapping_mul(STRIDE).wrapping_add(k)));
                        gathered.scale(1.0 / rays as f64);
                    }
                }
                ledger.work += cost::KEPT;
                row.add_pass(x, pass, &gathered.light);
                row.add_blur(x, gathered.beyond);
            }
            ledger.work
        };
        parallel::map_mut(&mut rows, &of_row).into_iter().sum()
    }

    /// Gathers what a ray through a pixel sees; its number in the pixel's lattice is the `pass`. What tables know of where it
    /// lands is read there, as specular connection does, and now and then the ray itself makes good what they have wrong.
    fn pixel(
        &self,
        (pixel, stream): (Pixel, Stream),
        optics: &Optics<M>,
        maps: &Maps<M>,
        out: &mut Gathered,
        ledger: &mut Ledger,
    ) {
        let world = self.world;
        let mut rng = pixel.rng(self.seed, stream);
        let [x, y, u, v] = pixel.start(self.seed, stream, pixel.pass);
        let film = world.eye.film_of(pixel.x, pixel.y, [x, y]);
        let pupil = disk([u, v]) * world.eye.pupil_radius_m();
        let read = |walker: &mut Walker<'_, M>, vertex: &Vertex, _: f64, _: Option<Span>| {
            let Surface::Scatter(scatter) = &walker.face(vertex).surface else { return };
            ledger.work += cost::STEP;
            self.gather_at(walker, (vertex, scatter, &Frame::about(vertex.normal)), maps, out, ledger);
        };
        let rest = self.glances.as_ref().map_or(Some(Rest::ALL), |glances| {
            let of = if self.part { Glanced::Little } else { Glanced::All };
            glances.read((world, optics), (film, pupil, None), (1.0, of, 0.0), Counted::Both, &mut rng, read)
        });
        let Some(rest) = rest else { return };
        let (origin, (_, dir), ..) = world.eye.ray_of(film, pupil);
        let ray = Ray { origin, dir, from: None };
        let walker = Walker::new((world, optics), Travel::FromEye, ray, 1.0 / rest.share, Interior::default(), rng);
        let walker = if rest.asks() { walker.recording() } else { walker };
        let even = (pixel, &Rqmc::new(self.seed, stream, pixel, pixel.pass));
        self.eye_path((walker, even, 0), rest, maps, out, ledger);
    }

    /// Gathers along a ray and its branches. `rest`: what of it tables have not read.
    /// `even`: by what it scatters. `scattered`: how many scatterers it has met.
    fn eye_path(
        &self,
        (mut walker, even, mut scattered): (Walker<'_, M>, (Pixel, &Rqmc), u32),
        rest: Rest,
        maps: &Maps<M>,
        out: &mut Gathered,
        ledger: &mut Ledger,
    ) {
        let faint = Faint { whole: 1.0 / rest.share, often: 1.0 / rest.share };
        loop {
            let Met::Face(vertex) = walker.advance(ledger) else { return };
            let other = if walker.events < SPLIT_FIRST_EVENTS {
                walker.split(&vertex, 0.0, Walker::<M>::MOST_SPLITS, ledger)
            } else {
                walker.spare(&vertex, faint, ledger)
            };
            if let Some(reflected) = other {
                self.eye_path((reflected, even, scattered), rest, maps, out, ledger);
            }
            match walker.meet(&vertex, ledger) {
                Meeting::Ended => return,
                Meeting::Went => {}
                Meeting::Scatter(scatter, frame) if scatter.is_narrow() => {
                    let u = even.1.take(scattered, &mut walker.rng);
                    scattered += 1;
                    if walker.scatter_by(u, &vertex, (scatter, &frame), ledger).is_none() {
                        return;
                    }
                }
                Meeting::Scatter(scatter, frame) => {
                    if !self.glances.as_ref().is_some_and(|glances| glances.has_read(rest, &walker, &vertex)) {
                        let at = (&vertex, scatter, &frame);
                        self.gather_at(&walker, at, maps, out, ledger);
                        if final_gather::goes_on(walker.trail, scatter.asks_for_final_gather()) {
                            self.go_on((walker, even.0), at, rest, maps, out, ledger);
                        }
                    }
                    return;
                }
            }
            if !self.reach_eye.allows(walker.trail) {
                return;
            }
        }
    }

    /// Goes on with copies of a path that has met a scatterer.
    fn go_on(
        &self,
        (mut walker, pixel): (Walker<'_, M>, Pixel),
        (vertex, scatter, frame): (&Vertex, &Scatter, &Frame),
        rest: Rest,
        maps: &Maps<M>,
        out: &mut Gathered,
        ledger: &mut Ledger,
    ) {
        let copies = final_gather::copies(walker.share());
        walker.beam.scale(1.0 / f64::from(copies));
        let copies = u64::from(copies);
        for number in 0..copies {
            let mut copy = walker.clone();
            copy.rng = walker.rng.fork();
            let even =
                Rqmc::new(self.seed, Stream::FinalGather, pixel, pixel.pass.wrapping_mul(copies).wrapping_add(number));
            let u = even.take(0, &mut copy.rng);
            if copy.scatter_by(u, vertex, (scatter, frame), ledger).is_some() && self.reach_eye.allows(copy.trail) {
                self.eye_path((copy, (pixel, &even), 1), rest, maps, out, ledger);
            }
        }
    }

    /// Adds what photons bring to where a path has met a scatterer.
    fn gather_at(
        &self,
        walker: &Walker<'_, M>,
        (vertex, scatter, frame): (&Vertex, &Scatter, &Frame),
        maps: &Maps<M>,
        out: &mut Gathered,
        ledger: &mut Ledger,
    ) {
        let d_in = frame.to_local(walker.ray.dir);
        let sides = walker.sides(vertex, scatter);
        let goes_on = final_gather::goes_on(walker.trail, scatter.asks_for_final_gather());
        // Of what lies here, and behind the face.
        let mut indices: [Option<M::Lanes<f64>>; 2] = [None; 2];
        let mut asked = maps.screens.asked_at(
            (self.world, walker.optics),
            (vertex.hit.point, vertex.hit.site),
            maps.caustic.radius(),
        );
        let visit = |photon: &Photon<M>, [density, part]: [f64; 2]| {
            ledger.work += cost::GATHERED;
            // Of what connection has, the path over one scatterer is not ours; over more it is.
            let over_more = walker.trail.has_scatter();
            if !over_more && photon.claim == Claim::Connected || !final_gather::gathers(goes_on, photon.trail) {
                return;
            }
            let trail = Trail::join(walker.trail, Event::Diffuse, photon.trail);
            let Some(share) = self.route.from_eye(photon.group, trail) else { return };
            let through = photon.outside != vertex.outside;
            let d_out = on_side(frame.to_local(-photon.dir), through);
            let index = indices[usize::from(through)].get_or_insert_with(|| walker.beyond(vertex, through, 0.0).0);
            let (values, alone) = sides.eval(scatter, d_in, d_out);
            if values.as_slice().iter().all(|value| *value == 0.0) || !over_more && asked.leaves_out(photon.claim) {
                return;
            }
            let plane = self.route.plane(share, |sieve| {
                sieve.takes(sieve.after(walker.told, Letter::of(Event::Diffuse, through)), photon.told)
            });
            let factors = lanes::<M, _>(|lane| values[lane] * density / (index[lane] * index[lane]));
            let light = plane_of::<M>(&mut out.light, plane);
            let before = out.components.luminance_value(light);
            let facets = sides.facets(scatter, (d_in, d_out), &values);
            let beam = walker.beam.gathering(facets.as_ref(), walker.ray.dir, photon);
            beam.join(walker.optics, light, (&photon.flux, photon.alone || alone), &factors);
            let own = out.components.luminance_value(light) - before;
            if density > 0.0 {
                out.beyond += own * (1.0 - part / density);
            }
        };
        maps.each(self.world, walker.trail, vertex, visit);
        ledger.work += asked.work;
    }
}
