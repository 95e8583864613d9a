//! Meshes of the implicit shapes: bodies of revolution from their profile, boxes, and planes. Normals are exact.

use super::implicit::Axis;
use crate::gltf::mesh::append;
use crate::gltf::primitive::FaceMesh;
use eyebox_scene::Mesh;
use glam::DVec3;

/// Around the axis of a body of revolution.
const AROUND: u32 = 192;
/// From pole to pole of a sphere, and around it: it is traced exactly, so the mesh need only show where it is.
const STACKS: u32 = 48;
const SLICES: u32 = 96;

/// A point of a profile and the normal there: (distance from the axis, along the axis).
type Profile = ([f64; 2], [f64; 2]);

fn at(turn: f64, [r, z]: [f64; 2]) -> DVec3 {
    let (sin, cos) = (turn * std::f64::consts::TAU).sin_cos();
    DVec3::new(r * cos, r * sin, z)
}

struct Builder {
    axis: Axis,
    mesh: Mesh,
}

impl Builder {
    /// Appends a face; more vertices than 32 bits can count never come out of here.
    fn add(&mut self, points: &[(DVec3, DVec3)], triangles: Vec<[u32; 3]>) {
        let turned = |v: DVec3| self.axis.turn(v).to_array().map(|x| x as f32);
        let face = FaceMesh {
            positions: points.iter().map(|&(p, _)| turned(p)).collect(),
            normals: points.iter().map(|&(_, n)| turned(n)).collect(),
            triangles,
            ..FaceMesh::default()
        };
        let _ = append(&mut self.mesh, face);
    }

    /// A face that turns a profile, given from −z to +z, once around. Ends on the axis are poles.
    fn revolve(&mut self, profile: &[Profile], around: u32) {
        let mut points: Vec<(DVec3, DVec3)> = Vec::new();
        let mut rings: Vec<(u32, bool)> = Vec::new();
        for &(point, normal) in profile {
            let pole = point[0] == 0.0 && normal[0] == 0.0;
            rings.push((points.len() as u32, pole));
            for i in 0..if pole { 1 } else { around } {
                let turn = f64::from(i) / f64::from(around);
                points.push((at(turn, point), at(turn, normal)));
            }
        }
        let mut triangles = Vec::new();
        for (pair, ends) in rings.windows(2).zip(profile.windows(2)) {
            let [(low, low_pole), (high, high_pole)] = [pair[0], pair[1]];
            for i in 0..around {
                let next = (i + 1) % around;
                let (a, b) = if low_pole { (low, low) } else { (low + i, low + next) };
                let (c, d) = if high_pole { (high, high) } else { (high + next, high + i) };
                // Where a ring has no radius, one of the two triangles has no area.
                if ends[0].0[0] > 0.0 {
                    triangles.push([a, b, c]);
                }
                if ends[1].0[0] > 0.0 {
                    triangles.push([a, c, d]);
                }
            }
        }
        self.add(&points, triangles);
    }

    /// A flat disc at `z`, seen from `side` (±1).
    fn disc(&mut self, radius: f64, z: f64, side: f64) {
        let normal = DVec3::new(0.0, 0.0, side);
        let mut points = vec![(DVec3::new(0.0, 0.0, z), normal)];
        points.extend((0..AROUND).map(|i| (at(f64::from(i) / f64::from(AROUND), [radius, z]), normal)));
        let triangle = |i: u32| {
            let (a, b) = (1 + i, 1 + (i + 1) % AROUND);
            if side > 0.0 { [0, a, b] } else { [0, b, a] }
        };
        self.add(&points, (0..AROUND).map(triangle).collect());
    }

    /// A flat quadrilateral, counter-clockwise.
    fn quad(&mut self, corners: [DVec3; 4]) {
        let normal = (corners[1] - corners[0]).cross(corners[3] - corners[0]).normalize_or_zero();
        self.add(&corners.map(|corner| (corner, normal)), vec![[0, 1, 2], [0, 2, 3]]);
    }
}

fn builder(name: &str, axis: Axis) -> Builder {
    Builder { axis, mesh: Mesh { name: name.to_owned(), ..Mesh::default() } }
}

/// The part of a sphere's profile between two angles from −z, in turns of π, about a centre on the axis.
fn arc(radius: f64, centre: f64, from: f64, to: f64, steps: u32) -> Vec<Profile> {
    let point = |i: u32| {
        let angle = std::f64::consts::PI * (from + (to - from) * f64::from(i) / f64::from(steps));
        let (sin, cos) = angle.sin_cos();
        let pole = from == 0.0 && i == 0 || to == 1.0 && i == steps;
        let sin = if pole { 0.0 } else { sin };
        ([radius * sin, centre - radius * cos], [sin, -cos])
    };
    (0..=steps).map(point).collect()
}

/// One face.
pub(super) fn sphere(name: &str, radius: f64) -> Mesh {
    let mut out = builder(name, Axis::Z);
    out.revolve(&arc(radius, 0.0, 0.0, 1.0, STACKS), SLICES);
    out.mesh
}

/// Six faces: −x, +x, −y, +y, −z, +z.
pub(super) fn cube(name: &str, size: f64) -> Mesh {
    let h = 0.5 * size;
    let mut out = builder(name, Axis::Z);
    for (u, v) in [
        (DVec3::Z, DVec3::Y),
        (DVec3::Y, DVec3::Z),
        (DVec3::X, DVec3::Z),
        (DVec3::Z, DVec3::X),
        (DVec3::Y, DVec3::X),
        (DVec3::X, DVec3::Y),
    ] {
        let normal = u.cross(v);
        out.quad([-u - v, u - v, u + v, v - u].map(|corner| h * (corner + normal)));
    }
    out.mesh
}

/// The cap at −axis, the side, the cap at +axis; a cap without radius is left out. A cone is one with `top` 0.
pub(super) fn frustum(name: &str, axis: Axis, height: f64, bottom: f64, top: f64) -> Mesh {
    let h = 0.5 * height;
    let mut out = builder(name, axis);
    if bottom > 0.0 {
        out.disc(bottom, -h, -1.0);
    }
    let slope = DVec3::new(height, bottom - top, 0.0).normalize_or(DVec3::X);
    let normal = [slope.x, slope.y];
    out.revolve(&[([bottom, -h], normal), ([top, h], normal)], AROUND);
    if top > 0.0 {
        out.disc(top, h, 1.0);
    }
    out.mesh
}

/// The hemisphere at −axis, the side, the hemisphere at +axis. `height` is the side's.
pub(super) fn capsule(name: &str, axis: Axis, height: f64, radius: f64) -> Mesh {
    let h = 0.5 * height;
    let mut out = builder(name, axis);
    out.revolve(&arc(radius, -h, 0.0, 0.5, STACKS / 2), AROUND);
    let normal = [1.0, 0.0];
    out.revolve(&[([radius, -h], normal), ([radius, h], normal)], AROUND);
    out.revolve(&arc(radius, h, 0.5, 1.0, STACKS / 2), AROUND);
    out.mesh
}

/// One face that looks along +axis. USD lays the width along x (z if the axis is x), the length along the other one.
pub(super) fn plane(name: &str, axis: Axis, width: f64, length: f64) -> Mesh {
    let (w, l) = (0.5 * width, 0.5 * length);
    let mut out = builder(name, Axis::Z);
    let (u, v) = match axis {
        Axis::Z => (w * DVec3::X, l * DVec3::Y),
        Axis::Y => (l * DVec3::Z, w * DVec3::X),
        Axis::X => (l * DVec3::Y, w * DVec3::Z),
    };
    out.quad([-u - v, u - v, u + v, v - u]);
    out.mesh
}
