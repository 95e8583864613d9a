//! The estimator that owns vision paths with known trains: per pixel and pass, one point of each lamp whose light may come
//! over a train (at [`EdgeSampling`] several) is joined with a point of the pixel, by solving for the point of the pupil between them.
//!
//! With J the derivative of the place on the lamp by the place in the pupil, the pixel's mean over the pupil is
//! ∫ L T dA_pupil/A = ∫ L T |det J|⁻¹ dA_lamp/A: what is left to chance is the point of the lamp and of the pixel, over
//! which the integrand is smooth but for the slide's picture.
//! Most of it is read from [`FilmTables`], whose errors a few solutions make good.

use super::eye_subpath;
use super::eye_table::EyeTable;
use super::film_table::{Branch, FilmTables};
use super::receiver::Receivers;
use super::seeds::MOST_SHEETS;
use super::seeds::bands::Bands;
use super::seeds::connections::{Connections, Entry};
use super::seeds::edge_sampling::EdgeSampling;
use super::solver::newton::{Root, Target};
use super::tuning::at_edges::{OF_A_CUT, PLACES};
use super::tuning::vision::INSIDE;
use crate::ledger::{Ledger, cost};
use crate::ownership::Ownership;
use crate::pixel::Pixel;
use crate::walk::{Travel, Walker};
use arrayvec::ArrayVec;
use eyebox_base::lpe::Source;
use eyebox_base::parallel;
use eyebox_base::rng::Stream;
use eyebox_film::accumulate::{Film, Light, Row};
use eyebox_world::World;
use eyebox_world::geometry::Ray;
use eyebox_world::interior::Interior;
use eyebox_world::mode::{Mode, OPTICS_AT_A_TIME, Turns, lanes, plane_of, turns, turns_of};
use eyebox_world::optics::Optics;
use eyebox_world::wavelengths::SharedLight;
use glam::DVec2;
use std::marker::PhantomData;
use std::sync::Arc;

/// The estimator, ready to run passes.
pub struct Manifold<'w, M: Mode> {
    mode: PhantomData<M>,
    pub(super) world: &'w World,
    pub(super) route: Ownership,
    connections: Arc<Bands>,
    tables: Option<FilmTables<M>>,
    rims: EdgeSampling,
    pub(super) glances: Option<Arc<EyeTable<M>>>,
    screens: Arc<Receivers<M>>,
    /// By pixel, see [`eye_subpath::pairs_at_edges`].
    pairs_at_edges: Vec<u8>,
    /// Wavelengths that lead in turn in a pass.
    turns: u64,
    /// What the wavelengths of passes make of light.
    shared: Option<SharedLight<'w>>,
    pub(super) seed: u64,
}

/// What a pixel fills anew for every lamp and train.
type Scratch<M> = (Vec<Root>, Vec<Branch<M>>);

impl<'w, M: Mode> Manifold<'w, M> {
    pub fn new(
        world: &'w World,
        route: Ownership,
        (connections, tables): (Arc<Bands>, Option<FilmTables<M>>),
        (screens, glances): (Arc<Receivers<M>>, Option<Arc<EyeTable<M>>>),
        seed: u64,
    ) -> Self {
        let rims = EdgeSampling::new(world, connections.middle());
        let pairs_at_edges = eye_subpath::pairs_at_edges(world, seed, &screens, glances.as_deref());
        Manifold {
            mode: PhantomData,
            world,
            route,
            connections,
            tables,
            rims,
            glances,
            screens,
            pairs_at_edges,
            turns: turns::<M>(world),
            shared: SharedLight::new::<M>(world),
            seed,
        }
    }

    /// The corners of a pixel, in tangents.
    fn corners(&self, pixel: Pixel) -> [DVec2; 4] {
        [[0, 0], [1, 0], [0, 1], [1, 1]]
            .map(|corner| self.world.eye.film_of(pixel.x, pixel.y, corner.map(|k| INSIDE[k])))
    }

    /// Whether light crosses slides on the way to screens that tables lead to.
    pub(super) fn cuts_slides(&self) -> bool {
        !self.pairs_at_edges.is_empty()
    }

    /// See [`eye_subpath::pairs_at_edges`].
    pub(super) fn pairs_at_edges(&self, pixel: u64) -> u64 {
        self.pairs_at_edges.get(pixel as usize).map_or(0, |pairs| u64::from(*pairs))
    }

    /// Adds passes `first .. first + count` to the film. The ledger counts connections as paths, and what they bring, in
    /// units of importance, as emitted and arrived: they lose nothing by chance.
    pub fn run(&self, film: &mut Film, first: u64, count: u64) -> Ledger {
        let mut total = Ledger::new(self.world.solids.len());
        let (mut pass, end) = (first, first + count);
        if let Some(shared) = &self.shared {
            film.know((first..end).map(|pass| (pass, shared.of_pass(self.turns, self.seed, pass))));
        }
        while pass < end {
            let next = self.screens.next_change(pass).min(pass.saturating_add(OPTICS_AT_A_TIME)).min(end);
            self.block(film, pass, next - pass, &mut total);
            pass = next;
        }
        film.close(first, count);
        total
    }

    /// Passes for which screens have the same maps, or a single one.
    fn block(&self, film: &mut Film, first: u64, count: u64, total: &mut Ledger) {
        let width = film.width;
        let parts = self.world.solids.len();
        let turns = |pass: u64| turns_of::<M>(self.world, self.turns, self.seed, pass);
        let passes: Vec<(u64, Turns<M>)> = (first..first + count).map(|pass| (pass, turns(pass))).collect();
        let screens = |(_, optics): &(u64, Optics<M>)| self.screens.of_pass(first, self.world, optics);
        let screens: Vec<Arc<Receivers<M>>> =
            passes.first().map_or(Vec::new(), |(_, turns)| turns.iter().map(screens).collect());
        let mut rows: Vec<_> = film.rows().collect();
        let of_row = |(y, row): &mut (usize, Row<'_>)| {
            let mut total = Ledger::new(parts);
            let mut scratch = Ledger::new(parts);
            let mut light = vec![Light::default(); self.route.planes.len() * M::COMPONENTS];
            let mut scratches = (Vec::new(), Vec::new());
            for (pass, turns) in &passes {
                let (mut ledger, before) = (Ledger::new(parts), scratch.work);
                for x in (0..width).filter(|x| self.world.eye.wants([*x, *y])) {
                    if !row.wants(x, *pass) {
                        continue;
                    }
                    light.fill(Light::default());
                    for ((number, optics), screens) in turns.iter().zip(&screens) {
                        let pixel = Pixel::new((x, *y), width, *number);
                        let times = self.rims.times(pixel.index);
                        for k in 0..times {
                            let once = Pixel { pass: number.wrapping_mul(times).wrapping_add(k), ..pixel };
                            let books = (&mut ledger, &mut scratch);
                            self.pixel(optics, (once, times as f64), &mut light, &mut scratches, books);
                        }
                        if !screens.is_empty() {
                            let books = (&mut ledger, &mut scratch);
                            eye_subpath::look(self, (optics, screens), pixel, &mut light, books);
                        }
                    }
                    if self.turns > 1 {
                        light.iter_mut().for_each(|light| *light = light.scaled(1.0 / self.turns as f64));
                    }
                    ledger.work += cost::KEPT;
                    row.add_pass(x, *pass, &light);
                }
                row.add_work(*pass, ledger.work + scratch.work - before);
                total.merge(&ledger);
            }
            total.vertex_error = scratch.vertex_error;
            total.work += scratch.work;
            total
        };
        let ledgers: Vec<Ledger> = parallel::map_mut(&mut rows, &of_row);
        ledgers.iter().for_each(|ledger| total.merge(ledger));
    }

    /// `pixel`: with the number of this time among all of its passes' times.
    fn pixel(
        &self,
        optics: &Optics<M>,
        (pixel, times): (Pixel, f64),
        out: &mut [Light],
        (roots, branches): &mut Scratch<M>,
        (ledger, scratch): (&mut Ledger, &mut Ledger),
    ) {
        let at: [f64; 4] = pixel.start(self.seed, Stream::Connection, pixel.pass);
        let film = self.world.eye.film_of(pixel.x, pixel.y, [at[0], at[1]]);
        let mut choices = pixel.rng(self.seed, Stream::ConnectionChoice);
        let spot = self.tables.as_ref().and_then(|tables| Some((tables, tables.spot(self.world, (pixel.x, pixel.y))?)));
        let within = DVec2::new(at[0], at[1]) - 0.5;
        let connections = self.connections.of(optics);
        // What is asked about a part of the pixel alone has no table over all of it.
        let spot = spot.map(|(tables, spot)| (tables, spot, connections.at_all(film, self.corners(pixel))));
        for (index, entry) in connections.at(film) {
            let Some(lamp) = self.world.lamps.get(entry.starts.lamp) else { continue };
            let share = spot.as_ref().map_or(1.0, |(tables, spot, _)| tables.share(index, spot));
            let (point, density) = entry.starts.aim(lamp, film, self.world.eye.pupil_radius_m(), [at[2], at[3]]);
            let weight = 1.0 / (density * times);
            let middle = entry.starts.middle();
            let off = middle.local(point.position - middle.point);
            // Where a table is of no use it need not be read.
            branches.clear();
            let useful = spot.as_ref().filter(|(.., all_of_pixel)| share < 1.0 && all_of_pixel.has(index));
            let size = entry.starts.size();
            let at_rim =
                useful.is_some_and(|(tables, spot, _)| tables.read(self.world, index, spot, (off, size), branches));
            // What the table says of all of the pixel. Where that is more than one piece of a picture the solver is always asked:
            // at an edge it differs most from the table.
            let mut share = if at_rim { 1.0 } else { share };
            let mut at_edge = false;
            let mut means: ArrayVec<M::Lanes<Light>, MOST_SHEETS> = ArrayVec::new();
            for Branch { number, over, over_lamp } in branches.iter() {
                let mut mean = lanes::<M, _>(|_| Light::default());
                match over_lamp {
                    None => {
                        let pieces = self.add_mean(optics, over, weight, &mut mean);
                        ledger.work += pieces * cost::CUT;
                        at_edge |= pieces > 1;
                        let others = useful.filter(|_| pieces > 1);
                        let others = others
                            .and_then(|(tables, spot, _)| tables.over_lamp(self.world, (index, *number), spot, size));
                        if let Some(over_lamp) = others {
                            let aimed = |uv: [f64; 2]| {
                                let (point, density) =
                                    entry.starts.aim(lamp, film, self.world.eye.pupil_radius_m(), uv);
                                (middle.local(point.position - middle.point), 1.0 / (density * times))
                            };
                            self.add_others((optics, &over_lamp), [at[2], at[3]], aimed, &mut mean, ledger);
                        }
                    }
                    Some(over_lamp) => {
                        at_edge = true;
                        let off = |uv: [f64; 2]| middle.local(lamp.sample_point(uv).position - middle.point);
                        let points = (self.points(over_lamp, off) / times as u64).max(1);
                        ledger.work += cost::CUT * points / OF_A_CUT;
                        for k in 0..points {
                            let index = pixel.pass.wrapping_mul(points).wrapping_add(k);
                            let off = off(pixel.start(self.seed, Stream::ConnectionLamp, index));
                            let weight = 1.0 / (times * points as f64);
                            if over_lamp.is_seen(off) {
                                ledger.work += cost::CUT * self.add_mean(optics, &over_lamp.at(off), weight, &mut mean);
                            }
                        }
                    }
                }
                // There are no more branches than that.
                let _ = means.try_push(mean);
            }
            share = if at_edge { 1.0 } else { share };
            let chance = connections.chance(entry) * share;
            let solved = chance >= 1.0 || choices.uniform() < chance;
            ledger.work += cost::READ;
            // Whether it is at an edge is a matter of the pixel and the lamp's point, and any place has a chance.
            let (film, within, weight) = if solved && at_edge {
                ledger.work += cost::CUT * (PLACES as u64 / OF_A_CUT);
                let (within, stands_for) = self.near_edges(branches, within, choices.uniform());
                (self.world.eye.film_of(pixel.x, pixel.y, (within + 0.5).to_array()), within, weight * stands_for)
            } else {
                (film, within, weight)
            };
            // Less what it says of this place where the solver is asked about it.
            let less = if solved { weight / chance } else { 0.0 };
            for (Branch { over, .. }, mut light) in branches.iter().zip(means) {
                let Some(share) = self.route.from_eye(lamp.group, over.trail) else { continue };
                let plane = self.route.plane_from_eye(share, over.told, lamp.group, Source::Face);
                let inside = less != 0.0 && over.pupil.length() <= self.world.eye.pupil_radius_m();
                if let Some(place) = inside.then(|| over.at((self.world, optics), within)).flatten() {
                    (0..M::LANES).for_each(|lane| light[lane].add(place[lane].scaled(-less)));
                }
                M::deposit(optics, plane_of::<M>(out, plane), light, over.alone);
            }
            if !solved {
                continue;
            }
            let target = Target::new(point.position, point.normal);
            roots.clear();
            let solved = connections.roots((self.world, optics), entry, film, &target, roots);
            ledger.work += cost::SOLVED * solved * connections.trains[entry.train].0.len() as u64;
            for root in roots.iter().filter(|root| root.u.length() <= self.world.eye.pupil_radius_m()) {
                ledger.paths += 1;
                let area_m2 = lamp.area_m2 * weight / chance;
                let brought = self.connect((optics, (connections, entry)), film, root, area_m2, pixel, out, scratch);
                ledger.emitted += brought;
                ledger.arrived += brought;
            }
        }
    }

    /// Follows the solution as any path is followed, and adds what it sees. Returns its share of a unit of importance.
    #[allow(clippy::too_many_arguments)]
    fn connect(
        &self,
        (optics, (connections, entry)): (&Optics<M>, (&Connections, &Entry)),
        film: DVec2,
        root: &Root,
        area_m2: f64,
        pixel: Pixel,
        out: &mut [Light],
        ledger: &mut Ledger,
    ) -> f64 {
        let (origin, (_, dir), ..) = self.world.eye.ray_of(film, root.u);
        let ray = Ray { origin, dir, from: None };
        // Roulette comes only to the longest trains.
        let rng = pixel.rng(self.seed, Stream::Connection);
        let mut walker = Walker::new((self.world, optics), Travel::FromEye, ray, 1.0, Interior::default(), rng);
        let train = &connections.trains[entry.train];
        let links = train.0.iter().map(|lens| lens.link);
        let Some(seen) = walker.follow_to(links, entry.starts.lamp, ledger, |_, _, _| {}) else { return 0.0 };
        let Some(share) = self.route.from_eye(seen.lamp.group, walker.trail) else { return 0.0 };
        let plane = self.route.plane_from_eye(share, walker.told, seen.lamp.group, Source::Face);
        let factor = area_m2 / (root.slope.determinant().abs() * self.world.eye.pupil_area_m2());
        if !factor.is_finite() {
            return 0.0;
        }
        walker.see(plane_of::<M>(out, plane), &seen, factor);
        walker.beam.carried() * factor
    }
}
