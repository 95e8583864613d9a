//! Algebraic starts for the least squares: spheres and quadrics of revolution that nearly pass through the points.

use super::conic::Conic;
use super::linalg::Triangle;
use glam::DVec3;

/// How the free factor of an implicit equation is spent: on the slope along a normal of the face (right for caps and
/// for planes), or on the squared terms (right for closed surfaces).
#[derive(Clone, Copy)]
pub(super) enum Norm {
    Slope(DVec3),
    Squares,
}

/// α|p|² + β(a·p)² + b·p + d = 0 for a given axis a: every quadric of revolution about any line parallel to a.
struct Quadric {
    axis: DVec3,
    alpha: f64,
    beta: f64,
    b: DVec3,
    d: f64,
    left: f64,
}

/// The ten monomials of all points, rotated into a triangle once; each axis is then tried on ten rows.
pub(super) struct Monomials(Triangle<10>);

impl Monomials {
    pub fn new(points: &[DVec3]) -> Self {
        let mut triangle = Triangle::new();
        for p in points {
            let DVec3 { x, y, z } = *p;
            triangle.add([x * x, y * y, z * z, x * y, x * z, y * z, x, y, z, 1.0]);
        }
        Monomials(triangle)
    }

    /// Ten rows `[α, β, three of b and d but for the normalised one, right-hand side]` and how the β column turns with
    /// the axis.
    fn rows(&self, axis: DVec3, norm: Norm) -> impl Iterator<Item = ([f64; 6], DVec3)> {
        let (m, t1, t2) = norm.frame();
        self.0.r.iter().map(move |row| {
            let square = row[0] + row[1] + row[2];
            // This row's Σ (a·p)², by its gradient in a.
            let [xx, yy, zz, xy, xz, yz] = [row[0], row[1], row[2], row[3], row[4], row[5]];
            let gradient = 2.0
                * DVec3::new(
                    xx * axis.x + xy * axis.y + xz * axis.z,
                    xy * axis.x + yy * axis.y + yz * axis.z,
                    xz * axis.x + yz * axis.y + zz * axis.z,
                );
            let along = 0.5 * gradient.dot(axis);
            let linear = DVec3::new(row[6], row[7], row[8]);
            let (slope, s1, s2) = (linear.dot(m), linear.dot(t1), linear.dot(t2));
            let entries = match norm {
                Norm::Slope(_) => [square, along, s1, s2, row[9], -slope],
                Norm::Squares => [slope, along, s1, s2, row[9], -square],
            };
            (entries, gradient)
        })
    }

    fn quadric(&self, axis: DVec3, norm: Norm, revolve: bool) -> Quadric {
        let mut triangle = Triangle::<6>::new();
        self.rows(axis, norm).for_each(|(row, _)| triangle.add(row));
        let x = triangle.solve(0.0, &[true, revolve, true, true, true, true]);
        // What the solution leaves, found with it so that the held column counts.
        let left = (0..6)
            .map(|i| triangle.r[i][5] - (0..5).map(|j| triangle.r[i][j] * x[j]).sum::<f64>())
            .fold(0.0f64, |sum, e| sum.hypot(e));
        let (m, t1, t2) = norm.frame();
        let (alpha, slope) = match norm {
            Norm::Slope(_) => (x[0], 1.0),
            Norm::Squares => (1.0, x[0]),
        };
        Quadric { axis, alpha, beta: x[1], b: slope * m + x[2] * t1 + x[3] * t2, d: x[4], left }
    }

    /// The sphere that solves the implicit equation best, with its pole towards the origin (the middle of the points).
    pub fn sphere(&self, norm: Norm) -> Option<Conic> {
        let Quadric { alpha, b, d, .. } = self.quadric(DVec3::Z, norm, false);
        let slope = (b.length_squared() - 4.0 * alpha * d).sqrt(); // gradient on the sphere; NaN where there is none
        let out = b.normalize_or(DVec3::Z);
        let t = -2.0 * d / (b.length() + slope);
        let conic = Conic { vertex: t * out, axis: -out, c: 2.0 * alpha / slope, k: 0.0 };
        (conic.vertex.is_finite() && conic.c.is_finite()).then_some(conic)
    }

    /// Conics about the axes for which the implicit equation is solved best, the best first: a scan of the half sphere
    /// of directions, then a descent from the few best that lie apart.
    pub fn conics(&self, norm: Norm) -> Vec<Conic> {
        const DIRECTIONS: usize = 600;
        const KEPT: usize = 3;
        let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
        let mut scan: Vec<Quadric> = (0..DIRECTIONS)
            .map(|i| {
                let z = (i as f64 + 0.5) / DIRECTIONS as f64;
                let (sin, cos) = (golden * i as f64).sin_cos();
                let rho = (1.0 - z * z).sqrt();
                self.quadric(DVec3::new(rho * cos, rho * sin, z), norm, true)
            })
            .filter(|q| q.left.is_finite())
            .collect();
        scan.sort_by(|x, y| x.left.total_cmp(&y.left));
        let mut kept: Vec<Quadric> = Vec::new();
        for quadric in scan {
            if kept.len() < KEPT && kept.iter().all(|k| k.axis.dot(quadric.axis).abs() < 0.95) {
                kept.push(quadric);
            }
        }
        let mut best: Vec<Quadric> = kept.into_iter().map(|q| self.search(q, norm)).collect();
        best.sort_by(|x, y| x.left.total_cmp(&y.left));
        best.iter().filter_map(Quadric::conic).collect()
    }

    /// Gauss–Newton over the axis together with the five linear unknowns, which are solved anew for each axis (variable
    /// projection): the valleys are too narrow and oblique for a search by directions.
    fn search(&self, mut best: Quadric, norm: Norm) -> Quadric {
        for _ in 0..60 {
            let (u, v) = best.axis.any_orthonormal_pair();
            let (m, t1, t2) = norm.frame();
            let factor = match norm {
                Norm::Slope(_) => best.alpha,
                Norm::Squares => best.b.dot(m),
            };
            let x = [factor, best.beta, best.b.dot(t1), best.b.dot(t2), best.d];
            let mut triangle = Triangle::<8>::new();
            for (row, gradient) in self.rows(best.axis, norm) {
                let misses = row[5] - (0..5).map(|j| row[j] * x[j]).sum::<f64>();
                let (du, dv) = (best.beta * gradient.dot(u), best.beta * gradient.dot(v));
                triangle.add([row[0], row[1], row[2], row[3], row[4], du, dv, misses]);
            }
            let step = triangle.solve(0.0, &[true; 8]);
            let turn = step[5] * u + step[6] * v;
            let turn = turn.clamp_length_max(0.5);
            let next = (0..12)
                .map(|halvings| {
                    self.quadric((best.axis + turn * 0.5f64.powi(halvings)).normalize_or(best.axis), norm, true)
                })
                .find(|next| next.left < best.left);
            match next {
                Some(next) => {
                    let done = next.left > best.left * (1.0 - 1e-6);
                    best = next;
                    if done {
                        break;
                    }
                }
                None => break,
            }
        }
        best
    }
}

impl Norm {
    /// The direction whose slope is normalised (any, if none is) and two across it.
    fn frame(self) -> (DVec3, DVec3, DVec3) {
        let m = match self {
            Norm::Slope(m) => m,
            Norm::Squares => DVec3::Z,
        };
        let (t1, t2) = m.any_orthonormal_pair();
        (m, t1, t2)
    }
}

impl Quadric {
    /// The conic of the sheet on which the points (around the origin) lie. None for one-sheeted hyperboloids, cylinders
    /// and cones, which have no vertex.
    fn conic(&self) -> Option<Conic> {
        let Quadric { axis, alpha, beta, b, d, .. } = *self;
        let b_along = b.dot(axis);
        let aside = -(b - b_along * axis) / (2.0 * alpha);
        // On the axis: (α+β)t² + b_along·t + d' = 0; the root nearer to the points is the vertex of their sheet.
        let square = alpha + beta;
        let d = d - alpha * aside.length_squared();
        let root = (b_along * b_along - 4.0 * square * d).sqrt();
        let q = -0.5 * (b_along + b_along.signum() * root);
        let (near, far) = (d / q, q / square);
        let t = if near.abs() <= far.abs() || !far.is_finite() { near } else { far };
        let slope = b_along + 2.0 * square * t;
        let conic = Conic { vertex: aside + t * axis, axis, c: -2.0 * alpha / slope, k: beta / alpha };
        (conic.vertex.is_finite() && conic.c.is_finite() && conic.k.is_finite()).then_some(conic)
    }
}
