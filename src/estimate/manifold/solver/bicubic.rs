//! A grid of nodes in two dimensions, and cubic interpolation between them.

use glam::DVec2;

/// Nodes along both axes; places are counted in cells from the first node.
#[derive(Debug, Clone, Copy)]
pub struct Nodes {
    /// At least four along each.
    pub count: [usize; 2],
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
}

/// Which sixteen nodes are asked, by cells aside of those about a place: these, or, near the rim of what is lit, as many on its
/// lit side. The place's cell is between some of them, or, for the last four, beside them.
pub const SIDES: [[i8; 2]; 13] =
    [[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [-1, 1], [1, -1], [-1, -1], [2, 0], [-2, 0], [0, 2], [0, -2]];

/// Four rows of nodes.
pub type Rows = [(usize, [f64; 4]); 4];

impl Nodes {
    /// How many there are.
    pub fn number(&self) -> usize {
        self.count[0] * self.count[1]
    }
    pub fn at_node(&self, node: usize) -> DVec2 {
        DVec2::new((node % self.count[0]) as f64, (node / self.count[0]) as f64)
    }
    /// The cells between the nodes, named by their nodes of least coordinates.
    pub fn cells(&self) -> impl Iterator<Item = usize> + use<> {
        let [nx, ny] = self.count;
        (0..ny - 1).flat_map(move |y| (0..nx - 1).map(move |x| y * nx + x))
    }
    /// Places in a cell: its middle, and eight near its rim.
    pub fn trials(&self, cell: usize) -> impl Iterator<Item = DVec2> + use<> {
        const ASIDE: f64 = 0.46;
        let middle = self.at_node(cell) + 0.5;
        // The middle is number 4 of the nine.
        [4, 0, 1, 2, 3, 5, 6, 7, 8]
            .into_iter()
            .map(move |k: u32| middle + (DVec2::new(f64::from(k % 3), f64::from(k / 3)) - 1.0) * ASIDE)
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
    /// The four nodes of a cell.
    pub fn corners(&self, cell: usize) -> [usize; 4] {
        [cell, cell + 1, cell + self.count[0], cell + self.count[0] + 1]
    }

    /// A place among the nodes; none beyond them.
    pub fn spot(&self, at: DVec2) -> Option<Spot> {
        self.spot_by(at, [0; 2])
    }

    /// A spot, or the same place by sixteen nodes that lie aside of those about it; none where those are not all there.
    pub fn aside(&self, spot: Spot, aside: [i8; 2]) -> Option<Spot> {
        if aside == [0; 2] { Some(spot) } else { self.spot_by(spot.at, aside) }
    }

    /// The same with sixteen nodes that lie aside of those about the place, by cells along both axes: −2 to 2.
    pub fn spot_by(&self, at: DVec2, aside: [i8; 2]) -> Option<Spot> {
        // The cell, the first of the four nodes about it (all of which there are), and the place from the second of them.
        let along = |x: f64, count: usize, aside: i8| {
            (x >= 0.0 && x <= (count - 1) as f64).then(|| {
                let cell = (x as usize).min(count - 2);
                let first = (cell + 1).saturating_add_signed(aside.into()).saturating_sub(2).min(count - 4);
                (cell, first, x - (first + 1) as f64)
            })
        };
        let (x, first_x, tx) = along(at.x, self.count[0], aside[0])?;
        let (y, first_y, ty) = along(at.y, self.count[1], aside[1])?;
        Some(Spot {
            at,
            cell: y * self.count[0] + x,
            first: [first_x, first_y],
            weights: [cubic(tx), cubic(ty)],
            columns: self.count[0],
        })
    }
}

/// Lagrange's weights of the nodes −1, 0, 1, 2 at t.
fn cubic(t: f64) -> [f64; 4] {
    let (a, b, c) = (t + 1.0, t - 1.0, t - 2.0);
    [-t * b * c / 6.0, a * b * c / 2.0, -a * t * c / 2.0, a * t * b / 6.0]
}

/// Their slopes there.
fn cubic_slope(t: f64) -> [f64; 4] {
    [
        -(3.0 * t * t - 6.0 * t + 2.0) / 6.0,
        (3.0 * t * t - 4.0 * t - 1.0) / 2.0,
        -(3.0 * t * t - 2.0 * t - 2.0) / 2.0,
        (3.0 * t * t - 1.0) / 6.0,
    ]
}

impl Spot {
    /// The sixteen nodes with their weights, and how those change by cells along both axes.
    pub fn nodes_with_slopes(&self) -> impl Iterator<Item = (usize, f64, DVec2)> + use<> {
        let [first_x, first_y] = self.first;
        let slopes =
            [(self.at.x, first_x), (self.at.y, first_y)].map(|(at, first)| cubic_slope(at - (first + 1) as f64));
        let (columns, [x, y]) = (self.columns, self.weights);
        (0..16).map(move |k| {
            let (i, j) = (k % 4, k / 4);
            let slope = DVec2::new(slopes[0][i] * y[j], x[i] * slopes[1][j]);
            ((first_y + j) * columns + first_x + i, x[i] * y[j], slope)
        })
    }

    /// The first of the four nodes of each row, which follow one another, and their weights.
    pub fn rows(&self) -> Rows {
        std::array::from_fn(|j| {
            let first = (self.first[1] + j) * self.columns + self.first[0];
            (first, self.weights[0].map(|weight| weight * self.weights[1][j]))
        })
    }

    /// The rows of nodes with what their weights change by along a step, in cells, to first order.
    pub fn rows_along(&self, step: DVec2) -> Rows {
        let [x, y] = [(self.at.x, self.first[0]), (self.at.y, self.first[1])]
            .map(|(at, first)| cubic_slope(at - (first + 1) as f64));
        std::array::from_fn(|j| {
            let first = (self.first[1] + j) * self.columns + self.first[0];
            let along = |i: usize| x[i] * self.weights[1][j] * step.x + self.weights[0][i] * y[j] * step.y;
            (first, std::array::from_fn(along))
        })
    }

    /// The sixteen nodes and their weights.
    pub fn nodes(&self) -> impl Iterator<Item = (usize, f64)> + use<> {
        self.rows().into_iter().flat_map(|(first, weights)| (first..).zip(weights))
    }
}

#[cfg(test)]
mod tests {
    use super::{Nodes, cubic, cubic_slope};
    use glam::DVec2;

    /// Slopes are met exactly, too.
    #[test]
    fn slopes_are_those_of_cubics() {
        for k in 0..=10 {
            let t = 0.3 * f64::from(k) - 1.0;
            for power in 0..4 {
                let slopes = cubic_slope(t).into_iter().zip([-1.0f64, 0.0, 1.0, 2.0]);
                let got: f64 = slopes.map(|(w, x)| w * x.powi(power)).sum();
                let wanted = if power == 0 { 0.0 } else { f64::from(power) * t.powi(power - 1) };
                assert!((got - wanted).abs() < 1e-13, "{t} {power} {got} {wanted}");
            }
        }
        let nodes = Nodes { count: [6, 7] };
        let spot = nodes.spot(DVec2::new(2.3, 4.9)).expect("it is among the nodes");
        let (mut value, mut slope) = (0.0, DVec2::ZERO);
        for ((node, weight, by), (same, again)) in spot.nodes_with_slopes().zip(spot.nodes()) {
            assert_eq!((node, weight), (same, again));
            let at = nodes.at_node(node);
            value += weight * at.x * at.y * at.y;
            slope += by * at.x * at.y * at.y;
        }
        assert!((value - 2.3 * 4.9 * 4.9).abs() < 1e-11, "{value}");
        assert!(slope.distance(DVec2::new(4.9 * 4.9, 2.0 * 2.3 * 4.9)) < 1e-11, "{slope}");
    }

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
