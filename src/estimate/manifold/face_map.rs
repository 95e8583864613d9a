//! Coordinates on a face that scatters, and interpolation between the nodes of a grid over it.

use crate::film::train::Screen;
use crate::world::World;
use crate::world::geometry::{Ray, Site};
use glam::{DVec2, DVec3};

/// The box of what a pilot found is a little smaller than what is lit; the grid stays this share inside of it, so that
/// its outer nodes have solutions.
const INSIDE: f64 = 2e-3;
/// How far beyond the outer nodes connections are still tried, cells: what is lit there is a sliver, and most of what is
/// tried is dark.
const BEYOND: f64 = 0.1;

/// A grid over the lit part of a face: places are counted along two axes of a plane.
#[derive(Debug, Clone)]
pub struct FaceMap {
    pub part: u32,
    pub face: u32,
    corner: DVec3,
    /// Unit: the face is looked for along it.
    normal: DVec3,
    across: [DVec3; 2],
    cell: DVec2,
    /// Nodes along both axes.
    count: [usize; 2],
    about: DVec3,
}

/// Where something lies among the nodes, and the weights of the sixteen about it.
#[derive(Debug, Clone, Copy)]
pub struct Spot {
    /// In cells, from the first node.
    pub at: DVec2,
    pub cell: usize,
    /// The first of four nodes along both axes.
    first: [usize; 2],
    weights: [[f64; 4]; 2],
    columns: usize,
    /// Beyond the outer nodes.
    pub outside: bool,
}

impl FaceMap {
    /// Over the box of a screen's places, with so many cells along its longer side. None where the face can't be met along
    /// its own normal.
    pub fn new(world: &World, screen: &Screen, cells: usize) -> Option<FaceMap> {
        let [lo, hi] = screen.bounds.map(DVec3::from_array);
        let seed = screen.seeds.first()?;
        let (place, dir) = (DVec3::from_array(seed.place), DVec3::from_array(seed.dir));
        let size = (hi - lo).length();
        // The normal there, met from a little off.
        let back = Ray { origin: place + dir * size, dir: -dir, from: None };
        let to_mesh = world.geometry.part_to_world(screen.part).inverse();
        let normal = world.geometry.meet(screen.part, screen.face, &back, to_mesh.transform_point3(place))?.normal;
        let (a, b) = normal.any_orthonormal_pair();
        let corners =
            (0..8usize).map(|k| DVec3::new([lo.x, hi.x][k & 1], [lo.y, hi.y][k >> 1 & 1], [lo.z, hi.z][k >> 2]));
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for corner in corners {
            let q = DVec2::new((corner - place).dot(a), (corner - place).dot(b));
            (low, high) = (low.min(q), high.max(q));
        }
        let longer = (high - low).max_element();
        if !(longer > 0.0 && longer.is_finite()) {
            return None;
        }
        (low, high) = (low + INSIDE * longer, high - INSIDE * longer);
        let size = (high - low).max(DVec2::splat(INSIDE * longer));
        // At least four nodes, for cubics.
        let nodes = |length: f64| ((cells as f64 * length / longer).ceil() as usize).clamp(3, cells.max(3)) + 1;
        let count = [nodes(size.x), nodes(size.y)];
        let cell = size / DVec2::new((count[0] - 1) as f64, (count[1] - 1) as f64);
        let corner = place + a * low.x + b * low.y + normal * (2.0 * longer);
        Some(FaceMap {
            part: screen.part,
            face: screen.face,
            corner,
            normal,
            across: [a, b],
            cell,
            count,
            about: to_mesh.transform_point3(place),
        })
    }

    pub fn nodes(&self) -> usize {
        self.count[0] * self.count[1]
    }
    pub fn across(&self) -> [DVec3; 2] {
        self.across
    }

    /// The place on the face at fractional node coordinates.
    pub fn place(&self, world: &World, at: DVec2) -> Option<(DVec3, Site)> {
        let origin = self.corner + self.across[0] * (at.x * self.cell.x) + self.across[1] * (at.y * self.cell.y);
        let ray = Ray { origin, dir: -self.normal, from: None };
        let meet = world.geometry.meet(self.part, self.face, &ray, self.about)?;
        Some((meet.point, Site { part: self.part, face: self.face, triangle: meet.triangle }))
    }

    pub fn at_node(&self, node: usize) -> DVec2 {
        DVec2::new((node % self.count[0]) as f64, (node / self.count[0]) as f64)
    }
    /// The middle of the cell whose corner of least coordinates is a node.
    pub fn middle(&self, cell: usize) -> DVec2 {
        self.at_node(cell) + 0.5
    }
    /// The cells between the nodes, named by their nodes of least coordinates.
    pub fn cells(&self) -> impl Iterator<Item = usize> + use<> {
        let [nx, ny] = self.count;
        (0..ny - 1).flat_map(move |y| (0..nx - 1).map(move |x| y * nx + x))
    }
    /// The longer side of a cell, m.
    pub fn cell_size(&self) -> f64 {
        self.cell.max_element()
    }
    pub fn neighbours(&self, node: usize) -> impl Iterator<Item = usize> + use<> {
        let [nx, ny] = self.count;
        let (x, y) = (node % nx, node / nx);
        let all = [(x.wrapping_sub(1), y), (x + 1, y), (x, y.wrapping_sub(1)), (x, y + 1)];
        all.into_iter().filter(move |(x, y)| *x < nx && *y < ny).map(move |(x, y)| y * nx + x)
    }
    /// The four nodes next to a node along each half of its row and column; none where there are fewer.
    pub fn lines(&self, node: usize) -> [Option<[usize; 4]>; 4] {
        let [nx, ny] = self.count.map(|n| n as i64);
        let (x, y) = ((node as i64) % nx, (node as i64) / nx);
        [(1, 0), (-1, 0), (0, 1), (0, -1)].map(|(dx, dy)| {
            let (last_x, last_y) = (x + 4 * dx, y + 4 * dy);
            let inside = (0..nx).contains(&last_x) && (0..ny).contains(&last_y);
            inside.then(|| [1, 2, 3, 4].map(|k| ((y + k * dy) * nx + x + k * dx) as usize))
        })
    }

    /// From one node to another along the axes, m.
    pub fn step(&self, from: usize, to: usize) -> DVec2 {
        (self.at_node(to) - self.at_node(from)) * self.cell
    }

    /// From a node to a spot, m along both axes.
    pub fn from_node(&self, node: usize, spot: &Spot) -> DVec2 {
        (spot.at - self.at_node(node)) * self.cell
    }

    /// The four nodes of a cell.
    pub fn corners(&self, cell: usize) -> [usize; 4] {
        [cell, cell + 1, cell + self.count[0], cell + self.count[0] + 1]
    }

    /// Where a point of the face lies; none farther than [`BEYOND`] the outer nodes.
    pub fn spot(&self, point: DVec3) -> Option<Spot> {
        let off = point - self.corner;
        let at = DVec2::new(off.dot(self.across[0]), off.dot(self.across[1])) / self.cell;
        self.spot_at(at)
    }

    pub fn spot_at(&self, at: DVec2) -> Option<Spot> {
        // The cell, the first of the four nodes about it (all of which there are), and the place from the second of them.
        let along = |x: f64, count: usize| {
            (x >= -BEYOND && x <= (count - 1) as f64 + BEYOND).then(|| {
                let cell = (x.max(0.0) as usize).min(count - 2);
                let first = cell.saturating_sub(1).min(count - 4);
                (cell, first, x - (first + 1) as f64)
            })
        };
        let (x, first_x, tx) = along(at.x, self.count[0])?;
        let (y, first_y, ty) = along(at.y, self.count[1])?;
        let (last_x, last_y) = ((self.count[0] - 1) as f64, (self.count[1] - 1) as f64);
        Some(Spot {
            at,
            cell: y * self.count[0] + x,
            first: [first_x, first_y],
            weights: [cubic(tx), cubic(ty)],
            columns: self.count[0],
            outside: at.x < 0.0 || at.y < 0.0 || at.x > last_x || at.y > last_y,
        })
    }
}

/// Lagrange's weights of the nodes −1, 0, 1, 2 at t.
fn cubic(t: f64) -> [f64; 4] {
    let (a, b, c) = (t + 1.0, t - 1.0, t - 2.0);
    [-t * b * c / 6.0, a * b * c / 2.0, -a * t * c / 2.0, a * t * b / 6.0]
}

impl Spot {
    /// The sixteen nodes and their weights.
    pub fn nodes(&self) -> impl Iterator<Item = (usize, f64)> + use<> {
        let spot = *self;
        (0..16).map(move |k| {
            let (i, j) = (k % 4, k / 4);
            let node = (spot.first[1] + j) * spot.columns + spot.first[0] + i;
            (node, spot.weights[0][i] * spot.weights[1][j])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::cubic;

    /// Cubics are met exactly, and constants add up.
    #[test]
    fn weights_reproduce_cubics() {
        for k in 0..=10 {
            let t = 0.3 * f64::from(k) - 1.0;
            let weights = cubic(t);
            for power in 0..4 {
                let got: f64 = weights.iter().zip([-1.0f64, 0.0, 1.0, 2.0]).map(|(w, x)| w * x.powi(power)).sum();
                assert!((got - t.powi(power)).abs() < 1e-14, "{t} {power} {got}");
            }
        }
    }
}
