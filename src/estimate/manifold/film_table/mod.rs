//! What connections with the eye bring, as tables over the picture.
//!
//! Per train and lamp the solutions are kept at the nodes of a grid over the picture, with their derivatives by the place
//! on the lamp; in between, the place in the pupil, the strength and the places on slides are interpolated. No table is
//! trusted: it is a control variate (e.g. A. Owen, "Monte Carlo theory, methods and examples", 2013, chapter 8.9). Every
//! pixel takes what the table says of all of it, with the slides' pictures cut by its footprint, and now and then, the more
//! seldom the better the table did on trial, the difference of the solved connection from what the table says of its place,
//! so that the mean is the solver's whatever stands in the way between two nodes.

mod make;
mod masks;
mod over_pixel;
mod trial;
mod tuning;

use super::receiver::{Crossing, SLIDES};
use super::seeds::connections::Connections;
use super::solver::bicubic::Spot;
use crate::manifold::film_grid::FilmGrid;
use arrayvec::ArrayVec;
use eyebox_base::lpe::LpeState;
use eyebox_base::parallel;
use eyebox_base::path::Trail;
use eyebox_world::World;
use eyebox_world::mode::{Mode, lanes, wavelengths_change};
use eyebox_world::optics::Optics;
use glam::{DMat2, DVec2, DVec3};
use make::Maker;
use masks::{Hidden, MASKS, Mask};
use over_pixel::Crossed;
pub(super) use over_pixel::{OverLamp, OverPixel};

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
    /// Where the faces of the table's masks are met, recentred world, m; `slide` is the mask's number.
    masks: ArrayVec<Crossing, MASKS>,
}

/// A train and lamp.
#[derive(Debug)]
pub struct FilmTable<M: Mode> {
    /// Faces of the train that the picture ends at.
    masks: ArrayVec<Mask, MASKS>,
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
    /// How far about a place the outlines of masks may lie, m; 0 where they are far from all of the cell.
    mask_reach: [f64; MASKS],
}

impl Use {
    /// The table is of no use: every connection is solved for.
    const SOLVED: Use = Use { share: 1.0, aside: [0; 2], rim: 0.0, pupil_rim: 0.0, mask_reach: [0.0; MASKS] };
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
        let made: Vec<FilmTable<M>> = parallel::map_all(&connections.entries, &|entry| maker.table(&tables, entry));
        tables.tables = made;
        Some(tables)
    }

    /// Where the middle of a pixel lies among the nodes.
    pub(super) fn spot(&self, world: &World, (x, y): (usize, usize)) -> Option<Spot> {
        self.over.spot(world.eye.film_of(x, y, [0.5; 2]))
    }

    /// How often the solved connection of an entry is to be looked at.
    pub(super) fn share(&self, entry: usize, spot: &Spot) -> f64 {
        self.tables.get(entry).map_or(1.0, |table| table.uses[spot.cell].share)
    }

    /// Adds what the branches of an entry bring to a pixel whose middle is there: for one point of the lamp, and for all of them
    /// where what is seen changes much from one to the other. Returns whether that is at the rim of a slide's picture, of the
    /// pupil, or of a face of the train. `off`: place on the lamp from its middle, m; `size`: of the lamp, m.
    pub(super) fn read(
        &self,
        world: &World,
        entry: usize,
        spot: &Spot,
        (off, size): (DVec2, f64),
        branches: &mut Vec<Branch<M>>,
    ) -> bool {
        let mut at_rim = false;
        let Some(table) = self.tables.get(entry) else { return at_rim };
        let Use { aside, rim, pupil_rim, mask_reach, .. } = table.uses[spot.cell];
        let radius = world.eye.pupil_radius_m();
        let Some(spot) = self.over.nodes.aside(*spot, aside) else { return at_rim };
        let cells = self.over.by_pixel(world);
        for (number, nodes) in table.branches.iter().enumerate() {
            let Some(crossed) = Crossed::read(nodes, &spot, cells) else { continue };
            // Most lamps are seen beside the pupil.
            let beside = (1.0 + pupil_rim) * radius + crossed.reach();
            if crossed.middle().length() > beside + crossed.spread(size) {
                continue;
            }
            let mut edges = ArrayVec::new();
            if mask_reach != [0.0; MASKS] {
                match masks::cut(world, nodes, (&table.masks, &mask_reach), (&spot, cells), size) {
                    None | Some(Hidden::All) => continue,
                    Some(Hidden::Beyond(cut)) => edges = cut,
                }
            }
            if edges.is_empty() && crossed.at(off).length() > beside {
                continue;
            }
            let at = |off: DVec2| OverPixel::read(nodes, &crossed, (&spot, cells), off);
            let Some(mut over) = at(off) else { continue };
            over.edges = edges.iter().map(|edge| edge.at(off)).collect();
            at_rim |= !edges.is_empty();
            at_rim |= (over.pupil.length() - radius).abs() <= pupil_rim * radius + crossed.reach();
            at_rim |= over.footprints.iter().any(|footprint| footprint.to_rim(&world.slides[footprint.slide]) <= rim);
            let over_lamp = if edges.is_empty() { None } else { OverLamp::read(at, edges, size).map(Box::new) };
            branches.push(Branch { number, over, over_lamp });
        }
        at_rim
    }

    /// What a branch, by its number, brings to a pixel whose middle is there, for every point of the lamp; for one that no outline
    /// cuts. None where a node is missing.
    pub(super) fn over_lamp(
        &self,
        world: &World,
        (entry, branch): (usize, usize),
        spot: &Spot,
        size: f64,
    ) -> Option<OverLamp<M>> {
        let table = self.tables.get(entry)?;
        let spot = self.over.nodes.aside(*spot, table.uses[spot.cell].aside)?;
        let (nodes, cells) = (table.branches.get(branch)?, self.over.by_pixel(world));
        let crossed = Crossed::read(nodes, &spot, cells)?;
        OverLamp::read(|off| OverPixel::read(nodes, &crossed, (&spot, cells), off), ArrayVec::new(), size)
    }
}

/// A branch over a pixel.
pub(super) struct Branch<M: Mode> {
    pub(super) number: usize,
    /// For one point of the lamp,
    pub(super) over: OverPixel<M>,
    /// and for all, where an outline moves with it.
    pub(super) over_lamp: Option<Box<OverLamp<M>>>,
}

type Places = ArrayVec<(usize, DVec3), SLIDES>;

/// What the nodes say between them, with the slides open.
struct Blend<M: Mode> {
    /// Place in the pupil, m.
    pupil: DVec2,
    /// Luminance per lane, cd/m².
    strength: M::Lanes<f64>,
    slides: Places,
    masks: ArrayVec<DVec3, MASKS>,
}

/// The nodes' solutions in between; none where a node is missing or they do not cross the same slides.
fn blend<M: Mode>(nodes: &[Option<Node<M>>], spot: &Spot, off: DVec2) -> Option<Blend<M>> {
    let near = nodes[spot.cell].as_ref()?;
    let mut pupil = DVec2::ZERO;
    let mut strength = lanes::<M, _>(|_| 0.0);
    let mut slides: Places = near.slides.iter().map(|crossing| (crossing.slide, DVec3::ZERO)).collect();
    let mut masks: ArrayVec<DVec3, MASKS> = near.masks.iter().map(|_| DVec3::ZERO).collect();
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
            *at += weight * crossing.at(off);
        }
        for (at, crossing) in masks.iter_mut().zip(&node.masks) {
            *at += weight * crossing.at(off);
        }
    }
    Some(Blend { pupil, strength, slides, masks })
}

/// Whether a path that crosses slides there goes through their pictures.
fn through_slides<M: Mode>(world: &World, optics: &Optics<M>, slides: &Places) -> bool {
    slides.iter().all(|(slide, at)| optics.slide(&world.slides[*slide], *at).is_some())
}
