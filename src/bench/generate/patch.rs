//! Curved faces as meshes with exact normals, and the exact surfaces that they are pieces of.

use crate::kit::Sheet;
use eyebox_scene::mesh::FaceRange;
use eyebox_scene::{Mesh, Shape};
use glam::{DAffine3, DVec2, DVec3};
use std::f64::consts::TAU;

/// One face of a mesh.
#[derive(Debug, Clone)]
pub struct Patch {
    corners: Vec<DVec3>,
    normals: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

/// Height over a point of the x–y plane, and its slopes along x and y.
pub type Height = (f64, DVec2);

impl Patch {
    /// A rectangle of the x–y plane about the origin, lifted to a height, facing +z.
    pub fn over(half: DVec2, [nx, ny]: [usize; 2], height: impl Fn(DVec2) -> Height) -> Patch {
        let at = |i: usize, n: usize, half: f64| half * (2.0 * i as f64 / n as f64 - 1.0);
        let points = (0..=ny).flat_map(|j| (0..=nx).map(move |i| DVec2::new(at(i, nx, half.x), at(j, ny, half.y))));
        let (corners, normals) = points
            .map(|p| {
                let (h, slope) = height(p);
                (p.extend(h), DVec3::new(-slope.x, -slope.y, 1.0).normalize())
            })
            .unzip();
        let vertex = |i: usize, j: usize| (j * (nx + 1) + i) as u32;
        let cells = (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j)));
        let triangles = cells.flat_map(|(i, j)| {
            let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
            [[a, b, c], [a, c, d]]
        });
        let triangles = triangles.collect();
        Patch { corners, normals, triangles }
    }

    /// A flat rectangle facing +z.
    pub fn flat(half: DVec2) -> Patch {
        Patch::over(half, [1, 1], |_| (0.0, DVec2::ZERO))
    }

    /// A flat polygon, counter-clockwise as seen from where it faces.
    pub fn polygon(corners: Vec<DVec3>) -> Patch {
        let triangles = (2..corners.len() as u32).map(|i| [0, i - 1, i]).collect();
        Patch::sheet((corners, triangles))
    }

    /// A flat sheet; the first three corners are not in line.
    pub fn sheet((corners, triangles): Sheet) -> Patch {
        let normal = match corners.as_slice() {
            [a, b, c, ..] => (*b - *a).cross(*c - *a).normalize_or(DVec3::Z),
            _ => DVec3::Z,
        };
        Patch { normals: vec![normal; corners.len()], corners, triangles }
    }

    /// A ring about z: a circle of radius `minor` around a circle of radius `major`.
    pub fn ring([major, minor]: [f64; 2], [along, around]: [usize; 2]) -> Patch {
        let turn = |i: usize, n: usize| DVec2::from_angle(TAU * (i % n) as f64 / n as f64);
        let points = (0..along).flat_map(|i| (0..around).map(move |j| (i, j)));
        let (corners, normals) = points
            .map(|(i, j)| {
                let (about, across) = (turn(i, along), turn(j, around));
                let normal = (about * across.x).extend(across.y);
                ((about * major).extend(0.0) + minor * normal, normal)
            })
            .unzip();
        let vertex = |i: usize, j: usize| (i % along * around + j % around) as u32;
        let cells = (0..along).flat_map(|i| (0..around).map(move |j| (i, j)));
        let triangles = cells.flat_map(|(i, j)| {
            let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
            [[a, b, c], [a, c, d]]
        });
        let triangles = triangles.collect();
        Patch { corners, normals, triangles }
    }

    /// The strip between two closed lines of as many points, which run counter-clockwise as seen from above; it faces
    /// outwards.
    pub fn wall(low: &[DVec3], high: &[DVec3]) -> Patch {
        let mut wall = Patch { corners: Vec::new(), normals: Vec::new(), triangles: Vec::new() };
        for (i, (a, b)) in low.iter().zip(high).enumerate() {
            let next = (i + 1) % low.len();
            wall.append(Patch::polygon(vec![*a, low[next], high[next], *b]));
        }
        wall
    }

    /// The corners around [`Patch::over`], counter-clockwise as seen from +z.
    pub fn edge(&self, [nx, ny]: [usize; 2]) -> Vec<DVec3> {
        let vertex = |i: usize, j: usize| self.corners[j * (nx + 1) + i];
        let (front, right) = ((0..nx).map(|i| vertex(i, 0)), (0..ny).map(|j| vertex(nx, j)));
        let (back, left) = ((1..=nx).rev().map(|i| vertex(i, ny)), (1..=ny).rev().map(|j| vertex(0, j)));
        front.chain(right).chain(back).chain(left).collect()
    }

    /// Facing the other way.
    pub fn flipped(mut self) -> Patch {
        self.normals.iter_mut().for_each(|normal| *normal = -*normal);
        self.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        self
    }

    /// Moved rigidly.
    pub fn moved(mut self, by: DAffine3) -> Patch {
        self.corners.iter_mut().for_each(|corner| *corner = by.transform_point3(*corner));
        self.normals.iter_mut().for_each(|normal| *normal = by.transform_vector3(*normal));
        self
    }

    /// Both as one face.
    pub fn append(&mut self, other: Patch) {
        let base = self.corners.len() as u32;
        self.corners.extend(other.corners);
        self.normals.extend(other.normals);
        self.triangles.extend(other.triangles.iter().map(|triangle| triangle.map(|vertex| vertex + base)));
    }

    /// A body between two of [`Patch::over`], both facing +z: its front, its back and the wall around.
    pub fn body(front: Patch, back: Patch, steps: [usize; 2]) -> Vec<Patch> {
        let wall = Patch::wall(&back.edge(steps), &front.edge(steps));
        vec![front, back.flipped(), wall]
    }

    /// A bar along y from −`half` to `half` over a polygon of x and z that is counter-clockwise with x to the right and z
    /// up: a face per side in the order of the corners, then the ends at −y and +y.
    pub fn bar(polygon: &[DVec2], half: f64) -> Vec<Patch> {
        let at = |p: DVec2, y: f64| DVec3::new(p.x, y, p.y);
        let sides = polygon.iter().enumerate().map(|(i, a)| {
            let b = polygon[(i + 1) % polygon.len()];
            Patch::polygon(vec![at(*a, -half), at(*a, half), at(b, half), at(b, -half)])
        });
        let low = Patch::polygon(polygon.iter().map(|p| at(*p, -half)).collect());
        let high = Patch::polygon(polygon.iter().rev().map(|p| at(*p, half)).collect());
        sides.chain([low, high]).collect()
    }
}

/// One mesh face per patch.
pub fn mesh(patches: &[Patch]) -> Mesh {
    let mut mesh = Mesh { name: "mesh".to_owned(), ..Mesh::default() };
    for patch in patches {
        let (base, first) = (mesh.positions.len() as u32, mesh.triangles.len() as u32);
        mesh.positions.extend(patch.corners.iter().map(|p| p.as_vec3().to_array()));
        mesh.normals.extend(patch.normals.iter().map(|n| n.as_vec3().to_array()));
        mesh.triangles.extend(patch.triangles.iter().map(|triangle| triangle.map(|vertex| vertex + base)));
        mesh.faces.push(FaceRange { first, count: patch.triangles.len() as u32 });
    }
    mesh
}

/// A conic with a polynomial, its vertex at the origin and its axis along z, as [`Shape::XyPoly`] has it.
#[derive(Debug, Clone)]
pub struct Freeform {
    pub radius: f64,
    pub conic: f64,
    pub coeffs: Vec<f64>,
}

impl Freeform {
    pub fn height(&self, p: DVec2) -> Height {
        let (c, r2) = (1.0 / self.radius, p.length_squared());
        let root = (1.0 - (1.0 + self.conic) * c * c * r2).sqrt();
        let (mut height, mut slope) = (c * r2 / (1.0 + root), p * (c / root));
        let powers = (0..).flat_map(|degree: i32| (0..=degree).map(move |j| (degree - j, j)));
        for (coeff, (i, j)) in self.coeffs.iter().zip(powers) {
            height += coeff * p.x.powi(i) * p.y.powi(j);
            slope.x += coeff * f64::from(i) * p.x.powi((i - 1).max(0)) * p.y.powi(j);
            slope.y += coeff * f64::from(j) * p.x.powi(i) * p.y.powi((j - 1).max(0));
        }
        (height, slope)
    }

    pub fn shape(&self) -> Shape {
        let Freeform { radius, conic, ref coeffs } = *self;
        let (vertex, axis) = (DVec3::ZERO, DVec3::Z);
        if coeffs.is_empty() {
            return Shape::Conic { vertex, axis, radius, conic };
        }
        Shape::XyPoly { vertex, axis, x: DVec3::X, radius, conic, coeffs: coeffs.clone() }
    }
}

/// A toroid, its vertex at the origin and its axis along z: curved along y with `radius`, along x with `tube_radius`, both
/// positive.
#[derive(Debug, Clone, Copy)]
pub struct Toroid {
    pub radius: f64,
    pub tube_radius: f64,
}

impl Toroid {
    /// The point (x, sag) of the circle in the plane of x and z is turned about the line along x at the height `radius`.
    pub fn height(&self, p: DVec2) -> Height {
        let root = (self.tube_radius.powi(2) - p.x * p.x).sqrt();
        let arm = self.radius - p.x * p.x / (self.tube_radius + root);
        let drop = (arm * arm - p.y * p.y).sqrt();
        (self.radius - drop, DVec2::new(arm * p.x / (root * drop), p.y / drop))
    }

    pub fn shape(&self, place: DAffine3) -> Shape {
        let [vertex, axis, x] =
            [place.translation, place.transform_vector3(DVec3::Z), place.transform_vector3(DVec3::X)];
        Shape::Toroid { vertex, axis, x, radius: self.radius, tube_radius: self.tube_radius }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Slopes against differences of heights, over steps whose third order is lost in the rounding.
    #[test]
    fn slopes_are_those_of_the_heights() {
        let freeform = Freeform { radius: 0.9, conic: -0.6, coeffs: vec![0.0, 0.0, 0.01, 0.2, 0.1, -0.3, 0.5, 0.4] };
        let toroid = Toroid { radius: 2.5, tube_radius: 1.5 };
        let surfaces: [&dyn Fn(DVec2) -> Height; 2] = [&|p| freeform.height(p), &|p| toroid.height(p)];
        for (surface, height) in surfaces.iter().enumerate() {
            for p in [DVec2::ZERO, DVec2::new(0.1, 0.05), DVec2::new(-0.07, 0.12)] {
                let along = |step: DVec2| (height(p + step).0 - height(p - step).0) / (2.0 * step.length());
                let by_steps = DVec2::new(along(DVec2::X * 1e-5), along(DVec2::Y * 1e-5));
                assert!((height(p).1 - by_steps).length() < 1e-9, "{surface}, {p}: {} and {by_steps}", height(p).1);
            }
        }
    }

    /// A bar is closed and right side out: by its volume.
    #[test]
    fn bars_and_bodies_hold_their_volume() {
        use eyebox_check::geometry::{edges, volume};
        let triangle = [DVec2::ZERO, DVec2::X, DVec2::Y];
        let bar = mesh(&Patch::bar(&triangle, 0.5));
        assert!((volume(&bar) - 0.5).abs() < 1e-6 && edges(&bar).open == 0, "{}", volume(&bar));
        let steps = [4, 3];
        let plane = |z: f64| Patch::over(DVec2::new(1.0, 0.5), steps, move |_| (z, DVec2::ZERO));
        let body = mesh(&Patch::body(plane(0.2), plane(0.0), steps));
        assert!((volume(&body) - 0.4).abs() < 1e-6 && edges(&body).open == 0, "{}", volume(&body));
        // A torus has 2π² R r²; one of facets a little less.
        let share = volume(&mesh(&[Patch::ring([0.2, 0.02], [96, 48])])) / (0.5 * TAU * TAU * 0.2 * 0.02 * 0.02);
        assert!((0.99..1.0).contains(&share), "{share}");
    }
}
