//! Cells over the picture, for what is looked up by a place in it.

use super::tuning::grid::{CELLS, FEWEST, PIXELS};
use eyebox_world::World;
use glam::DVec2;

/// Cells over the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    half: DVec2,
    count: [usize; 2],
}

impl Grid {
    pub fn of(world: &World) -> Grid {
        let half = world.eye.half();
        let longer = half.max_element();
        let cells = (world.eye.size().into_iter().max().unwrap_or(1) / PIXELS).clamp(FEWEST, CELLS);
        let along = |half: f64| ((cells as f64 * half / longer).ceil() as usize).clamp(1, cells);
        Grid { half, count: [along(half.x), along(half.y)] }
    }
    pub fn cells(&self) -> usize {
        self.count[0] * self.count[1]
    }
    /// The cell of a place; places outside belong to the nearest.
    pub fn cell(&self, film: DVec2) -> usize {
        let at = |x: f64, half: f64, count: usize| {
            let cell = (0.5 + 0.5 * x / half) * count as f64;
            (cell.max(0.0) as usize).min(count - 1)
        };
        at(film.y, self.half.y, self.count[1]) * self.count[0] + at(film.x, self.half.x, self.count[0])
    }
    pub fn middle(&self, cell: usize) -> DVec2 {
        let at = |index: usize, half: f64, count: usize| half * ((2 * index + 1) as f64 / count as f64 - 1.0);
        let [nx, ny] = self.count;
        DVec2::new(at(cell % nx, self.half.x, nx), at(cell / nx, self.half.y, ny))
    }
    pub fn half_cell(&self) -> DVec2 {
        self.half / DVec2::new(self.count[0] as f64, self.count[1] as f64)
    }
    /// The cells before and after one along an axis.
    pub fn beside(&self, cell: usize, axis: usize) -> [Option<usize>; 2] {
        let step = if axis == 0 { 1 } else { self.count[0] };
        let at = if axis == 0 { cell % self.count[0] } else { cell / self.count[0] };
        [(at > 0).then(|| cell - step), (at + 1 < self.count[axis]).then(|| cell + step)]
    }
    pub fn neighbours(&self, cell: usize) -> impl Iterator<Item = usize> + use<> {
        let [nx, ny] = self.count;
        let (x, y) = (cell % nx, cell / nx);
        let all = [(x.wrapping_sub(1), y), (x + 1, y), (x, y.wrapping_sub(1)), (x, y + 1)];
        all.into_iter().filter(move |(x, y)| *x < nx && *y < ny).map(move |(x, y)| y * nx + x)
    }
}
