//! Which triangle of a height field a point belongs to, looked up in a grid across the axis.
//!
//! A ray meets an exact surface in two points at most, found without the mesh. Asking where they are costs one cell
//! instead of a walk through a tree of boxes; a lens with two such caps is traced about twice as fast.

use super::coverage::open_edges;
use super::patch::{Shear, vertex};
use glam::{DVec2, DVec3};

#[derive(Debug)]
pub struct Grid {
    /// Where the plane's coordinates start: near the face, so that they keep their digits.
    base: DVec3,
    lo: DVec2,
    hi: DVec2,
    /// Cells per unit.
    scale: DVec2,
    columns: usize,
    /// For each cell, row by row, where its slots start; one more entry for the end.
    starts: Vec<u32>,
    /// Places in `flat`.
    inside: Vec<u32>,
    /// Corners of the triangles in the plane, from `base`.
    flat: Vec<[DVec2; 3]>,
    /// Slot of the first triangle.
    first: u32,
    /// Cells that are covered without a gap, as bits: few enough to stay at hand, where triangles do not.
    covered: Vec<u64>,
}

/// Cells per triangle.
const CELLS: f64 = 2.0;
/// More entries than this per triangle: the triangles overlap so much that a tree is better.
const MOST: usize = 24;

impl Grid {
    /// A grid over triangles, with their places in the list as slots. None if they do not spread over the plane.
    pub fn build(triangles: &[[[f32; 3]; 3]], shear: &Shear, base: DVec3) -> Option<Grid> {
        let flat: Vec<[DVec2; 3]> = triangles.iter().map(|t| t.map(|v| shear.flatten(vertex(v) - base))).collect();
        let corners = || flat.iter().flatten();
        let lo = corners().fold(DVec2::INFINITY, |a, b| a.min(*b));
        let hi = corners().fold(DVec2::NEG_INFINITY, |a, b| a.max(*b));
        // More than the rounding of a point's coordinates.
        let reach = triangles.iter().flatten().flatten().fold(0.0f64, |a, x| a.max(f64::from(x.abs())));
        let pad = 1e-9 * (hi - lo).max_element() + 1e-12 * (reach + base.abs().max_element());
        let (lo, hi) = (lo - pad, hi + pad);
        let size = hi - lo;
        let side = (size.x * size.y / (CELLS * flat.len() as f64)).sqrt();
        if !(side > 0.0 && side.is_finite()) {
            return None;
        }
        let count = |length: f64| (length / side).ceil().clamp(1.0, 2048.0);
        let counts = DVec2::new(count(size.x), count(size.y));
        let (columns, rows) = (counts.x as usize, counts.y as usize);
        let mut grid = Grid {
            base,
            lo,
            hi,
            scale: counts / size,
            columns,
            starts: vec![],
            inside: vec![],
            flat: vec![],
            first: 0,
            covered: vec![],
        };
        let mut entries: Vec<(u32, u32)> = Vec::new();
        for (i, t) in flat.iter().enumerate() {
            grid.each_cell(t, counts, pad, |cell| entries.push((cell as u32, i as u32)));
            if entries.len() > MOST * flat.len() + 1024 {
                return None;
            }
        }
        // By cell; in each the triangles keep their order.
        let mut starts = vec![0u32; columns * rows + 1];
        entries.iter().for_each(|(cell, _)| starts[*cell as usize + 1] += 1);
        (0..columns * rows).for_each(|cell| starts[cell + 1] += starts[cell]);
        let mut next = starts.clone();
        grid.inside = vec![0; entries.len()];
        for (cell, place) in entries {
            let at = &mut next[cell as usize];
            grid.inside[*at as usize] = place;
            *at += 1;
        }
        grid.starts = starts;
        grid.flat = flat;
        grid.cover(counts, pad);
        Some(grid)
    }

    /// Finds the cells that are covered without a gap.
    fn cover(&mut self, counts: DVec2, pad: f64) {
        let (columns, rows) = (counts.x as usize, counts.y as usize);
        let mut cut = vec![false; columns * rows];
        for [a, b] in open_edges(&self.flat) {
            self.each_cell(&[a, b, b], counts, pad, |cell| cut[cell] = true);
        }
        self.covered = vec![0; (columns * rows).div_ceil(64)];
        let mut covered = vec![false; columns * rows];
        for cell in (0..columns * rows).filter(|cell| !cut[*cell]) {
            // Beside a cell without open edges it is as there.
            let beside = [(cell % columns > 0, 1), (cell >= columns, columns)];
            let known = beside.into_iter().find(|(is_there, by)| *is_there && !cut[cell - by]);
            covered[cell] = match known {
                Some((_, by)) => covered[cell - by],
                None => {
                    let middle = DVec2::new((cell % columns) as f64 + 0.5, (cell / columns) as f64 + 0.5);
                    let middle = self.lo + middle / self.scale;
                    self.around(middle).iter().any(|place| self.contains(*place, middle))
                }
            };
            self.covered[cell / 64] |= u64::from(covered[cell]) << (cell % 64);
        }
    }

    /// Calls `visit` with the cells that a triangle in the plane overlaps.
    fn each_cell(&self, t: &[DVec2; 3], counts: DVec2, pad: f64, mut visit: impl FnMut(usize)) {
        let (near, far) = (t[0].min(t[1]).min(t[2]) - pad, t[0].max(t[1]).max(t[2]) + pad);
        let cell = |p: DVec2| ((p - self.lo) * self.scale).max(DVec2::ZERO).min(counts - 1.0);
        let (near, far) = (cell(near), cell(far));
        for row in near.y as usize..=far.y as usize {
            for column in near.x as usize..=far.x as usize {
                let low = self.lo + DVec2::new(column as f64, row as f64) / self.scale - pad;
                let high = self.lo + DVec2::new(column as f64 + 1.0, row as f64 + 1.0) / self.scale + pad;
                if overlaps(t, low, high) {
                    visit(row * self.columns + column);
                }
            }
        }
    }

    /// Moves all slots up.
    pub fn move_slots(&mut self, by: u32) {
        self.first += by;
    }

    /// Slot of the first triangle of all.
    pub fn first(&self) -> u32 {
        self.first
    }

    /// Whether a triangle contains a point of the surface: the test of [`Shear::cross`](super::patch::Shear::cross) in the
    /// plane, where the corners are known already. Each corner is moved by the point in the same way whatever triangle asks,
    /// so no point slips between two triangles.
    #[inline]
    pub fn covers(&self, shear: &Shear, p: DVec3) -> bool {
        let q = shear.flatten(p - self.base);
        let Some(cell) = self.cell(q) else { return false };
        let covered = self.covered.get(cell / 64).is_some_and(|bits| bits >> (cell % 64) & 1 != 0);
        covered || self.inside(cell).iter().any(|place| self.contains(*place, q))
    }

    /// [`Grid::covers`] without cells.
    #[cfg(any(test, feature = "testing"))]
    pub fn covers_by_all(&self, shear: &Shear, p: DVec3) -> bool {
        let q = shear.flatten(p - self.base);
        (0..self.flat.len() as u32).any(|place| self.contains(place, q))
    }

    #[inline]
    fn contains(&self, place: u32, q: DVec2) -> bool {
        self.flat.get(place as usize).is_some_and(|[a, b, c]| {
            let (a, b, c) = (*a - q, *b - q, *c - q);
            let (u, v, w) = (c.x * b.y - c.y * b.x, a.x * c.y - a.y * c.x, b.x * a.y - b.y * a.x);
            let outside = (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0);
            // An edge-on triangle contains nothing.
            !outside && u + v + w != 0.0
        })
    }

    /// Places of the triangles that may contain a point of the plane, ascending.
    fn around(&self, q: DVec2) -> &[u32] {
        self.cell(q).map_or(&[], |cell| self.inside(cell))
    }

    #[inline]
    fn cell(&self, q: DVec2) -> Option<usize> {
        if !(q.x >= self.lo.x && q.y >= self.lo.y && q.x <= self.hi.x && q.y <= self.hi.y) {
            return None;
        }
        let at = (q - self.lo) * self.scale;
        let column = (at.x as usize).min(self.columns - 1);
        Some(((at.y as usize) * self.columns + column).min(self.starts.len().saturating_sub(2)))
    }

    #[inline]
    fn inside(&self, cell: usize) -> &[u32] {
        match self.starts.get(cell..cell + 2) {
            Some([from, to]) => self.inside.get(*from as usize..*to as usize).unwrap_or(&[]),
            Some(_) | None => &[],
        }
    }
}

/// Whether a triangle and an axis-aligned box overlap: unless the box is all beyond an edge.
fn overlaps(t: &[DVec2; 3], low: DVec2, high: DVec2) -> bool {
    let turn = (t[1] - t[0]).perp_dot(t[2] - t[0]);
    (0..3).all(|i| {
        let (a, along) = (t[i], t[(i + 1) % 3] - t[i]);
        // The corner of the box that is farthest to the inner side of this edge.
        let inward = if turn < 0.0 { DVec2::new(along.y, -along.x) } else { DVec2::new(-along.y, along.x) };
        let corner = DVec2::select(inward.cmpge(DVec2::ZERO), high, low);
        inward.dot(corner - a) >= 0.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyebox_base::rng::{Rng, Stream};

    #[test]
    fn a_cell_knows_every_triangle_over_it() {
        let mut rng = Rng::new(21, Stream::Check, 0, 0);
        let shear = Shear::along(DVec3::new(0.2, -0.3, 0.9));
        let mut number = |size: f64| ((rng.uniform() - 0.5) * size) as f32;
        let triangles: Vec<[[f32; 3]; 3]> = (0..300)
            .map(|_| {
                let c = [number(10.0), number(10.0), number(10.0)];
                [(); 3].map(|_| [c[0] + number(1.0), c[1] + number(0.3), c[2] + number(0.3)])
            })
            .collect();
        let base = DVec3::new(1.0, 2.0, 3.0);
        let mut grid = Grid::build(&triangles, &shear, base).expect("scattered triangles");
        grid.move_slots(7);
        let mut found = 0;
        for _ in 0..20_000 {
            let p = DVec3::new(rng.uniform() - 0.5, rng.uniform() - 0.5, rng.uniform() - 0.5) * 12.0;
            let near = grid.around(shear.flatten(p - grid.base));
            let all: Vec<u32> =
                (0..triangles.len() as u32).filter(|i| shear.cross(&triangles[*i as usize], p).is_some()).collect();
            assert!(all.iter().all(|i| near.contains(i)), "{all:?} at {p}");
            assert_eq!(grid.covers(&shear, p), !all.is_empty(), "{all:?} at {p}");
            found += all.len();
        }
        assert!(found > 500 && grid.inside.len() < 10 * triangles.len(), "{found} {}", grid.inside.len());
    }

    /// A sheet of squares, each two triangles, some turned over, with a hole, a fold and a vertex on an edge: cells that are
    /// covered without a gap know what trying all triangles tells.
    #[test]
    fn covered_cells_have_no_gaps() {
        const SIDE: usize = 24;
        let mut rng = Rng::new(22, Stream::Check, 0, 0);
        let shear = Shear::along(DVec3::Z);
        let corner = |x: usize, y: usize| [x as f32 + 0.2 * ((7 * x + 3 * y) % 5) as f32, y as f32, 0.1 * x as f32];
        let mut triangles = Vec::new();
        for (x, y) in (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y))) {
            let [a, b, c, d] = [corner(x, y), corner(x + 1, y), corner(x, y + 1), corner(x + 1, y + 1)];
            match (x, y) {
                (10..13, 10..12) => {}
                (3, 17) => {
                    let middle = std::array::from_fn(|k| 0.5 * (a[k] + b[k]));
                    triangles.extend([[a, middle, c], [middle, d, c]]);
                }
                _ if (x + y) % 3 == 0 => triangles.extend([[a, b, c], [d, b, c]]),
                _ => triangles.extend([[a, b, c], [b, d, c]]),
            }
        }
        triangles.push([corner(0, 5), corner(2, 8), corner(5, 5)]);
        let grid = Grid::build(&triangles, &shear, DVec3::ZERO).expect("a sheet");
        let mut found = 0;
        for _ in 0..40_000 {
            let p = DVec3::new(rng.uniform() * 28.0 - 2.0, rng.uniform() * 28.0 - 2.0, 1.0);
            let covers = grid.covers(&shear, p);
            assert_eq!(covers, grid.covers_by_all(&shear, p), "{p}");
            found += usize::from(covers);
        }
        let covered: u32 = grid.covered.iter().map(|bits| bits.count_ones()).sum();
        assert!(found > 20_000 && covered as usize > grid.starts.len() / 2, "{found} {covered} {}", grid.starts.len());
    }
}
