//! Meshes of faces, which say where those end: rings of corners about the middle.

use super::{Outline, Profile};
use eyebox_scene::{FaceRange, Mesh};
use glam::{DAffine3, DVec3};
use std::f64::consts::TAU;

/// Steps of the meshes, which say where faces end: outwards and around.
const RINGS: usize = 16;
const SECTORS: usize = 96;
/// Those along a side of a rectangle, which has its corners at steps.
const SIDE: usize = SECTORS / 4;

impl Outline {
    /// Places all around, from +x towards +y.
    pub(super) fn around(self) -> impl Iterator<Item = [f64; 2]> {
        let Outline { centre, half, corners } = self;
        (0..SECTORS).map(move |sector| {
            let [x, y] = if corners {
                let from_corner = (sector + SIDE / 2) % SECTORS;
                let along = 2.0 * (from_corner % SIDE) as f64 / SIDE as f64 - 1.0;
                match from_corner / SIDE {
                    0 => [1.0, along],
                    1 => [-along, 1.0],
                    2 => [-1.0, -along],
                    _ => [along, -1.0],
                }
            } else {
                let (sin, cos) = (TAU * sector as f64 / SECTORS as f64).sin_cos();
                [cos, sin]
            };
            [centre[0] + half[0] * x, centre[1] + half[1] * y]
        })
    }

    /// The largest below it about the same middle for which something still holds, to a thousandth.
    pub(super) fn shrunk(self, holds: impl Fn(Outline) -> bool) -> Option<Outline> {
        (1..1000).rev().map(|k| self.scaled(f64::from(k) / 1000.0)).find(|outline| holds(*outline))
    }

    pub(super) fn scaled(self, factor: f64) -> Outline {
        Outline { half: self.half.map(|half| factor * half), ..self }
    }

    /// Whether a surface is there all around.
    pub(super) fn within(self, profile: &Profile) -> bool {
        self.around().all(|[x, y]| profile.sag(x, y).is_some())
    }
}

/// A face of a surface within an outline, without this share of it in the middle; `side` 1: its outside is towards +z.
pub(super) fn cap(mesh: &mut Mesh, profile: &Profile, to_part: &DAffine3, (outline, inner): (Outline, f64), side: f64) {
    let (first, start) = (mesh.triangles.len() as u32, mesh.positions.len() as u32);
    let scale = outline.half[0].max(outline.half[1]);
    let mut put = |x: f64, y: f64| {
        let z = profile.sag(x, y).unwrap_or(0.0);
        mesh.positions.push(to_part.transform_point3(DVec3::new(x, y, z)).as_vec3().to_array());
        let normal = to_part.transform_vector3(profile.normal(x, y, scale)) * side;
        mesh.normals.push(normal.as_vec3().to_array());
    };
    let whole = inner <= 0.0;
    if whole {
        put(outline.centre[0], outline.centre[1]);
    }
    let rings: Vec<f64> =
        (usize::from(whole)..=RINGS).map(|k| inner + (1.0 - inner) * k as f64 / RINGS as f64).collect();
    for part in &rings {
        outline.scaled(*part).around().for_each(|[x, y]| put(x, y));
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
pub(super) fn rim(mesh: &mut Mesh, ends: &[(&Profile, DAffine3, Outline); 2], side: f64) {
    let (first, start) = (mesh.triangles.len() as u32, mesh.positions.len() as u32);
    let places = ends.map(|(_, _, outline)| outline.around().collect::<Vec<_>>());
    let middle = ends[0].2.centre;
    for sector in 0..SECTORS {
        let out = DVec3::new(places[0][sector][0] - middle[0], places[0][sector][1] - middle[1], 0.0);
        for ((profile, to_part, _), places) in ends.iter().zip(&places) {
            let [x, y] = places[sector];
            let z = profile.sag(x, y).unwrap_or(0.0);
            mesh.positions.push(to_part.transform_point3(DVec3::new(x, y, z)).as_vec3().to_array());
            mesh.normals.push(out.normalize_or(DVec3::X).as_vec3().to_array());
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
