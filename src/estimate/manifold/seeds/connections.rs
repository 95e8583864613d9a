//! All specular connections of a plan, ready to be asked: which solutions there are for a place in the picture and a
//! point of a lamp, and whether a path is one of them.

use super::tuning::connections::{BRIGHT, FULL, SELDOM};
use super::{Builder, SAME, Seeds};
use crate::ledger::cost;
use crate::manifold::solver::grid::Grid;
use crate::manifold::solver::newton::{Root, Target};
use arrayvec::ArrayVec;
use eyebox_base::chain::Chain;
use eyebox_film::specular_chain::{Connection, SpecularChain};
use eyebox_world::World;
use eyebox_world::mode::Mode;
use eyebox_world::optics::Optics;
use glam::DVec2;
use std::collections::HashMap;

/// A train with its starts for one lamp.
#[derive(Debug)]
pub struct Entry {
    pub train: usize,
    /// Of its group's light, what the train brings.
    pub share: f64,
    pub starts: Seeds,
}

/// Who has a path that may be connection's, if the solver does not return it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rest {
    /// Light tracing.
    Lamp,
    /// Rays from the eye. `solved`: the solver may return it, so it has to be asked.
    Eye { solved: bool },
}

/// Entries of the other cells that an area reaches into.
#[derive(Debug, Default)]
pub struct Everywhere<'c> {
    others: ArrayVec<&'c [u32], 4>,
}

impl Everywhere<'_> {
    /// Whether an entry is tried in all of them.
    pub fn has(&self, entry: usize) -> bool {
        let listed = |cell: &&[u32]| u32::try_from(entry).is_ok_and(|entry| cell.binary_search(&entry).is_ok());
        self.others.iter().all(listed)
    }
}

/// The connections of a plan.
#[derive(Debug, Default)]
pub struct Connections {
    pub trains: Vec<SpecularChain>,
    /// Per train: of the light of the group that it brings most of.
    shares: Vec<f64>,
    /// Per train: whether light tracing has what the solver does not return.
    reached: Vec<bool>,
    pub entries: Vec<Entry>,
    /// Per cell of the picture: the entries whose light may arrive there.
    by_cell: Vec<Vec<u32>>,
    /// Train from the lamp to the eye → its number.
    known: HashMap<Chain, usize>,
    grid: Option<Grid>,
}

impl Connections {
    /// Solves for the starts. `index`: of what fills a part's space, or of air.
    pub fn new(world: &World, index: &impl Fn(Option<u32>) -> f64, connections: &[Connection]) -> Connections {
        if connections.is_empty() {
            return Connections::default();
        }
        let grid = Grid::of(world);
        let mut out =
            Connections { grid: Some(grid), by_cell: vec![Vec::new(); grid.cells()], ..Connections::default() };
        for connection in connections {
            let known = out.known.entry(connection.train.chain().reversed()).or_insert(out.trains.len());
            let train = *known;
            if train == out.trains.len() {
                out.trains.push(connection.train.clone());
                out.shares.push(0.0);
                out.reached.push(true);
            }
            out.reached[train] &= connection.reached;
            out.shares[train] = out.shares[train].max(connection.share);
            let builder = Builder { world, index, train: &connection.train };
            for starts in builder.starts(connection) {
                let entry = out.entries.len() as u32;
                (0..grid.cells()).filter(|cell| starts.has(*cell)).for_each(|cell| out.by_cell[cell].push(entry));
                out.entries.push(Entry { train, share: connection.share, starts });
            }
        }
        out
    }

    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// What may bring light to a place in the picture, with its number.
    pub fn at(&self, film: DVec2) -> impl Iterator<Item = (usize, &Entry)> {
        let cell = self.grid.map(|grid| grid.cell(film));
        let entries = cell.and_then(|cell| self.by_cell.get(cell)).map_or(&[][..], Vec::as_slice);
        entries.iter().filter_map(|index| Some((*index as usize, self.entries.get(*index as usize)?)))
    }

    /// Which entries are tried all over a small area with these corners, and not only about `film` in it.
    pub fn at_all(&self, film: DVec2, corners: [DVec2; 4]) -> Everywhere<'_> {
        let Some(grid) = self.grid else { return Everywhere::default() };
        let about = grid.cell(film);
        let others = corners.map(|corner| grid.cell(corner)).into_iter().filter(|cell| *cell != about);
        Everywhere { others: others.filter_map(|cell| self.by_cell.get(cell).map(Vec::as_slice)).collect() }
    }

    /// Who has the paths over `chain` (from the lamp) from `lamp` to this place in the picture that the solver does not return.
    /// Every path has one answer, whichever end it was found from.
    pub fn rest(&self, chain: &Chain, lamp: usize, film: DVec2) -> Rest {
        let Some(train) = self.known.get(chain) else { return Rest::Eye { solved: false } };
        let starts = self.entries_of(*train, lamp, film).next().is_some();
        match self.reached[*train] {
            true if starts || self.shares[*train] >= BRIGHT => Rest::Lamp,
            // The few paths that light tracing would find over a faint train without a start have great weight.
            true => Rest::Eye { solved: false },
            false => Rest::Eye { solved: starts },
        }
    }

    /// Whether a path that a ray from the eye has found is for such rays: [`Connections::rest`] says so, and the solver
    /// does not return it.
    pub fn leaves_to_eye<M: Mode>(
        &self,
        tracing: (&World, &Optics<M>),
        chain: &Chain,
        (lamp, target): (usize, &Target),
        (film, pupil): (DVec2, DVec2),
        work: &mut u64,
    ) -> bool {
        match self.rest(chain, lamp, film) {
            Rest::Lamp => false,
            Rest::Eye { solved: false } => true,
            Rest::Eye { solved: true } => !self.owns(tracing, chain, (lamp, target), (film, pupil), work),
        }
    }

    fn entries_of(&self, train: usize, lamp: usize, film: DVec2) -> impl Iterator<Item = &Entry> {
        let own = move |entry: &&Entry| entry.train == train && entry.starts.lamp == lamp;
        self.at(film).map(|(_, entry)| entry).filter(own)
    }

    /// The probability with which an entry is tried. Faint trains are left out now and then.
    pub fn chance(&self, entry: &Entry) -> f64 {
        (self.shares[entry.train] / FULL).clamp(SELDOM, 1.0)
    }

    /// The cells of the picture by which entries are looked up; none without any.
    pub fn grid(&self) -> Option<Grid> {
        self.grid
    }

    /// The solutions of an entry for a place in the picture and a point of its lamp. Returns how often it was solved for one.
    pub fn roots<M: Mode>(
        &self,
        (world, optics): (&World, &Optics<M>),
        entry: &Entry,
        film: DVec2,
        target: &Target,
        out: &mut Vec<Root>,
    ) -> u64 {
        entry.starts.roots(world, &index_of(optics), &self.trains[entry.train], film, target, out)
    }

    /// Whether a path from a point of `lamp` over `chain` (from the lamp) that crosses picture and pupil at these places is
    /// one that the solver returns. Adds to the counted work.
    pub fn owns<M: Mode>(
        &self,
        tracing: (&World, &Optics<M>),
        chain: &Chain,
        (lamp, target): (usize, &Target),
        (film, pupil): (DVec2, DVec2),
        work: &mut u64,
    ) -> bool {
        let Some(train) = self.known.get(chain) else { return false };
        let same = SAME * tracing.0.eye.pupil_radius_m();
        let mut roots = Vec::new();
        for entry in self.entries_of(*train, lamp, film) {
            let solved = self.roots(tracing, entry, film, target, &mut roots);
            *work += cost::SOLVED * solved * self.trains[*train].0.len() as u64;
        }
        roots.iter().any(|root| root.u.distance(pupil) <= same)
    }
}

/// Refractive index of what fills a part's space, or of air, for the wavelength that decides where paths go.
pub fn index_of<M: Mode>(optics: &Optics<M>) -> impl Fn(Option<u32>) -> f64 + use<'_, M> {
    |part| optics.index_in(part)[0]
}
