//! Where rays from the eye land on faces that are joined with lamps, as tables over the picture and the pupil.
//!
//! Over a known train of specular faces the place where a ray lands, its direction there and what the train lets through
//! are smooth in its place in the picture and in the pupil: between nodes they are interpolated. No table is trusted, as in
//! [`FilmTables`](super::film_table::FilmTables). Now and then the ray itself is followed with all its branches, and makes
//! good what the tables had wrong or did not have.

mod eye_hit;
pub mod first_scatterer;
mod make;
mod tuning;

use crate::ledger::Ledger;
use crate::manifold::film_grid::FilmGrid;
use crate::manifold::pixel_span::Span;
use crate::manifold::receiver::Receivers;
use crate::manifold::solver::bicubic::{Rows, Spot};
use crate::walk::{Travel, Vertex, Walker};
use eye_hit::{EyeHit, EyeHits, OVER_PUPIL};
use eyebox_base::chain::Chain;
use eyebox_base::lpe::LpeState;
use eyebox_base::path::Trail;
use eyebox_base::rng::{Rng, Stream};
use eyebox_world::World;
use eyebox_world::geometry::interface_derivatives::site_of;
use eyebox_world::geometry::{Hit, Ray};
use eyebox_world::interior::Interior;
use eyebox_world::mode::{Mode, lanes, wavelengths_change};
use eyebox_world::optics::Optics;
use glam::{DVec2, DVec3};
use std::sync::OnceLock;
use tuning::eye_table::{FAINT, OF_DIFFERENCES, OFTEN, OUTER, SELDOM, SELDOM_OF_LITTLE};

/// A train from the eye to a lit face.
struct Glance<M: Mode> {
    chain: Chain,
    /// Of what the best train brings.
    share: f64,
    /// A ray that landed over it: what it met, and what is the same for all.
    vertex: Vertex,
    trail: Trail,
    told: LpeState,
    interior: Interior,
    events: u32,
    /// Over the picture, where any ray lands over this train.
    lands: Vec<bool>,
    landings: EyeHits<M>,
}

/// How a cell is used.
#[derive(Debug, Clone, Copy)]
struct Use {
    /// How often the ray itself is followed.
    share: f64,
    /// By how much the tables were off on trial, in units of what has it always followed.
    off: f64,
    /// The glances that have all nodes, as bits.
    known: u32,
    /// Faint ones that have some.
    in_part: u32,
    /// No ray was found that lands on other faces that scatter.
    whole: bool,
    /// Which of [`SIDES`](crate::manifold::solver::bicubic::SIDES) is asked.
    aside: [i8; 2],
}

/// All trains from the eye to faces that are joined with lamps.
pub struct EyeTable<M: Mode> {
    over: FilmGrid,
    /// m
    radius: f64,
    glances: Vec<Glance<M>>,
    /// Per cell.
    uses: Vec<Use>,
}

/// Where to look.
struct Look {
    rows: Rows,
    /// Along a pixel to the right and down, and where in its pixel the ray is; none where nobody asks.
    along: Option<([Rows; 2], DVec2)>,
    /// Weights of the nodes over the pupil.
    pupil: [f64; OVER_PUPIL],
}

/// Which light tables are read for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Glanced {
    /// That of faces that are joined with lamps.
    Lit,
    /// That of any face that scatters.
    All,
    /// The same where it is little.
    Little,
}

impl Glanced {
    /// Trains with less than this of what the best brings are looked at by themselves, as seldom as they bring little.
    fn by_itself(self) -> f64 {
        match self {
            Glanced::Lit | Glanced::All => FAINT,
            Glanced::Little => 1.0,
        }
    }

    /// How often a train with such a share is looked at by itself.
    fn chance(self, share: f64) -> f64 {
        (share / self.by_itself()).clamp(self.least(), 1.0)
    }

    /// How often a ray itself is followed where another would always be.
    fn followed(self) -> f64 {
        match self {
            Glanced::Lit | Glanced::All => 1.0,
            Glanced::Little => SELDOM_OF_LITTLE,
        }
    }

    /// How often at least.
    fn least(self) -> f64 {
        match self {
            Glanced::Lit => OFTEN,
            Glanced::All | Glanced::Little => SELDOM,
        }
    }
}

/// What is counted where tables are read and a ray itself may be followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Counted {
    /// What tables say of the ray's place (of faint trains over all of its pixel), the ray, and less what they say of its place.
    Both,
    /// The ray less what tables say, both over all of the pixel where the ray lands over a train that they know:
    /// [`EyeTable::read_over`] reads them at many places.
    Differences,
}

/// What tables leave to rays that are followed.
#[derive(Debug, Clone, Copy)]
pub struct Rest {
    /// How often a ray is: it stands for 1/share.
    pub share: f64,
    /// Glances that it leaves out, as bits.
    read: u32,
    /// Glances of which it is told what tables say when it is known whether it has landed over them, as bits.
    open: u32,
}

impl Rest {
    /// There are no tables.
    pub const ALL: Rest = Rest { share: 1.0, read: 0, open: 0 };

    /// Whether it matters over which glance a followed ray lands, for which it has to record its faces.
    pub fn asks(self) -> bool {
        self.read != 0 || self.open != 0
    }
}

impl<M: Mode> EyeTable<M> {
    /// None without lit faces and trains to them, or where every pass has wavelengths of its own.
    pub fn new(world: &World, optics: &Optics<M>, screens: &Receivers<M>, over: FilmGrid) -> Option<EyeTable<M>> {
        if wavelengths_change::<M>() || screens.is_empty() {
            return None;
        }
        let radius = world.eye.pupil_radius_m();
        let glances = EyeTable { over, radius, glances: Vec::new(), uses: Vec::new() }.make((world, optics), screens);
        (!glances.glances.is_empty()).then_some(glances)
    }

    /// Calls `visit` with rays that have landed and what each stood for at its start. That is all light if a followed ray
    /// adds what the returned rest asks for; none: nothing is to be followed. `film`, `pupil`: places in tangents and m.
    /// `whole`: what the ray stands for; `least`: how often it is followed at least. `within`: its place in its pixel, if it matters how
    /// the landing moves with it: for trains that are looked at by themselves.
    #[allow(clippy::too_many_arguments)] // how a place is asked about
    pub fn read<'w>(
        &self,
        tracing: (&'w World, &'w Optics<M>),
        (film, pupil, within): (DVec2, DVec2, Option<DVec2>),
        (whole, of, least): (f64, Glanced, f64),
        counted: Counted,
        rng: &mut Rng,
        mut visit: impl FnMut(&mut Walker<'w, M>, &Vertex, f64, Option<Span>),
    ) -> Option<Rest> {
        let Some((spot, usage)) = self.usage(film, of, counted) else { return Some(Rest::ALL) };
        let cells = self.over.by_pixel(tracing.0);
        let look = self.look_at(spot, pupil, within.map(|within| (cells, within)));
        let usual = (usage.share * of.followed()).max(least);
        let followed = rng.uniform() < usual;
        let (mut read, mut open) = (0, 0);
        for (k, glance) in self.glances.iter().enumerate() {
            let by_itself = glance.share < of.by_itself();
            let known = usage.known & 1 << k != 0;
            if !known && usage.in_part & 1 << k == 0 {
                continue;
            }
            if counted == Counted::Differences && !by_itself {
                open |= u32::from(known) << k;
                continue;
            }
            // What the table says, less what stands for it where the ray itself is followed.
            let (weight, followed) = if by_itself {
                read |= 1 << k;
                // What no table tells is followed as often as tables are read.
                let chance = of.chance(glance.share);
                if rng.uniform() >= chance {
                    continue;
                }
                (whole / chance, !known || rng.uniform() < SELDOM)
            } else {
                (whole, followed)
            };
            let share = match (known, by_itself) {
                (false, _) => 1.0,
                (true, true) => SELDOM,
                (true, false) => usual,
            };
            let over_pixel = match counted {
                Counted::Both => 1.0,
                Counted::Differences => 0.0,
            };
            let control = if followed { over_pixel - 1.0 / share } else { over_pixel };
            let table = Some(glance).filter(|_| known && control != 0.0);
            let landed = table
                .and_then(|glance| glance.landings.blend(&look.rows, &look.pupil))
                .and_then(|at| glance.land(tracing, &at, weight * control, rng.fork()));
            if let Some((mut walker, vertex)) = landed {
                // Pixels in which others have an edge are asked about otherwise.
                let wanted = table.filter(|_| over_pixel != 0.0 && by_itself);
                let span = wanted.and_then(|glance| glance.span(&look, over_pixel / control));
                visit(&mut walker, &vertex, weight * control, span);
            }
            if followed && by_itself {
                let start = (film, pupil, weight / share, rng.fork());
                if let Some((mut walker, vertex)) = glance.follow(tracing, start) {
                    visit(&mut walker, &vertex, weight / share, None);
                }
            }
        }
        followed.then_some(Rest { share: usual, read, open })
    }

    /// What tables say over all of a pixel, by one place of it and of the pupil: of all light that [`EyeTable::read`] leaves out where
    /// it counts differences. Arguments as there.
    pub fn read_over<'w>(
        &self,
        tracing: (&'w World, &'w Optics<M>),
        (film, pupil, within): (DVec2, DVec2, DVec2),
        (whole, of): (f64, Glanced),
        rng: &mut Rng,
        mut visit: impl FnMut(&mut Walker<'w, M>, &Vertex, f64, Option<Span>),
    ) {
        let Some((spot, usage)) = self.usage(film, of, Counted::Differences) else { return };
        let look = self.look_at(spot, pupil, Some((self.over.by_pixel(tracing.0), within)));
        for (_, glance) in self.glances.iter().enumerate().filter(|(k, _)| usage.known & 1 << k != 0) {
            let by_itself = glance.share < of.by_itself();
            let chance = if by_itself { of.chance(glance.share) } else { 1.0 };
            if rng.uniform() >= chance {
                continue;
            }
            let at = glance.landings.blend(&look.rows, &look.pupil);
            let landed = at.and_then(|at| glance.land(tracing, &at, whole / chance, rng.fork()));
            if let Some((mut walker, vertex)) = landed {
                visit(&mut walker, &vertex, whole / chance, glance.span(&look, 1.0));
            }
        }
    }

    /// Where in the picture that is, and how tables are used there; none where they are not.
    fn usage(&self, film: DVec2, of: Glanced, counted: Counted) -> Option<(Spot, Use)> {
        let spot = self.over.spot(film)?;
        let usage = self.uses.get(spot.cell)?;
        let is_used = match counted {
            Counted::Both => usage.share < 1.0,
            // Of use if rays are always followed, too.
            Counted::Differences => usage.off < OF_DIFFERENCES,
        };
        if !is_used || !(usage.whole || of == Glanced::Lit) {
            return None;
        }
        // The nodes about the spot, or, where those are not all there, others beside it.
        Some((self.over.nodes.aside(spot, usage.aside)?, *usage))
    }

    /// The most that `of` says of what the middle of the pupil sees through the middle of a square of so many pixels' `side`, of how that
    /// moves over the square and, m, to the pupil's rim. None where they do not land, or tables do not tell the same trains in all of it, by its corners: what one part of
    /// a pixel has of all of it would be counted beside what rays find in the other.
    pub fn most<'w>(
        &self,
        tracing: (&'w World, &'w Optics<M>),
        (film, corners, side): (DVec2, [DVec2; 4], f64),
        of: impl Fn(&Vertex, Span, [DVec3; 2]) -> u64,
    ) -> Option<u64> {
        let (spot, usage) = self.usage(film, Glanced::Lit, Counted::Differences)?;
        let known = |film: DVec2| self.usage(film, Glanced::Lit, Counted::Differences).map(|(_, usage)| usage.known);
        if corners.iter().any(|corner| known(*corner) != Some(usage.known)) {
            return None;
        }
        let pixel = Some((self.over.by_pixel(tracing.0), DVec2::ZERO));
        let rim = [DVec2::X, DVec2::Y].map(|axis| self.look_at(spot, self.radius * axis, None));
        let look = self.look_at(spot, DVec2::ZERO, pixel);
        let known = |(k, glance): &(usize, &Glance<M>)| usage.known & 1 << k != 0 && !glance.is_faint();
        let of_glance = |(_, glance): (usize, &Glance<M>)| {
            let at = glance.landings.blend(&look.rows, &look.pupil)?;
            let span = glance.span(&look, 1.0)?;
            let span = Span { by: span.by.map(|by| side * by), ..span };
            let [u, v] = rim.each_ref().map(|look| glance.landings.blend(&look.rows, &look.pupil));
            let by_pupil = [u?.point - at.point, v?.point - at.point];
            let (_, vertex) = glance.land(tracing, &at, 1.0, Rng::new(0, Stream::Pilot, 7, 0))?;
            Some(of(&vertex, span, by_pupil))
        };
        self.glances.iter().enumerate().filter(known).map(of_glance).try_fold(0, |most, own| Some(own?.max(most)))
    }

    /// Whether a followed ray has landed where a glance has been read by itself.
    pub fn has_read(&self, rest: Rest, walker: &Walker<'_, M>, vertex: &Vertex) -> bool {
        self.landed_over(rest.read, walker, vertex).is_some()
    }

    /// Over which of some glances a followed ray has landed.
    fn landed_over(&self, of: u32, walker: &Walker<'_, M>, vertex: &Vertex) -> Option<usize> {
        let face = (vertex.hit.site.part, vertex.hit.site.face);
        let is_over = |k: &usize| {
            let glance = &self.glances[*k];
            of & 1 << k != 0 && glance.face() == face && walker.chain() == Some(&glance.chain)
        };
        if of == 0 || walker.trail.has_scatter() { None } else { (0..self.glances.len()).find(is_over) }
    }

    /// How what a followed ray has landed on moves over its pixel, where what tables say of that is still open: the ray stands for all
    /// of the pixel then, as the table it is held against does. `landed`: glances over which it has, as bits.
    /// Place as for [`EyeTable::read_over`].
    pub fn span_of(
        &self,
        (film, pupil, within): (DVec2, DVec2, DVec2),
        (world, rest, landed): (&World, Rest, &mut u32),
        (walker, vertex): (&Walker<'_, M>, &Vertex),
    ) -> Option<Span> {
        let k = self.landed_over(rest.open, walker, vertex)?;
        let (spot, _) = self.usage(film, Glanced::Lit, Counted::Differences)?;
        let look = self.look_at(spot, pupil, Some((self.over.by_pixel(world), within)));
        let span = self.glances[k].span(&look, 1.0)?;
        *landed |= 1 << k;
        Some(span)
    }

    /// Calls `visit` with what tables say that was left open, to be taken off: over all of the pixel where the ray has landed, too, so that
    /// of both an edge is not seen but by how far they lie apart; else of its place alone, as something stands in its way.
    pub fn take_off<'w>(
        &self,
        tracing: (&'w World, &'w Optics<M>),
        (film, pupil, within): (DVec2, DVec2, DVec2),
        (whole, rest, landed): (f64, Rest, u32),
        rng: &mut Rng,
        mut visit: impl FnMut(&mut Walker<'w, M>, &Vertex, f64, Option<Span>),
    ) {
        if rest.open == 0 {
            return;
        }
        let Some((spot, _)) = self.usage(film, Glanced::Lit, Counted::Differences) else { return };
        let look = self.look_at(spot, pupil, Some((self.over.by_pixel(tracing.0), within)));
        for (k, glance) in self.glances.iter().enumerate().filter(|(k, _)| rest.open & 1 << k != 0) {
            let weight = -whole / rest.share;
            let at = glance.landings.blend(&look.rows, &look.pupil);
            if let Some((mut walker, vertex)) = at.and_then(|at| glance.land(tracing, &at, weight, rng.fork())) {
                let span = if landed & 1 << k != 0 { glance.span(&look, 1.0) } else { None };
                visit(&mut walker, &vertex, weight, span);
            }
        }
    }

    /// Faces that the tables lead to, as (part, face).
    pub fn faces(&self) -> impl Iterator<Item = (u32, u32)> {
        self.glances.iter().map(Glance::face)
    }

    fn look_at(&self, spot: Spot, pupil: DVec2, pixel: Option<(DVec2, DVec2)>) -> Look {
        let at = if self.radius > 0.0 { pupil / (OUTER * self.radius) } else { DVec2::ZERO };
        let [x, y] = at.to_array().map(|t| [0.5 * t * (t - 1.0), 1.0 - t * t, 0.5 * t * (t + 1.0)]);
        let along = pixel.map(|(cells, within)| {
            ([DVec2::new(cells.x, 0.0), DVec2::new(0.0, cells.y)].map(|step| spot.rows_along(step)), within)
        });
        Look { rows: spot.rows(), along, pupil: std::array::from_fn(|k| x[k % 3] * y[k / 3]) }
    }
}

impl<M: Mode> Glance<M> {
    /// It brings so little that rays with all their branches hardly ever find it.
    fn is_faint(&self) -> bool {
        self.share < FAINT
    }

    /// The face that it leads to.
    fn face(&self) -> (u32, u32) {
        (self.vertex.hit.site.part, self.vertex.hit.site.face)
    }

    /// How the landing moves over the pixel.
    fn span(&self, look: &Look, whole: f64) -> Option<Span> {
        let (along, within) = look.along.as_ref()?;
        let [right, down] = along.each_ref().map(|rows| self.landings.blend(rows, &look.pupil).map(|at| at.point));
        Some(Span { by: [right?, down?], within: *within, whole })
    }

    /// Follows a ray over the train to the face; none where it does not get there with all wavelengths.
    fn follow<'w>(
        &self,
        tracing: (&'w World, &'w Optics<M>),
        (film, pupil, weight, rng): (DVec2, DVec2, f64, Rng),
    ) -> Option<(Walker<'w, M>, Vertex)> {
        let (origin, (_, dir), ..) = tracing.0.eye.ray_of(film, pupil);
        let ray = Ray { origin, dir, from: None };
        let walker = Walker::new(tracing, Travel::FromEye, ray, weight, Interior::default(), rng);
        follow(walker, &self.chain, self.face())
    }

    /// A ray that lands there; none where it misses the face.
    fn land<'w>(
        &self,
        (world, optics): (&'w World, &'w Optics<M>),
        landing: &EyeHit<M>,
        weight: f64,
        rng: Rng,
    ) -> Option<(Walker<'w, M>, Vertex)> {
        /// How far before the face the ray begins, of its distance from the eye: about as far as tables err.
        const BEFORE: f64 = 1e-4;
        let dir = landing.dir.try_normalize()?;
        let (site, known) = (self.vertex.hit.site, &self.vertex);
        let back = BEFORE * landing.point.distance(world.eye.position());
        let ray = Ray { origin: landing.point - dir * back, dir, from: None };
        let meet = world.geometry.meet(site.part, site.face, &ray, known.hit.local)?;
        let outside = dir.dot(meet.normal) < 0.0;
        if outside != known.outside {
            return None;
        }
        let hit = Hit {
            t: 0.0,
            site: site_of(site.part, site.face, &meet),
            point: meet.point,
            local: meet.local,
            normal: meet.normal,
            shading: meet.shading,
        };
        let shading = world.shading(&hit, ray.dir);
        let normal = if outside { shading } else { -shading };
        let vertex = Vertex {
            hit,
            touching: known.touching,
            then: None,
            back: None,
            beside: None,
            outside,
            normal,
            point: OnceLock::new(),
        };
        let weights = lanes::<M, _>(|lane| weight * landing.weight[lane]);
        let interior = self.interior;
        let mut walker = Walker::with_weights((world, optics), Travel::FromEye, ray, weights, interior, rng);
        (walker.trail, walker.told, walker.events) = (self.trail, self.told, self.events);
        Some((walker, vertex))
    }
}

/// Follows a ray over a train to a face; none where it does not get there with all wavelengths.
fn follow<'w, M: Mode>(mut walker: Walker<'w, M>, chain: &Chain, face: (u32, u32)) -> Option<(Walker<'w, M>, Vertex)> {
    let mut ledger = Ledger::new(walker.world.solids.len());
    let whole = walker.follow(chain.0.iter().copied(), &mut ledger, |_, _, _| {});
    let vertex = whole.then(|| walker.reach_face(face, &mut ledger)).flatten()?;
    walker.heal(&vertex, &mut ledger);
    (walker.beam.count() == M::LANES).then_some((walker, vertex))
}
