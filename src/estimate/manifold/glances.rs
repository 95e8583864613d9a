//! Where rays from the eye land on faces that are joined with lamps, as tables over the picture and the pupil.
//!
//! Over a known train of specular faces the place where a ray lands, its direction there and what the train lets through
//! are smooth in its place in the picture and in the pupil: between nodes they are interpolated. As with
//! [`Tables`](super::tables::Tables) no table is trusted. Now and then the ray itself is followed with all its branches,
//! and makes good what the tables had wrong or did not have.

mod make;

use super::nodes::Spot;
use super::over_film::OverFilm;
use super::screens::Screens;
use crate::base::chain::Chain;
use crate::base::lpe::Told;
use crate::base::path::Trail;
use crate::base::rng::Rng;
use crate::estimate::walk::{Travel, Vertex, Walker};
use crate::world::World;
use crate::world::geometry::bend::site_of;
use crate::world::geometry::{Hit, Ray};
use crate::world::interior::Interior;
use crate::world::mode::{Mode, Spectral, lanes};
use crate::world::optics::Optics;
use glam::{DVec2, DVec3};

/// Nodes over the pupil: three along both axes.
const OVER_PUPIL: usize = 9;
/// The outer of them, in radii.
const OUTER: f64 = 0.8;

/// Where a ray lands.
#[derive(Debug, Clone, Copy)]
struct Landing<M: Mode> {
    /// Recentred world, m.
    point: DVec3,
    dir: DVec3,
    /// Of what the ray starts with, per lane.
    weight: M::Lanes<f64>,
}

/// A train from the eye to a lit face.
struct Glance<M: Mode> {
    chain: Chain,
    /// A ray that landed over it: what it met, and what is the same for all.
    vertex: Vertex,
    trail: Trail,
    told: Told,
    interior: Interior,
    events: u32,
    /// Over the picture, each over the pupil; none where a ray does not land over this train.
    nodes: Vec<Option<[Landing<M>; OVER_PUPIL]>>,
}

/// How a cell is used.
#[derive(Debug, Clone, Copy)]
struct Use {
    /// How often the ray itself is followed.
    share: f64,
    /// The glances that have all nodes, as bits.
    known: u32,
}

/// All trains from the eye to faces that are joined with lamps.
pub struct Glances<M: Mode> {
    over: OverFilm,
    /// m
    radius: f64,
    glances: Vec<Glance<M>>,
    /// Per cell.
    uses: Vec<Use>,
}

/// Where to look.
pub(super) struct Look {
    spot: Spot,
    /// Weights of the nodes over the pupil.
    pupil: [f64; OVER_PUPIL],
    usage: Use,
}

impl Look {
    /// How often the ray itself has to be followed.
    pub(super) fn share(&self) -> f64 {
        self.usage.share
    }
}

impl<M: Mode> Glances<M> {
    /// None without lit faces and trains to them, or where every pass has wavelengths of its own.
    pub fn new(world: &World, optics: &Optics<M>, screens: &Screens<M>, over: OverFilm) -> Option<Glances<M>> {
        if M::SPECTRAL == Spectral::Hero || screens.is_empty() {
            return None;
        }
        let radius = world.eye.pupil_radius_m();
        let glances = Glances { over, radius, glances: Vec::new(), uses: Vec::new() }.make((world, optics), screens);
        (!glances.glances.is_empty()).then_some(glances)
    }

    /// Places in picture (tangents) and pupil (m).
    pub(super) fn look(&self, film: DVec2, pupil: DVec2) -> Option<Look> {
        let spot = self.over.spot(film)?;
        let usage = *self.uses.get(spot.cell)?;
        Some(self.look_at(spot, pupil, usage))
    }

    fn look_at(&self, spot: Spot, pupil: DVec2, usage: Use) -> Look {
        let at = if self.radius > 0.0 { pupil / (OUTER * self.radius) } else { DVec2::ZERO };
        let [x, y] = at.to_array().map(|t| [0.5 * t * (t - 1.0), 1.0 - t * t, 0.5 * t * (t + 1.0)]);
        Look { spot, pupil: std::array::from_fn(|k| x[k % 3] * y[k / 3]), usage }
    }

    /// Calls `visit` with rays that have just landed, where tables know of them. `weight`: what each started with.
    pub(super) fn each<'w>(
        &self,
        (world, optics): (&'w World, &'w Optics<M>),
        look: &Look,
        weight: f64,
        rng: &mut Rng,
        mut visit: impl FnMut(Walker<'w, M>, Vertex),
    ) {
        for (k, glance) in self.glances.iter().enumerate() {
            if look.usage.known & 1 << k == 0 {
                continue;
            }
            let Some(landing) = glance.blend(look) else { continue };
            if let Some((walker, vertex)) = glance.land((world, optics), &landing, weight, rng.fork()) {
                visit(walker, vertex);
            }
        }
    }
}

impl<M: Mode> Glance<M> {
    fn blend(&self, look: &Look) -> Option<Landing<M>> {
        let mut sum: Landing<M> = Landing { point: DVec3::ZERO, dir: DVec3::ZERO, weight: lanes::<M, _>(|_| 0.0) };
        for (node, over_film) in look.spot.nodes() {
            let node = self.nodes.get(node)?.as_ref()?;
            for (landing, over_pupil) in node.iter().zip(&look.pupil) {
                let share = over_film * over_pupil;
                sum.point += share * landing.point;
                sum.dir += share * landing.dir;
                for lane in 0..M::LANES {
                    sum.weight[lane] += share * landing.weight[lane];
                }
            }
        }
        Some(sum)
    }

    /// A ray that lands there; none where it misses the face.
    fn land<'w>(
        &self,
        (world, optics): (&'w World, &'w Optics<M>),
        landing: &Landing<M>,
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
        let normal = if outside { hit.shading } else { -hit.shading };
        let vertex = Vertex { hit, touching: known.touching, then: None, beside: None, outside, normal };
        let weights = lanes::<M, _>(|lane| weight * landing.weight[lane]);
        let interior = self.interior.clone();
        let mut walker = Walker::with_weights((world, optics), Travel::FromEye, ray, weights, interior, rng);
        (walker.trail, walker.told, walker.events) = (self.trail, self.told, self.events);
        Some((walker, vertex))
    }
}
