//! Meshes of the light shapes of USD that have no mesh of their own.

use super::{FaceRange, Mesh};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Corners of a round lamp's mesh.
const AROUND: u32 = 96;

/// The factor by which a regular polygon of [`AROUND`] corners must be larger than a circle to have its area.
fn swell() -> f64 {
    let step = TAU / f64::from(AROUND);
    (step / step.sin()).sqrt()
}

/// A mesh of one face from points with normals.
fn mesh(points: impl IntoIterator<Item = (DVec3, DVec3)>, triangles: Vec<[u32; 3]>) -> Mesh {
    let mut mesh = Mesh { faces: vec![FaceRange { first: 0, count: triangles.len() as u32 }], ..Mesh::default() };
    for (point, normal) in points {
        mesh.positions.push(point.as_vec3().to_array());
        mesh.normals.push(normal.as_vec3().to_array());
    }
    mesh.triangles = triangles;
    mesh
}

/// A rectangle in the plane z = 0 that faces −z, as UsdLux lights do.
pub fn rect(width: f64, height: f64) -> Mesh {
    let (x, y) = (width / 2.0, height / 2.0);
    let corners = [(-x, -y), (-x, y), (x, y), (x, -y)];
    mesh(corners.map(|(x, y)| (DVec3::new(x, y, 0.0), DVec3::NEG_Z)), vec![[0, 1, 2], [0, 2, 3]])
}

/// Direction in the xy-plane of corner `k`.
fn spoke(k: u32) -> DVec3 {
    let (sin, cos) = (TAU * f64::from(k % AROUND) / f64::from(AROUND)).sin_cos();
    DVec3::new(cos, sin, 0.0)
}

/// A disc that faces −z, of the area of the circle.
pub fn disk(radius: f64) -> Mesh {
    let rim = (0..AROUND).map(|k| (spoke(k) * radius * swell(), DVec3::NEG_Z));
    let triangles = (0..AROUND).map(|k| [0, 1 + (k + 1) % AROUND, 1 + k]).collect();
    mesh(std::iter::once((DVec3::ZERO, DVec3::NEG_Z)).chain(rim), triangles)
}

/// Along x, without caps.
pub fn cylinder(radius: f64, length: f64) -> Mesh {
    let step = TAU / f64::from(AROUND);
    // The perimeter of the polygon is that of the circle.
    let radius = radius * (step / 2.0) / (step / 2.0).sin();
    let ring = |x: f64| {
        (0..AROUND).map(move |k| {
            let normal = DVec3::new(0.0, spoke(k).x, spoke(k).y);
            (DVec3::X * x + normal * radius, normal)
        })
    };
    let quads = (0..AROUND).flat_map(|k| {
        let (a, b) = (k, (k + 1) % AROUND);
        [[a, b, b + AROUND], [a, b + AROUND, a + AROUND]]
    });
    mesh(ring(-length / 2.0).chain(ring(length / 2.0)), quads.collect())
}

/// A sphere, of the area of the true one.
pub fn sphere(radius: f64) -> Mesh {
    const RINGS: u32 = AROUND / 2;
    let at = |ring: u32, k: u32| {
        let (sin, cos) = (PI * f64::from(ring) / f64::from(RINGS)).sin_cos();
        spoke(k) * sin + DVec3::Z * cos
    };
    let normals: Vec<DVec3> = std::iter::once(DVec3::Z)
        .chain((1..RINGS).flat_map(|ring| (0..AROUND).map(move |k| (ring, k))).map(|(ring, k)| at(ring, k)))
        .chain(std::iter::once(DVec3::NEG_Z))
        .collect();
    let index = |ring: u32, k: u32| 1 + (ring - 1) * AROUND + k % AROUND;
    let last = normals.len() as u32 - 1;
    let mut triangles = Vec::new();
    for k in 0..AROUND {
        triangles.push([0, index(1, k), index(1, k + 1)]);
        for ring in 1..RINGS - 1 {
            let (a, b) = (index(ring, k), index(ring, k + 1));
            triangles.extend([[a, index(ring + 1, k), index(ring + 1, k + 1)], [a, index(ring + 1, k + 1), b]]);
        }
        triangles.push([last, index(RINGS - 1, k + 1), index(RINGS - 1, k)]);
    }
    // As large as the sphere: luminance times area is the flux.
    let area: f64 = triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|i| normals[i as usize]);
            (b - a).cross(c - a).length() / 2.0
        })
        .sum();
    let radius = radius * (4.0 * PI / area).sqrt();
    mesh(normals.iter().map(|normal| (*normal * radius, *normal)), triangles)
}
