//! Where the solver starts: per train and lamp, the solution for the middle of the lamp on a grid over the picture, with
//! its derivatives. A train whose map is folded has a sheet for each of its branches.

pub mod bands; // of wavelengths
pub mod connections;
pub mod edge_sampling;
mod extrapolate;
mod lamp_visibility;
mod tuning;

use crate::manifold::solver::grid::Grid;
use crate::manifold::solver::newton::{Family, Root, Target, newton, trace};
use eyebox_film::specular_chain::{Connection, SpecularChain};
use eyebox_world::World;
use eyebox_world::lamp::{Lamp, Lamps};
use glam::{DMat2, DVec2};
use lamp_visibility::Part;
use std::collections::VecDeque;
pub(super) use tuning::seeds::MOST_SHEETS;
pub use tuning::seeds::SAME;
use tuning::seeds::{AIMED, FAR};

/// The solution at the middle of a cell.
#[derive(Debug, Clone, Copy)]
struct Node {
    pupil: DVec2,
    by_film: DMat2,
    by_lamp: DMat2,
    /// How both change with the place in the picture, by its two coordinates.
    bend: [DMat2; 2],
    twist: [DMat2; 2],
    /// How far from the pupil's middle it may be for light of the cell and of all the lamp to cross the pupil.
    reach: f64,
    /// By how much what is foretold from here may err within the cell, m.
    unsure: f64,
}

/// One branch of the map from (picture, lamp) to the pupil.
#[derive(Debug, Clone)]
struct Sheet {
    nodes: Vec<Option<Node>>,
}

/// All branches of a train for one lamp.
#[derive(Debug, Clone)]
pub struct Seeds {
    /// Number of the lamp in the world.
    pub lamp: usize,
    middle: Target,
    /// Radius of the lamp, m.
    size: f64,
    grid: Grid,
    sheets: Vec<Sheet>,
    /// Of the lamp; none where its points are drawn evenly.
    parts: Vec<Part>,
}

/// What the tables are made with.
pub struct Builder<'b, I: Fn(Option<u32>) -> f64> {
    pub world: &'b World,
    pub index: &'b I,
    pub train: &'b SpecularChain,
}

impl<I: Fn(Option<u32>) -> f64> Builder<'_, I> {
    /// Starts for every lamp of the connection's group that its light comes from.
    pub fn starts(&self, connection: &Connection) -> Vec<Seeds> {
        let grid = Grid::of(self.world);
        let lamps = self.world.lamps.all().iter().enumerate();
        let lamps = lamps.filter(|(_, lamp)| lamp.group == connection.group && lamp.flux_lm > 0.0);
        let mut all: Vec<Seeds> = lamps.map(|(index, lamp)| Seeds::new(index, lamp, grid)).collect();
        for seed in &connection.seeds {
            if let Some(starts) = all.iter_mut().find(|starts| starts.lamp == seed.lamp as usize) {
                self.grow(starts, DVec2::from_array(seed.film), DVec2::from_array(seed.pupil));
            }
        }
        self.spread(&mut all);
        all.retain(|starts| !starts.sheets.is_empty());
        if connection.share >= AIMED {
            all.iter_mut().for_each(|starts| starts.take_apart(&self.world.lamps));
        }
        all
    }

    /// Adds the branch that has this solution, unless it is known.
    fn grow(&self, starts: &mut Seeds, film: DVec2, pupil: DVec2) {
        let radius = self.world.eye.pupil_radius_m();
        if starts.sheets.len() >= MOST_SHEETS {
            return;
        }
        let Some(seed) = self.solve(starts, film, pupil) else { return };
        // Solutions for one place are one, however far outside of the pupil a sheet says that it is.
        let solved = |sheet: &Sheet| {
            let cell = starts.grid.cell(film);
            self.solve(starts, film, sheet.nodes[cell]?.predict(film - starts.grid.middle(cell), DVec2::ZERO))
        };
        let same = |a: DVec2, b: DVec2| a.distance(b) <= SAME * radius;
        if starts.sheets.iter().filter_map(solved).any(|known| same(known.u, seed.u)) {
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
            let found = self.solve(starts, film, start);
            let Some(node) = found.and_then(|root| self.node(starts, film, &root)) else { continue };
            if node.is_useful() {
                for next in grid.neighbours(cell).filter(|next| !tried[*next]) {
                    open.push_back((next, node.pupil + node.by_film * (grid.middle(next) - film)));
                }
            }
            sheet.nodes[cell] = Some(node);
        }
        // A branch that was found from elsewhere: what of it is new is added. At folds two branches meet, and the solver goes over
        // from one to the other: what of both is known stays out, the rest is a branch.
        let alike: Vec<usize> = starts.sheets.iter().map(|known| sheet.strip(known, same)).collect();
        let new = sheet.nodes.iter().flatten().count();
        let known = starts.sheets.iter_mut().zip(alike).max_by_key(|(_, alike)| *alike);
        if let Some((known, _)) = known.filter(|(_, alike)| *alike > new) {
            sheet.hand_over(known);
            known.curve(&grid, starts.size);
        }
        sheet.curve(&grid, starts.size);
        if sheet.nodes.iter().flatten().any(Node::is_useful) {
            starts.sheets.push(sheet);
        }
    }

    /// The solution for the middle of the lamp at a place in the picture, from a start in the pupil.
    fn solve(&self, starts: &Seeds, film: DVec2, start: DVec2) -> Option<Root> {
        let family = Family::Pupil { film };
        newton(self.world, self.index, &family, start, self.train, &starts.middle, starts.size)
    }

    /// What there is to know of a solution for the middle of the lamp.
    fn node(&self, starts: &Seeds, film: DVec2, root: &Root) -> Option<Node> {
        let radius = self.world.eye.pupil_radius_m();
        let family = Family::Film { pupil: root.u };
        let end = trace(self.world, self.index, &family, film, self.train, &starts.middle)?;
        let by_lamp = root.slope.inverse();
        let by_film = -by_lamp * end.slope;
        let half = starts.grid.half_cell();
        let moves = (by_film.x_axis * half.x).length() + (by_film.y_axis * half.y).length();
        let size = starts.size * (by_lamp.x_axis.length() + by_lamp.y_axis.length());
        let reach = 1.1 * radius + 1.2 * (moves + size);
        let flat = [DMat2::ZERO; 2];
        let node = Node { pupil: root.u, by_film, by_lamp, bend: flat, twist: flat, reach, unsure: 0.0 };
        (by_lamp.is_finite() && by_film.is_finite()).then_some(node)
    }
}

impl Sheet {
    /// Takes out the nodes that another sheet has, too. Returns how many.
    fn strip(&mut self, known: &Sheet, same: impl Fn(DVec2, DVec2) -> bool) -> usize {
        let alike = self.nodes.iter_mut().zip(&known.nodes).filter_map(|(own, known)| {
            let (node, known) = ((*own)?, (*known)?);
            same(node.pupil, known.pupil).then(|| *own = None)
        });
        alike.count()
    }

    /// Gives its nodes to another sheet where that has none.
    fn hand_over(&mut self, known: &mut Sheet) {
        for (own, known) in self.nodes.iter_mut().zip(&mut known.nodes).filter(|(_, known)| known.is_none()) {
            *known = own.take();
        }
    }

    /// Takes how derivatives change from the nodes beside each other.
    fn curve(&mut self, grid: &Grid, size: f64) {
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
        for cell in 0..self.nodes.len() {
            let Some(here) = self.nodes[cell] else { continue };
            let missed = grid.neighbours(cell).filter_map(|next| {
                let foretold = here.predict(grid.middle(next) - grid.middle(cell), DVec2::ZERO);
                Some(foretold.distance(self.nodes[next]?.pupil))
            });
            // A corner of the cell is not farther than the next one's middle. Of the lamp only mixed derivatives are known: a step
            // on it is like one in the picture that moves the place in the pupil as far.
            let over_lamp = [DVec2::X, DVec2::Y].map(|axis| {
                let alike = here.by_film.inverse() * (here.by_lamp * axis);
                let twist = here.twist[0] * alike.x + here.twist[1] * alike.y;
                if twist.is_finite() { size.powi(2) * (twist * axis).length() } else { 0.0 }
            });
            let unsure = missed.fold(0.0, f64::max) + over_lamp.into_iter().fold(0.0, f64::max);
            if let Some(node) = &mut self.nodes[cell] {
                // Beyond a fold nothing is foretold.
                node.unsure = unsure.min(node.reach);
            }
        }
    }
}

impl Node {
    /// Light of the cell may cross the pupil.
    fn is_useful(&self) -> bool {
        self.pupil.length() <= self.reach
    }

    /// The place in the pupil for a place in the picture and on the lamp, from the node's own.
    fn predict(&self, film: DVec2, lamp: DVec2) -> DVec2 {
        let by_film = self.by_film + (self.bend[0] * film.x + self.bend[1] * film.y) * 0.5;
        self.pupil + by_film * film + self.by_lamp_at(film) * lamp
    }

    fn by_lamp_at(&self, film: DVec2) -> DMat2 {
        self.by_lamp + self.twist[0] * film.x + self.twist[1] * film.y
    }
}

impl Seeds {
    fn new(index: usize, lamp: &Lamp, grid: Grid) -> Seeds {
        let middle = lamp.sample_point([0.5, 0.5]);
        let (centre, radius) = lamp.around();
        let middle = Target::new(centre, middle.normal);
        Seeds { lamp: index, middle, size: radius, grid, sheets: Vec::new(), parts: Vec::new() }
    }

    fn take_apart(&mut self, lamps: &Lamps) {
        let middle = self.middle;
        self.parts = lamps
            .get(self.lamp)
            .map_or_else(Vec::new, |lamp| Part::of(lamp, |point| middle.local(point - middle.point)));
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
            let node = sheet.nodes[cell].filter(Node::is_useful)?;
            Some(node.predict(film - self.grid.middle(cell), DVec2::ZERO))
        })
    }

    /// Whether light of the place in the picture may come this way.
    pub fn has(&self, cell: usize) -> bool {
        self.useful(cell).next().is_some()
    }

    /// What the branches know of a cell.
    fn useful(&self, cell: usize) -> impl Iterator<Item = &Node> {
        self.sheets.iter().filter_map(move |sheet| sheet.nodes[cell].as_ref()).filter(|node| node.is_useful())
    }

    /// Adds the solutions for a place in the picture and a point of the lamp: a function of these alone. Returns how often it
    /// was solved for one.
    pub fn roots(
        &self,
        world: &World,
        index: &impl Fn(Option<u32>) -> f64,
        train: &SpecularChain,
        film: DVec2,
        target: &Target,
        out: &mut Vec<Root>,
    ) -> u64 {
        let first = out.len();
        let mut solved = 0;
        let cell = self.grid.cell(film);
        let off = self.middle.local(target.point - self.middle.point);
        for node in self.useful(cell) {
            let start = node.predict(film - self.grid.middle(cell), off);
            // A start so far outside of the pupil leads to nothing: the solver says so without trying.
            let far = FAR * world.eye.pupil_radius_m();
            if start.length() > far + node.unsure {
                continue;
            }
            let start = start.clamp_length_max(far);
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
