//! Numbers at the nodes of a grid, close together and in fours, so that they are blended four at a time.

use super::bicubic::Rows;

/// Four numbers.
pub type Quad = [f64; 4];

/// Numbers at nodes: so many quads for each, in the order of the nodes.
#[derive(Debug)]
pub struct SimdNodes {
    quads: Vec<Quad>,
    stride: usize,
}

impl SimdNodes {
    /// For as many nodes as are said, with `stride` quads each that are all `number`.
    pub fn new(nodes: usize, stride: usize, number: f64) -> SimdNodes {
        debug_assert!(stride > 0);
        SimdNodes { quads: vec![[number; 4]; nodes * stride], stride }
    }

    /// Quads of a node.
    pub fn stride(&self) -> usize {
        self.stride
    }

    /// The numbers of a node, four for each quad; nothing beyond the nodes.
    pub fn at(&self, node: usize) -> &[f64] {
        self.quads.get(node * self.stride..(node + 1) * self.stride).unwrap_or_default().as_flattened()
    }

    /// The numbers of each node in turn.
    pub fn nodes_mut(&mut self) -> impl Iterator<Item = &mut [f64]> {
        self.quads.as_flattened_mut().chunks_exact_mut(4 * self.stride)
    }

    /// The first N quads of the nodes in these rows, blended by their weights; none beyond the nodes.
    #[inline]
    pub fn blend<const N: usize>(&self, rows: &Rows) -> Option<[Quad; N]> {
        #[cfg(target_arch = "x86_64")]
        if std::is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has what the function needs.
            return unsafe { self.blend_in_lanes(rows) };
        }
        self.blend_by(rows)
    }

    /// With four lanes of f64. No product is fused: the numbers are the same everywhere.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn blend_in_lanes<const N: usize>(&self, rows: &Rows) -> Option<[Quad; N]> {
        self.blend_by(rows)
    }

    #[inline(always)]
    fn blend_by<const N: usize>(&self, rows: &Rows) -> Option<[Quad; N]> {
        // Where the stride is known, all of a row is known to be there at once.
        if self.stride == N { self.blend_at(rows, N) } else { self.blend_at(rows, self.stride) }
    }

    #[inline(always)]
    fn blend_at<const N: usize>(&self, rows: &Rows, stride: usize) -> Option<[Quad; N]> {
        let mut sums = [[Quad::default(); N]; 4];
        for ((first, weights), sums) in rows.iter().zip(&mut sums) {
            let row = self.quads.get(first * stride..(first + 4) * stride)?;
            for (node, weight) in row.chunks_exact(stride).zip(weights) {
                add(sums, *weight, node.first_chunk()?);
            }
        }
        Some(total(&sums))
    }

    /// The same where each node has a grid of its own, of K times N quads: its numbers are blended by `shares` first.
    #[inline]
    pub fn blend_grids<const N: usize, const K: usize>(&self, rows: &Rows, shares: &[f64; K]) -> Option<[Quad; N]> {
        #[cfg(target_arch = "x86_64")]
        if std::is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has what the function needs.
            return unsafe { self.blend_grids_in_lanes(rows, shares) };
        }
        self.blend_grids_by(rows, shares)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn blend_grids_in_lanes<const N: usize, const K: usize>(
        &self,
        rows: &Rows,
        shares: &[f64; K],
    ) -> Option<[Quad; N]> {
        self.blend_grids_by(rows, shares)
    }

    #[inline(always)]
    fn blend_grids_by<const N: usize, const K: usize>(&self, rows: &Rows, shares: &[f64; K]) -> Option<[Quad; N]> {
        debug_assert_eq!(self.stride, N * K);
        let mut sums = [[Quad::default(); N]; 4];
        for (first, weights) in rows {
            let row: &[Quad] = self.quads.get(first * N * K..(first + 4) * N * K)?;
            // All four nodes of a row side by side: a processor does not wait for one sum before it begins another.
            let mut of_nodes = [[Quad::default(); N]; 4];
            for (k, share) in shares.iter().enumerate() {
                for (node, sum) in of_nodes.iter_mut().enumerate() {
                    add(sum, *share, row[(node * K + k) * N..].first_chunk()?);
                }
            }
            for ((sum, weight), of_node) in sums.iter_mut().zip(weights).zip(&of_nodes) {
                add(sum, *weight, of_node);
            }
        }
        Some(total(&sums))
    }
}

#[inline(always)]
fn total<const N: usize>(sums: &[[Quad; N]; 4]) -> [Quad; N] {
    let [a, b, c, d] = sums;
    std::array::from_fn(|n| std::array::from_fn(|k| (a[n][k] + b[n][k]) + (c[n][k] + d[n][k])))
}

#[inline(always)]
fn add<const N: usize>(sums: &mut [Quad; N], weight: f64, quads: &[Quad; N]) {
    for (sum, quad) in sums.iter_mut().zip(quads) {
        for k in 0..4 {
            sum[k] += weight * quad[k];
        }
    }
}

/// Zeros follow.
#[inline]
pub fn filled<const N: usize, const ALL: usize>(quads: [Quad; N]) -> [Quad; ALL] {
    let mut all = [Quad::default(); ALL];
    all[..N].copy_from_slice(&quads);
    all
}

#[cfg(test)]
mod tests {
    use super::super::bicubic::Nodes;
    use super::SimdNodes;
    use glam::DVec2;

    /// Numbers that are products of cubics over the nodes, and of what the shares blend exactly, are met; what is done in
    /// lanes has the same bits.
    #[test]
    fn blends_are_exact_on_cubics_and_the_same_in_lanes() {
        let nodes = Nodes { count: [6, 7] };
        let over_nodes = |at: DVec2| 1.0 + at.x - 0.3 * at.x.powi(3) + at.y.powi(2) * at.x;
        let mut grids = SimdNodes::new(nodes.number(), 2 * 3, f64::NAN);
        let mut plain = SimdNodes::new(nodes.number(), 2, f64::NAN);
        for (node, (grid, plain)) in grids.nodes_mut().zip(plain.nodes_mut()).enumerate() {
            let value = over_nodes(nodes.at_node(node));
            plain.iter_mut().enumerate().for_each(|(k, number)| *number = value * (k as f64 + 0.5));
            grid.iter_mut().enumerate().for_each(|(k, number)| *number = value * (k as f64 % 8.0 + 0.5));
        }
        let shares = [0.25, 0.6, 0.15];
        for at in [DVec2::new(0.1, 0.2), DVec2::new(2.7, 3.3), DVec2::new(5.0, 6.0)] {
            let rows = nodes.spot(at).map(|spot| spot.rows()).expect("it is among the nodes");
            let (one, of_grids) = (plain.blend::<2>(&rows), grids.blend_grids::<2, 3>(&rows, &shares));
            assert_eq!(one, plain.blend_by::<2>(&rows));
            assert_eq!(of_grids, grids.blend_grids_by::<2, 3>(&rows, &shares));
            for sums in [one, of_grids] {
                let sums = sums.expect("all nodes are there");
                for (k, sum) in sums.as_flattened().iter().enumerate() {
                    let wanted = over_nodes(at) * (k as f64 + 0.5);
                    assert!((sum - wanted).abs() <= 1e-12 * wanted.abs().max(1.0), "{at} {k}: {sum}, not {wanted}");
                }
            }
        }
    }

    /// The first quad of longer ones, as all of them say it; a node that is not known, or not there, leaves none of the blend.
    #[test]
    fn parts_of_nodes_and_unknown_nodes() {
        let nodes = Nodes { count: [5, 4] };
        let mut lean = SimdNodes::new(nodes.number(), 3, f64::NAN);
        for (node, numbers) in lean.nodes_mut().enumerate().filter(|(node, _)| *node != 4) {
            numbers.iter_mut().enumerate().for_each(|(k, number)| *number = (node * node + k) as f64);
        }
        let rows = |x: f64| nodes.spot(DVec2::new(x, 1.5)).map(|spot| spot.rows()).expect("it is among the nodes");
        let all = lean.blend::<3>(&rows(1.3)).expect("all nodes are there");
        assert_eq!(lean.blend::<1>(&rows(1.3)), Some([all[0]]));
        assert!(all.as_flattened().iter().all(|number| number.is_finite()));
        // The node at (4, 0) is asked from beyond the third on.
        assert!(lean.blend::<1>(&rows(3.5)).is_some_and(|[quad]| quad.iter().all(|number| number.is_nan())));
        let few = SimdNodes::new(nodes.number() - 1, 3, 0.0);
        assert_eq!(few.blend::<3>(&rows(3.5)), None);
    }
}
