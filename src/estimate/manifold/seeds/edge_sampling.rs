//! How often the pixels of a picture are joined with lamps in a pass: where a lamp is seen whole, once is enough. At the rim
//! of its picture few places of a pixel and few points of the lamp are joined through the pupil, and most of the picture's
//! error is there.

use super::connections::Connections;
use super::tuning::edge_sampling::{DARK, MOST, UNSURE, USUAL};
use eyebox_base::parallel;
use eyebox_world::World;
use eyebox_world::eye::EyeLens;
use glam::DVec2;

/// How often each pixel is joined.
#[derive(Debug)]
pub struct EdgeSampling {
    /// By pixel; nothing where all are joined once.
    times: Vec<u8>,
}

impl EdgeSampling {
    pub fn new(world: &World, connections: &Connections) -> EdgeSampling {
        let Some(grid) = connections.grid() else { return EdgeSampling { times: Vec::new() } };
        let eye = &world.eye;
        let half = 0.5 * DVec2::from_array(eye.pixel());
        // Pixels whose middle is there, and about them.
        let beside = UNSURE * half;
        let of_cell =
            |cell: usize| Sums::new(connections, eye, grid.middle(cell), grid.half_cell() + beside).variance > 0.0;
        let at_rim: Vec<bool> = (0..grid.cells()).map(of_cell).collect();
        if !at_rim.contains(&true) {
            return EdgeSampling { times: Vec::new() };
        }
        let [width, height] = eye.size();
        let of_pixel = |index: usize| {
            let film = eye.film_of(index % width, index / width, [0.5; 2]);
            let times = |half: DVec2| Sums::new(connections, eye, film, half).times();
            if at_rim[grid.cell(film)] { times(half).max(times(beside)).round() as u8 } else { 1 }
        };
        EdgeSampling { times: parallel::map(width * height, &of_pixel) }
    }

    /// How often a pixel, by its row-major index, is joined in a pass.
    pub fn times(&self, pixel: u64) -> u64 {
        self.times.get(pixel as usize).map_or(1, |times| (*times).max(1).into())
    }
}

/// What all lamps bring to a place in the picture, in units of a lamp whose picture fills the pupil.
#[derive(Default)]
struct Sums {
    variance: f64,
    mean: f64,
    /// What there would be if all were seen whole, over trains with all light of their group.
    whole: f64,
}

impl Sums {
    /// `half`: of the sides of the place.
    fn new(connections: &Connections, eye: &EyeLens, film: DVec2, half: DVec2) -> Sums {
        let (mut sums, mut best) = (Sums::default(), 0.0f64);
        for (_, entry) in connections.at(film) {
            let Some((shown, fills)) = entry.starts.shown(film, half, eye) else { continue };
            let brings = entry.share * fills.min(1.0);
            sums.variance += brings.powi(2) * shown * (1.0 - shown);
            sums.mean += brings * shown;
            sums.whole += brings;
            best = best.max(entry.share);
        }
        Sums { whole: sums.whole / best, ..sums }
    }

    /// Work is spent best in proportion to the standard deviation of what it brings, relative to what is there.
    fn times(&self) -> f64 {
        let times = (self.variance / (self.mean.powi(2) + (DARK * self.whole).powi(2)) / USUAL).sqrt();
        if times.is_finite() { times.clamp(1.0, MOST) } else { 1.0 }
    }
}
