//! Lamps of simple shapes, in mm, as scenes of one part.

use eyebox::base::ids::{GroupId, MeshId};
use eyebox::scene::*;
use eyebox::world::lamp::{Lamp, Lamps};
use glam::{DAffine3, DVec3};
use std::f64::consts::TAU;

pub const MM: f64 = 1e-3;

pub fn eye(position: DVec3, look: DVec3, pupil_diameter_m: f64, fov_deg: f64) -> Eye {
    let focus_distance_m = f64::INFINITY;
    Eye {
        position,
        look,
        up: DVec3::Y,
        pupil_diameter_m,
        focus_distance_m,
        fov_deg,
        resolution: [1, 1],
        age: 30.0,
        adapts: false,
        limits: eyebox::scene::BinocularLimits::default(),
    }
}

/// A lamp from triangles in mm, counter-clockwise seen from where they shine to.
pub fn lamp(triangles: &[[DVec3; 3]], photometry: Photometry, angular: Angular) -> Lamp {
    let mesh = Mesh {
        name: "lamp".into(),
        positions: triangles.iter().flatten().map(|p| p.as_vec3().to_array()).collect(),
        triangles: (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
        faces: vec![FaceRange { first: 0, count: triangles.len() as u32 }],
        ..Mesh::default()
    };
    let emitter = Some(Emitter {
        group: GroupId(0),
        photometry,
        angular,
        spectrum: None,
        polarisation: None,
        both_sides: false,
        pattern: None,
    });
    let part = Part {
        name: "lamp".into(),
        path: "lamp".into(),
        mesh: MeshId(0),
        to_world: DAffine3::from_scale(DVec3::splat(MM)),
        medium: None,
        priority: 0,
        materials: Vec::new(),
 film_in: None,
        faces: vec![Face {
            finish: Finish::Absorber,
            coating: None,
            shape: Shape::Mesh,
            emitter,
            tint: None,
            slide: None,
            sensor: None,
        }],
    };
    let scene = Scene {
        name: "oracle".into(),
        unit_m: MM,
        wavelengths: Wavelengths::Visible,
        meshes: vec![mesh.into()],
        parts: vec![part],
        media: vec![],
        coatings: vec![],
        slides: vec![],
        surfaces: Vec::new(),
        scatters: vec![],
        wave_plates: vec![],
        gratings: vec![],
        profiles: Vec::new(),
        groups: vec![],
        lights: Vec::new(),
        sky: None,
        eye: eye(DVec3::ZERO, DVec3::Z, 0.004, 10.0),
        notes: vec![],
        hash: String::new(),
    };
    let lamps = Lamps::build(&scene, &|part| scene.parts[part].to_world).unwrap();
    lamps.all()[0].clone()
}

/// Triangles of a polygon, turned to shine towards `to`.
pub fn polygon(corners: &[DVec3], to: DVec3) -> Vec<[DVec3; 3]> {
    let towards = |[a, b, c]: [DVec3; 3]| {
        if (b - a).cross(c - a).dot(to - a) > 0.0 { [a, b, c] } else { [a, c, b] }
    };
    (2..corners.len()).map(|k| towards([corners[0], corners[k - 1], corners[k]])).collect()
}

/// A disk about (x, 0, d) with normal −z, of the area of the circle to 2e-6.
pub fn disk(radius: f64, d: f64, x: f64) -> Vec<[DVec3; 3]> {
    let sides = 2000;
    let rim = |k: usize| {
        let (sin, cos) = (TAU * k as f64 / sides as f64).sin_cos();
        DVec3::new(x + radius * cos, radius * sin, d)
    };
    (0..sides).map(|k| [DVec3::new(x, 0.0, d), rim(k + 1), rim(k)]).collect()
}

pub fn lambert(triangles: &[[DVec3; 3]], luminance: f64) -> Lamp {
    lamp(triangles, Photometry::LuminanceCdM2(luminance), Angular::Lambert)
}
