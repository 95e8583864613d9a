//! Nodes over the picture, for tables of what changes little from pixel to pixel.

use super::solver::bicubic::{Nodes, Spot};
use super::tuning::film_grid::{CELLS, FEWEST, PIXELS};
use eyebox_world::World;
use glam::DVec2;

/// A grid over the picture.
#[derive(Debug, Clone, Copy)]
pub struct FilmGrid {
    pub nodes: Nodes,
    half: DVec2,
    /// Pixels along a cell.
    pub pixels: f64,
}

impl FilmGrid {
    /// None where tables would not pay.
    pub fn new(world: &World) -> Option<FilmGrid> {
        let [width, height] = world.eye.size();
        FilmGrid::with_cells(world, width.max(height), CELLS)
    }

    /// A coarse one for a pilot's small picture of one whose longer side has so many pixels, where that one has tables.
    pub fn coarse(world: &World, longer: usize) -> Option<FilmGrid> {
        FilmGrid::with_cells(world, longer, FEWEST)
    }

    fn with_cells(world: &World, longer: usize, most: usize) -> Option<FilmGrid> {
        let cells = (longer / PIXELS).min(most);
        if cells < FEWEST {
            return None;
        }
        let half = world.eye.half();
        let along = |half: f64, longer: f64| ((cells as f64 * half / longer).ceil() as usize).clamp(3, cells) + 1;
        let nodes = Nodes { count: half.to_array().map(|side| along(side, half.max_element())) };
        Some(FilmGrid { nodes, half, pixels: longer as f64 / cells as f64 })
    }

    fn cells(&self) -> DVec2 {
        let [nx, ny] = self.nodes.count.map(|count| (count - 1) as f64);
        DVec2::new(nx, ny)
    }

    /// Cells from one pixel to the next, to the right and down.
    pub fn by_pixel(&self, world: &World) -> DVec2 {
        let [width, height] = world.eye.size();
        self.cells() * DVec2::new(1.0 / width as f64, -1.0 / height as f64)
    }

    /// Where a place in the picture (tangents) lies among the nodes.
    pub fn spot(&self, film: DVec2) -> Option<Spot> {
        self.nodes.spot((film / self.half * 0.5 + 0.5) * self.cells())
    }

    /// The place in the picture at fractional node coordinates.
    pub fn film(&self, at: DVec2) -> DVec2 {
        (at / self.cells() * 2.0 - 1.0) * self.half
    }

    /// The place in the picture at a share of its width and height.
    pub fn film_at(&self, share: DVec2) -> DVec2 {
        (2.0 * share - 1.0) * self.half
    }
}
