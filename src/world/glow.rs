//! Emission textures: what each place of a lamp has of its light.

use super::texture::{place, read, read_texel};
use eyebox_base::colour::luminance;
use eyebox_base::warp;
use eyebox_scene::texture::{Filter, Texels, TextureInput};
use eyebox_scene::{Emitter, Part, Scene};
use glam::DVec2;

/// Places of a triangle at which its mean is taken, and of all triangles together at most.
const PLACES: [usize; 2] = [16, 1 << 16];

/// The least mean of a texture that is not black, of its brightest texel: a light too small for all the places is still one.
const LEAST: f64 = 1e-4;

/// An emission texture on the triangles of a lamp.
#[derive(Debug, Clone)]
pub struct Glow {
    input: TextureInput,
    /// Texture coordinates of the corners, per triangle of the lamp.
    corners: Vec<[[f64; 2]; 3]>,
    mean: f64,
}

/// The largest luminance of a texture's texels.
fn brightest_of(input: &TextureInput) -> f64 {
    let (width, height) = (input.texture.width, input.texture.height);
    let plain = TextureInput {
        filter: Filter::Nearest,
        to_picture: [[1.0 / width as f64, 0.0, 0.0], [0.0, 1.0 / height as f64, 0.0]],
        ..input.clone()
    };
    let texels = (0..width * height).map(|i| read(&plain, [(i % width) as f64 + 0.5, (i / width) as f64 + 0.5]));
    texels.map(|[r, g, b, _]| luminance([r, g, b])).fold(0.0, f64::max)
}

/// Places of triangles of these areas at which means are taken: the number of the triangle, the shares of its corners, its area.
pub fn places(areas: &[f64]) -> impl Iterator<Item = (usize, [f64; 3], f64)> + '_ {
    let each = (PLACES[1] / areas.len().max(1)).clamp(1, PLACES[0]);
    areas.iter().enumerate().flat_map(move |(at, area)| {
        (0..each).map(move |place| {
            // Points of the golden ratio's lattice.
            let row = (place as f64 + 0.5) / each as f64;
            let turn = ((at * each + place) as f64 * 0.618_033_988_749_894_9).fract();
            let [u, v, w] = warp::triangle([row, turn]);
            (at, [w, u, v], *area)
        })
    })
}

impl Glow {
    /// None where the light has no texture.
    pub fn build(
        scene: &Scene,
        part: &Part,
        emitter: &Emitter,
        triangles: impl Iterator<Item = u32>,
    ) -> Option<Box<Glow>> {
        let surface = scene.surfaces.get(emitter.pattern?.index())?;
        let input = surface.emission.clone()?;
        let mesh = scene.meshes.get(part.mesh.index())?;
        let set = if input.set > 0 { &mesh.second_uvs } else { &mesh.uvs };
        let corner = |vertex: u32| set.get(vertex as usize).map_or([0.0; 2], |uv| uv.map(f64::from));
        let (mut corners, mut areas) = (Vec::new(), Vec::new());
        for index in triangles {
            let vertices = *mesh.triangles.get(index as usize)?;
            corners.push(vertices.map(corner));
            let [a, b, c] = vertices.map(|v| {
                mesh.positions.get(v as usize).map_or(glam::DVec3::ZERO, |p| glam::DVec3::from(p.map(f64::from)))
            });
            areas.push((b - a).cross(c - a).length());
        }
        let mut glow = Glow { input, corners, mean: 1.0 };
        glow.mean = glow.mean_of(&areas);
        Some(Box::new(glow))
    }

    fn mean_of(&self, areas: &[f64]) -> f64 {
        let (mut sum, mut whole, mut brightest) = (0.0, 0.0, 0.0f64);
        for (at, weights, area) in places(areas) {
            let found = luminance(self.texel(at, weights));
            (sum, whole, brightest) = (sum + found * area, whole + area, brightest.max(found));
        }
        let mean = if whole > 0.0 { sum / whole } else { 0.0 };
        let possible = match self.input.texture.texels {
            Texels::Bytes(_) | Texels::Encoded(_) => 1.0,
            Texels::Floats(_) => f64::INFINITY,
        };
        if mean > LEAST * possible { mean } else { mean.max(LEAST * brightest.max(brightest_of(&self.input))) }
    }

    fn coordinates(&self, at: usize, weights: [f64; 3]) -> [f64; 2] {
        let corners = self.corners[at];
        [0, 1].map(|c| (0..3).map(|i| weights[i] * corners[i][c]).sum())
    }

    fn texel(&self, at: usize, weights: [f64; 3]) -> [f64; 3] {
        let [r, g, b, _] = read(&self.input, self.coordinates(at, weights));
        [r, g, b].map(|c: f64| c.max(0.0))
    }

    /// Luminance of the whole, of a white texture's.
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// Linear Rec.709 at shares of the corners of triangle `at` of the lamp, over the mean's luminance.
    pub fn at(&self, at: usize, weights: [f64; 3]) -> [f64; 3] {
        if self.mean > 0.0 { self.texel(at, weights).map(|c| c / self.mean) } else { [0.0; 3] }
    }

    /// Where shares of the corners of triangle `at` lie in the texture, in columns and rows of its texels.
    pub fn place(&self, at: usize, weights: [f64; 3]) -> DVec2 {
        place(&self.input, self.coordinates(at, weights)).into()
    }

    /// Whether it is linear between the middles of texels, not even over each.
    pub fn is_smooth(&self) -> bool {
        match self.input.filter {
            Filter::Nearest => false,
            Filter::Linear => true,
        }
    }

    /// As [`Glow::at`], of a texel, by its whole column and row, in the texture or beyond it.
    pub fn of_texel(&self, at: [f64; 2]) -> [f64; 3] {
        let [r, g, b, _] = read_texel(&self.input, at);
        if self.mean > 0.0 { [r, g, b].map(|c| c.max(0.0) / self.mean) } else { [0.0; 3] }
    }
}
