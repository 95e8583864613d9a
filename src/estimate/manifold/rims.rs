//! How often the pixels of a picture are joined with lamps in a pass: where a lamp is seen whole, once is enough. At the rim
//! of its picture few places of a pixel and few points of the lamp are joined through the pupil, and most of the picture's
//! error is there.

use super::connections::Connections;
use crate::world::World;
use crate::world::eye::EyeLens;
use glam::DVec2;
use rayon::prelude::*;

/// Most times.
const MOST: f64 = 32.0;
/// Relative variance of a pixel that sees its lamps whole: it holds edges of the slides' pictures.
const USUAL: f64 = 0.1;
/// A pixel with less than this share of the light that is there where all lamps are seen whole is dark: its error counts by
/// that.
const DARK: f64 = 0.01;

/// How often each pixel is joined.
#[derive(Debug)]
pub struct Rims {
    /// By pixel; nothing where all are joined once.
    times: Vec<u8>,
}

impl Rims {
    pub fn new(world: &World, connections: &Connections) -> Rims {
        let Some(grid) = connections.grid() else { return Rims { times: Vec::new() } };
        let eye = &world.eye;
        let of_cell = |cell: usize| times(connections, eye, grid.middle(cell), grid.half_cell()) > 1.0;
        let at_rim: Vec<bool> = (0..grid.cells()).map(of_cell).collect();
        if !at_rim.contains(&true) {
            return Rims { times: Vec::new() };
        }
        let [width, height] = eye.size();
        let half = 0.5 * DVec2::from_array(eye.pixel());
        let of_pixel = |index: usize| {
            let film = eye.film_of(index % width, index / width, [0.5; 2]);
            if at_rim[grid.cell(film)] { times(connections, eye, film, half).round() as u8 } else { 1 }
        };
        Rims { times: (0..width * height).into_par_iter().map(of_pixel).collect() }
    }

    /// How often a pixel, by its row-major index, is joined in a pass.
    pub fn times(&self, pixel: u64) -> u64 {
        self.times.get(pixel as usize).map_or(1, |times| (*times).max(1).into())
    }
}

/// Work is spent best in proportion to the standard deviation of what it brings, relative to what is there. `half`: of the
/// sides of a place in the picture.
fn times(connections: &Connections, eye: &EyeLens, film: DVec2, half: DVec2) -> f64 {
    let (mut variance, mut mean, mut whole) = (0.0, 0.0, 0.0);
    for (_, entry) in connections.at(film) {
        let Some((shown, fills)) = entry.starts.shown(film, half, eye) else { continue };
        let brings = connections.share(entry) * fills.min(1.0);
        variance += brings.powi(2) * shown * (1.0 - shown);
        mean += brings * shown;
        whole += brings;
    }
    let times = (variance / (mean.powi(2) + (DARK * whole).powi(2)) / USUAL).sqrt();
    if times.is_finite() { times.clamp(1.0, MOST) } else { 1.0 }
}
