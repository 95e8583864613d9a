//! Which part of the pupil is lit, and how sharp a picture through it can be.
//!
//! Diffraction knows the pupil by its transfer function: the autocorrelation of the amplitude at a lag, 1 at none
//! (J. W. Goodman, "Introduction to Fourier Optics", section 6.3). The amplitude is taken as the root of the density of
//! the light that arrives, in step over the lit region of one lamp. Lamps are not in step with each other: their transfer
//! functions are added, by the light of each.

use std::f64::consts::PI;

/// Where a path crossed the pupil.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// m to the right and up from the pupil's centre.
    pub at: [f64; 2],
    /// The place in the picture that it belongs to, 0 to 1 across and down.
    pub field: [f64; 2],
    /// What it brought; any unit.
    pub light: f64,
    /// The same with all slides open.
    pub open: f64,
}

/// The lit part of the pupil as cells of constant amplitude.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Aperture {
    side: usize,
    /// Width and height of a cell, m.
    cell_m: [f64; 2],
    /// Autocorrelation at whole lags, `2·side − 1` per row, 1 at lag 0.
    correlation: Vec<f64>,
    /// (∫A)²/∫A², m²: the area of an evenly lit region.
    area_m2: f64,
    /// Standard deviation of the places along both axes, weighted by light, m.
    rms_m: [f64; 2],
}

/// What a light group has of the pupil.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum Pupil {
    /// A pinhole, which no ray tells the size of.
    Point,
    /// All of it, evenly.
    Disc { diameter_m: f64 },
    /// Parts of it: the share of the light and the region of each lamp.
    Lit(Vec<(f64, Aperture)>),
}

impl Aperture {
    /// Most cells along an axis.
    const MOST: usize = 64;
    /// Paths per cell, so that noise is no structure.
    const PER_CELL: usize = 16;
    /// The box of cells spans these quantiles of the light along each axis and `MARGIN` of their distance on each side;
    /// stray light beyond is left out.
    const QUANTILES: [f64; 2] = [0.05, 0.95];
    const MARGIN: f64 = 0.2;
    /// Paths per tile of the picture, and most tiles along an axis.
    const PER_TILE: usize = 256;
    const MOST_TILES: usize = 16;

    /// The region that the crossings of one lamp tell of, as it is for a place in the picture: where it lies in the pupil
    /// may change over the picture, and has no part in what it spreads. None if they are too few or all in one line.
    pub fn of(crossings: &[Crossing]) -> Option<Aperture> {
        Self::of_aligned(&aligned(crossings))
    }

    fn of_aligned(crossings: &[Crossing]) -> Option<Aperture> {
        let side = ((crossings.len() / Self::PER_CELL) as f64).sqrt() as usize;
        if side < 4 {
            return None;
        }
        let side = side.min(Self::MOST);
        let ranges = [span(crossings, 0)?, span(crossings, 1)?];
        let cell_m = ranges.map(|[low, high]| (high - low) / side as f64);
        if !cell_m.iter().all(|cell| cell.is_normal() && *cell > 0.0) {
            return None;
        }
        let mut light = vec![0.0; side * side];
        let (mut sum, mut first, mut second) = (0.0, [0.0; 2], [0.0; 2]);
        for crossing in crossings {
            let place: [f64; 2] = std::array::from_fn(|k| (crossing.at[k] - ranges[k][0]) / cell_m[k]);
            if !place.iter().all(|p| (0.0..side as f64).contains(p)) {
                continue;
            }
            light[place[1] as usize * side + place[0] as usize] += crossing.light;
            sum += crossing.light;
            for k in 0..2 {
                first[k] += crossing.light * place[k];
                second[k] += crossing.light * place[k] * place[k];
            }
        }
        let rms_m = std::array::from_fn(|k| (second[k] / sum - (first[k] / sum).powi(2)).max(0.0).sqrt() * cell_m[k]);
        let amplitude = amplitude(&light, side);
        let whole: f64 = amplitude.iter().sum();
        let square: f64 = amplitude.iter().map(|a| a * a).sum();
        let area_m2 = whole * whole / square * cell_m[0] * cell_m[1];
        let correlation = correlate(&amplitude, side, square);
        (area_m2.is_normal() && correlation.iter().all(|c| c.is_finite())).then_some(Aperture {
            side,
            cell_m,
            correlation,
            area_m2,
            rms_m,
        })
    }

    /// The autocorrelation of cells of constant amplitude is linear in each axis between whole lags.
    fn transfer(&self, lag_m: [f64; 2]) -> f64 {
        // A region may come from a file.
        if !(1..=Self::MOST).contains(&self.side) {
            return 0.0;
        }
        let width = 2 * self.side - 1;
        let lag: [f64; 2] = std::array::from_fn(|k| lag_m[k] / self.cell_m[k]);
        if !lag.iter().all(|lag| lag.abs() < self.side as f64) {
            return 0.0;
        }
        let [x, y] = lag.map(f64::floor);
        let [u, v] = [lag[0] - x, lag[1] - y];
        let middle = self.side as isize - 1;
        let at = |dx: isize, dy: isize| {
            let (i, j) = (x as isize + dx + middle, y as isize + dy + middle);
            let inside = (0..width as isize).contains(&i) && (0..width as isize).contains(&j);
            let lag = if inside { self.correlation.get(j as usize * width + i as usize) } else { None };
            lag.copied().unwrap_or(0.0)
        };
        (1.0 - v) * ((1.0 - u) * at(0, 0) + u * at(1, 0)) + v * ((1.0 - u) * at(0, 1) + u * at(1, 1))
    }
}

/// The crossings of each tile of the picture, moved so that the tile's median is at 0.
fn aligned(crossings: &[Crossing]) -> Vec<Crossing> {
    let tiles = ((crossings.len() / Aperture::PER_TILE) as f64).sqrt() as usize;
    let tiles = tiles.clamp(1, Aperture::MOST_TILES);
    let mut of_tile = vec![Vec::new(); tiles * tiles];
    for crossing in crossings {
        let [x, y] = crossing.field.map(|place| ((place * tiles as f64) as usize).min(tiles - 1));
        of_tile[y * tiles + x].push(*crossing);
    }
    for tile in &mut of_tile {
        let middle = [0, 1].map(|axis| quantiles(tile, axis, [0.5]).map_or(0.0, |[median]| median));
        tile.iter_mut().for_each(|crossing| (0..2).for_each(|k| crossing.at[k] -= middle[k]));
    }
    of_tile.concat()
}

/// Where the cells begin and end along an axis.
fn span(crossings: &[Crossing], axis: usize) -> Option<[f64; 2]> {
    let [low, high] = quantiles(crossings, axis, Aperture::QUANTILES)?;
    let margin = Aperture::MARGIN * (high - low);
    Some([low - margin, high + margin])
}

/// Quantiles of the light along an axis; none if there is no light, or a number is not finite.
fn quantiles<const N: usize>(crossings: &[Crossing], axis: usize, shares: [f64; N]) -> Option<[f64; N]> {
    let mut sorted: Vec<(f64, f64)> = crossings.iter().map(|c| (c.at[axis], c.light)).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let total: f64 = sorted.iter().map(|(_, light)| light).sum();
    let mut found = [0.0; N];
    for (to, share) in found.iter_mut().zip(shares) {
        let mut sum = 0.0;
        let reached = |(_, light): &&(f64, f64)| {
            sum += light;
            sum >= share * total
        };
        *to = sorted.iter().find(reached)?.0;
    }
    found.iter().all(|place| place.is_finite()).then_some(found)
}

/// The root of the density; a cell that an edge cuts has its share of what is beside it, since the mean of an amplitude
/// over a cell is less than the root of the mean of its square. What is beside a cell: the largest mean of 3 × 3 cells up
/// to two cells away.
fn amplitude(light: &[f64], side: usize) -> Vec<f64> {
    let around = |at: usize, reach: usize| at.saturating_sub(reach)..(at + reach + 1).min(side);
    let window = |x: usize, y: usize, reach: usize| {
        around(y, reach).flat_map(move |j| around(x, reach).map(move |i| j * side + i))
    };
    let places = || (0..side).flat_map(|y| (0..side).map(move |x| (x, y)));
    let mean = |(x, y): (usize, usize)| window(x, y, 1).map(|cell| light[cell]).sum::<f64>() / 9.0;
    let means: Vec<f64> = places().map(mean).collect();
    let beside = |(x, y): (usize, usize)| window(x, y, 2).map(|cell| means[cell]).fold(0.0, f64::max);
    let of = |(x, y): (usize, usize)| {
        let beside = beside((x, y));
        let whole = |reach: usize| {
            let inside = x.min(y) >= reach && x.max(y) + reach < side;
            inside && window(x, y, reach).all(|cell| light[cell] > 0.5 * beside)
        };
        // Away from edges neighbours tell more than one cell: what is left of the noise would spread light far.
        let reach = [2, 1].into_iter().find(|reach| whole(*reach)).unwrap_or(0);
        let cells = (2 * reach + 1) * (2 * reach + 1);
        let own = window(x, y, reach).map(|cell| light[cell]).sum::<f64>() / cells as f64;
        if own > 0.0 { own / beside.sqrt() } else { 0.0 }
    };
    places().map(of).collect()
}

/// The autocorrelation of `side` × `side` cells over `sum`, the sum of their squares.
fn correlate(amplitude: &[f64], side: usize, sum: f64) -> Vec<f64> {
    let width = 2 * side - 1;
    let mut out = vec![0.0; width * width];
    for dy in 0..side {
        for lag_x in 0..width {
            let dx = lag_x as isize - (side as isize - 1);
            let (from, to) = ((-dx).max(0) as usize, (side as isize - dx.max(0)) as usize);
            let mut value = 0.0;
            for y in 0..side - dy {
                let near = &amplitude[y * side..(y + 1) * side];
                let far = &amplitude[(y + dy) * side..(y + dy + 1) * side];
                let shifted = far[(from as isize + dx) as usize..(to as isize + dx) as usize].iter();
                value += near[from..to].iter().zip(shifted).map(|(a, b)| a * b).sum::<f64>();
            }
            // R(−s) = R(s).
            out[(side - 1 + dy) * width + lag_x] = value / sum;
            out[(side - 1 - dy) * width + (width - 1 - lag_x)] = value / sum;
        }
    }
    out
}

impl Pupil {
    /// The whole pupil; a point if it has no diameter.
    pub fn full(diameter_m: f64) -> Pupil {
        if diameter_m > 0.0 { Pupil::Disc { diameter_m } } else { Pupil::Point }
    }

    /// The transfer function at a lag in the pupil, m; 1 at none.
    pub fn transfer(&self, lag_m: [f64; 2]) -> f64 {
        match self {
            Pupil::Point => 1.0,
            Pupil::Disc { diameter_m } => {
                // Two discs' overlap (Goodman, section 6.3.2).
                let x = (lag_m[0].hypot(lag_m[1]) / diameter_m).min(1.0);
                (x.acos() - x * (1.0 - x * x).max(0.0).sqrt()) * 2.0 / PI
            }
            Pupil::Lit(regions) => regions.iter().map(|(share, region)| share * region.transfer(lag_m)).sum(),
        }
    }

    /// The largest lags along both axes at which anything is transferred, m.
    pub fn reach_m(&self) -> [f64; 2] {
        match self {
            Pupil::Point => [f64::INFINITY; 2],
            Pupil::Disc { diameter_m } => [*diameter_m; 2],
            Pupil::Lit(regions) => regions.iter().fold([0.0; 2], |most, (_, region)| {
                std::array::from_fn(|k| most[k].max(region.side as f64 * region.cell_m[k]))
            }),
        }
    }

    /// The lit area, m²: λ²/area is the solid angle into which diffraction spreads a point, flux over peak.
    pub fn area_m2(&self) -> f64 {
        match self {
            Pupil::Point => 0.0,
            Pupil::Disc { diameter_m } => PI * diameter_m * diameter_m / 4.0,
            Pupil::Lit(regions) => regions.iter().map(|(share, region)| share * region.area_m2).sum(),
        }
    }

    /// Standard deviation of the lit places along both axes, m.
    pub fn rms_m(&self) -> [f64; 2] {
        match self {
            Pupil::Point => [0.0; 2],
            Pupil::Disc { diameter_m } => [diameter_m / 4.0; 2],
            Pupil::Lit(regions) => std::array::from_fn(|k| {
                regions.iter().map(|(share, region)| share * region.rms_m[k] * region.rms_m[k]).sum::<f64>().sqrt()
            }),
        }
    }
}
