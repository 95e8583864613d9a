//! What a film keeps on request beyond the squares of its pixels: the squares of each layer, and of `open` and
//! `content` with their product, so that a picture mixed for another contrast can say how uncertain it is.

use super::accumulate::{Light, PlaneKey};
use super::layer::Layer;
use crate::base::twofold::Sum;

/// Whose standard errors a run keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ErrorDetail {
    /// Of `hybrid` alone.
    #[default]
    Picture,
    /// Of every layer, of every group's share, and of its `open` and `content`.
    Layers,
}

/// Second moments of the light of one plane, sums over samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mixed {
    pub open2: f64,
    pub content2: f64,
    pub open_content: f64,
}

/// Sums of the entries of [`Mixed`] in their order.
pub(super) type MixedSum = [Sum; 3];

fn add([open2, content2, open_content]: &mut MixedSum, light: Light) {
    let (open, content) = (light.open(), light.content());
    open2.add(open * open);
    content2.add(content * content);
    open_content.add(open * content);
}

/// The further sums of a film.
#[derive(Debug, Clone, PartialEq)]
pub struct Detail {
    /// The layers of the film's planes, each once.
    pub layers: Vec<Layer>,
    /// Plane → index in `layers`.
    of_plane: Vec<usize>,
    /// `[pixel][plane]`
    pub(super) mixed: Vec<MixedSum>,
    /// `[pixel][layer]`: squares of a layer's `value`.
    pub(super) squares: Vec<Sum>,
}

/// One row of it.
pub struct DetailRow<'f> {
    of_plane: &'f [usize],
    layers: usize,
    mixed: &'f mut [MixedSum],
    squares: &'f mut [Sum],
    /// Luminance of each layer in the pass under way.
    pass: Vec<f64>,
}

impl Detail {
    pub fn new(pixels: usize, planes: &[PlaneKey]) -> Self {
        let mut layers: Vec<Layer> = planes.iter().map(|key| key.layer).collect();
        layers.sort_unstable();
        layers.dedup();
        let of_plane = planes.iter().filter_map(|key| layers.iter().position(|layer| *layer == key.layer)).collect();
        Detail {
            of_plane,
            mixed: vec![MixedSum::default(); pixels * planes.len()],
            squares: vec![Sum::ZERO; pixels * layers.len()],
            layers,
        }
    }

    /// The rows of a film that is `width` pixels wide.
    pub fn rows(&mut self, width: usize) -> impl Iterator<Item = DetailRow<'_>> {
        let (of_plane, layers) = (self.of_plane.as_slice(), self.layers.len());
        self.mixed
            .chunks_mut((width * of_plane.len()).max(1))
            .zip(self.squares.chunks_mut((width * layers).max(1)))
            .map(move |(mixed, squares)| DetailRow { of_plane, layers, mixed, squares, pass: vec![0.0; layers] })
    }

    pub fn mixed(&self, pixel: usize, plane: usize) -> Mixed {
        let [open2, content2, open_content] = self.mixed[pixel * self.of_plane.len() + plane].map(Sum::value);
        Mixed { open2, content2, open_content }
    }
    /// Sum of the squares of a layer, by its index in `layers`.
    pub fn square(&self, pixel: usize, layer: usize) -> f64 {
        self.squares[pixel * self.layers.len() + layer].value()
    }
    /// Planes of a layer, by its index in `layers`.
    pub fn planes_of(&self, layer: usize) -> impl Iterator<Item = usize> {
        self.of_plane.iter().enumerate().filter(move |(_, of)| **of == layer).map(|(plane, _)| plane)
    }
}

impl DetailRow<'_> {
    /// Adds one pass's luminance of pixel `x` in one plane.
    pub fn add(&mut self, x: usize, plane: usize, light: Light) {
        add(&mut self.mixed[x * self.of_plane.len() + plane], light);
        self.pass[self.of_plane[plane]] += light.value;
    }

    /// After the last plane of a pixel's pass.
    pub fn close(&mut self, x: usize) {
        for (layer, value) in self.pass.iter_mut().enumerate() {
            self.squares[x * self.layers + layer].add(*value * *value);
            *value = 0.0;
        }
    }
}
