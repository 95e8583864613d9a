//! Where a face lies on its surface: its middle, its edge, and the axis of a sphere that suits both.

use super::conic::Conic;
use super::plane::plane;
use glam::DVec3;
use std::cell::OnceCell;

/// A face in centred and scaled coordinates, with coincident vertices welded.
pub(super) struct Face {
    pub points: Vec<DVec3>,
    pub triangles: Vec<[usize; 3]>,
    edge: OnceCell<Vec<usize>>,
}

impl Face {
    pub fn new(points: Vec<DVec3>, triangles: Vec<[usize; 3]>) -> Face {
        Face { points, triangles, edge: OnceCell::new() }
    }

    fn corners(&self) -> impl Iterator<Item = [DVec3; 3]> {
        self.triangles.iter().map(|t| t.map(|i| self.points.get(i).copied().unwrap_or_default()))
    }

    /// Middle of the triangles' area, of the points where there is none.
    pub fn middle(&self) -> DVec3 {
        let (mut sum, mut area) = (DVec3::ZERO, 0.0);
        for [a, b, c] in self.corners() {
            let size = (b - a).cross(c - a).length();
            sum += size * (a + b + c) / 3.0;
            area += size;
        }
        if area > 0.0 { sum / area } else { self.points.iter().sum::<DVec3>() / self.points.len().max(1) as f64 }
    }

    /// Mean normal of the triangles; None where they close around a volume or there are none.
    pub fn normal(&self) -> Option<DVec3> {
        let (mut sum, mut area) = (DVec3::ZERO, 0.0);
        for [a, b, c] in self.corners() {
            let cross = (b - a).cross(c - a);
            sum += cross;
            area += cross.length();
        }
        // A tenth: a sphere with a hole of 37° half angle, or triangles wound at random.
        (sum.length() > 0.1 * area).then(|| sum.normalize_or(DVec3::Z))
    }

    /// Indices of the points on edges that belong to one triangle only.
    pub fn edge(&self) -> &[usize] {
        self.edge.get_or_init(|| self.find_edge())
    }

    fn find_edge(&self) -> Vec<usize> {
        let sound = || self.triangles.iter().filter(|[a, b, c]| a != b && b != c && c != a);
        let edges = || sound().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)].map(|(p, q)| (p.min(q), p.max(q))));
        // Bucketed by the lower point; the few of a bucket are sorted by the higher.
        let mut ends = vec![0; self.points.len() + 1];
        edges().for_each(|(low, _)| ends[low + 1] += 1);
        (0..self.points.len()).for_each(|i| ends[i + 1] += ends[i]);
        let mut highs = vec![0; ends.last().copied().unwrap_or(0)];
        // Each bucket is filled from its start, which so becomes the next one's.
        for (low, high) in edges() {
            highs[ends[low]] = high;
            ends[low] += 1;
        }
        let mut on_edge = vec![false; self.points.len()];
        let mut from = 0;
        for (low, &to) in ends.iter().enumerate().take(self.points.len()) {
            highs[from..to].sort_unstable();
            for uses in highs[from..to].chunk_by(|p, q| p == q).filter(|uses| uses.len() == 1) {
                (on_edge[low], on_edge[uses[0]]) = (true, true);
            }
            from = to;
        }
        (0..self.points.len()).filter(|&i| on_edge[i]).collect()
    }

    /// The same sphere with its pole amid the face: under the middle of its edge where that lies in a plane (a revolved
    /// cap, however unevenly it is triangulated), else under the middle of its area, else (a whole ball) towards −z.
    pub fn seat(&self, sphere: Conic, tolerance: f64) -> Conic {
        let radius = 1.0 / sphere.c;
        let centre = sphere.vertex + radius * sphere.axis;
        let towards = self.middle() - centre;
        let edge: Vec<DVec3> = self.edge().iter().filter_map(|i| self.points.get(*i).copied()).collect();
        let flat = plane(&edge);
        let is_flat = edge.len() >= 3
            && flat.spread[1] > tolerance
            && edge.iter().all(|p| (*p - flat.vertex).dot(flat.axis).abs() <= tolerance);
        let out = if is_flat {
            let side = if towards.dot(flat.axis) < 0.0 { -1.0 } else { 1.0 };
            side * flat.axis
        } else if towards.length() > 1e-3 * radius.abs() {
            towards.normalize_or(DVec3::NEG_Z)
        } else {
            DVec3::NEG_Z
        };
        Conic { vertex: centre + radius.abs() * out, axis: -out, c: sphere.c.abs(), k: 0.0 }
    }
}
