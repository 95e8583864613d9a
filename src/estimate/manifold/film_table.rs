//! What connections with the eye bring, as tables over the picture.
//!
//! Per train and lamp the solutions are kept at the nodes of a grid over the picture, with their derivatives by the place
//! on the lamp; in between, the place in the pupil, the strength and the places on slides are interpolated. No table is
//! trusted: it is a control variate (e.g. A. Owen, "Monte Carlo theory, methods and examples", 2013, chapter 8.9). Every
//! pixel takes what the table says, and now and then, the more seldom the better the table did on trial, the difference of
//! the solved connection from it, so that the mean is the solver's whatever stands in the way between two nodes.

mod make;

use super::film_grid::FilmGrid;
use super::receiver::{Crossing, SLIDES};
use super::seeds::MOST_SHEETS;
use super::seeds::connections::Connections;
use super::solver::bicubic::Spot;
use crate::base::lpe::LpeState;
use crate::base::path::Trail;
use crate::film::accumulate::Light;
use crate::world::World;
use crate::world::mode::{Mode, lanes, wavelengths_change};
use crate::world::optics::Optics;
use arrayvec::ArrayVec;
use glam::{DMat2, DVec2, DVec3};
use make::Maker;
use rayon::prelude::*;

/// The solution at a node, for the middle of the lamp.
#[derive(Debug, Clone)]
struct Node<M: Mode> {
    /// m, and by metres on the lamp.
    pupil: DVec2,
    pupil_by: DMat2,
    /// Luminance that the whole lamp brings, per lane, cd/m², with the slides open; and by metres on the lamp.
    strength: M::Lanes<f64>,
    strength_by: [M::Lanes<f64>; 2],
    trail: Trail,
    told: LpeState,
    alone: bool,
    slides: ArrayVec<Crossing, SLIDES>,
}

/// What a connection brings to a place of the picture from a point of its lamp.
pub(super) struct Brought<M: Mode> {
    /// Place in the pupil, m.
    pub(super) pupil: DVec2,
    /// Luminance per lane, cd/m².
    pub(super) light: M::Lanes<Light>,
    pub(super) alone: bool,
    pub(super) trail: Trail,
    pub(super) told: LpeState,
}

/// A train and lamp.
#[derive(Debug)]
pub struct FilmTable<M: Mode> {
    /// Nodes of each branch.
    branches: Vec<Vec<Option<Node<M>>>>,
    /// Per cell.
    uses: Vec<Use>,
}

/// What a table is good for in a cell.
#[derive(Debug, Clone, Copy)]
struct Use {
    /// How often the solved connection is looked at.
    share: f64,
    /// Which sixteen nodes there are, see [`Nodes::spot_by`].
    aside: [i8; 2],
    /// So near to the rim of a slide's picture, as a share of its size, the solved connection is always looked at: there it may
    /// well find nothing where the table says light, and a difference taken now and then would be light below 0.
    rim: f64,
    /// The same of the pupil, as a share of its radius.
    pupil_rim: f64,
}

impl Use {
    /// The table is of no use: every connection is solved for.
    const SOLVED: Use = Use { share: 1.0, aside: [0; 2], rim: 0.0, pupil_rim: 0.0 };
}

/// Those of all [`Connections`], in the order of their entries.
#[derive(Debug)]
pub struct FilmTables<M: Mode> {
    over: FilmGrid,
    tables: Vec<FilmTable<M>>,
}

impl<M: Mode> FilmTables<M> {
    /// None without connections, or where every pass has wavelengths of its own.
    pub fn new(world: &World, optics: &Optics<M>, connections: &Connections, over: FilmGrid) -> Option<FilmTables<M>> {
        if wavelengths_change::<M>() || connections.is_empty() {
            return None;
        }
        let mut tables = FilmTables { over, tables: Vec::new() };
        let maker = Maker { world, optics, connections };
        let made: Vec<FilmTable<M>> = connections.entries.par_iter().map(|entry| maker.table(&tables, entry)).collect();
        tables.tables = made;
        Some(tables)
    }

    /// Where a place of the picture lies among the nodes.
    pub(super) fn spot(&self, film: DVec2) -> Option<Spot> {
        self.over.spot(film)
    }
}

impl<M: Mode> FilmTables<M> {
    /// How often the solved connection of an entry is to be looked at.
    pub(super) fn share(&self, entry: usize, spot: &Spot) -> f64 {
        self.tables.get(entry).map_or(1.0, |table| table.uses[spot.cell].share)
    }

    /// What the branches of an entry bring, before slides; and whether that is at the rim of a slide's picture. `off`: place
    /// on the lamp from its middle, m.
    pub(super) fn read(&self, world: &World, entry: usize, spot: &Spot, off: DVec2) -> Read<M> {
        let mut read = Read { branches: ArrayVec::new(), at_rim: false };
        let Some(table) = self.tables.get(entry) else { return read };
        let Use { aside, rim, pupil_rim, .. } = table.uses[spot.cell];
        let radius = world.eye.pupil_radius_m();
        let Some(spot) = self.over.nodes.aside(*spot, aside) else { return read };
        for nodes in &table.branches {
            let Some((brought, slides)) = blend(nodes, &spot, off) else { continue };
            read.at_rim |= (brought.pupil.length() - radius).abs() <= pupil_rim * radius;
            read.at_rim |= slides.iter().any(|(slide, at)| world.slides[*slide].to_rim(*at) <= rim);
            if read.branches.try_push((brought, slides)).is_err() {
                break;
            }
        }
        read
    }
}

/// What a table says of a place.
pub(super) struct Read<M: Mode> {
    branches: ArrayVec<(Brought<M>, Places), MOST_SHEETS>,
    pub(super) at_rim: bool,
}

impl<M: Mode> Read<M> {
    /// What comes through the slides.
    pub(super) fn brought(self, world: &World, optics: &Optics<M>) -> impl Iterator<Item = Brought<M>> {
        self.branches.into_iter().filter_map(move |(brought, slides)| through_slides(world, optics, brought, &slides))
    }
}

type Places = ArrayVec<(usize, DVec3), SLIDES>;

/// The nodes' solutions in between, with the slides open, and where slides are crossed; none where a node is missing or
/// they do not cross the same slides.
fn blend<M: Mode>(nodes: &[Option<Node<M>>], spot: &Spot, off: DVec2) -> Option<(Brought<M>, Places)> {
    let near = nodes[spot.cell].as_ref()?;
    let mut pupil = DVec2::ZERO;
    let mut strength = lanes::<M, _>(|_| 0.0);
    let mut slides: Places = near.slides.iter().map(|crossing| (crossing.slide, DVec3::ZERO)).collect();
    for (node, weight) in spot.nodes() {
        let node = nodes[node].as_ref()?;
        if node.slides.len() != near.slides.len() || (node.alone, node.trail) != (near.alone, near.trail) {
            return None;
        }
        pupil += weight * (node.pupil + node.pupil_by * off);
        for lane in 0..M::LANES {
            let [by_x, by_y] = node.strength_by.map(|by| by[lane]);
            strength[lane] += weight * (node.strength[lane] + by_x * off.x + by_y * off.y);
        }
        for ((_, at), crossing) in slides.iter_mut().zip(&node.slides) {
            *at += weight * (crossing.local + crossing.by_lamp[0] * off.x + crossing.by_lamp[1] * off.y);
        }
    }
    let light = lanes::<M, _>(|lane| Light::ONE.scaled(strength[lane]));
    Some((Brought { pupil, light, alone: near.alone, trail: near.trail, told: near.told }, slides))
}

/// None beside a slide's picture.
fn through_slides<M: Mode>(
    world: &World,
    optics: &Optics<M>,
    mut brought: Brought<M>,
    slides: &Places,
) -> Option<Brought<M>> {
    for (slide, at) in slides {
        let map = &world.slides[*slide];
        let s = optics.slide(map, *at)?;
        for lane in 0..M::LANES {
            brought.light[lane].cross(map.t_white(), map.transmittance(s[lane]), s[lane]);
        }
    }
    Some(brought)
}
