//! A torus by its two curvatures at a vertex, or a cylinder where the one along x is zero: distances, how they answer to
//! its parameters, and starts for the least squares.

use super::linalg::{self, Triangle, singular};
use super::plane::plane;
use super::pole::Face;
use super::refine::Model;
use glam::DVec3;

/// The circle of curvature `tube` in the plane of x and `axis` through `vertex`, turned about the line along x at the
/// distance 1/c from the vertex.
#[derive(Debug, Clone, Copy)]
pub(super) struct Torus {
    pub vertex: DVec3,
    pub axis: DVec3,
    pub x: DVec3,
    pub c: f64,
    pub tube: f64,
}

/// The freedoms, as columns of the Jacobian: along the axis, along x, turns of the axis towards x and y, a turn about the
/// axis, and the curvatures.
const RISE: usize = 0;
const SLIDE: usize = 1;
const TILT_X: usize = 2;
const TILT_Y: usize = 3;
const TWIST: usize = 4;
pub(super) const CURVE: usize = 5;
pub(super) const TUBE: usize = 6;

const CYLINDER: [bool; 8] = [true, false, true, true, true, true, false, false];
const TOROID: [bool; 8] = [true, true, true, true, true, true, true, false];

/// What moves.
pub(super) fn free(toroid: bool) -> &'static [bool; 8] {
    if toroid { &TOROID } else { &CYLINDER }
}

/// Signed distance of (y, z) from the circle of curvature c that touches z = 0 at the origin, positive towards +z: no
/// cancellation where the radius is long.
fn circle(c: f64, y: f64, z: f64) -> f64 {
    let square = y * y + z * z;
    (2.0 * z - c * square) / (1.0 + length(c, y, z))
}

/// Distance from the circle's centre over its radius.
fn length(c: f64, y: f64, z: f64) -> f64 {
    linalg::length(1.0 - c * z, c * y)
}

/// Derivatives of [`circle`] by y, z and c.
fn slopes(c: f64, y: f64, z: f64) -> [f64; 3] {
    let (l, square) = (length(c, y, z), y * y + z * z);
    let by_c = -square / (1.0 + l) - (2.0 * z - c * square) / ((1.0 + l) * (1.0 + l)) * (c * square - z) / l;
    [-c * y / l, (1.0 - c * z) / l, by_c]
}

impl Model for Torus {
    fn distance(&self, p: DVec3) -> f64 {
        let q = self.local(p);
        circle(self.tube, q.x, circle(self.c, q.y, q.z))
    }

    fn row(&self, p: DVec3) -> [f64; 8] {
        let q = self.local(p);
        let height = circle(self.c, q.y, q.z);
        let [ny, nz, by_c] = slopes(self.c, q.y, q.z);
        let [nx, share, by_tube] = slopes(self.tube, q.x, height);
        let (ny, nz) = (share * ny, share * nz);
        // A displacement V of the surface changes the distance by −n·V.
        [
            -nz,
            -nx,
            nz * q.x - nx * q.z,
            nz * q.y - ny * q.z,
            nx * q.y - ny * q.x,
            share * by_c,
            by_tube,
            circle(self.tube, q.x, height),
        ]
    }

    fn moved(&self, step: &[f64; 8]) -> Torus {
        let y = self.y();
        let axis = (self.axis + step[TILT_X] * self.x + step[TILT_Y] * y).normalize_or(self.axis);
        let x = self.x - step[TILT_X] * self.axis + step[TWIST] * y;
        Torus {
            vertex: self.vertex + step[RISE] * self.axis + step[SLIDE] * self.x,
            axis,
            x: (x - x.dot(axis) * axis).normalize_or(self.x),
            c: self.c + step[CURVE],
            tube: self.tube + step[TUBE],
        }
    }

    fn range(_: usize) -> f64 {
        1.0
    }
}

impl Torus {
    fn y(&self) -> DVec3 {
        self.axis.cross(self.x)
    }

    fn local(&self, p: DVec3) -> DVec3 {
        let q = p - self.vertex;
        DVec3::new(q.dot(self.x), q.dot(self.y()), q.dot(self.axis))
    }

    /// Positive on the vertex' side of the tube.
    fn side(&self, p: DVec3) -> f64 {
        let q = self.local(p);
        1.0 - self.tube * circle(self.c, q.y, q.z)
    }

    fn is_finite(&self) -> bool {
        self.vertex.is_finite() && self.axis.is_finite() && self.x.is_finite() && (self.c + self.tube).is_finite()
    }

    /// The same surface with its vertex on the side of `middle` and, for a cylinder, beside it, on the side of the tube
    /// where most of the points are, c ≥ 0.
    pub fn seated(self, middle: DVec3, points: &[DVec3]) -> Torus {
        let q = self.local(middle);
        let l = length(self.c, q.y, q.z);
        let mut out = self;
        // On the axis of revolution no side is nearer.
        if l > 1e-3 {
            let (sin, cos) = (self.c * q.y / l, (1.0 - self.c * q.z) / l);
            // A height above the vertex without cancellation, on either half of the circle.
            let (y, z) =
                (q.y / l, if cos > 0.0 { self.c * (q.y / l).powi(2) / (1.0 + cos) } else { (1.0 - cos) / self.c });
            out.vertex += y * self.y() + z * self.axis;
            out.axis = cos * self.axis - sin * self.y();
        }
        if self.tube == 0.0 {
            out.vertex += q.x * out.x;
        } else if points.iter().map(|p| self.side(*p)).sum::<f64>() < 0.0 {
            let across = 2.0 / self.tube;
            out.vertex += across * out.axis;
            out.c = 1.0 / (1.0 / self.c - across);
            out.tube = -self.tube;
        }
        if out.c < 0.0 {
            out = Torus { axis: -out.axis, c: -out.c, tube: -out.tube, ..out };
        }
        if out.is_finite() { out } else { self }
    }
}

/// Surfaces that are near to the points, to be refined.
pub(super) fn starts(face: &Face, points: &[DVec3], toroid: bool) -> Vec<Torus> {
    let mut all: Vec<Torus> = osculating(face, points, toroid).into_iter().flatten().collect();
    let patches = patches(face);
    all.extend(if toroid { by_lines(face, points, &patches) } else { by_normals(face, points, &patches) });
    all.retain(Torus::is_finite);
    all
}

/// By the principal curvatures of z = a + bx + cy + (ex² + 2fxy + gy²)/2 about the middle of the face, either of them
/// the one that is turned.
fn osculating(face: &Face, points: &[DVec3], toroid: bool) -> [Option<Torus>; 2] {
    let normal = face.normal().unwrap_or_else(|| plane(points).axis);
    let middle = face.middle();
    let (u, v) = normal.any_orthonormal_pair();
    let mut triangle = Triangle::<7>::new();
    for p in points {
        let q = *p - middle;
        let (x, y, z) = (q.dot(u), q.dot(v), q.dot(normal));
        triangle.add([1.0, x, y, 0.5 * x * x, x * y, 0.5 * y * y, z]);
    }
    let [a, b, c, e, f, g, _] = triangle.solve(0.0, &[true; 7]);
    let axis = (normal - b * u - c * v).normalize_or(normal);
    // Of the symmetric matrix (e f, f g).
    let (mean, half) = (0.5 * (e + g), (0.5 * (e - g)).hypot(f));
    let turn = 0.5 * f64::atan2(2.0 * f, e - g);
    let steep = (1.0 + b * b + c * c).powf(-1.5);
    let (sin, cos) = turn.sin_cos();
    let first = ((mean + half) * steep, cos * u + sin * v);
    let second = ((mean - half) * steep, cos * v - sin * u);
    let round = |turned: (f64, DVec3), other: (f64, DVec3)| {
        let x = (other.1 - other.1.dot(axis) * axis).try_normalize()?;
        let tube = if toroid { other.0 } else { 0.0 };
        Some(Torus { vertex: middle + a * normal, axis, x, c: turned.0, tube })
    };
    [round(first, second), round(second, first)]
}

/// Middles and area-weighted normals of the triangles, a part of very many.
fn patches(face: &Face) -> Vec<(DVec3, DVec3)> {
    let stride = face.triangles.len().div_ceil(1000).max(1);
    let corner = |i: usize| face.points.get(i).copied().unwrap_or_default();
    let patch = |t: &[usize; 3]| {
        let [a, b, c] = t.map(corner);
        ((a + b + c) / 3.0, (b - a).cross(c - a))
    };
    face.triangles.iter().step_by(stride).map(patch).collect()
}

/// A cylinder's normals are across its axis: the direction in which they spread least, and a circle in the projection.
fn by_normals(face: &Face, points: &[DVec3], patches: &[(DVec3, DVec3)]) -> Option<Torus> {
    let mut triangle = Triangle::<3>::new();
    patches.iter().for_each(|(_, n)| triangle.add(n.to_array()));
    let along = DVec3::from_array(singular(triangle.r)[2].1).try_normalize()?;
    let (u, v) = along.any_orthonormal_pair();
    let ([s, t], radius) = circle_through(points.iter().map(|p| [p.dot(u), p.dot(v)]))?;
    let foot = s * u + t * v;
    let middle = face.middle();
    let out = middle - foot - (middle - foot).dot(along) * along;
    let out = out.normalize_or(u);
    let vertex = foot + middle.dot(along) * along + radius * out;
    Some(Torus { vertex, axis: -out, x: along, c: 1.0 / radius, tube: 0.0 })
}

/// All normals of a surface of revolution meet its axis: a·(p × n) + m·n = 0 for the axis' direction a and moment m
/// (H. Pottmann and T. Randrup, Computing 60, 1998), linear in the six. Then a circle in the half plane of (along, away).
fn by_lines(face: &Face, points: &[DVec3], patches: &[(DVec3, DVec3)]) -> Option<Torus> {
    let solved = |held: usize| {
        let mut triangle = Triangle::<6>::new();
        for (p, n) in patches {
            let moment = p.cross(*n);
            let others = [0, 1, 2].map(|k| moment[(held + k) % 3]);
            triangle.add([others[1], others[2], n.x, n.y, n.z, -others[0]]);
        }
        let x = triangle.solve(0.0, &[true; 6]);
        let mut a = DVec3::ZERO;
        (a[held], a[(held + 1) % 3], a[(held + 2) % 3]) = (1.0, x[0], x[1]);
        let m = DVec3::new(x[2], x[3], x[4]) / a.length();
        let a = a.normalize_or_zero();
        let miss = |(p, n): &(DVec3, DVec3)| (a.dot(p.cross(*n)) + m.dot(*n)).powi(2);
        let misses: f64 = patches.iter().map(miss).sum();
        (misses / (1.0 + m.length_squared()), a, m - m.dot(a) * a)
    };
    let best = (0..3).map(solved).filter(|(miss, ..)| miss.is_finite()).min_by(|x, y| x.0.total_cmp(&y.0))?;
    let (_, a, m) = best;
    let on_axis = a.cross(m);
    let away = |p: DVec3| {
        let q = p - on_axis;
        let h = q.dot(a);
        (h, (q - h * a).length(), q - h * a)
    };
    let ([h, ring], tube) = circle_through(points.iter().map(|p| {
        let (h, rho, _) = away(*p);
        [h, rho]
    }))?;
    let centre = on_axis + h * a;
    let (_, _, out) = away(face.middle());
    let out = out.normalize_or(a.any_orthonormal_vector());
    let outer = points.iter().map(|p| away(*p).1 - ring).sum::<f64>() >= 0.0;
    let side = if outer { 1.0 } else { -1.0 };
    let radius = ring + side * tube;
    Some(Torus { vertex: centre + radius * out, axis: -out, x: a, c: 1.0 / radius, tube: side / tube })
}

/// The circle s² + t² + bs + ct + d = 0 that solves this best (I. Kåsa, IEEE Trans. Instrum. Meas. 25, 1976).
fn circle_through(points: impl Iterator<Item = [f64; 2]>) -> Option<([f64; 2], f64)> {
    let mut triangle = Triangle::<4>::new();
    points.for_each(|[s, t]| triangle.add([s, t, 1.0, -(s * s + t * t)]));
    let [b, c, d, _] = triangle.solve(0.0, &[true; 4]);
    let centre = [-0.5 * b, -0.5 * c];
    let radius = (0.25 * (b * b + c * c) - d).sqrt();
    (radius > 0.0 && radius.is_finite()).then_some((centre, radius))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tilted(c: f64, tube: f64) -> Torus {
        let axis = DVec3::new(0.2, 0.3, 0.9).normalize();
        let x = axis.cross(DVec3::new(0.1, 1.0, 0.0)).normalize();
        Torus { vertex: DVec3::new(0.3, -0.2, 0.1), axis, x, c, tube }
    }

    #[test]
    fn distances_are_those_of_the_textbook_torus() {
        for (radius, tube) in [(3.0, 0.7), (3.0, -0.7), (-2.0, 0.5), (2.0, 5.0)] {
            let torus = tilted(1.0 / radius, 1.0 / tube);
            for q in [DVec3::new(0.3, 0.2, 0.1), DVec3::new(-0.1, 0.4, -0.2)] {
                let p = torus.vertex + q.x * torus.x + q.y * torus.y() + q.z * torus.axis;
                // Signed by the side of the vertex, on which the point lies.
                let from_axis = q.y.hypot(radius - q.z) * radius.signum();
                let want = (tube.abs() - q.x.hypot(from_axis - (radius - tube))) * tube.signum();
                assert!((torus.distance(p) - want).abs() < 1e-14, "{radius} {tube}: {} {want}", torus.distance(p));
            }
        }
    }

    #[test]
    fn derivatives_are_differences() {
        for torus in [tilted(0.6, -0.9), tilted(0.6, 0.0), tilted(-0.3, 0.4)] {
            let p = torus.vertex + DVec3::new(0.5, 0.4, 0.35);
            let row = torus.row(p);
            for j in 0..7 {
                let h = 1e-6;
                let mut step = [0.0; 8];
                step[j] = h;
                let plus = torus.moved(&step).distance(p);
                step[j] = -h;
                let difference = (plus - torus.moved(&step).distance(p)) / (2.0 * h);
                assert!((row[j] - difference).abs() < 1e-9, "{j}: {} {difference}", row[j]);
            }
        }
    }

    #[test]
    fn seating_keeps_the_surface() {
        for torus in [tilted(0.6, -0.9), tilted(0.6, 0.0), tilted(-0.3, 2.0), tilted(0.8, 1.9)] {
            for middle in [DVec3::new(0.5, 0.4, 0.35), DVec3::new(-0.4, 1.4, 2.5), DVec3::new(3.0, -2.0, 0.1)] {
                let seated = torus.seated(middle, &[middle]);
                assert!(seated.c >= 0.0 && (seated.axis.length() - 1.0).abs() < 1e-12);
                for p in [middle, DVec3::new(0.2, 0.3, 0.1), DVec3::new(0.2, -0.3, -0.1)] {
                    assert!((seated.distance(p).abs() - torus.distance(p).abs()).abs() < 1e-12, "{torus:?} {seated:?}");
                }
                assert!(seated.local(middle).y.abs() < 1e-12);
            }
        }
    }
}
