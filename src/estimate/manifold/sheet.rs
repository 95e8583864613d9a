//! Where the solver starts: per train and lamp, the solution for the middle of the lamp on a grid over the picture, with
//! its derivatives. A train whose map is folded has a sheet for each of its branches.

use super::grid::Grid;
use super::solve::{Family, Root, Target, newton, trace};
use crate::film::train::{Connection, Train};
use crate::world::World;
use crate::world::lamp::Lamp;
use glam::{DMat2, DVec2};
use std::collections::VecDeque;

/// Sheets of one train and lamp; further branches stay with the estimator that owns the rest.
const MOST_SHEETS: usize = 4;
/// How far from its middle, in radii of the pupil, the solver looks for solutions.
const FAR: f64 = 1.05;
/// Roots nearer to each other than this share of the pupil's radius are one.
pub const SAME: f64 = 1e-6;

/// The solution at the middle of a cell.
#[derive(Debug, Clone, Copy)]
struct Node {
    pupil: DVec2,
    by_film: DMat2,
    by_lamp: DMat2,
    /// How both change with the place in the picture, by its two coordinates.
    bend: [DMat2; 2],
    twist: [DMat2; 2],
    /// Light of the cell may cross the pupil.
    useful: bool,
}

/// One branch of the map from (picture, lamp) to the pupil.
#[derive(Debug, Clone)]
struct Sheet {
    nodes: Vec<Option<Node>>,
}

/// All branches of a train for one lamp.
#[derive(Debug, Clone)]
pub struct Starts {
    /// Number of the lamp in the world.
    pub lamp: usize,
    middle: Target,
    /// Radius of the lamp, m.
    size: f64,
    grid: Grid,
    sheets: Vec<Sheet>,
}

/// What the tables are made with.
pub struct Builder<'b, I: Fn(Option<u32>) -> f64> {
    pub world: &'b World,
    pub index: &'b I,
    pub train: &'b Train,
}

impl<I: Fn(Option<u32>) -> f64> Builder<'_, I> {
    /// Starts for every lamp of the connection's group that its light comes from.
    pub fn starts(&self, connection: &Connection) -> Vec<Starts> {
        let grid = Grid::of(self.world);
        let lamps = self.world.lamps.all().iter().enumerate();
        let lamps = lamps.filter(|(_, lamp)| lamp.group == connection.group && lamp.flux_lm > 0.0);
        let mut all: Vec<Starts> = lamps.map(|(index, lamp)| Starts::new(index, lamp, grid)).collect();
        for seed in &connection.seeds {
            if let Some(starts) = all.iter_mut().find(|starts| starts.lamp == seed.lamp as usize) {
                self.grow(starts, DVec2::from_array(seed.film), DVec2::from_array(seed.pupil));
            }
        }
        // What one lamp does over a train its neighbours do too, moved.
        let mut open: VecDeque<usize> = (0..all.len()).filter(|i| !all[*i].sheets.is_empty()).collect();
        while let Some(from) = open.pop_front() {
            for to in 0..all.len() {
                if to != from && self.spread(&mut all, from, to) {
                    open.push_back(to);
                }
            }
        }
        all.retain(|starts| !starts.sheets.is_empty());
        all
    }

    /// Starts the lamp `to` from what is known of the lamp `from`. Returns whether it had nothing before and has now.
    fn spread(&self, all: &mut [Starts], from: usize, to: usize) -> bool {
        if !all[to].sheets.is_empty() {
            return false;
        }
        let radius = self.world.eye.pupil_radius_m();
        let offset = all[from].middle.local(all[to].middle.point - all[from].middle.point);
        let grid = all[from].grid;
        let near: Vec<(usize, DVec2)> = all[from]
            .sheets
            .iter()
            .flat_map(|sheet| sheet.nodes.iter().enumerate())
            .filter_map(|(cell, node)| node.map(|node| (cell, node.pupil + node.by_lamp * offset)))
            .filter(|(_, pupil)| pupil.length() <= 1.5 * radius)
            .collect();
        let mut next = 0;
        while next < near.len() && all[to].sheets.is_empty() {
            let (cell, pupil) = near[next];
            self.grow(&mut all[to], grid.middle(cell), pupil);
            // A few tries over all of the picture say whether there is anything.
            next += near.len().div_ceil(16);
        }
        !all[to].sheets.is_empty()
    }

    /// Adds the branch that has this solution, unless it is known.
    fn grow(&self, starts: &mut Starts, film: DVec2, pupil: DVec2) {
        let radius = self.world.eye.pupil_radius_m();
        if starts.sheets.len() >= MOST_SHEETS {
            return;
        }
        let family = Family::Pupil { film };
        let found = newton(self.world, self.index, &family, pupil, self.train, &starts.middle, starts.size);
        let Some(seed) = found else { return };
        let mut known = Vec::new();
        starts.roots(self.world, self.index, self.train, film, &starts.middle, &mut known);
        if known.iter().any(|root: &Root| root.u.distance(seed.u) <= SAME * radius) {
            return;
        }
        let grid = starts.grid;
        let mut sheet = Sheet { nodes: vec![None; grid.cells()] };
        let mut tried = vec![false; grid.cells()];
        let first = grid.cell(film);
        let moved =
            self.node(starts, film, &seed).map_or(DVec2::ZERO, |node| node.by_film * (grid.middle(first) - film));
        let mut open = VecDeque::from([(first, seed.u + moved)]);
        while let Some((cell, start)) = open.pop_front() {
            if std::mem::replace(&mut tried[cell], true) {
                continue;
            }
            let film = grid.middle(cell);
            let family = Family::Pupil { film };
            let found = newton(self.world, self.index, &family, start, self.train, &starts.middle, starts.size);
            let Some(node) = found.and_then(|root| self.node(starts, film, &root)) else { continue };
            if node.useful {
                for next in grid.neighbours(cell).filter(|next| !tried[*next]) {
                    open.push_back((next, node.pupil + node.by_film * (grid.middle(next) - film)));
                }
            }
            sheet.nodes[cell] = Some(node);
        }
        sheet.curve(&grid);
        if sheet.nodes.iter().flatten().any(|node| node.useful) {
            starts.sheets.push(sheet);
        }
    }

    /// What there is to know of a solution for the middle of the lamp.
    fn node(&self, starts: &Starts, film: DVec2, root: &Root) -> Option<Node> {
        let radius = self.world.eye.pupil_radius_m();
        let family = Family::Film { pupil: root.u };
        let end = trace(self.world, self.index, &family, film, self.train, &starts.middle)?;
        let by_lamp = root.slope.inverse();
        let by_film = -by_lamp * end.slope;
        let half = starts.grid.half_cell();
        let moves = (by_film.x_axis * half.x).length() + (by_film.y_axis * half.y).length();
        let size = starts.size * (by_lamp.x_axis.length() + by_lamp.y_axis.length());
        let useful = root.u.length() <= 1.1 * radius + 1.2 * (moves + size);
        let flat = [DMat2::ZERO; 2];
        let node = Node { pupil: root.u, by_film, by_lamp, bend: flat, twist: flat, useful };
        (by_lamp.is_finite() && by_film.is_finite()).then_some(node)
    }
}

impl Sheet {
    /// Takes how derivatives change from the nodes beside each other.
    fn curve(&mut self, grid: &Grid) {
        let at = |nodes: &[Option<Node>], cell: usize| nodes[cell].map(|node| (node.by_film, node.by_lamp));
        for cell in 0..self.nodes.len() {
            let Some(here) = at(&self.nodes, cell) else { continue };
            let change = [0, 1].map(|axis| {
                let [low, high] = grid
                    .beside(cell, axis)
                    .map(|next| next.and_then(|next| Some((at(&self.nodes, next)?, grid.middle(next)[axis]))));
                let own = (here, grid.middle(cell)[axis]);
                let ((low, from), (high, to)) = (low.unwrap_or(own), high.unwrap_or(own));
                let step = (to - from).recip();
                if step.is_finite() { [(high.0 - low.0) * step, (high.1 - low.1) * step] } else { [DMat2::ZERO; 2] }
            });
            if let Some(node) = &mut self.nodes[cell] {
                (node.bend, node.twist) = (change.map(|[bend, _]| bend), change.map(|[_, twist]| twist));
            }
        }
    }
}

impl Node {
    /// The place in the pupil for a place in the picture and on the lamp, from the node's own.
    fn predict(&self, film: DVec2, lamp: DVec2) -> DVec2 {
        let by_film = self.by_film + (self.bend[0] * film.x + self.bend[1] * film.y) * 0.5;
        let by_lamp = self.by_lamp + self.twist[0] * film.x + self.twist[1] * film.y;
        self.pupil + by_film * film + by_lamp * lamp
    }
}

impl Starts {
    fn new(index: usize, lamp: &Lamp, grid: Grid) -> Starts {
        let middle = lamp.sample_point([0.5, 0.5]);
        let (centre, radius) = lamp.around();
        let middle = Target::new(centre, middle.normal);
        Starts { lamp: index, middle, size: radius, grid, sheets: Vec::new() }
    }

    /// The middle of the lamp, and its radius in metres.
    pub fn middle(&self) -> &Target {
        &self.middle
    }
    pub fn size(&self) -> f64 {
        self.size
    }
    /// Branches of the map.
    pub fn branches(&self) -> usize {
        self.sheets.len()
    }
    /// Where the solver starts for a place in the picture and the middle of the lamp, on one branch: from the nearest cells
    /// that know it.
    pub fn start(&self, branch: usize, film: DVec2) -> Option<DVec2> {
        let sheet = self.sheets.get(branch)?;
        let half = self.grid.half_cell();
        let around = [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)];
        around.into_iter().find_map(|(x, y)| {
            let cell = self.grid.cell(film + half * DVec2::new(0.5 * x, 0.5 * y));
            let node = sheet.nodes[cell].filter(|node| node.useful)?;
            Some(node.predict(film - self.grid.middle(cell), DVec2::ZERO))
        })
    }

    /// Whether light of the place in the picture may come this way.
    pub fn has(&self, cell: usize) -> bool {
        self.sheets.iter().any(|sheet| sheet.nodes[cell].is_some_and(|node| node.useful))
    }

    /// Adds the solutions for a place in the picture and a point of the lamp: a function of these alone. Returns how often it
    /// was solved for one.
    pub fn roots(
        &self,
        world: &World,
        index: &impl Fn(Option<u32>) -> f64,
        train: &Train,
        film: DVec2,
        target: &Target,
        out: &mut Vec<Root>,
    ) -> u64 {
        let first = out.len();
        let mut solved = 0;
        let cell = self.grid.cell(film);
        let off = self.middle.local(target.point - self.middle.point);
        for sheet in &self.sheets {
            let Some(node) = sheet.nodes[cell].filter(|node| node.useful) else { continue };
            let start = node.predict(film - self.grid.middle(cell), off);
            // A start so far outside of the pupil leads to nothing: the solver says so without trying.
            if start.length() > FAR * world.eye.pupil_radius_m() {
                continue;
            }
            let family = Family::Pupil { film };
            solved += 1;
            if let Some(root) = newton(world, index, &family, start, train, target, self.size) {
                let same = SAME * world.eye.pupil_radius_m();
                if !out[first..].iter().any(|other| other.u.distance(root.u) <= same) {
                    out.push(root);
                }
            }
        }
        solved
    }
}
