//! Guided aperture as data: through which part of the pupil each part of the picture sees lamps.

use super::learn::{Even, Weighted, grow};
use super::tree::{AXES, Point, Tree};
use serde::{Deserialize, Serialize};

/// Densities over the pupil, one for each tile of the picture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Data", into = "Data")]
pub struct ApertureGuide {
    tiles: [usize; 2],
    /// Row by row. The last two axes are the pupil: [`eyebox_base::warp::disk`] makes a point of it of them.
    trees: Vec<Tree>,
}

#[derive(Serialize, Deserialize)]
struct Data {
    tiles: [usize; 2],
    trees: Vec<Tree>,
}

/// Where light from a lamp has crossed the pupil.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lit {
    /// Its place in the picture, 0 to 1 across and down.
    pub field: [f64; 2],
    /// Its place in the unit square that becomes the pupil.
    pub pupil: [f64; 2],
    /// What it brought; any unit.
    pub weight: f64,
}

/// First axis of the pupil.
const PUPIL: usize = 2;
/// Tiles along either side of the picture.
const TILES: usize = 8;
/// A tile learns from the crossings nearest to it: this part of all, which is less where many are known.
const NEAREST: usize = 512;
const OF_ALL: usize = 32;
/// Fewest crossings to learn from.
const FEWEST: usize = 64;
/// Most boxes of a tree.
const LEAVES: usize = 256;

impl ApertureGuide {
    /// None if there are too few crossings.
    pub fn learn(crossings: &[Lit]) -> Option<ApertureGuide> {
        let lit: Vec<Lit> = crossings.iter().copied().filter(|lit| lit.weight > 0.0).collect();
        if lit.len() < FEWEST {
            return None;
        }
        let nearest = NEAREST.max(lit.len() / OF_ALL).min(lit.len());
        let tree = |middle: [f64; 2]| {
            let apart = |lit: &Lit| (lit.field[0] - middle[0]).powi(2) + (lit.field[1] - middle[1]).powi(2);
            let mut near = lit.clone();
            near.select_nth_unstable_by(nearest - 1, |a, b| apart(a).total_cmp(&apart(b)));
            let point = |lit: &Lit| -> Point { [0.5, 0.5, lit.pupil[0], lit.pupil[1]] };
            let mut points: Vec<Weighted> =
                near[..nearest].iter().map(|lit| Weighted { x: point(lit), weight: lit.weight }).collect();
            grow(&mut points, PUPIL..AXES, LEAVES, Even::MANY)
        };
        let middle = |tile: usize| (tile as f64 + 0.5) / TILES as f64;
        let trees = (0..TILES * TILES).map(|tile| tree([middle(tile % TILES), middle(tile / TILES)])).collect();
        Some(ApertureGuide { tiles: [TILES; 2], trees })
    }

    /// The point that `u` in the unit square becomes for a place in the picture (0 to 1 across and down), and its density.
    pub fn draw(&self, field: [f64; 2], [u, v]: [f64; 2]) -> ([f64; 2], f64) {
        let ([.., u, v], density) = self.tree(field).draw([0.5, 0.5, u, v]);
        ([u, v], density)
    }

    /// The density of such a point.
    pub fn density(&self, field: [f64; 2], [u, v]: [f64; 2]) -> f64 {
        self.tree(field).density(&[0.5, 0.5, u, v])
    }

    /// Mean density where light crosses: how many times fewer points miss the lamps.
    pub fn gain(&self, crossings: &[Lit]) -> f64 {
        let at = |lit: &Lit| self.density(lit.field, lit.pupil);
        let sums = crossings.iter().fold((0.0, 0.0), |(sum, all), lit| (sum + lit.weight * at(lit), all + lit.weight));
        sums.0 / sums.1
    }

    fn tree(&self, field: [f64; 2]) -> &Tree {
        let tile = |axis: usize| ((field[axis] * self.tiles[axis] as f64) as usize).min(self.tiles[axis] - 1);
        &self.trees[tile(1) * self.tiles[0] + tile(0)]
    }
}

impl From<ApertureGuide> for Data {
    fn from(guide: ApertureGuide) -> Data {
        Data { tiles: guide.tiles, trees: guide.trees }
    }
}

impl TryFrom<Data> for ApertureGuide {
    type Error = String;

    /// Errors: no tree for each tile, trees that are cut across other axes than the pupil's.
    fn try_from(data: Data) -> Result<ApertureGuide, String> {
        let [across, down] = data.tiles;
        if across == 0 || down == 0 || across.checked_mul(down) != Some(data.trees.len()) {
            return Err(format!("a guide of the pupil has {} trees for {across} x {down} tiles", data.trees.len()));
        }
        if data.trees.iter().any(|tree| tree.is_cut_before(PUPIL)) {
            return Err("a guide of the pupil has a tree that is cut across what is no pupil".to_owned());
        }
        Ok(ApertureGuide { tiles: data.tiles, trees: data.trees })
    }
}
