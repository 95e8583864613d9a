//! The light that slides let through all of a small area at once: where a pixel's footprint on each slide is a parallelogram,
//! the pixels of their pictures are cut out of it exactly, so that no edge of a picture is left to chance.

use super::SlideMap;
use super::texels::Texels;
use crate::World;
use crate::mode::{Mode, lanes};
use crate::optics::Optics;
use arrayvec::ArrayVec;
use eyebox_film::accumulate::Light;
use glam::{DVec2, DVec3};

/// Most slides that are crossed one after the other, and most edges.
pub const MOST: usize = 4;
pub const MOST_EDGES: usize = 12;

/// A piece of no more of the square is rounding.
pub(crate) const SLIVER: f64 = 64.0 * f64::EPSILON;

/// Corners of a convex polygon; each edge adds one at most, each of a slide's pixels that it is cut by four.
pub(crate) type Polygon = ArrayVec<DVec2, { 4 + 4 * MOST + MOST_EDGES }>;

/// Where the points of the square from −½ to ½ cross a slide: `at` + x·by\[0\] + y·by\[1\], mesh units.
#[derive(Debug, Clone, Copy)]
pub struct Footprint {
    pub slide: usize,
    pub at: DVec3,
    pub by: [DVec3; 2],
}

impl Footprint {
    /// Where one of the square's points crosses.
    pub fn place(&self, point: DVec2) -> DVec3 {
        self.at + self.by[0] * point.x + self.by[1] * point.y
    }

    /// How near the square comes to the rim of the picture, as a share of its longer side; 0 or less where it may cross it.
    pub fn to_rim(&self, map: &SlideMap) -> f64 {
        let reach = 0.5 * (self.by[0].length() + self.by[1].length());
        map.to_rim(self.at) - reach / map.size()
    }
}

/// How bright the square is before slides: `middle` + x·by\[0\] + y·by\[1\].
#[derive(Debug, Clone, Copy)]
pub struct Brightness<M: Mode> {
    pub middle: M::Lanes<f64>,
    pub by: [M::Lanes<f64>; 2],
}

impl<M: Mode> Brightness<M> {
    /// At one of the square's points.
    pub fn at(&self, point: DVec2) -> M::Lanes<f64> {
        lanes::<M, _>(|lane| self.middle[lane] + self.by[0][lane] * point.x + self.by[1][lane] * point.y)
    }

    /// Its integral over a piece of the square; 0 over what is no more than rounding leaves of an edge along the square's own.
    pub(super) fn over(&self, piece: &Polygon) -> M::Lanes<f64> {
        let (area, moment) = moments(piece);
        if area < SLIVER {
            return lanes::<M, _>(|_| 0.0);
        }
        lanes::<M, _>(|lane| self.middle[lane] * area + self.by[0][lane] * moment.x + self.by[1][lane] * moment.y)
    }
}

/// A straight edge across the square: light comes where `first` + `by`·point is not negative.
pub type Edge = Lines;

/// The mean over the square of what comes past all edges and through all slides, and of how many pieces it was put together.
/// None where that is not finite, or more slides are crossed than [`MOST`], or edges than [`MOST_EDGES`].
pub fn mean<M: Mode>(
    tracing: (&World, &Optics<M>),
    brightness: &Brightness<M>,
    cutting: (&[Edge], &[Footprint]),
) -> Option<(M::Lanes<Light>, u64)> {
    mean_of(tracing, (brightness, None), cutting)
}

/// The same of a lamp that may shine through a texture: its brightness is that of its mean light. A texture counts as a slide. None, too,
/// where so many texels may be seen that they are not cut, wherever the square lies.
pub fn mean_of<M: Mode>(
    (world, optics): (&World, &Optics<M>),
    (brightness, texels): (&Brightness<M>, Option<&Texels>),
    (edges, footprints): (&[Edge], &[Footprint]),
) -> Option<(M::Lanes<Light>, u64)> {
    let pictures = footprints.len() + usize::from(texels.is_some());
    if edges.len() > MOST_EDGES || pictures > MOST || texels.is_some_and(Texels::are_many) {
        return None;
    }
    let mut square = square();
    // Most edges of what is near lie beside it.
    for edge in edges {
        let is_beside = edge.first >= 0.5 * (edge.by.x.abs() + edge.by.y.abs());
        if !is_beside {
            square = edge.keep(&square, |at| at);
        }
    }
    let light = lanes::<M, _>(|_| Light::default());
    let mut sum = Sum { tracing: (world, optics), brightness, texels, light, pieces: 0 };
    sum.through(&square, footprints, lanes::<M, _>(|_| Light::ONE))?;
    let finite = (0..M::LANES).all(|lane| sum.light[lane].is_finite());
    finite.then_some((sum.light, sum.pieces))
}

/// What comes past all edges and through all slides to one of the square's points; none beside a picture or beyond an edge.
pub fn at<M: Mode>(
    (world, optics): (&World, &Optics<M>),
    brightness: &Brightness<M>,
    (edges, footprints): (&[Edge], &[Footprint]),
    point: DVec2,
) -> Option<M::Lanes<Light>> {
    if edges.iter().any(|edge| edge.at(point) < 0.0) {
        return None;
    }
    let strength = brightness.at(point);
    let mut light = lanes::<M, _>(|lane| Light::ONE.scaled(strength[lane]));
    for footprint in footprints {
        let map = &world.slides[footprint.slide];
        let s = optics.slide(map, footprint.place(point))?;
        optics.cross_slide(&mut light, (map, world.rank(footprint.slide)), &s);
    }
    Some(light)
}

/// All of the square.
pub(crate) fn square() -> Polygon {
    [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]].into_iter().map(DVec2::from_array).collect()
}

struct Sum<'s, M: Mode> {
    tracing: (&'s World, &'s Optics<M>),
    brightness: &'s Brightness<M>,
    texels: Option<&'s Texels>,
    light: M::Lanes<Light>,
    pieces: u64,
}

impl<M: Mode> Sum<'_, M> {
    /// Adds a piece that `light` has come to through the slides before these.
    fn through(&mut self, piece: &Polygon, footprints: &[Footprint], light: M::Lanes<Light>) -> Option<()> {
        let Some((footprint, rest)) = footprints.split_first() else {
            let (factor, pieces) = match self.texels {
                None => (self.brightness.over(piece), 1),
                Some(texels) => texels.integral(self.tracing, self.brightness, piece),
            };
            self.pieces += pieces;
            for lane in 0..M::LANES {
                self.light[lane].add(light[lane].scaled(factor[lane]));
            }
            return Some(());
        };
        let (world, optics) = self.tracing;
        let (map, rank) = (&world.slides[footprint.slide], world.rank(footprint.slide));
        map.pieces(piece, footprint, &mut |piece, index| {
            let s = optics.slide_at(map, index);
            let mut light = light;
            optics.cross_slide(&mut light, (map, rank), &s);
            self.through(piece, rest, light)
        })
    }
}

impl SlideMap {
    /// Column and row of the picture over the square, in its pixels from the first one's side.
    pub(super) fn lines(&self, footprint: &Footprint) -> [Lines; 2] {
        [(self.across, self.width), (self.down, self.height)].map(|(axis, count)| Lines {
            first: (axis.dot(footprint.at - self.centre) + 0.5) * count as f64,
            by: DVec2::new(axis.dot(footprint.by[0]), axis.dot(footprint.by[1])) * count as f64,
        })
    }

    /// Whether these columns and rows, first and last of each, have one value.
    pub(super) fn is_even(&self, [first, last]: [usize; 2], [first_row, last_row]: [usize; 2]) -> bool {
        let start = first_row * self.width + first;
        (first_row..=last_row).all(|row| {
            let at = row * self.width + first;
            self.same(start, at) && usize::from(self.alike[at]) > last - first
        })
    }

    /// Cuts a polygon of the square into pieces that each show one value of the picture, and calls `each` with them and a
    /// pixel of that value. What lies beside the picture is left out. None where the footprint is not finite.
    fn pieces(
        &self,
        polygon: &Polygon,
        footprint: &Footprint,
        each: &mut impl FnMut(&Polygon, usize) -> Option<()>,
    ) -> Option<()> {
        let [columns, rows] = self.lines(footprint);
        if !(columns.first.is_finite() && columns.by.is_finite() && rows.first.is_finite() && rows.by.is_finite()) {
            return None;
        }
        let (down, along) = (rows.span(polygon), columns.span(polygon));
        let inside = |[low, high]: [f64; 2], count: usize| low >= 0.0 && high <= count as f64;
        let Some([first_row, last_row]) = cells(down, self.height) else { return Some(()) };
        let Some([first, last]) = cells(along, self.width) else { return Some(()) };
        // Most of a picture is even.
        if inside(down, self.height) && inside(along, self.width) && self.is_even([first, last], [first_row, last_row])
        {
            return each(polygon, first_row * self.width + first);
        }
        for row in first_row..=last_row {
            let strip = rows.cut(polygon, row as f64, (row + 1) as f64);
            let Some([first, last]) = cells(columns.span(&strip), self.width) else { continue };
            let mut column = first;
            while column <= last {
                let at = row * self.width + column;
                let end = column + usize::from(self.alike[at]);
                let piece = columns.cut(&strip, column as f64, end.min(self.width) as f64);
                if piece.len() > 2 {
                    each(&piece, at)?;
                }
                column = end;
            }
        }
        Some(())
    }
}

/// The cells that a span reaches, of so many from 0 on.
pub(super) fn cells([low, high]: [f64; 2], count: usize) -> Option<[usize; 2]> {
    let last = count - 1;
    (low < count as f64 && high > 0.0).then(|| [(low.max(0.0) as usize).min(last), (high as usize).min(last)])
}

/// A number that is linear over the square, as a coordinate of a picture in its pixels: `first` + `by`·point.
#[derive(Debug, Clone, Copy)]
pub struct Lines {
    pub first: f64,
    pub by: DVec2,
}

impl Lines {
    pub fn at(&self, point: DVec2) -> f64 {
        self.first + self.by.dot(point)
    }

    pub(crate) fn span(&self, polygon: &Polygon) -> [f64; 2] {
        let all = polygon.iter().map(|corner| self.at(*corner));
        all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)])
    }

    /// The part of a polygon between two values (I. E. Sutherland and G. W. Hodgman, "Reentrant polygon clipping", CACM 17, 1974).
    pub(crate) fn cut(&self, polygon: &Polygon, low: f64, high: f64) -> Polygon {
        let above = self.keep(polygon, |at| at - low);
        self.keep(&above, |at| high - at)
    }

    fn keep(&self, polygon: &Polygon, inside: impl Fn(f64) -> f64) -> Polygon {
        let mut kept = Polygon::new();
        let Some(mut before) = polygon.last().copied() else { return kept };
        let mut of_before = inside(self.at(before));
        for corner in polygon {
            let of_corner = inside(self.at(*corner));
            if (of_before < 0.0) != (of_corner < 0.0) {
                // The polygon is convex: at most two corners come new, for one that goes. No room is left only to rounding.
                let _ = kept.try_push(before.lerp(*corner, of_before / (of_before - of_corner)));
            }
            if of_corner >= 0.0 {
                let _ = kept.try_push(*corner);
            }
            (before, of_before) = (*corner, of_corner);
        }
        kept
    }
}

/// Area of a polygon, and the integral of the place over it.
pub(crate) fn moments(polygon: &Polygon) -> (f64, DVec2) {
    let (mut area, mut moment) = (0.0, DVec2::ZERO);
    let Some(mut before) = polygon.last().copied() else { return (area, moment) };
    for corner in polygon {
        let twice = before.perp_dot(*corner);
        area += twice;
        moment += (before + *corner) * twice;
        before = *corner;
    }
    // A footprint's corners run one way round whatever it is on the slide: they are places of the square.
    (0.5 * area, moment / 6.0)
}

#[cfg(test)]
#[path = "footprint_tests.rs"]
pub(super) mod tests;
