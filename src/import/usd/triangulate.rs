//! Polygons into triangles: fans where a polygon is convex, else ears, always n − 2 triangles and always the same ones.

use glam::{DVec2, DVec3};

/// What was met.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Met {
    /// Convex, or concave and cut cleanly.
    Plain,
    /// It crosses itself, or is so ragged that cutting was given up: a fan, some of whose triangles may fold back.
    Ragged,
}

/// Appends the triangles of a polygon as numbers of its corners, counter-clockwise as the polygon is.
pub(super) fn polygon(corners: &[DVec3], out: &mut Vec<[u32; 3]>) -> Met {
    let n = corners.len() as u32;
    match n {
        0..=2 => return Met::Plain,
        3 => {
            out.push([0, 1, 2]);
            return Met::Plain;
        }
        _ => {}
    }
    let flat = project(corners);
    if is_convex(&flat) {
        out.extend((1..n - 1).map(|i| [0, i, i + 1]));
        return Met::Plain;
    }
    ears(&flat, out)
}

/// The polygon seen against its normal (Newell's: the sum of the cross products of successive corners), without the
/// coordinate along which the normal is largest.
fn project(corners: &[DVec3]) -> Vec<DVec2> {
    let base = corners.first().copied().unwrap_or_default();
    let mut normal = DVec3::ZERO;
    for (i, corner) in corners.iter().enumerate() {
        let next = corners.get(i + 1).copied().unwrap_or(base);
        normal += (*corner - base).cross(next - base);
    }
    let size = normal.abs();
    let flatten = |p: &DVec3| {
        let p = *p - base;
        if size.z >= size.x && size.z >= size.y {
            if normal.z >= 0.0 { DVec2::new(p.x, p.y) } else { DVec2::new(p.y, p.x) }
        } else if size.x >= size.y {
            if normal.x >= 0.0 { DVec2::new(p.y, p.z) } else { DVec2::new(p.z, p.y) }
        } else if normal.y >= 0.0 {
            DVec2::new(p.z, p.x)
        } else {
            DVec2::new(p.x, p.z)
        }
    };
    corners.iter().map(flatten).collect()
}

/// > 0 where a, b, c turn left.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// Whether no triangle of the fan about corner 0 folds back, and no corner turns right.
fn is_convex(flat: &[DVec2]) -> bool {
    let n = flat.len();
    let at = |i: usize| flat[i % n];
    (0..n).all(|i| turn(at(i), at(i + 1), at(i + 2)) >= 0.0) && (1..n - 1).all(|i| turn(at(0), at(i), at(i + 1)) >= 0.0)
}

/// Cuts ears (Meisters 1975), the first that is found going round. Work is bounded: a hostile polygon of a million
/// corners must end, too.
fn ears(flat: &[DVec2], out: &mut Vec<[u32; 3]>) -> Met {
    let n = flat.len();
    let (mut before, mut after): (Vec<usize>, Vec<usize>) = (0..n).map(|i| ((i + n - 1) % n, (i + 1) % n)).unzip();
    let mut work = 4000usize.saturating_mul(n);
    let (mut at, mut left, mut misses) = (1, n, 0);
    while left > 3 && misses < left && work > 0 {
        let (a, c) = (before[at], after[at]);
        let area = turn(flat[a], flat[at], flat[c]);
        let is_ear = area > 0.0 && {
            let mut other = after[c];
            let mut clear = true;
            while other != a && work > 0 {
                work -= 1;
                let p = flat[other];
                // Only a corner that is not one of the ear's, at its place either, can be in the way.
                if p != flat[a]
                    && p != flat[at]
                    && p != flat[c]
                    && turn(flat[a], flat[at], p) >= 0.0
                    && turn(flat[at], flat[c], p) >= 0.0
                    && turn(flat[c], flat[a], p) >= 0.0
                {
                    clear = false;
                    break;
                }
                other = after[other];
            }
            clear && work > 0
        };
        // A corner without area (a spike or a straight line) can go, too, if nothing else can.
        if is_ear || area == 0.0 && misses + 1 >= left {
            out.push([a as u32, at as u32, c as u32]);
            (after[a], before[c]) = (c, a);
            (left, misses) = (left - 1, 0);
            // Going on behind the ear, not from its tip, keeps the triangles from all sharing one corner.
            at = after[c];
        } else {
            misses += 1;
            at = c;
        }
    }
    let first = at;
    let mut b = after[first];
    for _ in 0..left.saturating_sub(2) {
        let c = after[b];
        out.push([first as u32, b as u32, c as u32]);
        b = c;
    }
    if left > 3 { Met::Ragged } else { Met::Plain }
}
