//! Meshes of round faces, which say where faces end: rings of corners about the axis.

use super::Profile;
use crate::scene::{FaceRange, Mesh};
use glam::{DAffine3, DVec3};
use std::f64::consts::TAU;

/// Steps of the meshes, which say where faces end: outwards and around.
const RINGS: usize = 16;
const SECTORS: usize = 96;

/// Places all around a radius.
pub(super) fn around(radius: f64) -> impl Iterator<Item = [f64; 2]> {
    (0..SECTORS).map(move |sector| {
        let (sin, cos) = (TAU * sector as f64 / SECTORS as f64).sin_cos();
        [radius * cos, radius * sin]
    })
}

/// Whether a surface is there all around a radius.
pub(super) fn reaches(profile: &Profile, radius: f64) -> bool {
    around(radius).all(|[x, y]| profile.sag(x, y).is_some())
}

/// The largest radius below `most` at which something still holds, to a thousandth.
pub(super) fn shrunk(most: f64, holds: impl Fn(f64) -> bool) -> Option<f64> {
    (1..1000).rev().map(|k| most * f64::from(k) / 1000.0).find(|radius| holds(*radius))
}

/// A face of a surface between two radii; `side` 1: its outside is towards +z.
pub(super) fn cap(mesh: &mut Mesh, profile: &Profile, to_part: &DAffine3, [inner, outer]: [f64; 2], side: f64) {
    let (first, start) = (mesh.triangles.len() as u32, mesh.positions.len() as u32);
    let mut put = |x: f64, y: f64| {
        let z = profile.sag(x, y).unwrap_or(0.0);
        mesh.positions.push(to_part.transform_point3(DVec3::new(x, y, z)).as_vec3().to_array());
        let normal = to_part.transform_vector3(profile.normal(x, y, outer)) * side;
        mesh.normals.push(normal.as_vec3().to_array());
    };
    let whole = inner <= 0.0;
    if whole {
        put(0.0, 0.0);
    }
    let rings: Vec<f64> =
        (usize::from(whole)..=RINGS).map(|k| inner + (outer - inner) * k as f64 / RINGS as f64).collect();
    for radius in &rings {
        around(*radius).for_each(|[x, y]| put(x, y));
    }
    let ring = start + u32::from(whole);
    let at = |k: usize, sector: usize| ring + (k * SECTORS + sector % SECTORS) as u32;
    let mut triangles = Vec::new();
    for sector in 0..SECTORS {
        if whole {
            triangles.push([start, at(0, sector), at(0, sector + 1)]);
        }
        for k in 1..rings.len() {
            triangles.push([at(k - 1, sector), at(k, sector), at(k, sector + 1)]);
            triangles.push([at(k - 1, sector), at(k, sector + 1), at(k - 1, sector + 1)]);
        }
    }
    close(mesh, triangles, first, side);
}

/// What joins two faces at their rims.
pub(super) fn rim(mesh: &mut Mesh, ends: &[(&Profile, DAffine3); 2], radius: f64, side: f64) {
    let (first, start) = (mesh.triangles.len() as u32, mesh.positions.len() as u32);
    for sector in 0..SECTORS {
        let (sin, cos) = (TAU * sector as f64 / SECTORS as f64).sin_cos();
        for (profile, to_part) in ends {
            let z = profile.sag(radius * cos, radius * sin).unwrap_or(0.0);
            mesh.positions
                .push(to_part.transform_point3(DVec3::new(radius * cos, radius * sin, z)).as_vec3().to_array());
            mesh.normals.push(DVec3::new(cos, sin, 0.0).as_vec3().to_array());
        }
    }
    let at = |sector: usize, end: u32| start + 2 * (sector % SECTORS) as u32 + end;
    let quads = (0..SECTORS).flat_map(|s| [[at(s, 0), at(s + 1, 0), at(s + 1, 1)], [at(s, 0), at(s + 1, 1), at(s, 1)]]);
    close(mesh, quads.collect(), first, side);
}

fn close(mesh: &mut Mesh, triangles: Vec<[u32; 3]>, first: u32, side: f64) {
    let count = triangles.len() as u32;
    let turned = triangles.into_iter().map(|[a, b, c]| if side < 0.0 { [a, c, b] } else { [a, b, c] });
    mesh.triangles.extend(turned);
    mesh.faces.push(FaceRange { first, count });
}
