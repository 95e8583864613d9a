//! Scenes in other units, of other sizes, and far from the origin.

use super::{Case, contacts};
use crate::measure::How;
use crate::{closed, kit};
use eyebox_scene::{Scene, Shape};
use glam::{DAffine3, DVec3};

/// A tilted plate before a panel, its sides exact or triangles; and what the eye sees of the panel.
pub fn plate(degrees: f64, index: f64, exact: bool) -> (Scene, f64) {
    let mut s = kit::scene(0.01, 1);
    let half = DVec3::new(0.4, 0.4, 0.001);
    let to_world = DAffine3::from_translation(DVec3::NEG_Z * 0.5) * DAffine3::from_rotation_x(degrees.to_radians());
    let plane = |sign: f64| Shape::Plane { vertex: DVec3::Z * sign * half.z, axis: DVec3::Z * sign };
    let mut faces = vec![kit::polished(Shape::Mesh); 6];
    if exact {
        faces[4] = kit::polished(plane(-1.0));
        faces[5] = kit::polished(plane(1.0));
    }
    kit::add(&mut s, kit::mesh(&kit::cuboid(half)), to_world, Some(index), faces);
    behind(&mut s);
    (s, 1000.0 * closed::plates(&[1.0, index, 1.0], degrees.to_radians().sin()))
}

/// A panel of 1000 cd/m² behind the plates.
pub fn behind(s: &mut Scene) {
    kit::panel(s, 1000.0, kit::quad(DVec3::NEG_Z * 1.5, DVec3::X * 0.2, DVec3::Y * 0.2));
}

/// A ball of glass in a uniform sky, which can't be seen.
pub fn ball() -> (Scene, f64) {
    let mut s = kit::scene(20.0, 8);
    kit::sky(&mut s, 16, 8, vec![500.0; 128]);
    let at = DAffine3::from_translation(DVec3::NEG_Z * 0.05);
    kit::add(&mut s, kit::sphere(0.01, 24, 48), at, Some(1.5), vec![kit::polished(kit::ball(0.01))]);
    (s, 500.0)
}

/// The scene with mesh coordinates `mesh` times as large in units as much smaller, and all of it `world` times as large.
fn scaled(mut s: Scene, mesh: f64, world: f64) -> Scene {
    for m in &mut s.meshes {
        m.positions.iter_mut().flatten().for_each(|x| *x = (f64::from(*x) * mesh) as f32);
    }
    for part in &mut s.parts {
        part.to_world = DAffine3::from_scale(DVec3::splat(world)) * part.to_world;
        part.to_world *= DAffine3::from_scale(DVec3::splat(1.0 / mesh));
        for face in &mut part.faces {
            match &mut face.shape {
                Shape::Plane { vertex, .. } => *vertex *= mesh,
                Shape::Sphere { vertex, radius, .. } => {
                    *vertex *= mesh;
                    *radius *= mesh;
                }
                Shape::Mesh
                | Shape::Conic { .. }
                | Shape::Asphere { .. }
                | Shape::Cylinder { .. }
                | Shape::Toroid { .. }
                | Shape::XyPoly { .. }
                | Shape::Zernike { .. }
                | Shape::Bspline { .. } => {}
            }
        }
    }
    s.eye.position *= world;
    s.eye.pupil_diameter_m *= world;
    s
}

/// Coordinates from 1e-6 to 1e6.
pub fn scales() -> Vec<Case> {
    let mut cases = Vec::new();
    for factor in [1e-6, 1e-3, 1.0, 1e3, 1e6] {
        for (what, mesh, world) in [("coordinates", factor, 1.0), ("the world", 1.0, factor)] {
            for exact in [false, true] {
                let (s, want) = plate(45.0, 1.5, exact);
                let name = format!("plate at 45°, {what} × {factor:e}{}", if exact { ", exact" } else { "" });
                cases.push(Case::new(name, scaled(s, mesh, world), How::backward(400).polarised(), want));
            }
            let (s, want) = ball();
            let name = format!("ball in a uniform sky, {what} × {factor:e}");
            cases.push(Case::new(name, scaled(s, mesh, world), How::backward(32), want));
            let (s, want) = contacts::stack(1e-9 * world.min(1.0), 45.0);
            let name = format!("plates that touch, {what} × {factor:e}");
            cases.push(Case {
                noise: 5e-3,
                ..Case::new(name, scaled(s, mesh, world), How::backward(800).polarised(), want)
            });
        }
    }
    cases
}

/// Up to 1e8 scene sizes from the origin.
pub fn offsets() -> Vec<Case> {
    const SIZE: f64 = 1.5;
    let mut cases = Vec::new();
    for sizes in [1.0, 1e4, 1e8] {
        let by = DVec3::new(1.0, -0.7, 0.3) * sizes * SIZE;
        let moved = |mut s: Scene| {
            s.parts.iter_mut().for_each(|part| part.to_world.translation += by);
            s.eye.position += by;
            s
        };
        let (s, want) = plate(45.0, 1.5, true);
        cases.push(Case::new(
            format!("plate at 45°, {sizes:e} sizes away"),
            moved(s),
            How::backward(400).polarised(),
            want,
        ));
        let (s, want) = ball();
        cases.push(Case::new(
            format!("ball in a uniform sky, {sizes:e} sizes away"),
            moved(s),
            How::backward(32),
            want,
        ));
        let (s, want) = contacts::stack(0.0, 45.0);
        let name = format!("plates that touch, {sizes:e} sizes away");
        cases.push(Case { noise: 5e-3, ..Case::new(name, moved(s), How::backward(800).polarised(), want) });
    }
    cases
}
