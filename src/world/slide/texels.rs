//! What a lamp's emission texture has of its light over a small area: the picture is cut into texels or, where it is linear between
//! their middles, into the cells between these, and each is integrated exactly.

use super::footprint::{Brightness, Lines, Polygon};
use crate::World;
use crate::glow::Glow;
use crate::mode::{Mode, lanes};
use crate::optics::Optics;
use glam::DVec2;
use std::iter::successors;

/// A square that may see more texels is not cut.
const MOST_TEXELS: f64 = 4096.0;

/// Where the points of the square see a lamp's emission texture.
#[derive(Debug, Clone, Copy)]
pub struct Texels {
    /// Index among the lamps.
    pub lamp: usize,
    /// Columns and rows of texels, from the texture's upper left corner and beyond it.
    pub at: [Lines; 2],
}

/// A texel, or a cell between the middles of four.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell {
    /// Its upper left corner, in columns and rows of cells.
    corner: DVec2,
    /// What its corners have, linear Rec.709 of the mean light's luminance: left and right above, left and right below. In between it is
    /// linear along both ways.
    rgb: [[f64; 3]; 4],
}

impl Cell {
    fn is_even(&self) -> bool {
        self.rgb.iter().all(|corner| *corner == self.rgb[0])
    }

    /// Of the lamp's mean light per lane at a place, in columns and rows of cells.
    fn at<M: Mode>(&self, corners: &[M::Lanes<f64>; 4], place: DVec2) -> M::Lanes<f64> {
        let [s, t] = (place - self.corner).to_array();
        let between = |a: f64, b: f64, s: f64| a + (b - a) * s;
        let along = |lane: usize, k: usize| between(corners[k][lane], corners[k + 1][lane], s);
        lanes::<M, _>(|lane| between(along(lane, 0), along(lane, 2), t))
    }
}

impl Glow {
    /// Of a column and a row of cells.
    fn cell(&self, column: f64, row: f64) -> Cell {
        let rgb = if self.is_smooth() {
            let texel = |right: f64, down: f64| self.of_texel([column + right, row + down]);
            [texel(0.0, 0.0), texel(1.0, 0.0), texel(0.0, 1.0), texel(1.0, 1.0)]
        } else {
            [self.of_texel([column, row]); 4]
        };
        Cell { corner: DVec2::new(column, row), rgb }
    }

    /// The next one to the right.
    fn beside(&self, cell: &Cell) -> Cell {
        let [column, row] = (cell.corner + DVec2::X).to_array();
        if !self.is_smooth() {
            return self.cell(column, row);
        }
        let [_, above, _, below] = cell.rgb;
        let texel = |down: f64| self.of_texel([column + 1.0, row + down]);
        Cell { corner: DVec2::new(column, row), rgb: [above, texel(0.0), below, texel(1.0)] }
    }
}

/// First of the whole numbers that a span reaches, and how many more there are.
fn steps([low, high]: [f64; 2]) -> (f64, u64) {
    (low.floor(), (high.floor() - low.floor()) as u64)
}

impl Texels {
    /// How many texels the square may see, wherever it lies.
    pub fn count(&self) -> f64 {
        self.at.iter().map(|lines| 2.0 + (lines.by.x.abs() + lines.by.y.abs()).floor()).product()
    }

    /// Whether it may see so many that it is not cut, or lies where numbers do not tell one from the next.
    pub(super) fn are_many(&self) -> bool {
        let is_far = |lines: &Lines| lines.first.abs() > 1.0 / f64::EPSILON;
        self.count().is_nan() || self.count() > MOST_TEXELS || self.at.iter().any(is_far)
    }

    fn glow<'w>(&self, world: &'w World) -> Option<&'w Glow> {
        world.lamps.get(self.lamp)?.texture()
    }

    /// Columns and rows of cells.
    fn cells(&self, glow: &Glow) -> [Lines; 2] {
        let shift = if glow.is_smooth() { 0.5 } else { 0.0 };
        self.at.map(|lines| Lines { first: lines.first - shift, ..lines })
    }

    /// Whether all of the square sees the same.
    pub fn are_even(&self, world: &World) -> bool {
        let square = super::footprint::square();
        !self.are_many() && self.glow(world).is_some_and(|glow| even_over(glow, &self.cells(glow), &square).is_some())
    }

    /// Of the lamp's mean light per lane at one of the square's points.
    pub fn factor<M: Mode>(&self, (world, optics): (&World, &Optics<M>), point: DVec2) -> M::Lanes<f64> {
        let Some(glow) = self.glow(world) else { return lanes::<M, _>(|_| 0.0) };
        let place = DVec2::from_array(self.cells(glow).map(|lines| lines.at(point)));
        let cell = glow.cell(place.x.floor(), place.y.floor());
        let corners = cell.rgb.map(|rgb| optics.glow(rgb));
        if cell.is_even() { corners[0] } else { cell.at::<M>(&corners, place) }
    }

    /// What a polygon of the square has of the light, per lane, and of how many cells it is put together.
    pub(super) fn integral<M: Mode>(
        &self,
        (world, optics): (&World, &Optics<M>),
        brightness: &Brightness<M>,
        polygon: &Polygon,
    ) -> (M::Lanes<f64>, u64) {
        let (mut light, mut pieces) = (lanes::<M, _>(|_| 0.0), 0);
        let Some(glow) = self.glow(world) else { return (light, pieces) };
        let lines = self.cells(glow);
        let mut add = |piece: &Polygon, (cell, count): (&Cell, u64)| {
            pieces += count;
            let corners = cell.rgb.map(|rgb| optics.glow(rgb));
            if cell.is_even() {
                let whole = brightness.over(piece);
                for lane in 0..M::LANES {
                    light[lane] += whole[lane] * corners[0][lane];
                }
            } else {
                by_places(piece, |point, area| {
                    let place = DVec2::from_array(lines.map(|lines| lines.at(point)));
                    let (own, factor) = (brightness.at(point), cell.at::<M>(&corners, place));
                    for lane in 0..M::LANES {
                        light[lane] += area * own[lane] * factor[lane];
                    }
                });
            }
        };
        match even_over(glow, &lines, polygon) {
            Some(cell) => add(polygon, (&cell, 1)),
            None => cut(glow, &lines, polygon, add),
        }
        (light, pieces)
    }
}

/// The cell that all of a polygon's are like, if they are.
fn even_over(glow: &Glow, [columns, rows]: &[Lines; 2], polygon: &Polygon) -> Option<Cell> {
    let ((left, more), (top, below)) = (steps(columns.span(polygon)), steps(rows.span(polygon)));
    let first = glow.cell(left, top);
    let alike = |row: u64| (0..=more).all(|column| glow.cell(left + column as f64, top + row as f64).rgb == first.rgb);
    (first.is_even() && (0..=below).all(alike)).then_some(first)
}

/// Cuts a polygon into cells and calls `each` with them and how many they are: those alike side by side are one piece.
fn cut(glow: &Glow, [columns, rows]: &[Lines; 2], polygon: &Polygon, mut each: impl FnMut(&Polygon, (&Cell, u64))) {
    let (top, below) = steps(rows.span(polygon));
    for row in (0..=below).map(|row| top + row as f64) {
        let strip = rows.cut(polygon, row, row + 1.0);
        if strip.len() < 3 {
            continue;
        }
        let (left, more) = steps(columns.span(&strip));
        let side_by_side = successors(Some(glow.cell(left, row)), |cell| Some(glow.beside(cell)));
        let mut cells = side_by_side.zip(0..=more).map(|(cell, _)| cell).peekable();
        let mut from = 0;
        while let Some(cell) = cells.next() {
            let mut to = from + 1;
            while cell.is_even() && cells.next_if(|other| other.rgb == cell.rgb).is_some() {
                to += 1;
            }
            let piece = columns.cut(&strip, left + from as f64, left + to as f64);
            if piece.len() > 2 {
                each(&piece, (&cell, to - from));
            }
            from = to;
        }
    }
}

/// Places of a polygon with weights by which the integral of any polynomial of the third degree is a sum, exactly: of each triangle of a fan
/// the rule of four (G. Strang, G. J. Fix, "An Analysis of the Finite Element Method", 1973, table 4.1). The brightness is linear,
/// the texture in a cell linear along both ways.
fn by_places(polygon: &Polygon, mut each: impl FnMut(DVec2, f64)) {
    let Some((first, others)) = polygon.split_first() else { return };
    for (a, b) in others.iter().zip(others.iter().skip(1)) {
        let (to_a, to_b) = (*a - *first, *b - *first);
        let area = 0.5 * to_a.perp_dot(to_b);
        each(*first + (to_a + to_b) / 3.0, -27.0 / 48.0 * area);
        for (s, t) in [(0.2, 0.2), (0.6, 0.2), (0.2, 0.6)] {
            each(*first + to_a * s + to_b * t, 25.0 / 48.0 * area);
        }
    }
}
