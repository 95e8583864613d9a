//! What a film keeps on request beyond the squares of its pixels: the squares of each layer, and of `open` and
//! `content` with their product, so that a picture mixed for another contrast can say how uncertain it is. Where light path
//! expressions part the light of a group, the squares of its whole share and of what each expression takes, too, and of each
//! part what another contrast changes of it.

use super::accumulate::light::Light;
use super::accumulate::plane::{PlaneKey, Together};
use super::layer::Layer;
use super::tiles::{Tiles, TilesRow};
use eyebox_base::ids::GroupId;
use eyebox_base::lpe;

/// Second moments of the light of one plane, sums over samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mixed {
    pub open2: f64,
    pub content2: f64,
    pub open_content: f64,
}

/// Sums of the entries of [`Mixed`] in their order.
const MIXED: usize = 3;

fn add(row: &mut TilesRow, (x, share): (usize, usize), light: Light) {
    let (open, content) = (light.open(), light.content());
    if open == 0.0 && content == 0.0 {
        return;
    }
    if let [open2, content2, open_content] = row.grown(x, share, MIXED) {
        open2.add(open * open);
        content2.add(content * content);
        open_content.add(open * content);
    }
}

/// The further sums of a film.
#[derive(Debug, Clone, PartialEq)]
pub struct LayerMoments {
    /// Light groups' shares of layers, each once, in the order of their first planes.
    shares: Vec<(Layer, GroupId)>,
    /// Plane → index in `shares`.
    of_plane: Vec<usize>,
    /// What squares are kept of.
    squared: Vec<Together>,
    /// Plane → indices in `squared`.
    squares_of: Vec<Vec<usize>>,
    /// `[pixel][share]`
    pub(super) mixed: Tiles,
    /// `[pixel][squared]`: squares of the `value` of planes together.
    pub(super) squares: Tiles,
    /// `[pixel][plane]`, where shares are parted: squares of `content` − `open`.
    pub(super) changes: Option<Tiles>,
}

/// One row of it.
pub struct LayerMomentsRow<'f> {
    of_plane: &'f [usize],
    squares_of: &'f [Vec<usize>],
    mixed: TilesRow<'f>,
    squares: TilesRow<'f>,
    changes: Option<TilesRow<'f>>,
    /// The light of each share in the pass under way.
    light: Vec<Light>,
    /// Luminance of what squares are kept of, in the pass under way.
    pass: Vec<f64>,
}

impl LayerMoments {
    pub fn new(size: [usize; 2], planes: &[PlaneKey]) -> Self {
        let mut layers: Vec<Layer> = planes.iter().map(|key| key.layer).collect();
        layers.sort_unstable();
        layers.dedup();
        let mut shares: Vec<(Layer, GroupId)> = Vec::new();
        for key in planes {
            if !shares.contains(&(key.layer, key.group)) {
                shares.push((key.layer, key.group));
            }
        }
        let mut squared: Vec<Together> = layers.into_iter().map(Together::Layer).collect();
        if shares.len() < planes.len() {
            // A plane is no longer a share: it has no squares of its own among those of planes.
            squared.extend(shares.iter().map(|(layer, group)| Together::Share(*layer, *group)));
        }
        let bits = (0..lpe::MOST as u32).map(Together::Taken);
        squared.extend(bits.filter(|taken| planes.iter().any(|key| taken.has(key))));
        let share = |key: &PlaneKey| shares.iter().position(|share| *share == (key.layer, key.group));
        let sums = |key: &PlaneKey| (0..squared.len()).filter(|index| squared[*index].has(key)).collect();
        LayerMoments {
            of_plane: planes.iter().filter_map(share).collect(),
            squares_of: planes.iter().map(sums).collect(),
            mixed: Tiles::new(size, shares.len(), MIXED),
            squares: Tiles::new(size, squared.len(), 1),
            changes: (shares.len() < planes.len()).then(|| Tiles::new(size, planes.len(), 1)),
            shares,
            squared,
        }
    }

    /// The rows, top to bottom.
    pub fn rows(&mut self) -> impl Iterator<Item = LayerMomentsRow<'_>> {
        let (of_plane, squares_of) = (self.of_plane.as_slice(), self.squares_of.as_slice());
        let (shares, squared) = (self.shares.len(), self.squared.len());
        let mut changes = self.changes.as_mut().map(Tiles::rows);
        self.mixed.rows().zip(self.squares.rows()).map(move |(mixed, squares)| LayerMomentsRow {
            changes: changes.as_mut().and_then(Iterator::next),
            of_plane,
            squares_of,
            mixed,
            squares,
            light: vec![Light::default(); shares],
            pass: vec![0.0; squared],
        })
    }

    /// Of a light group's share of a layer, if the film has it.
    pub fn mixed(&self, pixel: usize, share: (Layer, GroupId)) -> Option<Mixed> {
        let index = self.shares.iter().position(|own| *own == share)?;
        let [open2, content2, open_content] = [0, 1, 2].map(|at| self.mixed.sum(pixel, index * MIXED + at).value());
        Some(Mixed { open2, content2, open_content })
    }

    /// Sum of the squares of `content` − `open` of a plane among several of its share.
    pub fn change2(&self, pixel: usize, plane: usize) -> Option<f64> {
        Some(self.changes.as_ref()?.sum(pixel, plane).value())
    }

    /// Sum of the squares of planes together; none if it is not kept, since one plane alone is meant.
    pub fn square(&self, pixel: usize, together: Together) -> Option<f64> {
        let index = self.squared.iter().position(|own| *own == together)?;
        Some(self.squares.sum(pixel, index).value())
    }
}

impl LayerMomentsRow<'_> {
    /// Adds one pass's luminance of pixel `x` in one plane.
    pub fn add(&mut self, (x, plane): (usize, usize), light: Light) {
        let change = light.content() - light.open();
        if let Some(changes) = self.changes.as_mut().filter(|_| change != 0.0) {
            changes.grown(x, plane, 1)[0].add(change * change);
        }
        self.light[self.of_plane[plane]].add(light);
        self.squares_of[plane].iter().for_each(|index| self.pass[*index] += light.value);
    }

    /// After the last plane of the pass of pixel `x`.
    pub fn close(&mut self, x: usize) {
        for (share, light) in self.light.iter_mut().enumerate() {
            add(&mut self.mixed, (x, share), std::mem::take(light));
        }
        for (index, value) in self.pass.iter_mut().enumerate() {
            if *value != 0.0 {
                self.squares.grown(x, index, 1)[0].add(*value * *value);
            }
            *value = 0.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accumulate::{Components, Film, Sampling};

    const GROUP: GroupId = GroupId(0);
    const SHARE: (Layer, GroupId) = (Layer::Direct, GROUP);

    /// Light of a pass in a part of a share, with a slide on its way.
    fn light(pass: u64, part: u64) -> Light {
        let mut light = Light::ONE.scaled(((pass * 7 + part * 5) % 11) as f64);
        light.cross(0.9, 0.4, 0.1 * part as f64, 0.0);
        light
    }

    /// A share in three parts has the errors of a film that was given their sums, and so has what an expression takes.
    #[test]
    fn parts_together_have_the_errors_of_their_sum() {
        let key = |takes| PlaneKey { layer: SHARE.0, group: SHARE.1, takes };
        for sampling in [Sampling::PerPass, Sampling::PerScramble { paths: 64 }] {
            let film = |keys: Vec<PlaneKey>| Film::new(1, 1, keys, Components::Luminance, sampling).with_detail();
            let mut parted = film(vec![key(0), key(1), key(3)]);
            let (mut whole, mut taken, mut alone) = (film(vec![key(0)]), film(vec![key(0)]), film(vec![key(0)]));
            for pass in 0..16 {
                let parts = [0, 1, 2].map(|part| light(pass, part));
                let sum = |parts: &[Light]| {
                    let mut sum = Light::default();
                    parts.iter().for_each(|part| sum.add(*part));
                    [sum]
                };
                let (all, some) = (sum(&parts), sum(&parts[1..]));
                let films: [(&mut Film, &[Light]); 4] =
                    [(&mut parted, &parts), (&mut whole, &all), (&mut taken, &some), (&mut alone, &parts[1..2])];
                for (film, planes) in films {
                    match sampling {
                        Sampling::PerPass => film.rows().for_each(|(_, mut row)| row.add_pass(0, 0, planes)),
                        Sampling::PerScramble { .. } => planes.iter().enumerate().for_each(|(plane, light)| {
                            film.splat(0, plane, (pass % 8) as usize, &[*light]);
                        }),
                    }
                    film.passes += 1;
                }
            }
            let near = |a: f64, b: f64| assert!((a - b).abs() <= 1e-12 * b.abs() && b != 0.0, "{a} {b}");
            let of = |film: &Film, together| film.variance_of(0, together).expect("it is kept");
            let share = Together::Share(SHARE.0, SHARE.1);
            near(of(&parted, share), of(&whole, share));
            near(of(&parted, Together::Layer(SHARE.0)), of(&whole, share));
            near(of(&parted, Together::Taken(0)), of(&taken, share));
            near(of(&parted, Together::Taken(1)), parted.variance(0, 2));
            assert_eq!(parted.variance_of(0, Together::Taken(2)), None);
            let [a, b] = [&parted, &whole].map(|film| film.mix_error(0, SHARE).expect("it is kept"));
            near(a.open, b.open);
            near(a.content, b.content);
            near(a.covariance, b.covariance);
            let own = alone.mix_error(0, SHARE).expect("it is kept");
            near(parted.change_variance(0, 1).expect("it is kept"), own.open + own.content - 2.0 * own.covariance);
        }
    }
}
