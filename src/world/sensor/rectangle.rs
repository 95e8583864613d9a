//! The smallest rectangle about a face in its mean plane, and areas cut by its pixels.

use glam::{DVec2, DVec3};

/// A side of a face.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// Where the outward normal points.
    Front,
    Back,
}

impl Side {
    pub const BOTH: [Side; 2] = [Side::Front, Side::Back];

    pub fn name(self) -> &'static str {
        match self {
            Side::Front => "front",
            Side::Back => "back",
        }
    }
}

/// Sides that differ by less than this share of themselves, and areas of rectangles, count as equal: single precision leaves
/// as much of a difference in a square.
const EQUAL: f64 = 1e-4;
/// Directions that are tried of a face with more corners.
const MOST_TRIED: usize = 1024;
/// Least sine of the angle between `u` and the normal.
const LEAST_ACROSS: f64 = 1e-6;

/// A rectangle in space, m.
#[derive(Debug, Clone, Copy)]
pub struct Rectangle {
    pub centre: DVec3,
    /// Unit, to the right and up; `normal` = u × v.
    pub u: DVec3,
    pub v: DVec3,
    pub normal: DVec3,
    pub half: [f64; 2],
}

impl Rectangle {
    /// The rectangle about some points in the plane across `normal`, through their middle: along `asked`, or the smallest of
    /// all, its longer side to the right; of both ways along a side, and of the sides of a square, the one most along
    /// `x`. None if `asked` is along the normal.
    pub fn about(points: Vec<DVec3>, normal: DVec3, asked: Option<DVec3>, x: DVec3) -> Option<Rectangle> {
        let first = normal.any_orthonormal_vector();
        let second = normal.cross(first);
        let flat = |p: DVec3| DVec2::new(p.dot(first), p.dot(second));
        // Near the origin, so that no digits are lost.
        let anchor = *points.first()?;
        let hull = hull(points.iter().map(|p| flat(*p - anchor)).collect());
        let u = match asked {
            Some(asked) => {
                let across = asked - normal * asked.dot(normal);
                flat(across).try_normalize().filter(|_| across.length() > LEAST_ACROSS * asked.length())?
            }
            None => smallest(&hull, flat(x)),
        };
        let [(low_u, high_u), (low_v, high_v)] = extents(&hull, u);
        let heights = points.iter().map(|p| (*p - anchor).dot(normal));
        let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), h| (a.min(h), b.max(h)));
        let space = |p: DVec2| first * p.x + second * p.y;
        let middle = u * (0.5 * (low_u + high_u)) + u.perp() * (0.5 * (low_v + high_v));
        Some(Rectangle {
            centre: anchor + space(middle) + normal * (0.5 * (low + high)),
            u: space(u),
            v: space(u.perp()),
            normal,
            half: [0.5 * (high_u - low_u), 0.5 * (high_v - low_v)],
        })
    }

    /// Where a point is in the map, in pixels to the right and down from its upper left corner.
    pub fn place(&self, point: DVec3, pixels: [usize; 2]) -> [f64; 2] {
        let off = point - self.centre;
        let along = |axis: DVec3, half: f64| if half > 0.0 { 0.5 + 0.5 * off.dot(axis) / half } else { 0.5 };
        [along(self.u, self.half[0]) * pixels[0] as f64, (1.0 - along(self.v, self.half[1])) * pixels[1] as f64]
    }

    /// Adds the area of a triangle, m², to the pixels that it lies in.
    pub fn share_out(&self, corners: [DVec3; 3], pixels: [usize; 2], areas_m2: &mut [f64]) {
        let at = |p: DVec3| {
            let [x, y] = self.place(p, pixels);
            Corner { at: [x, y], p }
        };
        let triangle = corners.map(at).to_vec();
        let range = |of: &[Corner], axis: usize| {
            let places = of.iter().map(|corner| corner.at[axis]);
            let (low, high) = places.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
            let cell = |x: f64| (x.max(0.0) as usize).min(pixels[axis] - 1);
            cell(low)..=cell(high)
        };
        for row in range(&triangle, 1) {
            let strip = cut(&triangle, 1, row, pixels[1]);
            if strip.len() < 3 {
                continue;
            }
            for column in range(&strip, 0) {
                let piece = cut(&strip, 0, column, pixels[0]);
                areas_m2[row * pixels[0] + column] += area(&piece);
            }
        }
    }
}

/// A corner of a polygon: its place in the map, and in space.
#[derive(Debug, Clone, Copy)]
struct Corner {
    at: [f64; 2],
    p: DVec3,
}

/// What of a convex polygon lies in a column or row of the map (Sutherland and Hodgman, "Reentrant polygon clipping", 1974);
/// the first and the last one reach beyond the map.
fn cut(polygon: &[Corner], axis: usize, index: usize, count: usize) -> Vec<Corner> {
    let mut kept = polygon.to_vec();
    let bounds =
        [(index > 0).then_some((index as f64, 1.0)), (index + 1 < count).then_some((index as f64 + 1.0, -1.0))];
    for (bound, sign) in bounds.into_iter().flatten() {
        let inside = |corner: &Corner| sign * (corner.at[axis] - bound);
        let mut next = Vec::with_capacity(kept.len() + 1);
        for (k, from) in kept.iter().enumerate() {
            let to = &kept[(k + 1) % kept.len()];
            let (a, b) = (inside(from), inside(to));
            if a >= 0.0 {
                next.push(*from);
            }
            if (a >= 0.0) != (b >= 0.0) {
                let t = a / (a - b);
                let between = |from: f64, to: f64| from + (to - from) * t;
                let mut at = [0, 1].map(|axis| between(from.at[axis], to.at[axis]));
                at[axis] = bound;
                next.push(Corner { at, p: from.p + (to.p - from.p) * t });
            }
        }
        kept = next;
    }
    kept
}

/// Of a flat convex polygon in space.
fn area(polygon: &[Corner]) -> f64 {
    let Some(first) = polygon.first() else { return 0.0 };
    let pieces = polygon.windows(2).map(|pair| (pair[0].p - first.p).cross(pair[1].p - first.p));
    0.5 * pieces.sum::<DVec3>().length()
}

/// The convex hull, counter-clockwise (A. M. Andrew, "Another efficient algorithm for convex hulls in two dimensions", 1979).
fn hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    if points.len() < 3 {
        return points;
    }
    let chain = |points: &mut dyn Iterator<Item = DVec2>| {
        let mut chain: Vec<DVec2> = Vec::new();
        for p in points {
            while let [.., a, b] = chain.as_slice()
                && (*b - *a).perp_dot(p - *b) <= 0.0
            {
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut all = chain(&mut points.iter().copied());
    all.extend(chain(&mut points.iter().rev().copied()));
    all
}

/// From where to where some points reach along `u` and across it.
fn extents(points: &[DVec2], u: DVec2) -> [(f64, f64); 2] {
    [u, u.perp()].map(|axis| {
        let along = points.iter().map(|p| p.dot(axis));
        along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
    })
}

/// The direction to the right of the smallest rectangle about a hull, one side of which lies on an edge of it.
fn smallest(hull: &[DVec2], x: DVec2) -> DVec2 {
    let edges = (0..hull.len()).filter_map(|k| (hull[(k + 1) % hull.len()] - hull[k]).try_normalize());
    let step = hull.len().div_ceil(MOST_TRIED).max(1);
    let own = x.try_normalize();
    let sides = |u: DVec2| extents(hull, u).map(|(low, high)| high - low);
    let mut best: Option<(DVec2, f64)> = None;
    // The part's own axis first: another one has to be better.
    for u in own.into_iter().chain(edges.step_by(step)) {
        let [width, height] = sides(u);
        if best.is_none_or(|(_, area)| width * height < area * (1.0 - EQUAL)) {
            best = Some((u, width * height));
        }
    }
    let u = best.map_or(DVec2::X, |(u, _)| u);
    let [width, height] = sides(u);
    // Of ways that are as much along x as each other, towards what is left of it.
    let along = |u: DVec2| u.dot(x + x.perp() * EQUAL);
    let square = (width - height).abs() <= EQUAL * width.max(height);
    let ways = if square {
        vec![u, -u, u.perp(), -u.perp()]
    } else if width > height {
        vec![u, -u]
    } else {
        vec![u.perp(), -u.perp()]
    };
    // Of ways that lie alike, the first.
    ways.into_iter().reduce(|a, b| if along(b) > along(a) { b } else { a }).unwrap_or(u)
}
